//! SDO transfers for an observer, from the frames of client and server only (CiA 301 7.2.4.3).
//!
//! [`Transfer`] follows one server. A test gives it each request with the server's answers, and compares the value that
//! it returns with what the server wrote.

use ecss_can::sdo::machine::Payload;
use ecss_can::types::{AbortCode, Address};

/// Segments of a sub-block.
const SUB_BLOCK: u8 = 127;
/// First byte of an abort.
const ABORT: u8 = 0x80;

/// A transfer in progress. Methods panic when an answer of the server breaks the protocol.
#[derive(Default)]
pub struct Transfer(State);

#[derive(Default)]
enum State {
    #[default]
    None,
    Download {
        at: Address,
        bytes: Vec<u8>,
        toggle: u8,
    },
    BlockDownload {
        at: Address,
        bytes: Vec<u8>,
        next: u8,
        checked: bool,
        is_complete: bool,
    },
    Upload {
        value: Value,
        bytes: Vec<u8>,
        toggle: u8,
    },
    BlockUploadStart {
        value: Value,
        checked: bool,
    },
    BlockUpload {
        value: Value,
        checked: bool,
        bytes: Vec<u8>,
        segments: Vec<Payload>,
    },
    BlockUploadEnd,
}

/// Expected value of an upload, if known.
type Value = Option<Vec<u8>>;

/// Index and sub-index of an initiate request.
fn address(payload: &Payload) -> Address {
    Address::new(u16::from_le_bytes([payload[1], payload[2]]), payload[3])
}

/// CRC-CCITT, bit by bit (CiA 301 7.2.4.3.16).
pub fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |sum, byte| {
        (0..8).fold(
            sum ^ u16::from(*byte) << 8,
            |sum, _| {
                if sum & 0x8000 == 0 { sum << 1 } else { sum << 1 ^ 0x1021 }
            },
        )
    })
}

impl Transfer {
    /// Checks a request, whether the server used it, and its responses. Returns the value of a download that ends with
    /// it. `readable`: returns the value of an object, if an upload has to return it.
    pub fn see(
        &mut self,
        request: &Payload,
        used: bool,
        answers: &[Payload],
        readable: &dyn Fn(Address) -> Option<Vec<u8>>,
    ) -> Option<(Address, Vec<u8>)> {
        if used && answers.is_empty() {
            self.see_silent_acknowledgement(request);
        }
        for answer in answers.iter().filter(|answer| answer[0] == ABORT) {
            let code = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
            assert!(AbortCode::from_code(code).is_some(), "abort code {code:08X}");
        }
        let command = request[0];
        if let State::BlockDownload { is_complete: false, .. } = &mut self.0 {
            self.see_sub_block(command, request, answers);
            return None;
        }
        // An unused request may be a repeated segment whose first byte equals that of an abort.
        if (used && command >> 5 == 4) || answers.iter().any(|answer| answer[0] == ABORT) {
            self.0 = State::None;
            return None;
        }
        let Some(answer) = answers.first() else {
            if matches!((command & 0xE3, &self.0), (0xA1, State::BlockUploadEnd)) {
                self.0 = State::None;
            }
            return None;
        };
        match command >> 5 {
            0 => return self.see_segment(command, request, answer),
            1 => {
                assert_eq!(address(answer), address(request));
                assert_eq!(answer[0], 0x60);
                self.0 = State::None;
                let at = address(request);
                match (command & 2 != 0, command & 1 != 0) {
                    (true, false) => return Some((at, request[4..].to_vec())),
                    (true, true) => {
                        return Some((at, request[4..8 - usize::from(command >> 2 & 3)].to_vec()));
                    }
                    _ => self.0 = State::Download { at, bytes: vec![], toggle: 0 },
                }
            }
            2 => self.see_upload(request, answer, readable),
            3 => self.see_upload_segment(command, answer),
            5 => self.see_block_upload(request, used, answers, readable),
            _ if command & 1 == 0 => {
                assert_eq!((answer[0], answer[4]), (0xA0 | command & 4, SUB_BLOCK));
                let at = address(request);
                let checked = command & 4 != 0;
                self.0 = State::BlockDownload { at, bytes: vec![], next: 1, checked, is_complete: false };
            }
            _ => return self.see_end(command, request, answer),
        }
        None
    }

    /// Checks frames that the server sends without a request.
    pub fn see_unasked(&mut self, answers: &[Payload]) {
        match &mut self.0 {
            _ if answers.is_empty() => {}
            _ if answers.iter().any(|answer| answer[0] == ABORT) => self.0 = State::None,
            State::BlockDownload { next, is_complete: false, .. } => {
                assert_eq!((answers.len(), answers[0][0], answers[0][1]), (1, 0xA2, *next - 1));
                *next = 1;
            }
            State::BlockUpload { segments, .. } => take_segments(segments, answers),
            _ => panic!("unasked: {answers:02X?}"),
        }
    }

