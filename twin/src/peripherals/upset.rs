//! Upsets of peripherals: bits that hold state, and what follows when one of them is inverted.
//!
//! Each block lists its registers with the bits that hold state, and inverts one of them by its offset. Locks, keys and modes that keep
//! a program from a register do not protect the bit. A block without clock is not listed.

use super::dma::{self, Dma};
use super::gpio::Gpio;
use super::iwdg::{self, Iwdg};
use super::map::Block;
use super::rcc::{self, Rcc};
use super::{Peripherals, name, timers};
use crate::bxcan::Side;
use crate::cpu::StateRegister;
use crate::mmio::{Now, Refusal};
use crate::wire::time::Time;

/// First addresses of the blocks that hold state, besides timers and ports.
const BLOCKS: [u32; 13] = [
    0x4000_3000, // IWDG
    0x4000_6400, // CAN1
    0x4000_6800, // CAN2
    0x4000_7000, // PWR
    0x4001_3800, // SYSCFG
    0x4001_3C00, // EXTI
    0x4002_3000, // CRC
    0x4002_3800, // RCC
    0x4002_3C00, // FLASH
    0x4002_6000, // DMA1
    0x4002_6400, // DMA2
    0xE004_2000, // DBGMCU
    0x4002_0000, // GPIOA; the other ports follow
];
const CAN1: u32 = 0x4000_6400;
const CAN2: u32 = 0x4000_6800;
const GPIOA: u32 = 0x4002_0000;
const PORT_BYTES: usize = 0x400;
/// IMR, EMR, RTSR, FTSR, PR.
const EXTI_WORDS: [u32; 5] = [0x00, 0x04, 0x08, 0x0C, 0x14];
const EXTI_LINES: u32 = 0x7F_FFFF;
/// EXTICR1 to EXTICR4.
const SYSCFG_WORDS: [u32; 4] = [0x08, 0x0C, 0x10, 0x14];
/// CR, APB1_FZ and APB2_FZ, with the bits of the F405.
const DBGMCU_WORDS: [(u32, u32); 3] = [(0x04, 0xE7), (0x08, 0x06E0_1DFF), (0x0C, 0x0007_0003)];

impl Peripherals {
    /// Returns all registers that hold state, with their addresses.
    pub fn state_registers(&self) -> Vec<StateRegister> {
        let ports = (GPIOA..).step_by(PORT_BYTES).take(self.part.ports()).skip(1);
        let bases = timers::bases().chain(BLOCKS).chain(ports);
        let all =
            bases.flat_map(|base| self.stored(base).into_iter().map(move |(at, bits)| (base + at, bits)));
        let named = all.filter(|(_, bits)| *bits != 0).filter_map(|(address, bits)| {
            Some(StateRegister { name: name(self.part, address)?, address, bits })
        });
        let mut registers: Vec<_> = named.collect();
        registers.sort_by_key(|register| register.address);
        registers
    }

    /// Returns the registers of the block at `base`: offsets, and bits that hold state. Empty for a block without clock.
    fn stored(&self, base: u32) -> Vec<(u32, u32)> {
        let Some((block, _)) = Block::at(self.part, base) else { return Vec::new() };
        if block.gate(if base == CAN2 { 0x400 } else { 0 }).is_some_and(|gate| !self.rcc.is_clocked(gate)) {
            return Vec::new();
        }
        let words = |offsets: &[u32], bits| offsets.iter().map(|offset| (*offset, bits)).collect();
        match block {
            Block::Can if base == CAN2 => {
                let of_can2 = self.can.stored(Side::Can2).into_iter();
                of_can2.map(|(offset, bits)| (offset - (CAN2 - CAN1), bits)).collect()
            }
            Block::Can => self.can.stored(Side::Can1),
            Block::Timer(n) if self.timers.is_touched(n) => self.timers.all[n].stored(),
            Block::Gpio(port) => self.gpio[port].stored(|n| self.part.has_pin(self.pin(port, n))),
            Block::Crc => self.crc.stored(),
            Block::Rcc => self.rcc.stored(),
            Block::Flash => self.flash.stored(),
            Block::Dma(n) => self.dma[n].stored(),
            Block::Iwdg => vec![(iwdg::PR, 0b111), (iwdg::RLR, 0xFFF)],
            Block::Exti => words(&EXTI_WORDS, EXTI_LINES),
            Block::Syscfg => words(&SYSCFG_WORDS, 0xFFFF),
            Block::Pwr => vec![(0, self.pwr.cr_mask())],
            Block::Dbgmcu => DBGMCU_WORDS.to_vec(),
            Block::Timer(_) | Block::I2c(_) | Block::Signature => Vec::new(),
        }
    }

