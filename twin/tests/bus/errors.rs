//! Errors by cause, their flags and delimiters, overload frames, and their effect on frames (ISO 11898-1, 10.4 and 12).

use std::collections::BTreeSet;

use can_twin::wire::bus::WireConfig;
use can_twin::wire::controller::ErrorKind;
use can_twin::wire::encode::encode;
use can_twin::wire::fault::Fault;
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::{Destruction, Observation};
use can_twin::wire::station::Bench;

use crate::common::*;

/// Each node reports a wrong bit as the error of its field. A stuff error is the sixth equal bit, a form error a
/// dominant bit in a delimiter or in EOF. A receiver can have a bit error only in the ACK slot and in flags, where it
/// sends dominant.
#[test]
fn a_wrong_bit_is_the_error_of_its_field_and_node() {
    // Of three nodes the first one sends. The fault; a node, the bit that shows it its first error, and the error.
    let mut cases = vec![
        // Bit 4 read dominant: bits 0 to 5 are six dominant bits.
        (flip_bit(4, &[1]), 1, 5, receive_error(ErrorKind::Stuff)),
        // The stuff bit itself.
        (flip_bit(10, &[1]), 1, 10, receive_error(ErrorKind::Stuff)),
        (flip_bit(10, &[0]), 0, 10, transmit_error(ErrorKind::Stuff)),
        (flip_field(Field::CrcDelimiter, &[1]), 1, CRC_DELIMITER, receive_error(ErrorKind::Form)),
        (flip_field(Field::CrcDelimiter, &[0]), 0, CRC_DELIMITER, transmit_error(ErrorKind::BitRecessive)),
        (flip_field(Field::AckDelimiter, &[1]), 1, ACK_DELIMITER, receive_error(ErrorKind::Form)),
        (flip_field(Field::AckSlot, &[0]), 0, ACK_SLOT, transmit_error(ErrorKind::Ack)),
        // The flag of the sender begins in the delimiter.
        (flip_field(Field::AckSlot, &[0]), 1, ACK_DELIMITER, receive_error(ErrorKind::Form)),
        (flip_field(Field::AckSlot, &[1]), 1, ACK_SLOT, receive_error(ErrorKind::BitDominant)),
        (flip_field(Field::AckSlot, &[1]), 0, ACK_DELIMITER, transmit_error(ErrorKind::BitRecessive)),
    ];
    for bit in [0, 1, 5, 11, 17] {
        cases.push((flip_bit(bit, &[0]), 0, bit, transmit_error(ErrorKind::BitDominant)));
    }
    for n in 0..6 {
        let (fault, bit) = (flip_field(Field::Eof(n), &[1]), ACK_DELIMITER + 1 + usize::from(n));
        cases.push((fault, 1, bit, receive_error(ErrorKind::Form)));
        // Its flag destroys the next bit for the others: recessive sent by the transmitter, of fixed form for receivers.
        cases.push((fault, 0, bit + 1, transmit_error(ErrorKind::BitRecessive)));
        if n < 5 {
            cases.push((fault, 2, bit + 1, receive_error(ErrorKind::Form)));
        } else {
            assert_eq!(errors(&disturbed(2, [fault], SOF + 60), 2), [], "the last bit of EOF");
        }
    }
    for (fault, node, bit, event) in cases {
        let first = errors(&disturbed(2, [fault], SOF + 60), node).first().copied();
        assert_eq!(first, Some((end_of(SOF, bit), event)), "{fault:?} at node {node}");
    }
}

/// A dominant bit within the delimiter is a form error, for a transmitter as well (it sends its frame no longer).
#[test]
fn form_error_in_an_error_delimiter() {
    for node in [0, 1] {
        let bench = disturbed(1, [flip_bit(11, &[0]), flip_field(Field::Delimiter(3), &[node])], SOF + 30);
        // Flags up to bit 22; the delimiter begins with bit 23.
        assert_eq!(errors(&bench, node)[1], (end_of(SOF, 26), receive_error(ErrorKind::Form)));
    }
}

