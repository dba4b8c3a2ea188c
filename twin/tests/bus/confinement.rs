//! Fault confinement, rule by rule (ISO 11898-1, 12.1.4.2): counters, states and the instants at which they change.

use can_twin::wire::controller::{ErrorKind, WireEvent};
use can_twin::wire::fault::{Effect, Fault, Nodes};
use can_twin::wire::field::Field;
use can_twin::wire::station::Bench;
use can_twin::wire::time::Time;

use crate::common::*;

const BIT_DOMINANT: WireEvent = WireEvent::TransmitError(ErrorKind::BitDominant);

/// The transmitter of 080h sees bit 11, a dominant one, recessive. Its flag takes bits 12 to 17. The bits before are
/// 0 0 0 0 0 (1) 0, so the flag breaks the stuffing rule for the others at bit 16; their flags end with bit 22.
fn transmitter_errs() -> Fault {
    flip_bit(11, &[0])
}

/// Node 1 sees bit 4, the only recessive one so far, dominant, and bit 5 as the sixth dominant bit in a row. Its flag
/// takes bits 6 to 11; the stuff bit 10 is the sixth dominant one for the others, whose flags take bits 11 to 16.
fn receiver_errs() -> Fault {
    flip_bit(4, &[1])
}

/// Rule a: +1 for a receiver that sees an error.
#[test]
fn a_receiver_that_sees_an_error_counts_one() {
    let bench = disturbed(2, [transmitter_errs()], 50);
    for node in [1, 2] {
        assert_eq!(errors(&bench, node), [(end_of(SOF, 16), receive_error(ErrorKind::Stuff))]);
        assert_eq!(counts(&bench, node), [(end_of(SOF, 16), 0, 1)]);
    }
}

/// Rule a, its exception: a bit error within the own flag counts by rule e instead, 8 and not 9.
#[test]
fn a_bit_error_in_the_own_flag_does_not_count_one_more() {
    let bench = disturbed(2, [transmitter_errs(), flip_field(Field::ErrorFlag(2), &[1])], 50);
    assert_eq!(counts(&bench, 1), [(end_of(SOF, 16), 0, 1), (end_of(SOF, 19), 0, 9)]);
    // The flag that node 1 sends instead ends with bit 25: rule b for node 2.
    assert_eq!(counts(&bench, 2), [(end_of(SOF, 16), 0, 1), (end_of(SOF, 23), 0, 9)]);
}

/// Rule b: +8 for a receiver whose first bit after the error flag is dominant: it was the first to see the error.
#[test]
fn the_receiver_that_erred_first_counts_eight_more() {
    let bench = disturbed(2, [receiver_errs()], 50);
    assert_eq!(counts(&bench, 1), [(end_of(SOF, 5), 0, 1), (end_of(SOF, 12), 0, 9)]);
    assert_eq!(counts(&bench, 2), [(end_of(SOF, 10), 0, 1)]);
}

/// Rule c: +8 for a transmitter that sends an error flag.
#[test]
fn a_transmitter_with_an_error_counts_eight() {
    let bench = disturbed(2, [transmitter_errs()], 50);
    assert_eq!(errors(&bench, 0), [(end_of(SOF, 11), BIT_DOMINANT)]);
    assert_eq!(counts(&bench, 0), [(end_of(SOF, 11), 8, 0)], "five dominant bits after its flag are free");
}

/// Rule c, exception 1, also "start-up alone": a transmitter without acknowledgements becomes error passive, and stays
/// there. Error active it tries every 57 bits (40 to the ACK slot, flag 6, delimiter 8, intermission 3), error passive
/// every 65.
#[test]
fn a_lone_transmitter_never_goes_bus_off() {
    let bench = disturbed(0, [], 100_000);
    let tries: Vec<Time> = starts(&bench, 0);
    let expected = |n: u64| if n < 16 { us(SOF + 57 * n) } else { us(SOF + 57 * 16 + 8 + 65 * (n - 16)) };
    assert!(tries.len() > 1500);
    assert!(tries.iter().zip(0..).all(|(&at, n)| at == expected(n)), "{:?}", &tries[..20]);
    let steps: Vec<(Time, u16, u16)> =
        (0..16).map(|n| (end_of(SOF + 57 * u64::from(n), ACK_SLOT), 8 * (n + 1), 0)).collect();
    assert_eq!(counts(&bench, 0), steps);
    assert_eq!(errors(&bench, 0).len() as u64, bench.wire.counters().ack_errors);
}

