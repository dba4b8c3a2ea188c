//! Settings of the PLL for a board's oscillator, computed at compile time, so that an impossible setting stops the
//! build.
//!
//! The *PLL* makes the clock of the core, HCLK, from the oscillator of the board, HSE:
//!
//! ```text
//!         /M                 *N                   /P
//! HSE ---------> VCO input ---------> VCO output ---------> SYSCLK = HCLK ---------> APB1, APB2
//!      2 to 63   1 to 2 MHz  50 to 432  100 to 432 MHz  2, 4, 6, 8      dividers
//! ```
//!
//! A board has an [`Oscillator`]:
//!
//! ```text
//! const OSCILLATOR: Oscillator = Oscillator::crystal(12_000_000);
//! const CLOCKS: Clocks = match Clocks::new(OSCILLATOR, 168_000_000) {
//!     Ok(clocks) => clocks,
//!     Err(error) => panic!("{}", error.message().as_str()),
//! };
//! ```
//!
//! Each whole number of MHz within the range of the oscillator gives a setting. Some other frequencies do too, as 19.2
//! MHz. HCLK is exact: an error of the clock would use up the oscillator tolerance of the CAN network.
//!
//! HCLK is 168 MHz or 84 MHz. Both give APB1 42 MHz and its timers 84 MHz. Bit timing and time stamps depend on these.
//!
//! Sources: RM0090 6.3.2 and 7.3.2, RM0390 6.3.2, RM0386 6.3.2 (RCC_PLLCFGR); DS8626, tables of HSE and PLL characteristics.

mod error;
#[cfg(test)]
mod tests;

pub use error::ClockError;

/// Clock of APB1, and so of the CAN controllers, in Hz.
pub const PCLK1: u32 = 42_000_000;
/// Clock of the timers of APB1, in Hz: twice that of APB1, because APB1 is divided.
pub const TIMERS: u32 = 84_000_000;

/// Oscillator of a board, at the pin OSC_IN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Oscillator {
    hz: u32,
    kind: OscillatorKind,
}

/// Kind of an oscillator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OscillatorKind {
    /// Crystal or ceramic resonator between OSC_IN and OSC_OUT, 4 to 26 MHz.
    Crystal,
    /// Clock from outside at OSC_IN, 1 to 50 MHz. The chip's own oscillator is bypassed (HSEBYP).
    External,
}

impl Oscillator {
    /// Makes a crystal or ceramic resonator with this frequency in Hz, 4 MHz to 26 MHz. [`Clocks::new`] checks the range.
    pub const fn crystal(hz: u32) -> Oscillator {
        Oscillator { hz, kind: OscillatorKind::Crystal }
    }

    /// Makes an external clock with this frequency in Hz, 1 MHz to 50 MHz. [`Clocks::new`] checks the range.
    pub const fn external(hz: u32) -> Oscillator {
        Oscillator { hz, kind: OscillatorKind::External }
    }

    /// Returns the frequency in Hz.
    pub const fn hz(self) -> u32 {
        self.hz
    }

    /// Returns the kind.
    pub const fn kind(self) -> OscillatorKind {
        self.kind
    }
}

impl OscillatorKind {
    /// Returns the least and the greatest frequency in MHz (DS8626, characteristics of HSE).
    const fn range(self) -> (u32, u32) {
        match self {
            OscillatorKind::Crystal => (4, 26),
            OscillatorKind::External => (1, 50),
        }
    }
}

const MHZ: u32 = 1_000_000;
/// Least and greatest PLLM.
const PREDIV: (u8, u8) = (2, 63);
/// Least and greatest PLLN. Other values would violate the limits of the VCO.
const MULTIPLIER: (u16, u16) = (50, 432);
/// Greatest PLLP. PLLP is even.
const DIVIDER: u8 = 8;
/// Least and greatest frequency of the VCO's input, MHz.
const VCO_INPUT: (u32, u32) = (1, 2);
/// Least and greatest frequency of the VCO's output, MHz.
const VCO_OUTPUT: (u32, u32) = (100, 432);

/// Settings of the main PLL and of the dividers behind it. AHB is not divided: HCLK is SYSCLK.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// PLLM: divides HSE to the input of the VCO. 2 to 63.
    pub prediv: u8,
    /// PLLN: multiplies the input of the VCO to its output. 50 to 432.
    pub multiplier: u16,
    /// PLLP: divides the output of the VCO to SYSCLK. 2, 4, 6 or 8.
    pub divider: u8,
    /// Clock of the core, in Hz.
    pub hclk: u32,
    /// PPRE1: divides HCLK to APB1, 42 MHz. 4 or 2.
    pub apb1: u8,
    /// PPRE2: divides HCLK to APB2, 84 MHz. 2 or 1.
    pub apb2: u8,
}

impl Clocks {
    /// Finds the settings for `hclk`, in Hz: 168 MHz or 84 MHz.
    ///
    /// Of all settings whose VCO input is a whole number of Hz it takes those with the highest VCO input, up to 2 MHz, which
    /// gives the least jitter. Of these it takes the one with the highest VCO output.
    ///
    /// # Errors
    /// [`ClockError`]: oscillator out of range, another HCLK, or no setting that gives HCLK exactly.
    pub const fn new(oscillator: Oscillator, hclk: u32) -> Result<Clocks, ClockError> {
        let Oscillator { hz, kind } = oscillator;
        let (first, last) = kind.range();
        if hz < first * MHZ || hz > last * MHZ {
            return Err(ClockError::OscillatorRange { hz, kind });
        }
        let (apb1, apb2) = match hclk {
            168_000_000 => (4, 2),
            84_000_000 => (2, 1),
            _ => return Err(ClockError::Hclk { hclk }),
        };
        // The least PLLM gives the highest VCO input, and the greatest PLLP the highest VCO output.
        let mut prediv = PREDIV.0;
        while prediv <= PREDIV.1 {
            let mut divider = DIVIDER;
            while divider >= 2 {
                if let Some(multiplier) = multiplier(hz, prediv, divider, hclk) {
                    return Ok(Clocks { prediv, multiplier, divider, hclk, apb1, apb2 });
                }
                divider -= 2;
            }
            prediv += 1;
        }
        Err(ClockError::NoPll { hz, hclk })
    }
}

/// Returns the PLLN that gives HCLK exactly with this PLLM and PLLP. `None` when there is none within all limits.
///
/// The input of the VCO is a whole number of Hz: the HAL computes in whole Hz, so it would take a rounded clock for a
/// slower one.
const fn multiplier(hz: u32, prediv: u8, divider: u8, hclk: u32) -> Option<u16> {
    let (input, output) = (hz / prediv as u32, hclk * divider as u32);
    let input_is_whole = hz.is_multiple_of(prediv as u32);
    if !input_is_whole || input < VCO_INPUT.0 * MHZ || input > VCO_INPUT.1 * MHZ {
        return None;
    }
    if output < VCO_OUTPUT.0 * MHZ || output > VCO_OUTPUT.1 * MHZ || !output.is_multiple_of(input) {
        return None;
    }
    // In 50 to 432, because of the limits of the VCO.
    Some((output / input) as u16)
}
