//! Value of a transfer between the bus and the dictionary.

use crate::od::{ObjectAccess, Transfer, WHOLE};
use crate::sdo::block::SEGMENT;
use crate::sdo::crc::Crc;
use crate::types::{AbortCode, Address};

/// Bytes of a segment.
const STEP: usize = SEGMENT as usize;

/// A whole value or a part of a stream, and the last segment of a block download with what is unused of it.
const BUFFER: usize = WHOLE + 8;

/// Bytes of a value, and what must hold for all of it.
///
/// A download of [`Transfer::Whole`] is complete here before it is written. An upload of one is read at its start.
/// So no reader sees half of the value. A stream passes through in parts.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Value {
    pub at: Address,
    /// The checksum, when it is wanted.
    pub crc: Option<Crc>,
    /// Upload: the size. Download: the size if the client sent it, otherwise the most that is accepted.
    size: u32,
    is_size_told: bool,
    is_stream: bool,
    /// The dictionary waits for the rest of a stream.
    is_open: bool,
    /// Download: bytes that may come, from the begin of the buffer on.
    room: u32,
    /// Download: where in the buffer a full segment must end.
    end: usize,
    /// Offset of the buffer in the value.
    offset: u32,
    /// Number of bytes in the checksum.
    summed: u32,
    filled: usize,
    buffer: [u8; BUFFER],
}

impl Value {
    pub const fn new() -> Value {
        Value {
            at: Address::new(0, 0),
            crc: None,
            size: 0,
            is_size_told: false,
            is_stream: false,
            is_open: false,
            room: 0,
            end: 0,
            offset: 0,
            summed: 0,
            filled: 0,
            buffer: [0; BUFFER],
        }
    }

    /// Returns the size of an upload.
    pub fn size(&self) -> u32 {
        self.size
    }

    fn open(&mut self, at: Address, size: u32, transfer: Transfer, crc: bool) {
        self.at = at;
        self.crc = crc.then(Crc::new);
        self.size = size;
        self.is_stream = matches!(transfer, Transfer::Stream(_));
        (self.offset, self.summed, self.filled) = (0, 0, 0);
    }

    /// Begins an upload.
    pub fn open_upload(
        &mut self,
        at: Address,
        transfer: Transfer,
        crc: bool,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), AbortCode> {
        let (Transfer::Whole(size) | Transfer::Stream(size)) = transfer;
        self.open(at, u32::try_from(size).map_err(|_| AbortCode::OutOfMemory)?, transfer, crc);
        if self.is_stream {
            return Ok(());
        }
        if size > WHOLE {
            return Err(AbortCode::OutOfMemory);
        }
        self.fill(0, size, objects)
    }

    /// Reads at least `least` bytes from `offset` on, if there are as many.
    fn fill(&mut self, offset: u32, least: usize, objects: &mut impl ObjectAccess) -> Result<(), AbortCode> {
        let rest = self.size.saturating_sub(offset) as usize;
        let into = self.buffer.get_mut(..rest.min(BUFFER)).unwrap_or_default();
        let filled = objects.read(self.at, offset as usize, into)?;
        (self.offset, self.filled) = (offset, filled.min(BUFFER));
        if self.filled < least { Err(AbortCode::CannotTransfer) } else { Ok(()) }
    }

    /// Returns the segment of an upload that begins at `offset`, and the number of its bytes that count.
    pub fn segment(
        &mut self,
        offset: u32,
        objects: &mut impl ObjectAccess,
    ) -> Result<([u8; STEP], usize), AbortCode> {
        let len = STEP.min(self.size.saturating_sub(offset) as usize);
        let is_here = offset >= self.offset && (offset - self.offset) as usize + len <= self.filled;
        if !is_here && len > 0 {
            self.fill(offset, len, objects)?;
        }
        let begin = offset.saturating_sub(self.offset) as usize;
        let bytes = self.buffer.get(begin..begin.saturating_add(len)).unwrap_or_default();
        if let Some(crc) = self.crc.as_mut().filter(|_| offset == self.summed) {
            crc.update(bytes);
            self.summed = self.summed.saturating_add(len as u32);
        }
        let mut data = [0; STEP];
        data.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        Ok((data, len))
    }

    /// Begins a download.
    pub fn open_download(
        &mut self,
        at: Address,
        told: Option<u32>,
        crc: bool,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), AbortCode> {
        let transfer = objects.download(at, told.map(|size| size as usize))?;
        let (Transfer::Whole(most) | Transfer::Stream(most)) = transfer;
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        self.open(at, told.unwrap_or(most), transfer, crc);
        (self.is_size_told, self.is_open) = (told.is_some(), self.is_stream);
        self.set_room(if self.is_stream { self.size } else { self.size.min(WHOLE as u32) });
        match told {
            Some(size) if size > most => Err(AbortCode::TooLong),
            Some(size) if !self.is_stream && size as usize > WHOLE => Err(AbortCode::OutOfMemory),
            _ => Ok(()),
        }
    }

