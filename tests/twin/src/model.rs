//! The boards that the twin knows: which part, which oscillator.

/// Where the main flash memory begins; it answers at zero as well.
pub const FLASH_BASE: u32 = 0x0800_0000;

/// A microcontroller. What the parts share is modelled once; what differs is told here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// STM32F405RG: 1 MiB of flash, 64 KiB of CCM, ports A to I (RM0090, DS8626).
    Stm32f405,
    /// STM32F446RE: 512 KiB of flash, no CCM, ports A to H, over-drive, a third PLL (RM0390, DS10693).
    Stm32f446,
}

impl Part {
    /// Bytes of flash at 0800 0000h.
    pub const fn flash_bytes(self) -> u32 {
        match self {
            Part::Stm32f405 => 1 << 20,
            Part::Stm32f446 => 512 << 10,
        }
    }

    /// Bytes of core-coupled memory at 1000 0000h.
    pub const fn ccm_bytes(self) -> u32 {
        match self {
            Part::Stm32f405 => 64 << 10,
            Part::Stm32f446 => 0,
        }
    }

    /// Number of GPIO ports, from A on.
    pub(crate) const fn ports(self) -> usize {
        match self {
            Part::Stm32f405 => 9,
            Part::Stm32f446 => 8,
        }
    }

    /// DBGMCU_IDCODE: F405 revision Y, F446 revision A.
    pub(crate) const fn idcode(self) -> u32 {
        match self {
            Part::Stm32f405 => 0x100F_6413,
            Part::Stm32f446 => 0x1000_6421,
        }
    }
}

/// What drives OSC_IN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Oscillator {
    /// Nominal frequency.
    pub hz: u64,
    /// A clock from outside, for which the program must bypass the oscillator of the part; otherwise a crystal.
    pub external: bool,
}

/// A board: part and oscillator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Model {
    /// The microcontroller.
    pub part: Part,
    /// Its high-speed oscillator.
    pub oscillator: Oscillator,
    /// Pins of the package: 64, 100, 144 or 176.
    pub package_pins: u32,
}

impl Model {
    /// pyboard v1.1: a crystal of 12 MHz.
    pub const PYBOARD_V11: Model = Model {
        part: Part::Stm32f405,
        oscillator: Oscillator { hz: 12_000_000, external: false },
        package_pins: 64,
    };

    /// NUCLEO-F446RE: 8 MHz from the ST-LINK.
    pub const NUCLEO_F446RE: Model = Model {
        part: Part::Stm32f446,
        oscillator: Oscillator { hz: 8_000_000, external: true },
        package_pins: 64,
    };
}
