//! A flight without faults: frames of each node, their times and their contents.

use std::sync::LazyLock;

use can_twin::spacecraft::{Bus, WireRecord};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use flight::*;

const SLAVES: [u8; 3] = [2, 3, 4];
const SYNC: u16 = 0x080;
const SPACECRAFT_TIME: u16 = 0x181;
/// Duration of frames that may precede a requested frame.
const QUEUEING: Time = Time::from_us(400);
/// Frames that may be ahead of a heartbeat, whose COB-IDs have the lowest priority: a command, a request and a reply of each
/// slave, 135 us each.
const HEARTBEAT_QUEUEING: Time = Time::from_us(9 * 135);

/// Two spacecraft times and four SYNCs.
static FLIGHT: LazyLock<Recording> = LazyLock::new(|| {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(20_300);
    flight.assert_nothing_lost();
    flight.seen
});

fn setup(node: u8) -> BoardSetup {
    MASTER_AND_THREE.into_iter().find(|setup| setup.node == node).unwrap()
}

/// Returns the duration of `nominal` by the crystal of `node`. It is shorter with a fast crystal.
fn by_crystal(node: u8, nominal: Time) -> Time {
    Time((nominal.0 as f64 / (1.0 + setup(node).ppm * 1e-6)).round() as u64)
}

/// Verifies: ECSS 6.5.3a
/// Verifies: ECSS 8.3.2a
/// Verifies: ECSS 6.10e
/// Verifies: ECSS 6.10j
#[test]
fn every_node_begins_with_boot_up_message_on_default_bus() {
    for setup in MASTER_AND_THREE {
        let first = FLIGHT.of(setup.node).next().unwrap();
        assert_eq!((first.bus, first.id()), (Bus::Nominal, Some(0x700 + u16::from(setup.node))));
        assert_eq!(first.data(), [BOOT_UP]);
    }
    assert_eq!(FLIGHT.on(Bus::Redundant).count(), 0);
}

/// Given a master that is powered first, then it is error passive until a slave acknowledges a frame, and no error is
/// reported.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn nobody_reports_an_error_in_a_nominal_flight() {
    let emergencies = |seen: &&Seen| seen.id().is_some_and(|id| (0x081..=0x0FF).contains(&id));
    let reported: Vec<&Seen> = FLIGHT.frames.iter().filter(emergencies).collect();
    assert!(reported.is_empty(), "{reported:?}");
}

/// Verifies: ECSS 6.5.1a.1, 6.5.3a
#[test]
fn a_slave_is_started_as_soon_as_it_has_booted() {
    for node in SLAVES {
        let heartbeats = FLIGHT.heartbeats(node, Bus::Nominal);
        let (booted, started) = (heartbeats[0], heartbeats[1]);
        assert_eq!((booted.1, started.1), (BOOT_UP, OPERATIONAL));
        let start = FLIGHT.first_after(booted.0, |seen| seen.id() == Some(0) && seen.data() == [1, node]);
        assert!(start.unwrap().end < started.0);
        // The slave checks its program (8 ms) and scans the store of an erased chip (4 ms). The master reads identity and settings over
        // SDO.
        assert!(started.0 < ms(setup(node).power_on_ms + 28), "node {node}: {} us", started.0.as_us());
    }
}

/// Verifies: ECSS 6.5.2a
/// Verifies: ECSS 8.3.3a
/// Verifies: ECSS 8.3.3d
#[test]
fn heartbeats_come_every_250_ms_by_the_crystal_of_their_node() {
    for setup in MASTER_AND_THREE {
        let heartbeats = FLIGHT.heartbeats(setup.node, Bus::Nominal);
        let steady: Vec<Time> = heartbeats.iter().map(|(at, _)| *at).filter(|at| *at > ms(300)).collect();
        assert!(steady.len() >= 79, "node {}: {} heartbeats", setup.node, steady.len());
        for gap in gaps(&steady) {
            let is_steady = about(ms(250), HEARTBEAT_QUEUEING).contains(&gap);
            assert!(is_steady, "node {}: {} us", setup.node, gap.as_us());
        }
        let periods = steady.len() as u64 - 1;
        let lasted = steady[steady.len() - 1].since(steady[0]);
        let expected = by_crystal(setup.node, ms(250 * periods));
        assert!(about(expected, HEARTBEAT_QUEUEING).contains(&lasted), "node {}: {lasted:?}", setup.node);
        assert!(heartbeats.iter().filter(|(at, _)| *at > ms(300)).all(|(_, state)| *state == OPERATIONAL));
    }
}

