//! Memory protection unit with 8 regions, and the default memory map (B3.1, B3.5).

const REGIONS: usize = 8;

const CTRL_ENABLE: u32 = 1;
const CTRL_HFNMIENA: u32 = 1 << 1;
const CTRL_PRIVDEFENA: u32 = 1 << 2;
const RBAR_VALID: u32 = 1 << 4;
const RASR_ENABLE: u32 = 1;
const RASR_XN: u32 = 1 << 28;
const RASR_BITS: u32 = 0x173F_FF3F;
/// The private peripheral bus always follows the default map.
const PRIVATE: std::ops::Range<u32> = 0xE000_0000..0xE010_0000;

/// Kind of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    Read,
    Write,
    Execute,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Region {
    base: u32,
    /// RASR.
    attributes: u32,
}

impl Region {
    fn contains(self, address: u32) -> bool {
        let size = self.attributes >> 1 & 0x1F;
        if self.attributes & RASR_ENABLE == 0 || size < 4 {
            return false;
        }
        let offset_mask = u32::MAX >> (31 - size);
        if (address ^ self.base) & !offset_mask != 0 {
            return false;
        }
        // Regions of 256 bytes and more have eight parts that can be left out.
        let part = if size >= 7 { (address & offset_mask) >> (size - 2) } else { 0 };
        size < 7 || self.attributes >> (8 + part) & 1 == 0
    }

    fn permits(self, access: Access, privileged: bool) -> bool {
        let (read, write) = match (self.attributes >> 24 & 7, privileged) {
            (0b001, true) | (0b010, true) | (0b011, _) => (true, true),
            (0b010, false) | (0b101, true) | (0b110 | 0b111, _) => (true, false),
            _ => (false, false),
        };
        match access {
            Access::Read => read,
            Access::Write => write,
            Access::Execute => read && self.attributes & RASR_XN == 0,
        }
    }
}

/// The MPU.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mpu {
    control: u32,
    selected: usize,
    regions: [Region; REGIONS],
}

impl Mpu {
    #[inline]
    pub fn is_enabled(&self) -> bool {
        self.control & CTRL_ENABLE != 0
    }

    /// Returns whether an access is permitted. `negative`: the execution priority is that of HardFault, NMI or FAULTMASK.
    pub fn permits(&self, address: u32, access: Access, privileged: bool, negative: bool) -> bool {
        let applies = self.is_enabled() && !(negative && self.control & CTRL_HFNMIENA == 0);
        if !applies || PRIVATE.contains(&address) {
            return default_permits(address, access);
        }
        // The region with the highest number decides.
        match self.regions.iter().rev().find(|region| region.contains(address)) {
            Some(region) => region.permits(access, privileged),
            None => privileged && self.control & CTRL_PRIVDEFENA != 0 && default_permits(address, access),
        }
    }

    /// Reads a register at an offset from E000_ED90h.
    pub fn read(&self, offset: u32) -> u32 {
        let region = self.regions[self.selected];
        match offset {
            0x00 => (REGIONS as u32) << 8,
            0x04 => self.control,
            0x08 => self.selected as u32,
            0x0C | 0x14 | 0x1C | 0x24 => region.base | self.selected as u32,
            _ => region.attributes,
        }
    }

    /// Writes a register at an offset from E000_ED90h.
    pub fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 => {}
            0x04 => self.control = value & (CTRL_ENABLE | CTRL_HFNMIENA | CTRL_PRIVDEFENA),
            0x08 => self.selected = value as usize % REGIONS,
            0x0C | 0x14 | 0x1C | 0x24 => {
                if value & RBAR_VALID != 0 {
                    self.selected = value as usize % REGIONS;
                }
                self.regions[self.selected].base = value & !0x1F;
            }
            _ => self.regions[self.selected].attributes = value & RASR_BITS,
        }
    }
}

/// The default memory map: code runs below 4000_0000h and in external RAM (B3.1.1).
fn default_permits(address: u32, access: Access) -> bool {
    access != Access::Execute || matches!(address >> 29, 0 | 1 | 3 | 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_region(number: u32, base: u32, attributes: u32) -> Mpu {
        let mut mpu = Mpu::default();
        mpu.write(0x0C, base | RBAR_VALID | number);
        mpu.write(0x10, attributes | RASR_ENABLE);
        mpu.write(0x04, CTRL_ENABLE | CTRL_PRIVDEFENA);
        mpu
    }

    #[test]
    fn read_only_region_refuses_writes() {
        // 1 KiB, read-only for all, execute-never.
        let mpu = with_region(0, 0x2000_0400, 9 << 1 | 0b110 << 24 | RASR_XN);
        assert!(mpu.permits(0x2000_0400, Access::Read, false, false));
        assert!(!mpu.permits(0x2000_07FF, Access::Write, true, false));
        assert!(!mpu.permits(0x2000_0400, Access::Execute, true, false));
        assert!(mpu.permits(0x2000_0800, Access::Write, true, false), "the background region");
        assert!(!mpu.permits(0x2000_0800, Access::Write, false, false));
        assert!(mpu.permits(0x2000_0400, Access::Write, true, true), "HFNMIENA is clear");
    }

    #[test]
    fn subregion_left_out_falls_to_the_next_region() {
        let mut mpu = with_region(0, 0x2000_0000, 9 << 1 | 0b011 << 24);
        mpu.write(0x0C, 0x2000_0000 | RBAR_VALID | 1);
        // 256 bytes in eight parts of 32, of which the second is left out.
        mpu.write(0x10, 7 << 1 | RASR_ENABLE | 0b10 << 8);
        assert!(!mpu.permits(0x2000_0000, Access::Read, true, false));
        assert!(mpu.permits(0x2000_0020, Access::Read, true, false));
        assert!(!mpu.permits(0x2000_0040, Access::Read, true, false));
    }

    #[test]
    fn default_map_runs_code_in_flash_ram_and_external_ram() {
        let mpu = Mpu::default();
        for address in [0x0800_0000, 0x2000_0000, 0x6000_0000, 0x9FFF_FFFE] {
            assert!(mpu.permits(address, Access::Execute, false, false), "{address:08X}");
        }
        for address in [0x4000_0000, 0xA000_0000, 0xE000_E000, 0xFFFF_FFFE] {
            assert!(!mpu.permits(address, Access::Execute, true, false), "{address:08X}");
        }
    }
}