#[test]
fn bit_error_of_a_transmitter_in_its_data() {
    // A data bit: 55h begins with a dominant one, the second is recessive. 19 plain bits and 2 stuff bits before it.
    let mut bench = Bench::together(vec![sending(SOF, WireFrame::standard(0x181, &[0x55])), idle()]);
    from_start(&mut bench, [flip_field(Field::Data(1), &[0])]);
    bench.leap(us(SOF + 40));
    assert_eq!(errors(&bench, 0)[0].1, transmit_error(ErrorKind::BitRecessive));
}

/// A wrong bit that keeps the stuffing shows in the CRC; the flag begins after the ACK delimiter, and no acknowledgement
/// is sent.
#[test]
fn crc_error_of_a_receiver_shows_after_the_ack_delimiter() {
    let payload = WireFrame::standard(0x155, &[0x55, 0x55]);
    let slot = encode(&payload).stuffed_len() + 1;
    let told = |receivers: usize| {
        let mut stations = vec![sending(SOF, payload)];
        stations.extend((0..receivers).map(|_| idle()));
        let mut bench = Bench::together(stations);
        from_start(&mut bench, [flip_field(Field::Data(7), &[1])]);
        bench.leap(us(SOF + slot as u64 + 3));
        (errors(&bench, 0), errors(&bench, 1))
    };
    let bit_error = (end_of(SOF, slot + 2), transmit_error(ErrorKind::BitRecessive));
    assert_eq!(told(2), (vec![bit_error], vec![(end_of(SOF, slot + 1), receive_error(ErrorKind::Crc))]));
    // The only receiver: the flag for the missing acknowledgement comes first.
    let unacknowledged = (end_of(SOF, slot), transmit_error(ErrorKind::Ack));
    assert_eq!(
        told(1),
        (vec![unacknowledged], vec![(end_of(SOF, slot + 1), receive_error(ErrorKind::Form))])
    );
}

/// Returns how long the line stays dominant after a local error of node 1 in bit `bit`, in bits from the end of that
/// bit that showed it.
fn superposition(payload: WireFrame, bit: usize) -> Option<u64> {
    let mut bench = Bench::together(vec![sending(SOF, payload), idle(), listener()]);
    from_start(&mut bench, [flip_bit(bit, &[1])]);
    bench.leap(us(SOF + 200));
    let first = (0..3).filter_map(|node| errors(&bench, node).first().map(|&(at, _)| at)).min()?;
    let line = &bench.stations[2].line;
    // The first time that the line is recessive for longer than stuffing allows.
    let end = line.windows(2).find(|pair| pair[0].1 && pair[0].0 > first && pair[1].0 > pair[0].0 + us(6));
    let end = end.map_or(line.last()?.0, |pair| pair[0].0);
    Some(end.since(first).as_us())
}

/// The flag of the first to see an error and those of the others: 6 to 12 bits.
#[test]
fn flags_superpose_to_6_up_to_12_bits() {
    let mut seen = BTreeSet::new();
    for payload in
        [sync(), WireFrame::standard(0x2A5, &[0x0F, 0xAA, 0x31]), WireFrame::standard(0x7F0, &[0xFF; 4])]
    {
        // The last bit of EOF is another matter.
        for bit in 1..encode(&payload).bits().len() - 1 {
            seen.extend(superposition(payload, bit));
        }
    }
    assert!(seen.iter().all(|length| (6..=12).contains(length)), "{seen:?}");
    assert!(seen.contains(&7) && seen.contains(&12), "{seen:?}");
    // All at once: 6 bits, then 8 of delimiter and 3 of intermission.
    let bench = disturbed(2, [flip_field(Field::Eof(2), &[0, 1, 2])], 200);
    assert_eq!(starts(&bench, 0), [us(SOF), us(SOF + 44 + 6 + 8 + 3)]);
    // Bit 10 is a stuff bit, five dominant bits follow: flags 11 to 16 and 17 to 22.
    assert_eq!(superposition(sync(), 10), Some(12));
}

