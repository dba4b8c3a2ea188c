//! Heartbeat times that 1016h and 1017h cannot hold, and consumer times that are not above the period they watch.

use ecss_can::boot::Setting;
use ecss_can::profile::Profile;
use ecss_can::types::{Address, Duration, NodeId};

const HALF: Profile = Profile { heartbeat: Duration::from_micros(2_500), ..Profile::DEFAULT };
const NONE: Profile = Profile { heartbeat: Duration::ZERO, ..Profile::DEFAULT };
const LONG: Profile = Profile {
    heartbeat: Duration::from_millis(65_536),
    consumer: Duration::ZERO,
    ..Profile::DEFAULT
};
const MICROS: Profile = Profile { consumer: Duration::from_micros(250_040), ..Profile::DEFAULT };
const EQUAL: Profile = Profile {
    heartbeat: Duration::from_millis(250),
    consumer: Duration::from_millis(250),
    ..Profile::DEFAULT
};
/// Node 3 sends its heartbeat every 250 ms.
const SLOW_SLAVE: Profile = Profile {
    settings: &[Setting { node: NodeId::of::<3>(), at: Address::new(0x1017, 0), value: &[250, 0] }],
    ..Profile::DEFAULT
};
/// Node 3 expects one of the master every 100 ms.
const IMPATIENT_SLAVE: Profile = Profile {
    settings: &[Setting { node: NodeId::of::<3>(), at: Address::new(0x1016, 1), value: &[100, 0, 1, 0] }],
    ..Profile::DEFAULT
};
/// Node 3 expects one of node 4 every 150 ms, which is sent every 200 ms.
const IMPATIENT_PEER: Profile = Profile {
    settings: &[
        Setting { node: NodeId::of::<3>(), at: Address::new(0x1016, 2), value: &[150, 0, 4, 0] },
        Setting { node: NodeId::of::<4>(), at: Address::new(0x1017, 0), value: &[200, 0] },
    ],
    ..Profile::DEFAULT
};

const _: Profile = HALF.checked();
const _: Profile = NONE.checked();
const _: Profile = LONG.checked();
const _: Profile = MICROS.checked();
const _: Profile = EQUAL.checked();
const _: Profile = SLOW_SLAVE.checked();
const _: Profile = IMPATIENT_SLAVE.checked();
const _: Profile = IMPATIENT_PEER.checked();

fn main() {}
