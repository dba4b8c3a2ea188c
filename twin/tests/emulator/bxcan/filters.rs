//! Acceptance filters: RM0090 32.7.4, 32.9.4.

use can_twin::wire::frame::{WireFrame, WireId};

use super::bench::*;

/// Filters of CAN1, set bank by bank.
struct Filters {
    bench: Bench,
    fm1r: u32,
    fs1r: u32,
    ffa1r: u32,
    fa1r: u32,
}

const LIST: u32 = 1;
const MASK: u32 = 0;
const WIDE: u32 = 1;
const HALF: u32 = 0;

impl Filters {
    fn none() -> Self {
        let mut bench = Bench::normal();
        bench.write(FMR, 1 | 28 << 8);
        Filters { bench, fm1r: 0, fs1r: 0, ffa1r: 0, fa1r: 0 }
    }

    fn bank(mut self, n: u32, fifo: u32, mode: u32, scale: u32, words: [u32; 2]) -> Self {
        self.fm1r |= mode << n;
        self.fs1r |= scale << n;
        self.ffa1r |= fifo << n;
        self.fa1r |= 1 << n;
        self.bench.write(BANKS + 8 * n, words[0]);
        self.bench.write(BANKS + 8 * n + 4, words[1]);
        self
    }

    fn inactive(mut self, n: u32) -> Self {
        self.fa1r &= !(1 << n);
        self
    }

    /// Activates with CAN2's banks from `can2sb` on.
    fn done(mut self, can2sb: u32) -> Bench {
        let registers = [(FM1R, self.fm1r), (FS1R, self.fs1r), (FFA1R, self.ffa1r), (FA1R, self.fa1r)];
        registers.iter().for_each(|&(register, value)| self.bench.write(register, value));
        self.bench.write(FMR, can2sb << 8);
        self.bench
    }
}

/// Returns the FIFO of CAN1 that stored the frame, and its filter match index.
fn admitted(bench: &mut Bench, sent: WireFrame) -> Option<(usize, u32)> {
    bench.deliver(sent);
    for (fifo, (rfr, rir)) in [(RF0R, RIR0), (RF1R, RIR1)].into_iter().enumerate() {
        if bench.read(rfr) & 0b11 != 0 {
            let index = bench.read(rir + 4) >> 8 & 0xFF;
            bench.write(rfr, 1 << 5);
            return Some((fifo, index));
        }
    }
    None
}

fn wide(id: u32) -> u32 {
    id << 21
}

fn half(id: u32) -> u32 {
    id << 5
}

/// Filter that matches no frame of these tests.
const NO: u32 = 0x7FF << 5 | 0x7FF << 21;

#[test]
fn no_active_bank_admits_nothing() {
    let mut bench = Filters::none().done(28);
    assert_eq!(admitted(&mut bench, frame(1)), None);
    assert_eq!(bench.stats().rejected, 1);
}

#[test]
fn each_scale_and_mode_compares_its_bits() {
    let mut bench = Filters::none()
        .bank(0, 0, LIST, WIDE, [wide(0x100), 0x1234_5678 << 3 | 0b100])
        .bank(1, 0, MASK, WIDE, [wide(0x200), wide(0x7F0) | 0b110])
        .bank(2, 0, LIST, HALF, [half(0x300) | half(0x301) << 16, half(0x302) | half(0x303) << 16])
        .bank(3, 0, MASK, HALF, [half(0x400) | (half(0x7F0) | 0x18) << 16, half(0x500) | half(0x7FF) << 16])
        .done(28);
    let extended = |id| WireFrame { id: WireId::Extended(id), ..frame(0) };
    let remote = |id| WireFrame { remote: true, ..frame(id) };
    let cases = [
        (frame(0x100), Some(0)),
        (remote(0x100), None),
        (extended(0x1234_5678), Some(1)),
        (extended(0x1234_5679), None),
        (frame(0x20F), Some(2)),
        (frame(0x210), None),
        (remote(0x200), None),
        (frame(0x300), Some(3)),
        (frame(0x301), Some(4)),
        (frame(0x302), Some(5)),
        (frame(0x303), Some(6)),
        (frame(0x304), None),
        (frame(0x40A), Some(7)),
        (remote(0x400), None),
        (frame(0x500), Some(8)),
        // Filter 8's mask leaves RTR, IDE and the extension open.
        (remote(0x500), Some(8)),
        (extended(0x500 << 18 | 0x2_0000), Some(8)),
        (frame(0x501), None),
    ];
    for (sent, index) in cases {
        assert_eq!(admitted(&mut bench, sent), index.map(|index| (0, index)), "{sent:?}");
    }
}

