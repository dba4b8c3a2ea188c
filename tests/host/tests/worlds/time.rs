//! SYNC, Local Time and the Spacecraft Time PDO; drifting clocks.

use std::pin::pin;

use can_twin::wire::time::Time;
use ecss_can::node::{MasterEvent, MasterRequest, SlaveEvent};
use ecss_can::od::Field;
use ecss_can::runner::extend::WholeNode;
use ecss_can::runner::{MasterHandle, TimeHandle};
use ecss_can::sdo::Error;
use ecss_can::types::{Address, Bus, Duration, Scet};
use ecss_can_worlds::world::{Sent, World};
use futures_util::future::{join_all, select};
use futures_util::poll;
use mission::{LIBRECUBE, Received, STANDARD};

use crate::support::*;

/// Returns the seconds in seven octets: fine time u24, coarse time u32, little-endian (ECSS Figure 7-1).
fn seconds(octets: &[u8]) -> f64 {
    assert_eq!(octets.len(), 7);
    let fine = u32::from_le_bytes([octets[0], octets[1], octets[2], 0]);
    let coarse = u32::from_le_bytes([octets[3], octets[4], octets[5], octets[6]]);
    f64::from(coarse) + f64::from(fine) / f64::from(1 << 24)
}

fn seconds_of(sent: &Sent) -> f64 {
    seconds(sent.frame.payload())
}

/// Returns the frame of `id` that follows `after`.
fn next(world: &World, id: u16, after: &Sent) -> Sent {
    since(world, Bus::Nominal, id, after.end).into_iter().next().expect("an answer to the SYNC")
}

/// Verifies: ECSS 6.9c, 6.9d, 6.3b
#[test]
fn sync_comes_every_period_from_the_master_alone() {
    let mut world = running(STANDARD, 3);
    world.run_until(ms(4_000));
    let frames = between(&world, Bus::Nominal, 0x080, ms(1_000), ms(4_000));
    assert_eq!(frames.len(), 30);
    assert!(frames.iter().all(|sent| sent.node == Some(MASTER) && sent.frame.dlc == 0));
    assert!(periods_us(&frames).iter().all(|us| us.abs_diff(100_000) < 500), "{:?}", periods_us(&frames));
}

/// Given a busy network, then each device with a synchronous PDO has 1005h: the master as the producer, the slaves as consumers. When
/// 1005h of one slave is changed by SDO, then its synchronous PDO follows the new identifier alone.
///
/// Verifies: ECSS 6.3a, 6.9b, 6.9e, 6.10c
/// Notices: ECSS 6.3a: a slave answers 080h whatever its 1005h says.
#[test]
fn devices_with_synchronous_pdos_have_a_sync_object() {
    const SYNC: Field = Field::raw(Address::new(0x1005, 0));
    const SYNC_TYPE: Field = Field::raw(Address::new(0x1800, 2));
    let mut world = MissionWorld::busy(STANDARD, 3, |world| world);
    world.run_until(ms(1_000));
    let task = world.on_master(|master| async move {
        let mut found = vec![];
        for node in [TWO, THREE, FOUR] {
            let (mut cob_id, mut kind) = ([0; 4], [0]);
            master.sdo(node).read_bytes(SYNC, &mut cob_id).await?;
            master.sdo(node).read_bytes(SYNC_TYPE, &mut kind).await?;
            found.push((u32::from_le_bytes(cob_id), kind[0]));
        }
        master.sdo(TWO).write_bytes(SYNC, &0x90_u32.to_le_bytes()).await?;
        Ok::<_, Error>(found)
    });
    world.run_for(ms(90));
    assert_eq!(task.take().expect("the SDO transfers ended").1, Ok(vec![(0x80, 1); 3]));
    let producer = world.master(|master| master.objects().communication.sync.cob_id);
    assert_eq!(producer, 0x4000_0080, "bit 30: it produces SYNC");

    let from = world.now();
    for _ in 0..3 {
        world.run_for(ms(250));
        world.inject(Bus::Nominal, standard(0x090, &[]));
    }
    world.run_for(ms(250));
    let number = |id| since(&world, Bus::Nominal, id, from).len();
    let syncs = number(0x080);
    assert!((9..=11).contains(&syncs), "{syncs}");
    assert_eq!([0x182, 0x183, 0x184].map(number), [3, syncs, syncs]);
}

