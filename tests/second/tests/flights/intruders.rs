//! Foreign nodes with identifiers of the master, and two boards with one Node-ID.

use std::sync::{LazyLock, Mutex};

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use flight::*;

/// EMCY code 8150h, CAN-ID collision, as on the wire.
const COLLISION: [u8; 2] = [0x50, 0x81];
/// EMCY code 8130h, heartbeat error, as on the wire.
const HEARTBEAT_ERROR: [u8; 2] = [0x30, 0x81];

/// Lets a guest send `frame` every `period_ms` from `from_ms` to `to_ms`.
fn babble(flight: &mut Flight, guest: GuestId, frame: WireFrame, period_ms: u64, [from_ms, to_ms]: [u64; 2]) {
    for at in (from_ms..to_ms).step_by(period_ms as usize) {
        flight.twin.inject(guest, ms(at), frame);
    }
}

/// Returns a flight with master and slaves 2 and 3 on the redundant bus at 3 s, after a cut of the nominal bus next to
/// the master. It is run once, and copied for each intruder.
fn after_fail_over() -> (Flight, GuestId) {
    static FLOWN: LazyLock<Mutex<(Flight, GuestId)>> = LazyLock::new(|| Mutex::new(fail_over()));
    FLOWN.lock().unwrap().clone()
}

fn fail_over() -> (Flight, GuestId) {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
    flight.fly_to(2000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(3000);
    flight.assert_operational([2, 3], Bus::Redundant);
    (flight, guest)
}

/// Returns the emergencies of `node` with this code.
fn emergencies(flight: &Flight, node: u8, code: [u8; 2]) -> Vec<(Bus, Time)> {
    let all = flight.of(node).filter(|seen| seen.id() == Some(0x080 + u16::from(node)));
    all.filter(|seen| seen.data()[..2] == code).map(|seen| (seen.bus, seen.end)).collect()
}

/// Asserts that an intruder costs at most one period. `before`: commands that nodes 2 and 3 executed before it.
fn assert_cost_one_period(flight: &mut Flight, before: [u32; 2], bus: Bus, period: u64) {
    println!("every {period} ms");
    flight.assert_operational([2, 3], bus);
    for (node, before) in [2, 3].into_iter().zip(before) {
        // Commands are sent every 100 ms. Of 40, those of one heartbeat period (250 ms) may be lost.
        let executed = flight.executed(node) - before;
        assert!(executed >= 40 - 3, "node {node}, every {period} ms: {executed} of 40\n{}", flight.log(node));
        assert_eq!(emergencies(flight, node, COLLISION).len(), 1, "every {period} ms\n{}", flight.log(node));
    }
    flight.assert_nothing_lost();
}

/// Given a master that left the nominal bus, when a node there sends 701h for 4 s, then each slave changes to that bus
/// at most once, and reports it.
///
/// Verifies: ECSS 8.3.3c
#[test]
fn intruder_heartbeat_on_left_bus_costs_one_period() {
    for period in [10, 50, 240] {
        let (mut flight, guest) = after_fail_over();
        let before = [2, 3].map(|node| flight.executed(node));
        babble(&mut flight, guest, WireFrame::standard(0x701, &[OPERATIONAL]), period, [3001, 7001]);
        flight.fly_to(7010);
        assert_cost_one_period(&mut flight, before, Bus::Redundant, period);
        for node in [2, 3] {
            let strayed = flight.heartbeats(node, Bus::Nominal).into_iter().filter(|(at, _)| *at > ms(3000));
            assert!(strayed.count() <= 2, "node {node}, every {period} ms");
        }
    }
}

/// Given an intruder that sends at all times, even before the cut, then the slaves detect no silence on the bus that
/// the master leaves, and lose one period.
#[test]
fn intruder_heartbeat_before_the_cut_costs_one_period() {
    for period in [10, 50, 240] {
        let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
        babble(&mut flight, guest, WireFrame::standard(0x701, &[OPERATIONAL]), period, [1001, 7001]);
        flight.fly_to(2000);
        flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        flight.fly_to(2300);
        let before = [2, 3].map(|node| flight.executed(node));
        flight.fly_to(6310);
        assert_cost_one_period(&mut flight, before, Bus::Redundant, period);
    }
}

/// Given a command on the inactive bus, then a slave that follows its master neither changes the bus nor obeys it.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn intruder_command_on_left_bus_moves_no_slave() {
    for command in [[0x01, 0x7E], [0x80, 2], [0x80, 0], [0x82, 0], [0x81, 0]] {
        let (mut flight, guest) = after_fail_over();
        let before = [2, 3].map(|node| flight.executed(node));
        babble(&mut flight, guest, WireFrame::standard(0x000, &command), 50, [3001, 7001]);
        flight.fly_to(7010);
        flight.assert_kept_running([2, 3], ms(3000));
        for (node, before) in [2, 3].into_iter().zip(before) {
            let executed = flight.executed(node) - before;
            assert!(executed >= 39, "{command:02X?}: {executed}");
            let strayed = flight.heartbeats(node, Bus::Nominal).into_iter().filter(|(at, _)| *at > ms(3000));
            assert_eq!(strayed.count(), 0, "node {node}, {command:02X?}");
        }
        flight.assert_nothing_lost();
    }
}

