//! A CANopen slave without anything of ECSS, on one bus.

use async_canopen::node::{CanopenSlave, Device, Settings};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::types::NodeId;

use crate::bench::{Bench, Probe};

const NODE: NodeId = NodeId::of::<5>();

/// A value that is sent with SYNC, and one that is received.
#[derive(Debug, Objects)]
#[objects(device)]
struct Channel {
    /// Input
    #[object(0x6000, ro, pdo)]
    input: u16,
    /// Output
    #[object(0x6200, rww, pdo)]
    output: u16,
}

impl Device for Channel {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::node(0x200)).map(Channel::OUTPUT).receive(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Channel::INPUT).transmit(1)],
    );
}

/// Given a slave in Operational that answers the SDO requests of its client every 20 ms, then it sets each of its filters again
/// within 5 s.
///
/// Verifies: ECSS 6.10d
#[test]
fn busy_canopen_slave_sets_each_filter_within_five_seconds() {
    let slave = || CanopenSlave::new(NODE, &Settings::DEFAULT, Channel::default());
    let mut bench = Bench::on_one_bus(slave, Probe::default());
    bench.start();
    bench.see_eleven_recessive_bits();
    bench.receive(WireFrame::standard(0x000, &[1, 5]));
    bench.pool.run_until_stalled();
    bench.drain();
    let before = bench.wire.replaced_filters();
    for _ in 0..250 {
        // Upload of 1000h.
        bench.receive(WireFrame::standard(0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
        bench.pool.run_until_stalled();
        assert!(bench.drain().contains(&(0x585, 0x43)));
        bench.run_for(Time::from_us(19_800));
    }
    let after = bench.wire.replaced_filters();
    // NMT, SYNC, SDO, the master's heartbeat, one of 1016h, one RPDO, and heartbeats with its own Node-ID.
    assert_eq!(after.len(), 7);
    assert!(after.iter().zip(before).all(|(after, before)| *after > before), "{after:?}");
}
