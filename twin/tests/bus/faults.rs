//! The effect of every fault, and the refusal of impossible faults with the reason.

use can_twin::wire::bus::WireConfig;
use can_twin::wire::controller::{ErrorKind, WireEvent};
use can_twin::wire::encode::encode;
use can_twin::wire::fault::{Effect, Fault, FaultError, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::{Destruction, Observation};
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use proptest::prelude::*;

use crate::common::*;

/// Returns a bench with two nodes on the left (0 m, 1 m) and two on the right (11 m, 12 m).
fn four(stations: [Station; 4]) -> Bench {
    Bench::new(WireConfig::default(), [0.0, 1.0, 11.0, 12.0].into_iter().zip(stations).collect())
}

/// Returns four nodes that send 100h, 200h, 300h and 400h at these ticks.
fn four_requesting(requests: &[u64]) -> Bench {
    let stations = requests.iter().zip(1..).map(|(&at, n)| idle().sending(Time(at), frame(0x100 * n)));
    four(stations.collect::<Vec<_>>().try_into().expect("four requests"))
}

/// The levels that `node` has seen on its line, one after the other.
fn levels(bench: &Bench, node: usize) -> Vec<bool> {
    bench.stations[node].line.iter().map(|&(_, level)| level).collect()
}

#[test]
fn what_cannot_be_is_refused_with_the_reason() {
    let mut bench = disturbed(1, [], 10);
    let mut refused = |at: u64, fault: Fault| {
        bench.wire.schedule(us(at), fault).expect_err(&format!("{fault:?} has to be refused"))
    };
    let infinite = f64::INFINITY;
    let flip = |field| Fault::Flip(Flip::new(Place::Field(field), Nodes::ALL));
    let glitch = Fault::Glitch { nodes: Nodes::ALL, duration: Time::ZERO, effect: Effect::Invert };
    let text = "a position on a cable is a finite number of metres from 0 on, not";
    for (fault, metres, shown) in [
        (Fault::Cut { position_m: -1.0 }, -1.0, "-1"),
        (Fault::Restore { position_m: infinite }, infinite, "inf"),
        (Fault::Short { position_m: -0.5, level: true }, -0.5, "-0.5"),
    ] {
        let got = refused(20, fault);
        assert_eq!((got, got.to_string()), (FaultError::Position(metres), format!("{text} {shown}")));
    }
    for (fault, error, text) in [
        (
            Fault::Drift(0, -1_000_000_000),
            FaultError::Drift(-1_000_000_000),
            "an oscillator cannot be -1000000000 ppb off: more than -1 000 000 000 is possible",
        ),
        (glitch, FaultError::NoDuration, "a disturbance lasts at least one tick of 1/336 us"),
        (
            Fault::BitErrors { rate: 1.5, seed: 0 },
            FaultError::Rate(1.5),
            "a bit error rate lies between 0 and 1, not at 1.5",
        ),
        (flip(Field::Eof(7)), FaultError::Place(Place::Field(Field::Eof(7))), "no bit is at Field(Eof(7))"),
        (flip(Field::Idle), FaultError::Place(Place::Field(Field::Idle)), "no bit is at Field(Idle)"),
        (flip_bit(160, &[0]), FaultError::Place(Place::Bit(160)), "no bit is at Bit(160)"),
    ] {
        let got = refused(20, fault);
        assert_eq!((got, got.to_string().as_str()), (error, text));
    }
    assert!(matches!(refused(20, Fault::Cut { position_m: f64::NAN }), FaultError::Position(_)));
    assert!(matches!(refused(20, Fault::BitErrors { rate: f64::NAN, seed: 0 }), FaultError::Rate(_)));
    for field in [
        Field::Identifier(11),
        Field::Extension(18),
        Field::Reserved(2),
        Field::Dlc(4),
        Field::Data(64),
        Field::Crc(15),
        Field::Intermission(3),
        Field::Suspend(8),
        Field::OverloadFlag(6),
        Field::Delimiter(0),
        Field::Delimiter(8),
    ] {
        assert_eq!(refused(20, flip(field)), FaultError::Place(Place::Field(field)));
    }
    let of_node = [
        Fault::Disconnect(2),
        Fault::Reconnect(2),
        Fault::PowerOff(2),
        Fault::PowerOn(2),
        Fault::StuckDominant(2),
        Fault::ReleaseDriver(2),
        Fault::Babble(2, sync()),
        Fault::StopBabbling(2),
        Fault::Drift(2, 0),
    ];
    for fault in of_node {
        let got = refused(20, fault);
        assert_eq!(got, FaultError::Node { node: 2, count: 2 });
        assert_eq!(got.to_string(), "there is no node 2: the wire has 2, counted from 0");
    }
    let past = refused(5, Fault::RestoreAll);
    assert_eq!(past, FaultError::Past { at: us(5), now: us(10) });
    assert_eq!(past.to_string(), "Time(1680) has passed: it is Time(3360)");
    // No refused fault has an effect.
    bench.leap(us(100));
    assert_eq!(received(&bench, 1).len(), 1);
    assert!(!bench.wire.take_records().iter().any(|record| matches!(record, Observation::Fault { .. })));
}

#[test]
fn each_piece_of_a_cut_cable_is_a_bus_of_its_own() {
    let mut bench = four([sending(SOF, sync()), idle(), sending(SOF, frame(0x100)), idle()]);
    bench.wire.cut(6.0);
    bench.leap(us(100));
    assert_eq!((frames(&bench, 1), frames(&bench, 3)), (vec![sync()], vec![frame(0x100)]));
    let records = bench.wire.take_records();
    let mut pieces = completed(&records);
    pieces.sort_by_key(|&(.., segment)| segment);
    let pieces = pieces.into_iter().map(|(trace, receivers, segment)| (trace.frame, receivers, segment));
    assert!(pieces.eq([(sync(), vec![1], 0), (frame(0x100), vec![3], 1)]));
}

#[test]
fn cut_off_transmitter_gets_no_acknowledgement_until_cut_heals() {
    let mut bench = four([sending(SOF, sync()), idle(), idle(), idle()]);
    bench.wire.cut(0.5);
    schedule(&mut bench, 1000, Fault::Restore { position_m: 0.5 });
    bench.leap(us(999));
    assert!(bench.wire.counters().ack_errors > 10);
    bench.leap(us(1200));
    assert_eq!((sent(&bench, 0).len(), received(&bench, 3).len()), (1, 1));
}

#[test]
fn a_node_at_the_cut_belongs_to_the_right_piece() {
    let mut bench =
        Bench::new(WireConfig::default(), vec![(0.0, sending(SOF, sync())), (6.0, idle()), (9.0, idle())]);
    bench.wire.cut(6.0);
    bench.leap(us(100));
    assert_eq!(errors(&bench, 0)[0].1, transmit_error(ErrorKind::Ack));
    assert_eq!(frames(&bench, 1), []);
}

/// The line has been dominant since bit 11 when the cut comes; from bit 15 on it is recessive there, and the sixth recessive bit breaks the stuffing rule on the far side.
#[test]
fn a_cut_within_a_frame_leaves_it_to_its_own_side() {
    let mut bench = four([sending(SOF, sync()), idle(), idle(), idle()]);
    schedule(&mut bench, SOF + 15, Fault::Cut { position_m: 6.0 });
    bench.leap(us(200));
    assert_eq!(sent(&bench, 0), [us(SOF + 48)]);
    assert_eq!(frames(&bench, 1), [sync()]);
    for node in [2, 3] {
        assert_eq!(frames(&bench, node), []);
        let (at, event) = errors(&bench, node)[0];
        assert_eq!((event, at.as_us()), (receive_error(ErrorKind::Stuff), SOF + 21), "node {node}");
    }
    let cut = Observation::Fault { at: us(SOF + 15), fault: Fault::Cut { position_m: 6.0 } };
    assert!(bench.wire.take_records().contains(&cut));
}

#[test]
fn cut_after_the_acknowledgement_and_its_healing_harm_no_node() {
    let mut bench = four([idle(), idle(), idle(), sending(SOF, sync())]);
    schedule(&mut bench, SOF + 43, Fault::Cut { position_m: 6.0 });
    schedule(&mut bench, SOF + 45, Fault::RestoreAll);
    bench.leap(us(200));
    assert_eq!(sent(&bench, 3).len(), 1);
    for node in [0, 1, 2] {
        assert_eq!((frames(&bench, node).len(), errors(&bench, node).len()), (1, 0));
    }
}

#[test]
fn frames_on_both_sides_destroy_each_other_when_the_cut_heals() {
    let mut bench = four([sending(20, sync()), idle(), sending(25, frame(0x100)), idle()]);
    bench.wire.cut(6.0);
    schedule(&mut bench, 45, Fault::RestoreAll);
    bench.leap(us(60));
    assert_eq!((sent(&bench, 0), sent(&bench, 2)), (vec![], vec![]));
    assert_eq!(bench.wire.counters().destroyed, 2);
    // Both try again, and each frame arrives once.
    bench.leap(us(400));
    for node in [1, 3] {
        let mut got = frames(&bench, node);
        got.sort_by_key(|frame| frame == &sync());
        assert_eq!(got, [frame(0x100), sync()]);
    }
}

#[test]
fn cutting_twice_and_healing_what_is_whole_change_nothing() {
    let mut bench = four([sending(SOF, sync()), idle(), idle(), idle()]);
    bench.wire.cut(6.0);
    bench.wire.cut(6.0);
    bench.wire.restore(3.0);
    bench.wire.restore(6.0);
    bench.leap(us(100));
    assert_eq!(frames(&bench, 3), [sync()]);
    bench.wire.cut(6.0);
    bench.wire.restore_all();
    send(&mut bench, 0, 100, [sync()]);
    bench.leap(us(200));
    assert_eq!(frames(&bench, 3).len(), 2);
}

/// A short shows on its own piece of the cable only.
#[test]
fn a_short_holds_its_piece_at_a_level() {
    for level in [true, false] {
        let mut bench = four([sending(SOF, sync()), idle(), sending(SOF, sync()), idle()]);
        bench.wire.cut(6.0);
        schedule(&mut bench, 15, Fault::Short { position_m: 8.0, level });
        schedule(&mut bench, 3000, Fault::ClearShorts);
        bench.leap(us(2999));
        assert_eq!((sent(&bench, 0).len(), sent(&bench, 2).len()), (1, 0));
        assert_eq!(frames(&bench, 3), []);
        bench.leap(Time::from_ms(10));
        assert_eq!((frames(&bench, 1).len(), frames(&bench, 3).len()), (1, 1));
    }
}

/// Recessive: a transmitter misses its SOF, then every bit of its active flags, and 16 bits later it is error passive.
/// Each try after that costs it 8 more, until bus-off.
#[test]
fn a_recessive_short_drives_a_transmitter_to_bus_off() {
    let mut bench = four([sending(SOF, sync()), idle(), idle(), idle()]);
    schedule(&mut bench, 15, Fault::Short { position_m: 8.0, level: true });
    bench.leap(us(1000));
    assert_eq!(errors(&bench, 0)[0], (us(SOF + 1), transmit_error(ErrorKind::BitDominant)));
    assert_eq!(counts(&bench, 0)[0], (us(SOF + 1), 8, 0));
    assert_eq!(tec(&bench, 0), 256);
    // Bit errors in active flags: one per bit, 16 in a row, up to error passive.
    assert_eq!(counts(&bench, 0)[15], (us(SOF + 16), 128, 0));
}

/// Dominant: receivers see six dominant bits, count 9 for the first after their flag and 8 for every eighth, and stay
/// error passive. Nodes that do not transmit are not bus-off.
#[test]
fn a_dominant_short_makes_receivers_error_passive() {
    let mut bench = four([idle(), idle(), idle(), idle()]);
    schedule(&mut bench, 20, Fault::Short { position_m: 8.0, level: false });
    bench.leap(Time::from_ms(1));
    for node in 0..4 {
        // SOF and five more bits, then the flag, then rules b and f.
        let told = counts(&bench, node);
        let times: Vec<u64> = told.iter().take(4).map(|&(at, ..)| at.as_us()).collect();
        let values: Vec<u16> = told.iter().take(4).map(|&(.., receive)| receive).collect();
        assert_eq!((times, values), (vec![26, 33, 40, 48], vec![1, 9, 17, 25]));
        assert_eq!((tec(&bench, node), rec(&bench, node)), (0, 255));
    }
}

#[test]
fn a_disconnected_node_hears_and_is_heard_by_nobody() {
    let mut bench = four([sending(SOF, sync()), idle(), sending(500, frame(0x100)), idle()]);
    schedule(&mut bench, 15, Fault::Disconnect(2));
    schedule(&mut bench, 1500, Fault::Reconnect(2));
    bench.leap(us(1499));
    assert_eq!(
        (frames(&bench, 1), frames(&bench, 2), frames(&bench, 3)),
        (vec![sync()], vec![], vec![sync()])
    );
    assert!(tec(&bench, 2) > 0, "it finds nobody to acknowledge");
    bench.leap(us(2000));
    assert_eq!(frames(&bench, 3), [sync(), frame(0x100)]);
}

#[test]
fn node_without_power_takes_no_part_and_returns_after_11_bits() {
    let mut bench = sender_and(2);
    send(&mut bench, 0, 300, [frame(0x100)]);
    schedule(&mut bench, 15, Fault::PowerOff(1));
    schedule(&mut bench, 200, Fault::PowerOn(1));
    bench.leap(us(400));
    assert_eq!(frames(&bench, 1), [frame(0x100)]);
    assert_eq!(bench.stations[1].told(WireEvent::Joined), [us(11), us(211)]);
}

/// The bus is blocked while a driver is stuck, and works again afterwards: only transmitters are bus-off.
#[test]
fn a_stuck_dominant_driver_blocks_the_bus_until_it_is_free() {
    let mut bench = four([sending(30, sync()), idle(), idle(), idle()]);
    schedule(&mut bench, 25, Fault::StuckDominant(2));
    schedule(&mut bench, 1000, Fault::ReleaseDriver(2));
    bench.leap(us(999));
    for node in 0..4 {
        assert_eq!(frames(&bench, node), []);
        assert!(rec(&bench, node) >= 128, "node {node}");
    }
    bench.leap(Time::from_ms(3));
    for node in 1..4 {
        assert_eq!(frames(&bench, node), [sync()]);
    }
}

/// A driver that is stuck within a frame: the transmitter's next recessive bit is wrong.
#[test]
fn a_driver_that_gets_stuck_within_a_frame_destroys_it() {
    let mut bench = sender_and(2);
    schedule(&mut bench, SOF + 17, Fault::StuckDominant(1));
    schedule(&mut bench, SOF + 60, Fault::ReleaseDriver(1));
    bench.leap(us(SOF + 50));
    // Bits 17 to 20 are dominant (DLC), bit 21 at the latest shows it: six dominant bits from 17 on are too many.
    let (at, event) = errors(&bench, 0)[0];
    assert!(at <= end_of(SOF, 22) && event == transmit_error(ErrorKind::BitRecessive), "{at:?} {event:?}");
    bench.leap(us(400));
    assert_eq!(frames(&bench, 2), [sync()]);
}

/// Given a babbling node of the highest priority, then all others are starved. With the lowest priority the others send
/// between its frames.
#[test]
fn a_babbling_node_starves_those_of_lower_priority() {
    for (id, delivered) in [(0x000, 0), (0x7FF, 20)] {
        let mut talker = idle();
        talker.queue.extend((0..20).map(|n| (us(200 + 100 * n), WireFrame::standard(0x181, &[n as u8]))));
        let mut bench = Bench::together(vec![talker, idle(), idle()]);
        schedule(&mut bench, 100, Fault::Babble(2, frame(id)));
        schedule(&mut bench, 4000, Fault::StopBabbling(2));
        bench.leap(us(4000));
        let own = |bench: &Bench| frames(bench, 1).iter().filter(|got| **got != frame(id)).count();
        assert_eq!(own(&bench), delivered, "{id:03X}h");
        let babble = encode(&frame(id)).bits().len() + 3;
        assert!(frames(&bench, 1).len() > 3000 / babble, "it fills the bus");
        assert!(bench.stations[2].told(WireEvent::Started).is_empty(), "its controller knows nothing of it");
        bench.leap(us(8000));
        assert_eq!(own(&bench), 20);
    }
}

/// The frame under way when the babble begins is the controller's, the one under way when it ends is not.
#[test]
fn a_babbler_keeps_its_controllers_frames_apart() {
    let mut bench = Bench::together(vec![sending(SOF, sync()).sending(us(80), frame(0x300)), idle()]);
    schedule(&mut bench, SOF + 10, Fault::Babble(0, frame(0x000)));
    schedule(&mut bench, SOF + 51 + 25, Fault::StopBabbling(0));
    bench.leap(us(400));
    assert_eq!(frames(&bench, 1), [sync(), frame(0x000), frame(0x300)]);
    assert_eq!(sent(&bench, 0).len(), 2);
}

/// A clock that drifts by 3 %, twice what the bit timing tolerates, loses the traffic, and gets it back.
#[test]
fn a_drifting_clock_loses_the_bus_until_it_is_back() {
    let traffic = |n: u64| WireFrame::standard(0x0F5, &[0x3C, 0x3C, 0x3C, 0x3C, 0x3C, 0x3C, 0x3C, n as u8]);
    let mut sender = idle();
    sender.queue.extend((0..60).map(|n| (us(100 + 200 * n), traffic(n))));
    let mut bench = Bench::together(vec![sender, idle(), idle()]);
    schedule(&mut bench, 2000, Fault::Drift(2, -30_000_000));
    schedule(&mut bench, 8000, Fault::Drift(2, 0));
    bench.leap(Time::from_ms(20));
    let times: Vec<u64> = received(&bench, 2).into_iter().map(|(at, _)| at.as_us()).collect();
    assert!(times.iter().filter(|&&at| at < 2000).count() >= 9);
    assert!(!times.iter().any(|at| (2200..8000).contains(at)), "{times:?}");
    assert!(times.iter().filter(|&&at| at > 8200).count() >= 18);
    assert_eq!(sent(&bench, 0).len(), 60, "once it is error passive, the others go on");
}

/// Only the named nodes see a glitch, with its effect.
#[test]
fn a_glitch_is_seen_by_whom_it_names() {
    for effect in [Effect::Invert, Effect::Recessive] {
        let mut bench = sender_and(3);
        // Bit 6 is dominant.
        let glitch = Fault::Glitch { nodes: Nodes::of(&[2]), duration: us(1), effect };
        schedule(&mut bench, SOF + 6, glitch);
        bench.leap(us(SOF + 300));
        assert!(errors(&bench, 2)[0].0 <= errors(&bench, 1)[0].0, "the others learn of it from node 2");
        assert_eq!((starts(&bench, 0).len(), frames(&bench, 1)), (2, vec![sync()]));
    }
    // A level that is already dominant does not change.
    let mut bench = sender_and(3);
    let glitch = Fault::Glitch { nodes: Nodes::ALL, duration: us(1), effect: Effect::Dominant };
    schedule(&mut bench, SOF + 6, glitch);
    bench.leap(us(200));
    assert_eq!(sent(&bench, 0), [us(SOF + 48)]);
}

/// A flip inverts one bit for each of its nodes, the next one at its place, and no other bit.
#[test]
fn a_flip_strikes_each_node_once() {
    let mut bench = sender_and(3);
    for n in 0..3u64 {
        send(&mut bench, 0, 200 + 100 * n, [sync()]);
    }
    from_start(&mut bench, [flip_field(Field::Eof(2), &[1]), flip_field(Field::Eof(2), &[2])]);
    bench.leap(us(700));
    // The first try: both at once. All the rest is well.
    assert_eq!(bench.wire.counters().destroyed, 1);
    assert_eq!(starts(&bench, 0).len(), 5);
    // Two flips of one node affect one frame each.
    let bench = disturbed(3, [flip_field(Field::Eof(2), &[1]), flip_field(Field::Eof(2), &[1])], 700);
    assert_eq!(bench.wire.counters().destroyed, 2);
}

/// Each node sees each microsecond inverted with the given probability. 4 nodes, 100 ms of back-to-back frames of 111
/// bits, rate 1e-4: 40 disturbances are expected; nearly every one destroys a frame, those of the idle bits do not.
#[test]
fn random_bit_errors_come_at_their_rate_and_end() {
    let mut sender = idle();
    sender.queue.extend((0..1500).map(|_| (us(30), WireFrame::standard(0x155, &[0x55; 8]))));
    let mut bench = Bench::together(vec![sender, idle(), idle(), idle()]);
    schedule(&mut bench, 0, Fault::BitErrors { rate: 1e-4, seed: 11 });
    schedule(&mut bench, 100_000, Fault::BitErrors { rate: 0.0, seed: 0 });
    bench.leap(Time::from_ms(100));
    let destroyed = bench.wire.counters().destroyed;
    // Four standard deviations of a Poisson count of 40 are 25.
    assert!((15..=65).contains(&destroyed), "{destroyed}");
    bench.leap(Time::from_ms(101));
    let after = bench.wire.counters().destroyed;
    bench.leap(Time::from_ms(200));
    assert_eq!(bench.wire.counters().destroyed, after);
    // The same seed brings the same errors.
    let again = |seed: u64| {
        let mut bench = sender_and(3);
        schedule(&mut bench, 0, Fault::BitErrors { rate: 0.01, seed });
        bench.leap(Time::from_ms(2));
        bench.stations.iter().map(|station| station.log.clone()).collect::<Vec<_>>()
    };
    assert_eq!(again(5), again(5));
    assert_ne!(again(5), again(6));
}

/// Given a transmitter that loses power within a frame, then the record has this cause.
#[test]
fn a_transmitter_that_loses_power_takes_its_frame_along() {
    let mut bench = sender_and(2);
    schedule(&mut bench, SOF + 10, Fault::PowerOff(0));
    bench.leap(us(200));
    let left = destroyed(&bench.wire.take_records()).map(|(cause, at, ..)| (cause, at));
    assert_eq!(left, Some((Destruction::TransmitterLeft, us(SOF + 10))));
    assert_eq!(frames(&bench, 1), []);
}

proptest! {
    #![proptest_config(cases(256))]

    /// Events on one side of a cut do not depend on the other side.
    #[test]
    fn pieces_do_not_know_of_each_other(
        left in prop::collection::vec((4000u64..100_000, 0u16..=0x7FF), 0..6),
        right in prop::collection::vec((4000u64..100_000, 0u16..=0x7FF), 0..6),
        cut in 1.5..10.5f64,
    ) {
        let queue = |requests: &[(u64, u16)]| {
            let mut station = idle();
            let mut requests: Vec<(Time, WireFrame)> =
                requests.iter().map(|&(at, id)| (Time(at), frame(id))).collect();
            requests.sort_by_key(|&(at, _)| at);
            station.queue.extend(requests);
            station
        };
        let run = |left: &[(u64, u16)], right: &[(u64, u16)]| {
            let mut bench = four([queue(left), idle(), queue(right), idle()]);
            bench.wire.cut(cut);
            bench.leap(us(1500));
            bench.stations.into_iter().map(|station| station.log).collect::<Vec<_>>()
        };
        let both = run(&left, &right);
        prop_assert_eq!(&both[..2], &run(&left, &[])[..2]);
        prop_assert_eq!(&both[2..], &run(&[], &right)[2..]);
    }

    /// Given any sequence of cuts and repairs, then all frames arrive after the last repair, and none is lost.
    #[test]
    fn a_healed_cable_delivers_everything(
        faults in prop::collection::vec((0u64..400_000, 0u8..3, prop::sample::select(vec![0.5, 6.0, 11.5])), 0..12),
        requests in prop::collection::vec(4000u64..400_000, 4),
    ) {
        let mut bench = four_requesting(&requests);
        for &(at, kind, position_m) in &faults {
            let fault = if kind < 2 { Fault::Cut { position_m } } else { Fault::Restore { position_m } };
            bench.wire.schedule(Time(at), fault).unwrap();
        }
        bench.wire.schedule(Time(400_000), Fault::RestoreAll).unwrap();
        bench.leap(us(4000));
        for node in 0..4 {
            prop_assert_eq!(sent(&bench, node).len(), 1);
        }
        prop_assert_eq!(bench.wire.counters().completed, 4);
        prop_assert_eq!(bench.wire.next_event(), None);
        let times: Vec<Time> = bench.wire.take_records().iter().map(Observation::at).collect();
        prop_assert!(times.is_sorted());
    }
}

/// Eleven recessive bits in a row: those before a short do not count.
#[test]
fn a_short_starts_the_wait_for_the_bus_anew() {
    let mut bench = Bench::together(vec![idle()]);
    schedule(&mut bench, 5, Fault::Short { position_m: 0.0, level: false });
    schedule(&mut bench, 30, Fault::ClearShorts);
    bench.leap(us(60));
    assert_eq!(bench.stations[0].told(WireEvent::Joined), [us(41)]);
}

/// A line that has long been dominant, with REC at its end: the sample point of the bit at 401 us, 288 ticks into it,
/// sees recessive, the next one dominant again. The falling edge at 296 ticks resynchronises: it is two quanta early,
/// SJW lets that next bit begin one quantum early, at 312 ticks, and it ends one bit later.
#[test]
fn one_recessive_sample_on_a_dominant_line_is_a_form_error() {
    let mut bench = Bench::together(vec![idle()]);
    schedule(&mut bench, 50, Fault::Short { position_m: 0.0, level: false });
    let glitch = Fault::Glitch { nodes: Nodes::ALL, duration: Time(332), effect: Effect::Invert };
    bench.wire.schedule(us(400) + Time(300), glitch).unwrap();
    bench.leap(us(500));
    assert_eq!(rec(&bench, 0), 255);
    assert_eq!(errors(&bench, 0).last(), Some(&(us(402) + Time(312), receive_error(ErrorKind::Form))));
}

/// The SOF of node 0 ends at the instant at which its driver sticks: the line stays dominant.
#[test]
fn a_driver_that_sticks_as_it_lets_go_stays_dominant() {
    let stations = vec![(0.0, sending(40, frame(0x7FF))), (10.0, listener())];
    let mut bench = Bench::new(WireConfig::default(), stations);
    schedule(&mut bench, 41, Fault::StuckDominant(0));
    bench.leap(us(300));
    assert_eq!(levels(&bench, 1), [false], "dominant since the SOF");
}

/// The effect of a stuck driver on other nodes ends with the fault, also if its node is silent.
#[test]
fn a_silent_node_with_a_stuck_driver_lets_go_again() {
    let mut bench = Bench::new(WireConfig::default(), vec![(0.0, silent()), (10.0, listener())]);
    schedule(&mut bench, 40, Fault::StuckDominant(0));
    schedule(&mut bench, 100, Fault::ReleaseDriver(0));
    bench.leap(us(300));
    assert_eq!(levels(&bench, 1), [false, true]);
}

#[test]
fn a_node_without_power_from_the_start_never_joins() {
    let mut bench = Bench::together(vec![idle(), idle()]);
    schedule(&mut bench, 0, Fault::PowerOff(1));
    bench.leap(us(300));
    assert_eq!(bench.stations[1].log, []);
}

#[test]
fn disturbances_of_nobody_and_of_foreign_nodes_are_refused() {
    let mut bench = Bench::together(vec![idle(), idle()]);
    let flip = |nodes: &[usize]| Fault::Flip(Flip::new(Place::Bit(0), Nodes::of(nodes)));
    assert_eq!(bench.wire.schedule(Time::ZERO, flip(&[])), Err(FaultError::NoNode));
    assert_eq!(bench.wire.schedule(Time::ZERO, flip(&[1, 2])), Err(FaultError::Node { node: 2, count: 2 }));
    assert_eq!(bench.wire.schedule(Time::ZERO, Fault::Flip(Flip::new(Place::Bit(0), Nodes::ALL))), Ok(()));
}

/// Given two pieces that are joined while both are in the ACK slot, then each acknowledges the other, and two frames
/// are complete.
#[test]
fn two_frames_that_acknowledge_each_other_are_both_on_record() {
    let mut bench = four_requesting(&[4_000, 369_771, 369_788, 255_294]);
    schedule(&mut bench, 0, Fault::Cut { position_m: 11.5 });
    bench.wire.schedule(Time(400_000), Fault::RestoreAll).unwrap();
    bench.leap(us(4000));
    let records = bench.wire.take_records();
    let completed = completed(&records);
    let completed = completed.iter().map(|(trace, receivers, _)| (trace.transmitter, receivers.len()));
    assert_eq!(completed.collect::<Vec<_>>(), [(0, 2), (1, 2), (3, 0), (2, 2)]);
    assert!(!records.iter().any(|record| matches!(record, Observation::Misread { .. })));
}
