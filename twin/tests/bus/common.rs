//! Short forms for benches, flips and events of stations.
//!
//! Unless a test says otherwise, nodes are at the same position, run at 1 Mbit/s (a bit is 1 us) and send 080h without
//! data at 20 us. On paper its bits are `0000 1 00000 (1) 00000 (1) 0000`, then the CRC sequence: stuff bits at 10 and
//! 16, the CRC delimiter at 38, the ACK slot at 39, EOF from 41 to 47.

use can_twin::wire::controller::{ErrorCounters, ErrorKind, NodeIndex, Trace, WireEvent};
use can_twin::wire::fault::{Effect, Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::{Destruction, Observation};
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// SOF of the first frame of most tests, us.
pub const SOF: u64 = 20;
pub const CRC_DELIMITER: usize = 38;
pub const ACK_SLOT: usize = 39;
pub const ACK_DELIMITER: usize = 40;

pub fn us(us: u64) -> Time {
    Time::from_us(us)
}

/// End of bit `bit` of a frame with its SOF at `sof` us.
pub fn end_of(sof: u64, bit: usize) -> Time {
    us(sof + bit as u64 + 1)
}

pub fn sync() -> WireFrame {
    WireFrame::standard(0x080, &[])
}

pub fn frame(id: u16) -> WireFrame {
    WireFrame::standard(id, &[])
}

/// Returns a bench with a node that sends 080h at 20 us, and `receivers` nodes that do not send.
pub fn sender_and(receivers: usize) -> Bench {
    let mut stations = vec![sending(SOF, sync())];
    stations.extend((0..receivers).map(|_| idle()));
    Bench::together(stations)
}

/// As [`sender_and`], with faults from the start on; runs to `until` us.
pub fn disturbed(receivers: usize, faults: impl IntoIterator<Item = Fault>, until: u64) -> Bench {
    let mut bench = sender_and(receivers);
    from_start(&mut bench, faults);
    bench.leap(us(until));
    bench
}

/// Returns a station that only receives.
pub fn idle() -> Station {
    Station::default()
}

/// Returns a station that sends a frame at `at` us.
pub fn sending(at: u64, frame: WireFrame) -> Station {
    Station::default().sending(us(at), frame)
}

/// Returns a station that records the level changes of its line.
pub fn listener() -> Station {
    Station { watches_line: true, ..Station::default() }
}

/// Returns a listener that only monitors the bus and drives nothing.
pub fn silent() -> Station {
    let mut station = listener();
    station.attachment.as_mut().unwrap().silent = true;
    station
}

/// Makes `node` take part from `since` us on.
pub fn joins_at(bench: &mut Bench, node: NodeIndex, since: u64) {
    bench.stations[node].attachment.as_mut().unwrap().since = us(since);
}

/// Queues more frames of `node`, not before `at` us.
pub fn send(bench: &mut Bench, node: NodeIndex, at: u64, frames: impl IntoIterator<Item = WireFrame>) {
    bench.stations[node].queue.extend(frames.into_iter().map(|frame| (us(at), frame)));
}

pub fn schedule(bench: &mut Bench, at: u64, fault: Fault) {
    bench.wire.schedule(us(at), fault).unwrap();
}

pub fn flip(place: Place, nodes: &[NodeIndex]) -> Fault {
    Fault::Flip(Flip::new(place, Nodes::of(nodes)))
}

pub fn flip_bit(bit: usize, nodes: &[NodeIndex]) -> Fault {
    flip(Place::Bit(bit), nodes)
}

pub fn flip_field(field: Field, nodes: &[NodeIndex]) -> Fault {
    flip(Place::Field(field), nodes)
}

/// Holds the line dominant for all nodes from `from` us on, for `length` us.
pub fn hold_dominant(bench: &mut Bench, from: u64, length: u64) {
    let fault = Fault::Glitch { nodes: Nodes::ALL, duration: us(length), effect: Effect::Dominant };
    schedule(bench, from, fault);
}

/// Schedules faults from the start on.
pub fn from_start(bench: &mut Bench, faults: impl IntoIterator<Item = Fault>) {
    faults.into_iter().for_each(|fault| schedule(bench, 0, fault));
}

pub fn tec(bench: &Bench, node: NodeIndex) -> u16 {
    bench.wire.error_counters(node).transmit
}

pub fn rec(bench: &Bench, node: NodeIndex) -> u16 {
    bench.wire.error_counters(node).receive
}

/// Returns every error that was reported to `node`.
pub fn errors(bench: &Bench, node: NodeIndex) -> Vec<(Time, WireEvent)> {
    let is_error =
        |event: &WireEvent| matches!(event, WireEvent::TransmitError(_) | WireEvent::ReceiveError(_));
    bench.stations[node].log.iter().filter(|(_, event)| is_error(event)).copied().collect()
}

/// Every change of the error counters of `node`.
pub fn counts(bench: &Bench, node: NodeIndex) -> Vec<(Time, u16, u16)> {
    let change = |&(at, event): &(Time, WireEvent)| match event {
        WireEvent::Counters(ErrorCounters { transmit, receive }) => Some((at, transmit, receive)),
        _ => None,
    };
    bench.stations[node].log.iter().filter_map(change).collect()
}

pub fn starts(bench: &Bench, node: NodeIndex) -> Vec<Time> {
    bench.stations[node].told(WireEvent::Started)
}

pub fn sent(bench: &Bench, node: NodeIndex) -> Vec<Time> {
    bench.stations[node].told(WireEvent::Transmitted)
}

pub fn received(bench: &Bench, node: NodeIndex) -> Vec<(Time, WireFrame)> {
    bench.stations[node].received().collect()
}

pub fn transmit_error(kind: ErrorKind) -> WireEvent {
    WireEvent::TransmitError(kind)
}

pub fn receive_error(kind: ErrorKind) -> WireEvent {
    WireEvent::ReceiveError(kind)
}

/// The frames that `node` received.
pub fn frames(bench: &Bench, node: NodeIndex) -> Vec<WireFrame> {
    bench.stations[node].received().map(|(_, frame)| frame).collect()
}

/// The frames that were completed, their receivers, and their piece of the cable.
pub fn completed(records: &[Observation]) -> Vec<(Trace, Vec<NodeIndex>, usize)> {
    let completed = records.iter().filter_map(|record| match record {
        Observation::Completed { trace, receivers, segment } => {
            Some((*trace, receivers.iter().map(|&(node, _)| node).collect(), *segment))
        }
        _ => None,
    });
    completed.collect()
}

/// The first transmission without success: cause, end, transmitter, and the number of nodes that received it
/// nevertheless.
pub fn destroyed(records: &[Observation]) -> Option<(Destruction, Time, NodeIndex, usize)> {
    records.iter().find_map(|record| match record {
        Observation::Destroyed { cause, at, transmitter, receivers, .. } => {
            Some((*cause, *at, *transmitter, receivers.len()))
        }
        _ => None,
    })
}

/// `count` random cases, the same each time. PROPTEST_CASES and PROPTEST_RNG_SEED change number and seed.
pub fn cases(count: u32) -> ProptestConfig {
    let rng_seed = RngSeed::Fixed(11898);
    ProptestConfig { cases: count, failure_persistence: None, rng_seed, ..ProptestConfig::default() }
}
