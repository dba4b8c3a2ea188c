//! SDO client: one transfer at a time, with the server of any node.

mod answer;
mod download;
mod error;
mod staging;
mod upload;

pub use error::Error;
pub use staging::STAGING;

use self::staging::Staging;
use super::block::{Receiver, Sender, Strays};
use super::crc::Crc;
use super::wire;
use super::wire::Payload;
use crate::types::{AbortCode, Address, Duration, Instant};

/// Values up to this size are not worth a block transfer: it takes five frames more than their segments.
const THRESHOLD: u8 = 28;

/// A pause in a sub-block as long as this part of the timeout means that its last segments are lost.
const PAUSE: u64 = 4;

/// Protocol for a value that does not fit into one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Blocks for values of more than 28 bytes if the server supports them, otherwise segments.
    #[default]
    Auto,
    /// Segments for values of any size.
    Segmented,
    /// Blocks for values of any size.
    Block,
}

/// Client of one SDO connection: one transfer at a time, with the server of any node.
///
/// Start a transfer, then [push](Client::push) or [pull](Client::pull) its bytes until it has an
/// [outcome](Client::outcome). Only [`Client::poll`] and [`Client::on_response`] send frames. So poll after every
/// other call, and when [`Client::deadline`] has come. The page of the [module](crate::sdo) has an example.
#[doc(alias("SDO client", "CSDO", "1280h"))]
#[derive(Debug)]
pub struct Client {
    state: State,
    mode: Mode,
    timeout: Duration,
    /// End of the time that the transfer waits, for the rest of a sub-block or for any frame.
    deadline: Instant,
    strays: Strays,
    at: Address,
    /// Download: the size. Upload: the size once the server sent it, before that the most that is accepted.
    size: u32,
    is_size_told: bool,
    /// Download: bytes that the server has acknowledged. Upload: bytes received.
    moved: u32,
    /// Checksum of all bytes pushed, or of those received without the last segment.
    crc: Crc,
    staging: Staging,
}

/// First request of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Protocol {
    Download,
    BlockDownload,
    Upload,
    BlockUpload,
}

#[derive(Debug)]
enum State {
    /// No transfer.
    Idle,
    /// Finished. The outcome was not fetched yet.
    Done(Result<usize, Error>),
    /// The request is to be sent.
    Initiate(Protocol),
    /// The answer to it is awaited.
    Initiated(Protocol),
    /// Segments; `asked`: the answer to one is awaited.
    Download { toggle: bool, asked: bool },
    /// Segments; `asked`: one is awaited.
    Upload { toggle: bool, asked: bool },
    /// Acknowledgement of a sub-block.
    BlockDownload { sender: Sender, crc: bool },
    /// Answer to the end of a block download.
    BlockDownloadEnd,
    /// Segments of a sub-block; `due`: it has ended and is to be acknowledged.
    BlockUpload { receiver: Receiver, crc: bool, due: bool },
    /// End of a block upload.
    BlockUploadEnd { receiver: Receiver, crc: bool },
}

impl Client {
    /// Makes a client without a transfer. A transfer without progress for `timeout` is aborted.
    pub const fn new(timeout: Duration) -> Client {
        Client {
            state: State::Idle,
            mode: Mode::Auto,
            timeout,
            deadline: Instant::ZERO,
            strays: Strays::NONE,
            at: Address::new(0, 0),
            size: 0,
            is_size_told: false,
            moved: 0,
            crc: Crc::new(),
            staging: Staging::new(),
        }
    }

    /// Begins to read a value of at most `most` bytes. Drops a running transfer without an abort:
    /// [cancel](Client::cancel) it first.
    ///
    /// [`Mode::Auto`] requests a block upload and lets the server choose segments for a small value. With a server
    /// that does not support blocks it costs one exchange more.
    pub fn start_upload(&mut self, at: Address, most: usize, mode: Mode) {
        let protocol = if mode == Mode::Segmented { Protocol::Upload } else { Protocol::BlockUpload };
        self.start(at, u32::try_from(most).unwrap_or(u32::MAX), mode, protocol);
    }

