//! The failures of ECSS-E-ST-50-15C, Table 5-2, and what the network has to do in each.
//!
//! A wire models levels, not voltages: a failure that only reduces the margin is a higher bit error rate, and one that
//! prevents communication is a line that stays recessive. Cases are numbered as in ISO 11898-2.

use can_twin::wire::bus::WireConfig;
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::station::Bench;
use can_twin::wire::time::Time;

use crate::common::*;

/// Nodes at 0, 10, 20, 30 and 40 m.
const NODES: usize = 5;
/// Each node sends a frame per millisecond, up to here.
const LAST_MS: u64 = 120;
/// The failure begins and ends, ms.
const ONSET_MS: u64 = 20;
const REMOVAL_MS: u64 = 40;
/// Time after which the failure must have no effect any more: recovery from bus-off takes at most 17 ms at 1 Mbit/s.
const SETTLED_MS: u64 = 70;

/// Fault that begins a failure, and the one that ends it; `None` if the damage is permanent.
type Failure = (Fault, Option<Fault>);

/// A reduced signal-to-noise ratio: about one frame of 110 bits in a hundred is hit. This is an assumption: the
/// standard gives no number.
fn reduced_margin(seed: u64) -> Failure {
    (Fault::BitErrors { rate: 1e-4, seed }, Some(Fault::BitErrors { rate: 0.0, seed }))
}

/// Returns frame `n` of a node, which differs from all others.
fn numbered(node: usize, n: u64) -> WireFrame {
    WireFrame::standard(0x181 + node as u16, &(n as u16).to_be_bytes())
}

/// Runs five nodes that send continuously, with a failure.
fn network(failure: Failure) -> Bench {
    let station = |node: usize| {
        let mut station = idle();
        station.queue.extend((1..=LAST_MS).map(|n| (Time::from_ms(n), numbered(node, n))));
        (10.0 * node as f64, station)
    };
    let mut bench = Bench::new(WireConfig::default(), (0..NODES).map(station).collect());
    let (onset, removal) = failure;
    bench.wire.schedule(Time::from_ms(ONSET_MS), onset).unwrap();
    if let Some(removal) = removal {
        bench.wire.schedule(Time::from_ms(REMOVAL_MS), removal).unwrap();
    }
    bench.leap(Time::from_ms(LAST_MS + 5));
    bench
}

/// Returns how many of the frames of `from` that were queued in these milliseconds arrived at `to` within them, or 1 ms
/// later.
fn arrived(bench: &Bench, from: usize, to: usize, ms: std::ops::Range<u64>) -> u64 {
    let late = Time::from_ms(ms.end + 1);
    let got: Vec<WireFrame> =
        bench.stations[to].received().filter(|&(at, _)| at < late).map(|(_, frame)| frame).collect();
    ms.filter(|&n| got.contains(&numbered(from, n))).count() as u64
}

/// Checks that all of `nodes` receive all frames of each other in these milliseconds.
fn communicate(bench: &Bench, nodes: &[usize], ms: std::ops::Range<u64>) {
    for &from in nodes {
        for &to in nodes.iter().filter(|&&to| to != from) {
            assert_eq!(arrived(bench, from, to, ms.clone()), ms.end - ms.start, "{from} to {to}, ms {ms:?}");
        }
    }
}

/// Checks that no node receives a frame of another one.
fn silence(bench: &Bench) {
    for from in 0..NODES {
        for to in (0..NODES).filter(|&to| to != from) {
            assert_eq!(arrived(bench, from, to, ONSET_MS + 1..REMOVAL_MS - 1), 0, "{from} to {to}");
        }
    }
}

const ALL: [usize; NODES] = [0, 1, 2, 3, 4];

/// Checks that the network is as before: all frames arrive, every node is error active, and waiting frames have been
/// sent.
fn no_ill_effects(bench: &Bench) {
    communicate(bench, &ALL, SETTLED_MS..LAST_MS);
    for node in ALL {
        assert!(tec(bench, node) < 128 && rec(bench, node) < 128, "node {node}");
        assert!(bench.stations[node].queue.is_empty(), "node {node}");
    }
}

