//! Port over a driver that reports the end of each transmission.

use std::cell::RefCell;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use async_canopen::link::Stamp;
use async_canopen::link::adapter::{Accepted, Adapter, Driver, Received, Refused};
use async_canopen::link::port::{CanPort, Filter, LastError, Mailbox, PortEvent};
use async_canopen::types::{CobId, Frame, Instant};

use crate::bench::frame;

/// Mailboxes of the controller, and the commands that it received.
#[derive(Default)]
struct Chip {
    places: [Option<Frame>; 2],
    /// The driver can abort a frame.
    aborts: bool,
    /// The next frame goes into the first place, whose frame is given up.
    replaces: bool,
    filters: Vec<Vec<Filter>>,
    received: Vec<Received>,
}

#[derive(Clone, Default)]
struct Following(Rc<RefCell<Chip>>);

impl Driver for Following {
    fn transmit(&mut self, frame: &Frame, _: &mut Context<'_>) -> Result<Accepted, Refused> {
        let chip = &mut *self.0.borrow_mut();
        let replaced = std::mem::take(&mut chip.replaces);
        let free = (0..).zip(&mut chip.places).find(|(_, place)| replaced || place.is_none());
        let (place, mailbox) = free.ok_or(Refused::Full)?;
        *mailbox = Some(*frame);
        Ok(Accepted::Followed { place, replaced })
    }

    fn poll_receive(&mut self, _: &mut Context<'_>) -> Poll<Received> {
        self.0.borrow_mut().received.pop().map_or(Poll::Pending, Poll::Ready)
    }

    fn now(&self) -> Instant {
        Instant::from_micros(42)
    }

    fn poll_sent(&mut self, place: u8, _: &mut Context<'_>) -> Poll<()> {
        if self.0.borrow().places[usize::from(place)].is_none() { Poll::Ready(()) } else { Poll::Pending }
    }

    fn abort(&mut self, place: u8) -> bool {
        let chip = &mut *self.0.borrow_mut();
        chip.aborts && chip.places[usize::from(place)].take().is_some()
    }

    fn set_filters(&mut self, filters: &[Filter]) {
        self.0.borrow_mut().filters.push(filters.to_vec());
    }
}

struct Bench {
    port: Adapter<Following>,
    chip: Rc<RefCell<Chip>>,
}

impl Bench {
    fn new() -> Bench {
        let driver = Following::default();
        let chip = driver.0.clone();
        let mut port = Adapter::new(driver);
        port.join();
        Bench { port, chip }
    }

    fn send(&mut self, id: u16) -> Mailbox {
        self.port.send(&frame(id, &[])).unwrap()
    }

    /// The frame in this place of the driver leaves.
    fn leaves(&self, place: usize) {
        assert!(self.chip.borrow_mut().places[place].take().is_some());
    }

    fn poll(&mut self) -> Poll<PortEvent> {
        self.port.poll_event(&mut Context::from_waker(Waker::noop()))
    }
}

fn transmitted(mailbox: Mailbox) -> Poll<PortEvent> {
    Poll::Ready(PortEvent::Transmitted { mailbox, stamp: Stamp::interrupt(Instant::from_micros(42)) })
}

#[test]
fn followed_frame_ends_when_it_has_left() {
    let mut bench = Bench::new();
    let (first, second) = (bench.send(0x183), bench.send(0x283));
    assert_eq!(bench.poll(), Poll::Pending);
    bench.leaves(1);
    assert_eq!(bench.poll(), transmitted(second));
    bench.leaves(0);
    assert_eq!(bench.poll(), transmitted(first));
    assert_eq!(bench.poll(), Poll::Pending);
}

#[test]
fn followed_frame_is_aborted_unless_it_is_too_late() {
    let mut bench = Bench::new();
    let (first, second) = (bench.send(0x183), bench.send(0x283));
    bench.port.abort(first);
    assert_eq!(bench.poll(), Poll::Pending, "it is on the wire");
    bench.leaves(0);
    assert_eq!(bench.poll(), transmitted(first));
    bench.chip.borrow_mut().aborts = true;
    bench.port.leave();
    assert_eq!(bench.poll(), Poll::Ready(PortEvent::Failed { mailbox: second }));
}

/// Given a frame that left, when its place has a new frame before the task looked, then both end.
#[test]
fn place_that_is_used_again_ends_its_earlier_frame() {
    let mut bench = Bench::new();
    let first = bench.send(0x183);
    bench.leaves(0);
    let second = bench.send(0x080);
    assert_eq!(bench.poll(), transmitted(first));
    assert_eq!(bench.poll(), Poll::Pending);
    bench.leaves(0);
    assert_eq!(bench.poll(), transmitted(second));
}

/// Given a followed frame that the driver gave up, then it waits again and has one end.
#[test]
fn replaced_followed_frame_waits_again() {
    let mut bench = Bench::new();
    let (first, second) = (bench.send(0x183), bench.send(0x283));
    bench.chip.borrow_mut().replaces = true;
    let urgent = bench.send(0x080);
    assert_eq!(bench.poll(), Poll::Pending);
    bench.leaves(0);
    assert_eq!(bench.poll(), transmitted(urgent));
    assert_eq!(bench.chip.borrow().places[0], Some(frame(0x183, &[])));
    bench.leaves(0);
    assert_eq!(bench.poll(), transmitted(first));
    bench.leaves(1);
    assert_eq!(bench.poll(), transmitted(second));
}

#[test]
fn cause_of_the_last_error_ends_with_a_successful_transmission() {
    let mut bench = Bench::new();
    bench.send(0x183);
    bench.chip.borrow_mut().received.push(Received::Error(LastError::Ack));
    assert_eq!(bench.poll(), Poll::Pending);
    assert_eq!(bench.port.health().last_error, LastError::Ack);
    bench.leaves(0);
    assert!(bench.poll().is_ready());
    assert_eq!(bench.poll(), Poll::Pending);
    assert_eq!(bench.port.health().last_error, LastError::None);
}

/// The runner sets a filter again ten times a second, and a controller may miss frames meanwhile.
#[test]
fn filter_that_did_not_change_is_not_passed_on() {
    let mut bench = Bench::new();
    let [sync, nmt] = [CobId::SYNC, CobId::NMT].map(Filter::exact);
    bench.port.set_filters(&[sync, nmt]);
    bench.port.set_filter(0, sync);
    bench.port.set_filter(1, sync);
    bench.port.set_filter(2, nmt);
    assert_eq!(bench.chip.borrow().filters, [vec![sync, nmt], vec![sync, sync]]);
}