/// The manual's own example, "Example of filter numbering".
#[test]
fn numbers_count_per_fifo_and_include_inactive_banks() {
    // Bank, FIFO, mode, scale, and where the frame that this bank alone admits goes. Banks 5, 7 and 10 are inactive.
    let rows = [
        (0, 0, LIST, WIDE, Some((0, 0))),
        (1, 0, MASK, WIDE, Some((0, 2))),
        (2, 1, MASK, HALF, Some((1, 0))),
        (3, 0, LIST, HALF, Some((0, 3))),
        (4, 1, LIST, WIDE, Some((1, 2))),
        (5, 0, LIST, WIDE, None),
        (6, 0, MASK, HALF, Some((0, 9))),
        (7, 1, MASK, HALF, None),
        (8, 1, MASK, HALF, Some((1, 6))),
        (9, 0, LIST, WIDE, Some((0, 11))),
        (10, 1, LIST, HALF, None),
        (11, 1, LIST, WIDE, Some((1, 12))),
        (12, 1, MASK, WIDE, Some((1, 14))),
        (13, 0, MASK, WIDE, Some((0, 13))),
    ];
    for (bank, .., expected) in rows {
        let filters = rows.into_iter().fold(Filters::none(), |filters, (n, fifo, mode, scale, _)| {
            let words = match scale {
                _ if n != bank => [NO, NO],
                WIDE => [wide(0x055), 0xFFFF_FFFE],
                _ => [half(0x055) | 0xFFFF << 16, NO],
            };
            filters.bank(n, fifo, mode, scale, words)
        });
        let mut bench = filters.inactive(5).inactive(7).inactive(10).done(28);
        assert_eq!(admitted(&mut bench, frame(0x055)), expected, "bank {bank}");
    }
}

#[test]
fn wide_goes_before_half_list_before_mask_then_the_lower_number() {
    let id = 0x155;
    let all = || {
        Filters::none()
            .bank(0, 0, MASK, HALF, [half(id) | 0xFFFF << 16, NO])
            .bank(1, 1, LIST, HALF, [half(id), NO])
            .bank(2, 0, MASK, WIDE, [wide(id), 0xFFFF_FFFE])
            .bank(3, 1, LIST, WIDE, [NO, wide(id)])
            .bank(4, 1, LIST, WIDE, [wide(id), wide(id)])
    };
    let sent = frame(0x155);
    // FIFO 1: bank 1 holds 0..=3, bank 3 4 and 5, bank 4 6 and 7. FIFO 0: bank 0 holds 0 and 1, bank 2 has 2.
    assert_eq!(admitted(&mut all().done(28), sent), Some((1, 5)));
    assert_eq!(admitted(&mut all().inactive(3).done(28), sent), Some((1, 6)));
    assert_eq!(admitted(&mut all().inactive(3).inactive(4).done(28), sent), Some((0, 2)));
    assert_eq!(admitted(&mut all().inactive(3).inactive(4).inactive(2).done(28), sent), Some((1, 0)));
}

