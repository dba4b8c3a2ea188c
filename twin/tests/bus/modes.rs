//! Bus monitoring, single shot, foreign frames, arbitration, joining and leaving.

use can_twin::wire::bus::WireConfig;
use can_twin::wire::controller::{ErrorKind, Trace, WireEvent};
use can_twin::wire::fault::Fault;
use can_twin::wire::field::Field;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Destruction;
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use can_twin::wire::transceiver::Transceiver;
use proptest::prelude::*;

use crate::common::*;

/// Every completed frame.
fn done(bench: &mut Bench) -> Vec<Trace> {
    completed(&bench.wire.take_records()).into_iter().map(|(trace, ..)| trace).collect()
}

fn order(traces: &[Trace]) -> Vec<WireFrame> {
    traces.iter().map(|trace| trace.frame).collect()
}

#[test]
fn a_silent_node_receives_but_does_not_acknowledge() {
    let mut bench = Bench::together(vec![sending(SOF, sync()), silent()]);
    bench.leap(us(SOF + 41));
    assert_eq!(errors(&bench, 0), [(end_of(SOF, ACK_SLOT), transmit_error(ErrorKind::Ack))]);
    let mut bench = Bench::together(vec![sending(SOF, sync()), silent(), idle()]);
    bench.leap(us(100));
    assert_eq!(received(&bench, 1), [(us(SOF + 47), sync())]);
}

/// A silent node sends no error flag, so its error stays local. It sees its own flag as if it were on the line.
#[test]
fn a_silent_node_disturbs_nobody_with_its_errors() {
    let mut bench = Bench::together(vec![sending(SOF, sync()), silent(), idle()]);
    from_start(&mut bench, [flip_bit(4, &[1])]);
    bench.leap(us(200));
    assert_eq!(starts(&bench, 0), [us(SOF)]);
    assert_eq!(received(&bench, 2).len(), 1);
    assert_eq!(received(&bench, 1), []);
    assert_eq!(errors(&bench, 1)[0], (end_of(SOF, 5), receive_error(ErrorKind::Stuff)));
    // Flag of six bits: bits 6 to 11; the line itself was recessive at bit 10.
    assert!(bench.stations[1].line.iter().all(|&(at, _)| at <= us(SOF + 6) || at >= us(SOF + 12)));
}

#[test]
fn a_silent_node_never_starts_a_frame() {
    let mut bench = Bench::together(vec![silent().sending(us(SOF), sync()), idle()]);
    bench.leap(us(500));
    assert_eq!((starts(&bench, 0), received(&bench, 1)), (vec![], vec![]));
    assert!(bench.stations[1].told(WireEvent::Joined) == [us(11)]);
}

#[test]
fn single_shot_gives_up_after_an_error_or_a_lost_arbitration() {
    let shot = |at: u64, frame: WireFrame| {
        Station { single_shot: true, ..Station::default() }.sending(us(at), frame)
    };
    let mut bench = Bench::together(vec![shot(SOF, sync())]);
    bench.leap(us(500));
    assert_eq!(starts(&bench, 0), [us(SOF)]);
    assert_eq!(errors(&bench, 0).len(), 1);

    let mut bench = Bench::together(vec![shot(SOF, frame(0x100)), sending(SOF, sync())]);
    bench.leap(us(500));
    // 080h and 100h differ in bit 3 (000 1... against 001 0...): the third bit of the identifier.
    assert_eq!(bench.stations[0].told(WireEvent::ArbitrationLost), [us(SOF + 4)]);
    assert_eq!(starts(&bench, 0).len(), 1);
    assert_eq!(received(&bench, 0), [(us(SOF + 47), sync())]);
}

/// Frames that nodes of this project never send are acknowledged like any other.
#[test]
fn foreign_frames_are_acknowledged_and_disturb_nobody() {
    let extended = WireFrame { id: WireId::Extended(0x1ABC_DEF0), ..WireFrame::standard(0, &[1, 2, 3]) };
    let remote = WireFrame { remote: true, dlc: 4, ..frame(0x701) };
    let extended_remote = WireFrame { remote: true, data: [0; 8], ..extended };
    let mut sender = idle();
    sender.queue.extend([extended, remote, extended_remote].map(|frame| (us(SOF), frame)));
    let mut bench = Bench::together(vec![sender, idle(), idle()]);
    bench.leap(us(600));
    assert_eq!(sent(&bench, 0).len(), 3);
    for node in [1, 2] {
        assert_eq!(frames(&bench, node), [extended, remote, extended_remote]);
        assert_eq!((errors(&bench, node), counts(&bench, node)), (vec![], vec![]));
    }
}

