//! SDO server: answers the requests of one client.

mod blocks;
mod initiate;
mod value;

use self::value::Value;
use super::block::{MOST, Receiver, Sender, Strays};
use super::wire;
use super::wire::{Payload, Request, Segment};
use crate::od::ObjectAccess;
use crate::types::{AbortCode, Address, Duration, Instant};

/// Segments of a sub-block of a block download.
const BLOCK_SIZE: u8 = MOST;

/// A pause in a sub-block as long as this part of the timeout means that its last segments are lost.
const PAUSE: u64 = 4;

/// SDO server of a node. Pass it the frames with the COB-ID of its requests, and send the payloads that it returns.
///
/// Call [`Server::poll`] when [`Server::deadline`] has come and after [`Server::on_sent`].
///
/// ```
/// # use async_canopen::od::machine::{ObjectAccess, Transfer};
/// use async_canopen::sdo::machine::Server;
/// # use async_canopen::types::{AbortCode, Address};
/// use async_canopen::types::{Duration, Instant};
/// # /// Object 1017h alone.
/// # struct Dictionary(Vec<u8>);
/// # impl ObjectAccess for Dictionary {
/// #     fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
/// #         if at.index == 0x1017 { Ok(Transfer::Whole(self.0.len())) } else { Err(AbortCode::NoObject) }
/// #     }
/// #     fn read(&mut self, _: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
/// #         let rest = &self.0[offset..];
/// #         let count = rest.len().min(into.len());
/// #         into[..count].copy_from_slice(&rest[..count]);
/// #         Ok(count)
/// #     }
/// #     fn download(&mut self, _: Address, _: Option<usize>) -> Result<Transfer, AbortCode> { Ok(Transfer::Whole(2)) }
/// #     fn write(&mut self, _: Address, value: &[u8]) -> Result<(), AbortCode> { self.0 = value.to_vec(); Ok(()) }
/// #     fn write_part(&mut self, _: Address, _: usize, _: &[u8]) -> Result<(), AbortCode> { Ok(()) }
/// #     fn finish(&mut self, _: Address, _: usize) -> Result<(), AbortCode> { Ok(()) }
/// #     fn cancel(&mut self, _: Address) {}
/// # }
///
/// let mut objects = Dictionary(vec![100, 0]); // implements `ObjectAccess`, as the dictionary of a node does
/// let mut server = Server::new(Duration::from_millis(500));
/// let mut answers = Vec::new();
/// let send = &mut |payload| answers.push(payload);
/// let read_1017h = [0x40, 0x17, 0x10, 0, 0, 0, 0, 0];
/// let read_1018h = [0x40, 0x18, 0x10, 1, 0, 0, 0, 0];
/// assert!(server.on_request(&read_1017h, Instant::ZERO, &mut objects, send));
/// assert!(server.on_request(&read_1018h, Instant::ZERO, &mut objects, send));
/// assert_eq!(answers[0], [0x4B, 0x17, 0x10, 0, 100, 0, 0, 0]);
/// assert_eq!(answers[1], [0x80, 0x18, 0x10, 1, 0x00, 0x00, 0x02, 0x06]); // 0602 0000h: no such object
/// ```
///
/// # Limits
///
/// - A new initiate request ends a running transfer without an abort: the client has started again.
/// - In a sub-block of a download a request is a segment. A client that gives up there sends an abort first, or waits
///   for that of the server, which comes one and a quarter of the timeout after the last segment.
/// - Any other request that does not belong to the transfer aborts it. A late segment of an ended transfer is
///   recognised, and ignored.
#[doc(alias("SDO server", "SSDO", "1200h"))]
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Server {
    state: State,
    timeout: Duration,
    /// End of the time that the transfer waits, for the rest of a sub-block or for any frame.
    deadline: Instant,
    value: Value,
}

/// The client's next move in the transfer of [`Server::value`].
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum State {
    /// No transfer.
    Idle,
    /// No transfer; segments of the last one may still come.
    Drain(Strays),
    /// Download segment.
    Download { toggle: bool },
    /// Upload segment request for the bytes from `offset` on.
    Upload { toggle: bool, offset: u32 },
    /// Segments of a sub-block. After a refusal the rest of the sub-block is ignored before the abort is sent.
    BlockDownload { receiver: Receiver, refused: Option<AbortCode> },
    /// End of a block download.
    BlockDownloadEnd(Receiver),
    /// Start of a block upload.
    BlockUploadStart(Sender),
    /// Acknowledgement of a sub-block.
    BlockUpload(Sender),
    /// Answer to the end of a block upload.
    BlockUploadEnd,
}

