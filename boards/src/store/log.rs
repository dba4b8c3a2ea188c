//! A log of sets in two pages of NOR flash; the last set that is whole is the one that is stored.
//!
//! ```text
//! page    magic | epoch, !epoch | set | note | set | ... | erased
//! set     length, !length | bytes, padded to words | CRC
//! note    8000h + note, complement
//! copy    4001h to 7FFFh, complement
//! ```
//!
//! * The CRC is written last: with it a set is stored, without it the one before. It is never FFFF FFFFh, the erased word.
//! * Length and epoch stand beside their complements, of which one bit of each pair is zero: a word that was cut short,
//!   or one that an erase was about to clear, has pairs of ones and is told for certain.
//! * The page in use is the one of the higher epoch. The other one is free or holds what is past, or the remains of an
//!   erase; it is erased before it is used.
//! * A note holds until the next set is stored. Notes end at three quarters of a page: the rest is for sets.
//! * Three copies of the Node-ID hold until they are replaced (`ecss_can::store::identity`). The last one of each number
//!   counts. Copies that were replaced are programmed to zero. A copy that differs is written anew at the next start.
//! * [`ParameterLog::open`] changes pages when room for a set is no longer left, or for a note: erase the other page, copy
//!   set, note and Node-ID, write the epoch. Until the epoch stands there the old page holds; afterwards it is not read.
//! * A word that does not read back as it was written fails the set.

use ecss_can::store::{ParameterStore, StoreError, identity};
use ecss_can::types::NodeId;
use embedded_storage::nor_flash::NorFlash;

/// The longest set, bytes. [`ParameterLog::open`] leaves room for one.
pub const MAX_SET: usize = 16 * 1024;

const WORD: u32 = 4;
const MAGIC: u32 = u32::from_le_bytes(*b"ECPS");
/// Magic and epoch.
const PAGE_HEADER: u32 = 2 * WORD;
const ERASED: u32 = u32::MAX;
/// In the first half of a word: a note follows in the other bits, and no length.
const NOTE: u16 = 0x8000;

/// What was found and done at start-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Opened {
    /// Sectors that were erased.
    pub erased: u32,
    /// Sets newer than the one stored whose CRC is wrong: damaged since, or cut short in the very last word. Where none is
    /// left, nothing is stored and defaults hold.
    pub damaged: u32,
}

/// A set in the page in use.
#[derive(Clone, Copy, Debug)]
struct StoredSet {
    /// Where its length stands.
    at: u32,
    len: u32,
}

impl StoredSet {
    const fn data(self) -> u32 {
        self.at + WORD
    }

    const fn crc(self) -> u32 {
        self.data() + self.len.next_multiple_of(WORD)
    }

    const fn end(self) -> u32 {
        self.crc() + WORD
    }
}

/// The last copies of the Node-ID, by their numbers.
#[derive(Clone, Copy, Debug, Default)]
struct Copies {
    /// Where they stand; zero where there is none.
    at: [u32; 3],
    /// Node-IDs, zero for none.
    ids: [u8; 3],
}

/// The set that is being written.
struct Writing {
    record: StoredSet,
    /// Bytes taken.
    taken: u32,
    /// Bytes that do not fill a word yet.
    word: [u8; WORD as usize],
    crc: Crc,
}

/// The store over two pages of `F`. It never erases once it is open.
pub struct ParameterLog<F> {
    flash: F,
    /// Where the page in use begins and ends.
    page: u32,
    page_end: u32,
    /// Where the next set goes.
    free: u32,
    stored: Option<StoredSet>,
    note: Option<u16>,
    copies: Copies,
    writing: Option<Writing>,
}

impl<F: NorFlash> ParameterLog<F> {
    const PAGE: u32 = F::ERASE_SIZE as u32;