#[test]
fn can2sb_splits_the_banks() {
    let build = |can2sb| {
        Filters::none()
            .bank(0, 0, MASK, WIDE, [wide(0x100), 0xFFFF_FFFE])
            .bank(14, 0, MASK, WIDE, [wide(0x200), 0xFFFF_FFFE])
            .done(can2sb)
    };
    let mut bench = build(14);
    assert_eq!(admitted(&mut bench, frame(0x100)), Some((0, 0)));
    assert_eq!(admitted(&mut bench, frame(0x200)), None);
    bench.start_can2();
    [0x100, 0x200].into_iter().for_each(|id| bench.deliver(frame(id)));
    assert_eq!(bench.read(BASE2 + RF0R), 1);
    assert_eq!(bench.read(BASE2 + RIR0), wide(0x200));
    // Bank 0 holds one filter, the 13 idle banks after it (16-bit mask at reset) two each.
    assert_eq!(admitted(&mut build(28), frame(0x200)), Some((0, 1 + 13 * 2)), "28: all to CAN1");
    assert_eq!(admitted(&mut build(0), frame(0x100)), None, "0: none to CAN1");
}

#[test]
fn finit_stops_reception() {
    let mut bench = Bench::normal();
    bench.write(FMR, 1 | 14 << 8);
    assert_eq!(admitted(&mut bench, frame(1)), None);
    bench.write(FMR, 14 << 8);
    assert_eq!(admitted(&mut bench, frame(1)), Some((0, 0)));
}

/// Given FINIT that is set and cleared while a frame is on the wire, the frame is acknowledged and lost, and the next one is
/// received.
#[test]
fn finit_in_the_middle_of_a_frame_loses_it() {
    for (set, clear, received) in [(10, 20, 0), (0, 3, 0), (1, 45, 0), (60, 70, 1)] {
        let mut bench = Bench::normal();
        bench.send(empty());
        bench.pass(bits(set));
        bench.write(FMR, 1 | 14 << 8);
        bench.pass(bits(clear - set));
        bench.write(FMR, 14 << 8);
        bench.pass(bits(100 - clear));
        assert_eq!(bench.read(RF0R) & 0b11, received, "FINIT from bit {set} to bit {clear}");
        assert_eq!(bench.wire.counters().ack_errors, 0);
        assert_eq!(admitted(&mut bench, frame(1)), Some((0, 0)));
    }
}

#[test]
fn filter_registers_are_protected() {
    let mut bench = Bench::normal();
    for register in [FM1R, FFA1R, BANKS] {
        bench.write(register, 0xFFFF_FFFF);
        assert_eq!(bench.read(register), 0, "{register:X}h");
    }
    assert_eq!(bench.stats().ignored_writes, 3);
    bench.write(BANKS + 8, 0x1234_5678);
    assert_eq!(bench.read(BANKS + 8), 0x1234_5678, "an inactive bank is writable");
    bench.write(FMR, 1);
    bench.write(BANKS, 0x1234_5678);
    assert_eq!(bench.read(BANKS), 0x1234_5678, "and every bank with FINIT");
    bench.write(FM1R, 0xFFFF_FFFF);
    assert_eq!(bench.read(FM1R), 0x0FFF_FFFF, "28 banks");
}

#[test]
fn a_frame_that_no_filter_admits_is_acknowledged() {
    let mut bench = Bench::with(vec![can_twin::wire::station::Station::default()], 0, 0);
    bench.write(FA1R, 0);
    let foreign = WireFrame { id: WireId::Extended(0x1234_5678), remote: true, ..frame(0) };
    for sent in [frame(0x123), foreign] {
        bench.deliver(sent);
    }
    assert_eq!((bench.stats().rejected, bench.wire.counters().ack_errors), (2, 0));
    assert_eq!(bench.read(ESR), 0);
}

#[test]
fn a_bank_takes_and_gives_up_its_part_while_the_bus_runs() {
    let mut bench = Bench::normal();
    bench.write(FA1R, 0);
    assert_eq!(admitted(&mut bench, frame(1)), None);
    bench.write(FA1R, 1);
    assert_eq!(admitted(&mut bench, frame(1)), Some((0, 0)));
}
