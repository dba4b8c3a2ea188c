//! Modes, bit timing and access rules: RM0090 32.4, 32.5, 32.7.7, 32.9.1, 32.9.2.

use can_wire::controller::Controller;
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::bxcan::{BadAccess, BxcanPair, PclkTick, Side};

use crate::bench::*;

const CAN2: u32 = 0x400;

#[test]
fn registers_hold_their_reset_values() {
    let bench = Bench::asleep();
    for base in [0, CAN2] {
        assert_eq!(bench.read(base + MCR), 0x0001_0002);
        assert_eq!(bench.read(base + MSR), 0x0000_0C02);
        assert_eq!(bench.read(base + TSR), 0x1C00_0000);
        assert_eq!(bench.read(base + BTR), 0x0123_0000);
        for zero in [RF0R, RF1R, IER, ESR] {
            assert_eq!(bench.read(base + zero), 0);
        }
    }
    assert_eq!(bench.read(FMR), 0x2A1C_0E01);
    for zero in [FM1R, FS1R, FFA1R, FA1R] {
        assert_eq!(bench.read(zero), 0);
    }
}

#[test]
fn reserved_and_unaligned_offsets_are_refused() {
    let mut pair = BxcanPair::new(pclk());
    // The filters exist behind CAN1 alone.
    for offset in [0x020, 0x17C, 0x1D0, 0x208, 0x320, 0x7FC, CAN2 + FMR, CAN2 + BANKS, 0x800, 0x002] {
        assert_eq!(pair.read(offset), Err(BadAccess { offset }), "{offset:X}h");
        assert_eq!(pair.write(offset, 0, Time::ZERO), Err(BadAccess { offset }), "{offset:X}h");
    }
}

#[test]
fn initialisation_from_sleep_needs_sleep_cleared() {
    let mut bench = Bench::asleep();
    bench.write(MCR, 0b11);
    assert_eq!(bench.read(MSR) & 0b11, 0b10, "asleep while SLEEP is set");
    bench.write(MCR, 0b01);
    assert_eq!(bench.read(MSR) & 0b11, 0b01, "INAK set, SLAK cleared");
    bench.write(MCR, 0b10);
    assert_eq!(bench.read(MSR) & 0b11, 0b10, "back to sleep at once");
}

#[test]
fn leaving_initialisation_takes_eleven_recessive_bits() {
    let mut bench = Bench::initialising(0);
    bench.now = Time::from_us(100);
    bench.write(MCR, 0);
    let synchronised = Time(100 * 336 + 11 * BIT);
    assert_eq!(bench.pair.next_event(), Some(synchronised));
    bench.pair.poll(Time(synchronised.0 - 1));
    assert_eq!(bench.read(MSR) & 0b11, 0b01);
    assert_eq!(bench.pair.line(Side::Can1).bit_time(), None, "not on the bus yet");
    bench.pair.poll(synchronised);
    assert_eq!(bench.read(MSR) & 0b11, 0);
    assert_eq!(bench.pair.line(Side::Can1).bit_time(), Some(Time(BIT)));
}

#[test]
fn a_busy_bus_delays_synchronisation() {
    let mut bench = Bench::initialising(0);
    bench.write(MCR, 0);
    bench.pair.set_bus_idle_since(Side::Can1, None);
    bench.pass(Time::from_ms(1));
    assert_eq!(bench.read(MSR) & 1, 1);
    assert_eq!(bench.pair.next_event(), None);
    // Ten bits are not enough, eleven are.
    bench.pair.recessive_stretch(Side::Can1, Time::from_us(500), Time::from_us(510));
    bench.pass(Time::from_us(1));
    assert_eq!(bench.read(MSR) & 1, 1);
    bench.pair.recessive_stretch(Side::Can1, Time::from_us(600), Time::from_us(611));
    bench.pass(Time::from_us(1));
    assert_eq!(bench.read(MSR) & 1, 0);
}

