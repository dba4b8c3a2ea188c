//! Transmit mailboxes: RM0090 32.7.1, 32.9.2 (TSR), 32.9.3.

use can_twin::wire::fault::Fault;
use can_twin::wire::field::Field;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;

use super::bench::*;

/// Identifiers that PEER has received.
fn heard(bench: &Bench) -> Vec<WireId> {
    bench.received_by(PEER).iter().map(|frame| frame.id).collect()
}

fn standard(ids: &[u16]) -> Vec<WireId> {
    ids.iter().map(|&id| WireId::Standard(id)).collect()
}

#[test]
fn a_mailbox_becomes_the_frame_that_it_describes() {
    let mut bench = Bench::normal();
    bench.fill(0, [0x155 << 21 | 1, 5, 0x4433_2211, 0x8877_6655]);
    bench.fill(1, [0x1234_5678 << 3 | 0b111, 15, 0, 0]);
    bench.fill(2, [0x1234_5679 << 3 | 0b101, 2, 0xFFFF_2211, 0]);
    (0..3).for_each(|n| bench.complete(n));
    let extended = |id| WireId::Extended(id);
    let expected = [
        WireFrame::standard(0x155, &[0x11, 0x22, 0x33, 0x44, 0x55]),
        WireFrame { id: extended(0x1234_5678), remote: true, dlc: 15, data: [0; 8] },
        WireFrame { id: extended(0x1234_5679), ..WireFrame::standard(0, &[0x11, 0x22]) },
    ];
    // 1234 5678h begins with 48Dh.
    assert_eq!(bench.received_by(PEER), expected);
}

#[test]
fn a_dlc_beyond_eight_sends_eight_bytes() {
    for dlc in 9..=15 {
        let mut bench = Bench::normal();
        bench.fill(0, [0x155 << 21 | 1, dlc, 0x4433_2211, 0x8877_6655]);
        bench.complete(0);
        let bytes = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
        assert_eq!(
            bench.received_by(PEER),
            [WireFrame { dlc: dlc as u8, ..WireFrame::standard(0x155, &bytes) }]
        );
    }
}

#[test]
fn success_sets_rqcp_and_txok_and_empties_the_mailbox() {
    let mut bench = Bench::normal();
    bench.write(IER, 1);
    bench.request(0, 0x100);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), 0);
    assert_eq!(bench.read(TIR0) & 1, 1, "TXRQ");
    bench.pass(bits(20));
    assert!(!bench.irq().tx);
    bench.complete(0);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), TME0 | RQCP | TXOK);
    assert_eq!(bench.read(TIR0) & 1, 0, "TXRQ cleared by hardware");
    assert!(bench.irq().tx);
    bench.write(TSR, RQCP);
    assert_eq!(bench.read(TSR) & STATUS, 0, "clearing RQCP clears all");
    assert!(!bench.irq().tx);
}

#[test]
fn each_mailbox_has_its_own_status() {
    for n in 0..3 {
        let mut bench = Bench::normal();
        bench.request(n, 0x100);
        assert_eq!(bench.read(TSR) >> 26 & 0b111, 0b111 & !(1 << n));
        bench.complete(n);
        assert_eq!(bench.read(TSR) & 0x00FF_FFFF, (RQCP | TXOK) << (8 * n));
        bench.write(TSR, RQCP << (8 * n));
        assert_eq!(bench.read(TSR), 0x1C00_0000);
    }
}

#[test]
fn a_frame_is_sent_at_the_last_bit_of_eof() {
    let mut bench = Bench::normal();
    bench.request(0, 0x080);
    bench.pass(Time(bits(EMPTY_BITS).0 - 1));
    assert_eq!(bench.received_by(PEER), [empty()], "valid one bit earlier for receivers");
    assert_eq!(bench.status(0), 0);
    bench.pass(Time(1));
    assert_eq!(bench.status(0), RQCP | TXOK);
}

#[test]
fn an_error_in_the_last_bit_of_eof_sends_the_frame_twice() {
    let mut bench = Bench::normal();
    bench.flip(CAN1, Field::Eof(6));
    bench.request(0, 0x080);
    bench.pass(bits(EMPTY_BITS));
    assert_eq!((bench.status(0), bench.tec()), (TERR, 8));
    bench.complete(0);
    assert_eq!(bench.received_by(PEER), [empty(), empty()]);
}