    fn pin(&self, port: usize, number: u32) -> crate::pin::Pin {
        crate::pin::Pin::new(char::from(b'A' + port as u8), number as u8)
    }

    /// Inverts a bit of a register of [`Peripherals::state_registers`].
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for another bit or a mode that the model lacks, [`Refusal::ClockLimit`] and [`Refusal::Misuse`] for clocks
    /// that the part or its flash does not stand.
    pub fn flip(&mut self, now: Now, address: u32, bit: u32) -> Result<(), Refusal> {
        let is_there =
            |register: &StateRegister| register.address == address && register.bits >> bit & 1 == 1;
        let (block, base) = Block::at(self.part, address).ok_or(Refusal::Unmodelled)?;
        if bit > 31 || !self.state_registers().iter().any(is_there) {
            return Err(Refusal::Unmodelled);
        }
        let (offset, mask) = (address - base, 1 << bit);
        self.run_timers(now.cycle);
        match block {
            Block::Can => self.can.flip(offset, bit, now.time),
            Block::Timer(n) => self.timers.all[n].flip(now.cycle, offset, bit)?,
            Block::Gpio(port) => {
                let gpio = &mut self.gpio[port];
                self.pin_changes.extend(gpio.flip(now.time, offset, mask));
                self.follow_pins(now.cycle);
            }
            Block::Crc => self.crc.flip(offset, mask),
            Block::Rcc => {
                self.rcc.flip(now, offset, mask);
                if let Some((bus, bits)) = self.rcc.resets.take() {
                    self.reset_blocks(bus, bits);
                }
                self.follow_pins(now.cycle);
            }
            Block::Flash => self.flash.flip(offset, bit),
            Block::Dma(n) => self.dma[n].flip(offset, bit)?,
            Block::Iwdg => self.iwdg.flip(now.time, offset, mask),
            Block::Exti => self.exti.words[offset as usize / 4] ^= mask,
            Block::Syscfg => self.syscfg.words[offset as usize / 4] ^= mask,
            Block::Pwr => self.pwr.cr ^= mask,
            Block::Dbgmcu => self.dbgmcu.words[offset as usize / 4] ^= mask,
            Block::I2c(_) | Block::Signature => return Err(Refusal::Unmodelled),
        }
        if !self.clocks_are_allowed() {
            return Err(Refusal::ClockLimit);
        }
        if self.flash.is_fast_enough(self.rcc.clocks().hclk) { Ok(()) } else { Err(Refusal::Misuse) }
    }
}

impl Gpio {
    /// MODER to LCKR, AFRL and AFRH: those with two bits for each pin, one bit, or four.
    fn stored(&self, has_pin: impl Fn(u32) -> bool) -> Vec<(u32, u32)> {
        let spread = |width: u32, pins: std::ops::Range<u32>| {
            let first = pins.start;
            let there = pins.filter(|n| has_pin(*n));
            there.fold(0, |bits, n| bits | ((1 << width) - 1) << (width * (n - first)))
        };
        let (one, two) = (spread(1, 0..16), spread(2, 0..16));
        let (low, high) = (spread(4, 0..8), spread(4, 8..16));
        [
            (0x00, two),
            (0x04, one),
            (0x08, two),
            (0x0C, two),
            (0x14, one),
            (0x1C, one | 1 << 16),
            (0x20, low),
            (0x24, high),
        ]
        .to_vec()
    }

