//! The two bxCAN controllers of the STM32F405, register by register.
//!
//! Model of RM0090 chapter 32 ("Controller area network (bxCAN)") without a CPU: registers are read and written at an
//! instant of virtual time, and each controller is connected to a wire as a
//! [`Controller`](crate::wire::controller::Controller).
//!
//! # Order of calls
//!
//! The CPU runs ahead by a quantum (at most 20 µs), then the wire follows, then the model is updated:
//!
//! 1. [`BxcanPair::write`] and [`BxcanPair::read`] with instants inside the quantum;
//! 2. `Wire::advance` to the end of the quantum, which calls [`BxcanPair::line`];
//! 3. [`BxcanPair::hear`], then [`BxcanPair::poll`] with the end of the quantum.
//!
//! So the wire reports instants that are in the past of the CPU. Each write of the CPU has its instant and takes effect
//! from there on:
//! - a mailbox enters an arbitration that begins at or after its request, and before its abort;
//! - an abort later than the start of its frame waits for the end of that transmission; an earlier one prevents it.
//!   Either way the mailbox shows as empty from `poll` on, not at the write (in Initialisation or Sleep, where
//!   nothing can start, at the write);
//! - INRQ or SLEEP stop new transmissions at their instant; the mode changes when the frame on the line ends, or
//!   at the next `poll` that finds the line idle;
//! - a FIFO place that was released after a frame became valid was still occupied at that time: the frame is an
//!   overrun.
//!
//! # Not modelled
//!
//! TTCM: the errata of this block say that time stamps cannot be used and that TTCM stays cleared, so TIME reads 0.
//! CANTX in loopback. SAMP and RX of MSR always read recessive.

mod clock;
mod controller;
mod errors;
mod fifo;
mod filter;
mod line;
mod mailbox;
mod regs;
mod upset;

use std::fmt;

pub use clock::PclkTick;
pub(crate) use clock::bit_pclks;
use controller::Mode;
pub(crate) use controller::Registers;
use filter::FilterBlock;
pub use line::BusTap;
pub use mailbox::{Aborted, Attempt};
use regs::{BTR, CONTROLLER_SIZE, FMR, IER, MCR, MCR_DBF};

use crate::wire::frame::WireFrame;
use crate::wire::time::Time;

/// One of the two controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// 4000 6400h, owner of the filters.
    Can1,
    /// 4000 6800h.
    Can2,
}

/// Offset of the registers of the first filter bank from 4000 6400h. Each bank has two words.
pub(crate) const BANKS: u32 = regs::BANKS;

impl Side {
    /// Returns the other controller.
    pub const fn other(self) -> Side {
        match self {
            Side::Can1 => Side::Can2,
            Side::Can2 => Side::Can1,
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Side::Can1 => "CAN1",
            Side::Can2 => "CAN2",
        })
    }
}

/// There is no register at this offset, or the offset is not word aligned.
///
/// "The peripheral registers have to be accessed by words (32 bits)", RM0090 32.9: the caller has to refuse narrower
/// accesses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("bxCAN has no register at offset {offset:03X}h")]
pub struct BadAccess {
    /// Offset from 4000 6400h.
    pub offset: u32,
}

/// Levels of the four interrupt lines of one controller, RM0090 32.8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IrqLines {
    /// Transmit (vector 19 or 63).
    pub tx: bool,
    /// FIFO 0 (20 or 64).
    pub rx0: bool,
    /// FIFO 1 (21 or 65).
    pub rx1: bool,
    /// Error and status change (22 or 66).
    pub sce: bool,
}

/// Activity on the bus of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Not connected: every bit is recessive.
    Nothing,
    /// Connected to a bus that is idle: it may leave the bus.
    Idle,
    /// Connected to a bus on which a frame or an error frame is in progress.
    Busy,
}

/// Stuck bits of a register of a broken chip. For modes, bit timing and filters the stored value is stuck as well;
/// flags and mailboxes only read with these values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StuckBits {
    /// Offset from 4000 6400h; CAN2 begins at 400h, and the filters are behind CAN1.
    pub offset: u32,
    /// Bits that are always 0.
    pub zeros: u32,
    /// Bits that are always 1.
    pub ones: u32,
}

