//! Frames that no node of the project sends: foreign, malformed, misplaced.

use can_twin::bxcan::Side;
use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use flight::*;

/// Frames are injected one every 3 ms from here on, in gaps between two rounds of commands.
const FROM_MS: u64 = 1050;

fn extended(id: u32, data: &[u8]) -> WireFrame {
    WireFrame { id: WireId::Extended(id), ..WireFrame::standard(0, data) }
}

fn remote(id: u16, dlc: u8) -> WireFrame {
    WireFrame { remote: true, dlc, ..WireFrame::standard(id, &[]) }
}

/// Flies the master and three slaves; a guest on `bus` sends `frames`. All must complete, acknowledged by every board
/// that takes part in that bus, and no node may change its state or bus.
fn undisturbed(bus: Bus, frames: &[WireFrame]) -> (Flight, GuestId) {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    let guest = flight.twin.add_guest(bus, 30.0);
    let mut at = FROM_MS;
    for frame in frames {
        // Rounds of commands begin every 100 ms after the master's start and last 20 ms.
        while !(45..95).contains(&(at % 100)) {
            at += 1;
        }
        flight.twin.inject(guest, ms(at), *frame);
        at += 3;
    }
    flight.fly_to(at + 1300);
    let sent: Vec<&Seen> = flight.on(bus).filter(|seen| seen.sender == guest.node).collect();
    assert_eq!(sent.iter().map(|seen| seen.frame).collect::<Vec<_>>(), frames);
    let everybody: &[u8] = if bus == Bus::Nominal { &[1, 2, 3, 4] } else { &[1, 2, 3] };
    assert!(sent.iter().all(|seen| seen.reached == everybody), "{sent:?}");
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    for node in [2, 3, 4] {
        let states = flight.heartbeats(node, Bus::Nominal).into_iter().filter(|(at, _)| *at > ms(300));
        let ends: Vec<Time> = states.clone().map(|(at, _)| at).collect();
        assert!(states.into_iter().all(|(_, state)| state == OPERATIONAL), "node {node}");
        assert!(gaps(&ends).all(|gap| about(ms(250), ms(1)).contains(&gap)), "node {node}");
    }
    let strayed = flight.on(Bus::Redundant).filter(|seen| seen.sender < MASTER_AND_THREE.len());
    assert_eq!(strayed.count(), 0, "nobody has changed the bus");
    for (_, board) in flight.twin.boards() {
        assert_eq!(board.counters().system_resets, 0);
    }
    flight.assert_nothing_lost();
    (flight, guest)
}

/// Malformed frames that `node` has counted on `bus`, by telemetry 0120h and 0121h.
fn malformed(flight: &Flight, node: u8, bus: Bus) -> u16 {
    let losses = telemetry(flight, node, 0x0120 | bus as u16);
    u16::from_le_bytes([losses[2], losses[3]])
}

/// Verifies: ECSS 11.1c
#[test]
fn foreign_and_remote_frames_are_acknowledged_and_filtered() {
    let frames = [
        extended(0x1234_5678, &[1, 2, 3, 4, 5, 6, 7, 8]),
        // 29-bit identifiers that begin like NMT, the master's heartbeat and a command to node 3.
        extended(0x000 << 18, &[0x81, 0]),
        extended(0x701 << 18, &[0x05]),
        extended(0x303 << 18, &[1, 0, 1]),
        remote(0x000, 2),
        remote(0x080, 0),
        remote(0x303, 3),
        remote(0x701, 1),
        remote(0x703, 1),
    ];
    for bus in Bus::ALL {
        let (flight, _) = undisturbed(bus, &frames);
        let side = if bus == Bus::Nominal { Side::Can1 } else { Side::Can2 };
        let stats = flight.emulated(3).can_stats(side);
        assert!(stats.rejected >= frames.len() as u64, "{stats:?}");
        for node in [2, 3, 4] {
            assert_eq!(malformed(&flight, node, bus), 0, "they never reach the software");
        }
    }
}

/// Returns malformed frames for slaves.
fn malformed_for_slaves() -> Vec<WireFrame> {
    vec![
        // NMT: too short, too long, unknown command, node above 127.
        WireFrame::standard(0x000, &[]),
        WireFrame::standard(0x000, &[0x81]),
        WireFrame::standard(0x000, &[0x81, 0, 0]),
        WireFrame::standard(0x000, &[0x83, 0]),
        WireFrame::standard(0x000, &[0x02, 128]),
        // Master heartbeat: empty, too long, unknown state.
        WireFrame::standard(0x701, &[]),
        WireFrame::standard(0x701, &[0x05, 0x05]),
        WireFrame::standard(0x701, &[0x33]),
    ]
}