/// A node takes part after 11 recessive bits: on a quiet bus that is 11 bits after its start, within traffic the end of
/// the intermission (ACK delimiter, EOF and intermission are 11 bits).
#[test]
fn joining_needs_11_recessive_bits() {
    let mut sender = sending(20, sync());
    sender.queue.push_back((us(20), frame(0x081)));
    let mut late = idle();
    late.attachment.as_mut().unwrap().since = us(25);
    let mut bench = Bench::together(vec![sender, idle(), late]);
    bench.leap(us(300));
    assert_eq!(bench.stations[1].told(WireEvent::Joined), [us(11)]);
    let joined = bench.stations[2].told(WireEvent::Joined)[0];
    // Its bits begin at an arbitrary phase and are synchronised with the first edge, to a quantum.
    assert!(joined.0.abs_diff(us(20 + 51).0) <= 16, "{joined:?}");
    assert_eq!(frames(&bench, 2), [frame(0x081)]);
    // 10 recessive bits are not sufficient: a request 10 bits after the start has to wait.
    let mut bench = Bench::together(vec![sending(10, sync()), idle()]);
    bench.leap(us(100));
    assert_eq!(starts(&bench, 0), [us(11)]);
}

#[test]
fn a_transmitter_that_leaves_takes_its_frame_along() {
    let mut bench = Bench::together(vec![sending(SOF, sync()), sending(27, frame(0x700))]);
    bench.leap(us(SOF + 15));
    bench.stations[0].attachment = None;
    bench.leap(us(150));
    assert_eq!((sent(&bench, 0), received(&bench, 1)), (vec![], vec![]));
    // Bits 11 to 14 are dominant, then the line is recessive: the sixth such bit is bit 20.
    assert_eq!(errors(&bench, 1)[0], (end_of(SOF, 20), receive_error(ErrorKind::Stuff)));
    let (cause, at, transmitter, _) = destroyed(&bench.wire.take_records()).unwrap();
    assert_eq!((cause, at, transmitter), (Destruction::TransmitterLeft, us(SOF + 15), 0));
    // Alone now: flag, delimiter, intermission, and no acknowledgement. 0 11100000 (1) 000 0 0 0 0000 ...: up to the
    // ACK slot, the bits of the frame but for ACK delimiter and EOF.
    let second = SOF + 21 + 6 + 8 + 3;
    let up_to_ack = can_twin::wire::encode::encode(&frame(0x700)).bits().len() as u64 - 8;
    assert_eq!(starts(&bench, 1), [us(second), us(second + up_to_ack + 6 + 8 + 3)]);
}

#[test]
fn a_receiver_that_leaves_is_not_missed_by_others() {
    let mut bench = disturbed(2, [], SOF + 15);
    bench.stations[1].attachment = None;
    bench.leap(us(200));
    assert_eq!((received(&bench, 1).len(), received(&bench, 2).len()), (0, 1));
    assert_eq!(starts(&bench, 0).len(), 1);
}

/// A power cycle clears the error counters, leaving the bus does not.
#[test]
fn error_counters_survive_leaving_and_not_a_power_cycle() {
    let mut bench = disturbed(0, [], 300);
    let count = tec(&bench, 0);
    assert!(count > 0);
    let attachment = bench.stations[0].attachment.take();
    bench.leap(us(400));
    bench.stations[0].attachment = attachment;
    bench.stations[0].queue.clear();
    bench.leap(us(500));
    assert_eq!(tec(&bench, 0), count);
    bench.stations[0].attachment.as_mut().unwrap().power_cycle += 1;
    bench.leap(us(600));
    assert_eq!(tec(&bench, 0), 0);
}

#[test]
fn propagation_delays_the_receiver_by_5_ns_per_metre() {
    let stations = vec![(10.0, sending(SOF, sync())), (50.0, listener()), (0.0, listener())];
    let mut bench = Bench::new(WireConfig::default(), stations);
    bench.leap(us(100));
    // 40 m are 200 ns = 67.2 ticks; 10 m are 50 ns = 16.8 ticks. Instants are rounded down to a tick.
    assert_eq!(bench.stations[1].line[0], (us(SOF) + Time(67), false));
    assert_eq!(bench.stations[2].line[0], (us(SOF) + Time(16), false));
    assert_eq!((bench.wire.delay(0, 1), bench.wire.delay(1, 0)), (Time(67), Time(67)));
}

