//! Port over a driver of `embedded_can::nb`, on a driver that the test plays by hand.

mod chip;
mod followed;
mod random;

use std::task::Poll;

use async_canopen::link::Stamp;
use async_canopen::link::adapter::Mode;
use async_canopen::link::port::{Busy, CanPort, ErrorState, Filter, Health, LastError, Mailbox, PortEvent};
use async_canopen::types::{CobId, Instant};
use embedded_can::{ErrorKind, ExtendedId, Frame as _, StandardId};

use self::chip::{Bench, Own, Replaces};
use crate::bench::frame;

#[test]
fn port_sends_and_receives_nothing_before_it_joins() {
    let mut bench = Bench::off(3, Replaces::Lowest);
    bench.chip.borrow_mut().inbox.push_back(Ok(Own::of(&frame(0x80, &[]))));
    assert_eq!(bench.port.send(&frame(0x703, &[5])), Err(Busy));
    assert_eq!(bench.poll(), Poll::Pending);
    bench.port.join();
    assert_eq!(bench.poll(), Poll::Pending, "the frame of before is not kept");
    assert!(bench.port.send(&frame(0x703, &[5])).is_ok());
    assert_eq!(bench.chip.borrow().modes, [Mode::On]);
}

/// Given a driver without results, then a frame ends when the driver accepts it, at that instant.
#[test]
fn accepted_frame_ends_as_transmitted_and_frees_its_mailbox() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    assert!(bench.poll().is_pending());
    bench.was_woken();
    bench.at(700);
    let mailbox = bench.port.send(&frame(0x703, &[5])).unwrap();
    assert!(bench.was_woken(), "there is an end to take");
    let stamp = Stamp::interrupt(Instant::from_micros(700));
    assert_eq!(bench.events(), [PortEvent::Transmitted { mailbox, stamp }]);
    assert_eq!(bench.port.send(&frame(0x703, &[5])), Ok(mailbox));
}

#[test]
fn last_free_mailbox_is_for_urgent_frames() {
    let mut bench = Bench::joined(0, Replaces::Never);
    assert_eq!(bench.port.send(&frame(0x583, &[1])), Ok(Mailbox(0)));
    assert_eq!(bench.port.send(&frame(0x283, &[2])), Ok(Mailbox(1)));
    assert_eq!(bench.port.send(&frame(0x383, &[3])), Err(Busy));
    assert_eq!(bench.port.send(&frame(0x083, &[4])), Ok(Mailbox(2)));
    assert_eq!(bench.port.send(&frame(0x080, &[])), Err(Busy));
}

/// Given a full driver that replaces nothing, then a frame waits, and leaves when there is room.
#[test]
fn frame_waits_for_a_full_driver() {
    let mut bench = Bench::joined(1, Replaces::Never);
    let first = bench.port.send(&frame(0x583, &[1])).unwrap();
    assert_eq!(bench.transmitted(), [first.0]);
    let second = bench.port.send(&frame(0x183, &[2])).unwrap();
    assert_eq!(bench.events(), []);
    bench.wake_up.notify();
    assert!(bench.was_woken());
    assert_eq!(bench.chip.borrow_mut().sends(), Some(frame(0x583, &[1])));
    assert_eq!(bench.transmitted(), [second.0]);
    assert_eq!(bench.drained(), [frame(0x183, &[2])]);
}

#[test]
fn frames_of_one_cob_id_keep_their_order_in_front_of_a_full_driver() {
    let mut bench = Bench::joined(1, Replaces::Never);
    for number in 0..3 {
        bench.port.send(&frame(0x181, &[number])).unwrap();
        bench.events();
    }
    assert_eq!(bench.drained(), [0, 1, 2].map(|number| frame(0x181, &[number])));
}

