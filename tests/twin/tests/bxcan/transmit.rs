//! Transmit mailboxes: RM0090 32.7.1, 32.9.2 (TSR), 32.9.3.

use can_wire::controller::{Controller, ErrorKind, WireEvent};
use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use twin::bxcan::Side;

use crate::bench::*;

const NART: u32 = 1 << 4;
const TXFP: u32 = 1 << 2;
/// RQCP, TXOK, ALST and TERR of mailbox 0.
const STATUS0: u32 = 0xF;
const RQCP: u32 = 1;
const TXOK: u32 = 2;
const ALST: u32 = 4;
const TERR: u32 = 8;
const ABRQ0: u32 = 1 << 7;
const TME0: u32 = 1 << 26;

fn contending_id(bench: &mut Bench) -> Option<WireId> {
    bench.contends().map(|frame| frame.id)
}

#[test]
fn a_mailbox_becomes_the_frame_that_it_describes() {
    let mut bench = Bench::normal();
    bench.write(TIR0 + 4, 5);
    bench.write(TIR0 + 8, 0x4433_2211);
    bench.write(TIR0 + 12, 0x8877_6655);
    bench.write(TIR0, 0x155 << 21 | 1);
    let expected = WireFrame::standard(0x155, &[0x11, 0x22, 0x33, 0x44, 0x55]);
    assert_eq!(bench.contends(), Some(expected));
    bench.started();
    bench.write(TIR0 + 16 + 4, 15);
    bench.write(TIR0 + 16, 0x1234_5678 << 3 | 0b111);
    let (id, data) = (WireId::Extended(0x1234_5678), [0; 8]);
    assert_eq!(bench.contends(), Some(WireFrame { id, remote: true, dlc: 15, data }));
}

#[test]
fn success_sets_rqcp_and_txok_and_empties_the_mailbox() {
    let mut bench = Bench::normal();
    bench.write(IER, 1);
    bench.request(0, 0x100);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS0), 0);
    assert_eq!(bench.read(TIR0) & 1, 1, "TXRQ");
    bench.started();
    assert!(!bench.pair.irq(Side::Can1).tx);
    bench.transmitted();
    assert_eq!(bench.read(TSR) & (TME0 | STATUS0), TME0 | RQCP | TXOK);
    assert_eq!(bench.read(TIR0) & 1, 0, "TXRQ cleared by hardware");
    assert!(bench.pair.irq(Side::Can1).tx);
    bench.write(TSR, RQCP);
    assert_eq!(bench.read(TSR) & STATUS0, 0, "clearing RQCP clears all");
    assert!(!bench.pair.irq(Side::Can1).tx);
}

#[test]
fn a_new_request_clears_the_old_result() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.started();
    bench.transmitted();
    bench.request(0, 0x100);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS0), 0);
}

#[test]
fn lowest_identifier_goes_first_then_lowest_mailbox() {
    let mut bench = Bench::normal();
    bench.request(0, 0x300);
    bench.request(1, 0x100);
    bench.request(2, 0x100);
    for (n, id) in [(1, 0x100), (2, 0x100), (0, 0x300)] {
        assert_eq!(contending_id(&mut bench), Some(WireId::Standard(id)));
        bench.started();
        bench.transmitted();
        assert_eq!(bench.read(TSR) >> (26 + n) & 1, 1, "mailbox {n} went");
    }
}

#[test]
fn a_standard_data_frame_beats_remote_and_extended_of_the_same_base() {
    let mut bench = Bench::normal();
    bench.write(TIR0, 0x100 << 21 | 0b101);
    bench.write(TIR0 + 16, 0x100 << 21 | 0b011);
    bench.write(TIR0 + 32, 0x100 << 21 | 0b001);
    let order = std::iter::from_fn(|| {
        let frame = bench.contends()?;
        bench.started();
        bench.transmitted();
        Some((matches!(frame.id, WireId::Extended(_)), frame.remote))
    });
    assert_eq!(order.collect::<Vec<_>>(), [(false, false), (false, true), (true, false)]);
}

#[test]
fn txfp_goes_by_request_order() {
    let mut bench = Bench::normal_with(TXFP, 0);
    bench.request(2, 0x300);
    bench.request(0, 0x200);
    bench.request(1, 0x100);
    for id in [0x300, 0x200, 0x100] {
        assert_eq!(contending_id(&mut bench), Some(WireId::Standard(id)));
        bench.started();
        bench.transmitted();
    }
}

#[test]
fn code_and_low_name_the_next_free_and_the_lowest_priority() {
    let mut bench = Bench::normal();
    let code = |bench: &Bench| bench.read(TSR) >> 24 & 0b11;
    let low = |bench: &Bench| bench.read(TSR) >> 29;
    assert_eq!((code(&bench), low(&bench)), (0, 0));
    bench.request(0, 0x100);
    assert_eq!((code(&bench), low(&bench)), (1, 0), "LOW is zero with one mailbox pending");
    bench.request(1, 0x300);
    assert_eq!((code(&bench), low(&bench)), (2, 0b010));
    bench.request(2, 0x200);
    assert_eq!((code(&bench), low(&bench)), (1, 0b010), "all pending: CODE is the lowest priority");
}