    fn set_room(&mut self, room: u32) {
        (self.room, self.end) = (room, BUFFER.min(room as usize));
    }

    /// Returns an error if the buffer has too many bytes.
    #[inline]
    fn check(&self, filled: usize) -> Result<(), AbortCode> {
        if filled <= self.room as usize {
            Ok(())
        } else if !self.is_stream && self.size as usize > WHOLE {
            // What does not fit into the buffer need not be too much for the object.
            Err(AbortCode::OutOfMemory)
        } else {
            Err(AbortCode::TooLong)
        }
    }

    /// Takes the next `len` bytes of a download.
    #[inline]
    pub fn push(
        &mut self,
        data: &[u8; STEP],
        len: usize,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), AbortCode> {
        self.check(self.filled + len)?;
        self.take(data, len, objects)
    }

    /// Returns whether there is room for a full segment.
    #[inline]
    pub fn has_room(&self) -> bool {
        self.filled + STEP <= self.end
    }

    /// Takes the next full segment of a download that [has room](Value::has_room) for it.
    #[inline]
    pub fn push_full(&mut self, data: &[u8; STEP]) {
        self.place(data, STEP);
    }

    /// Takes the last segment of a block download. [`Value::finish_blocks`] gets the number of its unused bytes.
    pub fn push_last(&mut self, data: &[u8; STEP], objects: &mut impl ObjectAccess) -> Result<(), AbortCode> {
        self.take(data, STEP, objects)
    }

    #[inline]
    fn take<O: ObjectAccess>(
        &mut self,
        data: &[u8; STEP],
        len: usize,
        objects: &mut O,
    ) -> Result<(), AbortCode> {
        // A whole value has room for one segment more.
        if O::TAKES_PARTS && self.filled + STEP > BUFFER {
            self.flush(objects)?;
        }
        self.place(data, len);
        Ok(())
    }

    #[inline]
    fn place(&mut self, data: &[u8; STEP], len: usize) {
        // All seven bytes, because that is quicker; the next ones overwrite those that do not count.
        if let Some(into) = self.buffer.get_mut(self.filled..).and_then(<[u8]>::first_chunk_mut) {
            *into = *data;
        }
        self.filled += len;
    }

    /// Returns whether these are the bytes that were taken last.
    pub fn ends_with(&self, data: &[u8; STEP]) -> bool {
        self.buffer.get(..self.filled).is_some_and(|taken| taken.ends_with(data))
    }

    /// Hands the buffer to the stream.
    #[inline(never)]
    fn flush(&mut self, objects: &mut impl ObjectAccess) -> Result<(), AbortCode> {
        let part = self.buffer.get(..self.filled).unwrap_or_default();
        if let Some(crc) = &mut self.crc {
            crc.update(part);
        }
        let written = objects.write_part(self.at, self.offset as usize, part);
        self.is_open = written.is_ok();
        self.offset = self.offset.saturating_add(self.filled as u32);
        self.set_room(self.room.saturating_sub(self.filled as u32));
        self.filled = 0;
        written
    }

    /// Ends a block download, except for `unused` bytes of its last segment.
    pub fn finish_blocks(
        &mut self,
        unused: u8,
        crc: u16,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), AbortCode> {
        // Some clients send an empty segment of an empty value and say that nothing in it is unused.
        let unused = if unused == 0 && self.is_empty() { STEP } else { usize::from(unused) };
        self.filled = self.filled.saturating_sub(unused);
        self.check(self.filled)?;
        // A wrong size explains a wrong checksum.
        if self.is_short() {
            return Err(AbortCode::TooShort);
        }
        if let Some(sum) = &mut self.crc {
            sum.update(self.buffer.get(..self.filled).unwrap_or_default());
            if sum.value() != crc {
                return Err(AbortCode::Crc);
            }
        }
        self.finish(objects)
    }

    /// Returns whether a download has no bytes: its size is zero, or the object accepts no bytes.
    pub fn is_empty(&self) -> bool {
        self.size == 0
    }

    /// Fewer bytes arrived than the client announced.
    fn is_short(&self) -> bool {
        self.is_size_told && self.room as usize > self.filled
    }

    /// Ends a download that is complete.
    pub fn finish<O: ObjectAccess>(&mut self, objects: &mut O) -> Result<(), AbortCode> {
        if self.is_short() {
            return Err(AbortCode::TooShort);
        }
        let rest = self.buffer.get(..self.filled).unwrap_or_default();
        if !(O::TAKES_PARTS && self.is_stream) {
            return objects.write(self.at, rest);
        }
        self.is_open = false;
        if !rest.is_empty() {
            objects.write_part(self.at, self.offset as usize, rest)?;
        }
        objects.finish(self.at, self.offset as usize + self.filled)
    }

    /// Ends the transfer. A stream that is not complete is cancelled.
    pub fn close<O: ObjectAccess>(&mut self, objects: &mut O) {
        if O::TAKES_PARTS && self.is_open {
            self.is_open = false;
            objects.cancel(self.at);
        }
    }
}