#[test]
fn a_new_request_clears_the_old_result() {
    let mut bench = Bench::normal();
    bench.transmit(0x100);
    bench.request(0, 0x100);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), 0);
}

#[test]
fn lowest_identifier_goes_first_then_lowest_mailbox() {
    let mut bench = Bench::normal();
    bench.request(0, 0x300);
    bench.request(1, 0x100);
    bench.request(2, 0x100);
    for n in [1, 2, 0] {
        bench.until("the next mailbox", |bench| bench.read(TSR) >> 26 & 0b111 != 0);
        assert_eq!(bench.read(TSR) >> 26 & 0b111, 1 << n, "mailbox {n} went");
        // Out of the way: it waits behind all others.
        bench.request(n, 0x700);
    }
    assert_eq!(heard(&bench), standard(&[0x100, 0x100, 0x300]));
}

#[test]
fn standard_data_frame_beats_remote_and_extended_of_same_base() {
    let mut bench = Bench::normal();
    bench.write(TIR0, 0x100 << 21 | 0b101);
    bench.write(TIR0 + 16, 0x100 << 21 | 0b011);
    bench.write(TIR0 + 32, 0x100 << 21 | 0b001);
    (0..3).for_each(|n| bench.complete(n));
    let order = bench
        .received_by(PEER)
        .into_iter()
        .map(|frame| (matches!(frame.id, WireId::Extended(_)), frame.remote));
    assert_eq!(order.collect::<Vec<_>>(), [(false, false), (false, true), (true, false)]);
}

#[test]
fn txfp_goes_by_request_order() {
    let mut bench = Bench::normal_with(TXFP, 0);
    bench.request(2, 0x300);
    bench.request(0, 0x200);
    bench.request(1, 0x100);
    (0..3).for_each(|n| bench.complete(n));
    assert_eq!(heard(&bench), standard(&[0x300, 0x200, 0x100]));
}

#[test]
fn txfp_keeps_the_order_after_a_lost_arbitration() {
    let mut bench = Bench::normal_with(TXFP, 0);
    bench.request(2, 0x300);
    bench.send(empty());
    bench.until("ALST", |bench| bench.status(2) & ALST != 0);
    bench.transmit(0x100);
    assert_eq!(heard(&bench), standard(&[0x300, 0x100]));
}

#[test]
fn code_and_low_name_the_next_free_and_the_lowest_priority() {
    let mut bench = Bench::normal();
    bench.occupy();
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
    bench.occupy();
    bench.request(0, 0x100);
    for word in [0, 4, 8, 12] {
        bench.write(TIR0 + word, 0xFFFF_FFFF);
    }
    assert_eq!(bench.stats().ignored_writes, 4);
    bench.complete(0);
    assert_eq!(bench.received_by(PEER), [frame(0x100)]);
}

#[test]
fn a_lost_arbitration_is_retried() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.send(empty());
    bench.until("ALST", |bench| bench.status(0) & ALST != 0);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), ALST, "pending again");
    assert_eq!(bench.tec(), 0, "no error");
    bench.complete(0);
    assert_eq!(bench.status(0), RQCP | TXOK, "the flags tell of the latest attempt");
    assert_eq!(heard(&bench), standard(&[0x100]));
    assert_eq!(bench.read(RIR0), 0x080 << 21, "the loser received the winner's frame");
}

#[test]
fn an_error_is_retried() {
    let mut bench = Bench::normal();
    bench.request(0, 0x100);
    bench.fail_attempt();
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), TERR, "pending again");
    bench.complete(0);
    assert_eq!(bench.status(0), RQCP | TXOK, "the flags tell of the latest attempt");
    assert_eq!(heard(&bench), standard(&[0x100]));
}

#[test]
fn single_shot_gives_up_after_a_lost_arbitration() {
    let mut bench = Bench::normal_with(NART, 0);
    bench.request(0, 0x100);
    bench.send(empty());
    bench.complete(0);
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), TME0 | RQCP | ALST);
    bench.calm();
    assert_eq!(heard(&bench), []);
}

