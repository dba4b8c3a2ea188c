//! Masters that restart: no command is lost, and none is executed twice.

use can_twin::spacecraft::BoardId;
use flight::*;

/// Flies on for a second. The next command to slave 15 comes from board `sender` and is equal to the first one; each command is executed.
fn assert_none_lost(flight: &mut Flight, first: &Seen, sender: usize) {
    flight.fly(first.end + ms(1_000));
    let sent: Vec<&Seen> = flight.with_id(COMMAND).collect();
    assert_eq!(
        (sent[1].sender, sent[1].frame),
        (sender, first.frame),
        "the first command again, byte by byte"
    );
    assert!(sent.len() >= 8, "{} commands", sent.len());
    flight.fly(flight.end + ms(5));
    assert_eq!((flight.executed(15) as usize, flight.repeats(15)), (flight.with_id(COMMAND).count(), 0));
}

/// Commands to slave 15.
const COMMAND: u16 = 0x30F;

/// Slave 15 has its turn just before the end of the master's period: the first command of a master can follow that of its
/// predecessor by less than a lifetime.
const LAST: BoardSetup = BoardSetup { node: 15, ..MASTER_AND_THREE[2] };

/// Given a master that is reset right after its first command
/// When it commands again
/// Then no command is lost: none is taken for a repeat of the one before.
#[test]
fn a_master_reset_after_its_first_command_loses_none() {
    let mut flight = Flight::with(&[MASTER_AND_THREE[0], LAST], &STANDARD);
    let first = flight.fly_until(|seen| seen.id() == Some(COMMAND));
    flight.reset(MASTER);
    assert_none_lost(&mut flight, &first, 0);
    flight.assert_sound();
}

/// Given a master that loses its power right after its first command
/// When another one gets power at once
/// Then no command of it is lost.
#[test]
fn another_master_loses_no_command() {
    let spare = BoardSetup { power_on_ms: 3_600_000, ppm: -7.0, position_m: 6.0, ..MASTER_AND_THREE[0] };
    let mut flight = Flight::with(&[MASTER_AND_THREE[0], LAST, spare], &STANDARD);
    let first = flight.fly_until(|seen| seen.id() == Some(COMMAND));
    flight.twin.power(BoardId(0), false);
    flight.twin.power(BoardId(2), true);
    assert_none_lost(&mut flight, &first, 2);
}
