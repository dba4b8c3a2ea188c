//! CRC unit and random number generator.

use super::Clocks;

/// CRC unit (RM0090 chapter 4): polynomial 04C1 1DB7h over words, highest bit first.
#[derive(Clone, Debug)]
pub struct Crc {
    dr: u32,
    idr: u32,
}

impl Default for Crc {
    fn default() -> Self {
        Crc { dr: u32::MAX, idr: 0 }
    }
}

impl Crc {
    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.dr),
            0x04 => Some(self.idr),
            0x08 => Some(0),
            _ => None,
        }
    }

    /// A store; `None` for what does not exist.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        const POLYNOMIAL: u32 = 0x04C1_1DB7;
        match offset {
            0x00 => {
                let step = |crc: u32, _| crc << 1 ^ if crc >> 31 == 1 { POLYNOMIAL } else { 0 };
                self.dr = (0..32).fold(self.dr ^ value, step);
            }
            0x04 => self.idr = value & 0xFF,
            0x08 if value & 1 == 1 => self.dr = u32::MAX,
            0x08 => {}
            _ => return None,
        }
        Some(())
    }
}

/// Random number generator of the F405 (RM0090 chapter 24). Its numbers follow from the board's serial number.
#[derive(Clone, Debug)]
pub struct Rng {
    serial: u32,
    state: u64,
    cr: u32,
    /// CEIS; SEIS never sets.
    clock_error: u32,
    /// The cycle at which the next number is there, and the cycles from one to the next.
    ready_at: Option<u64>,
    interval: u64,
}

impl Rng {
    const RNGEN: u32 = 1 << 2;
    const IE: u32 = 1 << 3;
    const DRDY: u32 = 1 << 0;
    const CECS: u32 = 1 << 1;
    const CEIS: u32 = 1 << 5;
    /// Periods of RNG_CLK from one number to the next.
    const PERIODS: u64 = 40;

    /// After power-on.
    pub fn new(serial: u32) -> Self {
        let state = u64::from(serial) << 32 | 0x9E37_79B9;
        Rng { serial, state, cr: 0, clock_error: 0, ready_at: None, interval: 0 }
    }

    /// RCC or a system reset.
    pub fn reset(&mut self) {
        *self = Rng { state: self.state, ..Rng::new(self.serial) };
    }

    fn is_ready(&self, cycle: u64) -> bool {
        self.ready_at.is_some_and(|at| at <= cycle)
    }

    /// The interrupt line at `cycle`.
    pub fn irq(&self, cycle: u64) -> bool {
        self.cr & Self::IE != 0 && (self.is_ready(cycle) || self.clock_error & Self::CEIS != 0)
    }

    /// The cycle at which the line may rise.
    pub fn next_event(&self) -> Option<u64> {
        self.ready_at.filter(|_| self.cr & Self::IE != 0)
    }

    /// A load; `None` for what does not exist.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.cr),
            0x04 => Some(self.clock_error | if self.is_ready(cycle) { Self::DRDY } else { 0 }),
            0x08 if self.is_ready(cycle) => {
                self.ready_at = Some(cycle + self.interval);
                // SplitMix64.
                self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
                let mixed = (self.state ^ self.state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
                Some((mixed ^ mixed >> 31) as u32)
            }
            0x08 => Some(0),
            _ => None,
        }
    }

    /// A store; `None` for what does not exist. RNG_CLK is `pll48` and must be faster than a sixteenth of HCLK.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32, clocks: Clocks, pll48: u64) -> Option<()> {
        match offset {
            0x00 => {
                let risen = value & !self.cr & Self::RNGEN != 0;
                self.cr = value & (Self::RNGEN | Self::IE);
                if value & Self::RNGEN == 0 {
                    self.ready_at = None;
                } else if risen && pll48 * 16 < clocks.hclk {
                    self.clock_error = Self::CECS | Self::CEIS;
                } else if risen {
                    self.interval = Self::PERIODS * clocks.hclk / pll48;
                    self.ready_at = Some(cycle + self.interval);
                }
            }
            // CEIS and SEIS clear by writing 0.
            0x04 => self.clock_error &= value | Self::CECS,
            0x08 => {}
            _ => return None,
        }
        Some(())
    }
}
