//! Bits and edges against an independent encoder and published lengths.

use can_wire::encode::encode;
use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use proptest::prelude::*;

/// The frame as text, the way one writes it on paper: binary strings, CRC by long division, stuffing by looking at the
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
    // x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
    let generator = b"1100010110011001";
    let mut dividend: Vec<u8> = format!("{text}000000000000000").into_bytes();
    for index in 0..text.len() {
        if dividend[index] == b'1' {
            for (digit, term) in dividend[index..].iter_mut().zip(generator) {
                *digit = if *digit == *term { b'0' } else { b'1' };
            }
        }
    }
    text += std::str::from_utf8(&dividend[text.len()..]).expect("digits");
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

fn as_text(bits: &[bool]) -> String {
    bits.iter().map(|&bit| if bit { '1' } else { '0' }).collect()
}

fn any_frame() -> impl Strategy<Value = WireFrame> {
    let id = prop_oneof![
        (0u16..=0x7FF).prop_map(WireId::Standard),
        (0u32..=0x1FFF_FFFF).prop_map(WireId::Extended)
    ];
    // Bytes of equal bits are what stuffing is about.
    let byte = prop_oneof![Just(0x00), Just(0xFF), any::<u8>()];
    (id, any::<bool>(), 0u8..=15, proptest::array::uniform8(byte)).prop_map(|(id, remote, dlc, mut data)| {
        let used = if remote { 0 } else { usize::from(dlc.min(8)) };
        data[used..].fill(0);
        WireFrame { id, remote, dlc, data }
    })
}

proptest! {
    #[test]
    fn same_bits_as_on_paper(frame in any_frame()) {
        let encoded = encode(&frame);
        let paper = on_paper(&frame);
        prop_assert_eq!(as_text(encoded.bits()), paper.clone());
        prop_assert_eq!(encoded.stuffed_len() + 10, paper.len());
    }

    /// The published bound for standard frames with interframe space is 55 + 10 s bits.
    #[test]
    fn no_standard_frame_exceeds_the_published_bound(id in 0u16..=0x7FF, data in proptest::collection::vec(any::<u8>(), 0..=8)) {
        let frame = WireFrame::standard(id, &data);
        prop_assert!(encode(&frame).bits().len() + 3 <= 55 + 10 * data.len());
    }

    #[test]
    fn edges_alternate_and_stand_at_bit_boundaries(frame in any_frame(), start in 0u64..1_000_000, bit in 300u64..4000) {
        let encoded = encode(&frame);
        let trace = encoded.trace(frame, 3, Time(start), Time(bit));
        prop_assert_eq!(trace.edges[0], (Time(start), false));
        prop_assert_eq!(trace.end, Time(start + bit * on_paper(&frame).len() as u64));
        // Sampled in the middle of each bit, the edges give the bits back.
        let paper: Vec<bool> = on_paper(&frame).chars().map(|digit| digit == '1').collect();
        for (index, &bit_level) in paper.iter().enumerate() {
            let middle = Time(start + bit * index as u64 + bit / 2);
            let level = trace.edges.iter().rev().find(|&&(at, _)| at <= middle).map(|&(_, level)| level);
            prop_assert_eq!(level, Some(bit_level));
        }
        prop_assert!(trace.edges.windows(2).all(|pair| pair[0].1 != pair[1].1 && pair[0].0 < pair[1].0));
        let delayed: Vec<(Time, bool)> = trace.edges_after(Time(17)).collect();
        prop_assert_eq!(delayed.len(), trace.edges.len());
        prop_assert!(delayed.iter().zip(&trace.edges).all(|(late, edge)| late.0.0 == edge.0.0 + 17 && late.1 == edge.1));
    }
}

/// SYNC, 080h with DLC 0: 51 bits with intermission, so 48 from SOF to the end of EOF, 44 of them unstuffed.
#[test]
fn sync_is_51_bits_long() {
    let encoded = encode(&WireFrame::standard(0x080, &[]));
    assert_eq!(encoded.bits().len() + 3, 51);
    assert_eq!(encoded.stuffed_len(), 38);
    let trace = encoded.trace(WireFrame::standard(0x080, &[]), 0, Time::from_us(100), Time(336));
    assert_eq!(trace.end, Time::from_us(148));
}

/// 0 0001(stuffed zeros) on paper: SOF 0, ID 000 1000 0000, RTR IDE r0 0, DLC 0000. Zeros run 4, then 1, then 14
/// zeros up to DLC: a stuff bit after each five. DLC bit 3 begins 17 bits after SOF, with a falling edge.
#[test]
fn sync_has_the_falling_edge_of_dlc_17_bits_after_sof() {
    let encoded = encode(&WireFrame::standard(0x080, &[]));
    assert!(as_text(encoded.bits()).starts_with("00001000001000001000"));
    let edges = encoded.edges(Time::ZERO, Time(336));
    assert!(edges.contains(&(Time::from_us(17), false)), "{edges:?}");
}

/// True maxima with interframe space, found by exhaustion elsewhere: 53 bits for no data, 62 for one byte.
#[test]
fn longest_frames_are_those_published() {
    let all = || 0..=0x7FFu16;
    let longest = |data: &[u8]| all().map(|id| encode(&WireFrame::standard(id, data)).bits().len() + 3).max();
    assert_eq!(longest(&[]), Some(53));
    assert_eq!((0..=255).filter_map(|byte| longest(&[byte])).max(), Some(62));
}
