//! Receive FIFOs: RM0090 32.7.3, 32.7.5, 32.9.2 (RFxR), 32.9.3.

use can_twin::bxcan::{IrqLines, Overrun, Side};
use can_twin::wire::field::Field;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;

use super::bench::*;

const FULL: u32 = 1 << 3;
const FOVR: u32 = 1 << 4;

#[test]
fn the_output_mailbox_shows_the_frame() {
    let mut bench = Bench::normal();
    bench.deliver(WireFrame::standard(0x7FF, &[1, 2, 3, 4, 5, 6]));
    assert_eq!(bench.read(RIR0), 0x7FF << 21);
    assert_eq!(bench.read(RIR0 + 4), 6, "DLC 6, filter 0, TIME 0");
    assert_eq!(bench.read(RIR0 + 8), 0x0403_0201);
    assert_eq!(bench.read(RIR0 + 12), 0x0000_0605);
    bench.write(RF0R, RFOM);
    bench.deliver(WireFrame { id: WireId::Extended(0x1FFF_0001), remote: true, dlc: 3, data: [0; 8] });
    assert_eq!(bench.read(RIR0), 0x1FFF_0001 << 3 | 0b110);
    assert_eq!(bench.read(RIR0 + 4), 0, "DLC is 0 for a remote frame");
    bench.write(RF0R, RFOM);
    bench.deliver(WireFrame { dlc: 12, ..WireFrame::standard(1, &[9; 8]) });
    assert_eq!(bench.read(RIR0 + 4), 12, "DLC as received");
}

#[test]
fn a_dlc_beyond_eight_carries_eight_bytes() {
    let mut bench = Bench::normal();
    for dlc in 9..=15 {
        bench.deliver(WireFrame { dlc, ..WireFrame::standard(1, &[1, 2, 3, 4, 5, 6, 7, 8]) });
        assert_eq!(bench.read(RIR0 + 4), u32::from(dlc));
        assert_eq!((bench.read(RIR0 + 8), bench.read(RIR0 + 12)), (0x0403_0201, 0x0807_0605));
        bench.write(RF0R, RFOM);
    }
}

#[test]
fn a_frame_is_valid_at_the_last_but_one_bit_of_eof() {
    let mut bench = Bench::normal();
    bench.send(empty());
    bench.changes_after(bits(EMPTY_BITS - 1), |bench| bench.read(RF0R), 0, 1);
}

#[test]
fn an_error_in_the_last_but_one_bit_of_eof_discards_the_frame() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::Eof(5));
    bench.deliver(empty());
    bench.calm();
    assert_eq!(bench.drain(), [0x080], "only the repetition");
    // Its error flag destroyed the last bit for the others: the frame is valid for a receiver, not for the transmitter.
    assert_eq!(bench.received_by(OTHER).len(), 2);
}

#[test]
fn a_dominant_last_bit_of_eof_is_no_error_for_a_receiver() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::Eof(6));
    bench.deliver(empty());
    bench.calm();
    assert_eq!(bench.drain(), [0x080]);
    assert_eq!(bench.read(ESR), 0, "an overload frame");
}

#[test]
fn repetition_after_dominant_last_eof_bit_is_received_again() {
    let mut bench = Bench::normal();
    bench.flip(PEER, Field::Eof(6));
    bench.deliver(empty());
    bench.calm();
    assert_eq!(bench.drain(), [0x080, 0x080]);
}

#[test]
fn three_messages_fill_the_fifo() {
    let mut bench = Bench::normal();
    for (n, expected) in [(1, 1), (2, 2), (3, 3 | FULL)] {
        bench.deliver(frame(n));
        assert_eq!(bench.read(RF0R), expected);
    }
    bench.write(RF0R, FULL);
    assert_eq!(bench.read(RF0R), 3, "FULL is cleared by software");
    assert_eq!(bench.drain(), [1, 2, 3]);
    bench.write(RF0R, RFOM);
    assert_eq!(bench.read(RF0R), 0, "releasing an empty FIFO has no effect");
    let stats = bench.stats();
    assert_eq!((stats.stored, stats.released), ([3, 0], [3, 0]));
}

#[test]
fn full_clears_with_the_release_of_a_message() {
    let mut bench = Bench::normal();
    (1..=3).for_each(|id| bench.deliver(frame(id)));
    assert_eq!(bench.read(RF0R), 3 | FULL);
    bench.write(RF0R, RFOM);
    assert_eq!(bench.read(RF0R), 2);
    bench.deliver(frame(4));
    assert_eq!(bench.read(RF0R), 3 | FULL, "full again");
}