    /// Opens the log in the two pages from `base` on and makes room for a set. Erases at most one page.
    ///
    /// # Errors
    /// [`StoreError::Hardware`] when the flash fails.
    pub fn open(flash: F, base: u32) -> Result<(Self, Opened), StoreError> {
        const {
            assert!(F::WRITE_SIZE == WORD as usize && F::READ_SIZE <= WORD as usize, "flash of words");
            assert!(
                F::ERASE_SIZE >= 2 * (PAGE_HEADER as usize + MAX_SET + 2 * WORD as usize),
                "room for sets"
            );
        }
        let pages = [base, base + Self::PAGE];
        let mut log = ParameterLog {
            flash,
            page: base,
            page_end: 0,
            free: 0,
            stored: None,
            note: None,
            copies: Copies::default(),
            writing: None,
        };
        let mut opened = Opened::default();
        let epochs = [log.epoch(pages[0])?, log.epoch(pages[1])?];
        let newest = match epochs {
            [Some(first), Some(second)] => Some(usize::from(second > first)),
            [Some(_), None] => Some(0),
            [None, Some(_)] => Some(1),
            [None, None] => None,
        };
        let Some(newest) = newest else {
            log.clear(pages[0], &mut opened)?;
            log.enter(pages[0]);
            log.stamp(1)?;
            return Ok((log, opened));
        };
        log.enter(pages[newest]);
        log.find_stored(&mut opened)?;
        let room = StoredSet { at: log.free, len: MAX_SET as u32 };
        if room.end() > log.page_end || log.free >= log.notes_end() {
            log.clear(pages[1 - newest], &mut opened)?;
            log.change_page(pages[1 - newest], epochs[newest].unwrap_or(0).saturating_add(1))?;
        }
        // Two copies are enough until the next start, which tries again.
        _ = log.mend_node_id();
        Ok((log, opened))
    }

    #[cfg(test)]
    pub(super) fn flash(&self) -> &F {
        &self.flash
    }

    #[cfg(test)]
    pub(super) fn into_flash(self) -> F {
        self.flash
    }

    fn enter(&mut self, page: u32) {
        self.page = page;
        self.page_end = page + Self::PAGE;
        self.free = page + PAGE_HEADER;
        (self.stored, self.note, self.copies) = (None, None, Default::default());
    }

    /// Where the last quarter of the page begins.
    fn notes_end(&self) -> u32 {
        self.page_end - Self::PAGE / 4
    }

    /// The epoch of a page that was made ready.
    fn epoch(&mut self, page: u32) -> Result<Option<u16>, StoreError> {
        let magic = self.word(page)?;
        Ok(doubled(self.word(page + WORD)?).filter(|_| magic == MAGIC))
    }

    fn stamp(&mut self, epoch: u16) -> Result<(), StoreError> {
        self.program(self.page, MAGIC)?;
        self.program(self.page + WORD, double(epoch))
    }

    /// Erases a page unless it is erased.
    fn clear(&mut self, page: u32, opened: &mut Opened) -> Result<(), StoreError> {
        let mut bytes = [0; 512];
        let mut at = page;
        while at < page + Self::PAGE {
            self.flash.read(at, &mut bytes).map_err(failed)?;
            let (words, _) = bytes.as_chunks();
            if words.iter().any(|&word| u32::from_le_bytes(word) != ERASED) {
                opened.erased += 1;
                return self.flash.erase(page, page + Self::PAGE).map_err(failed);
            }
            at += bytes.len() as u32;
        }
        Ok(())
    }

    /// Finds the last set that is whole, and the note behind it.
    fn find_stored(&mut self, opened: &mut Opened) -> Result<(), StoreError> {
        // The CRCs are looked at from the last on, which mostly is the one; each further one costs a walk.
        let mut before = self.page_end;
        while let Some(record) = self.last_committed(before)? {
            if self.crc_of(record)? == self.word(record.crc())? {
                self.stored = Some(record);
                break;
            }
            opened.damaged += 1;
            before = record.at;
        }
        Ok(())
    }

