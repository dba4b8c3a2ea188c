//! Two ports of one controller behind a transceiver switch (ECSS A.4.1), on a controller that the test plays by hand.
//!
//! Verifies: ECSS 8.2.1a.1, 8.2.3a

mod bench;

use std::task::Poll;

use async_canopen::link::port::{Busy, CanPort, Filter, Health, Mailbox, PortEvent};
use async_canopen::types::CobId;

use self::bench::Told::{Abort, Join, Leave, Listen, Recover, Select};
use self::bench::*;
use crate::bench::{NOMINAL, REDUNDANT, frame};

#[test]
fn port_that_joins_the_selected_bus_is_there_at_once() {
    let mut bench = Bench::new();
    bench.ports.nominal.join();
    assert_eq!(bench.told(), [Join]);
    assert_eq!(bench.ports.nominal.send(&frame(0x705, &[])), Ok(Mailbox(0)));
}

#[test]
fn controller_leaves_moves_and_joins_in_this_order() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    assert!(bench.was_woken(NOMINAL), "it moves the controller");
    bench.with(|chip| chip.is_silent = true);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    // It is told twice: its port leaves, and the other one needs it.
    assert_eq!(bench.told(), [Leave, Leave, Select(REDUNDANT), Join]);
    assert!(bench.was_woken(REDUNDANT), "it may have something to send");
    assert_eq!(bench.ports.redundant.send(&frame(0x705, &[])), Ok(Mailbox(0)));
}

/// The commands to two buses are for two tasks: either may be the first one.
#[test]
fn controller_moves_even_if_new_bus_is_joined_before_old_left() {
    let mut bench = Bench::joined();
    bench.ports.redundant.join();
    bench.ports.nominal.leave();
    bench.with(|chip| chip.is_silent = true);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Leave, Select(REDUNDANT), Join]);
    bench.ports.nominal.leave();
    assert_eq!(bench.told(), [], "it is elsewhere already");
    assert!(bench.ports.redundant.send(&frame(0x705, &[])).is_ok());
}

/// Verifies: ECSS 8.3.2a
#[test]
fn after_power_on_the_redundant_bus_may_be_the_first_one() {
    let mut bench = Bench::new();
    bench.ports.redundant.join();
    assert!(bench.was_woken(NOMINAL));
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Leave, Select(REDUNDANT), Join]);
}

#[test]
fn switch_waits_for_the_end_of_the_frame_on_the_wire() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), []);
    assert_eq!(bench.ports.redundant.send(&frame(0x705, &[])), Err(Busy));
    assert_eq!(bench.ports.nominal.send(&frame(0x705, &[])), Err(Busy));
    assert_eq!(bench.told(), []);
}

#[test]
fn events_of_a_bus_are_handed_out_there_before_the_switch_moves() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    let received = PortEvent::Received { frame: frame(0x701, &[5]), stamp: REPORTED };
    bench.happens(received);
    bench.happens(FAILED);
    bench.with(|chip| chip.is_silent = true);
    assert_eq!(bench.poll(REDUNDANT), Poll::Pending);
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(received));
    assert_eq!(bench.told(), []);
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(FAILED));
    assert_eq!(bench.told(), []);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Select(REDUNDANT), Join]);
    bench.happens(received);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.poll(REDUNDANT), Poll::Ready(received));
}

/// Given a controller that gets silent after it was asked for events, then its last one goes to the old bus, too.
#[test]
fn event_that_comes_with_silence_belongs_to_the_old_bus() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    bench.with(|chip| chip.last = Some(FAILED));
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(FAILED));
    assert_eq!(bench.told(), []);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Select(REDUNDANT), Join]);
}

#[test]
fn who_returns_before_the_controller_has_moved_keeps_it() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    bench.ports.nominal.join();
    bench.ports.redundant.leave();
    assert_eq!(bench.told(), [Join]);
    bench.with(|chip| chip.is_silent = true);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), []);
    assert!(bench.ports.nominal.send(&frame(0x705, &[])).is_ok());
    assert_eq!(bench.ports.redundant.send(&frame(0x705, &[])), Err(Busy));
}

#[test]
fn who_leaves_before_the_controller_has_come_is_not_joined() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.ports.redundant.leave();
    bench.told();
    bench.with(|chip| chip.is_silent = true);
    assert_eq!((bench.poll(NOMINAL), bench.poll(REDUNDANT)), (Poll::Pending, Poll::Pending));
    assert_eq!(bench.told(), []);
}

/// Verifies: ECSS 8.3.3b.1
#[test]
fn who_left_is_silent_and_sends_nothing() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    assert_eq!(bench.told(), [Leave]);
    assert_eq!(bench.ports.nominal.send(&frame(0x705, &[])), Err(Busy));
    bench.ports.nominal.recover();
    assert_eq!(bench.told(), []);
}