#[test]
fn leaving_sleep_takes_eleven_recessive_bits() {
    let mut bench = Bench::initialising(0);
    bench.write(MCR, 2);
    bench.write(MCR, 0);
    bench.pass(Time(11 * BIT - 1));
    assert_eq!(bench.read(MSR) & 0b11, 0b10);
    bench.pass(Time(1));
    assert_eq!(bench.read(MSR) & 0b11, 0);
}

#[test]
fn initialisation_waits_for_the_frame_on_the_wire() {
    let mut bench = Bench::normal();
    bench.request(0, 0x123);
    bench.started();
    bench.pair.set_bus_idle_since(Side::Can1, None);
    bench.pass(Time::from_us(10));
    bench.write(MCR, 1);
    bench.pass(Time::from_us(10));
    assert_eq!(bench.read(MSR) & 0x101, 0x100, "still transmitter (TXM), no INAK");
    bench.now += Time::from_us(30);
    bench.transmitted();
    assert_eq!(bench.read(MSR) & 0x101, 1);
    assert_eq!(bench.read(TSR) & 0b11, 0b11, "RQCP, TXOK");
}

#[test]
fn initialisation_waits_for_a_reception() {
    let mut bench = Bench::normal();
    bench.pair.set_bus_idle_since(Side::Can1, None);
    bench.write(MCR, 1);
    bench.pass(Time::from_us(10));
    assert_eq!(bench.read(MSR) & 0x201, 0x200, "receiver (RXM), no INAK");
    bench.received(WireFrame::standard(1, &[]));
    assert_eq!(bench.read(MSR) & 0x201, 1);
    assert_eq!(bench.read(RF0R), 1, "the frame was completed");
}

#[test]
fn no_frame_starts_after_the_request_for_initialisation() {
    let mut bench = Bench::normal();
    bench.request(0, 0x123);
    let before = bench.now;
    bench.now += Time::from_us(5);
    bench.write(MCR, 1);
    assert!(bench.contends().is_none());
    assert!(bench.pair.line(Side::Can1).contend(before).is_some(), "the wire may still be there");
}

#[test]
fn bus_activity_wakes_a_sleeper() {
    for (awum, slak_stays) in [(0, true), (1 << 5, false)] {
        let mut bench = Bench::initialising(0);
        bench.write(IER, 1 << 16);
        bench.write(MCR, 2 | awum);
        bench.pair.set_bus_idle_since(Side::Can1, None);
        bench.pass(Time::from_us(10));
        assert_eq!(bench.read(MSR) & 1 << 3, 1 << 3, "WKUI");
        assert!(bench.pair.irq(Side::Can1).sce);
        assert_eq!(bench.read(MCR) & 2 != 0, slak_stays, "AWUM clears SLEEP");
        bench.pair.set_bus_idle_since(Side::Can1, Some(bench.now));
        bench.pass(Time(11 * BIT));
        assert_eq!(bench.read(MSR) & 2 != 0, slak_stays);
        bench.write(MSR, 1 << 3);
        assert!(!bench.pair.irq(Side::Can1).sce);
    }
}

#[test]
fn sleep_acknowledge_interrupts_when_enabled() {
    let mut bench = Bench::initialising(0);
    bench.write(IER, 1 << 17);
    bench.write(MCR, 2);
    assert_eq!(bench.read(MSR) & 0x12, 0x12, "SLAK and SLAKI");
    assert!(bench.pair.irq(Side::Can1).sce);
    bench.write(MCR, 1);
    assert_eq!(bench.read(MSR) & 0x10, 0, "cleared by hardware with SLAK");
}

#[test]
fn master_reset_returns_to_sleep() {
    let mut bench = Bench::normal();
    bench.received(WireFrame::standard(1, &[]));
    bench.write(MCR, 1 << 15);
    assert_eq!(bench.read(MCR), 0x0001_0002);
    assert_eq!(bench.read(MSR) & 0b11, 0b10);
    assert_eq!(bench.read(RF0R), 0);
    assert_eq!(bench.read(BTR), BTR_1M);
    assert_eq!(bench.pair.stats(Side::Can1).discarded, 1);
}