/// Given buses without a fault, when a node sends 701h on the idle one for 4 s, then each slave changes to it once and
/// returns.
#[test]
fn intruder_heartbeat_on_idle_bus_costs_one_period() {
    let mut undisturbed = Flight::new(&MASTER_AND_THREE[..3]);
    let guest = undisturbed.twin.add_guest(Bus::Redundant, 30.0);
    undisturbed.fly_to(3000);
    for period in [10, 50, 240] {
        let mut flight = undisturbed.clone();
        let before = [2, 3].map(|node| flight.executed(node));
        babble(&mut flight, guest, WireFrame::standard(0x701, &[OPERATIONAL]), period, [3001, 7001]);
        flight.fly_to(7010);
        assert_cost_one_period(&mut flight, before, Bus::Nominal, period);
        for node in [2, 3] {
            let changes = flight.log(node).matches("active bus: ").count();
            assert!(changes <= 4, "power-on, found, followed, taken back\n{}", flight.log(node));
        }
    }
}

/// Given a cut next to the master, when a node keeps sending a command to a node that does not exist, then the slave
/// with selective access continues its search and finds the master, at most a consumer time later.
///
/// Verifies: ECSS 8.3.3g, 8.3.3h
#[test]
fn babbled_command_does_not_hold_up_a_search() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.fly_to(2013);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    let last = flight.heartbeats(MASTER, Bus::Nominal).last().unwrap().0;
    babble(&mut flight, guest, WireFrame::standard(0x000, &[0x01, 0x7E]), 100, [2100, 18_000]);
    flight.fly_to(18_000);
    let (toggled, _) = flight.heartbeats(4, Bus::Redundant)[0];
    let taken = toggled.since(last);
    assert!(taken > ms(12_499) && taken < ms(15_000 + 10), "{} us\n{}", taken.as_us(), flight.log(4));
    flight.assert_operational([4], Bus::Redundant);
    flight.assert_nothing_lost();
}

/// Given Ttoggle 1, so that miss and switch coincide, then the EMCY is sent on the bus that is being left.
///
/// Verifies: ECSS 8.3.3e
#[test]
fn emcy_of_a_missed_master_precedes_the_switch() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    // SDO download of 2000h sub 2, Ttoggle.
    let write = WireFrame::standard(0x604, &[0x2F, 0x00, 0x20, 2, 1, 0, 0, 0]);
    flight.twin.inject(guest, ms(1060), write);
    flight.fly_to(2013);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    let last = flight.heartbeats(MASTER, Bus::Nominal).last().unwrap().0;
    flight.fly_to(5500);
    let told = emergencies(&flight, 4, HEARTBEAT_ERROR);
    let (toggled, _) = flight.heartbeats(4, Bus::Redundant)[0];
    assert!(toggled.since(last) < ms(2_500 + 4), "{} us", toggled.since(last).as_us());
    // Another slave acknowledged it there. It is repeated on the bus where the slave finds the master.
    assert_eq!(told.len(), 2, "{}", flight.log(4));
    assert!(told[0].0 == Bus::Nominal && told[0].1 < toggled, "{told:?}");
    assert!(told[1].0 == Bus::Redundant && told[1].1 > toggled, "{told:?}");
    flight.assert_nothing_lost();
}

