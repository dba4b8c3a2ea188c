//! Requests and responses, from and to the eight bytes of a frame (CiA 301 7.2.4.3).
//!
//! Received frames are parsed into [`Request`] and [`Response`]. For each frame to send there is a function.
//! Reserved bits are sent as zero and ignored in reception. Segments of a sub-block have no command specifier: see
//! [`sub_block_segment`].

use crate::types::Address;

/// Data of an SDO frame. CiA 301 defines no other length.
pub type Payload = [u8; 8];

/// Content of an initiate frame: bits e, s and n, and bytes 4 to 7.
#[derive(Clone, Copy)]
pub(super) enum Content {
    /// The value itself, in the first so many of four bytes (`1..=4`).
    Expedited([u8; 4], u8),
    /// The value itself, in the first of four bytes. Their number is not sent.
    Unsized([u8; 4]),
    /// Segments follow, with this number of bytes if it was sent.
    Segmented(Option<u32>),
}

/// A segment outside of sub-blocks.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub toggle: bool,
    pub last: bool,
    /// Bytes of `data` that count, `0..=7`.
    pub len: u8,
    pub data: [u8; 7],
}

impl Segment {
    /// Returns whether the segment has no effect: it has no data and does not end the transfer.
    pub const fn is_vain(&self) -> bool {
        self.len == 0 && !self.last
    }
}

/// Request that a client sends.
#[derive(Clone, Copy)]
pub(super) enum Request {
    DownloadSegment(Segment),
    Download(Content),
    Upload,
    UploadSegment { toggle: bool },
    BlockUpload { crc: bool, block_size: u8, threshold: u8 },
    BlockUploadEnd,
    BlockUploadAck { ackseq: u8, block_size: u8 },
    BlockUploadStart,
    BlockDownload { crc: bool, size: Option<u32> },
    BlockDownloadEnd { unused: u8, crc: u16 },
    Abort,
    Unknown,
}

/// Response that a server sends.
#[derive(Clone, Copy)]
pub(super) enum Response {
    UploadSegment(Segment),
    DownloadSegment { toggle: bool },
    Upload(Content),
    Download,
    BlockDownload { crc: bool, block_size: u8 },
    BlockDownloadAck { ackseq: u8, block_size: u8 },
    BlockDownloadEnd,
    BlockUpload { crc: bool, size: Option<u32> },
    BlockUploadEnd { unused: u8, crc: u16 },
    Abort(Address, u32),
    Unknown,
}

const TOGGLE: u8 = 0x10;
/// Last segment: bit c of a segment outside of sub-blocks.
const LAST: u8 = 0x01;
/// Bit e of an initiate frame.
const EXPEDITED: u8 = 0x02;
/// Bit s of an initiate frame.
const SIZED: u8 = 0x01;
/// Bits cc and sc of a block initiate frame.
const CRC: u8 = 0x04;
/// Bit s of a block initiate frame.
const BLOCK_SIZED: u8 = 0x02;
/// Bit c of a segment of a sub-block.
pub(super) const LAST_OF_BLOCKS: u8 = 0x80;
/// First byte of an abort.
pub(super) const ABORT: u8 = 0x80;

impl Request {
    #[inline(never)] // of two callers
    pub fn parse(payload: &Payload) -> Request {
        let [command, one, two, _, four, five, _, _] = *payload;
        match command >> 5 {
            0 => Request::DownloadSegment(Segment::parse(payload)),
            1 => Request::Download(Content::parse(payload)),
            2 => Request::Upload,
            3 => Request::UploadSegment { toggle: command & TOGGLE != 0 },
            4 => Request::Abort,
            5 => match command & 3 {
                0 => Request::BlockUpload { crc: command & CRC != 0, block_size: four, threshold: five },
                1 => Request::BlockUploadEnd,
                2 => Request::BlockUploadAck { ackseq: one, block_size: two },
                _ => Request::BlockUploadStart,
            },
            6 if command & 1 == 0 => Request::BlockDownload {
                crc: command & CRC != 0,
                size: (command & BLOCK_SIZED != 0).then(|| tail(payload)),
            },
            6 => {
                Request::BlockDownloadEnd { unused: (command >> 2) & 7, crc: u16::from_le_bytes([one, two]) }
            }
            _ => Request::Unknown,
        }
    }

