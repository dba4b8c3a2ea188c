//! A mock of the boards' CAN port, with exactly the guarantees of [`CanPort`].
//!
//! Two sides share one state: a task holds the port ([`CanPort`]), a wire the controller
//! ([`Controller`](can_twin::wire::controller::Controller)).

mod faults;
mod mailbox;
mod missed;
mod one;
mod wire_side;

use std::cell::{Cell, Ref, RefCell, RefMut};
use std::collections::VecDeque;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use can_twin::wire::controller::Attachment;
use can_twin::wire::time::{TICKS_PER_US, Time};
use can_twin::wire::timing::BitTiming;
use ecss_can::link::Stamp;
use ecss_can::link::port::{Busy, CanPort, ErrorState, Filter, Health, Mailbox, PortEvent};
use ecss_can::types::Frame;
use faults::Faults;
use mailbox::{MAILBOXES, Mailboxes};
pub(crate) use missed::Missed;
pub use one::{BoardPort, MockSide, MockSwitch, one_controller};

use crate::clock::MockClock;

/// Received frames that wait for the task; more are lost and counted.
pub const RECEIVE_DEPTH: usize = 16;
/// Number of acceptance filters, as on the boards.
const FILTERS: usize = 28;
/// Bit time at 1 Mbit/s.
pub const BIT: Time = Time(TICKS_PER_US);

/// A CAN controller of a node. Clones are the same controller. With a transceiver switch it is the controller of each
/// bus, connected to the selected one.
#[derive(Clone, Debug)]
pub struct MockPort {
    plugs: Vec<Rc<RefCell<Chip>>>,
    position: Rc<Cell<usize>>,
}

/// The state of the controller.
#[derive(Debug)]
struct Chip {
    clock: MockClock,
    timing: BitTiming,
    /// Set when the state for the wire has changed.
    changed: Rc<Cell<bool>>,
    filters: Vec<Filter>,
    /// Number of replacements of each filter.
    replaced: Vec<u32>,
    missed: Missed,
    /// Instant since which it is on the bus.
    on_bus: Option<Time>,
    /// It has seen 11 recessive bits since (RM0090 32.4.2).
    joined: bool,
    /// It left the bus, and the wire has not been informed yet.
    gone: Cell<bool>,
    /// Number of resets.
    power_cycle: u32,
    /// Leaves the bus as soon as the frame on the wire has ended.
    leaving: bool,
    /// Drives no dominant bit.
    listens: bool,
    /// Mode in which it rejoins the bus after it has left: listening or not.
    back: Option<bool>,
    mailboxes: Mailboxes,
    /// Mailbox whose frame was last given to the wire.
    contending: Cell<Option<usize>>,
    faults: Faults,
    /// Recovery from bus-off was requested.
    recovers: bool,
    /// Results of mailboxes and received frames, in chronological order.
    events: VecDeque<PortEvent>,
    received: usize,
    lost: u16,
    /// Flags of the error state as last reported.
    told: (bool, ErrorState, bool),
    waker: Option<Waker>,
}

impl MockPort {
    /// Makes a controller at power-on, off the bus.
    pub fn new(clock: MockClock) -> Self {
        MockPort::that_sets(clock, Rc::default())
    }

    /// As [`MockPort::new`], with a flag `changed` that is set when the wire has to query it again.
    pub fn that_sets(clock: MockClock, changed: Rc<Cell<bool>>) -> Self {
        changed.set(true);
        let chip = Rc::new(RefCell::new(Chip::new(clock, changed, 0)));
        MockPort { plugs: vec![chip], position: Rc::default() }
    }

    /// Sets the bit timing, in place of 1 Mbit/s. The setting survives a reset.
    pub(crate) fn set_timing(&self, timing: BitTiming) {
        self.chip_mut().timing = timing;
    }

    /// Sets the frames that the controller misses. The setting survives a reset.
    pub(crate) fn set_missed(&self, missed: Missed) {
        self.chip_mut().missed = missed;
    }