impl StuckBits {
    fn apply(stuck: &[StuckBits], offset: u32, value: u32) -> u32 {
        let here = stuck.iter().filter(|bits| bits.offset == offset);
        here.fold(value, |value, bits| value & !bits.zeros | bits.ones)
    }
}

/// A frame that passed the filters and was lost in a full FIFO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// Instant at which the frame without room became valid.
    pub at: Time,
    /// FIFO 0 or 1.
    pub fifo: usize,
    /// The lost frame: the new one, or with RFLM = 0 the newest before it.
    pub lost: WireFrame,
}

/// Statistics of one controller since power-on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Frames stored per FIFO.
    pub stored: [u64; 2],
    /// Messages released by software per FIFO.
    pub released: [u64; 2],
    /// Frames lost in full FIFOs.
    pub overruns: Vec<Overrun>,
    /// Valid frames that no filter admitted.
    pub rejected: u64,
    /// Stored messages that a reset discarded.
    pub discarded: u64,
    /// Transmit requests that ended by an abort, in chronological order.
    pub aborted: Vec<Aborted>,
    /// Writes that the hardware ignores: BTR outside initialisation, a mailbox that is not empty, an active filter
    /// bank, a receive mailbox.
    pub ignored_writes: u64,
    /// Instant and offset from 4000 6400h of the latest ignored write.
    pub last_ignored_write: Option<(Time, u32)>,
}

impl Stats {
    /// Returns the number of frames that passed the filters and that no reset discarded, lost ones included.
    pub fn admitted(&self) -> u64 {
        self.stored.iter().sum::<u64>() + self.overruns.len() as u64 - self.discarded
    }
}

/// CAN1 and CAN2 with the filter block that they share.
#[derive(Clone, Debug)]
pub struct BxcanPair {
    controllers: [Registers; 2],
    filters: FilterBlock,
    stuck: Vec<StuckBits>,
}

impl BxcanPair {
    /// Makes both controllers as after power-on, in Sleep mode. `pclk` is the length of a PCLK1 tick.
    pub fn new(pclk: PclkTick) -> Self {
        BxcanPair {
            controllers: [Registers::new(Side::Can1, pclk), Registers::new(Side::Can2, pclk)],
            filters: FilterBlock::default(),
            stuck: Vec::new(),
        }
    }

    /// Forgets the statistics of both controllers.
    pub(crate) fn forget_statistics(&mut self) {
        for controller in &mut self.controllers {
            controller.stats = Stats::default();
            controller.mailboxes.forget_statistics();
        }
    }

    /// Forgets the registers of filter banks that are not active and for which `is_forgotten` returns true.
    pub(crate) fn forget_inactive_filters(&mut self, is_forgotten: impl Fn(u32) -> bool) {
        self.filters.forget_inactive(is_forgotten);
    }

    /// Returns the filter banks that were active since the last call.
    pub(crate) fn take_active_filters(&mut self) -> u32 {
        self.filters.take_active()
    }

    /// Makes bits of a register stuck, permanently.
    pub fn stick(&mut self, bits: StuckBits) {
        self.stuck.push(bits);
    }

    /// Resets one controller by RCC (CAN1RST, CAN2RST). CAN1RST also resets the filters.
    pub fn reset(&mut self, side: Side) {
        self.controllers[side as usize].reset();
        if side == Side::Can1 {
            self.filters.reset();
        }
    }

    /// Sets the length of a PCLK1 tick (clock tree, drift of the crystal).
    pub fn set_pclk(&mut self, pclk: PclkTick) {
        for controller in &mut self.controllers {
            controller.set_pclk(pclk);
        }
    }

