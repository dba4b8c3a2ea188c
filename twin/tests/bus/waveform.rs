//! Waveforms, compared with bits counted by hand.

use can_twin::wire::bus::WireConfig;
use can_twin::wire::controller::{ErrorKind, WireEvent};
use can_twin::wire::field::Field;
use can_twin::wire::station::Bench;
use can_twin::wire::time::Time;
use can_twin::wire::waveform::{Lane, Waveform};

use crate::common::*;

fn record(bench: &mut Bench, from: u64, to: u64) -> Waveform {
    bench.wire.record_waveform(us(from), us(to));
    bench.leap(us(to));
    bench.wire.take_waveform().unwrap()
}

fn digits(lane: &Lane) -> String {
    lane.bits.iter().map(|bit| if bit.sampled { '1' } else { '0' }).collect()
}

/// SYNC with its intermission, SOF at 20 us: stuff bits at 10 and 16.
#[test]
fn a_frame_bit_by_bit() {
    let waveform = record(&mut sender_and(1), 15, 75);
    assert_eq!((waveform.from, waveform.to), (us(15), us(75)));
    for lane in &waveform.lanes {
        assert_eq!(lane.bits.len(), 51, "SOF to the last bit of EOF: 48; then the intermission");
        assert_eq!(&digits(lane)[..21], "000010000010000010000");
        assert_eq!(&digits(lane)[38..], "1011111111111");
        for (n, bit) in lane.bits.iter().enumerate() {
            assert_eq!((bit.start, bit.end), (us(20 + n as u64), us(21 + n as u64)));
            // SYNC_SEG and segment 1: 12 of 14 quanta.
            assert_eq!(bit.sample, bit.start + Time(24 * 12));
            assert_eq!((bit.resynchronised, bit.flipped), (0, false));
        }
        let fields: Vec<Field> = lane.bits.iter().map(|bit| bit.field).collect();
        assert_eq!(fields[0], Field::Sof);
        assert_eq!(
            fields[9..14],
            [8, 255, 9, 10, 0].map(|n| match n {
                255 => Field::Stuff,
                0 => Field::Rtr,
                n => Field::Identifier(n),
            })
        );
        assert_eq!(fields[14..17], [Field::Ide, Field::Reserved(1), Field::Stuff]);
        assert_eq!(fields[CRC_DELIMITER], Field::CrcDelimiter);
        assert_eq!(
            fields[47..],
            [Field::Eof(6), Field::Intermission(0), Field::Intermission(1), Field::Intermission(2)]
        );
        let stuffed: Vec<usize> = (0..21).filter(|&n| fields[n] == Field::Stuff).collect();
        assert_eq!(stuffed, [10, 16]);
    }
    let [sender, receiver] = &waveform.lanes[..] else { panic!("two nodes") };
    let driven = |lane: &Lane| {
        lane.bits.iter().enumerate().filter(|(_, bit)| !bit.driven).map(|(n, _)| n).collect::<Vec<_>>()
    };
    assert_eq!(driven(receiver), [ACK_SLOT]);
    assert_eq!(receiver.driver, [(us(15), true), (us(59), false), (us(60), true)]);
    assert!(driven(sender).iter().all(|&n| n < CRC_DELIMITER && !sender.bits[n].sampled));
    assert_eq!(sender.driver[..3], [(us(15), true), (us(20), false), (us(24), true)]);
    assert_eq!(receiver.line, sender.line);
    assert_eq!(sender.events, [(us(20), WireEvent::Started), (us(68), WireEvent::Transmitted)]);
    assert_eq!(receiver.events, [(us(67), WireEvent::Received(sync()))]);
}