/// One call of the server: the time, the dictionary, and where its responses go.
struct Turn<'a, O, S> {
    now: Instant,
    objects: &'a mut O,
    send: &'a mut S,
}

impl<O: ObjectAccess, S: FnMut(Payload)> Turn<'_, O, S> {
    #[inline(never)] // from many places
    fn send(&mut self, payload: Payload) {
        if !self.objects.hold(&payload) {
            (self.send)(payload);
        }
    }

    fn abort(&mut self, at: Address, code: AbortCode) {
        self.send(wire::abort(at, code.code()));
    }
}

impl Server {
    /// Makes a server without a transfer. A transfer without progress for `timeout` is aborted.
    pub const fn new(timeout: Duration) -> Server {
        Server { state: State::Idle, timeout, deadline: Instant::ZERO, value: Value::new() }
    }

    /// Handles a request. Returns whether it was of use. Segments out of order, repeated frames and aborts
    /// without a transfer are ignored.
    #[inline(always)] // called from one place
    pub fn on_request(
        &mut self,
        payload: &Payload,
        now: Instant,
        objects: &mut impl ObjectAccess,
        send: &mut impl FnMut(Payload),
    ) -> bool {
        // First what nearly all are.
        if matches!(self.state, State::Idle) {
            match initiate::number(payload, objects) {
                Ok(None) => {}
                Ok(Some(response)) => {
                    send(response);
                    return true;
                }
                Err(code) => {
                    Turn { now, objects, send }.abort(wire::address(payload), code);
                    return true;
                }
            }
        }
        self.on_other(payload, &mut Turn { now, objects, send })
    }

