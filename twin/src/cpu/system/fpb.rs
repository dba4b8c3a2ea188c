//! The flash patch and breakpoint unit (FPB): words of the code region in place of which the core reads others (C1.11; "FPB" in
//! the technical reference manual).
//!
//! Six comparators replace instructions, by a word of RAM or by BKPT, two replace data. Comparator n takes its word from FP_REMAP + 4 n.
//! The MPU checks the original address. Power-on resets the unit, a system reset does not.
//!
//! Not replaced are unaligned data, vectors (the architecture leaves that to the implementation), words of a stack frame at the return
//! from an exception, and data that DMA reads. A breakpoint at the second half of an instruction alone is UNPREDICTABLE.

/// Comparators for instructions; those for data follow.
const CODE: usize = 6;
const ALL: usize = 8;
/// End of the code region.
const CODE_END: u32 = 0x2000_0000;

const CTRL: u32 = 0x00;
const REMAP: u32 = 0x04;
const COMP: u32 = 0x08;
const ENABLE: u32 = 1;
const KEY: u32 = 1 << 1;
/// FP_CTRL: numbers of comparators.
const NUMBERS: u32 = 2 << 8 | (CODE as u32) << 4;
/// FP_REMAP: the words are in RAM, which the unit supports.
const IN_RAM: u32 = 1 << 29;
const REMAP_BITS: u32 = 0x1FFF_FFE0;
const ADDRESS: u32 = 0x1FFF_FFFC;
const REPLACE: u32 = 0b11 << 30;

/// What an instruction is replaced by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replacement {
    /// The half-word at this address.
    Address(u32),
    /// BKPT.
    Breakpoint,
}

/// State of the unit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fpb {
    is_enabled: bool,
    remap: u32,
    comparators: [u32; ALL],
}

impl Fpb {
    /// Reads a register by its offset; zero behind the last one.
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            CTRL => NUMBERS | u32::from(self.is_enabled),
            REMAP => IN_RAM | self.remap,
            _ => self.comparators.get(comparator(offset)).copied().unwrap_or(0),
        }
    }

    /// Writes a register by its offset. FP_CTRL needs its key.
    pub fn write(&mut self, offset: u32, value: u32) {
        match offset {
            CTRL if value & KEY != 0 => self.is_enabled = value & ENABLE != 0,
            CTRL => {}
            REMAP => self.remap = value & REMAP_BITS,
            _ => {
                let number = comparator(offset);
                if let Some(comparator) = self.comparators.get_mut(number) {
                    *comparator = value & bits_of(number);
                }
            }
        }
    }

    /// Registers of the unit: offset and bits that hold state.
    pub fn stored() -> impl Iterator<Item = (u32, u32)> {
        let comparators = (COMP..).step_by(4).zip((0..ALL).map(bits_of));
        [(CTRL, ENABLE), (REMAP, REMAP_BITS)].into_iter().chain(comparators)
    }

    /// Inverts bits of a register.
    pub fn flip(&mut self, offset: u32, mask: u32) {
        match offset {
            CTRL => self.is_enabled ^= mask & ENABLE != 0,
            REMAP => self.remap ^= mask,
            _ => self.comparators[comparator(offset)] ^= mask,
        }
    }

    /// Words of the code region that the comparators name.
    pub fn words(&self) -> [u32; ALL] {
        self.comparators.map(|comparator| comparator & ADDRESS)
    }

    /// Returns whether the unit is on.
    #[inline]
    pub fn is_enabled(&self) -> bool {
        self.is_enabled
    }

    /// Returns what replaces the half-word of an instruction.
    #[inline]
    pub fn instruction(&self, address: u32) -> Option<Replacement> {
        if !self.is_enabled {
            return None;
        }
        let number = self.matching(0..CODE, address)?;
        match self.comparators[number] >> 30 {
            0 => Some(Replacement::Address(self.place(number, address))),
            halves => (halves >> (address >> 1 & 1) & 1 == 1).then_some(Replacement::Breakpoint),
        }
    }

    /// Returns the address from which aligned data are loaded.
    pub fn data(&self, address: u32) -> u32 {
        if !self.is_enabled || address >= CODE_END {
            return address;
        }
        self.matching(CODE..ALL, address).map_or(address, |number| self.place(number, address))
    }

    fn matching(&self, mut numbers: std::ops::Range<usize>, address: u32) -> Option<usize> {
        let is_here = |comparator: u32| comparator & ENABLE != 0 && comparator & ADDRESS == address & !0b11;
        numbers.find(|number| is_here(self.comparators[*number]))
    }

    /// Address in the table of words, of which each comparator has one.
    fn place(&self, number: usize, address: u32) -> u32 {
        (IN_RAM | self.remap) + 4 * number as u32 + (address & 0b11)
    }
}

fn comparator(offset: u32) -> usize {
    (offset.wrapping_sub(COMP) / 4) as usize
}

/// Data can only be replaced by a word.
fn bits_of(number: usize) -> u32 {
    ADDRESS | ENABLE | if number < CODE { REPLACE } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_keep_their_bits_and_control_needs_its_key() {
        let mut fpb = Fpb::default();
        assert_eq!(fpb.read(CTRL), 0x260);
        fpb.write(CTRL, 1);
        assert_eq!(fpb.read(CTRL), 0x260, "without the key");
        fpb.write(CTRL, 3);
        assert_eq!(fpb.read(CTRL), 0x261);
        for offset in (REMAP..0x28).step_by(4) {
            fpb.write(offset, u32::MAX);
        }
        assert_eq!(fpb.read(REMAP), 0x3FFF_FFE0);
        assert_eq!(fpb.read(COMP), 0xDFFF_FFFD);
        assert_eq!(fpb.read(COMP + 4 * CODE as u32), 0x1FFF_FFFD);
    }

    #[test]
    fn upper_half_word_alone_is_a_breakpoint() {
        let mut fpb = Fpb::default();
        fpb.write(CTRL, 3);
        fpb.write(COMP, 0x0800_0010 | 0b10 << 30 | 1);
        assert_eq!(fpb.instruction(0x0800_0010), None);
        assert_eq!(fpb.instruction(0x0800_0012), Some(Replacement::Breakpoint));
    }
}