/// 40 m are 200 ns, 67.2 ticks. The receiver begins with the quantum that holds the edge, 48 ticks late, and its
/// acknowledgement is back 115.2 ticks after the sender's ACK slot began: later than SJW, one quantum of 24 ticks.
#[test]
fn an_acknowledgement_from_afar_makes_the_slot_longer() {
    let sender = sending(SOF, sync());
    let stations = vec![(0.0, sender), (40.0, idle())];
    let waveform = record(&mut Bench::new(WireConfig::default(), stations), 15, 75);
    let [sender, receiver] = &waveform.lanes[..] else { panic!("two nodes") };
    assert_eq!((receiver.position_m, receiver.bits[0].start), (40.0, us(20) + Time(48)));
    assert_eq!(receiver.line[1], (us(20) + Time(67), false));
    let slot = sender.bits[ACK_SLOT];
    assert_eq!((slot.resynchronised, slot.end - slot.start), (24, Time(336 + 24)));
    assert_eq!(sender.bits.iter().filter(|bit| bit.resynchronised != 0).count(), 1);
}

/// The stuff bit at 16 flipped at node 2: its flag is bits 17 to 22. DLC and the first bit of the CRC sequence are 0, so
/// that 22 is a stuff bit: there the sender sees a bit error and node 1 a stuff error, and their flags are 23 to 28,
/// superposition for node 2. Delimiter to 36, intermission to 39, the second attempt at 60 us.
fn erring() -> Bench {
    disturbed(2, [flip_bit(16, &[2])], 0)
}

#[test]
fn an_error_frame_bit_by_bit() {
    let waveform = record(&mut erring(), 15, 62);
    let fields = |lane: &Lane| lane.bits[16..].iter().map(|bit| bit.field).collect::<Vec<_>>();
    let flag = || (0..6).map(Field::ErrorFlag);
    let end = || (1..8).map(Field::Delimiter).chain((0..3).map(Field::Intermission)).chain([Field::Sof]);
    let culprit =
        [Field::Stuff].into_iter().chain(flag()).chain((0..7).map(Field::Superposition)).chain(end());
    assert!(culprit.eq(fields(&waveform.lanes[2]).into_iter().take(25)), "{:?}", fields(&waveform.lanes[2]));
    for lane in &waveform.lanes[..2] {
        let head = [
            Field::Stuff,
            Field::Dlc(0),
            Field::Dlc(1),
            Field::Dlc(2),
            Field::Dlc(3),
            Field::Crc(0),
            Field::Stuff,
        ];
        let all = head.into_iter().chain(flag()).chain([Field::Superposition(0)]).chain(end());
        assert!(all.eq(fields(lane).into_iter().take(25)), "{:?}", fields(lane));
    }
    let flipped: Vec<usize> = (0..41).filter(|&n| waveform.lanes[2].bits[n].flipped).collect();
    assert_eq!(flipped, [16]);
    assert_eq!(waveform.lanes[2].events[0], (end_of(SOF, 16), receive_error(ErrorKind::Stuff)));
    assert_eq!(waveform.lanes[0].events.last(), Some(&(us(60), WireEvent::Started)));
}

/// A span that begins and ends within frames has the same bits as one that contains these frames.
#[test]
fn a_span_cuts_a_longer_one() {
    let whole = record(&mut erring(), 0, 120);
    let part = record(&mut erring(), 38, 85);
    for (whole, part) in whole.lanes.iter().zip(&part.lanes) {
        let within = whole.bits.iter().filter(|bit| bit.end > us(38) && bit.end <= us(85));
        assert!(within.eq(&part.bits));
        assert_eq!(part.line[0], (us(38), whole.line.iter().rfind(|&&(at, _)| at <= us(38)).unwrap().1));
    }
}

#[test]
fn there_is_no_waveform_before_its_end() {
    let mut bench = sender_and(1);
    bench.wire.record_waveform(us(15), us(75));
    bench.leap(us(74));
    assert_eq!(bench.wire.take_waveform(), None);
    bench.wire.record_waveform(us(80), us(90));
    bench.leap(us(200));
    assert_eq!(bench.wire.take_waveform().map(|waveform| waveform.from), Some(us(80)));
    assert_eq!(bench.wire.take_waveform(), None);
}

#[test]
#[should_panic(expected = "no span to come")]
fn the_past_cannot_be_recorded() {
    let mut bench = disturbed(1, [], 50);
    bench.wire.record_waveform(us(49), us(75));
}
