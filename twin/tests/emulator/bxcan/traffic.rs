//! Bit rate, silent and loopback mode: RM0090 32.5, 32.7.7.

use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::Observation;
use can_twin::wire::station::Station;
use can_twin::wire::time::Time;
use can_twin::wire::timing::{BitTiming, Quantum};

use super::bench::*;

/// Bit times of the frames completed so far.
fn bit_times(bench: &mut Bench) -> Vec<Time> {
    let completed = |record: &Observation| match record {
        Observation::Completed { trace, .. } => Some(trace.bit_time),
        _ => None,
    };
    bench.wire.take_records().iter().filter_map(completed).collect()
}

/// 500 kbit/s: 21 quanta of 2/21 us.
fn half_rate() -> BitTiming {
    BitTiming::new(Quantum::new(32, 1), 16, 4, 1)
}

fn with_btr(btr: u32, stations: Vec<Station>) -> Bench {
    let mut bench = Bench::initialising(stations, 0);
    bench.write(BTR, btr);
    bench.write(MCR, 0);
    bench.pass(Time::from_ms(1));
    bench
}

#[test]
fn bit_time_follows_btr() {
    let full = || vec![Station::default(), Station::default()];
    let half = || vec![Station::with_timing(half_rate()), Station::with_timing(half_rate())];
    // 42 MHz / 3 / (1 + 10 + 3) = 1 Mbit/s; 42 MHz / 6 / (1 + 11 + 2) = 500 kbit/s.
    let cases = [(2 << 20 | 9 << 16 | 2, full(), 336), (1 << 20 | 10 << 16 | 5, half(), 672)];
    for (btr, stations, ticks) in cases {
        let mut bench = with_btr(btr, stations);
        bench.transmit(0x080);
        assert_eq!(bench.status(0), RQCP | TXOK);
        assert_eq!(bit_times(&mut bench), [Time(ticks)]);
        bench.deliver(empty());
        assert_eq!((bench.read(RF0R), bench.read(ESR)), (1, 0));
    }
}

#[test]
fn synchronisation_takes_eleven_bits_of_the_own_rate() {
    let mut bench = Bench::initialising(vec![], 0);
    // 500 kbit/s.
    bench.write(BTR, 1 << 20 | 10 << 16 | 5);
    bench.write(MCR, 0);
    bench.changes_after(bits(22), Bench::mode, INAK, 0);
}

#[test]
fn two_bit_rates_do_not_understand_each_other() {
    let mut bench = with_btr(BTR_1M, vec![Station::with_timing(half_rate())]);
    bench.send(empty());
    bench.pass(Time::from_ms(1));
    assert_eq!(bench.read(RF0R), 0);
    assert_ne!(bench.rec(), 0, "errors instead");
    bench.request(0, 0x100);
    bench.pass(Time::from_ms(5));
    assert_eq!(bench.status(0) & TXOK, 0);
    assert_eq!(bench.received_by(PEER), []);
}

/// 1.2 % are 1.5 quanta in the six bits between two edges of long runs: more than one quantum can follow.
#[test]
fn the_jump_width_follows_btr() {
    for drift_ppb in [12_000_000, -12_000_000] {
        for (sjw, received) in [(0, 0), (3, 1)] {
            let mut bench = with_btr(BTR_1M | sjw << 24, vec![Station::default(), Station::default()]);
            bench.fault(Fault::Drift(CAN1, drift_ppb));
            bench.pass(bits(1));
            bench.station(PEER).single_shot = true;
            bench.deliver(WireFrame::standard(0x080, &[0; 8]));
            bench.calm();
            assert_eq!(bench.read(RF0R), received, "{drift_ppb} ppb, SJW field {sjw}");
        }
    }
}

#[test]
fn silent_mode_receives_among_others() {
    let mut bench = Bench::normal_with(0, SILM);
    bench.deliver(empty());
    assert_eq!((bench.read(RF0R), bench.read(ESR)), (1, 0));
}