/// Given a busy network of a profile, then between two SYNCs each slave with a clock sends its local time once, by a COB-ID of its
/// own. Its dictionary maps the local time (2011h) to one PDO.
///
/// Verifies: ECSS 7.2.3h, 7.2.3i, 7.2.3j, 7.2.2f, 7.2.2g
#[test]
fn each_slave_sends_one_local_time_pdo_with_each_sync() {
    for (profile, end) in [(STANDARD, ms(3_000)), (LIBRECUBE, ms(31_000))] {
        let mut world = MissionWorld::busy(profile, 3, |world| world);
        world.run_until(end);
        let syncs = between(&world, Bus::Nominal, 0x080, ms(1_000), end);
        assert!(syncs.len() >= 5, "{}", syncs.len());
        let ids = [TWO, THREE, FOUR].map(|node| (node, 0x180 + u16::from(node.get())));
        for pair in syncs.windows(2) {
            for (node, id) in ids {
                let sent = between(&world, Bus::Nominal, id, pair[0].end, pair[1].end);
                assert_eq!(sent.len(), 1, "{id:03X}h after the SYNC at {} us", pair[0].end.as_us());
                assert_eq!(sent[0].node, Some(node));
                assert!(sent[0].end.since(pair[0].end) < ms(2), "{id:03X}h");
            }
            // 181h is the spacecraft time; no node has the others.
            let frames = world.frames(Bus::Nominal).iter();
            let sent = frames.filter(|sent| sent.start >= pair[0].end && sent.end <= pair[1].end);
            assert_eq!(sent.filter(|sent| matches!(sent.id(), Some(0x182..0x200))).count(), 3);
        }
        for node in [TWO, THREE, FOUR] {
            let mappings = world.slave(node, |slave| {
                let tpdos = &slave.objects().pdos.tpdo_mappings;
                tpdos
                    .iter()
                    .filter(|mapping| mapping.objects.iter().any(|object| object >> 16 == 0x2011))
                    .count()
            });
            assert_eq!(mappings, 1, "{node:?}");
        }
    }
}

/// Verifies: ECSS 7.2.2e, 7.2.2f, 7.2.2g, 7.2.3k, 7.2.3i
#[test]
fn local_time_is_the_slaves_time_at_the_end_of_the_sync() {
    // No node sets the clocks in the first second. They start at zero at power-on.
    let mut world =
        MissionWorld::of(STANDARD, 2, |world| world.powered_at(TWO, ms(7)).powered_at(THREE, ms(13)));
    world.run_until(ms(900));
    let syncs = between(&world, Bus::Nominal, 0x080, ms(400), ms(850));
    assert!(syncs.len() >= 4);
    for sync in syncs {
        for (id, power_on) in [(0x182, 0.007), (0x183, 0.013)] {
            let told = seconds_of(&next(&world, id, &sync));
            let truth = sync.end.as_secs_f64() - power_on;
            assert!((told - truth).abs() < 3e-6, "{id:03X} says {told}, it was {truth}");
        }
    }
}

/// Verifies: ECSS 7.2.2b, 7.2.2d, 7.2.2a, 7.2.2c, 7.2.3b
#[test]
fn spacecraft_time_reaches_every_slave() {
    let mut world = running(STANDARD, 3);
    world.run_for(ms(50));
    let set_at = world.now();
    world.request(MasterRequest::SetTime(Scet::new(1_000_000, 1 << 23).expect("half a second")));
    // The third time changes the clocks of the slaves, which the SYNC after it shows.
    world.run_for(ms(3_150));
    // The value is the master's time at the end of the SYNC before it.
    let distributed = since(&world, Bus::Nominal, 0x181, set_at);
    assert_eq!(distributed.len(), 3, "one per second, from the master");
    for sent in &distributed {
        assert_eq!(sent.node, Some(MASTER));
        let truth = 1_000_000.5 + sent.end.since(set_at).as_secs_f64();
        let late = truth - seconds_of(sent);
        assert!((0.0..0.001).contains(&late), "late by {late} s");
    }
    let last = distributed.last().expect("three");
    for sync in since(&world, Bus::Nominal, 0x080, last.end) {
        for id in [0x182, 0x183, 0x184] {
            let answers = since(&world, Bus::Nominal, id, sync.end);
            let Some(answer) = answers.first() else { continue };
            // A slave takes the value as the time at the end of that SYNC.
            let truth = 1_000_000.5 + sync.end.since(set_at).as_secs_f64();
            assert!((seconds_of(answer) - truth).abs() < 0.001, "{id:03X}");
        }
    }
    // The master compares the clocks: each is within a millisecond of its own time at the last SYNC.
    let reference = world.master(|master| master.scet_at_sync()).expect("there was a SYNC");
    let last_sync = since(&world, Bus::Nominal, 0x080, set_at).pop().expect("SYNC every 100 ms");
    let compared: Vec<i64> = master_told(&world, last_sync.end)
        .into_iter()
        .filter_map(|event| match event {
            MasterEvent::Pdo(pdo) => match mission::received(&pdo)?.1 {
                Received::LocalTime(scet) => Some(scet.micros_since(reference)),
                Received::Telemetry(_) => None,
            },
            _ => None,
        })
        .collect();
    assert_eq!(compared.len(), 3);
    assert!(compared.iter().all(|us| us.abs() < 1_000), "{compared:?}");
}

