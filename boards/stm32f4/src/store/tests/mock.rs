//! Flash in RAM. Programs and erases as the chip does, counts the operations, and loses power at an operation that a
//! test selects.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

pub const PAGE: usize = 40 * 1024;

/// Content of the word or page during whose operation power failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remains {
    Old,
    New,
    /// Old words, new words, and words with bits of both; holds the seed.
    Mixed(u64),
}

impl Remains {
    /// Returns every kind, with `mixtures` mixtures.
    pub fn all(mixtures: u64) -> impl Iterator<Item = Remains> {
        [Remains::Old, Remains::New].into_iter().chain((0..mixtures).map(Remains::Mixed))
    }
}

#[derive(Clone, Debug)]
pub struct Flash {
    pub bytes: Vec<u8>,
    /// Words programmed and pages erased since the start of the test.
    pub programs: u64,
    pub erases: u64,
    /// Number of operations after which power fails, and the content that remains.
    pub cut: Option<(u64, Remains)>,
    pub powered: bool,
    /// Bits that cannot be changed: address, mask.
    pub stuck: Option<(usize, u8)>,
}

impl Flash {
    pub fn erased() -> Flash {
        Flash { bytes: vec![0xFF; 2 * PAGE], programs: 0, erases: 0, cut: None, powered: true, stuck: None }
    }

    pub fn operations(&self) -> u64 {
        self.programs + self.erases
    }

    /// Makes power fail in an operation; 1 is the next one.
    pub fn cut_at(&mut self, operation: u64, remains: Remains) {
        self.cut = Some((self.operations() + operation, remains));
    }

    /// Restores power.
    pub fn revived(mut self) -> Flash {
        self.powered = true;
        self.cut = None;
        self
    }

    fn operate(&mut self, at: usize, new: &[u8]) -> Result<(), PowerLost> {
        let old = self.bytes[at..at + new.len()].to_vec();
        let fails = self.cut.is_some_and(|(operation, _)| operation == self.operations());
        let content = match self.cut {
            Some((_, Remains::Old)) if fails => old,
            Some((_, Remains::Mixed(seed))) if fails => mixed(&old, new, seed),
            _ => new.to_vec(),
        };
        let held = self.stuck.map(|(address, mask)| (address, mask, self.bytes[address] & mask));
        self.bytes[at..at + new.len()].copy_from_slice(&content);
        if let Some((address, mask, bits)) = held {
            self.bytes[address] = self.bytes[address] & !mask | bits;
        }
        self.powered &= !fails;
        self.alive()
    }

    fn alive(&self) -> Result<(), PowerLost> {
        if self.powered { Ok(()) } else { Err(PowerLost) }
    }
}

fn mixed(old: &[u8], new: &[u8], seed: u64) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(seed);
    let words = old.chunks(4).zip(new.chunks(4)).map(|(old, new)| match random.u8(..3) {
        0 => old.to_vec(),
        1 => new.to_vec(),
        _ => old.iter().zip(new).map(|(old, new)| (old ^ new) & random.u8(..) ^ old).collect(),
    });
    words.collect::<Vec<_>>().concat()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerLost;

impl NorFlashError for PowerLost {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Flash {
    type Error = PowerLost;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerLost> {
        self.alive()?;
        bytes.copy_from_slice(&self.bytes[offset as usize..offset as usize + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerLost> {
        assert!(from.is_multiple_of(PAGE as u32) && to == from + PAGE as u32, "one page");
        self.alive()?;
        self.erases += 1;
        self.operate(from as usize, &[0xFF; PAGE])
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerLost> {
        assert!(offset.is_multiple_of(4) && bytes.len().is_multiple_of(4), "words");
        for (at, word) in (offset as usize..).step_by(4).zip(bytes.chunks(4)) {
            self.alive()?;
            self.programs += 1;
            let new: Vec<_> = self.bytes[at..].iter().zip(word).map(|(old, new)| old & new).collect();
            self.operate(at, &new)?;
        }
        Ok(())
    }
}
