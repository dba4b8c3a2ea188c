//! The journal of frames that controller and program hand over to each other, and of the errors that the program saw.

use can_wire::field::Field;
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::bxcan::{Exchange, Side};

use super::bench::*;

const RFOM: u32 = 1 << 5;
const LECIE: u32 = 1 << 11;
const ERRIE: u32 = 1 << 15;

/// A controller on its bus, with a journal.
fn kept() -> Bench {
    let bench = Bench::normal();
    bench.pair().keep_journal();
    bench
}

fn journal(bench: &Bench) -> Vec<(Time, Exchange)> {
    bench.pair().take_journal(Side::Can1)
}

/// The program reads a register.
fn load(bench: &Bench, offset: u32) -> u32 {
    bench.pair().load(offset, bench.now()).expect("a register")
}

/// Given a frame that was sent, then the journal has its request and the acknowledgement of the program, each when the program wrote.
#[test]
fn the_journal_has_a_request_and_its_end() {
    let mut bench = kept();
    let requested = bench.now();
    bench.request(0, 0x100);
    bench.complete(0);
    let noticed = bench.now();
    bench.write(TSR, RQCP);
    let entries = [(requested, Exchange::Requested(frame(0x100))), (noticed, Exchange::Sent(frame(0x100)))];
    assert_eq!(journal(&bench), entries);
    assert_eq!(journal(&bench), [], "taken");
}

#[test]
fn the_journal_has_an_aborted_request() {
    let mut bench = kept();
    bench.send(sync());
    bench.pass(bits(5));
    bench.request(1, 0x100);
    bench.write(TSR, ABRQ << 8);
    bench.pass(Time(1));
    bench.write(TSR, RQCP << 8);
    let exchanges: Vec<Exchange> = journal(&bench).into_iter().map(|(_, exchange)| exchange).collect();
    assert_eq!(exchanges, [Exchange::Requested(frame(0x100)), Exchange::Aborted(frame(0x100))]);
}

/// Given two received frames, then the journal has each one when the program takes it, and nothing when the FIFO is empty.
#[test]
fn the_journal_has_a_frame_when_it_is_taken() {
    let mut bench = kept();
    let [one, two] = [[1], [2]].map(|data| WireFrame::standard(0x123, &data));
    bench.deliver(one);
    bench.deliver(two);
    assert_eq!(journal(&bench), []);
    let taken = bench.now();
    bench.write(RF0R, RFOM);
    assert_eq!(journal(&bench), [(taken, Exchange::Taken(one))]);
    bench.write(RF0R, RFOM);
    bench.write(RF0R, RFOM);
    let rest: Vec<Exchange> = journal(&bench).into_iter().map(|(_, exchange)| exchange).collect();
    assert_eq!(rest, [Exchange::Taken(two)]);
}

/// Given error interrupts that the program acknowledges, then the journal has the next ESR each time, also without a change.
#[test]
fn the_journal_has_errors_after_each_interrupt() {
    let mut bench = kept();
    bench.write(IER, ERRIE | LECIE);
    for _ in 0..2 {
        bench.flip(CAN1, Field::CrcDelimiter);
        // After the error enough frames for REC to be zero again.
        (0..10).for_each(|_| bench.deliver(frame(0x123)));
        assert_ne!(load(&bench, MSR) & ERRI, 0);
        bench.write(MSR, ERRI);
        load(&bench, ESR);
        load(&bench, ESR);
    }
    let exchanges: Vec<Exchange> = journal(&bench).into_iter().map(|(_, exchange)| exchange).collect();
    assert_eq!(exchanges, [Exchange::Errors(0); 2]);
}

/// Given an error, then the journal has each value of ESR once, when the program reads it, not when it changes.
#[test]
fn the_journal_has_errors_when_they_are_read() {
    let mut bench = kept();
    let fresh = bench.now();
    assert_eq!(load(&bench, ESR), 0);
    bench.flip(CAN1, Field::CrcDelimiter);
    bench.send(frame(0x123));
    bench.pass(bits(500));
    let noticed = bench.now();
    let errors = load(&bench, ESR);
    assert_ne!(errors, 0);
    bench.pass(bits(500));
    load(&bench, ESR);
    load(&bench, TSR);
    assert_eq!(journal(&bench), [(fresh, Exchange::Errors(0)), (noticed, Exchange::Errors(errors))]);
}

#[test]
fn the_journal_outlives_the_reset_of_a_controller() {
    let mut bench = kept();
    bench.request(0, 0x100);
    bench.pair().reset(Side::Can1);
    assert_eq!(journal(&bench).len(), 1);
}

#[test]
fn no_journal_is_kept_unless_asked() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    assert_eq!(journal(&bench), []);
}