/// Verifies: ECSS 7.2.3c, 7.2.3g, 7.2.3i, 7.2.3k
#[test]
fn clocks_100_ppm_apart_are_steered_to_one_time() {
    let mut world = MissionWorld::of(STANDARD, 2, |world| world.drift(TWO, 100).drift(THREE, -100));
    world.run_until(ms(30_950));
    assert!(world.all_operational());
    // The last SYNC before the next distribution, 0.9 s after the one before.
    let sync = between(&world, Bus::Nominal, 0x080, ms(30_500), ms(30_950)).pop().expect("SYNC every 100 ms");
    let truth = world.master(|master| master.scet_at_sync()).expect("there was a SYNC");
    for id in [0x182, 0x183] {
        let told =
            Scet::decode(since(&world, Bus::Nominal, id, sync.end)[0].frame.payload()).expect("a time");
        let off = told.micros_since(truth);
        // Without steering it would be 90 us by now, and 3 ms in all.
        assert!(off.abs() <= 2, "{id:03X} is off by {off} us");
    }
    // Each clock was set once.
    for node in [TWO, THREE] {
        let steps = told(&world, node, ms(0), |event| matches!(event, SlaveEvent::Step(_)));
        assert_eq!(steps.len(), 1, "{steps:?}");
    }
}

/// Verifies: ECSS 6.9d
#[test]
fn a_master_100_ppm_off_makes_its_periods_so_much_longer() {
    let mut world = MissionWorld::of(STANDARD, 2, |world| world.drift(MASTER, -100));
    world.run_until(ms(101_000));
    assert!(world.all_operational());
    let syncs = between(&world, Bus::Nominal, 0x080, Time::ZERO, Time::NEVER);
    let span = syncs[1_000].end.since(syncs[0].end).as_secs_f64();
    // 1000 periods of 100 ms on a clock that is slow by 100 ppm.
    assert!((span - 100.010_001).abs() < 500e-6, "{span}");
}

/// Given a slave configured with a delay of 10 us, and a master with one of 3 us When the cable is measured Then the
/// result is the true delay, with the microsecond resolution of interrupt stamps.
#[test]
fn a_cable_is_as_long_as_it_is_whatever_delays_are_configured() {
    let mut world = running(STANDARD, 2);
    for (node, delay_ns) in [(MASTER, 3_000_i32), (TWO, 10_000)] {
        world.write(node, Address::new(0x2014, 1), &delay_ns.to_le_bytes());
    }
    world.run_for(ms(5_000));
    let task = world.on_master(|master| async move { master.measure_cable(TWO).await });
    world.run_for(ms(2_500));
    let (_, measured) = task.take().expect("it ended");
    let cable = measured.expect("it was measured");
    assert_eq!(cable.bus, Bus::Nominal);
    assert!(cable.delay_ns.abs() < 2_000, "{} ns", cable.delay_ns);
}

#[test]
fn a_cable_to_nobody_or_of_a_bus_that_was_left_is_a_typed_error() {
    let mut world = running(STANDARD, 2);
    let task = world.on_master(|master| async move { master.measure_cable(FOUR).await });
    world.run_for(ms(2_000));
    assert_eq!(task.take().map(|(_, measured)| measured), Some(Err(Error::Timeout)));
    let task = world.on_master(|master| async move { master.measure_cable(TWO).await });
    world.run_for(ms(500));
    world.request(MasterRequest::SwitchBus(Bus::Redundant));
    world.run_for(ms(5_000));
    assert_eq!(task.take().map(|(_, measured)| measured), Some(Err(Error::BusChanged)));
}

/// Given a measurement and four waits for a time, when they are dropped within a call that has the node, then 2044h names
/// no slave, and four others are woken by a step of the clock at once.
#[test]
fn futures_dropped_within_a_step_free_their_places() {
    let mut world = running(STANDARD, 2);
    let task = world.on_master(|master| async move {
        let clock = master.clock();
        let late = Scet::new(clock.now().coarse() + 1_000, 0).expect("a whole second");
        let mut measured = Box::pin(master.measure_cable(TWO));
        let mut waits: Vec<_> = (0..4).map(|_| Box::pin(clock.at(late))).collect();
        for wait in &mut waits {
            assert!(poll!(wait).is_pending());
        }
        let given_up = pin!(master.wait_until(master.now() + Duration::from_millis(300)));
        select(measured.as_mut(), given_up).await;
        master.with(move |_, _| drop((measured, waits)));
        let named = master.with(|master, _| master.objects().application.network.ranging.node);
        let mut waits: Vec<_> = (0..4).map(|_| Box::pin(clock.at(late))).collect();
        for wait in &mut waits {
            assert!(poll!(wait).is_pending());
        }
        master.request(MasterRequest::SetTime(late));
        let stepped = master.now();
        join_all(waits).await;
        (named, master.now().since(stepped))
    });
    world.run_for(ms(1_000));
    assert_eq!(task.take().map(|(_, outcome)| outcome), Some((0, Duration::ZERO)));
}

/// Given a measurement whose future is dropped under way, then 2044h names no slave any more.
#[test]
fn a_measurement_that_is_dropped_names_no_slave() {
    let mut world = running(STANDARD, 2);
    let task = world.on_master(|master| async move {
        let given_up = master.wait_until(master.now() + Duration::from_millis(300));
        select(pin!(master.measure_cable(TWO)), pin!(given_up)).await;
    });
    let named =
        |world: &MissionWorld| world.master(|master| master.objects().application.network.ranging.node);
    world.run_for(ms(200));
    assert_eq!(named(&world), TWO.get());
    world.run_for(ms(200));
    assert_eq!((task.take().is_some(), named(&world)), (true, 0));
}
