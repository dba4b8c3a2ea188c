//! The peripherals of one part and the bus in front of them.
//!
//! The bus refuses what a real one would answer with silence: registers that the model lacks and blocks whose clock is
//! off in RCC. A twin that answered zeros would let wrong firmware fly.

mod exti;
mod gpio;
mod rcc;
mod system;
mod tim2;

use crate::bxcan::{BxcanPair, Line, PclkTick, Side};
use crate::mmio::{Now, Refusal, Width};
use crate::model::{Model, Part};
use exti::{Exti, Syscfg};
use gpio::Gpio;
pub use gpio::{Pin, PinChange};
pub use rcc::{Clocks, ResetCause};
use rcc::{Gate, Rcc};
use system::{Dbgmcu, Flash, Pwr, signature};
use tim2::Tim2;

/// Levels of the NVIC inputs 0..=95.
pub type IrqLevels = [u32; 3];

const TIM2_IRQ: u16 = 28;
/// TX, RX0, RX1, SCE of CAN1 and CAN2.
const CAN_IRQS: [(Side, u16); 2] = [(Side::Can1, 19), (Side::Can2, 63)];
/// CAN_RX and CAN_TX of both boards, and their alternate function.
const CAN_PINS: [(Side, [u32; 2]); 2] = [(Side::Can1, [8, 9]), (Side::Can2, [12, 13])];
const CAN_AF: u32 = 9;
const PORT_B: usize = 1;

const AHB1: u32 = 0x00;
const APB1: u32 = 0x10;
const APB2: u32 = 0x14;
const TIM2_BIT: u32 = 0;
const CAN1_BIT: u32 = 25;
const CAN2_BIT: u32 = 26;
const PWR_BIT: u32 = 28;
const SYSCFG_BIT: u32 = 14;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    Tim2,
    Can,
    Pwr,
    Syscfg,
    Exti,
    Gpio(usize),
    Rcc,
    Flash,
    Dbgmcu,
    Signature,
}

impl Block {
    /// The block at `address` and where it begins (RM0090 table 1).
    fn at(part: Part, address: u32) -> Option<(Block, u32)> {
        let block = match address & !0x3FF {
            0x4000_0000 => Block::Tim2,
            0x4000_6400 | 0x4000_6800 => return Some((Block::Can, 0x4000_6400)),
            0x4000_7000 => Block::Pwr,
            0x4001_3800 => Block::Syscfg,
            0x4001_3C00 => Block::Exti,
            base @ 0x4002_0000..0x4002_2400 => {
                let port = (base as usize - 0x4002_0000) >> 10;
                return (port < part.ports()).then_some((Block::Gpio(port), base));
            }
            0x4002_3800 => Block::Rcc,
            0x4002_3C00 => Block::Flash,
            0xE004_2000 => Block::Dbgmcu,
            0x1FFF_7800 => Block::Signature,
            _ => return None,
        };
        Some((block, address & !0x3FF))
    }

    /// Its clock gate; some blocks have none.
    fn gate(self, offset: u32) -> Option<Gate> {
        let (bus, bit) = match self {
            Block::Tim2 => (APB1, TIM2_BIT),
            Block::Can if offset < 0x400 => (APB1, CAN1_BIT),
            Block::Can => (APB1, CAN2_BIT),
            Block::Pwr => (APB1, PWR_BIT),
            Block::Syscfg => (APB2, SYSCFG_BIT),
            Block::Gpio(port) => (AHB1, port as u32),
            Block::Exti | Block::Rcc | Block::Flash | Block::Dbgmcu | Block::Signature => return None,
        };
        Some(Gate { bus, bit })
    }
}

/// All peripherals of one board.
#[derive(Debug)]
pub struct Peripherals {
    part: Part,
    serial: u32,
    rcc: Rcc,
    flash: Flash,
    pwr: Pwr,
    dbgmcu: Dbgmcu,
    gpio: [Gpio; Pin::PORTS],
    exti: Exti,
    syscfg: Syscfg,
    tim2: Tim2,
    can: BxcanPair,
    pin_changes: Vec<PinChange>,
}

/// PCLK1 until the board says what it is: HSI, exact.
fn hsi_tick() -> PclkTick {
    PclkTick::new(21, 1)
}

impl Peripherals {
    /// After power-on; `serial` goes into the unique ID.
    pub fn new(model: Model, serial: u32) -> Self {
        let part = model.part;
        Peripherals {
            part,
            serial,
            rcc: Rcc::new(model),
            flash: Flash::default(),
            pwr: Pwr::new(part),
            dbgmcu: Dbgmcu::new(part),
            gpio: std::array::from_fn(Gpio::new),
            exti: Exti::default(),
            syscfg: Syscfg::default(),
            tim2: Tim2::default(),
            can: BxcanPair::new(hsi_tick()),
            pin_changes: Vec::new(),
        }
    }

