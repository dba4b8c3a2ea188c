//! Short forms for benches, flips and what stations were told.
//!
//! Unless a test says otherwise, nodes lie at one place, run at 1 Mbit/s (a bit is 1 us) and send 080h without data at
//! 20 us. On paper its bits are `0000 1 00000 (1) 00000 (1) 0000`, then the CRC sequence: stuff bits at 10 and 16, the
//! CRC delimiter at 38, the ACK slot at 39, EOF from 41 to 47.

use can_wire::controller::{ErrorCounters, ErrorKind, NodeIndex, WireEvent};
use can_wire::fault::{Effect, Fault, Flip, Nodes, Place};
use can_wire::field::Field;
use can_wire::frame::WireFrame;
use can_wire::station::{Bench, Station};
use can_wire::time::Time;
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

/// A node that sends 080h at 20 us, and `receivers` that do not send.
pub fn sender_and(receivers: usize) -> Bench {
    let mut stations = vec![Station::default().sending(us(SOF), sync())];
    stations.extend((0..receivers).map(|_| Station::default()));
    Bench::together(stations)
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

/// Dominant for everybody from `from` us on, for `length` us.
pub fn hold_dominant(bench: &mut Bench, from: u64, length: u64) {
    let fault = Fault::Glitch { nodes: Nodes::ALL, duration: us(length), effect: Effect::Dominant };
    bench.wire.schedule(us(from), fault).unwrap();
}

/// From the start on.
pub fn from_start(bench: &mut Bench, faults: impl IntoIterator<Item = Fault>) {
    for fault in faults {
        bench.wire.schedule(Time::ZERO, fault).unwrap();
    }
}

pub fn tec(bench: &Bench, node: NodeIndex) -> u16 {
    bench.wire.error_counters(node).transmit
}

pub fn rec(bench: &Bench, node: NodeIndex) -> u16 {
    bench.wire.error_counters(node).receive
}

/// Every error that `node` was told of.
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

/// `count` random cases, the same each time. PROPTEST_CASES and PROPTEST_RNG_SEED make more and other ones.
pub fn cases(count: u32) -> ProptestConfig {
    let rng_seed = RngSeed::Fixed(11898);
    ProptestConfig { cases: count, failure_persistence: None, rng_seed, ..ProptestConfig::default() }
}
