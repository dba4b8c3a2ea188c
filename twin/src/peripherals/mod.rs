//! The peripherals of one part and the bus in front of them.
//!
//! The bus refuses accesses that a real one would ignore: to registers that are not modelled and to blocks whose clock
//! is off in RCC. If the twin returned zeros, wrong firmware would pass its tests.

#[cfg(test)]
mod bench;
pub(crate) mod can_pins;
mod crc;
mod dma;
mod exti;
mod flash;
mod gpio;
mod i2c;
mod iwdg;
mod map;
mod names;
mod pins;
mod rcc;
mod requests;
mod resets;
mod same;
mod sleep;
mod system;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_blocks;
mod timer;
mod timers;
mod upset;
mod wires;

use crc::Crc;
use dma::Dma;
use exti::{Exti, Syscfg};
pub(crate) use flash::Change;
pub use flash::FlashSpeed;
use flash::{ACR, Flash};
pub use gpio::PinChange;
use gpio::{Gpio, TIMER_AF};
use i2c::Buses;
use iwdg::Iwdg;
use map::{Block, CAN1_BIT, CAN2_BIT};
pub(crate) use names::{is_reserved, name};
use rcc::{APB1, BDCR, Gate, Rcc};
pub use rcc::{Clocks, ResetCause};
pub use requests::Ram;
pub use same::RegisterUses;
use system::{Dbgmcu, Pwr, signature};
use timers::{TIM3, TIM5, TIMERS, Timers};

use crate::accelerator::PRFTEN;
use crate::bxcan::{BusTap, BxcanPair, PclkTick, Registers, Side};
use crate::mmio::{Now, Refusal, Width, duplicate, mask, merge};
use crate::model::{FLASH_BASE, Model, Part, Pins};
use crate::part::Family;
use crate::pin::Pin;
use crate::wire::time::Time;

/// Levels of the NVIC inputs 0..=95.
pub type IrqLevels = [u32; 3];

const IDCODE_REVISION_A: u32 = 0x2000_6411;
const FLASH_IRQ: u16 = 4;
/// TX, RX0, RX1, SCE of CAN1 and CAN2.
const CAN_IRQS: [(Side, u16); 2] = [(Side::Can1, 19), (Side::Can2, 63)];
const PORT_A: usize = 0;
/// Pins at which TIM5 captures CAN_RX, by its channels.
pub(crate) const CAPTURE_PINS: [Pin; 4] =
    [Pin::new('A', 0), Pin::new('A', 1), Pin::new('A', 2), Pin::new('A', 3)];
/// Pins of the channels of TIM3 and TIM5, the same in each part (DS8626 table 9, DS10693 table 11).
pub(crate) const TIM3_PINS: [&[Pin]; 4] = [
    &[Pin::new('A', 6), Pin::new('B', 4), Pin::new('C', 6)],
    &[Pin::new('A', 7), Pin::new('B', 5), Pin::new('C', 7)],
    &[Pin::new('B', 0), Pin::new('C', 8)],
    &[Pin::new('B', 1), Pin::new('C', 9)],
];
const TIM5_PINS: [&[Pin]; 4] =
    [&[CAPTURE_PINS[0]], &[CAPTURE_PINS[1]], &[CAPTURE_PINS[2]], &[CAPTURE_PINS[3]]];
/// First address of the option bytes.
const OPTION_BYTES: u32 = 0x1FFF_C000;
const LSI_HZ: u32 = 32_000;

/// A timer changed the level of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TimedChange {
    /// HCLK cycle of the change.
    pub cycle: u64,
    /// Pin that changed.
    pub pin: Pin,
    /// Level after the change.
    pub high: bool,
}

/// All peripherals of one board.
#[derive(Clone, Debug)]
pub struct Peripherals {
    pub(crate) part: Part,
    /// Connections of the board's pins.
    pins: Pins,
    serial: u32,
    pub(crate) rcc: Rcc,
    pub(crate) flash: Flash,
    pwr: Pwr,
    pub(crate) dbgmcu: Dbgmcu,
    gpio: [Gpio; Pin::PORTS],
    exti: Exti,
    syscfg: Syscfg,
    crc: Crc,
    dma: [Dma; 2],
    pub(crate) i2c: Buses,
    timers: Timers,
    iwdg: Iwdg,
    pub(crate) can: BxcanPair,
    /// Whether the pins carry CAN1 and CAN2.
    can_routed: [bool; 2],
    /// Instant since which a debugger has halted the core.
    halted: Option<Time>,
    /// The core sleeps, and a peripheral stands still meanwhile.
    is_asleep: bool,
    /// Changes of output pins by stores, until the board takes them.
    pub(crate) pin_changes: Vec<PinChange>,
    timed_changes: Vec<TimedChange>,
    /// An access may have changed interrupt lines, requests or events since this was taken.
    has_changed: bool,
}

