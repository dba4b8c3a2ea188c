//! Memory, and random numbers to fill it.

use can_twin::cpu::{Bus, BusError, Width};

/// A piece of memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    pub from: u32,
    pub content: Vec<u8>,
    /// The bus accepts stores.
    pub is_writable: bool,
}

/// Memory without waits, in pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory(pub Vec<Piece>);

impl Memory {
    /// Pieces that the bus can write, each from an address on.
    pub fn writable<const COUNT: usize>(pieces: [(u32, Vec<u8>); COUNT]) -> Self {
        Memory(pieces.map(|(from, content)| Piece { from, content, is_writable: true }).into())
    }

    fn bytes(&mut self, address: u32, width: Width, accepts: fn(&Piece) -> bool) -> Option<&mut [u8]> {
        self.0.iter_mut().filter(|piece| accepts(piece)).find_map(|piece| {
            let at = address.checked_sub(piece.from)? as usize;
            piece.content.get_mut(at..at + width.bytes() as usize)
        })
    }

    /// Loads without recording the access.
    pub fn peek(&mut self, address: u32, width: Width) -> Option<u32> {
        let bytes = self.bytes(address, width, |_| true)?;
        Some(bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
    }

    /// Stores without recording the access, also to memory that the bus cannot write.
    pub fn poke(&mut self, address: u32, width: Width, value: u32) {
        let bytes = self.bytes(address, width, |_| true).expect("memory");
        bytes.copy_from_slice(&value.to_le_bytes()[..width.bytes() as usize]);
    }

    /// Stores words without recording the access.
    pub fn poke_words(&mut self, address: u32, words: impl IntoIterator<Item = u32>) {
        words.into_iter().zip((address..).step_by(4)).for_each(|(word, at)| self.poke(at, Width::Word, word));
    }

    /// Stores code without recording the access.
    pub fn poke_code(&mut self, address: u32, code: &[u16]) {
        for (at, &half) in (address..).step_by(2).zip(code) {
            self.poke(at, Width::Half, u32::from(half));
        }
    }
}

impl Bus for Memory {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.load(address, Width::Half).map(|half| half as u16)
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        self.peek(address, width).ok_or(BusError)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        let bytes = self.bytes(address, width, |piece| piece.is_writable).ok_or(BusError)?;
        bytes.copy_from_slice(&value.to_le_bytes()[..width.bytes() as usize]);
        Ok(())
    }
}

/// xorshift64, as in `judge/make_vectors.py`.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as u32
    }
}
