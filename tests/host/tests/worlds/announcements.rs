//! Fifteen slaves announce four errors and eight values each after a change of the bus, while commands are sent.

use can_twin::wire::time::Time;
use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::pdo::Tpdo;
use ecss_can::prelude::*;
use ecss_can::runner::extend::WholeNode;
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::{MockBoard, NEXT_TO_MASTER_M, Plain, World, idle, plain_master};

/// Node-IDs 2 to 16.
const SLAVES: u8 = 15;
const STATES: usize = 8;
const ERRORS: u8 = 4;
const STRIKE: Time = Time::from_ms(1_500);

const STATE_PDOS: [Tpdo; STATES] = {
    let mut all =
        [Pdo::<()>::new(CobIdOf::node(0x280)).map(Instrument::STATES.sub(1)).transmit(1).state(); STATES];
    let mut nth = 0;
    while nth < STATES {
        let pdo = Pdo::<()>::new(CobIdOf::node(0x280 + 16 * nth as u16));
        all[nth] = pdo.map(Instrument::STATES.sub(nth as u8 + 1)).transmit(nth as u16 + 1).state();
        nth += 1;
    }
    all
};

#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
struct Instrument {
    /// States
    #[object(0x6000, array, ro, pdo)]
    states: [u8; STATES],
    /// Command
    #[object(0x6100, rww, pdo)]
    command: u16,
}

impl Device for Instrument {
    type Pdos = PdoObjects<1, STATES>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet =
        PdoSet::new(&[Pdo::<()>::new(CobIdOf::node(0x200)).map(Instrument::COMMAND).receive(1)], &STATE_PDOS);
}

type TestSlave = Slave<Instrument>;

fn nodes() -> impl Iterator<Item = NodeId> {
    (2..2 + SLAVES).map(|raw| NodeId::new(raw).expect("a Node-ID"))
}

/// Makes a world in which all nodes are Operational.
fn world() -> World {
    let mut world = World::builder().master(|_| plain_master(&Profile::DEFAULT), idle);
    for node in nodes() {
        let slave = |board: MockBoard| {
            let device = Instrument { states: [0; STATES], command: 0 };
            let slave = Slave::builder(board.node_id, &Profile::DEFAULT, device);
            slave.retained(board.hardware.retained.expect("RAM that outlives a reset")).build()
        };
        world = world.slave(node, slave, idle);
    }
    let mut world = world.build();
    world.run_until(STRIKE);
    assert!(world.all_operational());
    world
}

/// Lets each slave report four more errors and other values.
fn report(world: &World, value: u8) {
    for node in nodes() {
        world.slave::<Instrument>(node).with(|slave: &mut TestSlave, now| {
            for source in 0..ERRORS {
                slave.raise(DeviceError::new(ErrorCode::TEMPERATURE_DEVICE, source), [0; 4]);
            }
            slave.change(now, |device| device.states = [value; STATES]);
        });
    }
}

/// Runs until the master has left `bus`.
fn run_until_left(world: &mut World, bus: Bus) {
    let end = world.now() + Time::from_ms(500);
    while world.master_bus() == bus {
        assert!(world.now() < end, "the master stays on {bus:?}");
        world.run_for(Time::from_us(100));
    }
}

/// Returns the number of frames of slaves on a bus since `from` for which `is_it` holds.
fn count(world: &World, bus: Bus, from: Time, is_it: impl Fn(u16, &[u8]) -> bool) -> usize {
    let sent = world.frames(bus).iter().filter(|sent| sent.end >= from);
    sent.filter(|sent| sent.id().is_some_and(|id| is_it(id, sent.frame.payload()))).count()
}

const fn is_state(id: u16) -> bool {
    id >= 0x280 && id <= 0x300
}

