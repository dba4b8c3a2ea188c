//! A second opinion of transfers, from the frames of client and server alone (CiA 301 7.2.4.3).

use ecss_can::sdo::Payload;
use ecss_can::types::{AbortCode, Address};

use super::sdo_objects::Objects;

/// Segments of a sub-block.
const SUB_BLOCK: u8 = 127;
/// First byte of an abort.
const ABORT: u8 = 0x80;

/// What is under way.
#[derive(Default)]
pub enum Transfer {
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

/// What is to be uploaded, if that is known.
pub type Value = Option<Vec<u8>>;

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
    /// A request, whether it was of use, and what was answered at once. The value that has been downloaded with it.
    pub fn see(
        &mut self,
        request: &Payload,
        used: bool,
        answers: &[Payload],
        objects: &Objects,
    ) -> Option<(Address, Vec<u8>)> {
        for answer in answers.iter().filter(|answer| answer[0] == ABORT) {
            let code = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
            assert!(AbortCode::from_code(code).is_some(), "abort code {code:08X}");
        }
        let command = request[0];
        if let Transfer::BlockDownload { is_complete: false, .. } = self {
            self.see_sub_block(command, request, answers);
            return None;
        }
        // One that is of no use may be a segment that came again, with a first byte as an abort has it.
        if (used && command >> 5 == 4) || answers.iter().any(|answer| answer[0] == ABORT) {
            *self = Transfer::None;
            return None;
        }
        let Some(answer) = answers.first() else {
            if matches!((command & 0xE3, &*self), (0xA1, Transfer::BlockUploadEnd)) {
                *self = Transfer::None;
            }
            return None;
        };
        match command >> 5 {
            0 => return self.see_segment(command, request, answer),
            1 => {
                assert_eq!(address(answer), address(request));
                assert_eq!(answer[0], 0x60);
                *self = Transfer::None;
                let at = address(request);
                match (command & 2 != 0, command & 1 != 0) {
                    (true, false) => return Some((at, request[4..].to_vec())),
                    (true, true) => {
                        return Some((at, request[4..8 - usize::from(command >> 2 & 3)].to_vec()));
                    }
                    _ => *self = Transfer::Download { at, bytes: vec![], toggle: 0 },
                }
            }
            2 => self.see_upload(request, answer, objects),
            3 => self.see_upload_segment(command, answer),
            5 => self.see_block_upload(request, used, answers, objects),
            _ if command & 1 == 0 => {
                assert_eq!((answer[0], answer[4]), (0xA0 | command & 4, SUB_BLOCK));
                let at = address(request);
                let checked = command & 4 != 0;
                *self = Transfer::BlockDownload { at, bytes: vec![], next: 1, checked, is_complete: false };
            }
            _ => return self.see_end(command, request, answer),
        }
        None
    }

    /// What the server sends without a request.
    pub fn see_unasked(&mut self, answers: &[Payload]) {
        match self {
            _ if answers.is_empty() => {}
            _ if answers.iter().any(|answer| answer[0] == ABORT) => *self = Transfer::None,
            Transfer::BlockDownload { next, is_complete: false, .. } => {
                assert_eq!((answers.len(), answers[0][0], answers[0][1]), (1, 0xA2, *next - 1));
                *next = 1;
            }
            Transfer::BlockUpload { segments, .. } => take_segments(segments, answers),
            _ => panic!("unasked: {answers:02X?}"),
        }
    }

