//! Bus-off and the way back: RM0090 32.7.6, 32.9.2 (MCR, ESR).

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;

use super::bench::*;

/// 128 sequences of 11 recessive bits.
const RECOVERY: u64 = 128 * 11;

/// Returns a bench whose CAN1 has become bus-off at this instant with one pending mailbox, on a bus that works again.
fn bus_off(mcr: u32) -> Bench {
    let mut bench = Bench::normal_with(mcr, 0);
    bench.enter_bus_off();
    bench.fault(Fault::ClearShorts);
    bench
}

#[test]
fn abom_recovers_after_128_times_11_recessive_bits() {
    let mut bench = bus_off(ABOM);
    bench.changes_after(bits(RECOVERY), Bench::flags, 0b111, 0);
    assert_eq!((bench.tec(), bench.rec()), (0, 0));
}

#[test]
fn a_pending_frame_survives_bus_off_and_goes_after_recovery() {
    let mut bench = bus_off(ABOM);
    bench.pass(bits(RECOVERY));
    assert_eq!(bench.status(0) & RQCP, 0);
    bench.complete(0);
    assert_eq!(bench.status(0), RQCP | TXOK);
    assert_eq!(bench.received_by(PEER), [frame(0x100)]);
}

#[test]
fn without_abom_nothing_ends_bus_off() {
    let mut bench = bus_off(0);
    bench.pass(Time::from_ms(100));
    assert_eq!(bench.flags(), 0b111);
    bench.deliver(empty());
    assert_eq!(bench.read(RF0R), 0);
}

#[test]
fn without_abom_recovery_waits_for_inrq_set_and_cleared() {
    let mut bench = bus_off(0);
    bench.pass(Time::from_ms(10));
    bench.write(MCR, INRQ);
    bench.pass(Time(1));
    assert_eq!(bench.mode(), INAK);
    bench.pass(Time::from_ms(10));
    assert_eq!(bench.flags(), 0b111, "initialisation does not hear the line");
    bench.write(MCR, 0);
    bench.changes_after(bits(11), Bench::mode, INAK, 0);
    assert_eq!(bench.flags(), 0b111, "but still bus-off");
    bench.changes_after(bits(RECOVERY - 11), Bench::flags, 0b111, 0);
    assert_eq!((bench.tec(), bench.rec()), (0, 0));
    bench.complete(0);
    assert_eq!(bench.received_by(PEER), [frame(0x100)]);
}

#[test]
fn abom_set_in_bus_off_begins_the_recovery() {
    let mut bench = bus_off(0);
    bench.pass(Time::from_ms(10));
    bench.write(MCR, ABOM);
    bench.pass(Time(bits(RECOVERY).0 - 1));
    assert_eq!(bench.flags(), 0b111);
    bench.pass(bits(1));
    assert_eq!(bench.flags(), 0);
}

/// Back-to-back frames leave exactly 11 recessive bits: acknowledge delimiter, end of frame, intermission.
#[test]
fn a_busy_bus_lengthens_recovery() {
    let mut bench = bus_off(ABOM);
    let start = bench.now;
    (0..200).for_each(|_| bench.send(empty()));
    bench.until("recovery", |bench| bench.flags() & BOFF == 0);
    assert_eq!(bench.received_by(OTHER).len(), 128);
    assert_eq!(bench.now, start + bits(128 * (EMPTY_BITS + 3)));
}

#[test]
fn a_bus_shorted_dominant_ends_no_bus_off() {
    let mut bench = bus_off(ABOM);
    bench.pass(bits(700));
    bench.short(false);
    bench.pass(Time::from_ms(100));
    assert_eq!(bench.flags(), 0b111);
    bench.fault(Fault::ClearShorts);
    bench.pass(bits(700));
    assert_eq!(bench.flags(), 0b111, "the sequences before it count, but not yet enough");
    bench.pass(bits(30));
    assert_eq!(bench.flags(), 0);
}

#[test]
fn bus_off_and_its_end_interrupt_once() {
    let mut bench = Bench::normal_with(ABOM, 0);
    bench.write(IER, 1 << 10 | 1 << 15);
    bench.enter_bus_off();
    assert!(bench.irq().sce);
    bench.write(MSR, ERRI);
    bench.fault(Fault::ClearShorts);
    bench.until("recovery", |bench| bench.flags() & BOFF == 0);
    assert!(!bench.irq().sce, "leaving bus-off is no error condition");
}

#[test]
fn a_slow_crystal_does_not_drift_by_rounding() {
    // 100 ppm slow: 1408 bits of bus-off recovery are 1408 * 336 * 1.0001 = 473_135.3 ticks, not 1408 * 336.
    let mut bench = Bench::initialising(vec![], 0);
    bench.pair().set_pclk(can_twin::bxcan::PclkTick::new(8_000_800, 1_000_000));
    bench.write(MCR, ABOM);
    bench.pass(bits(20));
    bench.enter_bus_off();
    bench.pass(Time(473_134));
    assert_eq!(bench.flags(), 0b111);
    bench.pass(Time(2));
    assert_eq!(bench.flags(), 0);
}

#[test]
fn each_bus_off_without_abom_needs_its_own_request() {
    let mut bench = bus_off(0);
    bench.write(MCR, INRQ);
    bench.pass(Time(1));
    bench.write(MCR, 0);
    bench.until("recovery", |bench| bench.flags() == 0);
    bench.short(true);
    bench.until("bus-off", |bench| bench.flags() & BOFF != 0);
    bench.fault(Fault::ClearShorts);
    bench.pass(Time::from_ms(10));
    assert_eq!(bench.flags(), 0b111);
}

/// Initialisation does not monitor the bus: sequences before it do not count for the recovery.
#[test]
fn initialisation_during_recovery_begins_it_anew() {
    let mut bench = bus_off(ABOM);
    bench.pass(bits(RECOVERY - 10));
    bench.write(MCR, INRQ | ABOM);
    bench.pass(bits(100));
    assert_eq!((bench.mode(), bench.flags()), (INAK, 0b111));
    bench.write(MCR, ABOM);
    bench.changes_after(bits(RECOVERY), Bench::flags, 0b111, 0);
}

#[test]
fn a_reset_ends_bus_off() {
    let mut bench = bus_off(0);
    bench.write(MCR, 1 << 15);
    assert_eq!(bench.read(ESR), 0);
    bench.write(MCR, INRQ);
    bench.write(MCR, 0);
    bench.pass(bits(11));
    bench.transmit(0x101);
    assert_eq!((bench.status(0), bench.tec()), (RQCP | TXOK, 0));
}