/// Given fifteen slaves whose reports come while the bus fails, when the master has changed the bus and commands one of them each
/// millisecond, then each command arrives within 10 ms, and all errors and values follow.
///
/// Verifies: ECSS 6.4a, 8.3.3b
#[test]
fn commands_go_on_while_fifteen_slaves_announce() {
    let mut world = world();
    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(20));
    report(&world, 7);
    run_until_left(&mut world, Bus::Nominal);
    let change = world.now();
    let mut asked = vec![];
    for number in 0..300_u16 {
        let node = nodes().nth(usize::from(number) % usize::from(SLAVES)).expect("one of them");
        let frame =
            Frame::of(CobId::new(0x200 + u16::from(node.get())).expect("a COB-ID"), number.to_le_bytes());
        let sent =
            world.master::<Plain>().with(|master: &mut Master<Plain>, now| master.send_frame(frame, now));
        assert_eq!(sent, Ok(()), "command {number}");
        asked.push((world.now(), node, number));
        world.run_for(Time::from_ms(1));
    }
    for (at, node, number) in asked {
        let log = world.log_of(node);
        let arrived = log.iter().find(|(time, event)| {
            let is_it = |data: &[u8; 8]| data[..2] == number.to_le_bytes();
            *time >= at && matches!(event, NodeEvent::Slave(SlaveEvent::Pdo(pdo)) if is_it(&pdo.data))
        });
        let (arrival, _) = arrived.unwrap_or_else(|| panic!("command {number} to {node:?} never arrived"));
        assert!(arrival.since(at) <= Time::from_ms(10), "command {number}: {:?}", arrival.since(at));
    }
    world.run_for(Time::from_ms(2_000));
    let values = count(&world, Bus::Redundant, change, |id, data| is_state(id) && data == [7]);
    assert_eq!(values, usize::from(SLAVES) * STATES, "each value once");
    let known = world.master::<Plain>().with(|master: &mut Master<Plain>, _| master.active_errors().count());
    assert_eq!(known, usize::from(SLAVES) * usize::from(ERRORS));
}

/// Given ten changes of the bus in ten seconds, then no slave is silenced by its budget, and each slave sends a value
/// at most once per change and per report.
///
/// Verifies: ECSS 5.3.3.1b, 6.4a, 8.3.3b
#[test]
fn ten_changes_in_ten_seconds_neither_silence_a_node_nor_flood() {
    const CHANGES: u8 = 10;
    let mut world = world();
    let mut bus = Bus::Nominal;
    for change in 1..=CHANGES {
        world.cut(bus, NEXT_TO_MASTER_M);
        world.run_for(Time::from_ms(20));
        report(&world, change);
        run_until_left(&mut world, bus);
        world.heal(bus);
        world.run_until(STRIKE + Time::from_ms(1_000 * u64::from(change)));
        assert!(world.all_operational(), "change {change}");
        bus = bus.other();
    }
    world.run_for(Time::from_ms(2_000));
    let is_silenced = |event: &NodeEvent| matches!(event, NodeEvent::Slave(SlaveEvent::OverBudget { .. }));
    for node in nodes() {
        assert!(!world.log_of(node).iter().any(|(_, event)| is_silenced(event)), "{node:?}");
    }
    let of_all = |is_it: fn(u16, &[u8]) -> bool| {
        Bus::ALL.into_iter().map(|bus| count(&world, bus, STRIKE, is_it)).sum::<usize>()
    };
    let (values, changes) = (usize::from(SLAVES) * STATES, usize::from(CHANGES));
    let sent = of_all(|id, _| is_state(id));
    assert!((values * changes..=values * changes * 2).contains(&sent), "{sent} frames with values");
    let errors = usize::from(SLAVES) * usize::from(ERRORS);
    let emergencies = of_all(|id, _| (0x081..0x100).contains(&id));
    assert!(emergencies <= errors + errors * changes, "{emergencies} emergencies");
    let known = world.master::<Plain>().with(|master: &mut Master<Plain>, _| master.active_errors().count());
    assert_eq!(known, errors);
}