#[test]
fn port_without_the_controller_does_nothing_to_it() {
    let mut bench = Bench::moved();
    bench.ports.nominal.abort(Mailbox(0));
    bench.ports.nominal.recover();
    bench.ports.nominal.leave();
    assert_eq!(bench.ports.nominal.send(&frame(0x705, &[])), Err(Busy));
    assert_eq!(bench.ports.nominal.stamp(&frame(0x080, &[]), REPORTED), REPORTED);
    assert_eq!(bench.told(), []);
    bench.ports.redundant.abort(Mailbox(0));
    bench.ports.redundant.recover();
    assert_eq!(bench.ports.redundant.stamp(&frame(0x080, &[]), REPORTED), MEASURED);
    assert_eq!(bench.told(), [Abort(0), Recover]);
}

/// Given a bus-off controller, when the port of the selected bus recovers it, then the controller gets the command, on either bus.
///
/// Verifies: ECSS 5.6.2a
/// Notices: ECSS 5.6.2a: a controller is not recovered while the redundant bus is selected.
#[test]
fn port_with_the_controller_recovers_it_on_either_bus() {
    let mut nominal = Bench::joined();
    nominal.ports.nominal.recover();
    assert_eq!(nominal.told(), [Recover]);
    let mut redundant = Bench::moved();
    redundant.ports.redundant.recover();
    assert_eq!(redundant.told(), [Recover]);
}

/// A mailbox that is in use when its bus is left is still that of its bus.
#[test]
fn port_that_leaves_may_abort_its_mailbox() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    bench.ports.redundant.abort(Mailbox(0));
    assert_eq!(bench.told(), []);
    bench.ports.nominal.abort(Mailbox(0));
    assert_eq!(bench.told(), [Abort(0)]);
}

/// Verifies: ECSS 5.6.2c
/// Notices: ECSS 5.6.2c: the counters of the bus that was left are those of the other bus.
#[test]
fn health_is_live_on_joined_bus_and_last_known_on_the_other() {
    let mut bench = Bench::joined();
    bench.with(|chip| chip.health = PASSIVE);
    assert_eq!(bench.ports.nominal.health(), PASSIVE);
    assert_eq!(bench.ports.redundant.health(), Health::default());
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.with(|chip| chip.is_silent = true);
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    bench.with(|chip| chip.health = OFF);
    assert_eq!(bench.ports.nominal.health(), PASSIVE);
    assert_eq!(bench.ports.redundant.health(), OFF);
}

#[test]
fn filters_are_those_of_both_buses() {
    let mut bench = Bench::joined();
    let sync = Filter::exact(CobId::SYNC);
    bench.ports.nominal.set_filter(3, sync);
    bench.ports.redundant.set_filter(4, sync);
    assert_eq!(bench.told(), [Told::Filter(3), Told::Filter(4)]);
}

#[test]
fn port_may_listen_on_either_bus() {
    let mut bench = Bench::new();
    bench.ports.nominal.listen();
    assert_eq!(bench.told(), [Listen]);
    bench.ports.redundant.listen();
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Leave, Select(REDUNDANT), Listen]);
    bench.ports.redundant.join();
    assert_eq!(bench.told(), [Join]);
}

/// Given a bus that is dominant all the time, which lets no controller off, when the node goes to the other bus, then the
/// controller is moved as it is.
///
/// Verifies: ECSS 8.3.3b.2, 8.3.3e.2, 5.3.3.2.3e, 8.3.2b
/// Notices: ECSS 8.3.2b: a node with one controller does not listen on the other bus while its own is dominant all the time.
/// Notices: ECSS 8.3.3b.2: a node with one controller does not get away from a bus that is dominant all the time.
/// Notices: ECSS 8.3.3e.2: a node with one controller does not get away from a bus that is dominant all the time.
/// Notices: ECSS 5.3.3.2.3e: a node with one controller does not get away from a shorted bus.
#[test]
fn always_dominant_bus_does_not_keep_the_controller() {
    let mut bench = Bench::joined();
    bench.happens(PortEvent::Stalled);
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(PortEvent::Stalled), "it does not get on the bus");
    bench.ports.nominal.leave();
    bench.ports.redundant.join();
    bench.told();
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [], "it was given no time to get off");
    bench.happens(PortEvent::Stalled);
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(PortEvent::Stalled));
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Select(REDUNDANT), Join]);
}

/// The same when it was first left, and the other bus chosen later.
///
/// Verifies: ECSS 8.3.3b.2, 8.3.3e.2
#[test]
fn controller_that_did_not_get_off_before_is_moved_at_once() {
    let mut bench = Bench::joined();
    bench.ports.nominal.leave();
    bench.happens(PortEvent::Stalled);
    assert_eq!(bench.poll(NOMINAL), Poll::Ready(PortEvent::Stalled));
    bench.told();
    bench.ports.redundant.join();
    assert_eq!(bench.poll(NOMINAL), Poll::Pending);
    assert_eq!(bench.told(), [Leave, Select(REDUNDANT), Join]);
    bench.ports.redundant.leave();
    bench.ports.nominal.join();
    bench.told();
    assert_eq!(bench.poll(REDUNDANT), Poll::Pending);
    assert_eq!(bench.told(), [], "the other bus has its own time");
}