    /// Returns whether a transfer begins with this request, which then [names](address) the object.
    pub fn is_initiate(&self) -> bool {
        matches!(
            self,
            Request::Download(_)
                | Request::Upload
                | Request::BlockUpload { .. }
                | Request::BlockDownload { .. }
        )
    }
}

impl Response {
    pub fn parse(payload: &Payload) -> Response {
        let [command, one, two, _, four, ..] = *payload;
        match command >> 5 {
            0 => Response::UploadSegment(Segment::parse(payload)),
            1 => Response::DownloadSegment { toggle: command & TOGGLE != 0 },
            2 => Response::Upload(Content::parse(payload)),
            3 => Response::Download,
            4 => Response::Abort(address(payload), tail(payload)),
            5 => match command & 3 {
                0 => Response::BlockDownload { crc: command & CRC != 0, block_size: four },
                1 => Response::BlockDownloadEnd,
                2 => Response::BlockDownloadAck { ackseq: one, block_size: two },
                _ => Response::Unknown,
            },
            6 if command & 1 == 0 => Response::BlockUpload {
                crc: command & CRC != 0,
                size: (command & BLOCK_SIZED != 0).then(|| tail(payload)),
            },
            6 => Response::BlockUploadEnd { unused: (command >> 2) & 7, crc: u16::from_le_bytes([one, two]) },
            _ => Response::Unknown,
        }
    }

    /// Returns whether it is the first answer of a transfer, which [names](address) the object.
    pub fn is_initiate(&self) -> bool {
        matches!(
            self,
            Response::Upload(_)
                | Response::Download
                | Response::BlockUpload { .. }
                | Response::BlockDownload { .. }
        )
    }
}

impl Content {
    fn parse(payload: &Payload) -> Content {
        let [command, _, _, _, data @ ..] = *payload;
        match (command & EXPEDITED != 0, command & SIZED != 0) {
            (true, true) => Content::Expedited(data, 4 - ((command >> 2) & 3)),
            (true, false) => Content::Unsized(data),
            (false, true) => Content::Segmented(Some(u32::from_le_bytes(data))),
            (false, false) => Content::Segmented(None),
        }
    }
}

impl Segment {
    fn parse(payload: &Payload) -> Segment {
        let [command, data @ ..] = *payload;
        Segment {
            toggle: command & TOGGLE != 0,
            last: command & LAST != 0,
            len: 7 - ((command >> 1) & 7),
            data,
        }
    }

    /// Returns the bytes that count.
    pub fn bytes(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
    }

    /// Makes a download request or an upload response. Both have the command specifier 0.
    pub fn payload(&self) -> Payload {
        let unused = 7 - self.len.min(7);
        segment(bit(self.toggle, TOGGLE) | (unused << 1) | bit(self.last, LAST), self.data)
    }
}

/// Download initiate request with `len` bytes of data, `1..=4`.
pub(super) fn download_expedited(at: Address, data: [u8; 4], len: u8) -> Payload {
    initiate(0x20 | expedited(len), at, data)
}

/// Download initiate request; segments follow.
pub(super) fn download(at: Address, size: u32) -> Payload {
    initiate(0x20 | SIZED, at, size.to_le_bytes())
}

/// Download initiate response.
#[inline]
pub(super) fn download_response(at: Address) -> Payload {
    initiate(0x60, at, [0; 4])
}

/// Download segment response.
pub(super) fn download_segment_response(toggle: bool) -> Payload {
    short(0x20 | bit(toggle, TOGGLE), 0, 0)
}

/// Upload initiate request.
pub(super) fn upload(at: Address) -> Payload {
    initiate(0x40, at, [0; 4])
}

/// Upload initiate response with `len` bytes of data, `1..=4`.
#[inline]
pub(super) fn upload_expedited_response(at: Address, data: [u8; 4], len: u8) -> Payload {
    initiate(0x40 | expedited(len), at, data)
}

/// Upload initiate response; segments follow.
pub(super) fn upload_response(at: Address, size: u32) -> Payload {
    initiate(0x40 | SIZED, at, size.to_le_bytes())
}

