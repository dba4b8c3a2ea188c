//! A log of sets in two pages of NOR flash. The last complete set is the stored one.
//!
//! ```text
//! page    magic | epoch | set | note | set | ... | erased
//! set     length, 0 to 3FFFh | bytes, padded to words | CRC | 0
//! note    4000h + note
//! copy    5000h to 7FFFh
//! ```
//!
//! * Magic, epoch, length, note and copy are control words (`word.rs`): one flipped bit is corrected, and a word whose write was
//!   interrupted never reads as another one. The CRC of a set corrects one flipped bit of it (`crc.rs`).
//! * The last word of a set, all zeros, *commits* it. Without it the save was interrupted and the set before is stored.
//!   A committed set that cannot be corrected is *damaged*; the set before is stored, or none.
//! * The page with the higher epoch is in use. The other one is free, or holds older sets or the remains of an
//!   interrupted erase; it is erased before it is used.
//! * A note holds until the next set is stored. Notes end at three quarters of a page: the rest is for sets.
//! * Three copies of the Node-ID hold until they are replaced (`ecss_can::store::identity`). The last one of each number
//!   counts. Copies that were replaced are programmed to zero.
//! * [`ParameterLog::open`] changes pages when there is no room left for the longest set or for a note, and when it
//!   corrected a bit: erase the other page, copy set, note and Node-ID, write the epoch. Until the epoch is written the
//!   old page is valid; afterwards it is not read.
//! * A set begins behind flipped bits of the erased area. If a word reads back with another value than was written,
//!   storing the set, note or copy fails.

use ecss_can::store::{Loss, ParameterStore, StoreError, identity};
use ecss_can::types::NodeId;
use embedded_storage::nor_flash::NorFlash;

use super::word;
use crate::crc::{Crc, flipped};

/// The longest set, bytes. [`ParameterLog::open`] leaves room for one.
pub const MAX_SET: usize = 16 * 1024 - 4;

const WORD: u32 = 4;
/// First word of a page in this format.
const MAGIC: u16 = 0x4543;
/// Magic and epoch.
const PAGE_HEADER: u32 = 2 * WORD;
const ERASED: u32 = u32::MAX;
/// Mark of a note in a control word.
const NOTE: u16 = 0x4000;
/// The highest note, and its control word.
const MAX_NOTE: u16 = 0x0FFF;
const LAST_NOTE: u16 = NOTE | MAX_NOTE;
/// Number of bytes that are read at once.
const PART: usize = 256;

/// Findings and repairs at start-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Opened {
    /// Sectors that were erased.
    pub erased: u32,
    /// Saved sets, newer than the one stored, that have more flipped bits than can be corrected.
    pub damaged: u32,
    /// The last save was interrupted: power failed, or the flash refused a word. The set before is stored.
    pub is_interrupted: bool,
    /// Number of flipped bits that were corrected. The corrected data was written to the other page.
    pub corrected: u32,
}

/// A set in the page in use.
#[derive(Clone, Copy, Debug)]
struct StoredSet {
    /// Address of the word with its length.
    at: u32,
    /// Length in bytes.
    len: u32,
    /// Index of a flipped bit, counted from the first byte; the bits of the CRC follow the bytes.
    flipped: Option<u32>,
}

impl StoredSet {
    const fn new(at: u32, len: u32) -> StoredSet {
        StoredSet { at, len, flipped: None }
    }

    const fn data(self) -> u32 {
        self.at + WORD
    }

    const fn crc(self) -> u32 {
        self.data() + self.len.next_multiple_of(WORD)
    }

    const fn commit(self) -> u32 {
        self.crc() + WORD
    }

    const fn end(self) -> u32 {
        self.commit() + WORD
    }
}

/// The last copies of the Node-ID, by number.
#[derive(Clone, Copy, Debug, Default)]
struct Copies {
    /// Addresses; zero for none.
    at: [u32; 3],
    /// Node-IDs, zero for none.
    ids: [u8; 3],
}

/// The set that is being written.
struct Writing {
    record: StoredSet,
    /// Number of bytes received.
    taken: u32,
    /// Bytes of the incomplete word.
    word: [u8; WORD as usize],
    crc: Crc,
}

