//! Compares the fast path with the bit path: the results are equal to the tick.

use can_twin::wire::bus::WireConfig;
use can_twin::wire::fault::{Effect, Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;
use can_twin::wire::transceiver::Transceiver;
use can_twin::wire::waveform::Waveform;
use proptest::prelude::*;

use crate::common::cases;

fn frame() -> impl Strategy<Value = WireFrame> {
    let id = prop_oneof![
        6 => (0u16..0x800).prop_map(WireId::Standard),
        2 => (0u16..4).prop_map(WireId::Standard),
        1 => (0u32..1 << 29).prop_map(WireId::Extended),
    ];
    (id, prop::bool::weighted(0.1), 0u8..16, any::<[u8; 8]>()).prop_map(|(id, remote, dlc, mut data)| {
        let len = if remote { 0 } else { usize::from(dlc.min(8)) };
        data[len..].fill(0);
        WireFrame { id, remote, dlc, data }
    })
}

#[derive(Clone, Debug)]
struct Plan {
    nodes: Vec<Planned>,
    faults: Vec<(u64, Fault)>,
    /// Faults that are scheduled only at their instant, in chronological order.
    surprises: Vec<(u64, Surprise)>,
    /// Transceiver of each node.
    transceivers: Vec<Transceiver>,
    quantum_us: u64,
    /// Span of a waveform that is taken on the fast path, us.
    recorded: Option<(u64, u64)>,
}

/// Position in metres, clock error in ppb, bus monitoring, frames and when they are queued, us.
type Planned = (f64, i32, bool, Vec<(u64, WireFrame)>);

/// An event that the wire does not know in advance.
#[derive(Clone, Debug)]
enum Surprise {
    Fault(Fault),
    /// The controller of a node leaves the bus.
    Leaves(usize),
    Returns(usize),
    /// It changes to bus monitoring and back.
    Silent(usize, bool),
    /// A frame is queued only now.
    Sends(usize, WireFrame),
}

fn fault(nodes: usize) -> impl Strategy<Value = Fault> {
    let position = || (0u32..60).prop_map(f64::from);
    let some = move || {
        prop::collection::vec(any::<bool>(), nodes).prop_map(|chosen| {
            let those: Vec<usize> = (0..chosen.len()).filter(|&node| chosen[node]).collect();
            if those.is_empty() { Nodes::ALL } else { Nodes::of(&those) }
        })
    };
    let effect = prop_oneof![Just(Effect::Invert), Just(Effect::Dominant), Just(Effect::Recessive)];
    let place = prop_oneof![
        3 => (0usize..100).prop_map(Place::Bit),
        1 => (0u8..7).prop_map(|bit| Place::Field(Field::Eof(bit))),
        1 => (0u8..3).prop_map(|bit| Place::Field(Field::Intermission(bit))),
        1 => (0u8..6).prop_map(|bit| Place::Field(Field::ErrorFlag(bit))),
        1 => (0u8..6).prop_map(|bit| Place::Field(Field::OverloadFlag(bit))),
        1 => (1u8..8).prop_map(|bit| Place::Field(Field::Delimiter(bit))),
        1 => (0u8..8).prop_map(|bit| Place::Field(Field::Suspend(bit))),
        1 => prop::sample::select(vec![Field::Sof, Field::Rtr, Field::Stuff, Field::CrcDelimiter, Field::AckSlot])
            .prop_map(Place::Field),
    ];
    let cable = prop_oneof![
        position().prop_map(|position_m| Fault::Cut { position_m }),
        position().prop_map(|position_m| Fault::Restore { position_m }),
        Just(Fault::RestoreAll),
        (position(), any::<bool>()).prop_map(|(position_m, level)| Fault::Short { position_m, level }),
        Just(Fault::ClearShorts),
    ];
    let node = prop_oneof![
        (0..nodes).prop_map(Fault::Disconnect),
        (0..nodes).prop_map(Fault::Reconnect),
        (0..nodes).prop_map(Fault::PowerOff),
        (0..nodes).prop_map(Fault::PowerOn),
        (0..nodes).prop_map(Fault::StuckDominant),
        (0..nodes).prop_map(Fault::ReleaseDriver),
        (0..nodes, frame()).prop_map(|(node, frame)| Fault::Babble(node, frame)),
        (0..nodes).prop_map(Fault::StopBabbling),
        (0..nodes, -5_000_000i32..5_000_000).prop_map(|(node, ppb)| Fault::Drift(node, ppb)),
        (0..nodes, prop::sample::select(vec![1_000_000_000, -500_000_000, 50_000_000]))
            .prop_map(|(node, ppb)| Fault::Drift(node, ppb)),
    ];
    let line = prop_oneof![
        (some(), 1u64..6000, effect).prop_map(|(nodes, ticks, effect)| Fault::Glitch {
            nodes,
            duration: Time(ticks),
            effect
        }),
        (place, some()).prop_map(|(place, nodes)| Fault::Flip(Flip::new(place, nodes))),
        (prop::sample::select(vec![0.0, 1e-4, 1e-2]), any::<u64>())
            .prop_map(|(rate, seed)| Fault::BitErrors { rate, seed }),
    ];
    prop_oneof![cable, node, line]
}

fn surprise(nodes: usize) -> impl Strategy<Value = Surprise> {
    prop_oneof![
        4 => fault(nodes).prop_map(Surprise::Fault),
        1 => (0..nodes).prop_map(Surprise::Leaves),
        1 => (0..nodes).prop_map(Surprise::Returns),
        1 => (0..nodes, any::<bool>()).prop_map(|(node, silent)| Surprise::Silent(node, silent)),
        2 => (0..nodes, frame()).prop_map(|(node, frame)| Surprise::Sends(node, frame)),
    ]
}

fn plan(most_faults: usize) -> impl Strategy<Value = Plan> {
    (1usize..7).prop_flat_map(move |count| {
        let node = (
            (0u32..40).prop_map(f64::from),
            -100_000i32..100_000,
            prop::bool::weighted(0.1),
            prop::collection::vec((50u64..4_000, frame()), 0..4),
        );
        let nodes = prop::collection::vec(node, count);
        let faults = prop::collection::vec((50u64..4_000, fault(count)), 0..=most_faults);
        let surprises = prop::collection::vec((50u64..4_000, surprise(count)), 0..=most_faults);
        let recorded = prop::option::of((0u64..4_000, 1u64..2_000));
        let each = (0u32..130, 0u32..130)
            .prop_map(|(driver_ns, receiver_ns)| Transceiver { driver_ns, receiver_ns });
        let transceivers = prop_oneof![
            Just(vec![Transceiver::default(); count]),
            (100u32..250).prop_map(move |loop_ns| vec![Transceiver::with_loop(loop_ns); count]),
            prop::collection::vec(each, count),
        ];
        (nodes, faults, surprises, transceivers, 1u64..20, recorded).prop_map(
            |(nodes, faults, mut surprises, transceivers, quantum_us, recorded)| {
                surprises.sort_by_key(|&(at, _)| at);
                Plan { nodes, faults, surprises, transceivers, quantum_us, recorded }
            },
        )
    })
}

fn fly(plan: &Plan, bit_by_bit: bool, quantum: Option<Time>) -> Bench {
    let config = WireConfig { bit_by_bit, ..WireConfig::default() };
    let nodes = plan.nodes.iter().zip(&plan.transceivers);
    let stations = nodes.map(|((position_m, ppb, silent, frames), transceiver)| {
        let mut station =
            Station { watches_line: true, ..Station::with_timing(BitTiming::MEGABIT.fast_by(*ppb)) };
        station.attachment.as_mut().unwrap().silent = *silent;
        for (at, frame) in frames {
            station.queue.push_back((Time::from_us(*at), *frame));
        }
        (*position_m, *transceiver, station)
    });
    let mut bench = Bench::with_transceivers(config, stations.collect());
    for (at, fault) in &plan.faults {
        bench.wire.schedule(Time::from_us(*at), *fault).unwrap();
    }
    if let Some((from, length)) = plan.recorded.filter(|_| !bit_by_bit) {
        bench.wire.record_waveform(Time::from_us(from), Time::from_us(from + length));
    }
    let go_to = |bench: &mut Bench, until: Time| match quantum {
        Some(quantum) => bench.run(until, quantum),
        None if bench.wire.now() < until => bench.leap(until),
        None => {}
    };
    let kept: Vec<_> = bench.stations.iter().map(|station| station.attachment).collect();
    for (at, surprise) in &plan.surprises {
        let now = Time::from_us(*at);
        go_to(&mut bench, now);
        match surprise {
            Surprise::Fault(fault) => bench.wire.schedule(now, *fault).unwrap(),
            Surprise::Leaves(node) => bench.stations[*node].attachment = None,
            Surprise::Returns(node) => bench.stations[*node].attachment = kept[*node],
            Surprise::Silent(node, silent) => {
                if let Some(attachment) = &mut bench.stations[*node].attachment {
                    attachment.silent = *silent;
                }
            }
            Surprise::Sends(node, frame) => bench.stations[*node].queue.push_back((now, *frame)),
        }
    }
    go_to(&mut bench, Time::from_ms(6));
    bench
}

/// Checks that two lists are equal. The error contains the first difference.
fn equal<T: std::fmt::Debug + PartialEq>(what: &str, a: &[T], b: &[T]) -> Result<(), TestCaseError> {
    let at = (0..a.len().max(b.len())).find(|&n| a.get(n) != b.get(n));
    prop_assert!(
        at.is_none(),
        "{what} {at:?}: {:?}, not {:?}",
        at.map(|at| a.get(at)),
        at.map(|at| b.get(at))
    );
    Ok(())
}

fn same(a: &mut Bench, b: &mut Bench) -> Result<(), TestCaseError> {
    for (node, (a, b)) in a.stations.iter().zip(&b.stations).enumerate() {
        equal(&format!("log of node {node}"), &a.log, &b.log)?;
        equal(&format!("line of node {node}"), &a.line, &b.line)?;
    }
    prop_assert_eq!(a.wire.counters(), b.wire.counters());
    equal("records", &a.wire.take_records(), &b.wire.take_records())
}

/// Checks that a waveform agrees with the events of the controllers, and that every sample is the level at its sample
/// point.
fn is_true(waveform: &Waveform, bench: &Bench) -> Result<(), TestCaseError> {
    let inside = |&&(at, _): &&(Time, bool)| waveform.from < at && at < waveform.to;
    for (lane, station) in waveform.lanes.iter().zip(&bench.stations) {
        let shown: Vec<_> = lane.line.iter().filter(inside).copied().collect();
        let seen: Vec<_> = station.line.iter().filter(inside).copied().collect();
        equal(&format!("line of node {}", lane.node), &shown, &seen)?;
        prop_assert!(lane.bits.windows(2).all(|pair| pair[0].end <= pair[1].start), "bits overlap");
        for bit in lane.bits.iter().filter(|bit| bit.sample > waveform.from) {
            let before = lane.line.partition_point(|&(at, _)| at < bit.sample);
            // Within one tick of an edge either may be first.
            if lane.line.get(before).is_none_or(|&(at, _)| at > bit.sample) {
                prop_assert_eq!(
                    lane.line[before - 1].1 != bit.flipped,
                    bit.sampled,
                    "node {}: {:?}",
                    lane.node,
                    bit
                );
            }
        }
    }
    Ok(())
}

/// Returns the next event of the wire, two bits after the SOF at 40 us.
fn next_event_within_a_frame(bench: &mut Bench) -> Time {
    bench.leap(Time::from_us(42));
    bench.wire.next_event().unwrap()
}

/// An undisturbed frame is one step: the next event is when it is valid, 47 bits after its SOF. On the bit path there
/// is an event after the identifier, 12 bits after SOF.
#[test]
fn undisturbed_frames_take_the_fast_path() {
    let sync = WireFrame::standard(0x080, &[]);
    for (bit_by_bit, next) in [(false, 40 + 47), (true, 40 + 12)] {
        let config = WireConfig { bit_by_bit, ..WireConfig::default() };
        let sender = Station::default().sending(Time::from_us(40), sync);
        let mut bench = Bench::new(config, vec![(0.0, sender), (0.0, Station::default())]);
        assert_eq!(next_event_within_a_frame(&mut bench), Time::from_us(next));
    }
    // A contest takes it as soon as it is over: 15 bits of arbitration field with one stuff bit.
    let mut bench = Bench::together(vec![
        Station::default().sending(Time::from_us(40), sync),
        Station::default().sending(Time::from_us(40), WireFrame::standard(0x081, &[])),
        Station::default(),
    ]);
    bench.leap(Time::from_us(40 + 17));
    assert_eq!(bench.wire.next_event(), Some(Time::from_us(40 + 47)));
}

/// Runs a plan on both paths, the fast one in quanta. Checks that events are equal and that a waveform is as requested.
fn compare(plan: &Plan, quantum: Option<Time>) -> Result<(), TestCaseError> {
    let mut fast = fly(plan, false, quantum);
    same(&mut fast, &mut fly(plan, true, None))?;
    let waveform = fast.wire.take_waveform();
    prop_assert_eq!(waveform.is_some(), plan.recorded.is_some());
    waveform.map_or(Ok(()), |waveform| is_true(&waveform, &fast))
}

/// Returns two nodes with one fault that was not announced; the first frame of each is requested at 50 us.
fn surprised(frames: [Option<WireFrame>; 2], loop_ns: u32, at: u64, surprise: Surprise) {
    let node =
        |frame: Option<WireFrame>| (0.0, 0, false, frame.map(|frame| (50, frame)).into_iter().collect());
    let plan = Plan {
        nodes: frames.map(node).into(),
        faults: vec![],
        surprises: vec![(at, surprise)],
        transceivers: vec![Transceiver::with_loop(loop_ns); 2],
        quantum_us: 1,
        recorded: None,
    };
    compare(&plan, Some(Time::from_us(1))).unwrap_or_else(|error| panic!("{:?} us: {error}", plan.surprises));
}

/// Given a driver that gets stuck, unannounced, within its own frame of five dominant bits and a stuff bit, at every
/// microsecond, then the bits sent before do not change.
#[test]
fn a_driver_stuck_within_a_frame_does_not_change_the_past() {
    let frame = WireFrame::standard(0, &[0]);
    for at in 50..110 {
        surprised([Some(frame), None], 0, at, Surprise::Fault(Fault::StuckDominant(0)));
    }
}

/// Given a transmitter that becomes silent within a frame, unannounced, with its driver dominant, then the others do
/// not see it become recessive. With two contenders the frame is on the bit path until the arbitration is over.
#[test]
fn a_transmitter_that_goes_silent_reaches_nobody_on_both_paths() {
    let first = WireFrame::standard(0x001, &[8, 46, 132, 33, 150, 33, 46, 16]);
    let second = WireFrame::standard(0x081, &[18, 68, 230, 192, 4, 6, 5, 9]);
    for at in 50..130 {
        surprised([Some(first), Some(second)], 100, at, Surprise::Silent(0, true));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 20000, ..cases(1000) })]

    #[test]
    fn undisturbed_traffic_is_the_same_on_both_paths(plan in plan(0)) {
        compare(&plan, None)?;
    }

    #[test]
    fn disturbed_traffic_is_the_same_on_both_paths(plan in plan(4)) {
        compare(&plan, Some(Time::from_us(plan.quantum_us)))?;
    }
}
