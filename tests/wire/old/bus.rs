//! Arbitration, ACK, spacing, timing on one whole cable.

mod common;

use can_wire::controller::ErrorKind;
use can_wire::frame::WireFrame;
use can_wire::record::{Destruction, Record};
use can_wire::time::Time;
use common::*;
use proptest::prelude::*;

fn frame(id: u16) -> WireFrame {
    WireFrame::standard(id, &[])
}

/// Start and end of every completed frame, with its identifier's frame.
fn completed(world: &mut World) -> Vec<(Time, Time, WireFrame)> {
    let records = world.wire.take_records();
    let traces = records.iter().filter_map(|record| match record {
        Record::Completed { trace, .. } => Some((trace.start, trace.end, trace.frame)),
        _ => None,
    });
    traces.collect()
}

#[test]
fn a_frame_starts_at_its_request_and_ends_after_48_bits() {
    let mut world = World::together(vec![Script::sending(Time(1001), frame(0x080)), Script::new()]);
    world.run(us(100), us(20));
    let end = Time(1001) + bits(48);
    assert_eq!(world.node(0).log[0], (Time(1001), Told::Started));
    assert_eq!(world.node(0).sent(), [(end, frame(0x080))]);
    // Valid for receivers at the last but one bit of EOF.
    assert_eq!(world.node(1).got(), [(Time(1001) + bits(47), frame(0x080))]);
    assert_eq!(completed(&mut world), [(Time(1001), end, frame(0x080))]);
    assert_eq!(world.wire.counters().busy, bits(51));
}

#[test]
fn propagation_delays_the_receiver_by_5_ns_per_metre() {
    let mut world = World::new(vec![
        (10.0, Script::sending(us(5), frame(0x080))),
        (50.0, Script::new()),
        (0.0, Script::new()),
    ]);
    world.run(us(100), us(20));
    // 40 m are 200 ns, 67.2 ticks; 10 m are 50 ns, 16.8 ticks.
    assert_eq!(world.node(1).got(), [(us(52) + Time(67), frame(0x080))]);
    assert_eq!(world.node(2).got(), [(us(52) + Time(17), frame(0x080))]);
    assert_eq!((world.wire.delay(0, 1), world.wire.delay(1, 0)), (Time(67), Time(67)));
    assert_eq!(world.node(0).sent(), [(us(53), frame(0x080))]);
}

#[test]
fn a_receiver_that_waits_starts_when_the_end_has_reached_it() {
    let mut world = World::new(vec![
        (0.0, Script::sending(us(5), frame(0x080))),
        (40.0, Script::sending(us(10), frame(0x100))),
    ]);
    world.run(us(200), us(20));
    let starts: Vec<Time> = completed(&mut world).into_iter().map(|(start, ..)| start).collect();
    assert_eq!(starts, [us(5), us(5) + bits(51) + Time(67)]);
}

#[test]
fn nobody_acknowledges_a_lone_transmitter() {
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080))]);
    world.run(us(130), us(20));
    // 38 stuffed bits, CRC delimiter, ACK slot: bit 40. Flag 6, delimiter 8, intermission 3: the next SOF is 57 bits
    // after the first.
    let errors: Vec<(Time, Told)> = [45, 102].map(|at| (us(at), Told::TxError(ErrorKind::Ack))).into();
    assert_eq!(world.node(0).errors(), errors);
    let starts: Vec<Time> =
        world.node(0).log.iter().filter(|(_, told)| *told == Told::Started).map(|&(at, _)| at).collect();
    assert_eq!(starts, [us(5), us(62), us(119)]);
    assert_eq!(world.wire.counters().ack_errors, 2);
    assert_eq!(world.wire.counters().completed, 0);
    let records = world.wire.take_records();
    assert!(
        matches!(records[0], Record::Destroyed { cause: Destruction::Unacknowledged, at, .. } if at == us(45))
    );
}

#[test]
fn an_error_passive_transmitter_waits_8_bits_more() {
    let mut lone = Script::sending(us(5), frame(0x080));
    lone.passive = true;
    let mut world = World::together(vec![lone]);
    world.run(us(130), us(20));
    let errors: Vec<Time> = world.node(0).errors().into_iter().map(|(at, _)| at).collect();
    assert_eq!(errors, [us(45), us(110)]);

    let mut passive = Script::sending(us(5), frame(0x080));
    passive.passive = true;
    passive.queue.push((us(5), frame(0x081)));
    let mut world = World::together(vec![passive, Script::sending(us(6), frame(0x700))]);
    world.run(us(400), us(20));
    let order: Vec<WireFrame> = completed(&mut world).into_iter().map(|(.., frame)| frame).collect();
    assert_eq!(order, [frame(0x080), frame(0x700), frame(0x081)], "700h slips into the suspended time");
}

#[test]
fn silent_and_absent_controllers_do_not_acknowledge() {
    let mut silent = Script::new();
    silent.acknowledges = false;
    let mut absent = Script::new();
    absent.bit = None;
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), silent, absent]);
    world.run(us(60), us(20));
    assert_eq!(world.node(0).errors(), [(us(45), Told::TxError(ErrorKind::Ack))]);
    assert_eq!(world.node(1).got(), []);
    assert_eq!(world.node(2).log, []);
}