#[test]
fn full_interrupt_falls_with_the_release() {
    const FFIE0: u32 = 1 << 2;
    let mut bench = Bench::normal();
    bench.write(IER, FFIE0);
    (1..=3).for_each(|id| bench.deliver(frame(id)));
    assert!(bench.irq().rx0);
    bench.write(RF0R, RFOM);
    assert!(!bench.irq().rx0);
}

#[test]
fn overrun_replaces_the_newest_or_drops_the_new() {
    for (rflm, kept, lost) in [(0, [1, 2, 4], 3), (RFLM, [1, 2, 3], 4)] {
        let mut bench = Bench::normal_with(rflm, 0);
        (1..=3).for_each(|id| bench.deliver(frame(id)));
        bench.send(frame(4));
        bench.until("the overrun", |bench| bench.read(RF0R) == 3 | FULL | FOVR);
        let at = bench.now;
        assert_eq!(bench.stats().overruns, [Overrun { at, fifo: 0, lost: frame(lost) }]);
        bench.write(RF0R, FOVR);
        assert_eq!(bench.read(RF0R), 3 | FULL);
        assert_eq!(bench.drain(), kept);
    }
}

#[test]
fn a_frame_lost_in_a_full_fifo_was_acknowledged() {
    let mut bench = Bench::with(vec![Default::default()], RFLM, 0);
    (1..=5).for_each(|id| bench.deliver(frame(id)));
    assert_eq!(bench.wire.counters().ack_errors, 0);
    assert_eq!((bench.lec(), bench.drain()), (0, vec![1, 2, 3]));
}

#[test]
fn a_release_after_the_frame_does_not_save_it() {
    for (late, overruns) in [(true, 1), (false, 0)] {
        let mut bench = Bench::normal_with(RFLM, 0);
        (1..=3).for_each(|id| bench.deliver(frame(id)));
        bench.calm();
        let valid = bench.now + bits(EMPTY_BITS - 1);
        bench.send(empty());
        bench.pass(bits(EMPTY_BITS - 10));
        let release = if late { valid + bits(2) } else { Time(valid.0 - bits(2).0) };
        bench.write_at(release, RF0R, RFOM);
        bench.pass(bits(20));
        assert_eq!(bench.stats().overruns.len(), overruns);
        bench.deliver(frame(5));
        assert_eq!(
            bench.stats().overruns.len(),
            1,
            "late: the place was free by then; early: sync had taken it"
        );
    }
}

/// FMPIE, FFIE and FOVIE of FIFO 0; those of FIFO 1 are three higher.
#[test]
fn each_cause_drives_the_interrupt_of_its_fifo() {
    for (fifo, own, other) in [(0, RF0R, RF1R), (1, RF1R, RF0R)] {
        for (enable, frames) in [(1 << 1, 1), (1 << 2, 3), (1 << 3, 4)] {
            let mut bench = Bench::normal();
            bench.assign_to_fifo(fifo);
            bench.write(IER, enable << (3 * fifo));
            (1..frames).for_each(|id| bench.deliver(frame(id)));
            assert_eq!(bench.irq(), IrqLines::default());
            bench.deliver(frame(0x42));
            let pending = u32::from(frames.min(3));
            assert_eq!((bench.read(other), bench.read(own) & 0b11), (0, pending), "FIFO {fifo}");
            let raised = IrqLines { rx0: fifo == 0, rx1: fifo == 1, ..IrqLines::default() };
            assert_eq!(bench.irq(), raised, "FIFO {fifo}, {frames} frames");
            assert_eq!(bench.pair().irq(Side::Can2), IrqLines::default());
            bench.write(own, FULL | FOVR);
            (0..3).for_each(|_| bench.write(own, RFOM));
            assert_eq!((bench.read(own), bench.irq()), (0, IrqLines::default()), "FIFO {fifo}");
        }
    }
}

#[test]
fn fifo_1_shows_its_own_message() {
    let mut bench = Bench::normal();
    bench.assign_to_fifo(1);
    bench.deliver(frame(0x42));
    assert_eq!((bench.read(RIR1), bench.read(RIR0)), (0x42 << 21, 0));
}

/// The errata forbid TTCM: nothing is stamped, and no stamp is sent.
#[test]
fn ttcm_gives_no_stamps() {
    let mut bench = Bench::normal_with(TTCM, 0);
    bench.pass(Time::from_ms(1));
    bench.deliver(empty());
    assert_eq!(bench.read(RIR0 + 4) >> 16, 0, "TIME of what is received");
    bench.fill(0, [0x155 << 21 | 1, 8 | 1 << 8, 0x4433_2211, 0x8877_6655]);
    bench.complete(0);
    assert_eq!(bench.read(TIR0 + 4) >> 16, 0, "TIME of what is sent");
    let expected = WireFrame::standard(0x155, &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88]);
    assert_eq!(bench.received_by(PEER), [expected], "TGT replaces no data");
}
