//! Nodes that send without end: the bus stays usable for all others.
//!
//! Verifies: ECSS 5.3.3.1b

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::redundancy::BabblingStep;
use ecss_can::runner::SlaveHandle;
use ecss_can::types::{Address, Bus, Duration, NmtState, NodeId};
use ecss_can_worlds::log::NodeEvent;
use mission::{MissionObjects, STANDARD};

use crate::support::*;

/// Rate above the capacity of a bus.
const ANY: Rate = Rate::new(u16::MAX, u16::MAX);
/// Slaves without a budget.
const NO_BUDGET: Profile =
    Profile { budget: BudgetPolicy { cob_id: ANY, slave: ANY, ..STANDARD.budget }, ..STANDARD };
/// A profile in which no slave has a budget and the master does not react.
const NOTHING: Profile = Profile { budget: BudgetPolicy { heard: ANY, ..NO_BUDGET.budget }, ..STANDARD };

/// Makes a busy system of three slaves.
fn busy(profile: Profile) -> MissionWorld {
    let mut world = MissionWorld::busy(profile, 3, |world| world);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    world
}

/// Lets the application of slave 2 send telemetry every 50 us for two seconds.
fn babble(world: &mut MissionWorld) -> Time {
    let from = world.now();
    let _babbling = world.on_slave(TWO, |slave| async move {
        let start = slave.now();
        for nth in 0_u64..40_000 {
            slave.wait_until(start + Duration::from_micros(50 * nth)).await;
            slave.send(MissionObjects::TELEMETRY_PDO);
        }
    });
    world.run_for(ms(2_000));
    from
}

/// Returns the share of the time since `from` that frames with this identifier took on either bus, percent.
fn load(world: &MissionWorld, id: u16, from: Time) -> u64 {
    let sent = Bus::ALL.into_iter().flat_map(|bus| since(world, bus, id, from));
    let taken: u64 = sent.map(|sent| sent.end.since(sent.start).as_us()).sum();
    taken * 100 / world.now().since(from).as_us()
}

/// Returns the number of answers of a slave to the master since `from`.
fn answers(world: &MissionWorld, node: NodeId, from: Time) -> usize {
    since(world, Bus::Nominal, 0x380 + u16::from(node.get()), from).len()
}

/// Given an application that sends without end, when its node has a budget, then other nodes command, answer and are
/// heard as before. Without a budget, its frames block all frames with lower priority, including heartbeats.
///
/// Verifies: ECSS 6.4a.2
#[test]
fn a_babbling_application_leaves_the_bus_to_others() {
    let mut world = busy(NOTHING);
    let from = babble(&mut world);
    assert!(load(&world, 0x382, from) >= 80, "{} %", load(&world, 0x382, from));
    assert!(executed_since(&world, THREE, from) <= 12 && answers(&world, THREE, from) <= 4, "of twenty");
    assert!(switches(&world, from) > 0 && !world.all_operational());

    let mut world = busy(STANDARD);
    let from = babble(&mut world);
    assert!((5..=10).contains(&load(&world, 0x382, from)), "{} %", load(&world, 0x382, from));
    for node in [THREE, FOUR] {
        assert!((19..=21).contains(&executed_since(&world, node, from)), "{node:?}");
        assert!((19..=21).contains(&answers(&world, node, from)), "{node:?}");
        assert!(since(&world, Bus::Nominal, 0x700 + u16::from(node.get()), from).len() >= 19);
    }
    assert!(executed_since(&world, TWO, from) >= 19, "its own commands");
    assert_eq!((switches(&world, from), world.all_operational()), (0, true));
    // One report: there was no second without a refusal.
    let reports = |world: &MissionWorld| {
        let all = since(world, Bus::Nominal, 0x082, from).into_iter();
        let all = all.map(|sent| sent.frame.payload().to_vec());
        all.filter(|data| data[..2] == [0x00, 0x81] || data[3..5] == [0x00, 0x81]).collect::<Vec<_>>()
    };
    let report = [0x00, 0x81, 0x11, 0x17, 0x82, 0x03, 0, 0];
    assert_eq!(reports(&world), [report]);
    assert_eq!(told(&world, TWO, from, |event| matches!(event, SlaveEvent::OverBudget { .. })).len(), 1);
    let over = world.slave(TWO, |slave| slave.objects().extension.over_budget);
    assert_eq!((over.last, over.silenced), (0x382, 0));
    // All attempts of the application: sent, or counted.
    let sent = answers(&world, TWO, from) as u32;
    let asked = since(&world, Bus::Nominal, 0x402, from).len() as u32;
    let queue_full = u32::from(world.status(TWO).counters.nominal.queue_full);
    let all = over.refused + sent + queue_full;
    assert!((40_000..=40_000 + asked).contains(&all), "{} + {sent} + {queue_full}", over.refused);
    world.run_for(ms(1_100));
    let end = [0x00, 0x00, 0x00, 0x00, 0x81, 0x17, 0x00, 0x00];
    assert_eq!(reports(&world), [report, end]);
}