/// Upload segment request.
pub(super) fn upload_segment(toggle: bool) -> Payload {
    short(0x60 | bit(toggle, TOGGLE), 0, 0)
}

/// Block download initiate request.
pub(super) fn block_download(at: Address, crc: bool, size: u32) -> Payload {
    initiate(0xC0 | bit(crc, CRC) | BLOCK_SIZED, at, size.to_le_bytes())
}

/// Block download initiate response.
pub(super) fn block_download_response(at: Address, crc: bool, block_size: u8) -> Payload {
    initiate(0xA0 | bit(crc, CRC), at, [block_size, 0, 0, 0])
}

/// Block upload initiate request.
pub(super) fn block_upload(at: Address, crc: bool, block_size: u8, threshold: u8) -> Payload {
    initiate(0xA0 | bit(crc, CRC), at, [block_size, threshold, 0, 0])
}

/// Block upload initiate response.
pub(super) fn block_upload_response(at: Address, crc: bool, size: u32) -> Payload {
    block_download(at, crc, size)
}

/// Block upload start request.
pub(super) fn block_upload_start() -> Payload {
    short(0xA3, 0, 0)
}

/// Segment of a sub-block, of a download or an upload.
pub(super) fn sub_block_segment(seqno: u8, last: bool, data: [u8; 7]) -> Payload {
    segment(seqno | bit(last, LAST_OF_BLOCKS), data)
}

/// Acknowledgement of a sub-block, of a download or an upload.
pub(super) fn block_ack(ackseq: u8, block_size: u8) -> Payload {
    short(0xA2, ackseq, block_size)
}

/// End of the data of a block download (request) or upload (response).
pub(super) fn block_end(unused: u8, crc: u16) -> Payload {
    let [low, high] = crc.to_le_bytes();
    short(0xC1 | ((unused & 7) << 2), low, high)
}

/// Returns whether a frame with this first byte is a [`block_end`].
pub(super) fn is_block_end(command: u8) -> bool {
    command >> 5 == 6 && command & 1 != 0
}

/// The other side's answer to [`block_end`].
pub(super) fn block_end_answer() -> Payload {
    short(0xA1, 0, 0)
}

/// End of a transfer that failed.
pub(super) fn abort(at: Address, code: u32) -> Payload {
    initiate(ABORT, at, code.to_le_bytes())
}

#[inline]
fn initiate(command: u8, at: Address, [four, five, six, seven]: [u8; 4]) -> Payload {
    let [low, high] = at.index.to_le_bytes();
    [command, low, high, at.sub, four, five, six, seven]
}

fn segment(command: u8, [one, two, three, four, five, six, seven]: [u8; 7]) -> Payload {
    [command, one, two, three, four, five, six, seven]
}

fn short(command: u8, one: u8, two: u8) -> Payload {
    [command, one, two, 0, 0, 0, 0, 0]
}

/// Bits e and s, and n for `len` bytes, `1..=4`.
#[inline]
fn expedited(len: u8) -> u8 {
    EXPEDITED | SIZED | (4_u8.wrapping_sub(len) & 3) << 2
}

fn bit(on: bool, mask: u8) -> u8 {
    if on { mask } else { 0 }
}

/// Returns whether it is an upload initiate request.
#[inline]
pub(super) fn is_upload(payload: &Payload) -> bool {
    let [command, ..] = *payload;
    command >> 5 == 2
}

/// The data of an expedited download request, and the number of bytes that count if it was sent.
#[inline]
pub(super) fn expedited_download(payload: &Payload) -> Option<([u8; 4], Option<u8>)> {
    let [command, _, _, _, data @ ..] = *payload;
    let count = (command & SIZED != 0).then(|| 4 - ((command >> 2) & 3));
    (command >> 5 == 1 && command & EXPEDITED != 0).then_some((data, count))
}

/// Index and sub-index of an initiate frame.
#[inline]
pub(super) fn address(payload: &Payload) -> Address {
    let [_, low, high, sub, ..] = *payload;
    Address::new(u16::from_le_bytes([low, high]), sub)
}

fn tail(payload: &Payload) -> u32 {
    let [_, _, _, _, data @ ..] = *payload;
    u32::from_le_bytes(data)
}