    /// A reset of the whole part. DBGMCU alone survives all but power-on (RM0090 38.16.3).
    pub fn reset(&mut self, cause: ResetCause) {
        self.rcc.reset(cause);
        self.flash = Flash::default();
        self.pwr = Pwr::new(self.part);
        self.gpio.iter_mut().for_each(Gpio::reset);
        self.exti = Exti::default();
        self.syscfg = Syscfg::default();
        self.tim2.reset();
        self.can.reset(Side::Can1);
        self.can.reset(Side::Can2);
        if cause == ResetCause::PowerOn {
            self.dbgmcu = Dbgmcu::new(self.part);
        }
    }

    /// A load by the core.
    ///
    /// # Errors
    /// A [`Refusal`] when nothing may answer.
    pub fn read(&mut self, now: Now, address: u32, width: Width) -> Result<u32, Refusal> {
        let (block, offset) = self.select(address, width)?;
        let word = offset & !3;
        let value = match block {
            Block::Tim2 => self.tim2.read(now.cycle, word),
            Block::Can => self.can.read(word).ok(),
            Block::Pwr => self.pwr.read(word),
            Block::Syscfg => self.syscfg.read(word),
            Block::Exti => self.exti.read(word),
            Block::Gpio(port) => self.gpio[port].read(word),
            Block::Rcc => self.rcc.read(now, word),
            Block::Flash => self.flash.read(word),
            Block::Dbgmcu => self.dbgmcu.read(word),
            Block::Signature => signature(self.part, self.serial, address & !3),
        };
        let value = value.ok_or(Refusal::Unmodelled)?;
        Ok(value >> (8 * (address & 3)) & width.mask())
    }

    /// A store by the core; `value` above `width` is zero.
    ///
    /// # Errors
    /// A [`Refusal`] when nothing may answer.
    pub fn write(&mut self, now: Now, address: u32, width: Width, value: u32) -> Result<(), Refusal> {
        let (block, offset) = self.select(address, width)?;
        let word = offset & !3;
        if let Block::Gpio(port) = block {
            // AHB keeps the bytes that the access leaves out; BSRR reads zero, so they do nothing there.
            let old = self.gpio[port].read(word).ok_or(Refusal::Unmodelled)?;
            let shift = 8 * (address & 3);
            let merged = old & !(width.mask() << shift) | value << shift;
            return self.gpio[port]
                .write(now.time, word, merged, &mut self.pin_changes)
                .ok_or(Refusal::Unmodelled);
        }
        if address & 3 != 0 {
            return Err(Refusal::Width);
        }
        let done = match block {
            Block::Tim2 => self.tim2.write(now.cycle, word, value),
            Block::Can => self.can.write(word, value, now.time).ok(),
            Block::Pwr => self.pwr.write(word, value),
            Block::Syscfg => self.syscfg.write(word, value),
            Block::Exti => self.exti.write(word, value),
            Block::Rcc => self.rcc.write(now, word, value),
            Block::Flash => self.flash.write(word, value),
            Block::Dbgmcu => self.dbgmcu.write(word, value),
            Block::Gpio(_) | Block::Signature => None,
        };
        if let Some((bus, bits)) = self.rcc.take_resets() {
            self.reset_blocks(bus, bits);
        }
        done.ok_or(Refusal::Unmodelled)
    }

    fn select(&self, address: u32, width: Width) -> Result<(Block, u32), Refusal> {
        let (block, base) = Block::at(self.part, address).ok_or(Refusal::Unmodelled)?;
        let offset = address - base;
        if block == Block::Can && width != Width::Word || !address.is_multiple_of(width.bytes()) {
            return Err(Refusal::Width);
        }
        match block.gate(offset) {
            Some(gate) if !self.rcc.is_clocked(gate) => Err(Refusal::ClockOff),
            _ => Ok((block, offset)),
        }
    }

    fn reset_blocks(&mut self, bus: u32, bits: u32) {
        let hit = |on: u32, bit: u32| bus == on && bits >> bit & 1 == 1;
        for (port, gpio) in self.gpio.iter_mut().enumerate() {
            if hit(AHB1, port as u32) {
                gpio.reset();
            }
        }
        if hit(APB1, TIM2_BIT) {
            self.tim2.reset();
        }
        for (side, bit) in [(Side::Can1, CAN1_BIT), (Side::Can2, CAN2_BIT)] {
            if hit(APB1, bit) {
                self.can.reset(side);
            }
        }
        if hit(APB1, PWR_BIT) {
            self.pwr = Pwr::new(self.part);
        }
        if hit(APB2, SYSCFG_BIT) {
            self.syscfg = Syscfg::default();
        }
    }

    /// The clock tree as set now.
    pub fn clocks(&self) -> Clocks {
        self.rcc.clocks()
    }

