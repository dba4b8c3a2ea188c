//! Frames as bits: layout, stuffing, CRC and length against an encoder on paper and by exhaustion.

use std::collections::HashMap;

use can_twin::wire::bus::WireConfig;
use can_twin::wire::encode::encode;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::station::Bench;
use can_twin::wire::time::Time;

use crate::common::*;

/// Returns the frame as text, as calculated by hand: binary strings, CRC by long division, stuffing by looking at the
/// last five characters.
fn on_paper(frame: &WireFrame) -> String {
    let rtr = if frame.remote { "1" } else { "0" };
    let header = match frame.id {
        WireId::Standard(id) => format!("0{id:011b}{rtr}00"),
        WireId::Extended(id) => {
            let id = format!("{id:029b}");
            format!("0{}11{}{rtr}00", &id[..11], &id[11..])
        }
    };
    let mut text = format!("{header}{:04b}", frame.dlc);
    if !frame.remote {
        for byte in frame.data.iter().take(frame.dlc.into()) {
            text += &format!("{byte:08b}");
        }
    }
    text += &divided(&text);
    let mut stuffed = String::new();
    for digit in text.chars() {
        stuffed.push(digit);
        if stuffed.ends_with("00000") {
            stuffed.push('1');
        } else if stuffed.ends_with("11111") {
            stuffed.push('0');
        }
    }
    stuffed + "10" + "1" + "1111111"
}

/// Remainder of a long division by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
fn divided(text: &str) -> String {
    let generator = b"1100010110011001";
    let mut dividend = format!("{text}000000000000000").into_bytes();
    for index in 0..text.len() {
        if dividend[index] == b'1' {
            for (digit, term) in dividend[index..].iter_mut().zip(generator) {
                *digit = if *digit == *term { b'0' } else { b'1' };
            }
        }
    }
    String::from_utf8(dividend.split_off(text.len())).expect("digits")
}

fn as_text(bits: &[bool]) -> String {
    bits.iter().map(|&bit| if bit { '1' } else { '0' }).collect()
}

/// Returns a random frame of any kind. Bytes of equal bits test the stuffing.
fn random(rng: &mut fastrand::Rng) -> WireFrame {
    let id =
        if rng.bool() { WireId::Standard(rng.u16(..0x800)) } else { WireId::Extended(rng.u32(..1 << 29)) };
    let (remote, dlc) = (rng.u8(..8) == 0, rng.u8(..16));
    let mut data: [u8; 8] = core::array::from_fn(|_| match rng.u8(..3) {
        0 => 0x00,
        1 => 0xFF,
        _ => rng.u8(..),
    });
    data[if remote { 0 } else { usize::from(dlc.min(8)) }..].fill(0);
    WireFrame { id, remote, dlc, data }
}

#[test]
fn ten_thousand_random_frames_are_the_same_on_paper() {
    let mut rng = fastrand::Rng::with_seed(1);
    for _ in 0..10_000 {
        let frame = random(&mut rng);
        let (encoded, paper) = (encode(&frame), on_paper(&frame));
        assert_eq!(as_text(encoded.bits()), paper, "{frame:?}");
        assert_eq!(encoded.stuffed_len() + 10, paper.len());
        let changes: Vec<usize> = encoded.changes().collect();
        let expected: Vec<usize> = paper
            .char_indices()
            .filter(|&(index, digit)| {
                digit != index.checked_sub(1).map_or('1', |before| paper.as_bytes()[before] as char)
            })
            .map(|(index, _)| index)
            .collect();
        assert_eq!(changes, expected);
    }
}

/// The catalogue of parametrised CRC algorithms: CRC-15/CAN of "123456789" is 059Eh. It checks the division of this
/// file.
#[test]
fn the_paper_divides_as_the_catalogue_does() {
    let text: String = b"123456789".iter().map(|byte| format!("{byte:08b}")).collect();
    assert_eq!(divided(&text), format!("{:015b}", 0x059E));
}

/// Given every kind of frame, then receivers on both paths receive the frame that was sent.
#[test]
fn every_kind_of_frame_is_read_as_it_was_sent() {
    let mut rng = fastrand::Rng::with_seed(2);
    let sent: Vec<WireFrame> = (0..2000).map(|_| random(&mut rng)).collect();
    let mut sender = idle();
    sender.queue.extend(sent.iter().map(|&frame| (us(SOF), frame)));
    let config = WireConfig { bit_by_bit: true, ..WireConfig::default() };
    let mut bench = Bench::new(config, vec![(0.0, sender), (10.0, idle())]);
    bench.leap(Time::from_ms(400));
    assert_eq!(frames(&bench, 1), sent);
}

/// DLC 9 to 15 travel as they are, with 8 bytes of data; a remote frame has none.
#[test]
fn a_dlc_above_8_means_8_bytes() {
    for dlc in 8..=15 {
        let long = WireFrame { dlc, ..WireFrame::standard(0x123, &[1, 2, 3, 4, 5, 6, 7, 8]) };
        let bits: String = on_paper(&long);
        let eight = on_paper(&WireFrame { dlc: 8, ..long });
        assert!(bits.len().abs_diff(eight.len()) <= 5, "64 data bits either way");
        let mut bench = Bench::together(vec![sending(SOF, long), idle()]);
        bench.leap(us(300));
        assert_eq!(received(&bench, 1), [(us(SOF + bits.len() as u64 - 1), long)]);
        let remote = WireFrame { remote: true, data: [0; 8], ..long };
        let bits = on_paper(&remote).len();
        assert!((44..=53).contains(&bits), "{bits}");
    }
}

