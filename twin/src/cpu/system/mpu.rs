//! Memory protection unit with 8 regions, and the default memory map (B3.1, B3.5).

const REGIONS: usize = 8;

const CTRL_ENABLE: u32 = 1;
const CTRL_HFNMIENA: u32 = 1 << 1;
const CTRL_PRIVDEFENA: u32 = 1 << 2;
const RBAR_VALID: u32 = 1 << 4;
const RASR_ENABLE: u32 = 1;
const RASR_XN: u32 = 1 << 28;
const RASR_BITS: u32 = 0x173F_FF3F;
/// A block of 256 MiB, as a shift of addresses.
const BLOCK: u32 = 28;
const BLOCKS: usize = 16;
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

impl Access {
    /// Its bit in a set of rights.
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl Region {
    /// Ends of its parts, where rights may change.
    fn edges(self) -> impl Iterator<Item = u64> {
        let bytes = 2_u64 << (self.attributes >> 1 & 0x1F);
        let first = u64::from(self.base) & !(bytes - 1);
        (0..=8).map(move |part| first + part * bytes / 8)
    }

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

/// Addresses where privileged code has the same rights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Window {
    from: u32,
    bytes: u32,
    /// A bit for each [`Access`].
    rights: u8,
}

/// The MPU.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mpu {
    control: u32,
    selected: usize,
    regions: [Region; REGIONS],
    /// The first readable addresses of each block, derived from the registers: most accesses need no search of the regions.
    windows: [Window; BLOCKS],
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

    /// Returns whether a window permits an access of privileged code within a word, at any execution priority. `false`: ask
    /// [`Mpu::permits`].
    #[inline] // row `twin.host_instructions`
    pub fn grants(&self, address: u32, access: Access) -> bool {
        let window = &self.windows[(address >> BLOCK) as usize];
        address.wrapping_sub(window.from) < window.bytes && window.rights & access.bit() != 0
    }

    /// Returns the rights of privileged code at an address, as bits. Not those that it has only by a region and not by the
    /// default map, which holds instead at the priority of HardFault.
    fn rights(&self, address: u32) -> u8 {
        let all = [Access::Read, Access::Write, Access::Execute].into_iter();
        let permitted = all
            .filter(|&access| self.permits(address, access, true, false) && default_permits(address, access));
        permitted.fold(0, |rights, access| rights | access.bit())
    }

    /// Returns the first readable window of a block. From the private bus on there is none.
    fn window(&self, block: usize) -> Window {
        let (first, end) = ((block as u64) << BLOCK, (block as u64 + 1) << BLOCK);
        if first >= PRIVATE.start.into() {
            return Window::default();
        }
        let mut edges: Vec<u64> = self.regions.iter().flat_map(|region| region.edges()).collect();
        edges.retain(|edge| (first + 1..end).contains(edge));
        edges.extend([first, end]);
        edges.sort_unstable();
        let mut window = Window::default();
        for pair in edges.windows(2).filter(|pair| pair[0] < pair[1]) {
            let (from, bytes) = (pair[0] as u32, (pair[1] - pair[0]) as u32);
            let rights = self.rights(from);
            if window.bytes == 0 && rights & Access::Read.bit() != 0 {
                window = Window { from, bytes, rights };
            } else if window.bytes != 0 {
                if rights != window.rights {
                    break;
                }
                window.bytes += bytes;
            }
        }
        window
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
        self.windows = [Window::default(); BLOCKS];
        if self.is_enabled() {
            self.windows = std::array::from_fn(|block| self.window(block));
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

    /// Given regions with parts left out, overlaps and a background, then a window grants what the regions permit, and nothing
    /// else, at both priorities.
    #[test]
    fn windows_agree_with_the_regions() {
        let mut mpu = with_region(0, 0x0800_0000, 19 << 1 | 0b101 << 24);
        for (number, base, attributes) in [
            (1, 0x080C_0000, 17 << 1 | 0b001 << 24 | RASR_XN),
            (2, 0x2000_0000, 17 << 1 | 0b001 << 24 | RASR_XN | 0b1100_0000 << 8),
            (3, 0x4000_0000, 28 << 1 | 0b001 << 24 | 0b1110_1110 << 8),
        ] {
            mpu.write(0x0C, base | RBAR_VALID | number);
            mpu.write(0x10, attributes | RASR_ENABLE);
        }
        for (control, granted) in [(CTRL_ENABLE, 5), (CTRL_ENABLE | CTRL_PRIVDEFENA, 20), (0, 0)] {
            mpu.write(0x04, control);
            let mut grants = 0;
            for address in (0..u32::MAX).step_by(0x8000) {
                for access in [Access::Read, Access::Write, Access::Execute] {
                    let grant = mpu.grants(address, access);
                    grants += u32::from(grant);
                    for negative in [false, true] {
                        assert!(
                            !grant || mpu.permits(address, access, true, negative),
                            "{address:08X} {access:?}"
                        );
                    }
                }
            }
            assert!(grants >= granted, "{control}: {grants}");
        }
        mpu.write(0x04, CTRL_ENABLE);
        assert!(mpu.grants(0x080B_FFFC, Access::Execute) && !mpu.grants(0x080B_FFFC, Access::Write));
        assert!(mpu.grants(0x2002_FFFC, Access::Write) && !mpu.grants(0x2003_0000, Access::Read));
        assert!(!mpu.grants(0x2000_0000, Access::Execute) && !mpu.grants(0, Access::Read));
    }
}