    /// All but numbers without a transfer.
    #[inline(never)]
    fn on_other(
        &mut self,
        payload: &Payload,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> bool {
        if let State::BlockDownload { refused, .. } = &self.state {
            // Some clients send no segment of an empty value. It has none that could be taken for its end.
            let [command, ..] = payload;
            if refused.is_some() || !self.value.is_empty() || !wire::is_block_end(*command) {
                return self.on_sub_block(payload, turn);
            }
        }
        let request = Request::parse(payload);
        if !matches!(self.state, State::Idle)
            && let Some(used) = self.go_on(payload, &request, turn)
        {
            return used;
        }
        self.initiate(payload, request, turn)
    }

    /// A request while a transfer runs. `None`: it is over, the request may begin another one.
    fn go_on(
        &mut self,
        payload: &Payload,
        request: &Request,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Option<bool> {
        let [command, data @ ..] = payload;
        match &mut self.state {
            State::Drain(strays) => {
                if strays.claim(*command, turn.now) {
                    return Some(false);
                }
                self.state = State::Idle;
                return None;
            }
            State::BlockDownloadEnd(receiver)
                if receiver.is_repeat(*command)
                    && self.value.ends_with(data)
                    && !wire::is_block_end(*command) =>
            {
                return Some(false);
            }
            _ => {}
        }
        if request.is_initiate() {
            self.reset(turn.objects);
            return None;
        }
        let served = match (&mut self.state, request) {
            (_, Request::Abort) => {
                self.reset(turn.objects);
                return Some(true);
            }
            (State::Download { toggle }, Request::DownloadSegment(segment)) => {
                let toggle = *toggle;
                self.on_download_segment(toggle, segment, turn)
            }
            (State::Upload { toggle, offset }, Request::UploadSegment { toggle: asked }) => {
                let (toggle, offset) = (*toggle, *offset);
                if *asked == toggle {
                    self.send_segment(toggle, offset, turn)
                } else {
                    Err(AbortCode::Toggle)
                }
            }
            (
                State::BlockDownload { .. } | State::BlockDownloadEnd(_),
                Request::BlockDownloadEnd { unused, crc },
            ) => self.value.finish_blocks(*unused, *crc, turn.objects).map(|()| {
                self.state = State::Idle;
                turn.send(wire::block_end_answer());
            }),
            (State::BlockUploadStart(sender), Request::BlockUploadStart) => {
                self.state = State::BlockUpload(sender.clone());
                self.send_sub_block(turn)
            }
            (State::BlockUpload(_), Request::BlockUploadAck { ackseq, block_size }) => {
                match self.on_ack(*ackseq, *block_size, turn) {
                    Ok(true) => Ok(()),
                    Ok(false) => return Some(false),
                    Err(code) => Err(code),
                }
            }
            (State::BlockUpload(sender), Request::BlockUploadStart) if sender.is_first() => {
                return Some(false);
            }
            (State::BlockUploadEnd, Request::BlockUploadEnd) => {
                self.state = State::Idle;
                Ok(())
            }
            (State::BlockUploadEnd, Request::BlockUploadAck { .. }) => return Some(false),
            _ => Err(AbortCode::CommandSpecifier),
        };
        self.deadline = turn.now + self.timeout;
        if let Err(code) = served {
            self.abort(code, turn);
        }
        Some(true)
    }

    fn on_download_segment(
        &mut self,
        toggle: bool,
        segment: &Segment,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        if segment.toggle != toggle {
            return Err(AbortCode::Toggle);
        }
        if segment.is_vain() {
            return Err(AbortCode::TooShort);
        }
        self.value.push(&segment.data, usize::from(segment.len), turn.objects)?;
        self.state = if segment.last {
            self.value.finish(turn.objects)?;
            State::Idle
        } else {
            State::Download { toggle: !toggle }
        };
        turn.send(wire::download_segment_response(toggle));
        Ok(())
    }

    fn send_segment(
        &mut self,
        toggle: bool,
        offset: u32,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        let (data, len) = self.value.segment(offset, turn.objects)?;
        let offset = offset.saturating_add(len as u32);
        let last = offset >= self.value.size();
        self.state = if last { State::Idle } else { State::Upload { toggle: !toggle, offset } };
        turn.send(Segment { toggle, last, len: len as u8, data }.payload());
        Ok(())
    }

    /// Sends or aborts what is due at `now`.
    pub fn poll(&mut self, now: Instant, objects: &mut impl ObjectAccess, send: &mut impl FnMut(Payload)) {
        let turn = &mut Turn { now, objects, send };
        if self.is_busy() && self.deadline <= now {
            if self.is_sub_block_heard() {
                self.end_sub_block(false, turn);
            } else {
                // Time for what is on its way.
                self.deadline = now + self.pause();
                self.abort(AbortCode::Timeout, turn);
            }
        } else if matches!(self.state, State::BlockUpload(_))
            && let Err(code) = self.send_sub_block(turn)
        {
            self.abort(code, turn);
        }
    }

    /// Returns when to [poll](Server::poll) at the latest: in the past if a segment is to be sent.
    #[inline]
    pub fn deadline(&self) -> Option<Instant> {
        match &self.state {
            State::Idle | State::Drain(_) => None,
            State::BlockUpload(sender) if sender.next(self.value.size()).is_some() => Some(Instant::ZERO),
            _ => Some(self.deadline),
        }
    }

    /// Notes that a frame of this server left the bus, or failed.
    pub fn on_sent(&mut self) {
        if let State::BlockUpload(sender) = &mut self.state {
            sender.on_sent();
        }
    }

    /// Returns whether a transfer is running.
    pub fn is_busy(&self) -> bool {
        !matches!(self.state, State::Idle | State::Drain(_))
    }

    /// Ends a transfer without an abort, as a reset of the communication does.
    pub fn reset(&mut self, objects: &mut impl ObjectAccess) {
        self.value.close(objects);
        self.state = match &self.state {
            State::BlockDownload { receiver, .. } => State::Drain(receiver.strays(self.deadline)),
            _ => State::Idle,
        };
    }

    /// Ends a transfer because the bus of the client was left. Sends the client an abort on the new bus. No other
    /// frame of the transfer is sent there.
    pub fn on_bus_changed(
        &mut self,
        now: Instant,
        objects: &mut impl ObjectAccess,
        send: &mut impl FnMut(Payload),
    ) {
        self.abort(AbortCode::DeviceState, &mut Turn { now, objects, send });
        self.state = State::Idle;
    }

    /// Ends a transfer and sends the client an abort with the reason.
    fn abort(&mut self, code: AbortCode, turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>) {
        if self.is_busy() {
            turn.abort(self.value.at, code);
            self.reset(turn.objects);
        }
    }

    fn pause(&self) -> Duration {
        Duration::from_micros(self.timeout.as_micros() / PAUSE)
    }
}
