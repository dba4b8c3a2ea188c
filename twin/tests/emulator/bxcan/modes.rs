//! Registers, initialisation and its handshakes: RM0090 32.4.1, 32.4.2, 32.9.1, 32.9.2.

use can_twin::bxcan::{Activity, BadAccess, BxcanPair, Side};
use can_twin::wire::controller::{Controller, ErrorCounters, WireEvent};
use can_twin::wire::fault::Fault;
use can_twin::wire::station::Station;
use can_twin::wire::time::Time;

use super::bench::*;

#[test]
fn registers_hold_their_reset_values() {
    let bench = Bench::asleep(vec![]);
    for base in [0, BASE2] {
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
    for offset in [0x020, 0x17C, 0x1D0, 0x208, 0x320, 0x7FC, BASE2 + FMR, BASE2 + BANKS, 0x800, 0x002] {
        assert_eq!(pair.read(offset), Err(BadAccess { offset }), "{offset:X}h");
        assert_eq!(pair.write(offset, 0, Time::ZERO), Err(BadAccess { offset }), "{offset:X}h");
    }
}

/// ST's HAL and Zephyr set INRQ, wait for INAK, then clear SLEEP.
#[test]
fn inrq_in_sleep_is_acknowledged_while_sleep_is_set() {
    let mut bench = Bench::asleep(vec![]);
    bench.write(MCR, INRQ | SLEEP);
    assert_eq!(bench.mode(), INAK, "INAK set, SLAK cleared");
    bench.write(BTR, BTR_1M);
    assert_eq!(bench.read(BTR), BTR_1M, "writable in initialisation");
    bench.write(MCR, INRQ);
    assert_eq!(bench.mode(), INAK, "clearing SLEEP changes nothing");
    bench.write(MCR, SLEEP);
    assert_eq!(bench.mode(), SLAK, "back to sleep at once");
}

#[test]
fn normal_mode_is_entered_after_eleven_recessive_bits() {
    let mut initialising = Bench::initialising(vec![Station::default()], 0);
    initialising.pass(Time::from_us(100));
    // From Initialisation, and from Sleep.
    for (mut bench, before) in [(initialising, INAK), (Bench::sent_to_sleep(0), SLAK)] {
        bench.write(MCR, 0);
        bench.changes_after(bits(11), Bench::mode, before, 0);
    }
}

/// Off its pins a controller hears recessive bits.
#[test]
fn a_controller_without_a_bus_synchronises_by_itself() {
    let mut pair = BxcanPair::new(pclk());
    pair.write(MCR, INRQ, Time::ZERO).expect("a register");
    pair.write(BTR, BTR_1M, Time::ZERO).expect("a register");
    pair.write(MCR, 0, bits(100)).expect("a register");
    assert_eq!(pair.next_event(), Some(bits(111)));
    pair.poll(Time(bits(111).0 - 1));
    assert_eq!(pair.read(MSR).expect("a register") & 0b11, INAK);
    pair.poll(bits(111));
    assert_eq!(pair.read(MSR).expect("a register") & 0b11, 0);
}

/// Returns controllers in Normal mode since bit 111, connected to nothing.
fn alone(mcr: u32) -> BxcanPair {
    let mut pair = BxcanPair::new(pclk());
    pair.write(MCR, INRQ, Time::ZERO).expect("a register");
    pair.write(BTR, BTR_1M, Time::ZERO).expect("a register");
    pair.write(MCR, mcr, bits(100)).expect("a register");
    pair.poll(bits(111));
    pair
}

/// Given a controller whose pins are disconnected within a frame, then the attempt has failed, the request waits, and
/// Initialisation can be entered.
#[test]
fn a_controller_that_loses_its_bus_in_mid_frame_goes_on() {
    let mut pair = alone(0);
    pair.hear(Side::Can1, Activity::Idle);
    pair.poll(bits(120));
    pair.write(TIR0, 1, bits(120)).expect("a register");
    pair.line(Side::Can1).on_wire(bits(121), &WireEvent::Started);
    assert_eq!(pair.read(MSR).expect("a register") & TXM, TXM);
    pair.hear(Side::Can1, Activity::Nothing);
    pair.poll(bits(130));
    assert_eq!(pair.read(MSR).expect("a register") & TXM, 0);
    assert_eq!(pair.read(TSR).expect("a register") & TME0, 0, "it waits");
    pair.write(MCR, INRQ, bits(131)).expect("a register");
    pair.poll(bits(132));
    assert_eq!(pair.read(MSR).expect("a register") & INAK, INAK);
}

/// A dominant SOF that reads recessive is a bit error (ISO 11898-1), and in single shot the request ends with it.
#[test]
fn a_single_shot_without_a_bus_ends_in_a_bit_error() {
    let mut pair = alone(NART);
    pair.write(TIR0, 1, bits(120)).expect("a register");
    // SOF, error flag and error delimiter.
    assert_eq!(pair.next_event(), Some(bits(120)));
    pair.poll(bits(120));
    assert_eq!(pair.next_event(), Some(bits(135)));
    pair.poll(Time(bits(135).0 - 1));
    assert_eq!(pair.read(TSR).expect("a register") & STATUS, 0);
    pair.poll(bits(135));
    assert_eq!(pair.read(TSR).expect("a register") & STATUS, RQCP | TERR);
    assert_eq!(pair.read(ESR).expect("a register"), 8 << 16 | 5 << 4);
    assert_eq!(pair.next_event(), None);
}

/// With retransmission: 32 attempts of 15 bits, each followed by 3 bits of intermission, and by 8 more from the 16th
/// on, which makes it error passive. The last one makes it bus-off.
#[test]
fn a_request_without_a_bus_ends_in_bus_off() {
    let mut pair = alone(0);
    pair.write(TIR0, 1, bits(120)).expect("a register");
    let last = 120 + 15 * 18 + 16 * (18 + 8) + 15;
    pair.poll(Time(bits(last).0 - 1));
    assert_eq!(pair.read(ESR).expect("a register") & 0b111, 0b011);
    pair.poll(bits(last));
    assert_eq!(pair.read(ESR).expect("a register") & 0b111, 0b111);
    assert_eq!(pair.next_event(), None, "without ABOM it stays so");
}

/// RM0090 32.7.6: 128 times 11 recessive bits, from bus-off on, also where nothing is connected.
#[test]
fn bus_off_without_a_bus_ends_1408_bits_after_it_began() {
    let mut pair = alone(ABOM);
    let off = ErrorCounters { transmit: 256, receive: 0 };
    pair.line(Side::Can1).on_wire(bits(200), &WireEvent::Counters(off));
    pair.poll(bits(1607));
    assert_eq!(pair.read(ESR).expect("a register") & BOFF, BOFF);
    assert_eq!(pair.next_event(), Some(bits(1608)));
    pair.poll(bits(1608));
    assert_eq!(pair.read(ESR).expect("a register"), 0);
}

#[test]
fn a_frame_under_way_delays_synchronisation() {
    let mut bench = Bench::initialising(vec![Station::default(), Station::default()], 0);
    bench.pass(bits(20));
    bench.send(empty());
    bench.send(frame(0x123));
    bench.pass(bits(20));
    bench.write(MCR, 0);
    // Acknowledge delimiter, EOF and intermission are 11 bits.
    bench.changes_after(bits(EMPTY_BITS + 3 - 20), Bench::mode, INAK, 0);
    bench.until("the next frame", |bench| bench.read(RF0R) == 1);
    assert_eq!(bench.read(RIR0), 0x123 << 21, "and only the next");
}

#[test]
fn ten_recessive_bits_are_not_enough() {
    let mut bench = Bench::initialising(vec![Station::default()], 0);
    bench.pass(bits(20));
    bench.write(MCR, 0);
    bench.pass(bits(10));
    bench.dominant_pulse(1);
    // 11 bits after the pulse.
    bench.changes_after(bits(12), Bench::mode, INAK, 0);
}

#[test]
fn a_bus_shorted_dominant_keeps_a_controller_off_the_bus() {
    let initialising = Bench::initialising(vec![Station::default()], 0);
    for (mut bench, before) in [(initialising, INAK), (Bench::sent_to_sleep(0), SLAK)] {
        bench.short(false);
        bench.write(MCR, 0);
        bench.pass(Time::from_ms(100));
        assert_eq!(bench.mode(), before);
        bench.fault(Fault::ClearShorts);
        bench.pass(Time(bits(11).0 - 1));
        assert_eq!(bench.mode(), before);
        bench.pass(bits(1));
        assert_eq!(bench.mode(), 0);
    }
}

#[test]
fn initialisation_can_be_asked_for_again_before_it_was_left() {
    let mut bench = Bench::initialising(vec![Station::default()], 0);
    bench.write(MCR, 0);
    bench.pass(bits(5));
    bench.write(MCR, INRQ);
    bench.pass(bits(100));
    assert_eq!(bench.mode(), INAK);
    bench.write(MCR, 0);
    // All 11 bits again.
    bench.changes_after(bits(11), Bench::mode, INAK, 0);
}

#[test]
fn a_change_of_mode_waits_for_the_frame_on_the_wire() {
    for (request, acknowledgement) in [(INRQ, INAK), (SLEEP, SLAK)] {
        let mut bench = Bench::normal();
        bench.request(0, 0x080);
        bench.pass(bits(10));
        bench.write(MCR, request);
        bench.pass(bits(EMPTY_BITS - 11));
        assert_eq!(bench.read(MSR) & (TXM | INAK | SLAK), TXM, "MCR {request:X}h: still transmitter");
        bench.pass(bits(4));
        assert_eq!(bench.read(MSR) & (TXM | INAK | SLAK), acknowledgement, "MCR {request:X}h");
        assert_eq!(bench.status(0), RQCP | TXOK, "MCR {request:X}h");
    }
}

#[test]
fn initialisation_waits_for_a_reception() {
    let mut bench = Bench::normal();
    bench.send(empty());
    bench.pass(bits(10));
    bench.write(MCR, INRQ);
    bench.pass(bits(EMPTY_BITS - 12));
    assert_eq!(bench.read(MSR) & 0x201, 0x200, "receiver (RXM), no INAK");
    bench.pass(bits(5));
    assert_eq!(bench.read(MSR) & 0x201, INAK);
    assert_eq!(bench.read(RF0R), 1, "the frame was completed");
}

#[test]
fn initialisation_of_an_idle_controller_is_immediate() {
    let mut bench = Bench::normal();
    bench.write(MCR, INRQ);
    bench.pass(bits(1));
    assert_eq!(bench.mode(), INAK);
    bench.deliver(empty());
    assert_eq!(bench.read(RF0R), 0, "deaf");
    assert_eq!(bench.received_by(OTHER), [empty()]);
}

#[test]
fn a_request_for_initialisation_can_be_taken_back() {
    let mut bench = Bench::normal();
    bench.send(empty());
    bench.pass(bits(10));
    bench.write(MCR, INRQ);
    bench.pass(bits(10));
    bench.write(MCR, 0);
    bench.calm();
    assert_eq!((bench.mode(), bench.read(RF0R)), (0, 1));
    bench.transmit(0x100);
    assert_eq!(bench.status(0), RQCP | TXOK);
}

#[test]
fn no_frame_starts_after_the_request_for_initialisation() {
    // At 4 us the frame had begun.
    for (us, received) in [(5, vec![]), (4, vec![frame(0x123)])] {
        let mut bench = Bench::normal();
        let start = bench.now;
        bench.request_at(start + Time::from_us(us), 0, 0x123);
        bench.write_at(start + Time::from_us(5), MCR, INRQ);
        bench.pass(Time::from_ms(1));
        assert_eq!((bench.mode(), bench.received_by(PEER)), (INAK, received), "requested at {us} us");
    }
}

#[test]
fn failed_attempt_ends_activity_that_initialisation_waits_for() {
    let mut bench = Bench::with(vec![], 0, 0);
    bench.request(0, 0x080);
    bench.pass(bits(10));
    bench.write(MCR, INRQ);
    bench.pass(bits(100));
    assert_eq!(bench.mode(), INAK);
    assert_eq!(bench.wire.counters().ack_errors, 1, "no second attempt");
    assert_eq!(bench.status(0) & RQCP, 0, "still pending");
}

#[test]
fn error_counters_survive_initialisation() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.fail_attempt();
    bench.complete(0);
    bench.write(MCR, INRQ);
    bench.pass(bits(60));
    bench.write(MCR, 0);
    bench.pass(bits(11));
    assert_eq!((bench.mode(), bench.tec()), (0, 7));
    bench.transmit(0x100);
    assert_eq!(bench.tec(), 6);
}