#[test]
fn single_shot_gives_up_after_an_error() {
    let mut bench = Bench::normal_with(NART, 0);
    bench.request(0, 0x100);
    bench.fail_attempt();
    assert_eq!(bench.read(TSR) & (TME0 | STATUS), TME0 | RQCP | TERR);
    bench.calm();
    assert_eq!(heard(&bench), []);
    // A missing acknowledgement is an error, too.
    let mut bench = Bench::with(vec![], NART, 0);
    bench.transmit(0x100);
    assert_eq!((bench.status(0), bench.lec(), bench.tec()), (RQCP | TERR, 3, 8));
}

#[test]
fn single_shot_succeeds_like_any_other() {
    let mut bench = Bench::normal_with(NART, 0);
    bench.transmit(0x100);
    assert_eq!(bench.status(0), RQCP | TXOK);
}

#[test]
fn a_higher_priority_request_overtakes_between_attempts() {
    let mut bench = Bench::normal();
    bench.request(0, 0x200);
    bench.send(empty());
    bench.until("ALST", |bench| bench.status(0) & ALST != 0);
    bench.request(1, 0x100);
    bench.complete(0);
    assert_eq!(heard(&bench), standard(&[0x100, 0x200]));
}

#[test]
fn only_what_was_requested_by_then_contends() {
    let mut bench = Bench::normal();
    let start = bench.now;
    bench.request_at(start + Time::from_us(3), 0, 0x200);
    bench.request_at(start + Time::from_us(7), 1, 0x100);
    bench.complete(1);
    assert_eq!(heard(&bench), standard(&[0x200, 0x100]), "the first had begun");
    let frames: Vec<Time> = bench
        .wire
        .take_records()
        .iter()
        .filter_map(|record| match record {
            can_twin::wire::record::Observation::Completed { trace, .. } => Some(trace.start),
            _ => None,
        })
        .collect();
    assert_eq!(frames[0], start + Time::from_us(3));
}

#[test]
fn a_request_before_synchronisation_waits_for_it() {
    let mut bench = Bench::initialising(vec![Default::default()], 0);
    bench.request(0, 0x080);
    bench.pass(bits(50));
    bench.write(MCR, 0);
    bench.changes_after(bits(11 + EMPTY_BITS), |bench| bench.status(0), 0, RQCP | TXOK);
}

/// An error passive transmitter waits 8 bits more (ISO 11898-1, 10.4.6): another node sends first.
#[test]
fn a_passive_transmitter_lets_others_go_first() {
    for (failures, order) in [(15, [0x100, 0x200]), (17, [0x200, 0x100])] {
        let mut bench = Bench::normal();
        bench.request(0, 0x080);
        (0..failures).for_each(|_| bench.fail_attempt());
        bench.until("the repetition", |bench| bench.read(TIR0) & 1 == 0);
        bench.request(0, 0x100);
        bench.send(frame(0x200));
        bench.until("both", |bench| bench.received_by(OTHER).len() == 3);
        let last: Vec<_> = bench.received_by(OTHER)[1..].iter().map(|frame| frame.id).collect();
        assert_eq!(last, standard(&order), "after {failures} errors");
    }
}

#[test]
fn both_controllers_arbitrate_on_one_bus() {
    let mut bench = Bench::normal();
    bench.start_can2();
    bench.request(0, 0x200);
    bench.write(BASE2 + TIR0 + 4, 0);
    bench.write(BASE2 + TIR0, 0x100 << 21 | 1);
    bench.complete(0);
    assert_eq!(heard(&bench), standard(&[0x100, 0x200]));
    assert_eq!(bench.read(BASE2 + TSR) & STATUS, RQCP | TXOK);
}

#[test]
fn the_only_node_that_hears_acknowledges() {
    let mut bench = Bench::normal();
    bench.fault(Fault::Disconnect(OTHER));
    bench.deliver(empty());
    assert_eq!(bench.wire.counters().ack_errors, 0);
    assert_eq!(bench.read(RF0R), 1);
}
