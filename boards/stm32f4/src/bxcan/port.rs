//! A controller as the port of one bus.

#[cfg(feature = "full")]
mod selftest;
mod upsets;

use core::future::Future;
use core::pin::Pin;
use core::task::{Context, Poll};

use ecss_can::link::Stamp;
use ecss_can::link::one_controller::Movable;
use ecss_can::link::port::{Busy, CanPort, Filter, Health, Mailbox, PortEvent};
use ecss_can::runner::Clock;
use ecss_can::types::{CobId, Frame};
use embassy_stm32::interrupt::Priority;
use embassy_stm32::interrupt::typelevel::Interrupt;
use embassy_stm32::pac::can::Can;
use embassy_stm32::rcc;
use embassy_time::{Duration, Timer};

#[cfg(feature = "full")]
pub use selftest::{CaptureFault, ControllerFault, LineFault};

use super::MAILBOXES;
use super::banks;
use super::controller::{self, BANKS, Controller};
use super::events::EventQueue;
use super::held::Held;
use super::interrupts::ControllerInterrupts;
use super::lines::CanLines;
use super::mailboxes::Mailboxes;
use super::mode::{Mode, Request, Seen};
use super::registers::{enable_sources, mode, request};
use super::status::{Enables, Status};
use crate::Uptime;
use crate::alternate::{AlternatePin, Direction};
use crate::stamping::FrameStamps;
use crate::timing::ControllerTiming;

/// Lower than the priority of the timer driver, whose interrupt maintains the time of the stamps.
const PRIORITY: Priority = Priority::P6;

/// Reads of MSR while a controller enters Init mode after reset. If it takes longer, the mode is polled later.
const INIT_POLLS: usize = 2_000;

/// Polling interval for changes that raise no interrupt: changes of mode, and the end of a recovery from bus-off on a
/// quiet bus.
const LOOK: Duration = Duration::from_millis(1);

/// Ticks of the capture timer per clock of APB1: the timers run at twice its rate.
const TICKS_PER_CLOCK: u32 = 2;

/// A bxCAN controller on its bus.
pub struct Port<S> {
    registers: Can,
    first_bank: usize,
    /// Number of filters in use, two in each bank.
    filters: usize,
    events: &'static EventQueue,
    mailboxes: Mailboxes,
    timing: ControllerTiming,
    stamps: S,
    mode: Mode,
    rx: AlternatePin,
    tx: AlternatePin,
    /// [`Port::pin_check`] at the start.
    pins: u8,
    /// Part of the registers that was compared last.
    compared: u8,
    /// A recovery from bus-off may be in progress.
    recovering: bool,
    /// No change is in progress that needs polling.
    is_quiet: bool,
    /// Timer until the next poll of changes that raise no interrupt.
    look: Option<Timer>,
}

impl<S> Port<S> {
    /// Takes a controller into Init mode, silent. CAN1 must be made first: it clocks the filters of both.
    ///
    /// A controller that does not enter it stays silent. The request is repeated without limit and reported
    /// ([`PortEvent::Stalled`]).
    pub fn new<T: Controller>(
        lines: CanLines<T>,
        _interrupts: impl ControllerInterrupts<T>,
        timing: ControllerTiming,
        stamps: S,
    ) -> Port<S> {
        rcc::enable_and_reset::<T>();
        enable::<T::TXInterrupt>();
        enable::<T::RX0Interrupt>();
        enable::<T::SCEInterrupt>();
        Port {
            registers: T::REGISTERS,
            first_bank: T::FIRST_BANK,
            filters: 0,
            events: T::events(),
            mailboxes: Mailboxes::default(),
            timing,
            stamps,
            mode: Mode::entering(timing.emptying(), Uptime.now()),
            rx: lines.rx,
            tx: lines.tx,
            pins: 0,
            compared: 0,
            recovering: false,
            is_quiet: false,
            look: None,
        }
        .started()
    }

    /// Requests Init mode and connects the pins.
    #[inline(never)] // once for both controllers
    fn started(mut self) -> Port<S> {
        self.obey(Request::Init);
        enable_sources(self.registers, Enables::ALL);
        // The pins are connected last, because CAN_TX is recessive in Init mode.
        self.pins = self.pin_check();
        self.connect();
        for _ in 0..INIT_POLLS {
            self.advance();
            if self.mode.is_settled() {
                break;
            }
        }
        self
    }

    /// Connects the pins to the controller.
    fn connect(&mut self) {
        self.rx.connect(Direction::Input);
        self.tx.connect(Direction::Output);
    }

    /// Returns a number that each flipped bit of the pins changes.
    fn pin_check(&self) -> u8 {
        self.rx.check() ^ self.tx.check()
    }

    fn write_filter(&mut self, number: usize, filter: Filter) {
        if number < self.filters {
            banks::write(self.first_bank, self.filters, number, filter);
        }
    }

    /// Continues the change of mode in progress.
    fn advance(&mut self) {
        while let Some(request) = self.mode.advance(self.seen(), Uptime.now()) {
            self.obey(request);
        }
    }

    fn seen(&self) -> Seen {
        let status = self.registers.tsr().read();
        Seen { init: self.registers.msr().read().inak(), empty: (0..MAILBOXES).all(|n| status.tme(n)) }
    }

    #[inline(never)] // smaller: it has three callers, all of them rare
    fn want(&mut self, on_bus: bool, listens: bool) {
        self.mode.want(on_bus, listens);
        (self.recovering, self.is_quiet) = (on_bus, false);
        self.advance();
    }

