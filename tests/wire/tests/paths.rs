//! The fast path against the bit path: the same to the last tick.

use can_wire::fault::{Effect, Fault, Flip, Nodes, Place};
use can_wire::field::Field;
use can_wire::frame::{WireFrame, WireId};
use can_wire::station::{Bench, Station};
use can_wire::time::Time;
use can_wire::timing::BitTiming;
use can_wire::wire::WireConfig;
use proptest::prelude::*;

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
    nodes: Vec<(f64, i32, bool, Vec<(u64, WireFrame)>)>,
    faults: Vec<(u64, Fault)>,
    transceiver_ns: u32,
    quantum_us: u64,
}

fn fault(nodes: usize) -> impl Strategy<Value = Fault> {
    let position = 0u32..60;
    prop_oneof![
        position.clone().prop_map(|m| Fault::Cut { position_m: f64::from(m) }),
        Just(Fault::RestoreAll),
        (position, any::<bool>()).prop_map(|(m, level)| Fault::Short { position_m: f64::from(m), level }),
        Just(Fault::ClearShorts),
        (0..nodes).prop_map(Fault::Disconnect),
        (0..nodes).prop_map(Fault::Reconnect),
        (0..nodes).prop_map(Fault::PowerOff),
        (0..nodes).prop_map(Fault::PowerOn),
        (any::<u8>(), 1u64..3000).prop_map(|(mask, ticks)| Fault::Glitch {
            nodes: Nodes::of(&(0..8).filter(|n| mask >> n & 1 == 1).collect::<Vec<_>>()),
            duration: Time(ticks),
            effect: Effect::Invert,
        }),
        (0usize..60, 0..nodes).prop_map(|(bit, node)| Fault::Flip(Flip::new(Place::Bit(bit), Nodes::of(&[node])))),
        (0u8..7, 0..nodes).prop_map(|(bit, node)| Fault::Flip(Flip::new(Place::Field(Field::Eof(bit)), Nodes::of(&[node])))),
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
        (nodes, faults, prop_oneof![Just(0u32), 100u32..250], 1u64..20).prop_map(
            |(nodes, faults, transceiver_ns, quantum_us)| Plan { nodes, faults, transceiver_ns, quantum_us },
        )
    })
}

fn fly(plan: &Plan, bit_by_bit: bool, quantum: Option<Time>) -> Bench {
    let config = WireConfig { bit_by_bit, transceiver_ns: plan.transceiver_ns, ..WireConfig::default() };
    let stations = plan.nodes.iter().map(|(position_m, ppb, silent, frames)| {
        let mut station = Station { watches_line: true, ..Station::with_timing(BitTiming::MEGABIT.fast_by(*ppb)) };
        station.attachment.as_mut().unwrap().silent = *silent;
        for (at, frame) in frames {
            station.queue.push_back((Time::from_us(*at), *frame));
        }
        (*position_m, station)
    });
    let mut bench = Bench::new(config, stations.collect());
    for (at, fault) in &plan.faults {
        bench.wire.schedule(Time::from_us(*at), *fault).unwrap();
    }
    match quantum {
        Some(quantum) => bench.run(Time::from_ms(6), quantum),
        None => bench.leap(Time::from_ms(6)),
    }
    bench
}

/// Equal, or where they differ first.
fn equal<T: std::fmt::Debug + PartialEq>(what: &str, a: &[T], b: &[T]) -> Result<(), TestCaseError> {
    let at = (0..a.len().max(b.len())).find(|&n| a.get(n) != b.get(n));
    prop_assert!(at.is_none(), "{what} {at:?}: {:?}, not {:?}", at.map(|at| a.get(at)), at.map(|at| b.get(at)));
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, max_shrink_iters: 20000, ..ProptestConfig::default() })]

    #[test]
    fn undisturbed_traffic_is_the_same_on_both_paths(plan in plan(0)) {
        let mut fast = fly(&plan, false, None);
        let mut bits = fly(&plan, true, None);
        same(&mut fast, &mut bits)?;
    }

    #[test]
    fn disturbed_traffic_is_the_same_on_both_paths(plan in plan(4)) {
        let mut fast = fly(&plan, false, Some(Time::from_us(plan.quantum_us)));
        let mut bits = fly(&plan, true, None);
        same(&mut fast, &mut bits)?;
    }
}
