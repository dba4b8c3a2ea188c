//! Error management: RM0090 32.7.6, 32.9.2 (ESR), by real errors on the wire.

use can_twin::wire::fault::{Effect, Fault, Nodes};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::bench::*;

/// Runs until the next error or success. Returns its code.
fn next_lec(bench: &mut Bench) -> u32 {
    bench.write(ESR, 0x70);
    bench.until("an update of LEC", |bench| bench.lec() != 7);
    bench.lec()
}

#[test]
fn a_receiver_names_stuff_form_and_crc_errors() {
    // A stuff bit missed; CRC and ACK delimiter, EOF; a wrong checksum.
    let cases = [
        (Field::Stuff, 1),
        (Field::CrcDelimiter, 2),
        (Field::AckDelimiter, 2),
        (Field::Eof(0), 2),
        (Field::Eof(5), 2),
        (Field::Crc(14), 6),
    ];
    for (field, code) in cases {
        let mut bench = Bench::normal();
        bench.flip(CAN1, field);
        bench.send(WireFrame::standard(0x080, &[0x55, 0xAA, 0]));
        assert_eq!(next_lec(&mut bench), code, "{field:?}");
        assert_eq!(next_lec(&mut bench), 0, "the repetition succeeds");
        assert_eq!(bench.read(RF0R), 1);
    }
}

#[test]
fn a_receiver_names_a_broken_acknowledgement() {
    let mut bench = Bench::with(vec![Default::default()], 0, 0);
    bench.flip(CAN1, Field::AckSlot);
    bench.send(empty());
    assert_eq!(next_lec(&mut bench), 5, "sent dominant, saw recessive");
}

#[test]
fn a_transmitter_names_bit_errors() {
    let cases = [(Field::Dlc(0), 5), (Field::Sof, 5), (Field::CrcDelimiter, 4), (Field::Eof(2), 4)];
    for (field, code) in cases {
        let mut bench = Bench::normal();
        bench.flip(CAN1, field);
        bench.request(0, 0x080);
        assert_eq!(next_lec(&mut bench), code, "{field:?}");
        assert_eq!(bench.tec(), 8);
        assert_eq!(next_lec(&mut bench), 0, "the repetition succeeds");
    }
}

#[test]
fn a_transmitter_names_a_missing_acknowledgement() {
    let mut bench = Bench::with(vec![], 0, 0);
    bench.request(0, 0x080);
    assert_eq!(next_lec(&mut bench), 3);
    assert_eq!(bench.status(0), TERR);
}

#[test]
fn software_sets_lec_to_7_and_nothing_else() {
    let mut bench = Bench::normal();
    bench.write(ESR, 0xFFFF_FFFF);
    assert_eq!(bench.read(ESR), 0x70, "flags and counters are read-only");
    bench.deliver(empty());
    assert_eq!(bench.lec(), 0, "received");
    bench.write(ESR, 0x70);
    bench.transmit(0x100);
    assert_eq!(bench.lec(), 0, "sent");
}

#[test]
fn lec_stays_until_the_next_frame() {
    let mut bench = Bench::normal_with(NART, 0);
    bench.request(0, 0x100);
    bench.fail_attempt();
    bench.pass(Time::from_ms(10));
    assert_eq!(bench.lec(), 5);
}

#[test]
fn transmit_errors_count_8_and_successes_1() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.fail_attempt();
    assert_eq!(bench.tec(), 8);
    bench.complete(0);
    assert_eq!(bench.tec(), 7);
    for expected in [6, 5, 4, 3, 2, 1, 0, 0] {
        bench.transmit(0x100);
        assert_eq!(bench.tec(), expected, "not below zero");
    }
}

#[test]
fn warning_passive_and_bus_off_limits() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    for n in 1..=32 {
        bench.fail_attempt();
        let expected = match 8 * n {
            ..96 => 0,
            96..128 => 0b001,
            128..256 => 0b011,
            _ => 0b111,
        };
        assert_eq!(bench.flags(), expected, "after {n} errors");
        assert_eq!(bench.tec(), 8 * n % 256, "the low byte of a 9-bit counter");
    }
    bench.calm();
    bench.deliver(empty());
    assert_eq!((bench.read(RF0R), bench.status(0) & RQCP), (0, 0), "off the bus, still pending");
}

#[test]
fn flags_go_with_the_counters() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    (0..16).for_each(|_| bench.fail_attempt());
    assert_eq!((bench.tec(), bench.flags()), (128, 0b011));
    bench.complete(0);
    assert_eq!((bench.tec(), bench.flags()), (127, 0b001), "error active again");
    for _ in 0..32 {
        bench.transmit(0x100);
    }
    assert_eq!((bench.tec(), bench.flags()), (95, 0));
}

#[test]
fn a_lone_transmitter_stays_error_passive() {
    let mut bench = Bench::with(vec![], 0, 0);
    bench.request(0, 0x100);
    bench.pass(Time::from_ms(100));
    assert_eq!(bench.read(ESR), 0x0080_0033, "TEC 128, LEC 3, EPVF, EWGF, no BOFF");
}

