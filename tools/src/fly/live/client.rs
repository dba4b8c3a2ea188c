//! One client: its socket, the lines it sends, and the frames that wait for it.
//!
//! No call blocks on the client, and all buffers are bounded. The program stops reading from a client that requests
//! faster than the bus sends, or that does not read its answers; TCP then blocks the client. Frames for a client that
//! does not read are dropped and counted.

use std::io::{ErrorKind, Read, Write};

use can_twin::wire::controller::ErrorCounters;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::channel::{Channel, Mode, Refusal};
use super::slcan::{ERROR, LONGEST, OK};

/// Size of the buffer of bytes read and not yet parsed.
const INPUT: usize = 4096;

/// Size of the buffer of bytes that the client has not read yet: a second of a full bus, half an hour of heartbeats.
const OUTPUT: usize = 256 * 1024;

/// Part of [`OUTPUT`] that is reserved for answers.
const FOR_ANSWERS: usize = 1024;

/// Frames of one client that the bus has not sent yet.
const IN_FLIGHT: usize = 32;

/// Number of refused lines of one client that are reported; all are counted.
const REPORTED: u64 = 5;

/// Counters of a client.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames received from it.
    pub taken: u64,
    /// Frames given to it, or waiting in its buffer.
    pub given: u64,
    /// Frames dropped because its buffer was full.
    pub lost: u64,
    /// Refused lines; without requests for a state that the channel has already.
    pub refused: u64,
}

/// A client of one bus; `S` does not block.
#[derive(Debug)]
pub struct Client<S> {
    stream: S,
    channel: Channel,
    input: Vec<u8>,
    output: Vec<u8>,
    /// Begin of a line that is too long and skipped up to its end.
    skipping: Option<Vec<u8>>,
    /// Reports of refused lines, to be taken from here; at most [`REPORTED`].
    pub refused: Vec<String>,
    /// It sends nothing more.
    ended: bool,
    /// Nothing more can be sent to it.
    broken: bool,
    in_flight: usize,
    /// Counters so far.
    pub counts: Counts,
}

impl<S: Read + Write> Client<S> {
    /// Makes a client that has just connected to this channel.
    pub fn new(stream: S, channel: Channel) -> Self {
        Client {
            stream,
            channel,
            input: Vec::new(),
            output: Vec::new(),
            skipping: None,
            refused: Vec::new(),
            ended: false,
            broken: false,
            in_flight: 0,
            counts: Counts::default(),
        }
    }

    /// Returns how it takes part in its bus; a disconnected client does not.
    pub fn mode(&self) -> Mode {
        if self.ended { Mode::Closed } else { self.channel.mode }
    }

    /// Returns whether it has disconnected and all its lines were handled.
    pub fn is_gone(&self) -> bool {
        self.broken || self.ended && !self.input.contains(&OK)
    }

    /// Reads and executes lines, as far as there is room for answers. Returns the frames to send.
    pub fn listen(&mut self, errors: ErrorCounters) -> Vec<WireFrame> {
        self.read();
        let mut frames = Vec::new();
        while self.in_flight < IN_FLIGHT && self.output.len() + LONGEST <= OUTPUT {
            let Some(line) = self.next_line() else { break };
            if let Some(begin) = self.skipping.take() {
                self.output.push(ERROR);
                self.refuse(&begin, Refusal::TooLong);
                continue;
            }
            match self.channel.obey(&line, errors, &mut self.output) {
                Ok(Some(frame)) => {
                    self.in_flight += 1;
                    self.counts.taken += 1;
                    frames.push(frame);
                }
                Err(refusal) if refusal.is_mistake() => self.refuse(&line, refusal),
                Ok(None) | Err(_) => {}
            }
        }
        frames
    }

    /// Counts a refused line, and reports the first of them.
    fn refuse(&mut self, line: &[u8], refusal: Refusal) {
        self.counts.refused += 1;
        if self.counts.refused <= REPORTED {
            let dots = if refusal == Refusal::TooLong { "..." } else { "" };
            let last = if self.counts.refused == REPORTED { "; more of them are only counted" } else { "" };
            self.refused.push(format!("line \"{}{dots}\" refused: {refusal}{last}", line.escape_ascii()));
        }
    }

