//! Commands that CAN delivers more than once, and masters that start again: every command is executed once.
//!
//! A transmitter that sees an error in the last bit of EOF repeats a frame that its receivers have already
//! (ISO 11898-1, 10.7 and 13.4.3).

use can_wire::fault::{Fault, Flip, Nodes, Place};
use can_wire::field::Field;
use can_wire::frame::{WireFrame, WireId};
use can_wire::record::Observation;
use can_wire::time::Time;
use twin::spacecraft::{BoardId, Bus};

use flight::*;

const COMMAND_TO_TWO: u16 = 0x302;

/// Disturbs the last bit of EOF of the frame that `sender` transmits at `at`, as the sender sees it.
fn disturb_end(craft: &mut Craft, bus: Bus, sender: usize, at: Time) {
    let flip = Flip::new(Place::Field(Field::Eof(6)), Nodes::of(&[sender]));
    craft.twin.wire_mut(bus).schedule(at, Fault::Flip(flip)).unwrap();
}

/// Commands to slave 2 that the master repeated after slave 2 had received them.
fn repeated(craft: &Craft) -> usize {
    let two = craft.board(2).0;
    let was_received = |record: &Observation| match record {
        Observation::Destroyed { frame, receivers, .. } => {
            frame.id == WireId::Standard(COMMAND_TO_TWO) && receivers.iter().any(|(node, _)| *node == two)
        }
        _ => false,
    };
    craft.records.iter().filter(|wire| was_received(&wire.record)).count()
}

/// Given ten commands of the master, each disturbed twice in the last bit of EOF at the master
/// When each is received three times
/// Then each is executed once, and the repeats are counted.
#[test]
fn a_command_repeated_after_its_eof_is_executed_once() {
    let mut craft = Craft::new(&MASTER_AND_THREE);
    craft.fly_to(1000);
    let master = craft.board(MASTER).0;
    let is_command = |seen: &Seen| seen.id() == Some(COMMAND_TO_TWO);
    for _ in 0..10 {
        let next = craft.fly_until(is_command).start + ms(100);
        // In the frame, and in its first repetition: a frame of 8 bytes lasts 111 to 130 bits, an error 20.
        disturb_end(&mut craft, Bus::Nominal, master, next + Time::from_us(60));
        disturb_end(&mut craft, Bus::Nominal, master, next + Time::from_us(200));
        craft.fly(next + ms(2));
    }
    craft.fly(craft.end + ms(50));
    assert_eq!(repeated(&craft), 20, "ten commands, twice each");
    let sent = craft.sent(MASTER, Bus::Nominal, COMMAND_TO_TWO).count();
    assert_eq!(craft.executed(2) as usize, sent);
    assert_eq!(craft.repeats(2), 20);
    assert_eq!((craft.repeats(3), craft.repeats(4)), (0, 0));
    craft.assert_nothing_lost();
}

/// Given a slave that has executed a command on the nominal bus
/// When the bus changes and the command arrives again on the redundant one, within its lifetime
/// Then it is dropped, and a command with the next sequence is executed.
#[test]
fn a_repeat_on_the_other_bus_is_dropped() {
    let mut craft = Craft::new(&MASTER_AND_THREE);
    let guest = craft.twin.add_guest(Bus::Redundant, 30.0);
    craft.fly_to(1000);
    let command = craft.fly_until(|seen| seen.id() == Some(COMMAND_TO_TWO));
    let mut next = command.frame;
    next.data[7] = next.data[7].wrapping_add(1);
    for (after_us, frame) in
        [(500, WireFrame::standard(0x701, &[OPERATIONAL])), (1000, command.frame), (1500, next)]
    {
        craft.twin.inject(guest, command.end + Time::from_us(after_us), frame);
    }
    craft.fly(command.end + Time::from_us(400));
    let before = craft.executed(2);
    craft.fly(command.end + ms(3));
    let followed =
        craft.first_after(command.end, |seen| seen.sender == guest.node && seen.frame == next).unwrap();
    assert!(followed.reached.contains(&2) && craft.said(2, "Redundant", command.end).is_some());
    assert_eq!((craft.executed(2) - before, craft.repeats(2)), (1, 1), "{}", craft.log(2));
    craft.assert_sound();
}

