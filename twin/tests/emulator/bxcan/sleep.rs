//! Sleep and wake-up: RM0090 32.4.3, 32.8, 32.9.2.

use can_twin::wire::fault::Fault;
use can_twin::wire::station::Station;

use super::bench::*;

#[test]
fn a_sleeper_neither_receives_nor_acknowledges() {
    let mut bench = Bench::sent_to_sleep(0);
    bench.fault(Fault::Disconnect(OTHER));
    bench.send(empty());
    bench.pass(bits(100));
    assert!(bench.wire.counters().ack_errors > 0);
    assert_eq!((bench.read(RF0R), bench.read(ESR)), (0, 0));
}

#[test]
fn bus_activity_tells_a_sleeper() {
    let mut bench = Bench::sent_to_sleep(0);
    bench.deliver(empty());
    assert_eq!(bench.read(MSR) & WKUI, WKUI);
    assert!(bench.irq().sce);
    bench.calm();
    assert_eq!((bench.read(MCR) & SLEEP, bench.mode()), (SLEEP, SLAK), "software wakes it");
    bench.write(MSR, WKUI);
    assert!(!bench.irq().sce);
}

#[test]
fn awum_wakes_a_sleeper_by_bus_activity() {
    let mut bench = Bench::sent_to_sleep(AWUM);
    let start = bench.now;
    bench.send(empty());
    bench.send(frame(0x123));
    bench.pass(bits(2));
    assert_eq!(bench.read(MSR) & (WKUI | SLAK), WKUI | SLAK);
    assert_eq!(bench.read(MCR) & SLEEP, 0, "AWUM clears SLEEP");
    assert!(bench.irq().sce);
    bench.until("normal mode", |bench| bench.mode() == 0);
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
