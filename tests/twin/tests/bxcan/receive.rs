//! Receive FIFOs: RM0090 32.7.3, 32.7.5, 32.9.2 (RFxR), 32.9.3.

use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use twin::bxcan::{IrqLines, Overrun, Side};

use crate::bench::*;

const RFLM: u32 = 1 << 3;
const FULL: u32 = 1 << 3;
const FOVR: u32 = 1 << 4;
const RFOM: u32 = 1 << 5;

fn frame(id: u16) -> WireFrame {
    WireFrame::standard(id, &[])
}

/// Identifiers in FIFO 0, taken out one by one.
fn drain(bench: &mut Bench) -> Vec<u32> {
    let mut ids = Vec::new();
    while bench.read(RF0R) & 0b11 != 0 {
        ids.push(bench.read(RIR0) >> 21);
        bench.write(RF0R, RFOM);
    }
    ids
}

#[test]
fn the_output_mailbox_shows_the_frame() {
    let mut bench = Bench::normal();
    bench.received(WireFrame::standard(0x7FF, &[1, 2, 3, 4, 5, 6]));
    assert_eq!(bench.read(RIR0), 0x7FF << 21);
    assert_eq!(bench.read(RIR0 + 4), 6, "DLC 6, filter 0, TIME 0");
    assert_eq!(bench.read(RIR0 + 8), 0x0403_0201);
    assert_eq!(bench.read(RIR0 + 12), 0x0000_0605);
    bench.write(RF0R, RFOM);
    bench.received(WireFrame { id: WireId::Extended(0x1FFF_0001), remote: true, dlc: 3, data: [0; 8] });
    assert_eq!(bench.read(RIR0), 0x1FFF_0001 << 3 | 0b110);
    assert_eq!(bench.read(RIR0 + 4), 0, "DLC is 0 for a remote frame");
    bench.write(RF0R, RFOM);
    bench.received(WireFrame { dlc: 12, ..WireFrame::standard(1, &[9; 8]) });
    assert_eq!(bench.read(RIR0 + 4), 12, "DLC as received");
}

#[test]
fn three_messages_fill_the_fifo() {
    let mut bench = Bench::normal();
    for (n, expected) in [(1, 1), (2, 2), (3, 3 | FULL)] {
        bench.received(frame(n));
        assert_eq!(bench.read(RF0R), expected);
    }
    bench.write(RF0R, FULL);
    assert_eq!(bench.read(RF0R), 3, "FULL is cleared by software");
    assert_eq!(drain(&mut bench), [1, 2, 3]);
    bench.write(RF0R, RFOM);
    assert_eq!(bench.read(RF0R), 0, "releasing an empty FIFO has no effect");
    let stats = bench.pair.stats(Side::Can1);
    assert_eq!((stats.stored, stats.released), ([3, 0], [3, 0]));
}

#[test]
fn overrun_replaces_the_newest_or_drops_the_new() {
    for (rflm, kept, lost) in [(0, [1, 2, 4], 3), (RFLM, [1, 2, 3], 4)] {
        let mut bench = Bench::normal_with(rflm, 0);
        (1..=4).for_each(|id| bench.received(frame(id)));
        assert_eq!(bench.read(RF0R), 3 | FULL | FOVR);
        let at = bench.now;
        assert_eq!(bench.pair.stats(Side::Can1).overruns, [Overrun { at, fifo: 0, lost: frame(lost) }]);
        bench.write(RF0R, FOVR);
        assert_eq!(bench.read(RF0R), 3 | FULL);
        assert_eq!(drain(&mut bench), kept);
    }
}

#[test]
fn a_release_after_the_frame_does_not_save_it() {
    for (late, overruns) in [(true, 1), (false, 0)] {
        let mut bench = Bench::normal_with(RFLM, 0);
        (1..=3).for_each(|id| bench.received(frame(id)));
        let valid = bench.now + Time::from_us(10);
        bench.now += Time::from_us(if late { 15 } else { 5 });
        bench.write(RF0R, RFOM);
        bench.now = valid;
        bench.received(frame(4));
        assert_eq!(bench.pair.stats(Side::Can1).overruns.len(), overruns);
        bench.pass(Time::from_us(20));
        bench.received(frame(5));
        assert_eq!(bench.pair.stats(Side::Can1).overruns.len(), 1, "after the poll the place is free");
    }
}

#[test]
fn each_cause_drives_its_interrupt() {
    for (enable, frames) in [(1 << 1, 1), (1 << 2, 3), (1 << 3, 4)] {
        let mut bench = Bench::normal();
        bench.write(IER, enable);
        (1..frames).for_each(|id| bench.received(frame(id)));
        assert_eq!(bench.pair.irq(Side::Can1), IrqLines::default());
        bench.received(frame(9));
        assert_eq!(bench.pair.irq(Side::Can1), IrqLines { rx0: true, ..IrqLines::default() });
        assert_eq!(bench.pair.irq(Side::Can2), IrqLines::default());
    }
}

#[test]
fn fifo_1_has_its_own_registers_and_interrupt() {
    let mut bench = Bench::normal();
    bench.write(FMR, 1 | 14 << 8);
    bench.write(FFA1R, 1);
    bench.write(FMR, 14 << 8);
    bench.write(IER, 1 << 4);
    bench.received(frame(0x42));
    assert_eq!((bench.read(RF0R), bench.read(RF1R)), (0, 1));
    assert_eq!(bench.read(RIR1), 0x42 << 21);
    assert_eq!(bench.pair.irq(Side::Can1), IrqLines { rx1: true, ..IrqLines::default() });
    bench.write(RF1R, RFOM);
    assert_eq!(bench.read(RF1R), 0);
}