    fn see_sub_block(&mut self, command: u8, request: &Payload, answers: &[Payload]) {
        let Transfer::BlockDownload { bytes, next, is_complete, .. } = self else { return };
        if command == ABORT || answers.iter().any(|answer| answer[0] == ABORT) {
            *self = Transfer::None;
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
        let Transfer::Download { at, bytes, toggle } = self else { panic!("a segment of nothing") };
        assert_eq!((command & 0x10, answer[0]), (*toggle, 0x20 | *toggle));
        *toggle ^= 0x10;
        bytes.extend(&request[1..8 - usize::from(command >> 1 & 7)]);
        if command & 1 == 0 {
            return None;
        }
        let arrived = (*at, std::mem::take(bytes));
        *self = Transfer::None;
        Some(arrived)
    }

    fn see_end(&mut self, command: u8, request: &Payload, answer: &Payload) -> Option<(Address, Vec<u8>)> {
        let Transfer::BlockDownload { at, bytes, checked, .. } = self else { panic!("an end of nothing") };
        assert_eq!(answer[0], 0xA1);
        bytes.truncate(bytes.len() - usize::from(command >> 2 & 7));
        let sum = u16::from_le_bytes([request[1], request[2]]);
        assert!(!*checked || sum == checksum(bytes), "a wrong checksum was accepted");
        let arrived = (*at, std::mem::take(bytes));
        *self = Transfer::None;
        Some(arrived)
    }

    fn see_upload(&mut self, request: &Payload, answer: &Payload, objects: &Objects) {
        let value = objects.readable(address(request)).map(<[u8]>::to_vec);
        assert_eq!(address(answer), address(request));
        *self = Transfer::None;
        if answer[0] & 2 != 0 {
            assert_eq!(answer[0] & 0xF3, 0x43);
            let told = &answer[4..8 - usize::from(answer[0] >> 2 & 3)];
            assert_eq!(Some(told), value.as_deref());
        } else {
            assert_eq!(answer[0], 0x41);
            check_size(&value, answer);
            *self = Transfer::Upload { value, bytes: vec![], toggle: 0 };
        }
    }

    fn see_upload_segment(&mut self, command: u8, answer: &Payload) {
        let Transfer::Upload { value, bytes, toggle } = self else { panic!("a segment of nothing") };
        assert_eq!((command & 0x10, answer[0] & 0xF0), (*toggle, *toggle));
        *toggle ^= 0x10;
        bytes.extend(&answer[1..8 - usize::from(answer[0] >> 1 & 7)]);
        if answer[0] & 1 != 0 {
            assert_eq!(Some(&*bytes), value.as_ref());
            *self = Transfer::None;
        }
    }

    fn see_block_upload(&mut self, request: &Payload, used: bool, answers: &[Payload], objects: &Objects) {
        let command = request[0];
        match (command & 3, &mut *self) {
            (0, _) if answers[0][0] & 0xE0 == 0x40 => self.see_upload(request, &answers[0], objects),
            (0, _) => {
                assert_eq!((answers[0][0], address(&answers[0])), (0xC2 | command & 4, address(request)));
                let value = objects.readable(address(request)).map(<[u8]>::to_vec);
                check_size(&value, &answers[0]);
                *self = Transfer::BlockUploadStart { value, checked: command & 4 != 0 };
            }
            (3, Transfer::BlockUploadStart { value, checked }) => {
                let mut segments = vec![];
                take_segments(&mut segments, answers);
                let (value, checked) = (value.take(), *checked);
                *self = Transfer::BlockUpload { value, checked, bytes: vec![], segments };
            }
            (2, Transfer::BlockUpload { value, checked, bytes, segments }) => {
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
                    *self = Transfer::BlockUploadEnd;
                } else {
                    segments.clear();
                    take_segments(segments, answers);
                }
            }
            _ => panic!("an answer to {request:02X?}: {answers:02X?}"),
        }
    }

    /// An acknowledgement without an answer may be of use as well: what it asks for is in mid-flight still.
    pub fn see_silent_acknowledgement(&mut self, request: &Payload) {
        if let (0xA2, Transfer::BlockUpload { bytes, segments, .. }) = (request[0] & 0xE3, self) {
            segments[..usize::from(request[1])].iter().for_each(|segment| bytes.extend(&segment[1..]));
            segments.clear();
        }
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