#[test]
fn silent_mode_sends_nothing() {
    let mut bench = Bench::normal_with(0, SILM);
    bench.request(0, 0x100);
    bench.pass(Time::from_ms(1));
    assert_eq!((bench.status(0), bench.received_by(PEER)), (0, vec![]));
}

#[test]
fn silent_mode_does_not_acknowledge() {
    let mut bench = Bench::with(vec![Station::default()], 0, SILM);
    bench.write(ESR, 0x70);
    bench.send(empty());
    bench.until("a verdict", |bench| bench.lec() != 7);
    assert_eq!(bench.wire.counters().ack_errors, 1);
    assert_eq!(bench.read(RF0R), 0);
    // The controller reads its own acknowledgement internally ("the bit is rerouted internally", 32.5.1). The error
    // flag of the transmitter destroys the frame.
    assert_eq!(bench.lec(), 2);
}

#[test]
fn silent_mode_disturbs_nobody() {
    let mut bench = Bench::normal_with(0, SILM);
    bench.flip(CAN1, can_twin::wire::field::Field::CrcDelimiter);
    bench.deliver(empty());
    assert_eq!((bench.lec(), bench.read(RF0R)), (2, 0), "an error of its own");
    assert_eq!((bench.wire.counters().destroyed, bench.received_by(OTHER)), (0, vec![empty()]));
}

#[test]
fn loopback_receives_its_own_frames_without_a_bus() {
    for silent in [0, SILM] {
        let mut bench = Bench::normal_with(0, LBKM | silent);
        let start = bench.now;
        bench.request(0, 0x321);
        bench.until("the end of the frame", |bench| bench.read(RF0R) == 1);
        // 44 bits from SOF to EOF.
        assert_eq!(bench.now, start + bits(44));
        assert_eq!(bench.status(0), RQCP | TXOK);
        assert_eq!(bench.read(RIR0), 0x321 << 21);
        assert_eq!(bench.read(ESR), 0, "acknowledge errors are ignored");
    }
}

#[test]
fn loopback_does_not_hear_the_bus() {
    for silent in [0, SILM] {
        let mut bench = Bench::normal_with(0, LBKM | silent);
        bench.deliver(empty());
        bench.calm();
        assert_eq!((bench.read(RF0R), bench.read(ESR)), (0, 0), "the pin is disregarded");
        bench.short(false);
        bench.transmit(0x321);
        assert_eq!((bench.status(0), bench.read(ESR)), (RQCP | TXOK, 0), "a short does not matter");
    }
}

#[test]
fn loopback_filters_its_own_frames() {
    let mut bench = Bench::normal_with(0, LBKM);
    bench.write(FA1R, 0);
    bench.transmit(0x321);
    assert_eq!((bench.read(RF0R), bench.stats().rejected), (0, 1));
}

#[test]
fn loopback_aborts_what_has_not_begun() {
    let mut bench = Bench::normal_with(0, LBKM);
    bench.request(0, 0x100);
    bench.request(1, 0x200);
    bench.pass(bits(5));
    bench.write(TSR, ABRQ | ABRQ << 8);
    bench.complete(0);
    bench.calm();
    assert_eq!((bench.status(0), bench.status(1)), (RQCP | TXOK, RQCP));
    assert_eq!(bench.read(RF0R), 1);
}

#[test]
fn initialisation_waits_for_a_loopback_frame() {
    let mut bench = Bench::normal_with(0, LBKM);
    bench.request(0, 0x321);
    bench.pass(bits(10));
    bench.write(MCR, INRQ);
    bench.pass(bits(33));
    assert_eq!(bench.mode(), 0);
    bench.pass(bits(2));
    assert_eq!((bench.mode(), bench.status(0)), (INAK, RQCP | TXOK));
}

#[test]
fn loopback_sends_by_priority() {
    let mut bench = Bench::normal_with(0, LBKM | SILM);
    for (n, id) in [(0, 0x300), (1, 0x100), (2, 0x200)] {
        bench.request(n, id);
    }
    bench.complete(0);
    assert_eq!(bench.read(RF0R) & 0b11, 3);
    assert_eq!(bench.drain(), [0x100, 0x200, 0x300]);
}