    /// Walks the page in use: the last set before `before` that has a CRC, the last note behind it, and where the page is
    /// free. Sets between that set and that note are not stored.
    fn last_committed(&mut self, before: u32) -> Result<Option<StoredSet>, StoreError> {
        let mut last = None;
        self.free = self.page + PAGE_HEADER;
        self.note = None;
        while self.free < self.page_end {
            let word = self.word(self.free)?;
            if word == ERASED {
                break;
            }
            let Some(record) = self.record(self.free, word) else {
                match doubled(word) {
                    Some(note) if note & NOTE != 0 => self.note = Some(note & !NOTE),
                    Some(copy) => {
                        if let Some((number, id)) = identity::of_copy(copy) {
                            let nth = usize::from(number - 1) % 3;
                            (self.copies.at[nth], self.copies.ids[nth]) = (self.free, id);
                        }
                    }
                    None => {}
                }
                self.free += WORD;
                continue;
            };
            if record.at < before && self.word(record.crc())? != ERASED {
                (last, self.note) = (Some(record), None);
            }
            self.free = record.end();
        }
        Ok(last)
    }

    /// The set whose length stands at `at`. A note and a copy have nothing after them, and neither has a length that was cut
    /// short.
    fn record(&self, at: u32, length: u32) -> Option<StoredSet> {
        let len = doubled(length).filter(|len| *len <= MAX_SET as u16)?;
        Some(StoredSet { at, len: u32::from(len) }).filter(|record| record.end() <= self.page_end)
    }

    fn crc_of(&mut self, record: StoredSet) -> Result<u32, StoreError> {
        let mut crc = Crc::new();
        let mut at = record.data();
        let end = at + record.len;
        let mut bytes = [0; 64];
        while at < end {
            let part = &mut bytes[..((end - at) as usize).min(64)];
            self.flash.read(at, part).map_err(failed)?;
            crc.update(part);
            at += part.len() as u32;
        }
        Ok(crc.end())
    }

    /// Takes the stored set and the note over to a page that is erased.
    fn change_page(&mut self, page: u32, epoch: u16) -> Result<(), StoreError> {
        let (old, note, id) = (self.stored, self.note, self.node_id());
        self.enter(page);
        if let Some(old) = old {
            self.begin(old.len as usize)?;
            let mut bytes = [0; 64];
            for offset in (0..old.len).step_by(bytes.len()) {
                let part = &mut bytes[..((old.len - offset) as usize).min(64)];
                self.flash.read(old.data() + offset, part).map_err(failed)?;
                self.append(part)?;
            }
            self.commit()?;
        }
        if let Some(note) = note {
            self.write_note(note)?;
        }
        if id.is_some() {
            self.store_node_id(id)?;
        }
        self.stamp(epoch)
    }

    /// Writes three copies of the Node-ID anew where one of them differs.
    fn mend_node_id(&mut self) -> Result<(), StoreError> {
        let id = self.node_id();
        let [first, second, third] = self.copies.ids;
        if id.is_some() && (first != second || first != third) { self.store_node_id(id) } else { Ok(()) }
    }

    #[inline(never)] // looked at everywhere
    fn word(&mut self, at: u32) -> Result<u32, StoreError> {
        let mut bytes = [0; WORD as usize];
        self.flash.read(at, &mut bytes).map_err(failed)?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn program(&mut self, at: u32, word: u32) -> Result<(), StoreError> {
        self.flash.write(at, &word.to_le_bytes()).map_err(failed)?;
        if self.word(at)? == word { Ok(()) } else { Err(StoreError::Hardware) }
    }
}

impl<F: NorFlash> ParameterStore for ParameterLog<F> {
    fn stored_len(&self) -> usize {
        self.stored.map_or(0, |record| record.len as usize)
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        let record = self.stored.ok_or(StoreError::Size)?;
        let end = offset.checked_add(into.len()).ok_or(StoreError::Size)?;
        if end > record.len as usize {
            return Err(StoreError::Size);
        }
        self.flash.read(record.data() + offset as u32, into).map_err(failed)
    }