/// A local error becomes global: no node keeps the frame, and the transmitter repeats it.
#[test]
fn the_flag_of_one_receiver_makes_its_error_everybodys() {
    for bit in 0..=ACK_DELIMITER + 5 {
        let bench = disturbed(3, [flip_bit(bit, &[2])], SOF + 200);
        assert_eq!(starts(&bench, 0).len(), 2, "bit {bit}");
        for node in 1..4 {
            assert_eq!(received(&bench, node).len(), 1, "bit {bit}, node {node}");
        }
    }
}

/// Cost of recovery from an error: at most 12 bits of flags, 8 of delimiter and 3 of intermission, after the bit that
/// showed it (23; 31 with suspension).
#[test]
fn a_frame_is_repeated_within_23_bits_of_its_error() {
    for bit in 1..=ACK_DELIMITER + 6 {
        let bench = disturbed(3, [flip_bit(bit, &[2])], SOF + 200);
        let first = (0..4).filter_map(|node| errors(&bench, node).first().map(|&(at, _)| at)).min().unwrap();
        assert!(starts(&bench, 0)[1] <= first + us(23), "bit {bit}");
    }
}

fn two_frames(fault: Fault) -> Bench {
    let mut bench = sender_and(2);
    send(&mut bench, 0, SOF, [frame(0x081)]);
    from_start(&mut bench, [fault]);
    bench.leap(us(SOF + 300));
    bench
}

/// Overload frame, first cause: a dominant bit in the first two of intermission. Flags overlap to 7 bits, then come the
/// delimiter and intermission. No counter moves, and nothing is repeated.
#[test]
fn a_dominant_bit_in_intermission_delays_the_next_frame() {
    for n in [0, 1] {
        let bench = two_frames(flip_field(Field::Intermission(n), &[1]));
        let flag = u64::from(n) + 1;
        // After bit 1 of intermission the flag begins in bit 2, which the others read as a SOF.
        if n == 0 {
            assert_eq!(starts(&bench, 0), [us(SOF), us(SOF + 48 + flag + 7 + 8 + 3)]);
            for node in 0..3 {
                assert_eq!((errors(&bench, node), counts(&bench, node)), (vec![], vec![]));
            }
        }
        assert_eq!(sent(&bench, 0).len(), 2);
        assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (2, 2));
    }
}

/// The third bit of intermission is no overload condition: a dominant bit there is a SOF.
#[test]
fn a_dominant_third_bit_of_intermission_is_a_sof() {
    let bench = two_frames(flip_field(Field::Intermission(2), &[1]));
    // Node 1 takes five of the seven bits 0 000100 000 1 for its own SOF and what follows: it errs, and the frame is
    // repeated.
    assert!(!errors(&bench, 1).is_empty());
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (2, 2));
}

/// Overload frame, second cause: a dominant last bit of a delimiter, here of an error delimiter.
#[test]
fn a_dominant_last_bit_of_a_delimiter_is_an_overload() {
    let bench = disturbed(2, [flip_bit(11, &[0]), flip_field(Field::Delimiter(7), &[1])], 300);
    // Flags to bit 22, delimiter to bit 30; then the overload flag of node 1, which the others see in intermission.
    assert_eq!(starts(&bench, 0), [us(SOF), us(SOF + 31 + 7 + 8 + 3)]);
    assert_eq!(errors(&bench, 1).len(), 1);
    assert_eq!(counts(&bench, 1)[0], (end_of(SOF, 16), 0, 1));
}

/// A receiver answers a dominant last bit of EOF with an overload frame: the frame is valid for it.
#[test]
fn a_dominant_last_bit_of_eof_is_an_overload_for_a_receiver() {
    let bench = two_frames(flip_field(Field::Eof(6), &[1]));
    assert_eq!(starts(&bench, 0), [us(SOF), us(SOF + 48 + 7 + 8 + 3)]);
    for node in [1, 2] {
        assert_eq!(received(&bench, node).len(), 2);
        assert_eq!((errors(&bench, node), rec(&bench, node)), (vec![], 0));
    }
}