#[test]
fn btr_changes_in_initialisation_only() {
    let mut bench = Bench::normal();
    bench.write(BTR, 0);
    assert_eq!(bench.read(BTR), BTR_1M);
    let stats = bench.pair.stats(Side::Can1);
    assert_eq!((stats.ignored_writes, stats.last_ignored_write), (1, Some((bench.now, BTR))));
}

#[test]
fn bit_time_follows_btr() {
    // 42 MHz / 3 / (1 + 10 + 3) = 1 Mbit/s; 42 MHz / 6 / (1 + 11 + 2) = 500 kbit/s.
    for (btr, ticks) in [(2 << 20 | 9 << 16 | 2, 336), (1 << 20 | 10 << 16 | 5, 672)] {
        let mut bench = Bench::asleep();
        bench.write(MCR, 1);
        bench.write(BTR, btr);
        bench.write(MCR, 0);
        bench.pass(Time::from_ms(1));
        assert_eq!(bench.pair.line(Side::Can1).bit_time(), Some(Time(ticks)));
    }
}

#[test]
fn a_slow_crystal_does_not_drift_by_rounding() {
    // 100 ppm slow: 1408 bits of bus-off recovery are 1408 * 336 * 1.0001 = 473_135.3 ticks, not 1408 * 336.
    let mut bench = Bench::normal();
    bench.pair.set_pclk(PclkTick::new(8_000_800, 1_000_000));
    assert_eq!(bench.pair.line(Side::Can1).bit_time(), Some(Time(336)));
    bench.write(MCR, 1 << 6);
    let start = bench.now;
    (0..32).for_each(|_| bench.transmit_error(can_wire::controller::ErrorKind::BitDominant));
    assert_eq!(bench.pair.next_event(), Some(start + Time(473_135)));
}

#[test]
fn silent_mode_listens_only() {
    let mut bench = Bench::normal_with(0, 1 << 31);
    bench.request(0, 1);
    let line = bench.pair.line(Side::Can1);
    assert!(!line.acknowledges());
    assert_eq!(line.bit_time(), Some(Time(BIT)));
    assert_eq!(line.request_at(), None);
    assert!(bench.contends().is_none());
    bench.received(WireFrame::standard(5, &[]));
    assert_eq!(bench.read(RF0R), 1);
}

#[test]
fn loopback_receives_its_own_frames_without_a_bus() {
    for silent in [0, 1 << 31] {
        let mut bench = Bench::normal_with(0, 1 << 30 | silent);
        bench.pair.set_bus_idle_since(Side::Can1, None);
        bench.request(0, 0x321);
        assert_eq!(bench.pair.line(Side::Can1).bit_time(), None, "not on the wire");
        bench.pass(Time(1));
        let end = bench.pair.next_event().expect("the end of the frame");
        // 44 bits from SOF to EOF.
        assert_eq!(end, Time(bench.now.0 - 1 + 44 * BIT));
        bench.pair.poll(end);
        assert_eq!(bench.read(TSR) & 0b11, 0b11);
        assert_eq!(bench.read(RF0R), 1);
        assert_eq!(bench.read(RIR0), 0x321 << 21);
        assert_eq!(bench.read(ESR), 0, "acknowledge errors are ignored");
    }
}

#[test]
fn the_controllers_are_independent() {
    let mut bench = Bench::normal();
    assert_eq!(bench.read(CAN2 + MSR) & 0b11, 0b10);
    bench.write(CAN2 + MCR, 1);
    bench.write(CAN2 + BTR, BTR_1M);
    bench.write(CAN2 + MCR, 0);
    bench.pass(Time(11 * BIT));
    assert!(bench.pair.line(Side::Can2).bit_time().is_some());
    bench.pair.reset(Side::Can2);
    assert_eq!(bench.read(CAN2 + MSR) & 0b11, 0b10);
    assert_eq!(bench.read(MSR) & 0b11, 0);
    assert_eq!(bench.read(FA1R), 1, "the filters are CAN1's");
    bench.pair.reset(Side::Can1);
    assert_eq!(bench.read(FMR), 0x2A1C_0E01);
}
