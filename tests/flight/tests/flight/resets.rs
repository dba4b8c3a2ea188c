//! Boards that restart during a flight: by reset, loss of power, or command.

use can_twin::spacecraft::{Bus, Event};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// Returns the time of the boot-up message of `node` on `bus` after `from`.
fn boot_up(flight: &Flight, node: u8, bus: Bus, from: Time) -> Option<Time> {
    flight.heartbeats(node, bus).into_iter().find(|(at, s)| *at > from && *s == BOOT_UP).map(|(at, _)| at)
}

/// Returns the longest time between two commands to `node` on `bus` after `from`.
fn longest_pause(flight: &Flight, node: u8, bus: Bus, from: Time) -> Time {
    let commands = flight.sent(MASTER, bus, 0x300 + u16::from(node)).map(|seen| seen.end);
    let ends: Vec<Time> = commands.filter(|at| *at > from).chain([flight.end]).collect();
    gaps(&ends).max().unwrap()
}

/// Verifies: ECSS 8.3.2a, 6.5.3a
#[test]
fn the_master_is_reset_and_its_slaves_fly_on() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(1000);
    flight.reset(MASTER);
    flight.fly_to(2500);
    let booted = boot_up(&flight, MASTER, Bus::Nominal, ms(1000)).unwrap();
    // Its program is checked for 11.4 ms and starts after 18.3 ms, its node is Operational 3.0 ms later.
    assert!(booted < ms(1022), "{} us", booted.as_us());
    flight.assert_kept_running([2, 3, 4], ms(300));
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    for node in [2, 3, 4] {
        // After its reset the master knows a slave only from the next heartbeat of that slave.
        let pause = longest_pause(&flight, node, Bus::Nominal, ms(900));
        assert!(pause < ms(100 + 10 + 250 + 100), "node {node}: {} us", pause.as_us());
    }
    assert_eq!(flight.on(Bus::Redundant).count(), 0);
    flight.assert_sound();
}

/// Verifies: ECSS 6.5.3a, 8.3.2a, 8.3.3g
#[test]
fn master_reset_takes_it_and_its_slaves_to_the_default_bus() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(1000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(1500);
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.twin.wire_mut(Bus::Nominal).restore_all();
    flight.reset(MASTER);
    flight.fly_to(2500);
    let booted = boot_up(&flight, MASTER, Bus::Nominal, ms(1500)).unwrap();
    for node in [2, 3] {
        let followed =
            flight.heartbeats(node, Bus::Nominal).into_iter().find(|(at, _)| *at > booted).unwrap();
        assert_eq!(followed.1, OPERATIONAL);
        assert!(followed.0 < booted + ms(1), "node {node}: {} us", followed.0.as_us());
        let commands = flight.sent(MASTER, Bus::Nominal, 0x300 + u16::from(node));
        assert!(commands.filter(|seen| seen.end > booted).count() >= 8, "node {node}");
    }
    flight.assert_operational([2, 3], Bus::Nominal);
    flight.assert_sound();
}

/// Given a slave, when it restarts by its reset pin or after half a second without power, then the master starts it
/// again.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.3a, 8.3.2a
#[test]
fn a_slave_that_starts_again_is_taken_back() {
    for (events, from) in [
        (vec![(1000, Event::Reset)], 1000),
        (vec![(1000, Event::Power(false)), (1500, Event::Power(true))], 1500),
    ] {
        println!("{events:?}");
        let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
        let board = flight.board(3);
        for (at, event) in &events {
            flight.twin.schedule(ms(*at), board, *event);
        }
        flight.fly_to(from + 1500);
        let booted = boot_up(&flight, 3, Bus::Nominal, ms(1000)).unwrap();
        assert!(booted > ms(from) && booted < ms(from + 15), "{events:?}: {} us", booted.as_us());
        let said = flight.heartbeats(3, Bus::Nominal).into_iter().filter(|(at, _)| *at >= booted);
        let states: Vec<u8> = said.map(|(_, state)| state).collect();
        assert_eq!(states[..2], [BOOT_UP, OPERATIONAL], "{events:?}");
        assert!(states[1..].iter().all(|state| *state == OPERATIONAL), "{events:?}");
        flight.assert_operational([3], Bus::Nominal);
        assert!(longest_pause(&flight, 3, Bus::Nominal, booted) < ms(110), "{events:?}");
        flight.assert_kept_running([2], ms(300));
        assert!(longest_pause(&flight, 2, Bus::Nominal, ms(300)) < ms(101), "{events:?}");
        assert_eq!(flight.on(Bus::Redundant).count(), 0, "{events:?}");
        flight.assert_sound();
    }
}