#[test]
fn a_silent_controller_receives_what_others_acknowledge() {
    let mut silent = Script::new();
    silent.acknowledges = false;
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), silent, Script::new()]);
    world.run(us(60), us(20));
    assert_eq!(world.node(1).got().len(), 1);
}

#[test]
fn other_bit_rates_do_not_understand() {
    let mut slow = Script::new();
    slow.bit = Some(Time(672)); // 500 kbit/s
    let mut close = Script::new();
    close.bit = Some(Time(339)); // 0.9 % longer
    let mut far = Script::new();
    far.bit = Some(Time(340)); // 1.2 % longer
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), slow, far]);
    world.run(us(60), us(20));
    assert_eq!(world.node(0).errors(), [(us(45), Told::TxError(ErrorKind::Ack))]);
    for node in [1, 2] {
        assert_eq!(world.node(node).errors(), [(us(45), Told::RxError(ErrorKind::Form))]);
        assert_eq!(world.node(node).got(), []);
    }
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), close]);
    world.run(us(60), us(20));
    assert_eq!(world.node(1).got().len(), 1);
}

#[test]
fn contenders_of_different_bit_rates_destroy_each_other() {
    let mut slow = Script::sending(us(5), frame(0x100));
    slow.bit = Some(Time(672));
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), slow]);
    world.run(us(20), us(20));
    for node in [0, 1] {
        assert_eq!(world.node(node).errors(), [(us(17), Told::TxError(ErrorKind::BitRecessive))]);
    }
    assert_eq!(world.wire.counters().destroyed, 1);
}

#[test]
fn equal_identifiers_with_other_data_end_in_an_error_frame() {
    let one = Script::sending(us(5), WireFrame::standard(0x181, &[0x80]));
    let other = Script::sending(us(5), WireFrame::standard(0x181, &[0x00]));
    let mut world = World::together(vec![one, other, Script::new()]);
    world.run(us(45), us(20));
    // 0 00110000001 0 0 0 0001 | data: stuff bits after the first five zeros of the identifier's six, and after RTR to
    // the second DLC bit: 19 + 2 bits up to the data, whose first bit differs.
    let at = us(5) + bits(22);
    for node in [0, 1] {
        assert_eq!(world.node(node).errors(), [(at, Told::TxError(ErrorKind::BitRecessive))]);
        assert_eq!(world.node(node).sent(), []);
    }
    assert_eq!(world.node(2).errors(), [(at + bits(6), Told::RxError(ErrorKind::Stuff))]);
}

#[test]
fn equal_frames_are_sent_as_one() {
    let both = || Script::sending(us(5), frame(0x080));
    let mut world = World::together(vec![both(), both(), Script::new()]);
    world.run(us(200), us(20));
    assert_eq!(world.node(0).sent(), [(us(53), frame(0x080))]);
    assert_eq!(world.node(1).sent(), [(us(53), frame(0x080))]);
    assert_eq!(world.node(2).got().len(), 1);
    let mut world = World::together(vec![both(), both()]);
    world.run(us(50), us(20));
    assert_eq!(world.node(0).errors(), [(us(45), Told::TxError(ErrorKind::Ack))]);
}

#[test]
fn a_request_within_the_sof_contends_a_later_one_waits() {
    let mut world = World::together(vec![
        Script::sending(us(5), frame(0x100)),
        Script::sending(us(5) + Time(300), frame(0x080)),
        Script::sending(us(6), frame(0x001)),
    ]);
    world.run(us(300), us(20));
    let order: Vec<WireFrame> = completed(&mut world).into_iter().map(|(.., frame)| frame).collect();
    assert_eq!(order, [frame(0x080), frame(0x001), frame(0x100)]);
    // 100h and 080h differ in the third bit of the identifier, and no stuff bit comes before it.
    assert_eq!(world.node(0).log[1], (us(5) + bits(4), Told::Lost));
}

#[test]
fn a_transmitter_that_leaves_takes_its_frame_along() {
    let mut leaving = Script::sending(us(5), frame(0x080));
    leaving.leaves_at = us(20);
    let mut world = World::together(vec![leaving, Script::sending(us(12), frame(0x700))]);
    // A wire sees it when it is advanced, so stop there.
    world.run(us(20), us(5));
    world.run(us(60), us(20));
    assert_eq!(world.node(0).sent(), []);
    assert_eq!(world.node(1).got(), []);
    assert_eq!(world.node(1).errors(), [(us(26), Told::RxError(ErrorKind::Stuff))]);
    assert_eq!(world.wire.counters().destroyed, 1);
    let records = world.wire.take_records();
    assert!(matches!(
        records[0],
        Record::Destroyed { cause: Destruction::TransmitterLeft, at, transmitter: 0, .. } if at == us(20)
    ));
    // Alone now: 700h starts after flag, delimiter and intermission, and nobody acknowledges it.
    let second = us(26) + bits(6 + 8 + 3);
    assert!(world.node(1).log.contains(&(second, Told::Started)));
}