#[test]
fn an_occupied_mailbox_is_write_protected() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    for word in [0, 4, 8, 12] {
        bench.write(TIR0 + word, 0xFFFF_FFFF);
    }
    assert_eq!(bench.contends(), Some(WireFrame::standard(0x100, &[])));
    assert_eq!(bench.pair.stats(Side::Can1).ignored_writes, 4);
}

#[test]
fn failures_are_retried_unless_single_shot() {
    for (event, flag) in
        [(WireEvent::ArbitrationLost, ALST), (WireEvent::TransmitError(ErrorKind::BitDominant), TERR)]
    {
        let mut bench = Bench::normal();
        bench.request(0, 0x100);
        bench.started();
        bench.event(event.clone());
        assert_eq!(bench.read(TSR) & (TME0 | RQCP | TXOK | flag), flag, "pending again");
        assert!(bench.contends().is_some());
        bench.started();
        bench.transmitted();
        assert_eq!(bench.read(TSR) & STATUS0, RQCP | TXOK, "the flags tell of the latest attempt");

        let mut bench = Bench::normal_with(NART, 0);
        bench.request(0, 0x100);
        bench.started();
        bench.event(event);
        assert_eq!(bench.read(TSR) & (TME0 | STATUS0), TME0 | RQCP | flag, "one attempt only");
    }
}

#[test]
fn a_higher_priority_request_overtakes_between_attempts() {
    let mut bench = Bench::normal();
    bench.request(0, 0x200);
    bench.started();
    bench.request(1, 0x100);
    bench.event(WireEvent::ArbitrationLost);
    assert_eq!(contending_id(&mut bench), Some(WireId::Standard(0x100)));
}

#[test]
fn a_pending_request_is_aborted_at_once() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.now += Time(1);
    bench.write(TSR, ABRQ0);
    assert!(bench.contends().is_none());
    bench.pass(Time(1));
    assert_eq!(bench.read(TSR) & (TME0 | ABRQ0 | STATUS0), TME0 | RQCP, "completed, not TXOK");
    assert_eq!(bench.pair.stats(Side::Can1).aborted, 1);
}

#[test]
fn an_abort_on_the_wire_waits_for_the_end() {
    for success in [true, false] {
        let mut bench = Bench::normal();
        bench.request(0, 0x100);
        bench.started();
        bench.pass(Time(1));
        bench.write(TSR, ABRQ0);
        bench.pass(Time(1));
        assert_eq!(bench.read(TSR) & (TME0 | ABRQ0 | STATUS0), ABRQ0);
        if success {
            bench.transmitted()
        } else {
            bench.transmit_error(ErrorKind::Ack)
        }
        let result = if success { TXOK } else { TERR };
        assert_eq!(bench.read(TSR) & (TME0 | ABRQ0 | STATUS0), TME0 | RQCP | result);
        assert_eq!(bench.pair.stats(Side::Can1).aborted, u64::from(!success));
    }
}

#[test]
fn an_abort_counts_from_its_own_instant() {
    // The CPU has run to 20 µs, the wire follows.
    let mut bench = Bench::normal();
    let start = bench.now;
    bench.request(0, 0x100);
    bench.now = start + Time::from_us(10);
    bench.write(TSR, ABRQ0);
    bench.now = start + Time::from_us(20);

    let mut started_before = Bench { pair: bench.pair.clone(), now: start + Time::from_us(9) };
    assert!(started_before.contends().is_some());
    started_before.started();
    started_before.now = bench.now;
    started_before.pair.poll(bench.now);
    assert_eq!(started_before.read(TSR) & TME0, 0, "on the wire: waits for the end");

    assert!(bench.pair.line(Side::Can1).contend(start + Time::from_us(10)).is_none());
    bench.pair.poll(bench.now);
    assert_eq!(bench.read(TSR) & TME0, TME0);
}

#[test]
fn an_abort_without_a_request_has_no_effect() {
    let mut bench = Bench::normal();
    bench.write(TSR, ABRQ0);
    bench.pass(Time(1));
    assert_eq!(bench.read(TSR), 0x1C00_0000);
}

#[test]
fn only_what_was_requested_by_then_contends() {
    let mut bench = Bench::normal();
    let start = bench.now;
    bench.now = start + Time::from_us(3);
    bench.request(0, 0x200);
    bench.now = start + Time::from_us(7);
    bench.request(1, 0x100);
    let line = bench.pair.line(Side::Can1);
    assert_eq!(line.request_at(), Some(start + Time::from_us(3)));
    assert_eq!(line.contend(start + Time::from_us(2)), None);
    assert_eq!(line.contend(start + Time::from_us(3)), Some(WireFrame::standard(0x200, &[])));
    assert_eq!(line.contend(start + Time::from_us(7)), Some(WireFrame::standard(0x100, &[])));
}

#[test]
fn a_request_before_synchronisation_waits_for_it() {
    let mut bench = Bench::initialising(0);
    bench.request(0, 0x100);
    bench.write(MCR, 0);
    assert_eq!(bench.pair.line(Side::Can1).request_at(), None);
    bench.pass(Time::from_us(20));
    assert_eq!(bench.pair.line(Side::Can1).request_at(), Some(Time(11 * BIT)));
}