/// A flight with a module control command of a foreign controller to node 3: when it was sent, and the states that node 3 then reports.
fn commanded(command: u8) -> (Flight, Time, Vec<u8>) {
    after(WireFrame::standard(0x000, &[command, 3]))
}

/// Flies as [`commanded`] with any frame of a foreign controller.
fn after(frame: WireFrame) -> (Flight, Time, Vec<u8>) {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.twin.inject(guest, ms(1050), frame);
    flight.fly_to(1800);
    let sent = flight.first_after(ms(1050), |seen| seen.sender == guest.node).unwrap().end;
    let said = flight.heartbeats(3, Bus::Nominal).into_iter().filter(|(at, _)| *at > sent);
    let states = said.map(|(_, state)| state).collect();
    flight.assert_kept_running([2, 4], ms(300));
    flight.assert_operational([2, 4], Bus::Nominal);
    flight.assert_sound();
    (flight, sent, states)
}

/// Given a slave, when it is commanded to reset, then Reset Node resets its chip, and Reset Communication restarts its
/// node without a chip reset.
///
/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 6.5.3a
#[test]
fn reset_node_resets_the_chip_and_reset_communication_does_not() {
    for (command, chip_resets, within_ms) in [(0x81, 1, 15), (0x82, 0, 1)] {
        println!("{command:02X}h");
        let (flight, sent, states) = commanded(command);
        for text in ["reset by the master", "slave 3 starts"].into_iter().filter(|_| chip_resets == 1) {
            flight.assert_said(3, text, sent);
        }
        assert_eq!(flight.emulated(3).counters().system_resets, chip_resets, "{command:02X}h");
        assert_eq!(states[..2], [BOOT_UP, OPERATIONAL], "{command:02X}h: {states:?}");
        let booted = boot_up(&flight, 3, Bus::Nominal, sent).unwrap();
        assert!(booted < sent + ms(within_ms), "{command:02X}h: {} us", booted.since(sent).as_us());
        flight.assert_operational([3], Bus::Nominal);
    }
}

/// Given a client that commands the master to stop node 3 (1F82h: 4), then node 3 stays stopped and sends only
/// heartbeats.
///
/// Verifies: ECSS 6.5.1a.2, 6.5.4a
#[test]
fn stopped_slave_stays_stopped_and_sends_only_heartbeats() {
    let (flight, sent, states) = after(WireFrame::standard(0x601, &[0x2F, 0x82, 0x1F, 3, 4, 0, 0, 0]));
    assert!(states.len() >= 3 && states.iter().all(|state| *state == STOPPED), "{states:?}");
    let others = flight.frames.iter().filter(|seen| seen.sender == 2 && seen.end > sent);
    assert!(others.into_iter().all(|seen| seen.id() == Some(0x703)));
    let commands = flight.sent(MASTER, Bus::Nominal, 0x303).filter(|seen| seen.end > sent + ms(1));
    assert_eq!(commands.count(), 0, "the master commands slaves that are operational");
}

/// Given a slave that a foreign node has stopped or sent to Pre-operational, then the master starts it again.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 8.3.3f
#[test]
fn a_slave_that_a_foreign_command_stopped_is_started() {
    for (command, state) in [(0x02, STOPPED), (0x80, PRE_OPERATIONAL)] {
        println!("{command:02X}h");
        let (flight, sent, states) = commanded(command);
        assert_eq!(states[..2], [state, OPERATIONAL], "{command:02X}h: {states:?}");
        let start = flight.first_after(sent, |seen| seen.id() == Some(0) && seen.data() == [1, 3]).unwrap();
        // A slave in Pre-operational is started at once.
        let is_prompt = state == STOPPED || (start.sender == 0 && start.end < sent + ms(1));
        assert!(is_prompt, "{command:02X}h: {start:?}");
        flight.assert_operational([3], Bus::Nominal);
    }
}