/// Given a driver that gives up a frame for an urgent one, then that frame is handed over again, once, before a later frame of
/// its COB-ID, and has no second end.
#[test]
fn replaced_frame_is_handed_over_again() {
    let mut bench = Bench::joined(1, Replaces::Lowest);
    let first = bench.port.send(&frame(0x583, &[1])).unwrap();
    assert_eq!(bench.transmitted(), [first.0]);
    let urgent = bench.port.send(&frame(0x080, &[])).unwrap();
    assert_eq!(bench.transmitted(), [urgent.0]);
    let later = bench.port.send(&frame(0x583, &[2])).unwrap();
    assert_ne!(later, urgent, "its mailbox holds the frame that was given up");
    assert_eq!(bench.drained(), [frame(0x080, &[]), frame(0x583, &[1]), frame(0x583, &[2])]);
}

#[test]
fn replaced_frames_fill_the_mailboxes_and_none_is_lost() {
    let mut bench = Bench::joined(1, Replaces::Lowest);
    let ids = [0x181, 0x180, 0x100, 0x081, 0x080];
    let accepted = ids.map(|id| {
        let result = bench.port.send(&frame(id, &[]));
        bench.events();
        result.is_ok()
    });
    // One in the driver, three given back.
    assert_eq!(accepted, [true, true, true, true, false]);
    assert_eq!(bench.drained(), [0x081, 0x100, 0x180, 0x181].map(|id| frame(id, &[])));
}

/// Given a driver that gives up the most urgent frame, then handing over ends.
#[test]
fn driver_that_replaces_urgent_frames_does_not_hold_the_task() {
    let mut bench = Bench::joined(1, Replaces::Highest);
    bench.port.send(&frame(0x080, &[])).unwrap();
    bench.events();
    bench.port.send(&frame(0x181, &[])).unwrap();
    bench.events();
    assert!(bench.chip.borrow().attempts < 30, "{}", bench.chip.borrow().attempts);
}

/// Given a driver that fails, then the frame waits until it is aborted, and ends as failed.
#[test]
fn frame_of_a_failing_driver_waits_until_it_is_aborted() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    bench.chip.borrow_mut().failure = Some(ErrorKind::Acknowledge);
    let lost = bench.port.send(&frame(0x703, &[5])).unwrap();
    assert_eq!(bench.events(), []);
    assert_eq!(bench.port.health().last_error, LastError::Ack);
    bench.was_woken();
    bench.port.abort(lost);
    assert!(bench.was_woken(), "there is an end to take");
    assert_eq!(bench.events(), [PortEvent::Failed { mailbox: lost }]);
    let kept = bench.port.send(&frame(0x703, &[4])).unwrap();
    bench.chip.borrow_mut().failure = None;
    assert_eq!(bench.transmitted(), [kept.0]);
    assert_eq!(bench.drained(), [frame(0x703, &[4])]);
}

#[test]
fn frame_that_the_driver_accepted_is_not_aborted() {
    let mut bench = Bench::joined(1, Replaces::Lowest);
    let mailbox = bench.port.send(&frame(0x703, &[5])).unwrap();
    bench.port.abort(mailbox);
    assert_eq!(bench.transmitted(), [mailbox.0]);
    bench.port.abort(mailbox);
    assert_eq!(bench.events(), []);
}

/// Given a frame that waits and one that the driver gave back, when the port leaves, then neither leaves later.
#[test]
fn leaving_the_bus_drops_what_waits() {
    let mut bench = Bench::joined(1, Replaces::Lowest);
    for id in [0x583, 0x080] {
        bench.port.send(&frame(id, &[])).unwrap();
        bench.events();
    }
    let waiting = bench.port.send(&frame(0x283, &[])).unwrap();
    bench.port.leave();
    assert_eq!(bench.events(), [PortEvent::Failed { mailbox: waiting }]);
    assert_eq!(bench.drained(), [frame(0x080, &[])], "the driver has it");
    bench.port.listen();
    assert_eq!(bench.port.send(&frame(0x080, &[])), Err(Busy));
    assert_eq!(bench.chip.borrow().modes, [Mode::On, Mode::Off, Mode::Listening]);
}