#[test]
fn who_joins_in_the_middle_of_a_frame_gets_the_next_one() {
    let mut sender = Script::sending(us(5), frame(0x080));
    sender.queue.push((us(5), frame(0x081)));
    let mut joining = Script::new();
    joining.joins_at = us(20);
    let mut world = World::together(vec![sender, Script::new(), joining]);
    world.run(us(200), us(5));
    let got: Vec<WireFrame> = world.node(2).got().into_iter().map(|(_, frame)| frame).collect();
    assert_eq!(got, [frame(0x081)]);
}

#[test]
fn the_line_is_idle_from_the_end_of_the_last_dominant_bit() {
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), Script::new()]);
    world.run(us(4), us(20));
    assert_eq!(world.wire.idle_since(1), Some(Time::ZERO));
    world.run(us(30), us(20));
    assert_eq!(world.wire.idle_since(1), None);
    // ACK slot ends 40 bits after SOF.
    for now in [45, 50, 53, 56, 300] {
        world.run(us(now), us(20));
        assert_eq!(world.wire.idle_since(1), Some(us(45)), "at {now} us");
    }
}

#[test]
fn an_error_flag_is_dominant_unless_passive() {
    for (passive, idle) in [(false, None), (true, Some(us(43)))] {
        let mut lone = Script::sending(us(5), frame(0x080));
        lone.passive = passive;
        let mut world = World::together(vec![lone]);
        world.run(us(47), us(20));
        assert_eq!(world.wire.idle_since(0), idle);
        world.run(us(52), us(20));
        assert_eq!(world.wire.idle_since(0), idle.or(Some(us(51))));
    }
}

#[test]
fn an_idle_wire_has_no_events() {
    let mut world = World::together(vec![Script::sending(us(5), frame(0x080)), Script::new()]);
    world.run(us(200), us(20));
    assert_eq!(world.wire.next_event(), None);
}

/// Distinct identifiers, requests and places of a few nodes.
fn contenders() -> impl Strategy<Value = Vec<(u16, u64, f64)>> {
    let ids = proptest::collection::hash_set(0u16..=0x7FF, 2..8);
    ids.prop_flat_map(|ids| {
        let mut ids: Vec<u16> = ids.into_iter().collect();
        ids.sort_unstable();
        let requests = proptest::collection::vec((0u64..336 * 400, 0.0..40.0f64), ids.len());
        (Just(ids).prop_shuffle(), requests).prop_map(|(ids, rest)| {
            ids.into_iter().zip(rest).map(|(id, (at, place))| (id, at, place)).collect()
        })
    })
}

fn world_of(contenders: &[(u16, u64, f64)]) -> World {
    let script = |&(id, at, place): &(u16, u64, f64)| {
        (place, Script::sending(Time(at), WireFrame::standard(id, &[id as u8])))
    };
    World::new(contenders.iter().map(script).collect())
}

proptest! {
    #[test]
    fn those_that_ask_together_are_served_by_rising_identifier(mut contenders in contenders()) {
        for contender in &mut contenders {
            contender.1 = 1000;
            contender.2 = 0.0;
        }
        let mut world = world_of(&contenders);
        world.run(us(2000), us(20));
        let done = completed(&mut world);
        let order: Vec<WireFrame> = done.iter().map(|&(.., frame)| frame).collect();
        contenders.sort_unstable_by_key(|contender| contender.0);
        let expected: Vec<WireFrame> =
            contenders.iter().map(|&(id, ..)| WireFrame::standard(id, &[id as u8])).collect();
        prop_assert_eq!(order, expected);
        // Back to back: 3 bits of intermission.
        for pair in done.windows(2) {
            prop_assert_eq!(pair[1].0, pair[0].1 + bits(3));
        }
    }

    #[test]
    fn every_frame_reaches_everybody_once_and_frames_never_overlap(contenders in contenders()) {
        let mut world = world_of(&contenders);
        world.run(us(3000), us(20));
        let done = completed(&mut world);
        prop_assert_eq!(done.len(), contenders.len());
        for pair in done.windows(2) {
            prop_assert!(pair[1].0 >= pair[0].1 + bits(3));
        }
        for (node, contender) in contenders.iter().enumerate() {
            prop_assert_eq!(world.node(node).got().len(), contenders.len() - 1);
            prop_assert_eq!(world.node(node).sent().len(), 1);
            let own = WireFrame::standard(contender.0, &[contender.0 as u8]);
            // Who asks within another's SOF sends as if that SOF was its own.
            let on_time =
                done.iter().all(|&(start, _, frame)| frame != own || start + BIT > Time(contender.1));
            prop_assert!(on_time);
        }
    }

    #[test]
    fn the_length_of_the_quantum_changes_nothing(contenders in contenders()) {
        let logs = [1, 5, 20].map(|quantum| {
            let mut world = world_of(&contenders);
            world.run(us(3000), us(quantum));
            let logs: Vec<_> = world.scripts.0.iter().map(|script| script.log.clone()).collect();
            (logs, world.wire.take_records(), world.wire.counters())
        });
        prop_assert_eq!(&logs[0], &logs[1]);
        prop_assert_eq!(&logs[0], &logs[2]);
    }
}
