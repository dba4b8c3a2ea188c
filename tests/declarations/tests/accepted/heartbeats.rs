//! Heartbeat times at their limits.
#![deny(warnings)]

use ecss_can::boot::Setting;
use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::profile::Profile;
use ecss_can::types::{Address, Duration, NodeId};

const SHORT: Profile = Profile {
    heartbeat: Duration::from_millis(1),
    consumer: Duration::from_millis(2),
    budget: BudgetPolicy { cob_id: Rate::new(256, 2_000), ..Profile::DEFAULT.budget },
    ..Profile::DEFAULT
};
const LONG: Profile = Profile {
    heartbeat: Duration::from_millis(65_534),
    consumer: Duration::from_millis(65_535),
    ..Profile::DEFAULT
};
const NO_CONSUMER: Profile = Profile { consumer: Duration::ZERO, ..Profile::DEFAULT };
/// Node 3 watches the master, and node 4, which is faster than all others. Node 5 sends no heartbeat.
const BY_SETTINGS: Profile = Profile {
    settings: &[
        Setting { node: NodeId::of::<3>(), at: Address::new(0x1016, 1), value: &[101, 0, 1, 0] },
        Setting { node: NodeId::of::<3>(), at: Address::new(0x1016, 2), value: &[51, 0, 4, 0] },
        Setting { node: NodeId::of::<3>(), at: Address::new(0x1016, 3), value: &[0, 0, 6, 0] },
        Setting { node: NodeId::of::<4>(), at: Address::new(0x1017, 0), value: &[50, 0] },
        Setting { node: NodeId::of::<5>(), at: Address::new(0x1017, 0), value: &[0, 0] },
    ],
    ..Profile::DEFAULT
};

const _: Profile = Profile::DEFAULT.checked();
const _: Profile = SHORT.checked();
const _: Profile = LONG.checked();
const _: Profile = NO_CONSUMER.checked();
const _: Profile = BY_SETTINGS.checked();

fn main() {}