/// Returns the tick of PCLK1 until the board sets it: HSI, exact.
fn hsi_tick() -> PclkTick {
    PclkTick::new(21, 1)
}

impl Peripherals {
    /// After power-on; `serial` goes into the unique ID.
    pub fn new(model: Model, serial: u32) -> Self {
        let part = model.part;
        Peripherals {
            part,
            pins: model.pins,
            serial,
            rcc: Rcc::new(model),
            flash: Flash::new(part, FlashSpeed::Typical),
            pwr: Pwr::new(part),
            dbgmcu: Dbgmcu::new(part),
            gpio: std::array::from_fn(Gpio::new),
            exti: Exti::default(),
            syscfg: Syscfg::default(),
            crc: Crc::default(),
            dma: [Dma::new(0), Dma::new(1)],
            i2c: Buses::default(),
            timers: Timers::default(),
            iwdg: Iwdg::new(LSI_HZ),
            can: BxcanPair::new(hsi_tick()),
            can_routed: [false; 2],
            halted: None,
            is_asleep: false,
            pin_changes: Vec::new(),
            timed_changes: Vec::new(),
            has_changed: false,
        }
    }

    /// Returns whether an access since the last call may have changed interrupt lines, requests or events.
    pub(crate) fn take_change(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    /// Makes the part an F405 of revision A, whose prefetch does not work and whose DEV_ID is that of the STM32F20x
    /// (ES0182).
    ///
    /// # Panics
    /// For another part: a mistake in a test, not an input.
    pub fn set_revision_a(&mut self) {
        assert_eq!(self.part.family(), Family::F405, "only the F405 and its like have such a revision A");
        self.dbgmcu.set_idcode(IDCODE_REVISION_A);
    }

    fn lacks_prefetch(&self) -> bool {
        self.dbgmcu.idcode() == IDCODE_REVISION_A
    }

    /// Resets the whole part. Only power-on resets DBGMCU (RM0090 38.16.3).
    pub fn reset(&mut self, now: Time, cause: ResetCause) {
        self.rcc.reset(cause);
        self.halted = None;
        self.is_asleep = false;
        self.flash.reset();
        self.pwr = Pwr::new(self.part);
        self.gpio.iter_mut().for_each(Gpio::reset);
        self.exti = Exti::default();
        self.syscfg = Syscfg::default();
        self.crc = Crc::default();
        self.dma.iter_mut().for_each(Dma::reset);
        self.i2c.reset();
        self.timers.reset();
        self.iwdg.reset();
        self.can.reset(Side::Can1);
        self.can.reset(Side::Can2);
        self.can_routed = [false; 2];
        if cause == ResetCause::PowerOn {
            self.dbgmcu.reset();
            self.i2c.power_on();
        }
        if self.flash.watches().1 {
            self.iwdg.start(now);
        }
    }

    /// Loads a value for the core.
    ///
    /// # Errors
    /// A [`Refusal`] if the access is not supported.
    pub fn read(&mut self, now: Now, address: u32, width: Width) -> Result<u32, Refusal> {
        let (block, offset) = self.select(address, width)?;
        let word = offset & !3;
        self.has_changed |= block.changes_when_read(word);
        if block.shows_timers() {
            self.run_timers(now.cycle);
        }
        let value = match block {
            Block::Dma(n) => Some(self.dma[n].read(word)?),
            Block::I2c(n) => Some(self.i2c.0[n].read(now.cycle, word)?),
            Block::Timer(n) => Some(self.timers.touch(n).read(now.cycle, word)?),
            Block::Iwdg => Some(self.iwdg.read(now.time, word)?),
            Block::Can => self.can.read(word).ok(),
            Block::Pwr => self.pwr.read(word),
            Block::Syscfg => self.syscfg.read(word),
            Block::Exti => self.exti.read(word),
            Block::Gpio(port) => self.gpio[port].read(word),
            Block::Crc => self.crc.read(word),
            Block::Rcc => self.rcc.read(now, word),
            Block::Flash => self.flash.read(word),
            Block::Dbgmcu => self.dbgmcu.read(word),
            Block::Signature => match (address & !3).checked_sub(OPTION_BYTES) {
                Some(offset) => self.flash.options(offset),
                None => signature(self.part, self.serial, address & !3),
            },
        };
        let value = value.ok_or(Refusal::Unmodelled)?;
        Ok(value >> (8 * (address & 3)) & mask(width))
    }

    /// Stores a value of the core; bits of `value` above `width` are zero.
    ///
    /// # Errors
    /// A [`Refusal`] if the access is not supported.
    pub fn write(&mut self, now: Now, address: u32, width: Width, value: u32) -> Result<(), Refusal> {
        self.has_changed = true;
        if (FLASH_BASE..FLASH_BASE + self.part.flash_bytes()).contains(&address) {
            return self.flash.program(now.time, address - FLASH_BASE, width, value);
        }
        let (block, offset) = self.select(address, width)?;
        let word = offset & !3;
        // A peripheral in reset ignores stores.
        if block.gate(offset).is_some_and(|gate| self.rcc.is_held(gate)) {
            return Ok(());
        }
        let value = match self.kept(now, block, word) {
            Some(old) => merge(width, address, old, value),
            // Timers depend on the width of the access.
            None if matches!(block, Block::Timer(_)) => value,
            None => duplicate(width, value),
        };
        if matches!((block, word), (Block::Flash, ACR)) && value & PRFTEN != 0 && self.lacks_prefetch() {
            return Err(Refusal::Misuse);
        }
        if block.shows_timers() {
            self.run_timers(now.cycle);
        }
        let done = match block {
            Block::Dma(n) => Some(self.dma[n].write(word, value)?),
            Block::I2c(n) => Some(self.i2c.0[n].write(now.cycle, word, value)?),
            Block::Timer(n) => Some(self.timers.touch(n).write(now.cycle, word, width, value)?),
            Block::Iwdg => Some(self.iwdg.write(now.time, word, value)?),
            Block::Can => self.can.write(word, value, now.time).ok(),
            Block::Pwr => self.pwr.write(word, value),
            Block::Syscfg => self.syscfg.write(word, value),
            Block::Exti => self.exti.write(word, value),
            Block::Crc => self.crc.write(word, value),
            // The backup domain ignores stores without DBP.
            Block::Rcc if word == BDCR && !self.pwr.allows_backup() => Some(()),
            Block::Rcc => self.rcc.write(now, word, value),
            Block::Flash => Some(self.flash.write(now.time, word, value)?),
            Block::Dbgmcu => self.dbgmcu.write(word, value),
            Block::Gpio(port) => self.gpio[port].write(now.time, word, value, &mut self.pin_changes),
            Block::Signature => None,
        };
        if let Some((bus, bits)) = self.rcc.resets.take() {
            self.reset_blocks(bus, bits);
        }
        if matches!(block, Block::I2c(_) | Block::Gpio(_) | Block::Rcc) {
            self.follow_pins(now.cycle);
        }
        if matches!(block, Block::Rcc | Block::Pwr) && !self.clocks_are_allowed() {
            return Err(Refusal::ClockLimit);
        }
        // Reads that are faster than the flash return undefined values.
        if matches!(block, Block::Rcc | Block::Flash) && !self.flash.is_fast_enough(self.rcc.clocks().hclk) {
            return Err(Refusal::Misuse);
        }
        done.ok_or(Refusal::Unmodelled)
    }

    /// Returns whether the clocks are within the limits of the part. A broken prescaler does not count as an error of
    /// the program.
    fn clocks_are_allowed(&self) -> bool {
        let Clocks { hclk, apb1_divider, apb2_divider, .. } = self.rcc.clocks();
        let [most, apb1, apb2] = self.pwr.most();
        let is_apb1_allowed = hclk / apb1_divider <= apb1 || self.rcc.apb1_stuck;
        hclk <= most && is_apb1_allowed && hclk / apb2_divider <= apb2
    }

    /// Returns the value of the bytes that a store does not write, which AHB keeps. `None` behind the bridges to APB,
    /// which write a byte or half-word to the whole register, duplicated (RM0090 2.1).
    fn kept(&self, now: Now, block: Block, word: u32) -> Option<u32> {
        match block {
            Block::Gpio(port) => self.gpio[port].read(word),
            Block::Rcc => self.rcc.read(now, word),
            Block::Flash => self.flash.kept(word),
            _ => None,
        }
    }

    /// Returns whether a modelled block is at `address`.
    pub(crate) fn is_modelled(&self, address: u32) -> bool {
        Block::at(self.part, address).is_some()
    }

    fn select(&self, address: u32, width: Width) -> Result<(Block, u32), Refusal> {
        let (block, base) = Block::at(self.part, address).ok_or(Refusal::Unmodelled)?;
        let offset = address - base;
        block.takes(width)?;
        if !address.is_multiple_of(width.bytes()) {
            return Err(Refusal::Width);
        }
        match block.gate(offset) {
            Some(gate) if !self.rcc.is_clocked(gate) => Err(Refusal::ClockOff),
            _ => Ok((block, offset)),
        }
    }

    /// Applies a changed clock tree from `cycle` on; `pclk1` is the length of a PCLK1 tick.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks, pclk1: PclkTick) {
        self.i2c.set_clocks(cycle, clocks);
        self.timers.set_clocks(cycle, clocks);
        self.can.set_pclk(pclk1);
    }