/// PDOs that are too short, of every function that slaves consume; commands for slave 3.
fn malformed_pdos() -> Vec<WireFrame> {
    vec![
        WireFrame::standard(0x080, &[1, 2]),
        WireFrame::standard(0x181, &[0; 6]),
        WireFrame::standard(0x303, &[]),
        WireFrame::standard(0x303, &[1]),
        WireFrame::standard(0x403, &[1]),
    ]
}

/// Verifies: ECSS 6.5.1a
#[test]
fn malformed_frames_on_the_active_bus_are_ignored_and_counted() {
    let (for_all, pdos) = (malformed_for_slaves(), malformed_pdos());
    let (flight, _) = undisturbed(Bus::Nominal, &[for_all.clone(), pdos.clone()].concat());
    for (node, count) in [(2, for_all.len() + 2), (3, for_all.len() + pdos.len()), (4, for_all.len() + 2)] {
        assert_eq!(malformed(&flight, node, Bus::Nominal), count as u16, "node {node}");
        assert_eq!(malformed(&flight, node, Bus::Redundant), 0, "node {node}");
    }
}

/// Given malformed messages of the master on the other bus, then no slave follows them.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn malformed_frames_on_the_other_bus_call_nobody_there() {
    let frames = malformed_for_slaves();
    let (flight, _) = undisturbed(Bus::Redundant, &frames);
    for node in [2, 3] {
        assert_eq!(malformed(&flight, node, Bus::Redundant), frames.len() as u16, "node {node}");
    }
    assert_eq!(malformed(&flight, 4, Bus::Redundant), 0, "it does not listen there");
}

/// Given malformed frames with COB-IDs of slaves, then the master ignores them.
///
/// Verifies: ECSS 6.5.2a
#[test]
fn the_master_is_not_disturbed_by_malformed_frames_of_slaves() {
    let frames = [
        WireFrame::standard(0x703, &[]),
        WireFrame::standard(0x703, &[0x7F, 0x7F]),
        WireFrame::standard(0x703, &[0x21]),
        WireFrame::standard(0x700, &[0x05]),
        WireFrame::standard(0x383, &[]),
        WireFrame::standard(0x383, &[1]),
        WireFrame::standard(0x183, &[0; 3]),
        WireFrame::standard(0x380, &[1, 1, 0]),
    ];
    let (flight, _) = undisturbed(Bus::Nominal, &frames);
    let starts = flight.sent(MASTER, Bus::Nominal, 0x000).filter(|seen| seen.end > ms(300));
    assert_eq!(starts.count(), 0, "nobody is started again");
    let commands = flight.sent(MASTER, Bus::Nominal, 0x303).map(|seen| seen.end).collect::<Vec<_>>();
    assert!(gaps(&commands).all(|gap| about(ms(100), ms(1)).contains(&gap)), "{commands:?}");
}

/// Given unknown commands and requests, then they are no protocol errors. The application refuses and logs them.
#[test]
fn unknown_commands_are_declined() {
    let frames = [
        WireFrame::standard(0x303, &[0x77, 0x66, 1, 0, 0, 0, 0, 0]),
        WireFrame::standard(0x403, &[0x55, 0x44, 0, 0, 0, 0, 0, 0]),
    ];
    let (flight, _) = undisturbed(Bus::Nominal, &frames);
    flight.assert_said(3, "unknown command 6677h", ms(FROM_MS));
    flight.assert_said(3, "unknown telemetry request 4455h", ms(FROM_MS));
    assert_eq!(malformed(&flight, 3, Bus::Nominal), 0);
}

/// DLC 9 to 15 means 8 data bytes (ISO 11898-1).
///
/// Verifies: ECSS 7.2.2c
#[test]
fn a_data_length_code_above_8_is_8_bytes() {
    let value = WireFrame { dlc: 15, ..WireFrame::standard(0x303, &[2, 0, 1, 2, 3, 4, 5, 6]) };
    // A SYNC, and its spacecraft time in the first 7 of 8 bytes (CiA 301 7.2.2.1): 1000.5 s.
    let foreign = WireFrame::standard(0x080, &[]);
    let time = WireFrame { dlc: 9, ..WireFrame::standard(0x181, &[0, 0, 0x80, 0xE8, 3, 0, 0, 0]) };
    let (mut flight, _) = undisturbed(Bus::Nominal, &[value, foreign, time]);
    flight.assert_said(3, "unknown command 0002h", ms(FROM_MS));
    let set = flight.on(Bus::Nominal).find(|seen| seen.frame == foreign).unwrap().end;
    flight.fly_to(5100);
    let sync = flight.sent(MASTER, Bus::Nominal, 0x080).next().unwrap().end;
    let local = flight.sent(3, Bus::Nominal, 0x183).find(|seen| seen.end > sync).unwrap();
    let seconds = u32::from_le_bytes(local.data()[3..7].try_into().unwrap());
    let expected = 1000 + (sync.since(set).as_us() + 500_000) / 1_000_000;
    assert_eq!(u64::from(seconds), expected);
}