/// A frame is valid for receivers with the last but one bit of EOF, for the transmitter with the last: a dominant last
/// bit there doubles it.
#[test]
fn a_dominant_last_bit_of_eof_doubles_the_frame() {
    let mut bench = disturbed(2, [flip_field(Field::Eof(6), &[0])], 300);
    assert_eq!(errors(&bench, 0), [(us(SOF + 48), transmit_error(ErrorKind::BitRecessive))]);
    // Overload flags of the others follow one bit after the error flag: 7 bits.
    let again = SOF + 48 + 7 + 8 + 3;
    let valid = [(us(SOF + 47), sync()), (us(again + 47), sync())];
    for node in [1, 2] {
        assert_eq!(received(&bench, node), valid);
    }
    assert_eq!(sent(&bench, 0), [us(again + 48)]);
    let records = bench.wire.take_records();
    let cause = Destruction::Error(ErrorKind::BitRecessive);
    assert_eq!(destroyed(&records).map(|(cause, _, _, receivers)| (cause, receivers)), Some((cause, 2)));
}

/// Given a dominant last but one bit of EOF at the transmitter only, then the transmission ends there when the frame
/// becomes valid. At a distance of 10 m the frame is valid before the error arrives, after the transmission was
/// recorded.
#[test]
fn receivers_farther_away_receive_a_frame_after_its_end() {
    let places = [(0.0, sending(SOF, sync())), (1.0, idle()), (11.0, idle())];
    let mut bench = Bench::new(WireConfig::default(), places.into());
    from_start(&mut bench, [flip_field(Field::Eof(5), &[0])]);
    bench.leap(us(300));
    assert_eq!(errors(&bench, 0)[0], (us(SOF + 47), transmit_error(ErrorKind::BitRecessive)));
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (2, 2));
    let records = bench.wire.take_records();
    let cause = Destruction::Error(ErrorKind::BitRecessive);
    assert_eq!(destroyed(&records), Some((cause, us(SOF + 47), 0, 0)));
    let late = records.iter().filter_map(|record| match record {
        Observation::ReceivedLate { at, node, frame, transmitter, start } => {
            Some((*node, *at, *frame, *transmitter, *start))
        }
        _ => None,
    });
    let expected = [1, 2].map(|node| (node, received(&bench, node)[0].0, sync(), 0, us(SOF)));
    assert_eq!(late.collect::<Vec<_>>(), expected);
}

/// Given a dominant last but one bit of EOF at one receiver, then it rejects the frame, and the other one accepts it
/// and receives it twice.
#[test]
fn a_dominant_last_but_one_bit_of_eof_makes_receivers_disagree() {
    let bench = disturbed(2, [flip_field(Field::Eof(5), &[1])], 300);
    assert_eq!(errors(&bench, 1)[0], (us(SOF + 47), receive_error(ErrorKind::Form)));
    assert_eq!(errors(&bench, 0), [(us(SOF + 48), transmit_error(ErrorKind::BitRecessive))]);
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (1, 2));
}

/// Given that case and a transmitter that fails before it repeats the frame, or that does not see the flag, then the
/// receivers disagree permanently.
#[test]
fn receivers_disagree_for_good_if_transmitter_does_not_repeat() {
    let mut bench = sender_and(2);
    from_start(&mut bench, [flip_field(Field::Eof(5), &[1])]);
    schedule(&mut bench, SOF + 50, Fault::PowerOff(0));
    bench.leap(us(300));
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (0, 1));

    let bench = disturbed(2, [flip_field(Field::Eof(5), &[1]), flip_field(Field::Eof(6), &[0])], 300);
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (0, 1));
    assert_eq!(sent(&bench, 0), [us(SOF + 48)]);
}

/// A passive flag of a transmitter breaks its own frame: six recessive bits break the stuffing rule for the others.
#[test]
fn a_passive_flag_of_a_transmitter_is_seen_as_a_stuff_error() {
    let mut bench = sender_and(1);
    joins_at(&mut bench, 1, 920);
    // 16 attempts alone make it passive; the 17th, at 940 us, errs at bit 11.
    schedule(&mut bench, 930, flip_bit(11, &[0]));
    bench.leap(us(980));
    assert_eq!(errors(&bench, 0)[16], (end_of(940, 11), transmit_error(ErrorKind::BitDominant)));
    assert_eq!(errors(&bench, 1), [(end_of(940, 17), receive_error(ErrorKind::Stuff))]);
}