    /// Reads the word at `offset` from 4000 6400h; CAN2 begins at 400h. Reading has no side effect.
    ///
    /// # Errors
    /// [`BadAccess`] where there is no register.
    pub fn read(&self, offset: u32) -> Result<u32, BadAccess> {
        let (side, within) = locate(offset)?;
        let value = match side {
            Side::Can1 if within >= FMR => self.filters.read(within),
            _ => self.controllers[side as usize].read(within),
        };
        let value = value.ok_or(BadAccess { offset })?;
        Ok(StuckBits::apply(&self.stuck, offset, value))
    }

    /// Writes the word at `offset` from 4000 6400h at `now`. Reserved bits keep their value; read-only and protected
    /// registers ignore the write ([`Stats::ignored_writes`]).
    ///
    /// # Errors
    /// [`BadAccess`] where there is no register.
    pub fn write(&mut self, offset: u32, value: u32, now: Time) -> Result<(), BadAccess> {
        let (side, within) = locate(offset)?;
        let controller = &mut self.controllers[side as usize];
        let value = match within {
            MCR | IER | BTR | FMR.. => StuckBits::apply(&self.stuck, offset, value),
            _ => value,
        };
        let accepted = match side {
            Side::Can1 if within >= FMR => self.filters.write(within, value, now),
            _ => controller.write(within, value, now),
        };
        if !accepted.ok_or(BadAccess { offset })? {
            controller.stats.ignored_writes += 1;
            controller.stats.last_ignored_write = Some((now, offset));
        }
        Ok(())
    }

    /// Returns whether `side` takes part in a bus: in Normal mode and not in loopback.
    pub fn takes_part(&self, side: Side) -> bool {
        let controller = &self.controllers[side as usize];
        controller.mode == Mode::Normal && !controller.loopback()
    }

    /// Returns DBF of `side`: the controller stops with a halted core.
    pub fn stops_in_debug(&self, side: Side) -> bool {
        self.controllers[side as usize].mcr(MCR_DBF)
    }

    /// Levels of the interrupt lines of `side`.
    pub fn irq(&self, side: Side) -> IrqLines {
        self.controllers[side as usize].irq()
    }

    /// Interrupt lines of both controllers.
    pub(crate) fn irqs(&self) -> [IrqLines; 2] {
        [Side::Can1, Side::Can2].map(|side| self.irq(side))
    }

    /// The state of a controller.
    pub(crate) fn registers(&self, side: Side) -> &Registers {
        &self.controllers[side as usize]
    }

    /// Returns the access of a wire to the controller.
    pub fn line(&mut self, side: Side) -> BusTap<'_> {
        BusTap { registers: &mut self.controllers[side as usize], filters: &self.filters }
    }

    /// Sets the present activity on the controller's bus; [`Activity::Nothing`] before the first call.
    pub fn hear(&mut self, side: Side, heard: Activity) {
        self.controllers[side as usize].heard = heard;
    }

    /// Advances to `now`, which CPU and wires have reached: completes aborts and mode changes, runs loopback.
    pub fn poll(&mut self, now: Time) {
        for side in [Side::Can1, Side::Can2] {
            self.controllers[side as usize].poll(now);
            self.line(side).run_loopback(now);
        }
    }

    /// Returns the next instant at which the state changes without CPU or wire: end of a synchronisation or of bus-off
    /// of a controller without a wire, or of a loopback frame. Call [`BxcanPair::poll`] at that instant.
    pub fn next_event(&self) -> Option<Time> {
        self.controllers.iter().filter_map(Registers::next_event).min()
    }

    /// CAN_BTR of `side`.
    pub fn btr(&self, side: Side) -> u32 {
        self.controllers[side as usize].btr
    }

    /// Returns the statistics of `side`.
    pub fn stats(&self, side: Side) -> Stats {
        self.controllers[side as usize].stats()
    }
}

fn locate(offset: u32) -> Result<(Side, u32), BadAccess> {
    if !offset.is_multiple_of(4) {
        return Err(BadAccess { offset });
    }
    match offset / CONTROLLER_SIZE {
        0 => Ok((Side::Can1, offset)),
        1 => Ok((Side::Can2, offset - CONTROLLER_SIZE)),
        _ => Err(BadAccess { offset }),
    }
}