/// Each node's driver delays its sent levels and its receiver the received levels, its own included. The cable adds its
/// delay.
#[test]
fn transceivers_delay_by_node_and_direction() {
    let transceiver = |driver_ns, receiver_ns| Transceiver { driver_ns, receiver_ns };
    for bit_by_bit in [false, true] {
        let stations = vec![
            (10.0, transceiver(70, 85), listener().sending(us(SOF), sync())),
            (50.0, transceiver(80, 65), listener()),
            (10.0, transceiver(0, 0), listener()),
        ];
        let config = WireConfig { bit_by_bit, ..WireConfig::default() };
        let mut bench = Bench::with_transceivers(config, stations);
        bench.leap(us(100));
        // 70 + 85 ns; 70 + 200 + 65 ns; 70 ns: 52.08, 112.56 and 23.52 ticks. Instants are rounded down to a tick.
        let first = |node: usize| bench.stations[node].line[0];
        assert_eq!([0, 1, 2].map(first), [52, 112, 23].map(|ticks| (us(SOF) + Time(ticks), false)));
        assert_eq!([(0, 0), (0, 1), (1, 0)].map(|(from, to)| bench.wire.delay(from, to).0), [52, 113, 123]);
        assert_eq!((sent(&bench, 0).len(), received(&bench, 1).len()), (1, 1));
    }
}

#[test]
fn equal_identifiers_with_other_data_end_in_an_error_frame() {
    let sending = |data: u8| sending(SOF, WireFrame::standard(0x181, &[data]));
    let mut bench = Bench::together(vec![sending(0x80), sending(0x00), idle()]);
    bench.leap(us(SOF + 40));
    // 0 00110000001 0 0 0 0001: stuff bits after the first five zeros of the identifier's six, and after RTR to the
    // second DLC bit. 19 + 2 bits up to the data, whose first bit differs.
    assert_eq!(errors(&bench, 0)[0], (end_of(SOF, 21), transmit_error(ErrorKind::BitRecessive)));
    assert_eq!((sent(&bench, 0), sent(&bench, 1)), (vec![], vec![]));
}

#[test]
fn equal_frames_are_sent_as_one() {
    let both = || sending(SOF, sync());
    let mut bench = Bench::together(vec![both(), both(), idle()]);
    bench.leap(us(200));
    assert_eq!((sent(&bench, 0), sent(&bench, 1)), (vec![us(SOF + 48)], vec![us(SOF + 48)]));
    assert_eq!(received(&bench, 2).len(), 1);
    let mut bench = Bench::together(vec![both(), both()]);
    bench.leap(us(SOF + 41));
    assert_eq!(errors(&bench, 0), [(end_of(SOF, ACK_SLOT), transmit_error(ErrorKind::Ack))]);
}

/// A node whose frame waits when it sees a SOF takes part with its first identifier bit; a later one waits.
#[test]
fn a_request_before_the_sof_contends_a_later_one_waits() {
    let mut bench = Bench::new(
        WireConfig::default(),
        vec![
            (0.0, sending(SOF, frame(0x100))),
            // Its request comes while the SOF is on its way, 100 ns = 33.6 ticks.
            (20.0, idle().sending(us(SOF) + Time(30), sync())),
            (0.0, sending(SOF + 1, frame(0x001))),
        ],
    );
    bench.leap(us(400));
    assert_eq!(order(&done(&mut bench)), [sync(), frame(0x001), frame(0x100)]);
}

/// A dominant third bit of intermission is a SOF: a node with a waiting frame joins without sending a SOF. Its clock is
/// early by the delay of the other node.
#[test]
fn who_waits_joins_a_frame_that_began_in_its_intermission() {
    let fast = can_twin::wire::timing::BitTiming::MEGABIT.fast_by(5_000_000);
    let mut early = Station::with_timing(fast).sending(us(SOF), sync());
    early.queue.push_back((us(SOF), frame(0x300)));
    let slow = can_twin::wire::timing::BitTiming::MEGABIT.fast_by(-5_000_000);
    let late = Station::with_timing(slow).sending(us(SOF + 10), frame(0x081));
    let mut bench = Bench::together(vec![early, late, idle()]);
    bench.leap(us(400));
    assert_eq!(order(&done(&mut bench)), [sync(), frame(0x081), frame(0x300)], "the slow one still won");
    assert_eq!(bench.wire.counters().destroyed, 0);
}