    /// Applies a changed clock tree from `cycle` on; `pclk1` is the length of a PCLK1 tick.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks, pclk1: PclkTick) {
        self.tim2.set_divider(cycle, clocks.timer1_divider);
        self.can.set_pclk(pclk1);
    }

    /// The harness drives an input pin, or lets go of it.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        let before = self.exti_inputs();
        self.gpio[pin.port_index()].drive(u32::from(pin.number), level);
        let after = self.exti_inputs();
        self.exti.edges(before, after);
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

    /// Changes of output pins since the last call.
    pub fn take_pin_changes(&mut self) -> Vec<PinChange> {
        std::mem::take(&mut self.pin_changes)
    }

    /// Levels of all interrupt lines.
    pub fn irq_levels(&mut self, now: Now) -> IrqLevels {
        let mut levels = [0; 3];
        let mut set = |irq: u16, level: bool| {
            levels[usize::from(irq) / 32] |= u32::from(level) << (irq % 32);
        };
        set(TIM2_IRQ, self.tim2.irq(now.cycle));
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

    /// The cycle at which a timer next raises its line.
    pub fn next_timer_event(&self, now: Now) -> Option<u64> {
        self.tim2.next_event(now.cycle)
    }

    /// The two CAN controllers.
    pub fn can(&mut self) -> &mut BxcanPair {
        &mut self.can
    }

    /// The controller as its wire sees it: `None` while it has no clock or its pins do not carry it.
    pub fn can_line(&mut self, side: Side) -> Option<Line<'_>> {
        let (_, pins) = CAN_PINS[side as usize];
        let clocked = self.rcc.is_clocked(Gate { bus: APB1, bit: CAN1_BIT })
            && (side == Side::Can1 || self.rcc.is_clocked(Gate { bus: APB1, bit: CAN2_BIT }));
        let routed = pins.iter().all(|&n| self.gpio[PORT_B].alternate_function(n) == Some(CAN_AF));
        (clocked && routed).then(|| self.can.line(side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RCC: u32 = 0x4002_3800;

    fn enable(peripherals: &mut Peripherals, register: u32, bits: u32) {
        peripherals.write(Now::default(), RCC + register, Width::Word, bits).unwrap();
    }

    #[test]
    fn nothing_answers_where_no_peripheral_is_modelled() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        for address in [0x4000_0C00, 0x4000_4400, 0x4002_3850 - 4, 0x5000_0000] {
            assert_eq!(peripherals.read(Now::default(), address, Width::Word), Err(Refusal::Unmodelled));
        }
    }

    #[test]
    fn the_f446_has_no_port_i_and_its_own_identity() {
        let mut f446 = Peripherals::new(Model::NUCLEO_F446RE, 0);
        enable(&mut f446, 0x30, 0x1FF);
        let mut read = |address| f446.read(Now::default(), address, Width::Word);
        assert_eq!(read(0x4002_1C00), Ok(0), "port H");
        assert_eq!(read(0x4002_2000), Err(Refusal::Unmodelled), "port I");
        assert_eq!(read(0xE004_2000).map(|id| id & 0xFFF), Ok(0x421));
        assert_eq!(read(0x1FFF_7A20).map(|size| size >> 16), Ok(512));
    }

    #[test]
    fn a_block_without_clock_refuses() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        let moder = 0x4002_0400;
        assert_eq!(peripherals.read(Now::default(), moder, Width::Word), Err(Refusal::ClockOff));
        enable(&mut peripherals, 0x30, 1 << 1);
        assert_eq!(peripherals.read(Now::default(), moder, Width::Word), Ok(0x280));
    }

    #[test]
    fn can_takes_words_only() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        enable(&mut peripherals, 0x40, 1 << 25);
        assert_eq!(peripherals.read(Now::default(), 0x4000_6400, Width::Half), Err(Refusal::Width));
        assert_eq!(peripherals.read(Now::default(), 0x4000_6400, Width::Word), Ok(0x0001_0002));
    }

    #[test]
    fn a_byte_store_to_a_port_keeps_its_neighbours() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        enable(&mut peripherals, 0x30, 1);
        peripherals.write(Now::default(), 0x4002_0000, Width::Byte, 0x55).unwrap();
        assert_eq!(peripherals.read(Now::default(), 0x4002_0000, Width::Word), Ok(0xA800_0055));
    }

    #[test]
    fn the_wire_sees_a_controller_only_behind_its_pins() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        enable(&mut peripherals, 0x40, 1 << 25);
        enable(&mut peripherals, 0x30, 1 << 1);
        assert!(peripherals.can_line(Side::Can1).is_none());
        peripherals.write(Now::default(), 0x4002_0424, Width::Word, 0x99).unwrap();
        peripherals.write(Now::default(), 0x4002_0400, Width::Word, 0x000A_0280).unwrap();
        assert!(peripherals.can_line(Side::Can1).is_some());
    }

    #[test]
    fn an_rcc_reset_returns_a_block_to_its_reset_state() {
        let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
        enable(&mut peripherals, 0x40, 1);
        peripherals.write(Now::default(), 0x4000_0028, Width::Half, 83).unwrap();
        enable(&mut peripherals, 0x20, 1);
        assert_eq!(peripherals.read(Now::default(), 0x4000_0028, Width::Word), Ok(0));
    }
}