/// The known weakness of the Hamming distance: of two wrong bits the first turns a data bit into a stuff bit or the
/// other way round, the second reverts this, and the bits in between are shifted by one. The 6 that the CRC promises
/// counts bits without stuffing; here two are enough.
#[test]
fn two_wrong_bits_may_pass_the_crc() {
    let (payload, first, second) = short_fall().expect("two bits are enough for some frame");
    let mut bench = Bench::together(vec![sending(SOF, payload), idle(), idle()]);
    from_start(&mut bench, [flip_bit(first, &[1]), flip_bit(second, &[1])]);
    bench.leap(us(300));
    let right = received(&bench, 2);
    let wrong = received(&bench, 1);
    assert_eq!(right.iter().map(|got| got.1).collect::<Vec<_>>(), [payload]);
    assert_eq!(wrong.len(), 1);
    assert_ne!(wrong[0].1, payload);
    assert_eq!((errors(&bench, 0), errors(&bench, 1)), (vec![], vec![]));
    let misread = Observation::Misread { at: wrong[0].0, node: 1, frame: wrong[0].1 };
    assert!(bench.wire.take_records().contains(&misread));
}

/// Returns a frame and two bits of it. The shift gives the right one of 2^15 remainders by chance, so a search over
/// some thousand frames finds one.
fn short_fall() -> Option<(WireFrame, usize, usize)> {
    let mut rng = fastrand::Rng::with_seed(7);
    (0..200_000).find_map(|_| {
        let data: [u8; 8] = core::array::from_fn(|_| {
            if rng.bool() { [0x07, 0xE0, 0x83, 0x1F][rng.usize(..4)] } else { rng.u8(..) }
        });
        let payload = WireFrame::standard(rng.u16(..0x800), &data);
        unnoticed_pair(&payload).map(|(first, second)| (payload, first, second))
    })
}

/// Returns two bits of the frame whose inversion keeps length, stuffing and CRC valid, and the first of which shifts
/// the bits after it.
fn unnoticed_pair(payload: &WireFrame) -> Option<(usize, usize)> {
    let encoded = encode(payload);
    let bits = &encoded.bits()[..encoded.stuffed_len()];
    // Beyond the DLC, else the length changes.
    for first in 24..bits.len() - 20 {
        let mut wrong = bits.to_vec();
        wrong[first] = !wrong[first];
        if destuffed(&wrong)
            .is_some_and(|plain| plain.len() == destuffed(bits).map_or(0, |plain| plain.len()))
        {
            continue;
        }
        for second in first + 1..bits.len() {
            wrong[second] = !wrong[second];
            if destuffed(&wrong).is_some_and(|plain| plain.len() == 19 + 64 + 15 && remainder(&plain) == 0) {
                return Some((first, second));
            }
            wrong[second] = !wrong[second];
        }
    }
    None
}

/// Without stuff bits; `None` when a sixth equal bit follows five.
fn destuffed(bits: &[bool]) -> Option<Vec<bool>> {
    let (mut plain, mut run, mut last) = (Vec::with_capacity(bits.len()), 0, true);
    for &bit in bits {
        if run == 5 {
            if bit == last {
                return None;
            }
            (run, last) = (1, bit);
            continue;
        }
        run = if bit == last { run + 1 } else { 1 };
        last = bit;
        plain.push(bit);
    }
    (run < 5).then_some(plain)
}

/// Returns the remainder of the division by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
fn remainder(bits: &[bool]) -> u32 {
    bits.iter().fold(0, |rest, &bit| {
        let shifted = rest << 1 | u32::from(bit);
        if shifted >> 15 & 1 == 1 { shifted ^ 0b1100_0101_1001_1001 } else { shifted }
    })
}