/// Rule c, exception 1, only while the passive flag stays recessive on the line.
#[test]
fn dominant_bit_in_passive_flag_makes_missing_ack_count() {
    let mut bench = sender_and(0);
    // The 17th try has its SOF at 940 us and its ACK slot up to 980 us.
    schedule(&mut bench, 970, flip_field(Field::ErrorFlag(3), &[0]));
    bench.leap(us(1100));
    assert_eq!(counts(&bench, 0)[15..], [(us(915), 128, 0), (us(984), 136, 0)]);
    // Three recessive bits, the dominant one, six recessive bits: the flag ends 10 bits after the ACK slot.
    assert_eq!(starts(&bench, 0)[17], us(980 + 10 + 8 + 3 + 8));
}

/// Rule c, exception 2: a recessive stuff bit that is overwritten during arbitration counts nothing.
#[test]
fn an_overwritten_stuff_bit_in_the_arbitration_is_free() {
    let bench = disturbed(2, [receiver_errs()], 50);
    assert_eq!(errors(&bench, 0), [(end_of(SOF, 10), transmit_error(ErrorKind::Stuff))]);
    assert_eq!(counts(&bench, 0), []);
    // The same after the arbitration: the stuff bit at 16 lies before the DLC.
    let bench = disturbed(2, [flip_bit(16, &[0])], 50);
    assert_eq!(errors(&bench, 0), [(end_of(SOF, 16), transmit_error(ErrorKind::BitRecessive))]);
    assert_eq!(counts(&bench, 0), [(end_of(SOF, 16), 8, 0)]);
}

/// Rule d: +8 for a transmitter with a bit error in its active error flag.
#[test]
fn transmitter_with_bit_error_in_its_error_flag_counts_eight() {
    let bench = disturbed(2, [transmitter_errs(), flip_field(Field::ErrorFlag(3), &[0])], 50);
    assert_eq!(counts(&bench, 0), [(end_of(SOF, 11), 8, 0), (end_of(SOF, 15), 16, 0)]);
    assert_eq!(errors(&bench, 0)[1], (end_of(SOF, 15), receive_error(ErrorKind::BitDominant)));
}

/// Rule d, overload flag. Intermission begins with bit 48.
#[test]
fn transmitter_with_bit_error_in_its_overload_flag_counts_eight() {
    let faults = [flip_field(Field::Intermission(0), &[0]), flip_field(Field::OverloadFlag(1), &[0])];
    let bench = disturbed(2, faults, 100);
    assert_eq!(counts(&bench, 0), [(end_of(SOF, 50), 8, 0)]);
}

/// Rule e: +8 for a receiver with a bit error in its active error flag, or in its overload flag.
#[test]
fn a_receiver_with_a_bit_error_in_its_flag_counts_eight() {
    let faults = [flip_field(Field::Intermission(0), &[1]), flip_field(Field::OverloadFlag(1), &[1])];
    let bench = disturbed(2, faults, 100);
    assert_eq!(errors(&bench, 1), [(end_of(SOF, 50), receive_error(ErrorKind::BitDominant))]);
    assert_eq!(counts(&bench, 1), [(end_of(SOF, 50), 0, 8)]);

    let bench = disturbed(2, [transmitter_errs(), flip_field(Field::ErrorFlag(5), &[2])], 50);
    assert_eq!(counts(&bench, 2), [(end_of(SOF, 16), 0, 1), (end_of(SOF, 22), 0, 9)]);
}

