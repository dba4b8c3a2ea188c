//! Error management: RM0090 32.7.6, 32.9.2 (ESR).

use can_wire::controller::{Controller, ErrorKind, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::bxcan::Side;

use crate::bench::*;

const ABOM: u32 = 1 << 6;

fn tec(bench: &Bench) -> u32 {
    bench.read(ESR) >> 16 & 0xFF
}

fn rec(bench: &Bench) -> u32 {
    bench.read(ESR) >> 24
}

fn flags(bench: &Bench) -> u32 {
    bench.read(ESR) & 0b111
}

fn bus_off(mcr: u32) -> Bench {
    let mut bench = Bench::normal_with(mcr, 0);
    (0..32).for_each(|_| bench.transmit_error(ErrorKind::BitDominant));
    assert_eq!(flags(&bench), 0b111);
    bench
}

#[test]
fn lec_names_the_last_error() {
    let codes = [
        (ErrorKind::Stuff, 1),
        (ErrorKind::Form, 2),
        (ErrorKind::Ack, 3),
        (ErrorKind::BitRecessive, 4),
        (ErrorKind::BitDominant, 5),
        (ErrorKind::Crc, 6),
    ];
    let mut bench = Bench::normal();
    for (kind, code) in codes {
        bench.event(WireEvent::ReceiveError(kind));
        assert_eq!(bench.read(ESR) >> 4 & 0b111, code);
    }
    bench.write(ESR, 0xFFFF_FFFF);
    assert_eq!(bench.read(ESR) & 0xFF00_0077, 0x0600_0070, "7 by software, the rest is read-only");
    bench.received(WireFrame::standard(1, &[]));
    assert_eq!(bench.read(ESR) >> 4 & 0b111, 0);
    bench.write(ESR, 0x70);
    bench.transmitted();
    assert_eq!(bench.read(ESR) >> 4 & 0b111, 0);
}

#[test]
fn transmit_errors_count_8_and_successes_1() {
    let mut bench = Bench::normal();
    bench.transmit_error(ErrorKind::BitRecessive);
    assert_eq!(tec(&bench), 8);
    bench.transmitted();
    assert_eq!(tec(&bench), 7);
    (0..20).for_each(|_| bench.transmitted());
    assert_eq!(tec(&bench), 0, "not below zero");
}

#[test]
fn warning_passive_and_bus_off_limits() {
    let mut bench = Bench::normal();
    for (errors, expected) in [(11, 0), (1, 0b001), (3, 0b001), (1, 0b011), (15, 0b011), (1, 0b111)] {
        (0..errors).for_each(|_| bench.transmit_error(ErrorKind::Form));
        assert_eq!(flags(&bench), expected, "TEC {}", tec(&bench));
        assert_eq!(bench.pair.line(Side::Can1).error_passive(), expected & 2 != 0);
    }
    assert_eq!(bench.pair.line(Side::Can1).bit_time(), None, "off the bus");
}

#[test]
fn a_lone_transmitter_stays_error_passive() {
    let mut bench = Bench::normal();
    (0..1000).for_each(|_| bench.transmit_error(ErrorKind::Ack));
    assert_eq!(bench.read(ESR), 0x0080_0033, "TEC 128, LEC 3, EPVF, EWGF, no BOFF");
}

#[test]
fn receive_errors_count_1_and_a_success_leaves_passive() {
    let mut bench = Bench::normal();
    let error = |bench: &mut Bench| bench.event(WireEvent::ReceiveError(ErrorKind::Crc));
    (0..95).for_each(|_| error(&mut bench));
    assert_eq!((rec(&bench), flags(&bench)), (95, 0));
    error(&mut bench);
    assert_eq!((rec(&bench), flags(&bench)), (96, 0b001));
    (0..40).for_each(|_| error(&mut bench));
    assert_eq!((rec(&bench), flags(&bench)), (136, 0b011));
    bench.received(WireFrame::standard(1, &[]));
    assert_eq!((rec(&bench), flags(&bench)), (120, 0b001), "reset to 120 from above 128");
    bench.received(WireFrame::standard(1, &[]));
    assert_eq!(rec(&bench), 119);
    (0..300).for_each(|_| error(&mut bench));
    assert_eq!((rec(&bench), flags(&bench)), (255, 0b011), "reception alone never leads to bus-off");
}

#[test]
fn enabled_conditions_raise_erri_and_the_sce_line() {
    let cases = [(1 << 8, 12), (1 << 9, 16), (1 << 10, 32), (1 << 11, 1)];
    for (enable, errors) in cases {
        let mut bench = Bench::normal();
        bench.write(IER, enable | 1 << 15);
        (1..errors).for_each(|_| bench.transmit_error(ErrorKind::Form));
        assert!(!bench.pair.irq(Side::Can1).sce);
        bench.transmit_error(ErrorKind::Form);
        assert_eq!(bench.read(MSR) & 1 << 2, 1 << 2, "ERRI");
        assert!(bench.pair.irq(Side::Can1).sce);
        bench.write(MSR, 1 << 2);
        assert!(!bench.pair.irq(Side::Can1).sce, "cleared by writing 1, though the condition stays");
    }
}

#[test]
fn erri_needs_its_enables() {
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 15);
    (0..32).for_each(|_| bench.transmit_error(ErrorKind::Form));
    assert_eq!(bench.read(MSR) & 1 << 2, 0, "no single cause enabled");
    let mut bench = Bench::normal();
    bench.write(IER, 1 << 11);
    bench.transmit_error(ErrorKind::Form);
    assert_eq!(bench.read(MSR) & 1 << 2, 1 << 2);
    assert!(!bench.pair.irq(Side::Can1).sce, "ERRIE is off");
}