    fn read(&mut self) {
        let mut chunk = [0; INPUT];
        while !self.ended && self.input.len() < INPUT {
            match self.stream.read(&mut chunk[..INPUT - self.input.len()]) {
                Ok(0) => self.ended = true,
                Ok(count) => self.input.extend(chunk.iter().take(count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => (self.ended, self.broken) = (true, true),
            }
        }
    }

    /// Returns the next line without its end; `None` if none is complete. For a line longer than [`LONGEST`] returns
    /// its rest, with its begin in `skipping`.
    fn next_line(&mut self) -> Option<Vec<u8>> {
        let end = self.input.iter().position(|byte| *byte == OK);
        let length = end.unwrap_or(self.input.len());
        // Users at a terminal and some programs send a line feed as well.
        let line_feed = usize::from(self.input.first() == Some(&b'\n'));
        if self.skipping.is_none() && length - line_feed.min(length) > LONGEST {
            self.skipping = Some(self.input[line_feed..line_feed + LONGEST].to_vec());
        }
        let Some(end) = end else {
            if self.skipping.is_some() {
                self.input.clear();
            }
            return None;
        };
        Some(self.input.drain(..=end).take(end).skip(line_feed).collect())
    }

    /// Records that its oldest frame was sent.
    pub fn was_sent(&mut self) {
        self.in_flight = self.in_flight.saturating_sub(1);
    }

    /// Drops all its frames that were not sent. Further lines of a disconnected client are ignored.
    pub fn was_abandoned(&mut self) {
        self.in_flight = 0;
        self.broken |= self.ended;
    }

    /// Gives it a frame that was on the bus at `at`.
    pub fn give(&mut self, at: Time, frame: &WireFrame) {
        let Some(line) = self.channel.line(at, frame) else { return };
        if self.output.len() + line.len() > OUTPUT - FOR_ANSWERS {
            self.counts.lost += 1;
            self.channel.overrun = true;
        } else {
            self.counts.given += 1;
            self.output.extend(line);
        }
    }

    /// Writes as much as the client accepts now.
    pub fn flush(&mut self) {
        let mut taken = 0;
        while taken < self.output.len() && !self.broken {
            match self.stream.write(&self.output[taken..]) {
                Ok(0) => self.broken = true,
                Ok(count) => taken += count,
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.broken = true,
            }
        }
        self.output.drain(..taken);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::io;

    use super::*;

    /// A socket with the test at the other end.
    #[derive(Default)]
    struct Wire {
        to_read: VecDeque<u8>,
        closed: bool,
        written: Vec<u8>,
        room: usize,
    }

    impl Read for Wire {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            match self.to_read.read(buffer)? {
                0 if !self.closed => Err(ErrorKind::WouldBlock.into()),
                count => Ok(count),
            }
        }
    }

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let count = bytes.len().min(self.room);
            if count == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.room -= count;
            self.written.extend(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn client() -> Client<Wire> {
        Client::new(Wire { room: usize::MAX, ..Wire::default() }, Channel::new(1_000_000, 1))
    }

    fn listen(client: &mut Client<Wire>) -> Vec<WireFrame> {
        client.listen(ErrorCounters::default())
    }

    /// Sends bytes to the client's port. Returns the frames to be sent, and the answers.
    fn says(client: &mut Client<Wire>, bytes: &[u8]) -> (Vec<WireFrame>, String) {
        client.stream.to_read.extend(bytes);
        let frames = listen(client);
        client.flush();
        (frames, String::from_utf8(std::mem::take(&mut client.stream.written)).unwrap())
    }

    fn open() -> Client<Wire> {
        let mut client = client();
        assert_eq!(says(&mut client, b"O\r").1, "\r");
        client
    }

    const FRAME: WireFrame =
        WireFrame { id: can_twin::wire::frame::WireId::Standard(0x080), remote: false, dlc: 0, data: [0; 8] };

    #[test]
    fn lines_come_in_any_pieces() {
        let mut client = client();
        assert_eq!(says(&mut client, b"O"), (vec![], String::new()));
        assert_eq!(says(&mut client, b"\rt08"), (vec![], "\r".into()));
        assert_eq!(says(&mut client, b"00\rt0800\r\r"), (vec![FRAME; 2], "z\rz\r\r".into()));
        assert_eq!(client.counts, Counts { taken: 2, ..Counts::default() });
    }

    #[test]
    fn a_line_feed_after_a_line_does_no_harm() {
        assert_eq!(says(&mut client(), b"V\r\nN\r\n\r\n").1, "V0101\rN0001\r\r");
    }

    #[test]
    fn rubbish_is_answered_once_per_line() {
        let mut client = client();
        let all: Vec<u8> = (0..=255).filter(|byte| *byte != OK).collect();
        assert_eq!(says(&mut client, &all).1, "");
        client.stream.to_read.extend([0; 100_000]);
        while !client.stream.to_read.is_empty() {
            assert_eq!(listen(&mut client), []);
            assert!(client.input.len() <= INPUT && client.output.is_empty());
        }
        assert_eq!(says(&mut client, b"\rV\r").1, "\x07V0101\r");
        assert_eq!(says(&mut client, b"\xF0\x9F\r\x00\rV\r").1, "\x07\x07V0101\r");
        assert_eq!(client.counts.refused, 3);
        assert_eq!(
            std::mem::take(&mut client.refused),
            [
                "line \"\\x00\\x01\\x02\\x03\\x04\\x05\\x06\\x07\\x08\\t\\n\\x0b\\x0c\\x0e\\x0f\\x10\\x11\\x12\\x13\\x14\\x15\\x16\\x17\\x18\\x19\\x1a...\" \
                 refused: longer than any command, 26 characters",
                "line \"\\xf0\\x9f\" refused: no SLCAN command, or a malformed one",
                "line \"\\x00\" refused: no SLCAN command, or a malformed one",
            ]
        );
    }

    #[test]
    fn session_of_python_can_has_no_refused_line() {
        let mut client = client();
        let (_, answers) = says(&mut client, b"C\rS8\r\rO\rO\rt0800\rC\r");
        assert_eq!(answers, "\x07\r\r\r\x07z\r\r", "a CAN232 answers so");
        assert_eq!(client.counts.refused, 0);
        assert_eq!(std::mem::take(&mut client.refused), Vec::<String>::new());
    }

    #[test]
    fn refused_lines_are_reported_five_times_and_counted() {
        let mut client = open();
        says(&mut client, &b"S6\r".repeat(7));
        let refused = std::mem::take(&mut client.refused);
        assert_eq!(refused.len(), 5);
        let first = "line \"S6\" refused: the channel is open, close it with C to change a setting";
        assert_eq!(refused[0], first);
        assert!(refused[4].ends_with("more of them are only counted"), "{}", refused[4]);
        assert_eq!(client.counts.refused, 7);
    }

    #[test]
    fn the_longest_line_is_obeyed_and_a_longer_one_refused() {
        let mut client = open();
        let longest = b"T1FFFFFFF80102030405060708\r";
        assert_eq!(says(&mut client, longest).1, "Z\r");
        assert_eq!(says(&mut client, b"T1FFFFFFF801020304050607080\r").1, "\x07");
        assert_eq!(says(&mut client, b"T1FFFFFFF801020304050607").1, "");
        assert_eq!(says(&mut client, b"0809").1, "");
        assert_eq!(says(&mut client, b"0\r").1, "\x07");
        assert_eq!(says(&mut client, longest).1, "Z\r");
    }

    #[test]
    fn who_sends_faster_than_the_bus_is_read_when_the_bus_has_sent() {
        let mut client = open();
        let (frames, _) = says(&mut client, &b"t0800\r".repeat(1000));
        assert_eq!(frames.len(), IN_FLIGHT);
        assert!(client.input.len() <= INPUT && !client.stream.to_read.is_empty());
        assert_eq!(listen(&mut client), []);
        let mut sent = frames.len();
        while client.in_flight > 0 {
            client.was_sent();
            sent += listen(&mut client).len();
        }
        assert_eq!(sent, 1000, "none is lost");
        assert!(client.stream.to_read.is_empty());
    }

    #[test]
    fn who_does_not_read_loses_frames_and_they_are_counted() {
        let mut client = open();
        client.stream.room = 0;
        let frame = WireFrame::standard(0x123, &[0; 8]);
        let line = "t12380000000000000000\r".len();
        let fits = (OUTPUT - FOR_ANSWERS) / line;
        for _ in 0..fits + 7 {
            client.give(Time::ZERO, &frame);
        }
        client.flush();
        assert_eq!(client.counts, Counts { given: fits as u64, lost: 7, ..Counts::default() });
        // It reads again: the flag of the overrun is set, and nothing else is missing.
        client.stream.room = usize::MAX;
        let (_, written) = says(&mut client, b"F\r");
        assert_eq!(written.len(), fits * line + "F08\r".len());
        assert!(written.ends_with("\rF08\r"));
    }

    #[test]
    fn who_does_not_take_answers_is_not_obeyed() {
        let mut client = client();
        client.stream.room = 0;
        for _ in 0..1000 {
            client.stream.to_read.extend(b"V\r".repeat(1000));
            listen(&mut client);
            client.flush();
        }
        assert!(client.output.len() <= OUTPUT, "{}", client.output.len());
        client.stream.room = usize::MAX;
        let mut answers = 0;
        while !client.stream.to_read.is_empty() || !client.output.is_empty() {
            answers += says(&mut client, b"").1.matches("V0101\r").count();
        }
        assert_eq!(answers, 1_000_000);
    }

    #[test]
    fn who_leaves_is_heard_to_the_end() {
        let mut client = open();
        client.stream.to_read.extend(b"t0800\r".repeat(IN_FLIGHT + 1));
        client.stream.to_read.extend(b"t08");
        client.stream.closed = true;
        assert_eq!(listen(&mut client).len(), IN_FLIGHT);
        assert!(!client.is_gone());
        client.was_sent();
        assert_eq!(listen(&mut client).len(), 1);
        assert!(client.is_gone());
    }

    #[test]
    fn client_that_leaves_a_stalled_bus_is_gone_when_given_up() {
        let mut client = open();
        client.stream.to_read.extend(b"t0800\r".repeat(IN_FLIGHT + 1));
        client.stream.closed = true;
        assert_eq!(listen(&mut client).len(), IN_FLIGHT);
        client.was_abandoned();
        assert!(client.is_gone());
    }

    #[test]
    fn whose_socket_breaks_is_gone() {
        let mut client = open();
        client.stream.closed = true;
        client.give(Time::ZERO, &FRAME);
        assert_eq!(listen(&mut client), []);
        assert!(client.is_gone());
    }
}