    /// Drives an input pin by the harness, or releases it.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        let before = self.exti_inputs();
        self.gpio[pin.port_index()].drive(u32::from(pin.number), level);
        let after = self.exti_inputs();
        self.exti.edges(before, after);
    }

    /// Changes the capture pin that is wired to CAN_RX of a bus at `cycle`. Returns whether this may raise an interrupt
    /// line or a DMA transfer. Has no effect on a board without these wires.
    pub fn capture_edge(&mut self, side: Side, cycle: u64, level: bool) -> bool {
        let Some(pins) = self.pins.capture else { return false };
        let n = u32::from(pins[side as usize].number);
        let gpio = &mut self.gpio[PORT_A];
        if gpio.driven_level(n) == Some(level) {
            return false;
        }
        gpio.drive(n, Some(level));
        let captured = gpio.alternate_function(n) == Some(TIMER_AF)
            && self.rcc.is_clocked(TIMERS[TIM5].gate)
            && self.timers.all[TIM5].edge(n, cycle, level);
        let external = self.syscfg.exti_port(n) == PORT_A;
        if external {
            let lines = |level: bool| u32::from(level) << n;
            self.exti.edges(lines(!level), lines(level));
        }
        captured || external
    }

    /// Runs TIM5 and TIM3 until `cycle`: TIM5 starts TIM3, both drive pins.
    pub fn run_timers(&mut self, cycle: u64) {
        self.timers.all[TIM5].catch_up(cycle);
        if !self.timers.all[TIM5].rises.is_empty() {
            for rise in self.timers.all[TIM5].take_rises() {
                if self.rcc.is_clocked(TIMERS[TIM3].gate) {
                    self.timers.all[TIM3].trigger(rise);
                }
            }
        }
        self.timers.all[TIM3].catch_up(cycle);
        if self.timers.all[TIM3].changes.is_empty() && self.timers.all[TIM5].changes.is_empty() {
            return;
        }
        for (timer, pins) in [(TIM3, TIM3_PINS), (TIM5, TIM5_PINS)] {
            for (cycle, channel, level) in self.timers.all[timer].take_changes() {
                for &pin in pins[channel as usize] {
                    if self.gpio[pin.port_index()].drive_by_timer(u32::from(pin.number), level) {
                        self.timed_changes.push(TimedChange { cycle, pin, high: level == Some(true) });
                    }
                }
            }
        }
    }

    /// Takes the changes of pins by timers since the last call, in chronological order.
    pub(crate) fn take_timed_changes(&mut self) -> Vec<TimedChange> {
        std::mem::take(&mut self.timed_changes)
    }

    /// Returns the count of TIM5 at `cycle`, with its fraction.
    pub fn capture_clock(&self, cycle: u64) -> f64 {
        self.timers.all[TIM5].exact_count(cycle)
    }

    /// Returns the instant at which the watchdog resets the chip unless the program reloads it before.
    pub fn watchdog_deadline(&self) -> Option<Time> {
        let frozen = self.halted.is_some() && self.dbgmcu.freezes_watchdog();
        self.iwdg.deadline().filter(|_| !frozen)
    }

    /// Halts the core as a debugger does.
    pub(crate) fn halt(&mut self, now: Time) {
        self.halted = Some(now);
    }

    /// Resumes the core.
    pub(crate) fn go_on(&mut self, now: Time) {
        if let Some(since) = self.halted.take()
            && self.dbgmcu.freezes_watchdog()
        {
            self.iwdg.stood_still(now.since(since));
        }
    }

    /// Returns whether a controller is frozen with its core.
    fn is_can_frozen(&self, side: Side) -> bool {
        self.halted.is_some() && self.dbgmcu.freezes_can(side) && self.can.stops_in_debug(side)
    }

    /// Sets the frequency of the LSI oscillator, in Hz. The watchdog must not run yet.
    pub fn set_lsi(&mut self, hz: u32) {
        self.iwdg = Iwdg::new(hz);
    }

    fn exti_inputs(&self) -> u32 {
        (0..16).fold(0, |lines, n| {
            let port = self.gpio.get(self.syscfg.exti_port(n));
            lines | port.map_or(0, |gpio| gpio.idr() & 1 << n)
        })
    }

    /// Level of a pin as its port sees it.
    pub fn pin_level(&self, pin: Pin) -> bool {
        self.gpio[pin.port_index()].idr() >> pin.number & 1 == 1
    }

    /// Levels of all interrupt lines.
    pub fn irq_levels(&mut self, now: Now) -> IrqLevels {
        self.run_timers(now.cycle);
        let mut levels = [0; 3];
        let mut set = |irq: u16, level: bool| {
            if level {
                levels[usize::from(irq) / 32] |= 1 << (irq % 32);
            }
        };
        set(FLASH_IRQ, self.flash.irq());
        for dma in &self.dma {
            dma.irqs(|irq| set(irq, true));
        }
        self.i2c.irqs(now.cycle, &mut set);
        self.timers.irqs(now.cycle, &mut set);
        for (side, first) in CAN_IRQS {
            let lines = self.can.irq(side);
            for (k, level) in [lines.tx, lines.rx0, lines.rx1, lines.sce].into_iter().enumerate() {
                set(first + k as u16, level);
            }
        }
        for (irq, level) in self.exti.irqs() {
            set(irq, level);
        }
        levels
    }

    /// The cycle at which a timer or an I2C bus next raises its line or asks for DMA.
    pub fn next_timer_event(&self, now: Now) -> Option<u64> {
        [self.i2c.next_event(), self.timers.next_event(now.cycle)].into_iter().flatten().min()
    }

    /// Returns the access of a wire to the controller; `None` while it has no clock or its pins do not carry it.
    pub fn can_line(&mut self, side: Side) -> Option<BusTap<'_>> {
        self.is_can_connected(side).then(|| self.can.line(side))
    }

    /// The state of a controller, under the conditions of [`Peripherals::can_line`].
    pub(crate) fn can_registers(&self, side: Side) -> Option<&Registers> {
        self.is_can_connected(side).then(|| self.can.registers(side))
    }

    fn is_can_connected(&self, side: Side) -> bool {
        self.can_routed[side as usize] && self.is_can_clocked(side) && !self.is_can_frozen(side)
    }

    /// Returns the reason why a controller that takes part reaches no bus. `None` if it reaches one or does not take
    /// part. `wired`: its transceiver is connected to a bus.
    pub(crate) fn unconnected_can(&self, side: Side, wired: bool) -> Option<String> {
        if !self.is_can_clocked(side) || !self.can.takes_part(side) {
            return None;
        }
        let loose = || (!wired).then(|| "the board's wiring has no bus behind its transceiver".to_owned());
        can_pins::missing(&self.gpio, self.part, self.pins.can(side), side).or_else(loose)
    }

    fn is_can_clocked(&self, side: Side) -> bool {
        self.is_running(Gate { bus: APB1, bit: CAN1_BIT })
            && (side == Side::Can1 || self.is_running(Gate { bus: APB1, bit: CAN2_BIT }))
    }
}