#[test]
fn received_frames_pass_the_filters_in_order() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    bench.port.set_filters(&[Filter::exact(CobId::SYNC), Filter::exact(CobId::NMT)]);
    let other = Own::new_remote(StandardId::new(0x80).unwrap(), 0).unwrap();
    let long = Own::new(ExtendedId::new(0x80).unwrap(), &[]).unwrap();
    let own = [0x603, 0x80, 0x000].map(|id| Own::of(&frame(id, &[7])));
    bench.chip.borrow_mut().inbox.extend([other, long].into_iter().chain(own).map(Ok));
    bench.at(900);
    let stamp = Stamp::interrupt(Instant::from_micros(900));
    let received = |id| PortEvent::Received { frame: frame(id, &[7]), stamp };
    assert_eq!(bench.events(), [received(0x80), received(0x000)]);
    bench.port.set_filter(1, Filter::exact(CobId::new(0x603).unwrap()));
    bench.chip.borrow_mut().inbox.extend([0x000, 0x603].map(|id| Ok(Own::of(&frame(id, &[7])))));
    assert_eq!(bench.events(), [received(0x603)]);
}

#[test]
fn many_rejected_frames_let_other_tasks_run() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    bench.port.set_filters(&[Filter::exact(CobId::SYNC)]);
    let others = [0x603; 40].map(|id| Ok(Own::of(&frame(id, &[]))));
    bench.chip.borrow_mut().inbox.extend(others);
    assert!(bench.poll().is_pending());
    assert!(!bench.chip.borrow().inbox.is_empty());
    assert!(bench.was_woken(), "it goes on");
}

#[test]
fn overruns_and_errors_of_receive_are_reported() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    let good = || Ok(Own::of(&frame(0x80, &[])));
    bench.chip.borrow_mut().inbox.extend([Err(ErrorKind::Overrun), Err(ErrorKind::Crc)]);
    assert_eq!(bench.events(), [PortEvent::Overrun { lost: 1 }]);
    assert_eq!(bench.port.health().last_error, LastError::Crc);
    bench.chip.borrow_mut().inbox.push_back(good());
    assert_eq!(bench.events().len(), 1);
    assert_eq!(bench.port.health().last_error, LastError::None, "a transfer was successful");
}

/// Given a driver whose every call fails, then the task waits for the next interrupt.
#[test]
fn driver_that_always_fails_does_not_hold_the_task() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    bench.chip.borrow_mut().inbox.extend((0..100).map(|_| Err(ErrorKind::Other)));
    bench.was_woken();
    assert_eq!(bench.poll(), Poll::Pending);
    assert!(!bench.was_woken());
    assert!(bench.chip.borrow().inbox.len() > 90);
}

/// Given a driver that knows its error state, then passive, bus-off and the return are reported, and recovery is passed on.
#[test]
fn error_state_is_reported_when_it_changes() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    let passive = Health { state: ErrorState::Passive, tec: 128, rec: 3, last_error: LastError::Ack };
    let off = Health { state: ErrorState::BusOff, tec: 255, ..passive };
    for health in [passive, off, Health::default()] {
        bench.chip.borrow_mut().health = Some(health);
        bench.wake_up.notify();
        assert_eq!(bench.events(), [PortEvent::Health(health)]);
        assert_eq!(bench.port.health(), health);
    }
    // Counters alone are no event.
    let counted = Health { tec: 8, ..Health::default() };
    bench.chip.borrow_mut().health = Some(counted);
    assert_eq!(bench.events(), []);
    assert_eq!(bench.port.health(), counted);
    bench.port.recover();
    assert_eq!(bench.chip.borrow().recoveries, 1);
}

#[test]
fn error_state_is_reported_after_a_frame_that_came_with_it() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    let off = Health { state: ErrorState::BusOff, ..Health::default() };
    bench.chip.borrow_mut().health = Some(off);
    bench.chip.borrow_mut().inbox.push_back(Ok(Own::of(&frame(0x80, &[]))));
    let events = bench.events();
    assert!(matches!(events[..], [PortEvent::Received { .. }, PortEvent::Health(health)] if health == off));
}

#[test]
fn interrupt_wakes_the_task_that_polled() {
    let mut bench = Bench::joined(3, Replaces::Lowest);
    assert!(bench.poll().is_pending());
    assert!(!bench.was_woken());
    bench.wake_up.notify();
    assert!(bench.was_woken());
}