    /// Returns the toggle bit of the next segment: 0 or 10h.
    pub fn toggle(&self) -> u8 {
        match &self.0 {
            State::Download { toggle, .. } | State::Upload { toggle, .. } => *toggle,
            _ => 0,
        }
    }

    /// Returns the number of the next segment of a block download, from 1.
    pub fn next(&self) -> u8 {
        if let State::BlockDownload { next, .. } = &self.0 { *next } else { 1 }
    }

    /// Returns the bytes of a download that have arrived.
    pub fn bytes(&self) -> &[u8] {
        match &self.0 {
            State::Download { bytes, .. } | State::BlockDownload { bytes, .. } => bytes,
            _ => &[],
        }
    }

    /// Returns the number of segments of a sub-block that the server has sent.
    pub fn segments(&self) -> u8 {
        if let State::BlockUpload { segments, .. } = &self.0 { segments.len() as u8 } else { 0 }
    }
    fn see_sub_block(&mut self, command: u8, request: &Payload, answers: &[Payload]) {
        let State::BlockDownload { bytes, next, is_complete, .. } = &mut self.0 else { return };
        if command == ABORT || answers.iter().any(|answer| answer[0] == ABORT) {
            self.0 = State::None;
            return;
        }
        let is_taken = command & 0x7F == *next;
        if is_taken {
            bytes.extend(&request[1..]);
            *next += 1;
        }
        if let [answer] = answers {
            assert_eq!((answer[0], answer[1]), (0xA2, *next - 1), "acknowledged is what came in order");
            *next = 1;
            *is_complete = is_taken && command & 0x80 != 0;
        } else {
            assert!(answers.is_empty());
        }
    }

    fn see_segment(
        &mut self,
        command: u8,
        request: &Payload,
        answer: &Payload,
    ) -> Option<(Address, Vec<u8>)> {
        let State::Download { at, bytes, toggle } = &mut self.0 else { panic!("a segment of nothing") };
        assert_eq!((command & 0x10, answer[0]), (*toggle, 0x20 | *toggle));
        *toggle ^= 0x10;
        bytes.extend(&request[1..8 - usize::from(command >> 1 & 7)]);
        if command & 1 == 0 {
            return None;
        }
        let arrived = (*at, std::mem::take(bytes));
        self.0 = State::None;
        Some(arrived)
    }

    fn see_end(&mut self, command: u8, request: &Payload, answer: &Payload) -> Option<(Address, Vec<u8>)> {
        let State::BlockDownload { at, bytes, checked, .. } = &mut self.0 else {
            panic!("an end of nothing")
        };
        assert_eq!(answer[0], 0xA1);
        bytes.truncate(bytes.len() - usize::from(command >> 2 & 7));
        let sum = u16::from_le_bytes([request[1], request[2]]);
        assert!(!*checked || sum == checksum(bytes), "a wrong checksum was accepted");
        let arrived = (*at, std::mem::take(bytes));
        self.0 = State::None;
        Some(arrived)
    }

    fn see_upload(
        &mut self,
        request: &Payload,
        answer: &Payload,
        readable: &dyn Fn(Address) -> Option<Vec<u8>>,
    ) {
        let value = readable(address(request));
        assert_eq!(address(answer), address(request));
        self.0 = State::None;
        if answer[0] & 2 != 0 {
            assert_eq!(answer[0] & 0xF3, 0x43);
            let told = &answer[4..8 - usize::from(answer[0] >> 2 & 3)];
            assert_eq!(Some(told), value.as_deref());
        } else {
            assert_eq!(answer[0], 0x41);
            check_size(&value, answer);
            self.0 = State::Upload { value, bytes: vec![], toggle: 0 };
        }
    }

    fn see_upload_segment(&mut self, command: u8, answer: &Payload) {
        let State::Upload { value, bytes, toggle } = &mut self.0 else { panic!("a segment of nothing") };
        assert_eq!((command & 0x10, answer[0] & 0xF0), (*toggle, *toggle));
        *toggle ^= 0x10;
        bytes.extend(&answer[1..8 - usize::from(answer[0] >> 1 & 7)]);
        if answer[0] & 1 != 0 {
            assert_eq!(Some(&*bytes), value.as_ref());
            self.0 = State::None;
        }
    }

