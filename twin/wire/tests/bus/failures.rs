//! The failures of ECSS-E-ST-50-15C, Table 5-2, and what the network has to do in each.

use crate::common::*;
use can_wire::failure::Failure;
use can_wire::frame::WireFrame;
use can_wire::station::{Bench, Station};
use can_wire::time::Time;
use can_wire::wire::WireConfig;

/// Nodes at 0, 10, 20, 30 and 40 m.
const NODES: usize = 5;
/// Each node sends a frame per millisecond, up to here.
const LAST_MS: u64 = 120;
/// The failure begins and ends, ms.
const ONSET_MS: u64 = 20;
const REMOVAL_MS: u64 = 40;
/// From here on nothing may remind of it: 17 ms are the longest way back from bus-off at 1 Mbit/s.
const SETTLED_MS: u64 = 70;

/// Frame `n` of a node: no other is like it.
fn numbered(node: usize, n: u64) -> WireFrame {
    WireFrame::standard(0x181 + node as u16, &(n as u16).to_be_bytes())
}

/// Five nodes that talk all the time, a failure among them.
fn network(failure: Failure) -> Bench {
    let station = |node: usize| {
        let mut station = Station::default();
        station.queue.extend((1..=LAST_MS).map(|n| (Time::from_ms(n), numbered(node, n))));
        (10.0 * node as f64, station)
    };
    let mut bench = Bench::new(WireConfig::default(), (0..NODES).map(station).collect());
    bench.wire.schedule(Time::from_ms(ONSET_MS), failure.onset).unwrap();
    if let Some(removal) = failure.removal {
        bench.wire.schedule(Time::from_ms(REMOVAL_MS), removal).unwrap();
    }
    bench.leap(Time::from_ms(LAST_MS + 5));
    bench
}

/// How many of the frames that `from` wanted to send in these milliseconds arrived at `to` within them, or 1 ms later.
fn arrived(bench: &Bench, from: usize, to: usize, ms: std::ops::Range<u64>) -> u64 {
    let late = Time::from_ms(ms.end + 1);
    let got: Vec<WireFrame> =
        bench.stations[to].received().filter(|&(at, _)| at < late).map(|(_, frame)| frame).collect();
    ms.filter(|&n| got.contains(&numbered(from, n))).count() as u64
}

/// All of `nodes` hear all frames of each other in these milliseconds.
fn communicate(bench: &Bench, nodes: &[usize], ms: std::ops::Range<u64>) {
    for &from in nodes {
        for &to in nodes.iter().filter(|&&to| to != from) {
            assert_eq!(arrived(bench, from, to, ms.clone()), ms.end - ms.start, "{from} to {to}, ms {ms:?}");
        }
    }
}

/// Nobody hears anybody.
fn silence(bench: &Bench) {
    for from in 0..NODES {
        for to in (0..NODES).filter(|&to| to != from) {
            assert_eq!(arrived(bench, from, to, ONSET_MS + 1..REMOVAL_MS - 1), 0, "{from} to {to}");
        }
    }
}

const ALL: [usize; NODES] = [0, 1, 2, 3, 4];

/// The network is as before: all frames arrive, every node is error active, also what waited has been sent.
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

/// While it lasts the rest goes on; afterwards everybody does.
fn the_rest_goes_on(failure: Failure, rest: &[usize]) {
    let bench = network(failure);
    before(&bench);
    communicate(&bench, rest, ONSET_MS..REMOVAL_MS);
    no_ill_effects(&bench);
}

/// Errors come and every one of them is repaired by repetition.
fn all_go_on_with_errors(failure: impl Fn(u64) -> Failure) {
    let mut destroyed = 0;
    for seed in 0..5 {
        let bench = network(failure(seed));
        before(&bench);
        communicate(&bench, &ALL, ONSET_MS..REMOVAL_MS);
        no_ill_effects(&bench);
        destroyed += bench.wire.counters().destroyed;
    }
    assert!(destroyed > 0, "the margin is reduced");
}

fn all_resume_after(failure: Failure) {
    let bench = network(failure);
    before(&bench);
    silence(&bench);
    no_ill_effects(&bench);
}

fn nothing_goes_on(failure: Failure) {
    assert_eq!(failure.removal, None, "no repair in flight");
    let bench = network(failure);
    before(&bench);
    silence(&bench);
    assert_eq!(arrived(&bench, 0, 1, SETTLED_MS..LAST_MS), 0);
}