    /// Handles a chip reset, or another power-on with a new clock.
    pub fn reset(&self, clock: MockClock) {
        let power_cycle = self.chip().power_cycle + 1;
        let gone = self.chip().on_bus.is_some() || self.chip().gone.get();
        let (changed, timing, missed) =
            (self.chip().changed.clone(), self.chip().timing, self.chip().missed.clone());
        changed.set(true);
        *self.plug().borrow_mut() =
            Chip { timing, missed, gone: Cell::new(gone), ..Chip::new(clock, changed, power_cycle) };
    }

    /// Returns whether it is off the bus, and a frame that was on the wire has ended.
    pub fn is_off_bus(&self) -> bool {
        let chip = self.chip();
        chip.on_bus.is_none() && !chip.leaving
    }

    /// Returns how often the node has set each of its filters again since power-on.
    pub fn replaced_filters(&self) -> Vec<u32> {
        self.chip().replaced.clone()
    }

    /// Returns whether there are ends of transmissions or received frames to take.
    pub fn has_events(&self) -> bool {
        !self.chip().events.is_empty()
    }

    fn plug(&self) -> &RefCell<Chip> {
        &self.plugs[self.position.get()]
    }

    fn chip(&self) -> Ref<'_, Chip> {
        self.plug().borrow()
    }

    fn chip_mut(&self) -> Changing<'_> {
        Changing::of(self.plug().borrow_mut())
    }
}

/// Guard of a change to a controller. It informs the wire of changes.
struct Changing<'a> {
    chip: RefMut<'a, Chip>,
    before: Shown,
}

impl<'a> Changing<'a> {
    fn of(chip: RefMut<'a, Chip>) -> Self {
        Changing { before: chip.shown(), chip }
    }
}

impl Deref for Changing<'_> {
    type Target = Chip;

    fn deref(&self) -> &Chip {
        &self.chip
    }
}

impl DerefMut for Changing<'_> {
    fn deref_mut(&mut self) -> &mut Chip {
        &mut self.chip
    }
}

impl Drop for Changing<'_> {
    fn drop(&mut self) {
        if self.chip.shown() != self.before {
            self.chip.changed.set(true);
        }
    }
}

/// State of a controller for the wire: attachment, departure, since when a frame waits.
type Shown = (Option<Attachment>, bool, Option<Time>);

impl Chip {
    fn new(clock: MockClock, changed: Rc<Cell<bool>>, power_cycle: u32) -> Self {
        Chip {
            clock,
            timing: BitTiming::MEGABIT,
            changed,
            filters: Vec::new(),
            replaced: Vec::new(),
            missed: Missed::default(),
            on_bus: None,
            joined: false,
            gone: Cell::new(false),
            power_cycle,
            leaving: false,
            listens: false,
            back: None,
            mailboxes: Mailboxes::default(),
            contending: Cell::new(None),
            faults: Faults::default(),
            recovers: false,
            events: VecDeque::new(),
            received: 0,
            lost: 0,
            told: (false, ErrorState::Active, false),
            waker: None,
        }
    }

    fn shown(&self) -> Shown {
        (self.attachment(), self.gone.get(), self.waits_since())
    }

    fn now(&self) -> Time {
        self.clock.timeline().now()
    }

    /// Returns a stamp captured at the end of the frame.
    fn stamp(&self, at: Time) -> Stamp {
        Stamp::captured(self.clock.fine(at))
    }

    /// Returns whether it may send: joined, not leaving, not bus-off.
    fn may_send(&self) -> bool {
        self.joined && !self.leaving && !self.listens && self.faults.state() != ErrorState::BusOff
    }

    fn push(&mut self, event: PortEvent) {
        self.events.push_back(event);
        self.wake();
    }

    fn wake(&mut self) {
        if let Some(waker) = self.waker.take() {
            self.clock.timeline().interrupt();
            waker.wake();
        }
    }

