//! The parts that the twin models: each STM32F4 with two bxCAN controllers that reaches 168 MHz.
//!
//! A *part* is the chip as marked: `STM32F407VG` is the line STM32F407 in a package with 100 pins (V) with 1 MiB of
//! flash (G). [`Part::named`] reads such a name. Common features of the lines are modelled once; this table contains
//! the differences.
//!
//! Flash of 2 MiB has two banks: sectors 12 to 23 are in the second one, and the core runs from the first bank while the
//! second one is erased. Flash of up to 1 MiB is one bank: the bit DB1M, which divides 1 MiB in two, is refused. So are BFB2 and the write
//! protection of the second bank (OPTCR1).

mod lines;
mod package;

use std::fmt;

pub(crate) use lines::{Family, Lines, TABLE};
use lines::{ProductLine, REFUSED};

use crate::pin::Pin;

const KIB: u32 = 1 << 10;

/// A microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Part {
    line: &'static ProductLine,
    /// Letter of the package.
    package: char,
    /// Letter of the flash size.
    size: char,
    flash_bytes: u32,
    package_pins: u32,
}

impl Part {
    /// The part with this name: line, package and flash size, as `STM32F407VG`. Letters after these eleven characters
    /// (`STM32F407VGT6`, `STM32F446RETx`) mean housing and temperature, and are ignored.
    ///
    /// # Errors
    /// For a part that is not modelled: the reason, and the modelled parts.
    pub fn named(name: &str) -> Result<Part, String> {
        let upper = name.to_ascii_uppercase();
        if let Some((_, why)) = REFUSED.iter().find(|(line, _)| upper.starts_with(line)) {
            return Err(format!("{why}; {}", allowed_lines()));
        }
        let line = TABLE.iter().find(|line| upper.starts_with(line.name));
        let line = line.ok_or_else(|| format!("no part that the twin models; {}", allowed_lines()))?;
        let mut rest = upper[line.name.len()..].chars();
        let package = rest.next().filter(|letter| line.packages.contains(*letter));
        let package = package.ok_or_else(|| {
            let packages: Vec<_> = line
                .packages
                .chars()
                .map(|letter| format!("{letter} ({} pins)", package::pins(letter)))
                .collect();
            format!(
                "no package of the {} that the twin models; allowed are {}",
                line.name,
                packages.join(", ")
            )
        })?;
        let size = rest.next().filter(|letter| line.sizes.contains(*letter));
        let size = size.ok_or_else(|| {
            let sizes: Vec<_> = line
                .sizes
                .chars()
                .map(|letter| format!("{letter} ({} KiB)", flash_bytes(letter) / KIB))
                .collect();
            format!("no flash size of the {}; allowed are {}", line.name, sizes.join(", "))
        })?;
        if rest.any(|letter| !letter.is_ascii_alphanumeric()) {
            return Err(format!("no name of a part; allowed is {}{package}{size}", line.name));
        }
        Ok(Part { line, package, size, flash_bytes: flash_bytes(size), package_pins: package::pins(package) })
    }

    /// Bytes of flash at 0800 0000h.
    pub const fn flash_bytes(self) -> u32 {
        self.flash_bytes
    }

    /// Bytes of SRAM at 2000 0000h.
    pub const fn ram_bytes(self) -> u32 {
        self.line.ram_kib * KIB
    }

    /// Bytes of core-coupled memory at 1000 0000h.
    pub const fn ccm_bytes(self) -> u32 {
        self.line.ccm_kib * KIB
    }

    /// Pins of the package: 64 to 216.
    pub const fn package_pins(self) -> u32 {
        self.package_pins
    }

    /// Returns whether the package has this pin.
    pub fn has_pin(self, pin: Pin) -> bool {
        pin.port_index() < self.ports() && package::has(self.family(), self.package, pin)
    }

    /// Bank of the flash, 0 or 1, at this offset from 0800 0000h.
    pub(crate) const fn bank_of(self, offset: u32) -> u32 {
        offset / (1024 * KIB)
    }

    /// Number of GPIO ports, from A on.
    pub(crate) const fn ports(self) -> usize {
        self.line.ports
    }

    /// Returns its family, which shares RCC, PWR, ADC and revision.
    pub(crate) const fn family(self) -> Family {
        self.line.family
    }

    /// Its line, as a set with one member.
    pub(crate) const fn lines(self) -> Lines {
        self.line.bit
    }

    /// DEV_ID of DBGMCU_IDCODE. Lines of one family share it.
    pub const fn device_id(self) -> u32 {
        self.idcode() & 0xFFF
    }

