//! The CRC calculation unit (RM0090 chapter 4). A store takes effect at once. On the part it takes 4 cycles, for which the next access waits.

/// Polynomial of CRC-32, without its highest power.
const POLYNOMIAL: u32 = 0x04C1_1DB7;
const INITIAL: u32 = u32::MAX;

const DR: u32 = 0;
const IDR: u32 = 4;
const CR: u32 = 8;
const RESET: u32 = 1;

/// State of the unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crc {
    remainder: u32,
    independent: u8,
}

impl Default for Crc {
    fn default() -> Crc {
        Crc { remainder: INITIAL, independent: 0 }
    }
}

impl Crc {
    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            DR => Some(self.remainder),
            IDR => Some(self.independent.into()),
            CR => Some(0),
            _ => None,
        }
    }

    /// A store; `None` for what does not exist.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            DR => self.add(value),
            IDR => self.independent = value as u8,
            CR if value & RESET != 0 => self.remainder = INITIAL,
            CR => {}
            _ => return None,
        }
        Some(())
    }

    fn add(&mut self, word: u32) {
        let shifted = |crc: u32| crc << 1 ^ if crc >> 31 == 1 { POLYNOMIAL } else { 0 };
        self.remainder = (0..u32::BITS).fold(self.remainder ^ word, |crc, _| shifted(crc));
    }

    /// Offsets and bits that hold state.
    pub(super) fn stored(&self) -> Vec<(u32, u32)> {
        vec![(DR, u32::MAX), (IDR, 0xFF)]
    }

    /// Inverts bits of a register.
    pub(super) fn flip(&mut self, offset: u32, mask: u32) {
        match offset {
            DR => self.remainder ^= mask,
            _ => self.independent ^= mask as u8,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given "12345678" in two words, highest byte first, then the remainder is that of CRC-32/MPEG-2, by another implementation.
    /// CR.RESET begins again and keeps IDR.
    #[test]
    fn remainder_is_that_of_the_catalogue() {
        let expected = crc::Crc::<u32>::new(&crc::CRC_32_MPEG_2).checksum(b"12345678");
        let mut unit = Crc::default();
        assert_eq!(unit.read(DR), Some(u32::MAX));
        unit.write(IDR, 0x15A).unwrap();
        for _ in 0..2 {
            for word in [*b"1234", *b"5678"] {
                unit.write(DR, u32::from_be_bytes(word)).unwrap();
            }
            assert_eq!(unit.read(DR), Some(expected));
            assert_eq!(unit.read(IDR), Some(0x5A));
            unit.write(CR, RESET).unwrap();
            assert_eq!(unit.read(DR), Some(u32::MAX));
        }
        assert_eq!((unit.read(CR), unit.read(0x0C), unit.write(0x0C, 0)), (Some(0), None, None));
    }
}
