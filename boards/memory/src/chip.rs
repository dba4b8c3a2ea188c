//! The chips: their memories and the number by which they identify themselves.

use crate::Error;

/// A supported chip.
///
/// Its name is the feature of embassy-stm32: the line (`stm32f405`), a letter for the package and one for the size of the flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chip {
    name: String,
    family: &'static Family,
    flash_kib: u32,
}

/// Product lines with the same memories and the same DEV_ID.
#[derive(Debug, PartialEq, Eq)]
struct Family {
    /// Digits of the lines after `stm32f`, for example `405`.
    lines: &'static [&'static str],
    /// Letters of the flash sizes that exist in these lines.
    flash: &'static [char],
    /// Contiguous SRAM from 2000 0000h on, KiB.
    ram_kib: u32,
    /// CCM from 1000 0000h on, KiB.
    ccm_kib: u32,
    /// DEV_ID of DBGMCU_IDCODE.
    device_id: u16,
}

/// Sources: DS8626, DS8597 (F405 to F417), DS9405, DS9484 (F427 to F439), DS10693 (F446), DS11189 (F469, F479); DEV_ID from the
/// chapters "Debug support" of RM0090, RM0390 and RM0386.
const FAMILIES: [Family; 4] = [
    Family {
        lines: &["405", "407", "415", "417"],
        flash: &['e', 'g'],
        ram_kib: 112 + 16,
        ccm_kib: 64,
        device_id: 0x413,
    },
    Family {
        lines: &["427", "429", "437", "439"],
        flash: &['e', 'g', 'i'],
        ram_kib: 112 + 16 + 64,
        ccm_kib: 64,
        device_id: 0x419,
    },
    Family { lines: &["446"], flash: &['c', 'e'], ram_kib: 112 + 16, ccm_kib: 0, device_id: 0x421 },
    Family {
        lines: &["469", "479"],
        flash: &['e', 'g', 'i'],
        ram_kib: 160 + 32 + 128,
        ccm_kib: 64,
        device_id: 0x434,
    },
];

/// STM32F4 lines that are refused, and why.
const REFUSED: [(&[&str], &str); 3] = [
    (&["401", "410", "411"], "this line has no CAN controller"),
    (&["412"], "this line reaches 100 MHz, and boards run at 168 MHz"),
    (
        &["413", "423"],
        "this line reaches 100 MHz, and boards run at 168 MHz; it has three CAN controllers, and boards drive two",
    ),
];

const SUPPORTED: &str = "supported are STM32F405, 407, 415, 417, 427, 429, 437, 439, 446, 469 and 479";

impl Chip {
    /// Finds a chip by its name, as `stm32f405rg`, in either case.
    ///
    /// # Errors
    /// [`Error::Chip`] for a chip that is not supported, with the reason.
    pub fn named(name: &str) -> Result<Chip, Error> {
        let lower = name.to_ascii_lowercase();
        Chip::find(&lower).map_err(|reason| Error::Chip { chip: lower, reason })
    }

    fn find(name: &str) -> Result<Chip, String> {
        let Some(rest) = name.strip_prefix("stm32f4") else {
            return Err(format!(
                "it is no STM32F4, and flash, clocks and CAN controllers of other families differ; {SUPPORTED}"
            ));
        };
        let complete = rest.len() == 4 && rest.bytes().all(|byte| byte.is_ascii_alphanumeric());
        if !complete {
            return Err(
                "a name has a letter for the package and one for the size of the flash behind the line, as \
                        stm32f405rg"
                    .to_owned(),
            );
        }
        let (line, size) = (&name[6..9], name.as_bytes()[10] as char);
        if let Some((_, why)) = REFUSED.iter().find(|(lines, _)| lines.contains(&line)) {
            return Err(format!("{why}; {SUPPORTED}"));
        }
        let family = FAMILIES.iter().find(|family| family.lines.contains(&line));
        let family = family.ok_or_else(|| format!("its line is unknown; {SUPPORTED}"))?;
        let flash_kib = match size {
            _ if !family.flash.contains(&size) => {
                return Err(format!(
                    "no flash size {size} of its line is known; known are {}",
                    sizes(family)
                ));
            }
            'c' => {
                return Err("the parameter store needs two sectors of 128 KiB, and flash of 256 KiB has one; take a chip \
                            with 512 KiB, its last letter is e"
                    .to_owned());
            }
            other => kib(other),
        };
        Ok(Chip { name: name.to_owned(), family, flash_kib })
    }

    /// Returns the name, as the feature of embassy-stm32: `stm32f405rg`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the size of the flash from 0800 0000h on, in KiB: 512, 1024 or 2048.
    pub fn flash_kib(&self) -> u32 {
        self.flash_kib
    }

    /// Returns the size of the contiguous SRAM from 2000 0000h on, in KiB.
    pub fn ram_kib(&self) -> u32 {
        self.family.ram_kib
    }

    /// Returns the size of the CCM at 1000 0000h, in KiB. Zero where there is none.
    pub fn ccm_kib(&self) -> u32 {
        self.family.ccm_kib
    }

    /// Returns DEV_ID of the register DBGMCU_IDCODE, by which the chip identifies itself.
    pub fn device_id(&self) -> u16 {
        self.family.device_id
    }
}

fn kib(letter: char) -> u32 {
    match letter {
        'c' => 256,
        'e' => 512,
        'g' => 1024,
        _ => 2048,
    }
}

fn sizes(family: &Family) -> String {
    let sizes: Vec<_> =
        family.flash.iter().map(|letter| format!("{letter} ({} KiB)", kib(*letter))).collect();
    sizes.join(", ")
}