/// The store over two pages of `F`. It never erases once it is open.
pub struct ParameterLog<F> {
    flash: F,
    /// Begin and end of the page in use.
    page: u32,
    page_end: u32,
    /// Address of the next record.
    free: u32,
    stored: Option<StoredSet>,
    note: Option<u16>,
    copies: Copies,
    /// Flipped bits that were corrected in the page in use.
    corrected: u32,
    loss: Option<Loss>,
    writing: Option<Writing>,
}

impl<F: NorFlash> ParameterLog<F> {
    const PAGE: u32 = F::ERASE_SIZE as u32;

    /// Opens the log in the two pages from `base` on, makes room for a set and corrects flipped bits. Erases at most
    /// one page.
    ///
    /// # Errors
    /// [`StoreError::Hardware`] when the flash fails.
    pub fn open(flash: F, base: u32) -> Result<(Self, Opened), StoreError> {
        const {
            assert!(F::WRITE_SIZE == WORD as usize && F::READ_SIZE <= WORD as usize, "flash of words");
            assert!(
                F::ERASE_SIZE >= 2 * (PAGE_HEADER as usize + MAX_SET + 3 * WORD as usize),
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
            corrected: 0,
            loss: None,
            writing: None,
        };
        let mut opened = Opened::default();
        let epochs = [log.epoch(pages[0])?, log.epoch(pages[1])?];
        let newest = usize::from(epochs[1] > epochs[0]);
        let epoch = epochs[newest];
        if epoch == 0 {
            for page in pages {
                // A page that is not empty was in use: its epoch is damaged.
                if log.control(page)? == Some(MAGIC) && log.word(page + PAGE_HEADER)? != ERASED {
                    opened.damaged += 1;
                    log.loss = Some(Loss::Damaged);
                }
            }
            log.clear(pages[0], &mut opened)?;
            log.enter(pages[0]);
            log.stamp(1)?;
            return Ok((log, opened));
        }
        log.find_stored(pages[newest], &mut opened)?;
        let has_room = StoredSet::new(log.free, MAX_SET as u32).end() <= log.page_end;
        if !has_room || log.free >= log.notes_end() || log.corrected > 0 {
            opened.corrected = log.corrected;
            log.clear(pages[1 - newest], &mut opened)?;
            log.change_page(pages[1 - newest], epoch + 1)?;
        }
        Ok((log, opened))
    }

    #[cfg(test)]
    pub(super) fn flash(&self) -> &F {
        &self.flash
    }

    #[cfg(test)]
    pub(super) fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    #[cfg(test)]
    pub(super) fn into_flash(self) -> F {
        self.flash
    }

    fn enter(&mut self, page: u32) {
        self.page = page;
        self.page_end = page + Self::PAGE;
        self.free = page + PAGE_HEADER;
        self.corrected = 0;
        (self.stored, self.note, self.copies) = (None, None, Default::default());
    }

    /// Returns the address of the last quarter of the page.
    fn notes_end(&self) -> u32 {
        self.page_end - Self::PAGE / 4
    }

    /// Returns the epoch of a valid page, otherwise zero.
    fn epoch(&mut self, page: u32) -> Result<u16, StoreError> {
        let is_ready = self.control(page)? == Some(MAGIC);
        Ok(if is_ready { self.control(page + WORD)?.unwrap_or(0) } else { 0 })
    }

    fn stamp(&mut self, epoch: u16) -> Result<(), StoreError> {
        self.program(self.page, word::encode(MAGIC))?;
        self.program(self.page + WORD, word::encode(epoch))
    }

    /// Erases a page unless it is erased.
    fn clear(&mut self, page: u32, opened: &mut Opened) -> Result<(), StoreError> {
        let end = page + Self::PAGE;
        if self.first_written(page, end)? < end {
            opened.erased += 1;
            self.flash.erase(page, end).map_err(failed)?;
        }
        Ok(())
    }

    /// Returns the address of the first word that is not erased, or `end` if there is none.
    fn first_written(&mut self, mut at: u32, end: u32) -> Result<u32, StoreError> {
        let mut bytes = [0; PART];
        while at < end {
            let part = &mut bytes[..((end - at) as usize).min(PART)];
            self.flash.read(at, part).map_err(failed)?;
            for word in part.as_chunks().0 {
                if u32::from_le_bytes(*word) != ERASED {
                    return Ok(at);
                }
                at += WORD;
            }
        }
        Ok(end)
    }

    /// Selects a page, and finds its last complete set and the note behind it.
    fn find_stored(&mut self, page: u32, opened: &mut Opened) -> Result<(), StoreError> {
        // Begins with the last set, which is complete in most cases; each further set needs another walk.
        let mut before = page + Self::PAGE;
        loop {
            self.enter(page);
            self.epoch(page)?;
            let is_interrupted = self.walk(before)?;
            if opened.damaged == 0 && is_interrupted {
                opened.is_interrupted = true;
                self.loss = Some(Loss::Interrupted);
            }
            let Some(last) = self.stored else { return Ok(()) };
            if self.correct(last)? {
                return Ok(());
            }
            opened.damaged += 1;
            before = last.at;
        }
    }

    /// Walks the page in use. Finds the last committed set before `before`, the last note behind it, the copies, and
    /// the free area of the page. Sets between that set and that note are not stored. Returns whether the last set of
    /// the page is not committed.
    fn walk(&mut self, before: u32) -> Result<bool, StoreError> {
        let mut is_interrupted = false;
        while self.free < self.page_end && self.word(self.free)? != ERASED {
            let (at, found) = (self.free, self.control(self.free)?);
            self.free += WORD;
            match found {
                Some(note @ NOTE..=LAST_NOTE) => self.note = Some(note - NOTE),
                Some(len) if len < NOTE => {
                    let record = StoredSet::new(at, len.into());
                    if record.end() > self.page_end {
                        continue;
                    }
                    self.free = record.end();
                    // Requires zeros in both halves: a flipped bit of the erased word does not commit the set.
                    let commit = self.word(record.commit())?;
                    is_interrupted = commit as u16 == u16::MAX || commit >> 16 == 0xFFFF;
                    if !is_interrupted && at < before {
                        (self.stored, self.note) = (Some(record), None);
                    }
                }
                Some(copy) => {
                    if let Some((number, id)) = identity::of_copy(copy) {
                        let nth = usize::from(number - 1) % 3;
                        (self.copies.at[nth], self.copies.ids[nth]) = (at, id);
                    }
                }
                None => {}
            }
        }
        let [first, second, third] = self.copies.ids;
        if self.node_id().is_some() && (first != second || first != third) {
            self.corrected += 1;
        }
        Ok(is_interrupted)
    }

    /// Compares a set with its CRC. Returns true and selects the set if at most one bit is flipped, which reading
    /// corrects. Otherwise the set is damaged, and no set is selected.
    fn correct(&mut self, set: StoredSet) -> Result<bool, StoreError> {
        let mut set = StoredSet { flipped: None, ..set };
        let difference = self.crc_of(set)? ^ self.word(set.crc())?;
        if difference != 0 {
            set.flipped = flipped(difference, 8 * set.len);
            if set.flipped.is_none() {
                (self.stored, self.loss) = (None, Some(Loss::Damaged));
                return Ok(false);
            }
            self.corrected += 1;
        }
        self.stored = Some(set);
        Ok(true)
    }

    /// Returns the number of a control word, with one flipped bit corrected.
    fn control(&mut self, at: u32) -> Result<Option<u16>, StoreError> {
        let word = self.word(at)?;
        let number = word::decode(word);
        self.corrected += u32::from(number.is_some() && word::is_flipped(word));
        Ok(number)
    }

    fn crc_of(&mut self, set: StoredSet) -> Result<u32, StoreError> {
        let mut crc = Crc::new();
        let mut bytes = [0; PART];
        let mut offset = 0;
        while offset < set.len {
            let part = &mut bytes[..((set.len - offset) as usize).min(PART)];
            self.copy(set, offset, part)?;
            crc.update(part);
            offset += part.len() as u32;
        }
        Ok(crc.value())
    }

    /// Copies bytes of a set from `offset` on.
    fn copy(&mut self, set: StoredSet, offset: u32, into: &mut [u8]) -> Result<(), StoreError> {
        self.flash.read(set.data() + offset, into).map_err(failed)?;
        if let Some(bit) = set.flipped
            && let Some(byte) = into.get_mut((bit / 8).wrapping_sub(offset) as usize)
        {
            *byte ^= 1 << (bit % 8);
        }
        Ok(())
    }

    /// Copies the stored set, the note and the Node-ID to a page that is erased.
    fn change_page(&mut self, page: u32, epoch: u16) -> Result<(), StoreError> {
        let (old, note, id, loss) = (self.stored, self.note, self.node_id(), self.loss);
        self.enter(page);
        if let Some(old) = old {
            self.begin(old.len as usize)?;
            let mut bytes = [0; PART];
            let mut offset = 0;
            while offset < old.len {
                let part = &mut bytes[..((old.len - offset) as usize).min(PART)];
                self.copy(old, offset, part)?;
                self.append(part)?;
                offset += part.len() as u32;
            }
            self.commit()?;
        }
        if let Some(note) = note {
            self.write_note(note)?;
        }
        if id.is_some() {
            self.store_node_id(id)?;
        }
        self.loss = loss;
        self.stamp(epoch)
    }

    #[inline(never)] // row `size.pyboard-v11.slave.flash`: five of these save 40 bytes
    fn word(&mut self, at: u32) -> Result<u32, StoreError> {
        let mut bytes = [0; WORD as usize];
        self.flash.read(at, &mut bytes).map_err(failed)?;
        Ok(u32::from_le_bytes(bytes))
    }

    /// Programs a word. A word that does not read back is programmed to zero, so that it does not read as a corrected
    /// one.
    fn program(&mut self, at: u32, word: u32) -> Result<(), StoreError> {
        self.write(at, word)?;
        if self.word(at)? == word {
            return Ok(());
        }
        self.write(at, 0)?;
        Err(StoreError::Hardware)
    }

    fn write(&mut self, at: u32, word: u32) -> Result<(), StoreError> {
        self.flash.write(at, &word.to_le_bytes()).map_err(failed)
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
        self.copy(record, offset as u32, into)
    }

    fn check(&mut self) -> Option<Loss> {
        if let Some(set) = self.stored {
            // If the flash cannot be read, the load fails as well.
            _ = self.correct(set);
        }
        self.loss
    }

    fn begin(&mut self, len: usize) -> Result<(), StoreError> {
        self.writing = None;
        if len > MAX_SET {
            return Err(StoreError::Size);
        }
        loop {
            let record = StoredSet::new(self.free, len as u32);
            if record.end() > self.page_end {
                return Err(StoreError::Full);
            }
            let written = self.first_written(record.at, record.end())?;
            // If this fails, the word is not a length and the words behind it are not a set.
            self.free += WORD;
            if written == record.at {
                continue;
            }
            // Words that do not read as erased become part of a set that is never committed.
            let is_free = written == record.end();
            let len = if is_free { record.len } else { written - record.data() };
            let record = StoredSet { len, ..record };
            self.program(record.at, word::encode(len as u16))?;
            self.free = record.end();
            if is_free {
                self.writing = Some(Writing { record, taken: 0, word: [0xFF; 4], crc: Crc::new() });
                return Ok(());
            }
        }
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
        self.program(record.crc(), writing.crc.value())?;
        self.program(record.commit(), 0)?;
        (self.stored, self.note, self.loss) = (Some(record), None, None);
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        self.note
    }

    fn write_note(&mut self, note: u16) -> Result<(), StoreError> {
        self.writing = None;
        if note > MAX_NOTE {
            return Err(StoreError::Size);
        }
        let at = self.free;
        if at >= self.notes_end() {
            return Err(StoreError::Full);
        }
        // If this fails, the word is not a note.
        self.free += WORD;
        self.program(at, word::encode(NOTE | note))?;
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
            // If this fails, the word is not a copy.
            self.free += WORD;
            self.program(at, word::encode(identity::copy(nth as u8 + 1, id)))?;
            self.copies.ids[nth] = id;
            let old = core::mem::replace(&mut self.copies.at[nth], at);
            // If the new copy is damaged, the old one must not take its place.
            if old != 0 {
                self.program(old, 0)?;
            }
        }
        Ok(())
    }
}

/// Takes the complete word and sets the next one to the erased state.
fn take_word(word: &mut [u8; WORD as usize]) -> [u8; WORD as usize] {
    core::mem::replace(word, [0xFF; WORD as usize])
}

fn failed<E>(_: E) -> StoreError {
    StoreError::Hardware
}
