//! Decoded instructions, kept by address.
//!
//! There are two stores. Code that changes only by announcement (flash) is found by its index and used without reading
//! the memory. Code at any other address (RAM) is used only if the memory still holds the half-words from which it was
//! decoded. Copies of a core share the pages of the first store until one of them changes a page.

use std::ops::Range;
use std::sync::Arc;

use crate::cpu::decode;
use crate::cpu::instruction::{Decoded, Instruction};

/// Half-words of a page of [`Cache::pages`].
const PAGE: usize = 128;
/// Entries for code outside of the announced range. A power of two.
const CHECKED: usize = 256;

/// Instructions of a program, decoded before it runs. Cores that are made with a copy share them.
#[derive(Clone, Debug)]
pub struct Code {
    base: u32,
    pages: Vec<Option<Arc<[Decoded; PAGE]>>>,
}

impl Code {
    /// Decodes the content of flash from `base` on, an even address. Every half-word may begin an instruction.
    #[must_use]
    pub fn decode(base: u32, content: &[u8]) -> Self {
        let halves = content.chunks_exact(2).map(|half| u16::from_le_bytes([half[0], half[1]]));
        let halves: Vec<u16> = halves.collect();
        let decoded = |n: usize| match (halves[n], halves.get(n + 1)) {
            (first, _) if !decode::is_wide(first) => decode::narrow(first),
            (first, Some(second)) => decode::wide(first, *second),
            // The rest of the instruction is not part of the content.
            (_, None) => Decoded::NOTHING,
        };
        let page = |start: usize| {
            let at = |n| if start + n < halves.len() { decoded(start + n) } else { Decoded::NOTHING };
            Some(Arc::new(std::array::from_fn(at)))
        };
        Code { base, pages: (0..halves.len()).step_by(PAGE).map(page).collect() }
    }
}

impl Decoded {
    const NOTHING: Decoded = Decoded { instruction: Instruction::Undefined, size: 0 };
}

/// Half-words and the instruction that they encode.
#[derive(Clone, Copy, Debug)]
struct Checked {
    address: u32,
    word: u32,
    decoded: Decoded,
}

/// The two stores.
#[derive(Clone, Debug)]
pub struct Cache {
    code: Code,
    checked: Vec<Option<Checked>>,
}

impl Cache {
    /// A cache for code that changes only by announcement in `code`.
    pub fn new(code: &Range<u32>) -> Self {
        let half_words = code.len() / 2;
        let pages = vec![None; half_words.div_ceil(PAGE)];
        Cache { code: Code { base: code.start, pages }, checked: vec![None; CHECKED] }
    }

    /// The instructions decoded so far.
    pub fn code(&self) -> Code {
        self.code.clone()
    }

    /// Number of the half-word at an address.
    #[inline]
    fn index(&self, address: u32) -> usize {
        (address.wrapping_sub(self.code.base) >> 1) as usize
    }

    /// Takes instructions that were decoded before.
    pub fn share(&mut self, code: &Code) {
        let first = self.index(code.base);
        if let Some(pages) = self.code.pages.get_mut(first / PAGE..)
            && first.is_multiple_of(PAGE)
        {
            pages.iter_mut().zip(&code.pages).for_each(|(page, decoded)| page.clone_from(decoded));
        }
    }

    /// The instruction at an address whose content changes only by announcement; its size is 0 if it is not known.
    #[inline]
    pub fn get(&self, address: u32) -> Decoded {
        let index = self.index(address);
        match self.code.pages.get(index / PAGE) {
            Some(Some(page)) => page[index % PAGE],
            _ => Decoded::NOTHING,
        }
    }

    /// Stores an instruction. Does nothing for addresses outside of the range.
    pub fn put(&mut self, address: u32, decoded: Decoded) {
        let index = self.index(address);
        if let Some(page) = self.code.pages.get_mut(index / PAGE) {
            let page = page.get_or_insert_with(|| Arc::new([Decoded::NOTHING; PAGE]));
            Arc::make_mut(page)[index % PAGE] = decoded;
        }
    }

    /// Returns whether the content of an address changes only by announcement.
    pub fn covers(&self, address: u32) -> bool {
        self.index(address) / PAGE < self.code.pages.len()
    }

    /// Forgets the instructions that begin in `range` or reach into it.
    pub fn invalidate(&mut self, range: Range<u32>) {
        // A 32-bit instruction that begins one half-word before reaches into the range.
        let first = (range.start & !1).saturating_sub(2);
        for address in (first..range.end).step_by(2) {
            let index = self.index(address);
            if let Some(Some(page)) = self.code.pages.get_mut(index / PAGE) {
                Arc::make_mut(page)[index % PAGE] = Decoded::NOTHING;
            }
        }
    }

    /// Returns the instruction decoded from `word` at `address`, if it is in the store.
    pub fn get_checked(&self, address: u32, word: u32) -> Option<Decoded> {
        self.checked[place(address)]
            .filter(|entry| entry.address == address && entry.word == word)
            .map(|entry| entry.decoded)
    }

    /// Keeps the instruction that `word` at `address` encodes.
    pub fn put_checked(&mut self, address: u32, word: u32, decoded: Decoded) {
        self.checked[place(address)] = Some(Checked { address, word, decoded });
    }
}

/// All caches are equal: they affect the speed of a core, not its behaviour.
impl PartialEq for Cache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

fn place(address: u32) -> usize {
    (address >> 1) as usize % CHECKED
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOP: Decoded = Decoded { instruction: Instruction::Barrier, size: 4 };

    #[test]
    fn invalidate_drops_instructions_that_reach_into_the_range() {
        let mut cache = Cache::new(&(0x0800_0000..0x0800_1000));
        for address in [0x0800_0100, 0x0800_0102, 0x0800_0104, 0x0800_0108] {
            cache.put(address, NOP);
        }
        cache.invalidate(0x0800_0104..0x0800_0108);
        assert!(cache.get(0x0800_0100).size == 4);
        assert!(cache.get(0x0800_0102).size == 0, "its second half-word lies in the range");
        assert!(cache.get(0x0800_0104).size == 0);
        assert!(cache.get(0x0800_0108).size == 4);
    }

    #[test]
    fn shared_code_is_copied_before_it_changes() {
        // MOVS r0, #1; MOVW r1, #0; a wide instruction of which half is there
        let content = [0x01, 0x20, 0x40, 0xF2, 0x00, 0x01, 0x40, 0xF2];
        let code = Code::decode(0x0800_0000, &content);
        let mut caches = [(); 2].map(|()| Cache::new(&(0x0800_0000..0x0800_1000)));
        caches.iter_mut().for_each(|cache| cache.share(&code));
        let sizes = |cache: &Cache| [0, 2, 4, 6, 8].map(|at| cache.get(0x0800_0000 + at).size);
        assert_eq!(sizes(&caches[0]), [2, 4, 2, 0, 0]);
        caches[0].invalidate(0x0800_0000..0x0800_0004);
        assert_eq!((sizes(&caches[0]), sizes(&caches[1])), ([0, 0, 2, 0, 0], [2, 4, 2, 0, 0]));
    }

    #[test]
    fn checked_entry_with_other_content_is_not_found() {
        let mut cache = Cache::new(&(0..0));
        cache.put_checked(0x2000_0000, 0xF3BF_8F4F, NOP);
        assert!(cache.get_checked(0x2000_0000, 0xF3BF_8F4F).is_some());
        assert!(cache.get_checked(0x2000_0000, 0xF3BF_8F4E).is_none());
        assert!(cache.get_checked(0x2000_0200, 0xF3BF_8F4F).is_none());
    }
}