/// INAK and the clearing of INRQ are in one quantum of the bench: 20 bits.
#[test]
fn initialisation_left_once_acknowledged_synchronises_anew() {
    let mut bench = Bench::normal();
    bench.write(MCR, INRQ);
    bench.pass(bits(20));
    assert_eq!(bench.mode(), INAK);
    bench.write(MCR, 0);
    bench.changes_after(bits(11), Bench::mode, INAK, 0);
    bench.deliver(empty());
    assert_eq!(bench.read(RF0R), 1);
}

#[test]
fn master_reset_returns_to_sleep() {
    let mut bench = Bench::normal();
    bench.deliver(empty());
    bench.write(MCR, 1 << 15);
    assert_eq!(bench.read(MCR), 0x0001_0002);
    assert_eq!(bench.mode(), SLAK);
    assert_eq!(bench.read(RF0R), 0);
    assert_eq!(bench.read(BTR), BTR_1M);
    assert_eq!(bench.stats().discarded, 1);
}

#[test]
fn a_reset_breaks_off_the_frame_on_the_wire() {
    for rejoins_at_once in [true, false] {
        let mut bench = Bench::normal();
        bench.request(0, 0x080);
        bench.pass(bits(20));
        bench.write(MCR, 1 << 15);
        if !rejoins_at_once {
            bench.pass(bits(100));
        }
        bench.write(MCR, INRQ);
        bench.write(MCR, 0);
        bench.until("normal mode", |bench| bench.mode() == 0);
        bench.calm();
        assert_eq!((bench.received_by(PEER), bench.read(ESR)), (vec![], 0));
        assert_eq!(bench.read(TSR), 0x1C00_0000, "nothing is pending");
        bench.deliver(frame(0x123));
        assert_eq!((bench.read(RIR0), bench.read(ESR)), (0x123 << 21, 0));
        bench.transmit(0x100);
        assert_eq!(bench.received_by(PEER), [frame(0x100)]);
    }
}