    /// Names of the lines with this DEV_ID: `STM32F446`. None for a chip that is not modelled.
    pub(crate) fn lines_with(device_id: u32) -> Vec<&'static str> {
        let lines = TABLE.iter().filter(|line| line.family.idcode() & 0xFFF == device_id);
        lines.map(|line| line.name).collect()
    }

    /// DBGMCU_IDCODE.
    pub(crate) const fn idcode(self) -> u32 {
        self.line.family.idcode()
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.line.name, self.package, self.size)
    }
}

impl fmt::Debug for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

const fn flash_bytes(size: char) -> u32 {
    match size {
        'C' => 256 * KIB,
        'E' => 512 * KIB,
        'G' => 1024 * KIB,
        _ => 2048 * KIB,
    }
}

fn allowed_lines() -> String {
    let names: Vec<_> = TABLE.iter().map(|line| line.name).collect();
    format!(
        "allowed are {}, each with the letters of package and flash size, such as STM32F407VG",
        names.join(", ")
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The part of a test.
    pub(crate) fn part(name: &str) -> Part {
        Part::named(name).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Memories by the data sheets: DS8626, DS8597, DS9405, DS9484, DS10693, DS11189.
    #[test]
    fn memories_are_those_of_the_data_sheet() {
        for (name, flash, ram, ccm, pins) in [
            ("STM32F405RG", 1024, 128, 64, 64),
            ("STM32F407VE", 512, 128, 64, 100),
            ("STM32F415ZG", 1024, 128, 64, 144),
            ("STM32F417IG", 1024, 128, 64, 176),
            ("STM32F427VI", 2048, 192, 64, 100),
            ("STM32F429BE", 512, 192, 64, 208),
            ("STM32F437ZG", 1024, 192, 64, 144),
            ("STM32F439NI", 2048, 192, 64, 216),
            ("STM32F446RC", 256, 128, 0, 64),
            ("STM32F446RETx", 512, 128, 0, 64),
            ("STM32F469NIH6", 2048, 320, 64, 216),
            ("stm32f479zg", 1024, 320, 64, 144),
        ] {
            let part = part(name);
            let kib = [part.flash_bytes(), part.ram_bytes(), part.ccm_bytes()].map(|bytes| bytes >> 10);
            assert_eq!((kib, part.package_pins()), ([flash, ram, ccm], pins), "{name}");
        }
        assert_eq!(part("STM32F407VGT6").to_string(), "STM32F407VG");
    }

    /// Given a name that is not modelled, then the error contains the reason and the allowed names.
    #[test]
    fn other_parts_are_refused_with_the_reason() {
        for (name, said) in [
            ("STM32F412RG", &["at most 100 MHz", "STM32F405"][..]),
            ("STM32F413VG", &["at most 100 MHz", "three bxCAN", "STM32F469"]),
            ("STM32F423VH", &["at most 100 MHz", "three bxCAN"]),
            ("STM32F411RE", &["no CAN controller", "STM32F446"]),
            ("STM32H743ZI", &["no part that the twin models", "STM32F439"]),
            ("", &["no part that the twin models"]),
            ("STM32F405OG", &["no package", "R (64 pins), V (100 pins), Z (144 pins)"]),
            ("STM32F407RG", &["no package", "V (100 pins), Z (144 pins), I (176 pins)"]),
            ("STM32F405RE", &["no flash size", "G (1024 KiB)"]),
            ("STM32F429Z", &["no flash size", "E (512 KiB), G (1024 KiB), I (2048 KiB)"]),
            ("STM32F405RG-1", &["no name of a part", "STM32F405RG"]),
        ] {
            let error = Part::named(name).expect_err(name);
            assert!(said.iter().all(|part| error.contains(part)), "{name}: {error}");
        }
    }

    /// Pins by the data sheets: which a package has, and which ones the DSI host of the F469 takes.
    #[test]
    fn packages_have_the_pins_of_the_data_sheet() {
        for (name, port, number, has) in [
            ("STM32F405RG", 'D', 2, true),
            ("STM32F405RG", 'D', 0, false),
            ("STM32F405RG", 'H', 1, true),
            ("STM32F407VG", 'E', 15, true),
            ("STM32F407VG", 'F', 0, false),
            ("STM32F407ZG", 'G', 15, true),
            ("STM32F407IG", 'I', 11, true),
            ("STM32F407IG", 'I', 12, false),
            ("STM32F429NI", 'K', 7, true),
            ("STM32F429NI", 'K', 8, false),
            ("STM32F429II", 'J', 0, false),
            ("STM32F446RE", 'B', 11, false),
            ("STM32F446ZE", 'B', 11, true),
            ("STM32F469VI", 'C', 4, false),
            ("STM32F469ZI", 'F', 6, false),
            ("STM32F469II", 'H', 13, false),
            ("STM32F469NI", 'H', 13, true),
            ("STM32F469NI", 'K', 0, false),
        ] {
            assert_eq!(part(name).has_pin(Pin::new(port, number)), has, "{name} P{port}{number}");
        }
    }
}