/// Counters of transmitter and receiver after a line held dominant from bit 12 on. Everybody sees the error in the
/// stuff bit 16; the flags end with bit 22.
fn held_dominant(bits: u64) -> ((u16, u16), (u16, u16)) {
    let mut bench = sender_and(1);
    hold_dominant(&mut bench, SOF + 12, bits);
    bench.leap(us(SOF + 12 + bits));
    ((tec(&bench, 0), rec(&bench, 0)), (tec(&bench, 1), rec(&bench, 1)))
}

/// Rule f: up to seven dominant bits after a flag are tolerated (but see rule b); the 14th in a row counts 8, and so
/// does every eighth after it.
#[test]
fn dominant_line_after_active_flag_counts_eight_repeatedly() {
    let up_to_bit = |bit: u64| held_dominant(bit - 11);
    assert_eq!(up_to_bit(22), ((8, 0), (0, 1)));
    assert_eq!(up_to_bit(23), ((8, 0), (0, 9)), "rule b");
    assert_eq!(up_to_bit(29), ((8, 0), (0, 9)));
    assert_eq!(up_to_bit(30), ((16, 0), (0, 17)), "14 dominant bits from 17 on");
    assert_eq!(up_to_bit(37), ((16, 0), (0, 17)));
    assert_eq!(up_to_bit(38), ((24, 0), (0, 25)));
    assert_eq!(up_to_bit(46), ((32, 0), (0, 33)));
}

/// Rule f after a passive flag: the eighth dominant bit. The 17th try of a lone node is its first passive flag, from
/// 980 to 986 us.
#[test]
fn dominant_line_after_passive_flag_counts_from_eighth_bit() {
    for (bits, count) in [(7, 128), (8, 136), (15, 136), (16, 144)] {
        let mut bench = sender_and(0);
        hold_dominant(&mut bench, 986, bits);
        bench.leap(us(986 + bits));
        assert_eq!(tec(&bench, 0), count, "{bits} bits");
    }
}

/// Rule f after an overload flag: 14 dominant bits in a row count, and rule b does not apply.
#[test]
fn dominant_line_after_overload_flag_counts_from_fourteenth_bit() {
    for (bits, count) in [(1 + 13, 0), (1 + 14, 8), (1 + 22, 16)] {
        let mut bench = sender_and(1);
        // The first bit of intermission, then six of the flag.
        hold_dominant(&mut bench, SOF + 48, bits);
        bench.leap(us(SOF + 48 + bits));
        assert_eq!((tec(&bench, 0), rec(&bench, 1)), (count, count), "{bits} bits");
    }
}

/// Rule g: -1 for every frame sent well, never below 0.
#[test]
fn a_frame_sent_well_takes_one_off() {
    let mut bench = sender_and(1);
    from_start(&mut bench, [transmitter_errs()]);
    send(&mut bench, 0, SOF, [sync(); 9]);
    bench.leap(Time::from_ms(2));
    assert_eq!(sent(&bench, 0).len(), 10);
    let steps: Vec<u16> = counts(&bench, 0).into_iter().map(|(_, transmit, _)| transmit).collect();
    assert_eq!(steps, [8, 7, 6, 5, 4, 3, 2, 1, 0]);
}

/// Rule h: -1 for every frame received well, never below 0.
#[test]
fn a_frame_received_well_takes_one_off() {
    let mut bench = sender_and(1);
    from_start(&mut bench, [transmitter_errs()]);
    send(&mut bench, 0, SOF, [sync()]);
    bench.leap(us(300));
    // Flags to bit 22, delimiter 8, intermission 3: the second SOF is 34 bits after the first.
    let valid = end_of(SOF + 34, 46);
    assert_eq!(counts(&bench, 1), [(end_of(SOF, 16), 0, 1), (valid, 0, 0)]);
    assert_eq!(received(&bench, 1).len(), 2);
}

/// Node 1 errs alone in the first 15 attempts: 1 by rule a and 8 by rule b each time, which makes it error passive.
fn passive_receiver(more: usize) -> Bench {
    let mut bench = sender_and(2);
    from_start(&mut bench, (0..15 + more).map(|_| flip_bit(4, &[1])));
    bench
}