#[test]
fn btr_changes_in_initialisation_only() {
    let mut bench = Bench::normal();
    bench.write(BTR, 0);
    assert_eq!(bench.read(BTR), BTR_1M);
    let stats = bench.stats();
    assert_eq!((stats.ignored_writes, stats.last_ignored_write), (1, Some((bench.now, BTR))));
}

#[test]
fn can2_has_its_own_interrupts() {
    let mut bench = Bench::normal();
    bench.start_can2();
    bench.write(FMR, 1);
    bench.write(FMR, 0);
    bench.write(BASE2 + IER, 1 | 1 << 1 | 1 << 11 | 1 << 15);
    bench.deliver(empty());
    assert!(bench.pair().irq(Side::Can2).rx0, "all banks are CAN2's");
    bench.write(BASE2 + TIR0 + 4, 0);
    bench.write(BASE2 + TIR0, 0x100 << 21 | 1);
    bench.flip(CAN2, can_twin::wire::field::Field::Dlc(0));
    bench.until("an error", |bench| bench.read(BASE2 + ESR) >> 4 & 0b111 == 5);
    assert!(bench.pair().irq(Side::Can2).sce);
    bench.until("success", |bench| bench.read(BASE2 + TSR) & TXOK != 0);
    assert!(bench.pair().irq(Side::Can2).tx);
    assert_eq!(bench.irq(), can_twin::bxcan::IrqLines::default());
}

#[test]
fn the_controllers_are_independent() {
    let mut bench = Bench::normal();
    assert_eq!(bench.read(BASE2 + MSR) & 0b11, SLAK);
    bench.start_can2();
    bench.deliver(empty());
    assert_eq!((bench.read(RF0R), bench.read(BASE2 + RF0R)), (1, 0), "no filter of CAN2");
    bench.pair().reset(Side::Can2);
    assert_eq!(bench.read(BASE2 + MSR) & 0b11, SLAK);
    assert_eq!(bench.mode(), 0);
    assert_eq!(bench.read(FA1R), 1, "the filters are CAN1's");
    bench.pair().reset(Side::Can1);
    assert_eq!(bench.read(FMR), 0x2A1C_0E01);
}