#[test]
fn an_idle_wire_has_no_events() {
    let bench = disturbed(1, [], 200);
    assert_eq!(bench.wire.next_event(), None);
    assert!(bench.wire.is_idle(0) && bench.wire.is_idle(1));
}

/// Given a node whose frame waits, when its power goes off within a frame, then it loses its state.
#[test]
fn a_node_without_power_loses_what_it_knew() {
    let mut bench = sender_and(2);
    from_start(&mut bench, [flip_field(Field::Eof(2), &[1])]);
    schedule(&mut bench, SOF + 60, Fault::PowerOff(1));
    schedule(&mut bench, SOF + 70, Fault::PowerOn(1));
    bench.leap(us(SOF + 59));
    assert!(rec(&bench, 1) > 0);
    bench.leap(us(SOF + 72));
    assert_eq!((tec(&bench, 1), rec(&bench, 1)), (0, 0));
}

/// Distinct identifiers, requests and places of a few nodes.
fn contenders() -> impl Strategy<Value = Vec<(u16, u64, f64)>> {
    let ids = prop::collection::hash_set(0u16..=0x7FF, 2..8);
    ids.prop_flat_map(|ids| {
        let mut ids: Vec<u16> = ids.into_iter().collect();
        ids.sort_unstable();
        let requests = prop::collection::vec((4000u64..336 * 400, 0.0..40.0f64), ids.len());
        (Just(ids).prop_shuffle(), requests).prop_map(|(ids, rest)| {
            ids.into_iter().zip(rest).map(|(id, (at, place))| (id, at, place)).collect()
        })
    })
}

fn bench_of(contenders: &[(u16, u64, f64)]) -> Bench {
    let station = |&(id, at, place): &(u16, u64, f64)| {
        (place, idle().sending(Time(at), WireFrame::standard(id, &[id as u8])))
    };
    Bench::new(WireConfig::default(), contenders.iter().map(station).collect())
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn those_that_ask_together_are_served_by_rising_identifier(mut contenders in contenders()) {
        for contender in &mut contenders {
            (contender.1, contender.2) = (us(SOF).0, 0.0);
        }
        let mut bench = bench_of(&contenders);
        bench.leap(us(2000));
        let done = done(&mut bench);
        contenders.sort_unstable_by_key(|contender| contender.0);
        let expected: Vec<WireFrame> =
            contenders.iter().map(|&(id, ..)| WireFrame::standard(id, &[id as u8])).collect();
        prop_assert_eq!(order(&done), expected);
        // Back to back: 3 bits of intermission, within the quantum by which synchronisation shifts clocks of equal
        // speed.
        for pair in done.windows(2) {
            prop_assert!(pair[1].start.0.abs_diff((pair[0].end + us(3)).0) <= 16);
        }
    }

    #[test]
    fn every_frame_reaches_everybody_once_and_frames_never_overlap(contenders in contenders()) {
        let mut bench = bench_of(&contenders);
        bench.leap(us(3000));
        let done = done(&mut bench);
        prop_assert_eq!(done.len(), contenders.len());
        for pair in done.windows(2) {
            prop_assert!(pair[1].start > pair[0].end + us(2));
        }
        for node in 0..contenders.len() {
            prop_assert_eq!(received(&bench, node).len(), contenders.len() - 1);
            prop_assert_eq!(sent(&bench, node).len(), 1);
            prop_assert_eq!(errors(&bench, node), vec![]);
        }
    }

    #[test]
    fn the_length_of_the_quantum_changes_nothing(contenders in contenders()) {
        let runs = [1, 5, 20].map(|quantum| {
            let mut bench = bench_of(&contenders);
            bench.run(us(3000), us(quantum));
            let logs: Vec<_> = bench.stations.iter().map(|station| station.log.clone()).collect();
            (logs, bench.wire.take_records(), bench.wire.counters())
        });
        prop_assert_eq!(&runs[0], &runs[1]);
        prop_assert_eq!(&runs[0], &runs[2]);
    }
}
