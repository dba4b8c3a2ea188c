//! The lines of parts.

/// Lines that share RCC, PWR and ADC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Family {
    /// STM32F405, 407, 415, 417 (RM0090).
    F405,
    /// STM32F427, 429, 437, 439 (RM0090): over-drive, a third PLL.
    F42x,
    /// STM32F446 (RM0390): over-drive, a third PLL, clock gating.
    F446,
    /// STM32F469, 479 (RM0386): over-drive, a third PLL.
    F469,
}

impl Family {
    /// DBGMCU_IDCODE (RM0090 38.6.1; RM0390 and RM0386, chapter "Debug support"): F405 revision Y, F42x revision Y, F446 and F469 revision A.
    pub(crate) const fn idcode(self) -> u32 {
        match self {
            Family::F405 => 0x100F_6413,
            Family::F42x => 0x1003_6419,
            Family::F446 => 0x1000_6421,
            Family::F469 => 0x1000_6434,
        }
    }
}

/// A set of lines, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Lines(u16);

impl Lines {
    pub(crate) const F405: Lines = Lines(1 << 0);
    pub(crate) const F407: Lines = Lines(1 << 1);
    pub(crate) const F415: Lines = Lines(1 << 2);
    pub(crate) const F417: Lines = Lines(1 << 3);
    pub(crate) const F427: Lines = Lines(1 << 4);
    pub(crate) const F429: Lines = Lines(1 << 5);
    pub(crate) const F437: Lines = Lines(1 << 6);
    pub(crate) const F439: Lines = Lines(1 << 7);
    pub(crate) const F446: Lines = Lines(1 << 8);
    pub(crate) const F469: Lines = Lines(1 << 9);
    pub(crate) const F479: Lines = Lines(1 << 10);

    /// The four lines of [`Family::F405`].
    pub(crate) const F40X: Lines = Lines::F405.and(Lines::F407).and(Lines::F415).and(Lines::F417);
    /// The four lines of [`Family::F42x`].
    pub(crate) const F42X: Lines = Lines::F427.and(Lines::F429).and(Lines::F437).and(Lines::F439);
    /// The two lines of [`Family::F469`].
    pub(crate) const F46X: Lines = Lines::F469.and(Lines::F479);
    pub(crate) const ALL: Lines = Lines::F40X.and(Lines::F42X).and(Lines::F446).and(Lines::F46X);

    /// Returns the union of the sets.
    pub(crate) const fn and(self, other: Lines) -> Lines {
        Lines(self.0 | other.0)
    }

    /// Returns this set without the other one.
    pub(crate) const fn without(self, other: Lines) -> Lines {
        Lines(self.0 & !other.0)
    }

    /// Returns whether the sets have a line in common.
    pub(crate) const fn has(self, other: Lines) -> bool {
        self.0 & other.0 != 0
    }
}

/// A line of parts.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) struct ProductLine {
    /// First nine characters of the name.
    pub(crate) name: &'static str,
    /// The set of this line alone.
    pub(super) bit: Lines,
    /// Family with common peripherals.
    pub(super) family: Family,
    /// Letters of its packages.
    pub(super) packages: &'static str,
    /// Letters of its flash sizes.
    pub(super) sizes: &'static str,
    /// SRAM from 2000 0000h on, KiB.
    pub(super) ram_kib: u32,
    /// Core-coupled memory, KiB.
    pub(super) ccm_kib: u32,
    /// GPIO ports, from A on.
    pub(super) ports: usize,
}

const fn line(
    name: &'static str,
    bit: Lines,
    family: Family,
    packages: &'static str,
    sizes: &'static str,
) -> ProductLine {
    let (ram_kib, ccm_kib, ports) = match family {
        Family::F405 => (128, 64, 9),
        Family::F42x => (192, 64, 11),
        Family::F446 => (128, 0, 8),
        Family::F469 => (320, 64, 11),
    };
    ProductLine { name, bit, family, packages, sizes, ram_kib, ccm_kib, ports }
}

/// By the data sheets DS8626, DS8597, DS9405, DS9484, DS10693, DS11189. Packages whose pins are not in the model (O, A, M, Y) are left out.
pub(crate) const TABLE: &[ProductLine] = &[
    line("STM32F405", Lines::F405, Family::F405, "RVZ", "G"),
    line("STM32F407", Lines::F407, Family::F405, "VZI", "EG"),
    line("STM32F415", Lines::F415, Family::F405, "RVZ", "G"),
    line("STM32F417", Lines::F417, Family::F405, "VZI", "EG"),
    line("STM32F427", Lines::F427, Family::F42x, "VZI", "GI"),
    line("STM32F429", Lines::F429, Family::F42x, "VZIBN", "EGI"),
    line("STM32F437", Lines::F437, Family::F42x, "VZI", "GI"),
    line("STM32F439", Lines::F439, Family::F42x, "VZIBN", "GI"),
    line("STM32F446", Lines::F446, Family::F446, "RVZ", "CE"),
    line("STM32F469", Lines::F469, Family::F469, "VZIBN", "EGI"),
    line("STM32F479", Lines::F479, Family::F469, "VZIBN", "GI"),
];

/// Lines of the family STM32F4 that are not modelled, and the reasons.
pub(super) const REFUSED: &[(&str, &str)] = &[
    ("STM32F401", "the STM32F401 has no CAN controller"),
    ("STM32F410", "the STM32F410 has no CAN controller"),
    ("STM32F411", "the STM32F411 has no CAN controller"),
    ("STM32F412", "the STM32F412 runs at most 100 MHz, and has another map of peripherals"),
    (
        "STM32F413",
        "the STM32F413 runs at most 100 MHz, and has three bxCAN with another arrangement of filters",
    ),
    (
        "STM32F423",
        "the STM32F423 runs at most 100 MHz, and has three bxCAN with another arrangement of filters",
    ),
];