/// Rule h for an error passive receiver: REC lands between 119 and 127, and the node is error active again (rule k).
#[test]
fn a_good_frame_brings_a_passive_receiver_back_to_119_to_127() {
    let mut bench = passive_receiver(0);
    bench.leap(Time::from_ms(3));
    let steps: Vec<u16> = counts(&bench, 1).into_iter().map(|(.., receive)| receive).collect();
    let (last, before) = steps.split_last().unwrap();
    let expected: Vec<u16> = (0..15).flat_map(|n| [9 * n + 1, 9 * n + 9]).collect();
    assert_eq!(before, expected);
    assert!((119..=127).contains(last), "{last}");
    assert_eq!(received(&bench, 1).len(), 1);
}

/// Rule i: from 128 on a node is error passive, here by REC: its error flag is recessive, and the frame continues.
#[test]
fn an_error_passive_receiver_disturbs_nobody() {
    let mut bench = passive_receiver(1);
    bench.leap(Time::from_ms(3));
    assert_eq!(received(&bench, 2).len(), 1, "its 16th error harms nobody");
    assert_eq!(received(&bench, 1), []);
    assert_eq!(errors(&bench, 2).len(), 15);
    assert_eq!(starts(&bench, 0).len(), 16);
    // Rule a for the 16th, and rule b: the first bit after six equal ones of its flag is not known to be dominant.
    assert!(rec(&bench, 1) >= 136);
}

/// Rule i: the error that makes a node error passive still shows with an active flag. 16th and 17th try alone.
#[test]
fn the_flag_of_the_error_that_makes_passive_is_active() {
    let mut bench = sender_and(0);
    bench.stations[0].watches_line = true;
    bench.leap(us(1000));
    let line = &bench.stations[0].line;
    assert!(line.contains(&(us(915), false)) && line.contains(&(us(921), true)), "{line:?}");
    assert!(line.iter().all(|&(at, _)| !(us(980)..us(1000)).contains(&at)), "{line:?}");
}

/// 32 bit errors in a row at a transmitter with receivers, and when each attempt has its SOF. An attempt and its error
/// frame take 34 bits. Error passive (after the 16th): 8 bits of suspension more, and the others see the error one bit
/// later, at the sixth recessive bit from 12 on.
fn to_bus_off(receivers: usize) -> (Bench, u64) {
    let mut bench = sender_and(receivers);
    from_start(&mut bench, (0..32).map(|_| flip_bit(11, &[0])));
    let last = SOF + 34 * 15 + 42 + 43 * 15;
    (bench, last)
}

/// Rule j: above 255 a transmitter is bus-off; it sends no flag for its last error.
#[test]
fn the_32nd_error_of_a_transmitter_is_bus_off() {
    let (mut bench, last) = to_bus_off(2);
    bench.stations[1].watches_line = true;
    bench.leap(us(last + 30));
    assert_eq!(starts(&bench, 0).last(), Some(&us(last)));
    let steps: Vec<u16> = counts(&bench, 0).into_iter().map(|(_, transmit, _)| transmit).collect();
    assert_eq!(steps, (1..=32).map(|n| 8 * n).collect::<Vec<u16>>());
    assert_eq!(counts(&bench, 0).last(), Some(&(end_of(last, 11), 256, 0)));
    // Bits 12 to 17 are recessive, bits 18 to 23 the flags of the others.
    let line = &bench.stations[1].line;
    assert_eq!(
        line[line.len() - 3..],
        [(us(last + 12), true), (us(last + 18), false), (us(last + 24), true)]
    );
}

/// Rule k: error active again as soon as both counters are 127 or less.
#[test]
fn a_transmitter_at_127_is_error_active_again() {
    let mut bench = sender_and(1);
    joins_at(&mut bench, 1, 915);
    send(&mut bench, 0, SOF, [sync(); 2]);
    bench.stations[0].watches_line = true;
    // The 17th attempt, the first acknowledged one, at 940 us. The next one has an error at bit 11.
    schedule(&mut bench, 989, flip_bit(11, &[0]));
    bench.leap(us(1012));
    assert_eq!(counts(&bench, 0)[15..], [(us(915), 128, 0), (us(988), 127, 0), (us(1003), 135, 0)]);
    // No suspension: 51 bits after the one before. And the flag is active, at bits 12 to 17.
    assert_eq!(starts(&bench, 0)[16..], [us(940), us(991)]);
    assert_eq!(bench.stations[0].line.last(), Some(&(us(991 + 11), false)), "dominant from bit 11 on");
}

