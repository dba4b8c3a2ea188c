//! The SDO client, between an application and any server.

use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::{Client, Payload};
use ecss_can::types::{Address, Duration, Instant};
use ecss_can_worlds::judge::sdo::checksum;

use crate::fuzz::{Input, Signature};

const TIMEOUT: Duration = Duration::from_millis(400);
const AT: Address = Address::new(0x2008, 0);
const SPANS: [Duration; 3] = [Duration::from_millis(1), Duration::from_millis(100), TIMEOUT];

/// First byte of an abort.
const ABORT: u8 = 0x80;
/// Largest number of frames of one call.
const BURST: usize = 20;

/// Progress of a transfer, derived from frames only.
#[derive(Clone, Copy, PartialEq)]
enum Phase {
    /// Before the first answer.
    Begun,
    Segments,
    Blocks,
    End,
    Over,
}

struct World<'a> {
    client: Client,
    now: Instant,
    up: bool,
    size: usize,
    phase: Phase,
    /// The last frame that was sent outside sub-blocks.
    asked: Payload,
    /// Bytes that were transferred and confirmed.
    bytes: Vec<u8>,
    /// Segments of the present sub-block.
    segments: Vec<Payload>,
    pushed: usize,
    pulled: Vec<u8>,
    outcome: Option<Result<usize, Error>>,
    signature: &'a mut Signature,
}

/// Returns a byte of the value of a download.
fn value(at: usize) -> u8 {
    (at.wrapping_mul(167) ^ (at >> 8)) as u8
}

/// Runs an input. An operation is a byte for its kind, and its arguments.
pub fn run(mut input: Input, signature: &mut Signature) {
    let mut world = World {
        client: Client::new(TIMEOUT),
        now: Instant::from_micros(1_000_000),
        up: false,
        size: 0,
        phase: Phase::Over,
        asked: [0; 8],
        bytes: vec![],
        segments: vec![],
        pushed: 0,
        pulled: vec![],
        outcome: None,
        signature,
    };
    world.begin(&mut input);
    while !input.is_empty() {
        match input.byte() % 12 {
            0 => world.answer(input.bytes()),
            1..=5 => {
                let answer = world.right_answer(input.byte());
                world.answer(answer);
            }
            6 | 7 => {
                for _ in 0..input.byte() % 128 {
                    let answer = world.right_answer(3);
                    world.answer(answer);
                }
            }
            8 => {
                let mut answer = world.right_answer(input.byte());
                answer[usize::from(input.byte() % 8)] ^= input.byte();
                world.answer(answer);
            }
            9 => world.wait(input.pick(&SPANS)),
            10 => world.apply(input.word()),
            _ => match input.byte() {
                0xF0.. => {
                    world.client.cancel(&mut |frame: Payload| assert_eq!(frame[0], ABORT));
                    world.begin(&mut input);
                }
                0xE8..=0xEF => world.call(None, |client, _, mut send| {
                    client.bus_changed(&mut send);
                    false
                }),
                count => {
                    (0..count % 10).for_each(|_| world.client.on_sent());
                    world.poll();
                }
            },
        }
    }
    world.rest();
}

