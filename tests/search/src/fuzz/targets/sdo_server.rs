//! The SDO server with any client and a small dictionary.

use ecss_can::sdo::machine::{Payload, Server};
use ecss_can::types::{Address, Duration, Instant};
use ecss_can_worlds::judge::sdo::{Transfer, checksum, is_written};

use super::sdo_objects::{OBJECTS, Objects, address};
use crate::fuzz::{Input, Signature};

const TIMEOUT: Duration = Duration::from_millis(400);
const SPANS: [Duration; 4] =
    [Duration::from_millis(1), Duration::from_millis(99), Duration::from_millis(100), TIMEOUT];

/// First bytes of requests.
const INITIATES: [u8; 16] =
    [0x20, 0x21, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x40, 0xA0, 0xA4, 0xC0, 0xC2, 0xC4, 0xC6, 0x80, 0xE0];

/// Largest number of frames that one request or one poll may cause.
const BURST: usize = 10;

struct World<'a> {
    server: Server,
    objects: Objects,
    transfer: Transfer,
    now: Instant,
    signature: &'a mut Signature,
}

/// Runs an input. An operation is a byte for its kind, and its arguments.
pub fn run(mut input: Input, signature: &mut Signature) {
    let mut world = World {
        server: Server::new(TIMEOUT),
        objects: Objects::new(),
        transfer: Transfer::default(),
        now: Instant::from_micros(1_000_000),
        signature,
    };
    while !input.is_empty() {
        match input.byte() % 12 {
            0 => world.ask(input.bytes()),
            1 | 2 => {
                let command = input.pick(&INITIATES);
                let [low, high] = address(input.byte() % (OBJECTS as u8 + 1)).index.to_le_bytes();
                let [sub, a, b, c, d] = input.bytes();
                world.ask([command, low, high, u8::from(sub == 0xFF), a, b, c, d]);
            }
            3 | 4 => world.segment(input.byte()),
            5 | 6 => world.sub_block(input.bytes()),
            7 => world.end(input.byte(), input.byte()),
            8 => world.ask([0x60 | world.toggle(input.byte() == 0xFF), 0, 0, 0, 0, 0, 0, 0]),
            9 => {
                let command = input.pick(&[0xA2, 0xA2, 0xA2, 0xA3, 0xA3, 0xA1]);
                let given = input.byte();
                let all = world.transfer.segments();
                let ackseq = if given < 0xC0 { all } else { given % 4 };
                world.ask([command, ackseq, input.byte() % 130, 0, 0, 0, 0, 0]);
            }
            10 => world.wait(input.pick(&SPANS)),
            _ => match input.byte() {
                0xFF => {
                    world.server.reset(&mut world.objects);
                    world.transfer = Transfer::default();
                }
                count => {
                    (0..count % 10).for_each(|_| world.server.on_sent());
                    world.poll();
                }
            },
        }
        let is_left = world.objects.is_open() && !world.server.is_busy();
        assert!(!is_left, "a stream is left open");
    }
    world.rest();
}

impl World<'_> {
    /// Returns the expected toggle bit, or the wrong one.
    fn toggle(&self, wrong: bool) -> u8 {
        self.transfer.toggle() ^ if wrong { 0x10 } else { 0 }
    }

    /// Sends the next segment of a download.
    fn segment(&mut self, how: u8) {
        let last = u8::from(how & 0xC0 == 0);
        let unused = if last == 1 { how & 7 } else { 0 };
        let toggle = self.toggle(how & 0xF0 == 0xF0);
        self.ask([toggle | unused << 1 | last, how, 2, 3, 4, 5, 6, 7]);
    }

    /// Sends segments of a sub-block from the expected one on. Some may be omitted.
    fn sub_block(&mut self, [count, how]: [u8; 2]) {
        let first = self.transfer.next() + if how > 0xE0 { how & 3 } else { 0 };
        let last = first.saturating_add(count % 128).min(127);
        for seqno in first..=last {
            let ends = u8::from(seqno == last && how & 1 == 0) << 7;
            self.ask([seqno | ends, seqno, how, 3, 4, 5, 6, 7]);
        }
    }

    /// Ends a block download with the right or a wrong checksum.
    fn end(&mut self, unused: u8, wrong: u8) {
        let unused = unused & 7;
        let bytes = self.transfer.bytes();
        let len = bytes.len().saturating_sub(usize::from(unused));
        let wrong = if wrong > 0xE0 { wrong } else { 0 };
        let [low, high] = (checksum(&bytes[..len]) ^ u16::from(wrong)).to_le_bytes();
        self.ask([0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]);
    }

    fn ask(&mut self, request: Payload) {
        let before = self.objects.changes.len();
        let mut answers = vec![];
        let used =
            self.server.on_request(&request, self.now, &mut self.objects, &mut |answer| answers.push(answer));
        assert!(answers.len() <= BURST, "{} answers", answers.len());
        answers.iter().for_each(|answer| self.signature.note(kind(answer)));
        self.signature.note(0x100 | u32::from(request[0] >> 5) << 1 | u32::from(used));
        let readable = |at| self.objects.readable(at).map(<[u8]>::to_vec);
        let arrived = self.transfer.see(&request, used, &answers, &readable);
        let changes = &self.objects.changes[before..];
        assert!(changes.len() <= 1);
        let change = changes.first();
        assert!(is_written(&request, arrived.as_ref(), change), "{request:02X?}: {arrived:?}, {change:?}");
        self.poll();
    }

    fn poll(&mut self) {
        let mut answers: Vec<Payload> = vec![];
        self.server.poll(self.now, &mut self.objects, &mut |answer| answers.push(answer));
        assert!(answers.len() <= BURST, "{} frames", answers.len());
        answers.iter().for_each(|answer| self.signature.note(0x200 | kind(answer)));
        self.transfer.see_unasked(&answers);
        assert!(self.server.deadline().is_none_or(|due| due > self.now), "a deadline of the past");
    }

    fn wait(&mut self, span: Duration) {
        let until = self.now + span;
        while let Some(due) = self.server.deadline().filter(|due| *due <= until) {
            self.now = due;
            self.poll();
        }
        self.now = until;
    }

    /// Checks that after silence the server serves again.
    fn rest(&mut self) {
        (0..4).for_each(|_| self.wait(TIMEOUT));
        assert!(!self.server.is_busy(), "stuck");
        let at: Address = address(0);
        self.objects.set(at, &[1, 2, 3, 4]);
        let mut answers = vec![];
        let request = [0x40, 0, 0x20, 0, 0, 0, 0, 0];
        self.server.on_request(&request, self.now, &mut self.objects, &mut |answer| answers.push(answer));
        assert_eq!(answers, [[0x43, 0, 0x20, 0, 1, 2, 3, 4]]);
    }
}

/// Returns the kind of an answer: its command specifier, or the code of an abort.
fn kind(answer: &Payload) -> u32 {
    let [command, _, _, _, code @ ..] = *answer;
    if command == 0x80 { u32::from_le_bytes(code) } else { u32::from(command >> 5) }
}