#[test]
fn an_error_of_its_own_counts_9_for_a_receiver() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::CrcDelimiter);
    bench.send(empty());
    // ISO 11898-1, 12.1.4.2 a and b: 1 for the error, 8 because the others answer its flag.
    bench.until("both", |bench| bench.rec() == 9);
    bench.until("the repetition", |bench| bench.read(RF0R) == 1);
    assert_eq!((bench.rec(), bench.tec()), (8, 0));
}

#[test]
fn a_pulse_on_an_idle_bus_is_a_stuff_error() {
    let mut bench = Bench::normal();
    bench.dominant_pulse(1);
    bench.until("an error", |bench| bench.rec() != 0);
    assert_eq!(bench.lec(), 1, "a start of frame, and six recessive bits");
}

#[test]
fn a_pulse_that_ends_before_the_sample_point_is_nothing() {
    let mut bench = Bench::normal();
    let (nodes, effect) = (Nodes::of(&[CAN1]), Effect::Dominant);
    // The sample point lies 17 of 21 quanta into the bit.
    bench.fault(Fault::Glitch { nodes, duration: Time(14 * 16), effect });
    bench.pass(bits(100));
    assert_eq!(bench.read(ESR), 0);
}

#[test]
fn an_overload_frame_is_no_error() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::Intermission(0));
    let start = bench.now;
    bench.deliver(empty());
    bench.deliver(empty());
    assert_eq!((bench.read(ESR), bench.read(RF0R)), (0, 2));
    // A bit of intermission, two flags one bit apart, a delimiter, and the intermission again.
    assert_eq!(bench.now, start + bits(2 * EMPTY_BITS + 1 + 7 + 8 + 3));
}

#[test]
fn receive_errors_count_1_and_a_success_leaves_passive() {
    let mut bench = Bench::normal();
    (0..95).for_each(|_| bench.fail_reception());
    assert_eq!((bench.rec(), bench.flags()), (95, 0));
    bench.fail_reception();
    assert_eq!((bench.rec(), bench.flags()), (96, 0b001));
    (0..31).for_each(|_| bench.fail_reception());
    assert_eq!((bench.rec(), bench.flags()), (127, 0b001));
    bench.fail_reception();
    assert_eq!((bench.rec(), bench.flags()), (128, 0b011));
    bench.deliver(empty());
    assert_eq!((bench.rec(), bench.flags()), (127, 0b001), "1 less");
    (0..9).for_each(|_| bench.fail_reception());
    assert_eq!((bench.rec(), bench.flags()), (136, 0b011));
    bench.deliver(empty());
    assert_eq!((bench.rec(), bench.flags()), (120, 0b001), "reset to 120 from above 128");
    bench.deliver(empty());
    assert_eq!(bench.rec(), 119);
}

#[test]
fn reception_alone_never_leads_to_bus_off() {
    let mut bench = Bench::normal();
    bench.short(false);
    bench.pass(Time::from_ms(10));
    assert_eq!(bench.read(ESR) & 0xFFFF_0007, 0xFF00_0003, "REC 255, passive");
}

#[test]
fn enabled_conditions_raise_erri_and_the_sce_line() {
    let cases = [(1 << 8, 12), (1 << 9, 16), (1 << 10, 32), (1 << 11, 1)];
    for (enable, errors) in cases {
        let mut bench = Bench::normal();
        bench.write(IER, enable | 1 << 15);
        bench.request(0, 0x100);
        (1..errors).for_each(|_| bench.fail_attempt());
        assert!(!bench.irq().sce);
        bench.fail_attempt();
        assert_eq!(bench.read(MSR) & ERRI, ERRI);
        assert!(bench.irq().sce);
        bench.write(MSR, ERRI);
        assert!(!bench.irq().sce, "cleared by writing 1, though the condition stays");
        assert_ne!(bench.read(ESR) & 0x77, 0);
    }
}

#[test]
fn a_condition_that_stays_raises_erri_once() {
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 8 | 1 << 15);
    bench.request(0, 0x100);
    (0..12).for_each(|_| bench.fail_attempt());
    bench.write(MSR, ERRI);
    (0..3).for_each(|_| bench.fail_attempt());
    assert_eq!(bench.read(MSR) & ERRI, 0);
    bench.write(IER, 1 << 11 | 1 << 15);
    for _ in 0..3 {
        bench.fail_attempt();
        assert_eq!(bench.read(MSR) & ERRI, ERRI, "but LECIE at every error");
        bench.write(MSR, ERRI);
    }
}

#[test]
fn a_success_raises_no_erri() {
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 11 | 1 << 15);
    bench.write(ESR, 0x70);
    bench.deliver(empty());
    assert_eq!((bench.lec(), bench.read(MSR) & ERRI), (0, 0));
}

#[test]
fn erri_needs_its_enables() {
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 15);
    bench.request(0, 0x100);
    (0..32).for_each(|_| bench.fail_attempt());
    assert_eq!(bench.read(MSR) & ERRI, 0, "no single cause enabled");
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 11);
    bench.request(0, 0x100);
    bench.fail_attempt();
    assert_eq!(bench.read(MSR) & ERRI, ERRI);
    assert!(!bench.irq().sce, "ERRIE is off");
}
