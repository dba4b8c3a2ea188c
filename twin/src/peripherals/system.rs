//! Small blocks that firmware only sets up and reads back: PWR, DBGMCU, device signature.

use crate::bxcan::Side;
use crate::part::{Family, Part};

/// Words of DBGMCU: APB1_FZ, behind it APB2_FZ.
const APB1_FZ: usize = 2;
const IWDG_STOP: u32 = 1 << 12;
const CAN_STOP: [u32; 2] = [1 << 25, 1 << 26];

/// PWR, RM0090 chapter 5 (F405, F42x), RM0390 chapter 5 (F446), RM0386 chapter 5 (F469). The regulator reaches its scale and over-drive at once; Stop
/// and Standby are not modelled.
#[derive(Clone, Debug)]
pub struct Pwr {
    part: Part,
    pub(super) cr: u32,
    csr: u32,
}

impl Pwr {
    /// After a reset.
    pub fn new(part: Part) -> Self {
        let cr = match part.family() {
            Family::F405 => 0x0000_4000,
            Family::F42x | Family::F446 | Family::F469 => 0x0000_C000,
        };
        Pwr { part, cr, csr: 0 }
    }

    /// Bits of CR that the part has.
    pub(super) const fn cr_mask(&self) -> u32 {
        match self.part.family() {
            Family::F405 => 0x0000_43FF,
            Family::F42x | Family::F469 => 0x000F_EFFF,
            Family::F446 => 0x003F_EFFF,
        }
    }

    /// ODEN and ODSWEN in CR, ODRDY and ODSWRDY in CSR.
    const OD: u32 = 1 << 16;
    const ODSW: u32 = 1 << 17;
    const VOSRDY: u32 = 1 << 14;
    const BRE: u32 = 1 << 9;
    const BRR: u32 = 1 << 3;
    const EWUP: u32 = 1 << 8;

    /// Greatest frequencies of AHB, APB1 and APB2 at the present scale of the regulator, Hz (DS8626 table 14, RM0090 5.1.3;
    /// DS9405, RM0090 5.1.4; DS10693 table 16, RM0390 5.1.3 and 5.1.4; DS11189).
    pub fn most(&self) -> [u64; 3] {
        const MHZ: u64 = 1_000_000;
        let (scale, is_over_driven) = match self.part.family() {
            // One bit: 1 is scale 1, 0 is scale 2.
            Family::F405 => (if self.cr >> 14 & 1 == 1 { 1 } else { 2 }, false),
            Family::F42x | Family::F446 | Family::F469 => {
                (4 - (self.cr >> 14 & 0b11).max(1), self.cr & Self::ODSW != 0)
            }
        };
        let hclk = match (scale, is_over_driven) {
            (1, true) => 180 * MHZ,
            (1, false) | (2, true) => 168 * MHZ,
            (2, false) => 144 * MHZ,
            _ => 120 * MHZ,
        };
        if is_over_driven { [hclk, 45 * MHZ, 90 * MHZ] } else { [hclk, 42 * MHZ, 84 * MHZ] }
    }

    /// Returns DBP: the backup domain accepts stores.
    pub fn allows_backup(&self) -> bool {
        self.cr >> 8 & 1 == 1
    }

    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.cr),
            0x04 => {
                let backup = if self.csr & Self::BRE != 0 { Self::BRR } else { 0 };
                // The switch to over-drive needs it enabled (RM0390 5.1.4).
                let over_drive = match self.cr & (Self::OD | Self::ODSW) {
                    Self::ODSW => 0,
                    bits => bits,
                };
                Some(self.csr | Self::VOSRDY | backup | over_drive)
            }
            _ => None,
        }
    }

    /// A store; `None` for what does not exist.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.cr = value & self.cr_mask(),
            0x04 => self.csr = value & (Self::BRE | Self::EWUP),
            _ => return None,
        }
        Some(())
    }
}

/// DBGMCU, RM0090 38.16: selects the peripherals that are frozen while a debugger halts the core.
#[derive(Clone, Debug)]
pub struct Dbgmcu {
    pub(super) words: [u32; 4],
}

impl Dbgmcu {
    /// After power-on.
    pub fn new(part: Part) -> Self {
        Dbgmcu { words: [part.idcode(), 0, 0, 0] }
    }

    /// Clears all registers except the identity, at power-on.
    pub fn reset(&mut self) {
        self.words[1..].fill(0);
    }

    /// Part and revision.
    pub fn idcode(&self) -> u32 {
        self.words[0]
    }

    /// DBG_IWDG_STOP.
    pub fn freezes_watchdog(&self) -> bool {
        self.words[APB1_FZ] & IWDG_STOP != 0
    }

    /// DBG_CAN1_STOP or DBG_CAN2_STOP.
    pub fn freezes_can(&self, side: Side) -> bool {
        self.words[APB1_FZ] & CAN_STOP[side as usize] != 0
    }

    /// Returns the bits of APB1_FZ and APB2_FZ for peripherals that the model cannot freeze.
    pub fn unmodelled_freezes(&self) -> (u32, u32) {
        (self.words[APB1_FZ] & !(IWDG_STOP | CAN_STOP[0] | CAN_STOP[1]), self.words[APB1_FZ + 1])
    }

    /// Sets part and revision.
    pub fn set_idcode(&mut self, idcode: u32) {
        self.words[0] = idcode;
    }

    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00..=0x0C => Some(self.words[offset as usize / 4]),
            _ => None,
        }
    }

    /// A store; `None` for what does not exist.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x04..=0x0C => {
                self.words[offset as usize / 4] = value;
                Some(())
            }
            _ => None,
        }
    }
}

const UNIQUE_ID: u32 = 0x1FFF_7A10;
const UNIQUE_ID_END: u32 = UNIQUE_ID + 12;

/// Unique ID of a chip: its first word is `serial`.
pub fn unique_id(serial: u32) -> [u8; 12] {
    let words = [serial, 0x3430_3546, 0x2054_5749];
    let bytes = words.map(u32::to_le_bytes);
    bytes.concat().try_into().unwrap_or_default()
}

/// Device signature in system memory, RM0090 chapter 39: unique ID and flash size.
pub fn signature(part: Part, serial: u32, address: u32) -> Option<u32> {
    match address {
        UNIQUE_ID..UNIQUE_ID_END => {
            let word = unique_id(serial).as_chunks().0.get((address - UNIQUE_ID) as usize / 4).copied()?;
            Some(u32::from_le_bytes(word))
        }
        // Flash size in KiB in the upper half; the lower is reserved.
        0x1FFF_7A20 => Some(part.flash_bytes() >> 10 << 16),
        _ => None,
    }
}
