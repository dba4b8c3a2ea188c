//! Aborts and their races: RM0090 32.7.1 ("Abort"), 32.9.2 (TSR).

use can_twin::bxcan::Attempt;
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::bench::*;

fn occupied() -> Bench {
    let mut bench = Bench::normal();
    bench.occupy();
    bench
}

/// The aborted frames, with the results of their latest attempts.
fn aborted(bench: &Bench) -> Vec<(WireFrame, Option<Attempt>)> {
    bench.stats().aborted.iter().map(|aborted| (aborted.frame, aborted.last)).collect()
}

#[test]
fn a_pending_request_is_aborted_at_once() {
    let mut bench = occupied();
    bench.request(0, 0x100);
    bench.pass(bits(1));
    bench.write(TSR, ABRQ);
    bench.pass(Time(1));
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ | STATUS), TME0 | RQCP, "completed, not TXOK");
    assert_eq!(aborted(&bench), [(frame(0x100), None)]);
    bench.calm();
    assert_eq!(bench.received_by(PEER), []);
}

#[test]
fn an_aborted_request_leaves_the_others_alone() {
    let mut bench = occupied();
    (0..3).for_each(|n| bench.request(n, 0x100 + n));
    bench.write(TSR, ABRQ << 8);
    bench.complete(2);
    assert_eq!([0, 1, 2].map(|n| bench.status(n)), [RQCP | TXOK, RQCP, RQCP | TXOK]);
    assert_eq!(bench.received_by(PEER), [frame(0x100), frame(0x102)]);
}

#[test]
fn an_abort_raises_the_transmit_interrupt() {
    let mut bench = occupied();
    bench.write(IER, 1);
    bench.request(0, 0x100);
    bench.write(TSR, ABRQ);
    bench.pass(Time(1));
    assert!(bench.irq().tx, "RQCP is set by an abort as well");
}

#[test]
fn abort_of_successful_transmission_waits_for_its_end() {
    let mut bench = Bench::normal();
    bench.request(0, 0x080);
    bench.pass(bits(1));
    bench.write(TSR, ABRQ);
    bench.changes_after(
        bits(EMPTY_BITS - 1),
        |bench| bench.read(TSR) & (TME0 | ABRQ | STATUS),
        ABRQ,
        TME0 | RQCP | TXOK,
    );
    assert_eq!(aborted(&bench), []);
    assert_eq!(bench.received_by(PEER), [empty()]);
}

#[test]
fn an_abort_during_a_transmission_that_fails_ends_it() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::Dlc(0));
    bench.request(0, 0x080);
    bench.pass(bits(1));
    bench.write(TSR, ABRQ);
    bench.complete(0);
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ | STATUS), TME0 | RQCP | TERR);
    assert_eq!(aborted(&bench), [(empty(), Some(Attempt::Failed))]);
    bench.calm();
    assert_eq!(bench.received_by(PEER), [], "no further attempt");
}

#[test]
fn abort_of_unacknowledged_transmission_ends_it() {
    let mut bench = Bench::with(vec![], 0, 0);
    bench.request(0, 0x080);
    bench.pass(bits(1));
    bench.write(TSR, ABRQ);
    bench.complete(0);
    assert_eq!((bench.status(0), bench.lec()), (RQCP | TERR, 3));
    bench.pass(Time::from_ms(1));
    assert_eq!(bench.wire.counters().ack_errors, 1);
}

#[test]
fn an_abort_during_a_transmission_that_loses_ends_it() {
    let mut bench = Bench::normal();
    // 001h: PEER's lower identifier shows in the last bit only.
    bench.send(frame(0x000));
    bench.request(0, 0x001);
    bench.pass(bits(3));
    assert_eq!(bench.status(0), 0);
    bench.write(TSR, ABRQ);
    bench.complete(0);
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ | STATUS), TME0 | RQCP | ALST);
    assert_eq!(aborted(&bench).last().map(|(_, last)| *last), Some(Some(Attempt::ArbitrationLost)));
    bench.calm();
    assert_eq!(bench.received_by(PEER), []);
}

#[test]
fn an_abort_after_a_lost_arbitration_needs_no_further_attempt() {
    let mut bench = Bench::normal();
    bench.send(empty());
    bench.request(0, 0x100);
    bench.until("ALST", |bench| bench.status(0) & ALST != 0);
    bench.write(TSR, ABRQ);
    bench.pass(Time(1));
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ | STATUS), TME0 | RQCP | ALST);
    assert_eq!(aborted(&bench).last().map(|(_, last)| *last), Some(Some(Attempt::ArbitrationLost)));
    bench.calm();
    assert_eq!(bench.received_by(PEER), []);
}

#[test]
fn an_abort_counts_from_its_own_instant() {
    // The CPU has run to 10 us before the wire: the frame had begun.
    let mut bench = Bench::normal();
    let start = bench.now;
    bench.request_at(start + Time::from_us(3), 0, 0x100);
    bench.write_at(start + Time::from_us(10), TSR, ABRQ);
    bench.pass(Time::from_us(20));
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ), ABRQ, "on the wire: waits for the end");
    bench.complete(0);
    assert_eq!(bench.status(0), RQCP | TXOK);

    // The bus becomes free at the instant of the abort: too late to begin. One tick later it has begun.
    for (late, status, received) in [(Time(0), RQCP, vec![]), (Time(1), RQCP | TXOK, vec![frame(0x100)])] {
        let mut bench = Bench::normal();
        let free = bench.now + bits(EMPTY_BITS + 3);
        bench.send(empty());
        bench.pass(bits(EMPTY_BITS - 5));
        bench.request_at(bench.now + bits(1), 0, 0x100);
        bench.write_at(free + late, TSR, ABRQ);
        bench.pass(bits(20));
        bench.complete(0);
        bench.calm();
        assert_eq!((bench.status(0), bench.received_by(PEER)), (status, received), "{late:?}");
    }
}

#[test]
fn an_abort_without_a_request_has_no_effect() {
    let mut bench = Bench::normal();
    bench.write(TSR, ABRQ);
    bench.pass(Time(1));
    assert_eq!(bench.read(TSR), 0x1C00_0000);
}

#[test]
fn an_abort_in_bus_off_and_in_initialisation_is_immediate() {
    let mut bench = Bench::normal();
    bench.enter_bus_off();
    bench.write(TSR, ABRQ);
    bench.pass(Time(1));
    assert_eq!(bench.status(0) & (RQCP | TXOK | ABRQ), RQCP);

    let mut bench = Bench::initialising(vec![], 0);
    bench.request(0, 0x100);
    bench.write(TSR, ABRQ);
    assert_eq!(bench.status(0), RQCP);
}

#[test]
fn a_mailbox_is_free_again_after_an_abort() {
    let mut bench = occupied();
    bench.request(0, 0x100);
    bench.write(TSR, ABRQ);
    bench.pass(bits(1));
    bench.transmit(0x101);
    assert_eq!(bench.status(0), RQCP | TXOK);
    assert_eq!(bench.received_by(PEER), [frame(0x101)]);
}