    fn finish_leaving(&mut self) {
        if self.leaving && self.mailboxes.on_wire().is_none() {
            self.gone.set(self.gone.get() || self.on_bus.is_some());
            (self.leaving, self.on_bus, self.joined) = (false, None, false);
            if let Some(listens) = self.back.take() {
                (self.listens, self.on_bus) = (listens, Some(self.now()));
            }
        }
    }

    /// Changes between listening and sending by leaving and rejoining the bus.
    fn go_on_bus(&mut self, listens: bool) {
        if self.on_bus.is_some() && self.listens != listens {
            (0..MAILBOXES).for_each(|mailbox| self.abort(mailbox));
            (self.leaving, self.back) = (true, Some(listens));
            return self.finish_leaving();
        }
        (self.leaving, self.listens, self.back) = (false, listens, None);
        if self.on_bus.is_none() {
            self.on_bus = Some(self.now());
        }
    }

    fn fail(&mut self, mailbox: usize) {
        self.mailboxes.end(mailbox);
        self.push(PortEvent::Failed { mailbox: Mailbox(mailbox as u8) });
    }

    fn abort(&mut self, mailbox: usize) {
        if self.mailboxes.abort(mailbox) {
            self.fail(mailbox);
        }
    }

    fn next_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        if self.told != self.faults.flags() {
            self.told = self.faults.flags();
            return Poll::Ready(PortEvent::Health(self.faults.health()));
        }
        if self.lost > 0 {
            return Poll::Ready(PortEvent::Overrun { lost: std::mem::take(&mut self.lost) });
        }
        let Some(event) = self.events.pop_front() else {
            self.waker = Some(context.waker().clone());
            return Poll::Pending;
        };
        match event {
            PortEvent::Received { .. } => self.received -= 1,
            PortEvent::Transmitted { mailbox, .. } | PortEvent::Failed { mailbox } => {
                self.mailboxes.free(usize::from(mailbox.0));
            }
            PortEvent::Overrun { .. } | PortEvent::Health(_) | PortEvent::Stalled => {}
        }
        Poll::Ready(event)
    }
}

impl CanPort for MockPort {
    type PerMailbox<T: Default> = [T; MAILBOXES];

    const FILTERS: usize = FILTERS;

    fn set_filters(&mut self, filters: &[Filter]) {
        for plug in &self.plugs {
            let mut chip = Changing::of(plug.borrow_mut());
            (chip.filters, chip.replaced) = (filters.to_vec(), vec![0; filters.len()]);
        }
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        for plug in &self.plugs {
            let (mut chip, number) = (Changing::of(plug.borrow_mut()), usize::from(number));
            if number < chip.filters.len() {
                chip.filters[number] = filter;
                chip.replaced[number] += 1;
            }
        }
    }

    fn join(&mut self) {
        self.chip_mut().go_on_bus(false);
    }

    fn listen(&mut self) {
        self.chip_mut().go_on_bus(true);
    }

    fn leave(&mut self) {
        let mut chip = self.chip_mut();
        (0..MAILBOXES).for_each(|mailbox| chip.abort(mailbox));
        (chip.leaving, chip.back) = (true, None);
        chip.recovers = false;
        chip.finish_leaving();
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        let mut chip = self.chip_mut();
        let now = chip.now();
        if chip.back.unwrap_or(chip.listens) {
            return Err(Busy);
        }
        chip.mailboxes.put(*frame, now).map(|mailbox| Mailbox(mailbox as u8)).ok_or(Busy)
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.chip_mut().abort(usize::from(mailbox.0));
    }

    fn health(&self) -> Health {
        self.chip().faults.health()
    }

    fn recover(&mut self) {
        let mut chip = self.chip_mut();
        chip.recovers = chip.on_bus.is_some() && chip.faults.state() == ErrorState::BusOff;
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        self.chip_mut().next_event(context)
    }
}