    /// Begins to write a value of `size` bytes; [push](Client::push) all of them. Drops a running transfer
    /// without an abort: [cancel](Client::cancel) it first.
    pub fn start_download(&mut self, at: Address, size: usize, mode: Mode) {
        let is_small = size <= usize::from(THRESHOLD);
        let protocol = match mode {
            Mode::Segmented => Protocol::Download,
            Mode::Auto if is_small => Protocol::Download,
            Mode::Auto | Mode::Block => Protocol::BlockDownload,
        };
        match u32::try_from(size) {
            Ok(size) => self.start(at, size, mode, protocol),
            Err(_) => self.done(Err(Error::TooLarge)),
        }
    }

    fn start(&mut self, at: Address, size: u32, mode: Mode, protocol: Protocol) {
        self.leave(State::Initiate(protocol));
        self.staging.clear();
        (self.at, self.size, self.mode) = (at, size, mode);
        (self.is_size_told, self.moved, self.crc) = (false, 0, Crc::new());
    }

    /// Takes bytes of a download. Returns the number of bytes taken.
    pub fn push(&mut self, bytes: &[u8]) -> usize {
        let taken = bytes.get(..bytes.len().min(self.room())).unwrap_or_default();
        self.crc.update(taken);
        self.staging.push(taken)
    }

    /// Returns the number of bytes that [`Client::push`] takes now.
    pub fn room(&self) -> usize {
        if !self.is_downloading() {
            return 0;
        }
        let to_come = (self.size.saturating_sub(self.moved) as usize).saturating_sub(self.staging.len());
        to_come.min(self.staging.room())
    }

    /// Copies bytes of an upload. Returns their number. The last bytes stay available after the outcome, until
    /// the next transfer starts.
    pub fn pull(&mut self, into: &mut [u8]) -> usize {
        let ready = self.ready();
        let most = into.len().min(ready);
        let pulled = self.staging.peek(0, into.get_mut(..most).unwrap_or_default());
        self.staging.consume(pulled);
        pulled
    }

    /// Returns the outcome of the transfer, once: the number of bytes of the value, or the error.
    pub fn outcome(&mut self) -> Option<Result<usize, Error>> {
        let State::Done(outcome) = self.state else { return None };
        self.state = State::Idle;
        Some(outcome)
    }

    /// Returns whether the transfer waits for the application: to push, to pull, or to fetch the outcome.
    pub fn needs_application(&self) -> bool {
        match self.state {
            State::Done(_) => true,
            State::Upload { asked: false, .. } | State::BlockUpload { due: true, .. } => {
                self.staging.room() < upload::SEGMENT
            }
            _ => self.room() > 0,
        }
    }

    /// Returns whether blocks are moved. Their frames leave no room for frames of lower priority.
    pub const fn fills_bus(&self) -> bool {
        matches!(self.state, State::BlockDownload { .. } | State::BlockUpload { .. })
    }

    /// Sends or aborts what is due at `now`.
    pub fn poll(&mut self, now: Instant, send: &mut impl FnMut(Payload)) {
        if self.is_on_the_way() && self.deadline <= now {
            match &mut self.state {
                State::BlockUpload { receiver, due, .. } if receiver.is_heard() && !*due => {
                    // There is room for what did not come.
                    *due = true;
                }
                _ => {
                    // Time for what is on its way.
                    self.deadline = now + self.pause();
                    self.fail(Error::Timeout, send);
                }
            }
        }
        self.drive(now, send);
    }