    fn see_block_upload(
        &mut self,
        request: &Payload,
        used: bool,
        answers: &[Payload],
        readable: &dyn Fn(Address) -> Option<Vec<u8>>,
    ) {
        let command = request[0];
        match (command & 3, &mut self.0) {
            (0, _) if answers[0][0] & 0xE0 == 0x40 => self.see_upload(request, &answers[0], readable),
            (0, _) => {
                assert_eq!((answers[0][0], address(&answers[0])), (0xC2 | command & 4, address(request)));
                let value = readable(address(request));
                check_size(&value, &answers[0]);
                self.0 = State::BlockUploadStart { value, checked: command & 4 != 0 };
            }
            (3, State::BlockUploadStart { value, checked }) => {
                let mut segments = vec![];
                take_segments(&mut segments, answers);
                let (value, checked) = (value.take(), *checked);
                self.0 = State::BlockUpload { value, checked, bytes: vec![], segments };
            }
            (2, State::BlockUpload { value, checked, bytes, segments }) => {
                assert!(used, "ignored, but answered");
                let good = &segments[..usize::from(request[1])];
                good.iter().for_each(|segment| bytes.extend(&segment[1..]));
                if good.last().is_some_and(|last| last[0] & 0x80 != 0) {
                    let [end] = answers else { panic!("no end") };
                    assert_eq!(end[0] & 0xE3, 0xC1);
                    bytes.truncate(bytes.len() - usize::from(end[0] >> 2 & 7));
                    assert_eq!(Some(&*bytes), value.as_ref());
                    let sum = u16::from_le_bytes([end[1], end[2]]);
                    assert!(!*checked || sum == checksum(bytes), "a wrong checksum");
                    self.0 = State::BlockUploadEnd;
                } else {
                    segments.clear();
                    take_segments(segments, answers);
                }
            }
            _ => panic!("an answer to {request:02X?}: {answers:02X?}"),
        }
    }

    /// Handles an acknowledgement without a response: the requested segments may still be in transmission.
    fn see_silent_acknowledgement(&mut self, request: &Payload) {
        if let (0xA2, State::BlockUpload { bytes, segments, .. }) = (request[0] & 0xE3, &mut self.0) {
            segments[..usize::from(request[1])].iter().for_each(|segment| bytes.extend(&segment[1..]));
            segments.clear();
        }
    }
}

/// Returns whether a server wrote the bytes that arrived with a request, and nothing else. An expedited download
/// without a size has as many bytes as the object.
pub fn is_written(
    request: &Payload,
    arrived: Option<&(Address, Vec<u8>)>,
    written: Option<&(Address, Vec<u8>)>,
) -> bool {
    match (arrived, written) {
        (Some((at, value)), Some((changed, new))) if request[0] >> 5 == 1 && request[0] & 3 == 2 => {
            at == changed && value.starts_with(new)
        }
        _ => arrived == written,
    }
}

fn check_size(value: &Value, answer: &Payload) {
    let told = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
    assert!(value.as_ref().is_none_or(|value| value.len() == told as usize), "size {told}");
}

