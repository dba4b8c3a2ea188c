//! One controller without its filters: modes, errors, interrupts.

use super::clock::{PclkTick, bit_pclks};
use super::errors::ErrorState;
use super::fifo::{Fifo, Storing, rir};
use super::filter::{FilterBlock, FilterKey};
use super::mailbox::{Attempt, Mailboxes};
use super::regs::*;
use super::{Activity, IrqLines, Overrun, Side, Stats};
use crate::wire::controller::{Attachment, ErrorCounters, ErrorKind};
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;

/// Recessive bits that synchronise a controller with the bus, 32.4.2.
const SEQUENCE: u64 = 11;
/// Sequences of them that end bus-off, 32.7.6.
const BUS_OFF_SEQUENCES: u64 = 128;
/// An attempt without a wire: the dominant SOF reads recessive; error flag and error delimiter follow (ISO 11898-1).
const LONE_ATTEMPT: u64 = 1 + 6 + 8;
/// Bits between two attempts: the intermission. An error passive transmitter waits in addition.
const INTERMISSION: u64 = 3;
const SUSPENSION: u64 = 8;

/// Operating mode, RM0090 32.4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Sleep,
    Initialisation,
    Normal,
}

/// Registers and state of one controller.
#[derive(Clone, Debug)]
pub struct Registers {
    side: Side,
    pclk: PclkTick,
    /// Bit timing configured by BTR.
    timing: BitTiming,
    pub(super) mcr: u32,
    /// ERRI, WKUI and SLAKI.
    pub(super) msr_flags: u32,
    pub(super) ier: u32,
    pub(super) btr: u32,
    pub(super) errors: ErrorState,
    pub(super) mailboxes: Mailboxes,
    pub(super) fifos: [Fifo; 2],
    pub(super) mode: Mode,
    /// Instant at which the mode was entered.
    mode_since: Time,
    /// On the way from Sleep or Initialisation to Normal.
    joining: bool,
    /// Instant at which it last began to take part.
    joined_since: Time,
    /// Instant since which it is connected to no wire.
    alone_since: Option<Time>,
    /// End of the current attempt without a wire.
    lone_end: Option<Time>,
    /// Instant of the last bus-off.
    bus_off_since: Time,
    /// Bus-off, and INRQ was set and cleared since.
    recovery_asked: bool,
    /// On the way from Normal to another mode since this instant.
    leaving: Option<Time>,
    /// Instant since which frames may be sent: synchronised, and not bus-off.
    pub(super) on_bus_since: Time,
    /// End of the current loopback frame.
    pub(super) loopback_end: Option<Time>,
    pub(super) heard: Activity,
    /// The line became dominant in Sleep mode since the last poll.
    dominant_seen: bool,
    /// Number of resets; each restarts the error counters.
    resets: u32,
    pub(super) stats: Stats,
}

impl Registers {
    pub fn new(side: Side, pclk: PclkTick) -> Self {
        Registers {
            side,
            pclk,
            timing: pclk.timing(BTR_AT_RESET),
            mcr: MCR_AT_RESET,
            msr_flags: 0,
            ier: 0,
            btr: BTR_AT_RESET,
            errors: ErrorState::default(),
            mailboxes: Mailboxes::default(),
            fifos: Default::default(),
            mode: Mode::Sleep,
            mode_since: Time::ZERO,
            joining: false,
            joined_since: Time::ZERO,
            alone_since: None,
            lone_end: None,
            bus_off_since: Time::ZERO,
            recovery_asked: false,
            leaving: None,
            on_bus_since: Time::ZERO,
            loopback_end: None,
            heard: Activity::Nothing,
            dominant_seen: false,
            resets: 0,
            stats: Stats::default(),
        }
    }

    /// Resets the controller as RCC does; the clock, the line and the statistics are kept.
    pub fn reset(&mut self) {
        let fresh = Registers::new(self.side, self.pclk);
        self.stats.discarded += self.fifos.iter().map(|fifo| fifo.messages.len() as u64).sum::<u64>();
        self.stats.aborted.append(&mut self.mailboxes.aborted);
        let stats = std::mem::take(&mut self.stats);
        *self = Registers { stats, heard: self.heard, resets: self.resets + 1, ..fresh };
    }