    fn flip(&mut self, at: Time, offset: u32, mask: u32) -> Vec<super::PinChange> {
        let mut changes = Vec::new();
        let word = self.words[offset as usize / 4] ^ mask;
        self.write(at, offset, word, &mut changes);
        changes
    }
}

impl Rcc {
    /// CR without ready flags and calibration, PLLCFGR, CFGR, CIR, the resets, enables and low-power enables of the peripherals that the
    /// part has, LSION. The backup domain is not listed.
    fn stored(&self) -> Vec<(u32, u32)> {
        let family = self.model.part.family() as usize;
        let of_low_power = |offset: u32| {
            rcc::AT_RESET.iter().find(|(at, _)| *at == offset).map_or(0, |(_, bits)| bits[family])
        };
        let mut all =
            vec![(0x00, 0x050D_00F9), (0x04, 0x0F43_7FFF), (0x08, 0xFFFF_FCF3), (0x0C, 0x3F00), (0x74, 1)];
        for bus in [0x00, 0x04, 0x08, 0x10, 0x14] {
            let bits = of_low_power(0x50 + bus);
            all.extend([rcc::AHB1RSTR, rcc::AHB1ENR, 0x50].map(|first| (first + bus, bits)));
        }
        all
    }

    fn flip(&mut self, now: Now, offset: u32, mask: u32) {
        let word = self.words[offset as usize / 4] ^ mask;
        self.write(now, offset, word);
    }
}

impl Dma {
    /// The flags, and of each stream CR, NDTR, the addresses and FCR.
    fn stored(&self) -> Vec<(u32, u32)> {
        let of_stream = [
            (dma::CR, dma::CR_BITS),
            (dma::NDTR, 0xFFFF),
            (dma::PAR, !0),
            (dma::M0AR, !0),
            (dma::M1AR, !0),
            (dma::FCR, 0x87),
        ];
        let streams = (dma::FIRST_STREAM..dma::LAST).step_by(dma::STREAM_LEN as usize);
        let flags = dma::FLAG_SHIFT.iter().fold(0, |bits, shift| bits | dma::FLAGS << shift);
        let registers = streams.flat_map(|first| of_stream.map(|(register, bits)| (first + register, bits)));
        [(dma::LISR, flags), (dma::HISR, flags)].into_iter().chain(registers).collect()
    }

    /// Inverts a bit. A stream that is on does not protect its registers from an upset.
    fn flip(&mut self, offset: u32, bit: u32) -> Result<(), Refusal> {
        let mask: u32 = 1 << bit;
        if offset < dma::FIRST_STREAM {
            let shifts = dma::FLAG_SHIFT.iter().rposition(|shift| *shift <= bit).unwrap_or(0);
            let stream = shifts + if offset == dma::HISR { 4 } else { 0 };
            self.streams[stream].flags ^= mask >> dma::FLAG_SHIFT[shifts];
            return Ok(());
        }
        let at = offset - dma::FIRST_STREAM;
        let number = (at / dma::STREAM_LEN) as usize;
        let stream = &mut self.streams[number];
        match at % dma::STREAM_LEN {
            dma::CR => stream.cr ^= mask,
            dma::NDTR => stream.ndtr ^= mask,
            dma::PAR => stream.par ^= mask,
            dma::M0AR => stream.m0ar ^= mask,
            dma::M1AR => stream.m1ar ^= mask,
            _ => stream.fcr ^= mask,
        }
        let is_modelled = stream.is_modelled();
        self.follow(number);
        if is_modelled { Ok(()) } else { Err(Refusal::Unmodelled) }
    }
}

impl Iwdg {
    /// Inverts bits of PR or RLR. The counter takes a new reload value when it is next reloaded.
    fn flip(&mut self, now: Time, offset: u32, mask: u32) {
        match offset {
            iwdg::PR => self.set_prescaler(now, self.pr ^ mask),
            _ => self.rlr ^= mask,
        }
    }
}
