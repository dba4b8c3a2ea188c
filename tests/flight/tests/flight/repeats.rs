//! Commands that CAN delivers more than once: every command is executed once.
//!
//! A transmitter that detects an error in the last bit of EOF repeats the frame, which its receivers have already
//! accepted (ISO 11898-1, 10.7 and 13.4.3).

use can_twin::spacecraft::Bus;
use can_twin::wire::fault::{Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use flight::*;

const COMMAND_TO_TWO: u16 = 0x302;

/// Disturbs the last bit of EOF of the frame that `sender` transmits at `at`, as the sender sees it.
fn disturb_end(flight: &mut Flight, bus: Bus, sender: usize, at: Time) {
    let flip = Flip::new(Place::Field(Field::Eof(6)), Nodes::of(&[sender]));
    flight.twin.wire_mut(bus).schedule(at, Fault::Flip(flip)).unwrap();
}

/// Commands to slave 2 that the master repeated after slave 2 had received them.
fn repeated(flight: &Flight) -> usize {
    let two = flight.board(2).0;
    let was_received = |record: &Observation| match record {
        Observation::Destroyed { frame, receivers, .. } => {
            frame.id == WireId::Standard(COMMAND_TO_TWO) && receivers.iter().any(|(node, _)| *node == two)
        }
        Observation::ReceivedLate { frame, node, .. } => {
            frame.id == WireId::Standard(COMMAND_TO_TWO) && *node == two
        }
        _ => false,
    };
    flight.records.iter().filter(|wire| was_received(&wire.record)).count()
}

/// Given ten commands of the master, each disturbed twice in the last bit of EOF at the master
/// When each is received three times
/// Then each is executed once, and the repeats are counted.
#[test]
fn a_command_repeated_after_its_eof_is_executed_once() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(1000);
    let master = flight.board(MASTER).0;
    let is_command = |seen: &Seen| seen.id() == Some(COMMAND_TO_TWO);
    for _ in 0..10 {
        let next = flight.fly_until(is_command).start + ms(100);
        // In the frame, and in its first repetition: a frame of 8 bytes lasts 111 to 130 bits, an error 20. Either may wait
        // for another frame.
        let (disturbed, mut inside) = (repeated(&flight) + 2, next + Time::from_us(60));
        while repeated(&flight) < disturbed && inside < next + ms(1) {
            disturb_end(&mut flight, Bus::Nominal, master, inside);
            inside += Time::from_us(140);
            flight.fly(inside);
        }
        flight.fly(next + ms(2));
    }
    flight.fly(flight.end + ms(50));
    assert_eq!(repeated(&flight), 20, "ten commands, twice each");
    let sent = flight.sent(MASTER, Bus::Nominal, COMMAND_TO_TWO).count();
    assert_eq!(flight.executed(2) as usize, sent);
    assert_eq!(flight.repeats(2), 20);
    assert_eq!((flight.repeats(3), flight.repeats(4)), (0, 0));
    flight.assert_nothing_lost();
}

/// Given a slave that has executed a command on the nominal bus
/// When the bus changes and the command arrives again on the redundant one, within its lifetime
/// Then it is dropped, and a command with the next sequence is executed.
#[test]
fn a_repeat_on_the_other_bus_is_dropped() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Redundant);
    flight.fly_to(1000);
    let command = flight.fly_until(|seen| seen.id() == Some(COMMAND_TO_TWO));
    let mut next = command.frame;
    next.data[7] = next.data[7].wrapping_add(1);
    for (after_us, frame) in
        [(500, WireFrame::standard(0x701, &[OPERATIONAL])), (1000, command.frame), (1500, next)]
    {
        flight.twin.inject(guest, command.end + Time::from_us(after_us), frame);
    }
    flight.fly(command.end + Time::from_us(400));
    let before = flight.executed(2);
    flight.fly(command.end + ms(3));
    let followed =
        flight.first_after(command.end, |seen| seen.sender == guest.node && seen.frame == next).unwrap();
    assert!(followed.reached.contains(&2) && flight.said(2, "Redundant", command.end).is_some());
    assert_eq!((flight.executed(2) - before, flight.repeats(2)), (1, 1), "{}", flight.log(2));
    flight.assert_sound();
}

/// Given telemetry requests of 2 to 8 bytes, zero behind the code
/// When they reach a slave
/// Then each is answered, and none is an error (ECSS Figure 9-2: DLC 0 to 8).
///
/// Verifies: ECSS 6.2a
#[test]
fn a_request_of_its_code_alone_is_answered() {
    const VALUE: [u8; 8] = [0x02, 0x01, 0, 0, 0, 0, 0, 0];
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.fly_to(1_055);
    for (bytes, at_ms) in (2..=8).zip((1_055..).step_by(3)) {
        flight.twin.inject(guest, ms(at_ms), WireFrame::standard(0x403, &VALUE[..bytes]));
    }
    flight.fly_to(1_095);
    let answers = flight.sent(3, Bus::Nominal, 0x383).filter(|seen| seen.end > ms(1_055));
    let codes: Vec<&[u8]> = answers.map(|seen| &seen.data()[..2]).collect();
    assert_eq!(codes, [[0x02, 0x01]; 7]);
    flight.fly_to(2_200);
    assert_eq!(flight.emergencies(3, ms(0)).count(), 0);
    assert_eq!(telemetry(&flight, 3, 0x0120), [0; 6], "nothing malformed");
    flight.assert_nothing_lost();
}