/// The case of ECSS 5.3.3.2.2a
#[test]
fn a_disconnected_node_leaves_the_others_communicating() {
    the_rest_goes_on(Failure::node_disconnected(2), &[0, 1, 3, 4]);
    the_rest_goes_on(Failure::node_disconnected(0), &[1, 2, 3, 4]);
}

/// The case of ECSS 5.3.3.2.2b
#[test]
fn a_node_without_power_leaves_the_others_communicating() {
    the_rest_goes_on(Failure::node_unpowered(2), &[0, 1, 3, 4]);
}

/// The case of ECSS 5.3.3.2.2c
#[test]
fn a_node_without_ground_leaves_the_others_communicating() {
    the_rest_goes_on(Failure::ground_lost(4), &[0, 1, 2, 3]);
}

/// The case of ECSS 5.3.3.2.2d
#[test]
fn a_lost_shield_leaves_all_communicating() {
    all_go_on_with_errors(Failure::shield_lost);
}

/// The case of ECSS 5.3.3.2.3a, 5.3.3.2.3b
#[test]
fn one_interrupted_wire_leaves_all_communicating() {
    all_go_on_with_errors(Failure::can_h_interrupted);
    all_go_on_with_errors(Failure::can_l_interrupted);
}

/// The case of ECSS 5.3.3.2.3c
#[test]
fn can_h_at_a_low_voltage_leaves_all_communicating() {
    all_go_on_with_errors(Failure::can_h_shorted_to_low_voltage);
}

/// The case of ECSS 5.3.3.2.3d
#[test]
fn can_h_at_voltage_in_range_blocks_the_bus_until_removed() {
    all_resume_after(Failure::can_h_shorted_in_range(15.0));
}

/// The bus is lost, and only another one helps (ECSS 5.3.3.2.3e, i).
#[test]
fn a_voltage_out_of_range_blocks_the_bus_for_ever() {
    nothing_goes_on(Failure::can_h_shorted_out_of_range(15.0));
    nothing_goes_on(Failure::can_l_shorted_out_of_range(25.0));
}

/// The case of ECSS 5.3.3.2.3f
#[test]
fn can_l_at_ground_leaves_all_communicating() {
    all_go_on_with_errors(Failure::can_l_shorted_to_ground);
}

/// The case of ECSS 5.3.3.2.3g
#[test]
fn can_h_at_ground_blocks_the_bus_until_it_is_removed() {
    all_resume_after(Failure::can_h_shorted_to_ground(0.0));
}

/// The case of ECSS 5.3.3.2.3h
#[test]
fn can_l_at_voltage_in_range_blocks_the_bus_until_removed() {
    all_resume_after(Failure::can_l_shorted_in_range(40.0));
}

/// The case of ECSS 5.3.3.2.3j
#[test]
fn shorted_wires_block_the_bus_until_it_is_removed() {
    all_resume_after(Failure::can_l_shorted_to_can_h(33.0));
}

/// The case of ECSS 5.3.3.2.3k, 5.3.3.2.3k.1, 5.3.3.2.3k.2
#[test]
fn a_cut_leaves_those_upstream_communicating() {
    // Both pieces have two nodes or more: each is a bus.
    let bench = network(Failure::both_interrupted(25.0));
    before(&bench);
    communicate(&bench, &[0, 1, 2], ONSET_MS..REMOVAL_MS);
    communicate(&bench, &[3, 4], ONSET_MS..REMOVAL_MS);
    assert_eq!(arrived(&bench, 0, 3, ONSET_MS + 1..REMOVAL_MS - 1), 0);
    no_ill_effects(&bench);
    // A node alone at the end: it finds nobody, and is never bus-off.
    let bench = network(Failure::both_interrupted(35.0));
    communicate(&bench, &[0, 1, 2, 3], ONSET_MS..REMOVAL_MS);
    assert!(counts(&bench, 4).iter().all(|&(_, transmit, _)| transmit < 256));
    no_ill_effects(&bench);
}

/// The case of ECSS 5.3.3.2.3l
#[test]
fn a_lost_termination_leaves_all_communicating() {
    all_go_on_with_errors(Failure::termination_lost);
}