/// Rule l: bus-off ends after 128 times 11 recessive bits, with both counters zero. The flags of the others end with
/// bit 23 of the last attempt.
#[test]
fn bus_off_ends_after_128_times_11_recessive_bits() {
    let (mut bench, last) = to_bus_off(2);
    bench.leap(Time::from_ms(4));
    let back = us(last + 24 + 128 * 11);
    assert_eq!(counts(&bench, 0)[32], (back, 0, 0));
    assert_eq!(starts(&bench, 0)[32], back, "what waited goes out at once");
    assert_eq!(sent(&bench, 0), [back + us(48)]);
}

/// Rule l on a full bus: each frame has 11 recessive bits in a row once, at its end (ACK delimiter, EOF, intermission).
#[test]
fn on_a_full_bus_the_way_back_takes_128_frames() {
    let (mut bench, last) = to_bus_off(2);
    send(&mut bench, 1, last + 1, [frame(0x081); 200]);
    bench.leap(Time::from_ms(12));
    let back = counts(&bench, 0)[32].0;
    // The error frame of the others gives the first sequence.
    let before = sent(&bench, 1).iter().filter(|&&at| at < back).count();
    assert_eq!(before, 127);
    assert_eq!(back, sent(&bench, 1)[126] + us(3));
}

/// Rule l: a dominant bit begins the sequence anew, and those seen before still count.
#[test]
fn a_dominant_bit_costs_a_bus_off_node_one_sequence_at_most() {
    let (mut bench, last) = to_bus_off(1);
    let line_free = last + 24;
    schedule(&mut bench, line_free + 100 * 11 + 4, glitch_at(0));
    bench.leap(Time::from_ms(4));
    // Four bits of the 101st sequence are lost, and the dominant one.
    assert_eq!(counts(&bench, 0)[32], (us(line_free + 128 * 11 + 5), 0, 0));
}

fn glitch_at(node: usize) -> Fault {
    Fault::Glitch { nodes: Nodes::of(&[node]), duration: us(1), effect: Effect::Dominant }
}

/// A node without automatic recovery stays bus-off until recovery is requested.
#[test]
fn bus_off_without_permission_to_recover_is_for_ever() {
    let (mut bench, last) = to_bus_off(1);
    bench.stations[0].attachment.as_mut().unwrap().recovers = false;
    bench.leap(Time::from_ms(20));
    assert_eq!(tec(&bench, 0), 256);
    assert_eq!(starts(&bench, 0).last(), Some(&us(last)));
    bench.stations[0].attachment.as_mut().unwrap().recovers = true;
    bench.leap(Time::from_ms(30));
    assert_eq!(counts(&bench, 0)[32], (Time::from_ms(20) + us(128 * 11), 0, 0));
    assert_eq!(sent(&bench, 0).len(), 1);
}

/// Error passive, it waits for 8 bits more than others before its next frame, which lets them pass.
#[test]
fn an_error_passive_transmitter_suspends_transmission() {
    let mut bench = sender_and(1);
    joins_at(&mut bench, 1, 850);
    // REC keeps node 0 passive after its success.
    let low = frame(0x700);
    send(&mut bench, 0, SOF, [sync()]);
    send(&mut bench, 1, 960, [low]);
    from_start(&mut bench, [flip_bit(11, &[0])]);
    bench.leap(Time::from_ms(3));
    // Alone it errs at bit 11 once (6 + 8 + 3 bits after it: 29 bits), and 15 times at the ACK slot.
    let passive_at = SOF + 29 + 57 * 14 + 40;
    assert_eq!(counts(&bench, 0)[15], (us(passive_at), 128, 0));
    let next = passive_at + 6 + 8 + 3 + 8;
    assert_eq!(starts(&bench, 0)[16], us(next));
}