impl World<'_> {
    fn begin(&mut self, input: &mut Input) {
        let mode = input.pick(&[Mode::Auto, Mode::Segmented, Mode::Block]);
        self.up = input.byte().is_multiple_of(2);
        self.size = usize::from(input.word() % 2_000);
        if input.byte().is_multiple_of(2) {
            self.size %= 32;
        }
        (self.phase, self.pushed, self.outcome) = (Phase::Begun, 0, None);
        self.bytes.clear();
        self.segments.clear();
        self.pulled.clear();
        if self.up {
            self.client.start_upload(AT, self.size, mode);
        } else {
            self.client.start_download(AT, self.size, mode);
        }
        self.poll();
    }

    /// Lets the application provide or take up to `count` bytes.
    fn apply(&mut self, count: u16) {
        let count = usize::from(count) % 1_024;
        if self.up {
            let mut into = vec![0; count];
            let pulled = self.client.pull(&mut into);
            self.pulled.extend(&into[..pulled]);
        } else if self.outcome.is_none() {
            let end = (self.pushed + count).min(self.size);
            let bytes: Vec<u8> = (self.pushed..end).map(value).collect();
            self.pushed += self.client.push(&bytes);
        }
        self.poll();
    }

    fn poll(&mut self) {
        self.call(None, |client, now, mut send| {
            client.poll(now, &mut send);
            false
        });
        let due = self.client.deadline();
        assert!(due.is_none_or(|due| due > self.now), "a deadline of the past");
    }

    fn answer(&mut self, answer: Payload) {
        self.call(Some(answer), |client, now, mut send| client.on_response(&answer, now, &mut send));
        self.poll();
    }

    /// Calls the client, with an answer or for another reason, and checks its frames.
    fn call(
        &mut self,
        answer: Option<Payload>,
        call: impl FnOnce(&mut Client, Instant, &mut dyn FnMut(Payload)) -> bool,
    ) {
        let was_over = self.phase == Phase::Over;
        let mut sent = vec![];
        let used = call(&mut self.client, self.now, &mut |frame| sent.push(frame));
        assert!(sent.len() <= BURST, "{} frames", sent.len());
        assert!(!was_over || sent.is_empty(), "after the end: {sent:02X?}");
        let failed = sent.iter().any(|frame| frame[0] == ABORT);
        if let Some(answer) = answer {
            self.signature.note(0x400 | u32::from(answer[0] >> 5) << 1 | u32::from(used));
            if used && !failed {
                self.see_answer(&answer);
            }
        }
        for frame in &sent {
            let is_segment = self.phase == Phase::Blocks;
            self.signature.note(if is_segment { 0x200 } else { u32::from(frame[0]) });
            self.see(frame);
        }
        if let Some(outcome) = self.client.outcome() {
            assert!(self.outcome.is_none(), "two outcomes");
            self.signature.note(outcome.map_or_else(Error::code, |_| 1));
            self.outcome = Some(outcome);
            self.phase = Phase::Over;
        }
    }

    /// Checks a frame of the client.
    fn see(&mut self, frame: &Payload) {
        match (self.phase, frame[0]) {
            (Phase::Over, _) => panic!("after the end"),
            // No segment has this number.
            (_, ABORT) => self.phase = Phase::Over,
            (Phase::Blocks, _) if !self.up => {
                assert_eq!(usize::from(frame[0] & 0x7F), self.segments.len() + 1, "a segment out of order");
                self.segments.push(*frame);
            }
            (Phase::Blocks, 0xA2) => {
                assert_eq!(usize::from(frame[1]), self.segments.len(), "acknowledged is what came in order");
                self.phase = if self.is_complete() { Phase::End } else { Phase::Blocks };
                self.settle(self.segments.len());
            }
            (Phase::End, _) if !self.up => {
                let [low, high] = checksum(&self.bytes).to_le_bytes();
                let unused = if self.size == 0 { 7 } else { (7 - self.size % 7) % 7 };
                assert_eq!(frame[0], 0xC1 | (unused as u8) << 2);
                assert!(
                    matches!([frame[1], frame[2]], sum if sum == [0, 0] || sum == [low, high]),
                    "a wrong checksum"
                );
            }
            _ => self.asked = *frame,
        }
    }

    /// Handles an answer that the client used.
    fn see_answer(&mut self, answer: &Payload) {
        let (answered, asked) = (answer[0] >> 5, self.asked[0] >> 5);
        let is_toggle_right = self.asked[0] & 0x10 == answer[0] & 0x10;
        match self.phase {
            Phase::Begun if answered == 4 => {}
            Phase::Begun => {
                let at = Address::new(u16::from_le_bytes([answer[1], answer[2]]), answer[3]);
                assert_eq!(at, AT, "another object's");
                self.phase = if answered >= 5 { Phase::Blocks } else { Phase::Segments };
                match (answered, asked) {
                    (2, _) if answer[0] & 3 == 3 => self.bytes.extend(expedited(answer)),
                    (2, _) if answer[0] & 3 == 2 => self.bytes.extend(answer[4..].iter().take(self.size)),
                    (3, 1) if self.asked[0] & 2 != 0 => self.bytes.extend(expedited(&self.asked)),
                    (2, 2 | 5) | (3, 1) | (5, 6) | (6, 5) => {}
                    other => panic!("taken: {other:?}"),
                }
            }
            Phase::Segments if answered == 4 => {}
            Phase::Segments if self.up => {
                assert!(is_toggle_right && answered == 0);
                self.bytes.extend(segment(answer));
            }
            Phase::Segments => {
                assert!(is_toggle_right && answered == 1);
                self.bytes.extend(segment(&self.asked));
            }
            Phase::Blocks if answer[0] == ABORT || !self.up && answered == 4 => {}
            Phase::Blocks if self.up => {
                assert_eq!(usize::from(answer[0] & 0x7F), self.segments.len() + 1, "out of order");
                self.segments.push(*answer);
            }
            Phase::Blocks => {
                self.settle(usize::from(answer[1]));
                self.bytes.truncate(self.size);
                if self.bytes.len() == self.size && answer[1] > 0 {
                    self.phase = Phase::End;
                }
            }
            Phase::End if answered == 4 => {}
            Phase::End if self.up => {
                self.bytes.truncate(self.bytes.len() - usize::from(answer[0] >> 2 & 7));
            }
            Phase::End => assert_eq!(answer[0] & 0xE3, 0xA1),
            Phase::Over => panic!("of use after the end"),
        }
    }

    /// Confirms the first segments. The others are to be sent again.
    fn settle(&mut self, good: usize) {
        assert!(good <= self.segments.len(), "more than was sent");
        self.segments.drain(..).take(good).for_each(|segment| self.bytes.extend(&segment[1..]));
    }

    /// Returns whether the last segment of the value is in the present sub-block.
    fn is_complete(&self) -> bool {
        self.segments.last().is_some_and(|last| last[0] & 0x80 != 0)
    }

    /// Returns the answer of a correct server. `how` selects among alternatives.
    fn right_answer(&self, how: u8) -> Payload {
        let [low, high] = AT.index.to_le_bytes();
        let size = (self.size as u16).to_le_bytes();
        let left = self.size.saturating_sub(self.bytes.len());
        let named = |command, four, five| [command, low, high, 0, four, five, 0, 0];
        let short = |command, one, two| [command, one, two, 0, 0, 0, 0, 0];
        let toggle = self.asked[0] & 0x10;
        match (self.phase, self.asked[0] >> 5) {
            (Phase::Begun, 1) => named(0x60, 0, 0),
            (Phase::Begun, 2) if (1..=4).contains(&self.size) => {
                named(0x43 | (4 - self.size as u8) << 2, how, 1)
            }
            (Phase::Begun, 2) => named(0x40 | how & 1, size[0] * (how & 1), size[1] * (how & 1)),
            (Phase::Begun, 5) if how > 0xE0 => named(0x41, size[0], size[1]),
            (Phase::Begun, 5) => named(0xC0 | (how & 3) << 1, size[0], size[1]),
            (Phase::Begun, 6) if how > 0xE0 => [0x80, low, high, 0, 1, 0, 4, 5],
            (Phase::Begun, 6) => named(0xA0 | how & 4, if how > 7 { how / 2 } else { 127 }, 0),
            (Phase::Segments, _) if self.up => {
                let unused = 7_usize.saturating_sub(left) as u8;
                [toggle | unused << 1 | u8::from(left <= 7), how, 1, 2, 3, 4, 5, 6]
            }
            (Phase::Segments, _) => short(0x20 | toggle, 0, 0),
            (Phase::Blocks, _) if self.up => {
                let next = self.segments.len() as u8 + 1;
                let last = u8::from(left <= usize::from(next) * 7) << 7;
                [next & 0x7F | last, next, 1, 2, 3, 4, 5, how]
            }
            (Phase::Blocks, _) => {
                let all = self.segments.len() as u8;
                let lost = if how > 0xC0 { how & 7 } else { 0 };
                short(0xA2, all.saturating_sub(lost), if how & 0xC0 == 0x40 { how & 0x1F } else { 127 })
            }
            (Phase::End, _) if self.up => {
                let len = self.size.min(self.bytes.len());
                let unused = (self.bytes.len() - len).min(7) as u8;
                let [low, high] = checksum(&self.bytes[..len]).to_le_bytes();
                short(0xC1 | unused << 2, low, high)
            }
            _ => short(0xA1, 0, 0),
        }
    }

    fn wait(&mut self, span: Duration) {
        let until = self.now + span;
        while let Some(due) = self.client.deadline().filter(|due| *due <= until) {
            self.now = due;
            self.poll();
        }
        self.now = until;
    }

    /// Checks that a cooperating application ends its transfer with any server.
    fn rest(&mut self) {
        for _ in 0..8 {
            self.apply(1_000);
            self.wait(TIMEOUT);
        }
        assert_eq!(self.client.deadline(), None, "stuck");
        let mut into = vec![0; 2_000];
        let pulled = self.client.pull(&mut into);
        self.pulled.extend(&into[..pulled]);
        match self.outcome {
            None => panic!("no outcome"),
            Some(Ok(moved)) if self.up => {
                assert_eq!(moved, self.bytes.len());
                assert!(moved <= self.size, "more than was asked for");
                assert!(self.pulled == self.bytes, "not what the frames carried");
            }
            Some(Ok(moved)) => {
                assert_eq!(moved, self.size);
                assert!(self.bytes.iter().copied().eq((0..self.size).map(value)), "not what was given");
            }
            Some(Err(_)) if self.up => {
                self.settle(self.segments.len());
                assert!(self.bytes.starts_with(&self.pulled), "not what the frames carried");
            }
            Some(Err(_)) => {}
        }
    }
}

/// Returns the data of an expedited transfer with indicated size.
fn expedited(frame: &Payload) -> &[u8] {
    &frame[4..8 - usize::from(frame[0] >> 2 & 3)]
}

/// Returns the data of a segment outside sub-blocks.
fn segment(frame: &Payload) -> &[u8] {
    &frame[1..8 - usize::from(frame[0] >> 1 & 7)]
}