/// Given slave 4 with selective access, when its application chooses the redundant bus by command, where there is no
/// master, then it searches, returns after Ttoggle consumer times and is started. Slave 2 with parallel access refuses.
///
/// Verifies: ECSS 8.2.3a
#[test]
fn application_of_a_selective_slave_chooses_the_bus() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    for (at, id) in [(1060, 0x304), (1063, 0x302)] {
        let select_redundant = WireFrame::standard(id, &[0x04, 0, 1, 0, 0, 0, 0, 0x77]);
        flight.twin.inject(guest, ms(at), select_redundant);
    }
    flight.fly_to(14_500);
    let chosen = flight.first_after(ms(1060), |seen| seen.id() == Some(0x304)).unwrap().end;
    let there = flight.heartbeats(4, Bus::Redundant);
    assert!(there[0].0 < chosen + ms(1) && there[0].1 == PRE_OPERATIONAL, "{there:?}");
    flight.assert_said(4, "active bus: Redundant (Selected)", chosen);
    let back = flight.heartbeats(4, Bus::Nominal).into_iter().find(|(at, _)| *at > chosen).unwrap().0;
    assert!(about(ms(12_500), ms(2)).contains(&back.since(chosen)), "{} us", back.since(chosen).as_us());
    flight.assert_operational([4], Bus::Nominal);
    flight.assert_said(2, "declined", chosen);
    flight.assert_kept_running([2], ms(300));
    assert!(flight.heartbeats(2, Bus::Redundant).is_empty());
    flight.assert_nothing_lost();
}

/// Given a slave that has worked for a consumer time, when a foreign node sends heartbeats with its Node-ID and another
/// state, in step with the slave, faster and slower, then the master reports the collision once, and withholds few
/// commands before.
///
/// Verifies: ECSS 6.10h
#[test]
fn foreign_double_of_a_slave_costs_few_commands() {
    let mut undisturbed = Flight::new(&MASTER_AND_THREE[..3]);
    let guest = undisturbed.twin.add_guest(Bus::Nominal, 30.0);
    undisturbed.fly_to(3000);
    for period in [90, 250, 600] {
        let mut flight = undisturbed.clone();
        let before = flight.executed(2);
        babble(&mut flight, guest, WireFrame::standard(0x702, &[PRE_OPERATIONAL]), period, [3001, 8001]);
        flight.fly_to(8010);
        let executed = flight.executed(2) - before;
        assert!(executed >= 40, "{executed} of 50, every {period} ms\n{}", flight.log(1));
        let reported: Vec<&[u8]> = flight.emergencies(MASTER, ms(0)).collect();
        assert_eq!(reported, [[0x50, 0x81, 0x11, 2, 0, 0, 0, 0]], "{}", flight.log(1));
        flight.assert_said(1, "two nodes have Node-ID 2", ms(3000));
        flight.assert_nothing_lost();
    }
}

/// Given two boards with one Node-ID, then the one that booted last is silent, and one of them reports the reason.
///
/// Verifies: ECSS 6.10h
#[test]
fn second_board_with_a_node_id_yields() {
    for second_ms in [60, 61, 65, 310, 1500] {
        let [master, two, three, _] = MASTER_AND_THREE;
        let second = BoardSetup { ppm: -17.0, position_m: 20.0, power_on_ms: second_ms, ..three };
        let mut flight = Flight::new(&[master, two, three, second]);
        flight.fly_to(6000);
        let of = |board: usize, id: u16| {
            flight.on(Bus::Nominal).filter(move |seen| seen.sender == board && seen.id() == Some(id))
        };
        let alive = |board| of(board, 0x703).any(|seen| seen.end > ms(5000));
        assert!(alive(2) != alive(3), "one of them is silent, powered at {second_ms} ms");
        let (elder, newcomer) = if alive(2) { (2, 3) } else { (3, 2) };
        let said: Vec<&Seen> = of(elder, 0x703).filter(|seen| seen.end > ms(2000)).collect();
        assert!(said.len() >= 15, "powered at {second_ms} ms");
        // Two boards that boot together answer the same SDO requests. Their boot-up may fail, which the master reports.
        let is_started = said.iter().all(|seen| seen.data() == [OPERATIONAL]);
        assert!(is_started || second_ms < 100, "powered at {second_ms} ms\n{}", flight.log(3));
        // That of the newcomer may still be delayed by its inhibit time when it becomes silent.
        let mut told = [elder, newcomer].into_iter().flat_map(|board| of(board, 0x083));
        assert!(told.any(|seen| seen.data()[..2] == COLLISION), "powered at {second_ms} ms");
        let late = flight.on(Bus::Nominal).filter(|seen| seen.sender == newcomer && seen.end > ms(2000));
        assert_eq!(late.count(), 0, "powered at {second_ms} ms");
        let is_lost =
            |record: &Observation| matches!(record, Observation::Destroyed { transmitter: 2.., .. });
        let destroyed = flight.records.iter().filter(|record| is_lost(&record.record)).count();
        assert!(destroyed < 20, "{destroyed} destroyed, powered at {second_ms} ms");
        flight.assert_operational([2], Bus::Nominal);
        flight.assert_sound();
    }
}