    /// Statistics so far.
    pub fn stats(&self) -> Stats {
        let mut stats = self.stats.clone();
        stats.aborted.extend(&self.mailboxes.aborted);
        stats
    }

    pub fn set_pclk(&mut self, pclk: PclkTick) {
        self.pclk = pclk;
        self.timing = pclk.timing(self.btr);
    }

    /// Returns the value of a register; `None` if there is no register at this offset.
    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            MCR => self.mcr,
            MSR => self.msr(),
            TSR => self.mailboxes.tsr(self.mcr(MCR_TXFP)),
            RF0R => self.fifos[0].rfr(),
            RF1R => self.fifos[1].rfr(),
            IER => self.ier,
            ESR => self.errors.esr(),
            BTR => self.btr,
            TX_MAILBOXES..RX_MAILBOXES => {
                let (n, word) = locate(offset - TX_MAILBOXES);
                self.mailboxes.read(n, word)
            }
            RX_MAILBOXES..RX_MAILBOXES_END => {
                let (n, word) = locate(offset - RX_MAILBOXES);
                self.fifos[n].output(word)
            }
            _ => return None,
        })
    }

    /// Writes a register; `Some(false)` when the hardware ignores the value.
    pub fn write(&mut self, offset: u32, value: u32, now: Time) -> Option<bool> {
        match offset {
            MCR => self.write_mcr(value, now),
            MSR => self.msr_flags &= !(value & (MSR_ERRI | MSR_WKUI | MSR_SLAKI)),
            TSR => {
                self.mailboxes.write_tsr(value, now);
                if self.mode != Mode::Normal {
                    self.mailboxes.settle(now);
                }
            }
            RF0R | RF1R => {
                let n = usize::from(offset == RF1R);
                self.stats.released[n] += u64::from(self.fifos[n].write_rfr(value, now));
            }
            IER => self.ier = value & IER_STORED,
            ESR => self.errors.write(value),
            BTR => {
                let writable = self.mode == Mode::Initialisation;
                if writable {
                    self.set_btr(value & BTR_STORED);
                }
                return Some(writable);
            }
            TX_MAILBOXES..RX_MAILBOXES => {
                let (n, word) = locate(offset - TX_MAILBOXES);
                return Some(self.mailboxes.write(n, word, value, now));
            }
            RX_MAILBOXES..RX_MAILBOXES_END => return Some(false),
            _ => return None,
        }
        Some(true)
    }

    pub(super) fn set_btr(&mut self, btr: u32) {
        self.btr = btr;
        self.timing = self.pclk.timing(btr);
    }

    /// Levels of the four interrupt lines, RM0090 32.8.
    pub fn irq(&self) -> IrqLines {
        let enabled = |bit: u32| self.ier & bit != 0;
        let fifo = |n: usize| {
            let rfr = self.fifos[n].rfr();
            let enabled = |bit: u32| enabled(bit << (3 * n));
            enabled(IER_FMPIE0) && rfr & 0b11 != 0
                || enabled(IER_FFIE0) && rfr & RFR_FULL != 0
                || enabled(IER_FOVIE0) && rfr & RFR_FOVR != 0
        };
        let flag = |bit: u32| self.msr_flags & bit != 0;
        IrqLines {
            tx: enabled(IER_TMEIE) && self.mailboxes.any_completed(),
            rx0: fifo(0),
            rx1: fifo(1),
            sce: enabled(IER_ERRIE) && flag(MSR_ERRI)
                || enabled(IER_WKUIE) && flag(MSR_WKUI)
                || enabled(IER_SLKIE) && flag(MSR_SLAKI),
        }
    }

    /// `bits` bit times by this controller's clock.
    pub fn bits(&self, bits: u64) -> Time {
        self.pclk.span(bits * bit_pclks(self.btr))
    }

    pub fn mcr(&self, bit: u32) -> bool {
        self.mcr & bit != 0
    }

    pub fn loopback(&self) -> bool {
        self.btr & BTR_LBKM != 0
    }

    pub fn silent(&self) -> bool {
        self.btr & BTR_SILM != 0
    }

    /// Returns whether a frame may start at `at`.
    pub fn may_send(&self, at: Time) -> bool {
        self.mode == Mode::Normal
            && !self.errors.counters.bus_off()
            && self.on_bus_since <= at
            && self.leaving.is_none_or(|leaving| leaving > at)
    }

    /// Returns how this controller takes part in its bus.
    pub fn attachment(&self) -> Option<Attachment> {
        let live = (self.mode == Mode::Normal || self.joining) && !self.loopback();
        live.then(|| Attachment {
            timing: self.timing,
            silent: self.silent(),
            recovers: self.recovers(),
            power_cycle: self.resets,
            since: self.joined_since,
        })
    }

    /// Returns the earliest instant at which a frame waits.
    pub fn request_at(&self) -> Option<Time> {
        if self.silent() {
            return None;
        }
        let at = self.mailboxes.request_at()?.max(self.on_bus_since);
        self.may_send(at).then_some(at)
    }

    /// Returns the frame that it would send in an arbitration that begins at `at`.
    pub fn contend(&self, at: Time) -> Option<WireFrame> {
        let allowed = !self.silent() && self.may_send(at);
        allowed.then(|| self.mailboxes.contend(at, self.mcr(MCR_TXFP))).flatten()
    }

    /// TEC and REC.
    pub fn error_counters(&self) -> ErrorCounters {
        self.errors.counters
    }

    /// Returns whether the controller recovers from bus-off after 128 sequences of 11 recessive bits.
    fn recovers(&self) -> bool {
        self.mcr(MCR_ABOM) || self.recovery_asked
    }

    /// Handles a dominant edge of the line at `at`, which has an effect in Sleep mode only, 32.4.3.
    pub fn dominant(&mut self, at: Time) {
        self.dominant_seen |= self.mode == Mode::Sleep && at >= self.mode_since;
    }

    /// Advances to `now`, which CPU and wire have reached.
    pub fn poll(&mut self, now: Time) {
        if std::mem::take(&mut self.dominant_seen) {
            self.wake_up(now);
        }
        if !self.is_alone() {
            self.alone_since = None;
            if self.lone_end.take().is_some() {
                self.fail_alone(now);
            }
        } else {
            let since = *self.alone_since.get_or_insert(now);
            if !self.loopback() {
                self.attempt_alone(now);
            }
            self.count_alone(now, since);
        }
        self.mailboxes.settle(now);
        self.fifos.iter_mut().for_each(Fifo::settle);
        let inactive = self.errors.counters.bus_off() || self.is_alone() || self.heard == Activity::Idle;
        if self.leaving.is_some() && !self.mailboxes.transmitting() && inactive {
            self.leave(now);
        }
    }

    /// Simulates attempts without a wire up to `now`: every attempt reads its own dominant bits as recessive. Bit
    /// errors inside the error flags are not counted.
    fn attempt_alone(&mut self, now: Time) {
        if self.mailboxes.transmitting() && self.lone_end.is_none() {
            // The wire was disconnected in the middle of a frame.
            self.fail_alone(now);
        }
        loop {
            if let Some(end) = self.lone_end {
                if end > now {
                    return;
                }
                self.lone_end = None;
                self.fail_alone(end);
            }
            let Some(start) = self.lone_start().filter(|start| *start <= now) else { return };
            self.mailboxes.start(start, self.mcr(MCR_TXFP));
            self.lone_end = Some(start + self.bits(LONE_ATTEMPT));
        }
    }

    fn fail_alone(&mut self, end: Time) {
        self.mailboxes.finish(end, Attempt::Failed, self.mcr(MCR_NART));
        self.fail(ErrorKind::BitDominant);
        let counters = self.errors.counters;
        self.count(end, ErrorCounters { transmit: counters.transmit + 8, ..counters });
        let suspension = if counters.transmit + 8 >= 128 { SUSPENSION } else { 0 };
        self.on_bus_since = end + self.bits(INTERMISSION + suspension);
    }

    /// Returns the start of the next attempt without a wire. In silent mode there is none: the controller reads its own
    /// dominant bits internally.
    fn lone_start(&self) -> Option<Time> {
        self.loopback_start().filter(|_| !self.silent() && self.mode == Mode::Normal)
    }

    /// Returns whether the controller reads only recessive bits: off its pins, or in loopback ("the pin is
    /// disregarded", 32.5.2).
    fn is_alone(&self) -> bool {
        self.loopback() || self.heard == Activity::Nothing
    }

    /// Counts recessive bits without a wire, where every bit is recessive.
    fn count_alone(&mut self, now: Time, since: Time) {
        if self.joining && self.joined_since + self.bits(SEQUENCE) <= now {
            self.joined(self.joined_since + self.bits(SEQUENCE));
        }
        if let Some(back) = self.recovery_alone(since).filter(|&back| back <= now) {
            self.resets += 1;
            self.count(back, ErrorCounters::default());
        }
    }

    /// Returns the end of bus-off for a controller without a wire since `since`.
    fn recovery_alone(&self, since: Time) -> Option<Time> {
        let counts =
            self.errors.counters.bus_off() && self.recovers() && (self.mode == Mode::Normal || self.joining);
        let from = self.joined_since.max(self.bus_off_since).max(since);
        counts.then(|| from + self.bits(SEQUENCE * BUS_OFF_SEQUENCES))
    }

    /// Handles 11 recessive bits in a row.
    pub fn joined(&mut self, at: Time) {
        if self.joining {
            self.enter(Mode::Normal, at);
            self.on_bus_since = at;
        }
    }

    /// Returns the next change that occurs while the line does not change.
    pub fn next_event(&self) -> Option<Time> {
        let alone = self.is_alone().then(|| {
            let since = self.alone_since.unwrap_or(Time::ZERO);
            let joined = self.joining.then(|| self.joined_since + self.bits(SEQUENCE));
            let lone = || (!self.loopback()).then(|| self.lone_end.or_else(|| self.lone_start())).flatten();
            joined.or_else(|| self.recovery_alone(since)).or_else(lone)
        });
        let loopback = || self.loopback_end.or_else(|| self.loopback_start());
        let loopback = (self.mode == Mode::Normal && self.loopback()).then(loopback);
        [alone.flatten(), loopback.flatten()].into_iter().flatten().min()
    }

    /// Returns the start of the next loopback frame: the first bit after its request. Until then a mailbox with a lower
    /// identifier may be requested and go first; drivers depend on this at low bit rates (docs/decisions/twin.md).
    pub fn loopback_start(&self) -> Option<Time> {
        let request = self.mailboxes.request_at()?;
        let waited = request.since(self.on_bus_since);
        let bit = self.bits(1).0.max(1);
        let start = self.on_bus_since + self.bits(waited.0.div_ceil(bit));
        self.may_send(start).then_some(start)
    }

    /// Stores a frame that began at `start` and became valid at `at`, if a filter admits it.
    pub fn receive(&mut self, start: Time, at: Time, frame: WireFrame, filters: &FilterBlock) {
        self.errors.succeeded();
        let found = filters.admit(self.side, FilterKey { rir: rir(&frame) });
        let Some(found) = found.filter(|_| filters.admit_from(start)) else {
            self.stats.rejected += 1;
            return;
        };
        match self.fifos[found.fifo].store(at, frame, found.index, self.mcr(MCR_RFLM)) {
            Storing::Stored => self.stats.stored[found.fifo] += 1,
            Storing::Overrun(lost) => {
                self.stats.overruns.push(Overrun { at, fifo: found.fifo, lost });
                // The newest message was replaced, so the new one is stored nevertheless.
                self.stats.stored[found.fifo] += u64::from(!self.mcr(MCR_RFLM));
            }
        }
    }

    /// Records an error.
    pub fn fail(&mut self, kind: ErrorKind) {
        self.errors.failed(kind);
        if self.ier & IER_LECIE != 0 {
            self.msr_flags |= MSR_ERRI;
        }
    }

    /// Sets new error counters and raises the enabled interrupts.
    pub fn count(&mut self, at: Time, counters: ErrorCounters) {
        let before = self.errors.flags();
        self.errors.counters = counters;
        let after = self.errors.flags();
        let enables = [(ESR_EWGF, IER_EWGIE), (ESR_EPVF, IER_EPVIE), (ESR_BOFF, IER_BOFIE)];
        let raised = after & !before;
        if enables.iter().any(|&(flag, enable)| raised & flag != 0 && self.ier & enable != 0) {
            self.msr_flags |= MSR_ERRI;
        }
        if raised & ESR_BOFF != 0 {
            self.bus_off_since = at;
        }
        if before & !after & ESR_BOFF != 0 {
            self.recovery_asked = false;
            self.on_bus_since = at;
        }
    }

    fn msr(&self) -> u32 {
        let mode = match self.mode {
            Mode::Sleep => MSR_SLAK,
            Mode::Initialisation => MSR_INAK,
            Mode::Normal if self.mailboxes.transmitting() => MSR_TXM,
            Mode::Normal if self.heard == Activity::Busy && !self.loopback() => MSR_RXM,
            Mode::Normal => 0,
        };
        mode | self.msr_flags | MSR_RECESSIVE
    }

    pub(super) fn write_mcr(&mut self, value: u32, now: Time) {
        if value & MCR_RESET != 0 {
            self.master_reset();
            return;
        }
        self.mcr = value & MCR_STORED;
        let (init, sleep) = (self.mcr(MCR_INRQ), self.mcr(MCR_SLEEP));
        match self.mode {
            // INRQ wins over SLEEP: vendor drivers set INRQ, wait for INAK and only then clear SLEEP, and the
            // silicon acknowledges.
            Mode::Sleep if init => self.enter(Mode::Initialisation, now),
            Mode::Sleep if sleep => self.joining = false,
            Mode::Initialisation if init => self.joining = false,
            Mode::Initialisation if sleep => self.enter(Mode::Sleep, now),
            Mode::Sleep | Mode::Initialisation => self.join(now),
            Mode::Normal if init || sleep => {
                self.leaving.get_or_insert(now);
                if self.errors.counters.bus_off() {
                    self.leave(now);
                }
            }
            Mode::Normal => self.leaving = None,
        }
    }

    /// RESET in MCR: "MCR and the FMP bits are initialized, Sleep mode is activated". BTR, IER and filters stay. The
    /// manual does not define the rest. In this model the protocol core restarts: mailboxes are empty, counters are
    /// zero.
    fn master_reset(&mut self) {
        let (ier, btr) = (self.ier, self.btr);
        self.reset();
        self.ier = ier;
        self.set_btr(btr);
    }

    fn join(&mut self, now: Time) {
        if !std::mem::replace(&mut self.joining, true) {
            self.joined_since = now;
        }
        // "In initialization mode bxCAN does not monitor CANRX, therefore it cannot complete the recovery sequence",
        // 32.7.6: the recovery begins here, and the synchronising sequence is the first of the 128.
        self.recovery_asked |= self.errors.counters.bus_off();
    }

    /// Leaves Normal mode for the mode that MCR requests.
    fn leave(&mut self, now: Time) {
        self.enter(if self.mcr(MCR_INRQ) { Mode::Initialisation } else { Mode::Sleep }, now);
    }

    fn enter(&mut self, mode: Mode, at: Time) {
        self.mode = mode;
        self.mode_since = at;
        self.joining = false;
        self.leaving = None;
        if mode != Mode::Normal {
            self.recovery_asked = false;
        }
        if mode == Mode::Sleep {
            if self.ier & IER_SLKIE != 0 {
                self.msr_flags |= MSR_SLAKI;
            }
        } else {
            self.msr_flags &= !MSR_SLAKI;
        }
    }

    /// A start of frame was seen in Sleep mode, 32.4.3.
    fn wake_up(&mut self, now: Time) {
        if self.mode != Mode::Sleep || self.joining {
            return;
        }
        self.msr_flags |= MSR_WKUI;
        if self.mcr(MCR_AWUM) {
            self.mcr &= !MCR_SLEEP;
            if self.mcr(MCR_INRQ) { self.enter(Mode::Initialisation, now) } else { self.join(now) }
        }
    }
}

/// Number and word of a mailbox of 16 bytes.
fn locate(offset: u32) -> (usize, usize) {
    ((offset / 16) as usize, (offset / 4 % 4) as usize)
}