/// Verifies: ECSS 6.9c
/// Verifies: ECSS 7.2.2b
/// Verifies: ECSS 7.2.2d
/// Verifies: ECSS 6.9d
/// Verifies: ECSS 7.2.3b
#[test]
fn a_sync_every_5_s_and_a_spacecraft_time_every_10_s() {
    for (id, period, count) in [(SYNC, 5000, 4), (SPACECRAFT_TIME, 10_000, 2)] {
        let ends: Vec<Time> = FLIGHT.sent(MASTER, Bus::Nominal, id).map(|seen| seen.end).collect();
        assert_eq!(ends.len(), count, "{id:03X}h");
        assert_eq!(FLIGHT.with_id(id).count(), count, "no other producer");
        for gap in gaps(&ends) {
            let expected = by_crystal(MASTER, ms(period));
            assert!(about(expected, QUEUEING).contains(&gap), "{id:03X}h: {} us", gap.as_us());
        }
    }
}

/// Returns the SCET in a frame, microseconds: fine time (2^-24 s), then coarse time, little-endian (ECSS Figure 7-1).
fn scet_us(octets: &[u8]) -> u64 {
    assert_eq!(octets.len(), 7);
    let (fine, coarse) = octets.split_at(3);
    number(coarse) * 1_000_000 + ((number(fine) * 1_000_000) >> 24)
}

/// Verifies: ECSS 6.9e
/// Verifies: ECSS 7.2.2c
/// Verifies: ECSS 7.2.2f
/// Verifies: ECSS 7.2.3k
/// Verifies: ECSS 7.2.3i
#[test]
fn every_slave_sends_its_local_time_of_each_sync() {
    let syncs: Vec<Time> = FLIGHT.sent(MASTER, Bus::Nominal, SYNC).map(|seen| seen.end).collect();
    let spacecraft_time = FLIGHT.sent(MASTER, Bus::Nominal, SPACECRAFT_TIME).next().unwrap();
    for node in SLAVES {
        let local: Vec<&Seen> = FLIGHT.sent(node, Bus::Nominal, 0x180 + u16::from(node)).collect();
        assert_eq!(local.len(), syncs.len());
        for (local, sync) in local.iter().zip(&syncs) {
            assert!(local.end > *sync && local.end < *sync + ms(2), "node {node}: {} us", local.end.as_us());
        }
        // The SYNC at 15 s comes 5 s after the clocks were set: crystals of at most 50 ppm, and a frame's way.
        let elapsed = syncs[2].since(spacecraft_time.end).as_us();
        let expected = scet_us(spacecraft_time.data()) + elapsed;
        let off = scet_us(local[2].data()).abs_diff(expected);
        assert!(off < 600, "node {node} is {off} us off");
    }
}

/// Verifies: ECSS 6.2a
#[test]
fn commands_and_telemetry_flow_ten_times_a_second() {
    for node in SLAVES {
        for function in [0x300, 0x400] {
            let sent: Vec<&Seen> = FLIGHT.sent(MASTER, Bus::Nominal, function + u16::from(node)).collect();
            let expected = (20_300 - setup(node).power_on_ms) / 100;
            assert!((sent.len() as u64).abs_diff(expected) <= 1, "node {node}: {} frames", sent.len());
        }
    }
}