    fn begin(&mut self, len: usize) -> Result<(), StoreError> {
        self.writing = None;
        if len > MAX_SET {
            return Err(StoreError::Size);
        }
        let record = StoredSet { at: self.free, len: len as u32 };
        if record.end() > self.page_end {
            return Err(StoreError::Full);
        }
        // If it fails it is no length, and nothing after it is the start of a set.
        self.free += WORD;
        self.program(record.at, double(len as u16))?;
        self.free = record.end();
        self.writing = Some(Writing { record, taken: 0, word: [0xFF; 4], crc: Crc::new() });
        Ok(())
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        let mut writing = self.writing.take().ok_or(StoreError::Size)?;
        if bytes.len() > (writing.record.len - writing.taken) as usize {
            return Err(StoreError::Size);
        }
        writing.crc.update(bytes);
        for &byte in bytes {
            let place = writing.taken % WORD;
            writing.word[place as usize] = byte;
            writing.taken += 1;
            if place == WORD - 1 {
                let at = writing.record.data() + writing.taken - WORD;
                self.program(at, u32::from_le_bytes(take_word(&mut writing.word)))?;
            }
        }
        self.writing = Some(writing);
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        let mut writing = self.writing.take().ok_or(StoreError::Size)?;
        let record = writing.record;
        if writing.taken != record.len {
            return Err(StoreError::Size);
        }
        if !record.len.is_multiple_of(WORD) {
            self.program(record.crc() - WORD, u32::from_le_bytes(take_word(&mut writing.word)))?;
        }
        self.program(record.crc(), writing.crc.end())?;
        (self.stored, self.note) = (Some(record), None);
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        self.note
    }

    fn write_note(&mut self, note: u16) -> Result<(), StoreError> {
        self.writing = None;
        if note & NOTE != 0 {
            return Err(StoreError::Size);
        }
        let at = self.free;
        if at >= self.notes_end() {
            return Err(StoreError::Full);
        }
        // If it fails it is no note, and nothing after it.
        self.free += WORD;
        self.program(at, double(NOTE | note))?;
        self.note = Some(note);
        Ok(())
    }

    fn node_id(&mut self) -> Option<NodeId> {
        identity::agreed(self.copies.ids)
    }

    fn store_node_id(&mut self, id: Option<NodeId>) -> Result<(), StoreError> {
        self.writing = None;
        if self.free >= self.notes_end() {
            return Err(StoreError::Full);
        }
        let id = id.map_or(0, NodeId::get);
        for nth in 0..3 {
            let at = self.free;
            // If it fails it is no copy, and nothing after it.
            self.free += WORD;
            self.program(at, double(identity::copy(nth as u8 + 1, id)))?;
            self.copies.ids[nth] = id;
            let old = core::mem::replace(&mut self.copies.at[nth], at);
            // Whatever happens to the new copy, the old one takes its place no more.
            if old != 0 {
                self.program(old, 0)?;
            }
        }
        Ok(())
    }
}

/// A word that is complete; the next one begins erased.
fn take_word(word: &mut [u8; WORD as usize]) -> [u8; WORD as usize] {
    core::mem::replace(word, [0xFF; WORD as usize])
}

fn failed<E>(_: E) -> StoreError {
    StoreError::Hardware
}

/// A number and its complement in one word.
const fn double(number: u16) -> u32 {
    (!number as u32) << 16 | number as u32
}

/// The number of a word of [`double`].
fn doubled(word: u32) -> Option<u16> {
    let number = word as u16;
    (word == double(number)).then_some(number)
}

/// CRC-32 of ISO HDLC, bit by bit: sets are short, and a table is a KiB.
struct Crc(u32);

impl Crc {
    fn new() -> Crc {
        Crc(u32::MAX)
    }

    #[inline(never)] // from two places
    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 ^= u32::from(*byte);
            for _ in 0..8 {
                let feedback = if self.0 & 1 == 1 { 0xEDB8_8320 } else { 0 };
                self.0 = self.0 >> 1 ^ feedback;
            }
        }
    }

    /// Never the erased word.
    fn end(self) -> u32 {
        if !self.0 == ERASED { 0 } else { !self.0 }
    }
}