/// SYNC, 080h with DLC 0: 51 bits with intermission, 48 from SOF to the end of EOF, 44 of them unstuffed.
#[test]
fn sync_is_51_bits_long() {
    let encoded = encode(&sync());
    assert_eq!(encoded.bits().len() + 3, 51);
    assert_eq!(encoded.stuffed_len(), CRC_DELIMITER);
    assert!(as_text(encoded.bits()).starts_with("000010000010000010000"));
    // A frame that follows at once.
    let mut bench = sender_and(1);
    send(&mut bench, 0, SOF, [sync()]);
    bench.leap(us(200));
    assert_eq!(starts(&bench, 0), [us(SOF), us(SOF + 51)]);
}

/// Standard against extended with the same first 11 bits, data against remote: RTR and IDE arbitrate.
#[test]
fn the_arbitration_field_ends_with_ide_or_the_extended_rtr() {
    let contest = |one: WireFrame, other: WireFrame| {
        let mut bench = Bench::together(vec![sending(SOF, one), sending(SOF, other), idle()]);
        bench.leap(us(400));
        let order: Vec<WireFrame> = bench.stations[2].received().map(|(_, frame)| frame).collect();
        assert_eq!(bench.wire.counters().destroyed, 0);
        order
    };
    let standard = frame(0x123);
    let remote = WireFrame { remote: true, ..standard };
    let extended = WireFrame { id: WireId::Extended(0x123 << 18), ..standard };
    let extended_remote = WireFrame { remote: true, ..extended };
    for (first, second) in
        [(standard, remote), (standard, extended), (remote, extended), (extended, extended_remote)]
    {
        assert_eq!(contest(first, second), [first, second]);
        assert_eq!(contest(second, first), [first, second]);
    }
}

/// Bits of the last five equal, whether the last is recessive, and the CRC register: on which all later stuff bits
/// depend.
type State = (u8, bool, u16);

/// The most bits, interframe space included, of any standard data frame with `bytes` bytes: over all identifiers and
/// data, by the most stuff bits with which each state can be reached. Two frames in the same state have the same
/// continuations, so the one with fewer stuff bits so far never becomes the longer one and is dropped.
fn longest(bytes: usize) -> usize {
    let mut field: Vec<Option<bool>> = vec![Some(false)];
    field.extend([None; 11]);
    field.extend([Some(false); 3]);
    field.extend((0..4).rev().map(|shift| Some(bytes >> shift & 1 == 1)));
    field.extend(std::iter::repeat_n(None, 8 * bytes));
    let mut reached = Table::new();
    reached.raise((0, true, 0), 0);
    for bit in &field {
        let mut next = Table::new();
        for (state, stuffed) in reached.iter() {
            for level in [false, true].into_iter().filter(|&level| bit.is_none_or(|fixed| fixed == level)) {
                let (state, more) = step(state, level, true);
                next.raise(state, stuffed + more);
            }
        }
        reached = next;
    }
    let with_crc = reached.iter().map(|(state, stuffed)| {
        let crc = state.2;
        let bits = (0..15).rev().map(|shift| crc >> shift & 1 == 1);
        bits.fold((state, stuffed), |(state, stuffed), level| {
            let (state, more) = step(state, level, false);
            (state, stuffed + more)
        })
    });
    let most = with_crc.map(|(_, stuffed)| usize::from(stuffed)).max().expect("there are frames");
    // CRC sequence, CRC delimiter, ACK slot and delimiter, EOF, intermission.
    field.len() + most + 15 + 1 + 2 + 7 + 3
}

fn step((run, last, crc): State, level: bool, in_crc: bool) -> (State, u8) {
    let shifted = crc << 1 & 0x7FFF;
    let divides = in_crc && level != (crc >> 14 & 1 == 1);
    let crc = match (in_crc, divides) {
        (false, _) => crc,
        (true, false) => shifted,
        (true, true) => shifted ^ 0b100_0101_1001_1001,
    };
    let run = if level == last { run + 1 } else { 1 };
    if run == 5 { ((1, !level, crc), 1) } else { ((run, level, crc), 0) }
}

/// Most stuff bits by state.
struct Table(Vec<Option<u8>>);

impl Table {
    fn new() -> Self {
        Table(vec![None; 1 << 19])
    }

    fn raise(&mut self, (run, last, crc): State, stuffed: u8) {
        let cell = &mut self.0[usize::from(crc) << 4 | usize::from(run) << 1 | usize::from(last)];
        *cell = (*cell).max(Some(stuffed));
    }

    fn iter(&self) -> impl Iterator<Item = (State, u8)> + '_ {
        self.0.iter().enumerate().filter_map(|(index, cell)| {
            let state = ((index >> 1 & 7) as u8, index & 1 == 1, (index >> 4) as u16);
            cell.map(|stuffed| (state, stuffed))
        })
    }
}

/// The published maxima with interframe space, over all identifiers and data, and the exhaustion itself against brute
/// force where that is possible.
#[test]
fn longest_frames_are_those_published() {
    assert_eq!([0, 1, 2].map(longest), [53, 62, 72]);
    let mut by_length: HashMap<usize, usize> = HashMap::new();
    for id in 0..=0x7FF {
        let mut count = |data: &[u8]| {
            let bits = encode(&WireFrame::standard(id, data)).bits().len() + 3;
            let longest = by_length.entry(data.len()).or_default();
            *longest = bits.max(*longest);
        };
        count(&[]);
        (0..=255).for_each(|byte| count(&[byte]));
    }
    assert_eq!((by_length[&0], by_length[&1]), (53, 62));
}

/// The published bound 55 + 10 s holds for every standard frame there is, and worst-case analyses may build on it.
#[test]
fn no_standard_frame_exceeds_the_published_bound() {
    for bytes in 0..=8 {
        assert!(longest(bytes) <= 55 + 10 * bytes, "{bytes} bytes");
    }
}