    fn obey(&self, request: Request) {
        match request {
            Request::Configure { listens } => controller::configure(self.registers, &self.timing, listens),
            // In rising order: a waiting frame is in a lower mailbox than the last frame before it, and the end of that
            // one would request it.
            Request::Abort => (0..MAILBOXES).for_each(|n| self.give_up(Mailbox(n as u8))),
            Request::Init => self.registers.mcr().write_value(mode(true)),
            Request::Normal => self.registers.mcr().write_value(mode(false)),
        }
    }

    fn give_up(&self, mailbox: Mailbox) {
        let number = usize::from(mailbox.0);
        if number < MAILBOXES && !self.events.cancel(mailbox) {
            self.registers.tsr().write(|w| w.set_abrq(number, true));
        }
    }

    /// Returns whether a frame with this identifier was, or may have been, received or sent without being reported yet.
    fn holds(&self, id: CobId) -> bool {
        let status = self.registers.tsr().read();
        (0..MAILBOXES).any(|n| status.rqcp(n))
            || self.registers.rfr(0).read().fmp() > 0
            || self.events.holds(id, &self.mailboxes)
    }

    fn is_bus_off(&self) -> bool {
        self.registers.esr().read().boff()
    }

    /// Polls changes that raise no interrupt, now and again after [`LOOK`]. Returns whether a request takes too long.
    #[inline(never)] // seldom
    fn watch(&mut self, context: &mut Context<'_>) -> bool {
        if !self.mode.is_settled() {
            self.advance();
        }
        if self.mode.take_stall(Uptime.now()) {
            return true;
        }
        if self.recovering {
            self.watch_recovery();
        }
        self.is_quiet = self.mode.is_settled() && !self.recovering;
        if self.is_quiet {
            self.look = None;
            return false;
        }
        let timer = self.look.get_or_insert_with(|| Timer::after(LOOK));
        if Pin::new(timer).poll(context).is_ready() {
            self.look = None;
            // Runs again at once to start the next timer.
            context.waker().wake_by_ref();
        }
        false
    }

    fn watch_recovery(&mut self) {
        self.events.note_errors(self.registers);
        self.recovering = self.is_bus_off();
    }
}

fn enable<I: Interrupt>() {
    I::set_priority(PRIORITY);
    // SAFETY: the handler is bound, and its state is a static behind a critical section. No critical section relies on
    // this interrupt being masked.
    unsafe { I::enable() };
}

impl<S: FrameStamps> CanPort for Port<S> {
    type PerMailbox<T: Default> = [T; MAILBOXES];

    /// Two filters in each bank.
    const FILTERS: usize = 2 * BANKS;

    fn set_filters(&mut self, filters: &[Filter]) {
        self.filters = filters.len();
        banks::prepare();
        for (number, filter) in (0..).zip(filters) {
            self.write_filter(number, *filter);
        }
    }

    /// Sets a filter. The runner calls it ten times a second, so it also compares registers with what they have to be.
    fn set_filter(&mut self, number: u8, filter: Filter) {
        self.mend_next();
        self.write_filter(number.into(), filter);
    }

    fn join(&mut self) {
        self.want(true, false);
    }

    fn listen(&mut self) {
        self.want(true, true);
    }

    fn leave(&mut self) {
        self.want(false, false);
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        if !self.mode.is_wanted_to_send() {
            return Err(Busy);
        }
        let (number, behind) = self.mailboxes.claim(frame.id(), || self.events.holds_frame()).ok_or(Busy)?;
        let waits = behind.contains(&true);
        let mailbox = self.registers.tx(usize::from(number.0).min(MAILBOXES - 1));
        let [a, b, c, d, e, f, g, h] = frame.padded();
        mailbox.tdtr().write(|w| w.set_dlc(frame.dlc()));
        mailbox.tdlr().write(|w| w.0 = u32::from_le_bytes([a, b, c, d]));
        mailbox.tdhr().write(|w| w.0 = u32::from_le_bytes([e, f, g, h]));
        mailbox.tir().write(|w| {
            w.set_stid(frame.id().raw());
            w.set_txrq(!waits);
        });
        // The status is read after the frame is stored: a later result raises the interrupt.
        if waits
            && let Some(due) =
                self.events.hold(Held { mailbox: number, behind }, |n| self.registers.tsr().read().tme(n))
        {
            request(self.registers, due);
        }
        Ok(number)
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.give_up(mailbox);
    }

    fn health(&self) -> Health {
        Status(self.registers.esr().read().0).health()
    }

    /// A port that left its bus stays off it; [`CanPort::join`] also recovers it from bus-off.
    fn recover(&mut self) {
        if self.is_bus_off()
            && let Some(request) = self.mode.recover(Uptime.now())
        {
            self.obey(request);
            (self.recovering, self.is_quiet) = (true, false);
            self.advance();
        }
    }

    fn stamp(&mut self, frame: &Frame, reported: Stamp) -> Stamp {
        let bit = self.timing.clocks() * TICKS_PER_CLOCK;
        self.stamps.stamp(frame, reported, bit, || !self.holds(frame.id()))
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        if !self.is_quiet && self.watch(context) {
            return Poll::Ready(PortEvent::Stalled);
        }
        let event = self.events.poll(context);
        if let Poll::Ready(PortEvent::Transmitted { mailbox, .. } | PortEvent::Failed { mailbox }) = event {
            self.mailboxes.release(mailbox);
        }
        event
    }
}

impl<S: FrameStamps> Movable for Port<S> {
    fn is_silent(&self) -> bool {
        self.mode.is_silent()
    }
}