fn before(bench: &Bench) {
    communicate(bench, &ALL, 1..ONSET_MS);
}

/// Checks that the nodes of `rest` communicate during the failure, and all nodes afterwards.
fn the_rest_goes_on(failure: Failure, rest: &[usize]) -> Bench {
    let bench = network(failure);
    before(&bench);
    communicate(&bench, rest, ONSET_MS..REMOVAL_MS);
    no_ill_effects(&bench);
    bench
}

/// The cases of ECSS 5.3.3.2.2a, 5.3.3.2.2c: levels of a node without ground are as those of an open stub.
#[test]
fn a_disconnected_node_leaves_the_others_communicating() {
    for (node, rest) in [(2, [0, 1, 3, 4]), (0, [1, 2, 3, 4]), (4, [0, 1, 2, 3])] {
        the_rest_goes_on((Fault::Disconnect(node), Some(Fault::Reconnect(node))), &rest);
    }
}

/// The case of ECSS 5.3.3.2.2b
#[test]
fn a_node_without_power_leaves_the_others_communicating() {
    the_rest_goes_on((Fault::PowerOff(2), Some(Fault::PowerOn(2))), &[0, 1, 3, 4]);
}

/// The cases of ECSS 5.3.3.2.2d (shield lost), 5.3.3.2.3a and b (cases 1 and 2: one wire open), c (3a: CAN_H at +7 V or
/// less), f (4: CAN_L at ground) and l (9: a termination lost). Errors occur, and retransmission corrects all of them.
#[test]
fn a_reduced_margin_leaves_all_communicating() {
    let mut destroyed = 0;
    for seed in 0..5 {
        destroyed += the_rest_goes_on(reduced_margin(seed), &ALL).wire.counters().destroyed;
    }
    assert!(destroyed > 0, "the margin is reduced");
}

/// The cases of ECSS 5.3.3.2.3d (3b: CAN_H at a voltage that transceivers survive), g (5: CAN_H at ground), h (6a: CAN_L at such a
/// voltage) and j (7: both wires together).
#[test]
fn a_short_in_range_blocks_the_bus_until_it_is_removed() {
    for position_m in [0.0, 15.0, 33.0, 40.0] {
        let bench = network((Fault::Short { position_m, level: true }, Some(Fault::ClearShorts)));
        before(&bench);
        silence(&bench);
        no_ill_effects(&bench);
    }
}

/// The bus is lost permanently (ECSS 5.3.3.2.3e, i; cases 3c, 6b and 6c: transceivers are destroyed).
#[test]
fn a_voltage_out_of_range_blocks_the_bus_for_ever() {
    let bench = network((Fault::Short { position_m: 15.0, level: true }, None));
    before(&bench);
    silence(&bench);
    assert_eq!(arrived(&bench, 0, 1, SETTLED_MS..LAST_MS), 0);
}

/// The case of ECSS 5.3.3.2.3k, 5.3.3.2.3k.1, 5.3.3.2.3k.2 (case 8: both wires at one location)
#[test]
fn a_cut_leaves_those_upstream_communicating() {
    let cut = |position_m| (Fault::Cut { position_m }, Some(Fault::Restore { position_m }));
    // Both pieces have two nodes or more: each is a bus.
    let bench = the_rest_goes_on(cut(25.0), &[0, 1, 2]);
    communicate(&bench, &[3, 4], ONSET_MS..REMOVAL_MS);
    assert_eq!(arrived(&bench, 0, 3, ONSET_MS + 1..REMOVAL_MS - 1), 0);
    // A node alone at the end finds no other node, and is never bus-off.
    let bench = the_rest_goes_on(cut(35.0), &[0, 1, 2, 3]);
    assert!(counts(&bench, 4).iter().all(|&(_, transmit, _)| transmit < 256));
}