/// Returns the telemetry of a slave with this code, and the time of each request.
fn replies(node: u8, code: u16) -> Vec<(Time, Vec<u8>)> {
    let [request_id, reply_id] = [0x400, 0x380].map(|function| function + u16::from(node));
    let mut replies = Vec::new();
    for request in FLIGHT.sent(MASTER, Bus::Nominal, request_id).filter(|seen| seen.end < ms(20_250)) {
        let reply = FLIGHT.first_after(request.end, |seen| seen.id() == Some(reply_id)).unwrap();
        assert!(reply.end < request.end + ms(2), "node {node} at {} us", request.end.as_us());
        assert_eq!(reply.data()[..2], request.data()[..2]);
        if request.data()[..2] == code.to_le_bytes() {
            replies.push((request.end, reply.data()[2..].to_vec()));
        }
    }
    assert!(replies.len() >= 19, "node {node}, {code:04X}h: {} replies", replies.len());
    replies
}

fn number(octets: &[u8]) -> u64 {
    octets.iter().rev().fold(0, |number, octet| number << 8 | u64::from(*octet))
}

#[test]
fn the_uptime_told_is_the_time_since_power_on() {
    for node in SLAVES {
        for (asked, reply) in replies(node, 0x0101) {
            let since_power_on = asked.since(ms(setup(node).power_on_ms)).as_us() / 1000;
            let told = number(&reply);
            // The clock starts after the check of the program, the start of the crystal and the initialisation of memory.
            assert!((since_power_on - 18..=since_power_on + 1).contains(&told), "node {node}: {told} ms");
        }
    }
}

/// Verifies: ECSS 6.2a
#[test]
fn the_value_read_back_is_the_one_last_commanded() {
    for node in SLAVES {
        let commands: Vec<&Seen> = FLIGHT.sent(MASTER, Bus::Nominal, 0x300 + u16::from(node)).collect();
        for (asked, reply) in replies(node, 0x0102) {
            let set = commands.iter().rfind(|seen| seen.end < asked && seen.data()[..2] == [2, 0]).unwrap();
            assert_eq!(reply[..4], set.data()[2..6], "node {node} at {} us", asked.as_us());
        }
    }
}

/// Verifies: ECSS 6.2a
#[test]
fn every_command_is_executed() {
    for node in SLAVES {
        let commands: Vec<&Seen> = FLIGHT.sent(MASTER, Bus::Nominal, 0x300 + u16::from(node)).collect();
        for (asked, reply) in replies(node, 0x0103) {
            let sent = commands.iter().filter(|seen| seen.end < asked).count();
            assert_eq!(number(&reply), sent as u64, "node {node} at {} us", asked.as_us());
        }
    }
}

#[test]
fn the_frames_told_are_those_on_the_wire() {
    for node in SLAVES {
        for (asked, reply) in replies(node, 0x0110) {
            let sent = FLIGHT.of(node).filter(|seen| seen.end < asked).count();
            assert_eq!(number(&reply[3..6]), sent as u64, "node {node} at {} us", asked.as_us());
        }
    }
}

#[test]
fn no_slave_sees_an_error_or_loses_a_frame() {
    for node in SLAVES {
        for code in [0x0120, 0x0121, 0x0130, 0x0131] {
            for (asked, reply) in replies(node, code) {
                assert_eq!(number(&reply), 0, "node {node}, {code:04X}h at {} us", asked.as_us());
            }
        }
    }
    let is_destroyed = |wire: &&WireRecord| matches!(wire.record, Observation::Destroyed { .. });
    let destroyed = FLIGHT.records.iter().filter(is_destroyed).filter(|wire| wire.at > ms(80));
    assert_eq!(destroyed.count(), 0, "with two nodes on the bus every frame is acknowledged");
}

fn flown(ppm_of_slave: f64) -> Recording {
    let mut setups = MASTER_AND_THREE;
    setups[1].ppm = ppm_of_slave;
    let mut flight = Flight::new(&setups);
    flight.fly_to(1500);
    flight.seen
}

#[test]
fn a_flight_is_a_function_of_its_configuration() {
    let (one, again, other) = (flown(-31.0), flown(-31.0), flown(-30.0));
    assert_eq!(one.records, again.records);
    assert_eq!(one.logs, again.logs);
    assert_ne!(one.records, other.records);
}