/// Commands to `node` on both buses and of all masters.
fn commands(craft: &Craft, node: u8) -> Vec<&Seen> {
    craft.frames.iter().filter(|seen| seen.id() == Some(0x300 + u16::from(node))).collect()
}

/// Slave 15 has its turn just before the end of the master's period: the first command of a master can follow that of its
/// predecessor by less than a lifetime.
const LAST: Seat = Seat { node: 15, ..MASTER_AND_THREE[2] };

/// Given a master that is reset right after its first command
/// When it commands again
/// Then no command is lost: none is taken for a repeat of the one before.
#[test]
fn a_master_reset_after_its_first_command_loses_none() {
    let mut craft = Craft::with(&[MASTER_AND_THREE[0], LAST], &STANDARD);
    let first = craft.fly_until(|seen| seen.id() == Some(0x30F));
    let master = craft.board(MASTER);
    craft.twin.reset(master);
    craft.fly(first.end + ms(1_000));
    let sent = commands(&craft, 15);
    assert_eq!(sent[1].frame, first.frame, "the first command again, byte by byte");
    assert!(sent.len() >= 8, "{} commands", sent.len());
    craft.fly(craft.end + ms(5));
    assert_eq!((craft.executed(15) as usize, craft.repeats(15)), (commands(&craft, 15).len(), 0));
    craft.assert_sound();
}

/// Given a master that loses its power right after its first command
/// When another one gets power at once
/// Then no command of it is lost.
#[test]
fn another_master_loses_no_command() {
    let spare = Seat { power_on_ms: 3_600_000, ppm: -7.0, position_m: 6.0, ..MASTER_AND_THREE[0] };
    let mut craft = Craft::with(&[MASTER_AND_THREE[0], LAST, spare], &STANDARD);
    let first = craft.fly_until(|seen| seen.id() == Some(0x30F));
    craft.twin.power(BoardId(0), false);
    craft.twin.power(BoardId(2), true);
    craft.fly(first.end + ms(1_000));
    let sent = commands(&craft, 15);
    assert_eq!((sent[1].sender, sent[1].frame), (2, first.frame), "of another master, byte by byte");
    assert!(sent.len() >= 8, "{} commands", sent.len());
    craft.fly(craft.end + ms(5));
    assert_eq!((craft.executed(15) as usize, craft.repeats(15)), (commands(&craft, 15).len(), 0));
}

/// Given telemetry requests of 2 to 8 bytes, zero behind the code
/// When they reach a slave
/// Then each is answered, and none is an error (ECSS Figure 9-2: DLC 0 to 8).
#[test]
fn a_request_of_its_code_alone_is_answered() {
    const VALUE: [u8; 8] = [0x02, 0x01, 0, 0, 0, 0, 0, 0];
    let mut craft = Craft::new(&MASTER_AND_THREE);
    let guest = craft.twin.add_guest(Bus::Nominal, 30.0);
    craft.fly_to(1_045);
    for (bytes, at_ms) in (2..=8).zip((1_045..).step_by(3)) {
        craft.twin.inject(guest, ms(at_ms), WireFrame::standard(0x403, &VALUE[..bytes]));
    }
    craft.fly_to(1_095);
    let answers = craft.sent(3, Bus::Nominal, 0x383).filter(|seen| seen.end > ms(1_045));
    let codes: Vec<&[u8]> = answers.map(|seen| &seen.data()[..2]).collect();
    assert_eq!(codes, [[0x02, 0x01]; 7]);
    craft.fly_to(2_200);
    assert_eq!(craft.sent(3, Bus::Nominal, 0x083).count(), 0, "no emergency");
    assert_eq!(telemetry(&craft, 3, 0x0120), [0; 6], "nothing malformed");
    craft.assert_nothing_lost();
}