    /// Sends what can be sent.
    fn drive(&mut self, now: Instant, send: &mut impl FnMut(Payload)) {
        let payload = match &mut self.state {
            State::Initiate(protocol) => {
                let protocol = *protocol;
                let Some(request) = self.request(protocol) else { return };
                self.state = State::Initiated(protocol);
                Some(request)
            }
            State::Download { toggle, asked: asked @ false } => {
                let segment = download::segment(&self.staging, *toggle, self.size.saturating_sub(self.moved));
                *asked = segment.is_some();
                segment
            }
            State::Upload { toggle, asked: asked @ false } => {
                *asked = self.staging.room() >= upload::SEGMENT;
                asked.then(|| wire::upload_segment(*toggle))
            }
            State::BlockDownload { .. } => return self.send_sub_block(now, send),
            State::BlockUpload { receiver, due: due @ true, .. } => {
                let block_size = upload::block_size(&self.staging);
                if block_size == 0 {
                    return;
                }
                *due = false;
                match receiver.acknowledge(block_size) {
                    Ok(ackseq) => Some(wire::block_ack(ackseq, block_size)),
                    Err(code) => return self.fail(Error::Protocol(code), send),
                }
            }
            _ => None,
        };
        if let Some(payload) = payload {
            self.deadline = now + self.timeout;
            send(payload);
        }
    }

    fn request(&self, protocol: Protocol) -> Option<Payload> {
        Some(match protocol {
            Protocol::Download => return download::request(&self.staging, self.at, self.size),
            Protocol::BlockDownload => wire::block_download(self.at, true, self.size),
            Protocol::Upload => wire::upload(self.at),
            Protocol::BlockUpload => {
                let threshold = if self.mode == Mode::Auto { THRESHOLD } else { 0 };
                wire::block_upload(self.at, true, upload::block_size(&self.staging), threshold)
            }
        })
    }

    /// Returns when to [poll](Client::poll) at the latest.
    pub fn deadline(&self) -> Option<Instant> {
        self.is_on_the_way().then_some(self.deadline)
    }

    /// Notes that a frame of this client left the bus, or failed.
    pub fn on_sent(&mut self) {
        if let State::BlockDownload { sender, .. } = &mut self.state {
            sender.on_sent();
        }
    }

    /// Aborts the running transfer. There is no outcome.
    pub fn cancel(&mut self, send: &mut impl FnMut(Payload)) {
        if self.is_on_the_way() {
            send(wire::abort(self.at, AbortCode::LocalControl.code()));
        }
        self.leave(State::Idle);
        self.staging.clear();
    }

    /// Aborts the running transfer, because the active bus changed.
    pub fn bus_changed(&mut self, send: &mut impl FnMut(Payload)) {
        if self.is_on_the_way() {
            self.fail(Error::BusChanged, send);
        }
    }

    /// Ends the transfer and sends the server an abort.
    fn fail(&mut self, error: Error, send: &mut impl FnMut(Payload)) {
        send(wire::abort(self.at, error.code()));
        self.done(Err(error));
    }

    fn done(&mut self, outcome: Result<usize, Error>) {
        if outcome.is_err() || self.is_downloading() {
            self.staging.clear();
        }
        self.leave(State::Done(outcome));
    }

    fn leave(&mut self, state: State) {
        if let State::BlockUpload { receiver, .. } = &self.state {
            self.strays = receiver.strays(self.deadline);
        }
        self.state = state;
    }

    /// Returns whether the server knows the transfer.
    fn is_on_the_way(&self) -> bool {
        !matches!(self.state, State::Idle | State::Done(_) | State::Initiate(_))
    }

    fn is_downloading(&self) -> bool {
        use Protocol::{BlockDownload, Download};
        matches!(
            self.state,
            State::Initiate(Download | BlockDownload)
                | State::Initiated(Download | BlockDownload)
                | State::Download { .. }
                | State::BlockDownload { .. }
                | State::BlockDownloadEnd
        )
    }

    fn pause(&self) -> Duration {
        Duration::from_micros(self.timeout.as_micros() / PAUSE)
    }
}