/// Given a slave with four transmit PDOs that a client gave an event timer of 1 ms, then it silences itself, boots up with the
/// timers of power-on, and the master starts it. No other node is touched.
///
/// Verifies: ECSS 6.5.3a
#[test]
fn a_slave_that_was_configured_to_babble_comes_back_without() {
    let mut world = busy(STANDARD);
    let from = world.now();
    for nth in 4_u16..8 {
        let id = 0x4000_01C2 + 0x100 * u32::from(nth - 4);
        let object = |index, sub| Address::new(index + nth, sub);
        world.write(TWO, object(0x1800, 2), &[254]);
        world.write(TWO, object(0x1800, 5), &[1, 0]);
        world.write(TWO, object(0x1A00, 1), &0x1001_0008_u32.to_le_bytes());
        world.write(TWO, object(0x1A00, 0), &[1]);
        world.write(TWO, object(0x1800, 1), &id.to_le_bytes());
    }
    world.run_for(ms(1_000));
    assert_eq!(world.state(TWO), Some(NmtState::PreOperational));
    let silent = told_once(&world, TWO, from, entered(NmtState::PreOperational));
    assert!(silent.since(from) <= ms(200), "{silent:?}");
    for id in [0x1C2, 0x2C2, 0x3C2, 0x4C2] {
        let sent = since(&world, Bus::Nominal, id, from);
        assert!((60..=200).contains(&sent.len()), "{id:03X}h: {}", sent.len());
        // The lifetime of queued frames is at most 100 ms.
        assert!(since(&world, Bus::Nominal, id, silent + ms(100)).is_empty());
    }
    world.run_for(ms(5_000));
    let boot_ups = since(&world, Bus::Nominal, 0x702, silent);
    let boot_ups: Vec<_> = boot_ups.iter().filter(|sent| sent.frame.payload() == [0]).collect();
    assert_eq!(boot_ups.len(), 1);
    let silence = boot_ups[0].end.since(silent).as_us();
    assert!((4_999_000..=5_001_000).contains(&silence), "{silence} us");
    assert!(world.all_operational());
    let back = world.now();
    world.run_for(ms(1_000));
    assert!(since(&world, Bus::Nominal, 0x1C2, back).is_empty());
    assert!(answers(&world, TWO, back) >= 9);
    for node in [THREE, FOUR] {
        assert_eq!(told(&world, node, from, |event| matches!(event, SlaveEvent::State(_))), [], "{node:?}");
        assert!(executed_since(&world, node, from) >= 69);
    }
    assert_eq!(switches(&world, from), 0);
}

/// Returns the reactions of the master to babbling slaves, and their times after `from`, in milliseconds.
fn steps(world: &MissionWorld, from: Time) -> Vec<(u64, NodeId, BabblingStep)> {
    let log = world.log_of(MASTER).into_iter().filter(|(at, _)| *at >= from);
    log.filter_map(|(at, what)| match what {
        NodeEvent::Master(MasterEvent::Babbling { node, step }) => {
            Some((at.since(from).as_us() / 1_000, node, step))
        }
        _ => None,
    })
    .collect()
}

/// Asserts that no other slave changed its state.
fn assert_others_untouched(world: &MissionWorld, others: &[NodeId], from: Time) {
    for node in others {
        assert_eq!(told(world, *node, from, |event| matches!(event, SlaveEvent::State(_))), [], "{node:?}");
    }
}

/// Given a slave without a budget whose application babbles, then the master stops it, and starts it after a quiet
/// period.
///
/// Verifies: ECSS 6.5.1a.2
#[test]
fn the_master_stops_a_babbling_slave() {
    let mut world = busy(NO_BUDGET);
    let from = babble(&mut world);
    let all = steps(&world, from);
    assert_eq!(
        all.iter().map(|(_, node, step)| (*node, *step)).collect::<Vec<_>>(),
        [(TWO, BabblingStep::Stopped)]
    );
    assert!(all[0].0 <= 200, "{} ms", all[0].0);
    assert_eq!(world.state(TWO), Some(NmtState::Stopped));
    for node in [THREE, FOUR] {
        assert!(
            (19..=21).contains(&executed_since(&world, node, from)),
            "{node:?}: {}",
            executed_since(&world, node, from)
        );
        assert!(
            (18..=21).contains(&answers(&world, node, from)),
            "{node:?}: {}",
            answers(&world, node, from)
        );
    }
    world.run_for(ms(9_000));
    assert!(world.all_operational());
    assert_eq!(
        steps(&world, from)[1..].iter().map(|(_, node, step)| (*node, *step)).collect::<Vec<_>>(),
        [(TWO, BabblingStep::Quiet)]
    );
    assert_eq!(switches(&world, from), 0);
    assert_others_untouched(&world, &[THREE, FOUR], from);
}

/// Given a controller that keeps sending heartbeats of slave 4 and obeys no command, then the master commands that
/// slave to stop, resets it and leaves the bus, each once. The slave is started there 10 s after the change of the bus.
/// One that babbles on both buses moves the master once.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn the_master_leaves_a_babbling_controller_behind() {
    for both in [false, true] {
        let mut world = busy(STANDARD);
        let (from, four) = (world.now(), world.index(FOUR));
        for bus in [Bus::Nominal, Bus::Redundant] {
            if both || bus == Bus::Nominal {
                world.strike(bus, Fault::Babble(four, standard(0x704, &[5])));
            }
        }
        world.run_for(ms(2_000));
        let all = steps(&world, from);
        let done: Vec<_> = all.iter().map(|(_, node, step)| (*node, *step)).collect();
        let expected = [BabblingStep::Stopped, BabblingStep::Reset, BabblingStep::BusLeft];
        assert_eq!(done, expected.map(|step| (FOUR, step)), "{both}");
        assert!(all[2].0 <= 1_500, "{} ms", all[2].0);
        assert_eq!((world.master_bus(), switches(&world, from)), (Bus::Redundant, 1));
        world.run_for(ms(11_000));
        assert_eq!((world.master_bus(), switches(&world, from)), (Bus::Redundant, 1));
        assert_others_untouched(&world, &[TWO, THREE], from);
        for node in [TWO, THREE] {
            let executed = executed_since(&world, node, from);
            assert!((126..=131).contains(&executed), "{node:?}: {executed} of 130");
        }
        assert_eq!(world.all_operational(), !both);
    }
}