fn take_segments(segments: &mut Vec<Payload>, answers: &[Payload]) {
    for answer in answers {
        assert_eq!(usize::from(answer[0] & 0x7F), segments.len() + 1, "a segment out of order");
        segments.push(*answer);
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;

    /// A request and its answers.
    type Exchange<'a> = (&'a str, &'a [&'a str]);

    const AT: Address = Address::new(0x2000, 0);
    const NINE: [u8; 9] = *b"123456789";

    /// Parses bytes from hexadecimal digits; missing ones are zero.
    fn frame(digits: &str) -> Payload {
        let mut payload = [0; 8];
        let bytes = digits.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap());
        payload.iter_mut().zip(bytes).for_each(|(place, byte)| *place = byte);
        payload
    }

    /// Checks exchanges of request and responses. Returns the value of the last completed download.
    fn seen(exchanges: &[Exchange]) -> Option<(Address, Vec<u8>)> {
        let mut transfer = Transfer::default();
        let mut arrived = None;
        for (request, answers) in exchanges {
            let answers: Vec<Payload> = answers.iter().map(|answer| frame(answer)).collect();
            let nine = |at| (at == AT).then(|| NINE.to_vec());
            arrived = transfer.see(&frame(request), true, &answers, &nine).or(arrived);
        }
        arrived
    }

    const SEGMENTED: [Exchange; 3] =
        [("21 00 20 00 09", &["60 00 20 00"]), ("00 31 32 33 34 35 36 37", &["20"]), ("1B 38 39", &["30"])];
    /// The checksum of these nine bytes is that of CiA 301 7.2.4.3.16.
    const BLOCK: [Exchange; 4] = [
        ("C6 00 20 00 09", &["A4 00 20 00 7F"]),
        ("01 31 32 33 34 35 36 37", &[]),
        ("82 38 39", &["A2 02 7F"]),
        ("D5 C3 31", &["A1"]),
    ];
    const UPLOAD: [Exchange; 3] =
        [("40 00 20 00", &["41 00 20 00 09"]), ("60", &["00 31 32 33 34 35 36 37"]), ("70", &["1B 38 39"])];
    const BLOCK_UPLOAD: [Exchange; 3] = [
        ("A4 00 20 00 7F", &["C6 00 20 00 09"]),
        ("A3", &["01 31 32 33 34 35 36 37", "82 38 39"]),
        ("A2 02 7F", &["D5 C3 31"]),
    ];

    #[test]
    fn a_value_arrives_with_the_last_frame_of_its_download() {
        assert_eq!(seen(&[("2B 00 20 00 05 06", &["60 00 20 00"])]), Some((AT, vec![5, 6])));
        for exchanges in [&SEGMENTED[..], &BLOCK] {
            let (_, early) = exchanges.split_last().unwrap();
            assert_eq!(seen(early), None);
            assert_eq!(seen(exchanges), Some((AT, NINE.to_vec())));
        }
        assert_eq!(seen(&UPLOAD).or(seen(&BLOCK_UPLOAD)), None);
    }

    /// Given a transfer up to an exchange, when its response is wrong, then that is detected.
    #[test]
    fn a_wrong_answer_is_found() {
        let cases: [(&str, &[Exchange], &str); 13] = [
            ("another object", &SEGMENTED[..1], "60 01 20 00"),
            ("a toggle bit", &SEGMENTED[..2], "30"),
            ("the toggle bit of the second segment", &SEGMENTED[..3], "20"),
            ("an unknown abort code", &SEGMENTED[..1], "80 00 20 00 01"),
            ("a checksum that nobody offered", &[("C2 00 20 00 09", &[])], "A4 00 20 00 7F"),
            ("a segment that was not sent", &BLOCK[..3], "A2 03 7F"),
            ("the end of a block", &BLOCK[..4], "A2"),
            ("a size", &UPLOAD[..1], "41 00 20 00 08"),
            ("a value", &UPLOAD[..3], "1B 38 38"),
            ("bytes that are none", &UPLOAD[..3], "19 38 39"),
            ("a segment out of order", &BLOCK_UPLOAD[..2], "02 31 32 33 34 35 36 37"),
            ("the checksum of an upload", &BLOCK_UPLOAD[..3], "D5 C3 30"),
            ("an expedited value of nine bytes", &UPLOAD[..1], "43 00 20 00 31 32 33 34"),
        ];
        for (what, exchanges, wrong) in cases {
            let ((request, _), early) = exchanges.split_last().unwrap();
            assert!(catch_unwind(|| seen(early)).is_ok(), "before {what}");
            let answers = [wrong];
            let all: Vec<Exchange> = early.iter().copied().chain([(*request, &answers[..])]).collect();
            assert!(catch_unwind(|| seen(&all)).is_err(), "not found: {what}");
        }
    }

    /// Given a block download whose checksum is wrong. When the server accepts it, then that is detected.
    #[test]
    fn a_wrong_checksum_that_is_accepted_is_found() {
        let end = |request| BLOCK[..3].iter().copied().chain([(request, &["A1"][..])]).collect::<Vec<_>>();
        assert!(catch_unwind(|| seen(&end("D5 C3 31"))).is_ok());
        assert!(catch_unwind(|| seen(&end("D5 C3 30"))).is_err());
    }

    #[test]
    fn frames_that_nobody_asked_for_are_found() {
        let unasked = |frames: &[Payload]| {
            let mut transfer = Transfer::default();
            transfer.see(&frame("C2 00 20 00 09"), true, &[frame("A0 00 20 00 7F")], &|_| None);
            transfer.see(&frame("01 31 32 33 34 35 36 37"), true, &[], &|_| None);
            assert_eq!((transfer.next(), transfer.bytes()), (2, &NINE[..7]));
            transfer.see_unasked(frames);
        };
        assert!(catch_unwind(|| unasked(&[frame("A2 01 7F")])).is_ok());
        assert!(catch_unwind(|| unasked(&[frame("A2 02 7F")])).is_err());
        assert!(catch_unwind(|| Transfer::default().see_unasked(&[frame("A2 00 7F")])).is_err());
    }

    #[test]
    fn what_was_written_is_what_arrived() {
        let some = |bytes: &[u8]| Some((AT, bytes.to_vec()));
        for (request, arrived, written, expected) in [
            ("23", some(&[1, 2, 3, 4]), some(&[1, 2, 3, 4]), true),
            ("23", some(&[1, 2, 3, 4]), some(&[1, 2]), false),
            ("22", some(&[1, 2, 3, 4]), some(&[1, 2]), true),
            ("22", some(&[1, 2, 3, 4]), some(&[2, 1]), false),
            ("22", some(&[1, 2, 3, 4]), None, false),
            ("23", None, some(&[1]), false),
            ("40", None, None, true),
        ] {
            let found = is_written(&frame(request), arrived.as_ref(), written.as_ref());
            assert_eq!(found, expected, "{request}: {arrived:?}, {written:?}");
        }
    }
}
