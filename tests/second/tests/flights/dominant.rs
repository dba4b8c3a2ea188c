//! A bus that is dominant for a short time while a slave has a report. A guest is the master.

use can_twin::spacecraft::Bus;
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

const SLAVE: u8 = 2;

/// Returns a flight with slave 2, Operational at 1 s. A guest starts it, and sends the master's heartbeat every 250 ms
/// and these SDO requests.
fn flown(until: u64, requests: &[(u64, [u8; 8])]) -> Flight {
    let (mut flight, guest) = Flight::with_guest(&[MASTER_AND_THREE[1]], Bus::Nominal);
    let heartbeats = (100..until).step_by(250).map(|at| (at, WireFrame::standard(0x701, &[OPERATIONAL])));
    let requests =
        requests.iter().map(|(at, data)| (*at, WireFrame::standard(0x600 + u16::from(SLAVE), data)));
    let start = (700, WireFrame::standard(0x000, &[1, SLAVE]));
    let mut frames: Vec<_> = heartbeats.chain([start]).chain(requests).collect();
    frames.sort_by_key(|(at, _)| *at);
    for (at, frame) in frames {
        flight.twin.inject(guest, ms(at), frame);
    }
    flight.fly_to(1_000);
    flight.assert_operational([SLAVE], Bus::Nominal);
    flight
}

/// Makes the bus dominant from `at` on for `span`.
fn hold_dominant(flight: &mut Flight, at: Time, span: Time) {
    let wire = flight.twin.wire_mut(Bus::Nominal);
    wire.schedule(at, Fault::Short { position_m: 1.0, level: false }).unwrap();
    wire.schedule(at + span, Fault::ClearShorts).unwrap();
}

/// Returns the data of the slave's frames with this identifier that ended after `from`.
fn sent(flight: &Flight, id: u16, from: Time) -> Vec<Vec<u8>> {
    let later = flight.sent(SLAVE, Bus::Nominal, id).filter(|seen| seen.end > from);
    later.map(|seen| seen.data().to_vec()).collect()
}

/// Given a bus that is dominant for 0.05, 0.3 and 0.9 s, then the slave reports error passive and its end once and in
/// this order, or neither of them if the error had ended before the first message could be sent. Its history has each.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn the_end_of_an_error_on_a_dominant_bus_is_never_reported_alone() {
    const SHORTS: [(u64, u64); 3] = [(1_100, 50), (4_100, 300), (7_100, 900)];
    const NEWEST: [u8; 8] = [0x40, 0x03, 0x10, 1, 0, 0, 0, 0];
    let mut flight = flown(11_000, &SHORTS.map(|(at, span)| (at + span + 1_500, NEWEST)));
    for (at, span) in SHORTS {
        hold_dominant(&mut flight, ms(at), ms(span));
        flight.fly_to(at + span + 2_000);
        let messages = sent(&flight, 0x082, ms(at));
        let kinds: Vec<&[u8]> = messages.iter().map(|data| &data[..2]).collect();
        let is_paired = kinds.is_empty() || kinds == [[0x20, 0x81], [0, 0]];
        assert!(is_paired, "{span} ms: {messages:02X?}");
        let newest = sent(&flight, 0x580 + u16::from(SLAVE), ms(at));
        assert_eq!(newest, [[0x43, 0x03, 0x10, 1, 0x20, 0x81, 0, 0]], "{span} ms");
    }
    flight.assert_sound();
}

/// Given a PDO that is sent on events and is no state, when the bus is dominant for 0.7 s at the time of its frame,
/// then the slave does not send it later. Its application gets the unsent value.
#[test]
fn the_application_is_told_which_event_a_dominant_bus_took() {
    // TPDO 5: value 6210h, inhibit time 500 ms.
    const CONFIGURATION: [[u8; 8]; 6] = [
        [0x23, 0x04, 0x18, 1, 0xE2, 0x03, 0x00, 0xC0],
        [0x2F, 0x04, 0x1A, 0, 0, 0, 0, 0],
        [0x23, 0x04, 0x1A, 1, 0x20, 0x00, 0x10, 0x62],
        [0x2F, 0x04, 0x1A, 0, 1, 0, 0, 0],
        [0x2B, 0x04, 0x18, 3, 0x88, 0x13, 0, 0],
        [0x23, 0x04, 0x18, 1, 0xE2, 0x03, 0x00, 0x40],
    ];
    const VALUES: [[u8; 8]; 2] = [[0x23, 0x10, 0x62, 0, 0x11, 0, 0, 0], [0x23, 0x10, 0x62, 0, 0x22, 0, 0, 0]];
    let requests = CONFIGURATION.into_iter().chain(VALUES);
    let times = (1_010..).step_by(10).take(CONFIGURATION.len()).chain([1_200, 1_300]);
    let mut flight = flown(6_000, &times.zip(requests).collect::<Vec<_>>());
    hold_dominant(&mut flight, ms(1_400), ms(700));
    flight.fly_to(5_000);
    let answers = sent(&flight, 0x580 + u16::from(SLAVE), ms(1_000));
    assert!(answers.len() == 8 && answers.iter().all(|answer| answer[0] == 0x60), "{answers:02X?}");
    assert_eq!(sent(&flight, 0x3E2, ms(1_000)), [[0x11, 0, 0, 0]]);
    flight.assert_said(SLAVE, "3E2h not sent on Nominal: [22, 00", ms(1_400));
    flight.assert_sound();
}