#[test]
fn abom_recovers_after_128_times_11_recessive_bits() {
    let mut bench = bus_off(ABOM);
    let end = bench.now + Time(128 * 11 * BIT);
    assert_eq!(bench.pair.next_event(), Some(end));
    bench.pair.poll(Time(end.0 - 1));
    assert_eq!(flags(&bench) & 0b100, 0b100);
    bench.pair.poll(end);
    assert_eq!(bench.read(ESR) & 0xFFFF_0007, 0, "error active, counters zero");
    assert!(bench.pair.line(Side::Can1).bit_time().is_some());
}

#[test]
fn without_abom_recovery_waits_for_inrq_set_and_cleared() {
    let mut bench = bus_off(0);
    bench.pass(Time::from_ms(100));
    assert_eq!(flags(&bench), 0b111);
    bench.write(MCR, 1);
    assert_eq!(bench.read(MSR) & 1, 1);
    bench.pass(Time::from_ms(100));
    assert_eq!(flags(&bench), 0b111, "initialisation does not hear the line");
    let cleared = bench.now;
    bench.write(MCR, 0);
    bench.pass(Time(11 * BIT));
    assert_eq!(bench.read(MSR) & 1, 0, "normal mode after 11 bits");
    assert_eq!(bench.pair.next_event(), Some(cleared + Time(128 * 11 * BIT)));
    bench.pass(Time(127 * 11 * BIT));
    assert_eq!(flags(&bench), 0);
}

#[test]
fn a_busy_bus_lengthens_recovery() {
    let mut bench = bus_off(ABOM);
    bench.pair.set_bus_idle_since(Side::Can1, None);
    // Frames back to back leave exactly 11 recessive bits: acknowledge delimiter, end of frame, intermission.
    for n in 1..=128 {
        assert_eq!(flags(&bench) & 0b100, 0b100, "before pause {n}");
        let pause = bench.now + Time(100 * BIT);
        bench.pair.recessive_stretch(Side::Can1, pause, pause + Time(11 * BIT));
        bench.pass(Time(120 * BIT));
    }
    assert_eq!(flags(&bench), 0);
}

#[test]
fn a_pending_frame_survives_bus_off_and_goes_after_recovery() {
    let mut bench = Bench::normal_with(ABOM, 0);
    bench.request(0, 0x100);
    for _ in 0..32 {
        bench.started();
        bench.transmit_error(ErrorKind::BitDominant);
    }
    assert!(bench.contends().is_none());
    bench.pass(Time(128 * 11 * BIT));
    assert_eq!(bench.contends(), Some(WireFrame::standard(0x100, &[])));
}
