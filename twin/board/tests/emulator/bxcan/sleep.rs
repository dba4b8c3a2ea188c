//! Sleep and wake-up: RM0090 32.4.3, 32.8, 32.9.2.

use can_wire::fault::Fault;
use can_wire::station::Station;
use can_wire::time::Time;

use super::bench::*;

/// Asleep from initialisation, with these bits in MCR beside SLEEP; wake-up interrupts enabled.
fn asleep(mcr: u32) -> Bench {
    let mut bench = Bench::initialising(vec![Station::default(), Station::default()], 0);
    bench.write(IER, 1 << 16);
    bench.write(MCR, SLEEP | mcr);
    bench.pass(bits(20));
    assert_eq!(bench.read(MSR) & 0b11, SLAK);
    bench
}

#[test]
fn leaving_sleep_takes_eleven_recessive_bits() {
    let mut bench = asleep(0);
    bench.write(MCR, 0);
    bench.pass(Time(bits(11).0 - 1));
    assert_eq!(bench.read(MSR) & 0b11, SLAK);
    bench.pass(Time(1));
    assert_eq!(bench.read(MSR) & 0b11, 0);
}

#[test]
fn a_bus_shorted_dominant_keeps_a_sleeper_asleep() {
    let mut bench = asleep(0);
    bench.short(false);
    bench.write(MCR, 0);
    bench.pass(Time::from_ms(100));
    assert_eq!(bench.read(MSR) & SLAK, SLAK);
    bench.fault(Fault::ClearShorts);
    bench.pass(bits(12));
    assert_eq!(bench.read(MSR) & SLAK, 0);
}

#[test]
fn sleep_waits_for_the_frame_on_the_wire() {
    let mut bench = Bench::normal();
    bench.request(0, 0x080);
    bench.pass(bits(10));
    bench.write(MCR, SLEEP);
    bench.pass(bits(EMPTY_BITS - 11));
    assert_eq!(bench.read(MSR) & 0b11, 0);
    bench.pass(bits(4));
    assert_eq!(bench.read(MSR) & 0b11, SLAK);
    assert_eq!(bench.status(0), RQCP | TXOK);
}

#[test]
fn a_sleeper_neither_receives_nor_acknowledges() {
    let mut bench = asleep(0);
    bench.fault(Fault::Disconnect(OTHER));
    bench.send(empty());
    bench.pass(bits(100));
    assert!(bench.wire.counters().ack_errors > 0);
    assert_eq!((bench.read(RF0R), bench.read(ESR)), (0, 0));
}

#[test]
fn bus_activity_tells_a_sleeper() {
    let mut bench = asleep(0);
    bench.deliver(empty());
    assert_eq!(bench.read(MSR) & WKUI, WKUI);
    assert!(bench.irq().sce);
    bench.calm();
    assert_eq!((bench.read(MCR) & SLEEP, bench.read(MSR) & SLAK), (SLEEP, SLAK), "software wakes it");
    bench.write(MSR, WKUI);
    assert!(!bench.irq().sce);
}

#[test]
fn awum_wakes_a_sleeper_by_bus_activity() {
    let mut bench = asleep(AWUM);
    let start = bench.now;
    bench.send(empty());
    bench.send(frame(0x123));
    bench.pass(bits(2));
    assert_eq!(bench.read(MSR) & (WKUI | SLAK), WKUI | SLAK);
    assert_eq!(bench.read(MCR) & SLEEP, 0, "AWUM clears SLEEP");
    assert!(bench.irq().sce);
    bench.until("normal mode", |bench| bench.read(MSR) & SLAK == 0);
    assert_eq!(bench.now, start + bits(EMPTY_BITS + 3), "11 recessive bits end with the intermission");
    bench.until("the next frame", |bench| bench.read(RF0R) == 1);
    assert_eq!(bench.read(RIR0), 0x123 << 21, "the one that woke it is lost");
}

#[test]
fn what_was_on_the_bus_before_sleep_wakes_nobody() {
    let mut bench = Bench::initialising(vec![Station::default(), Station::default()], 0);
    bench.pass(bits(20));
    bench.dominant_pulse(1);
    // The CPU runs ahead: asleep 5 bits after the pulse, within the same quantum.
    let later = bench.now + bits(5);
    bench.write_at(later, MCR, SLEEP | AWUM);
    bench.pass(bits(50));
    assert_eq!(bench.read(MSR) & (WKUI | SLAK), SLAK);
}

#[test]
fn nothing_wakes_a_controller_that_does_not_sleep() {
    let mut bench = Bench::normal();
    bench.deliver(empty());
    assert_eq!(bench.read(MSR) & WKUI, 0);
    bench.write(MCR, INRQ);
    bench.calm();
    bench.deliver(empty());
    assert_eq!(bench.read(MSR) & WKUI, 0);
}

#[test]
fn sleep_acknowledge_interrupts_when_enabled() {
    let mut bench = Bench::initialising(vec![], 0);
    bench.write(IER, 1 << 17);
    bench.write(MCR, SLEEP);
    assert_eq!(bench.read(MSR) & 0x12, 0x12, "SLAK and SLAKI");
    assert!(bench.irq().sce);
    bench.write(MCR, INRQ);
    assert_eq!(bench.read(MSR) & 0x10, 0, "cleared by hardware with SLAK");
}
