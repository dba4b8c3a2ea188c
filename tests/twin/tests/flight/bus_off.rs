//! The master is driven into bus-off and comes back.

use can_wire::fault::{Effect, Fault, Nodes};
use twin::spacecraft::Bus;

use crate::craft::*;

/// ISO 11898-1: 128 times 11 recessive bits, at 1 Mbit/s on an idle bus.
const RECOVERY_US: u64 = 1408;

/// The master's receiver is deaf for two milliseconds while it sends: every dominant bit of its is a bit error, and its
/// counter runs to bus-off. It is alone with its slaves again after the pause of its policy and the recovery sequence;
/// nobody changes the bus.
///
/// Verifies: ECSS 5.6.2b
/// Verifies: ECSS 5.6.2c
#[test]
fn the_master_recovers_from_bus_off_and_keeps_its_slaves() {
    let mut craft = Craft::new(&MASTER_AND_THREE);
    craft.fly_to(1000);
    let (last, _) = *craft.heartbeats(1, Bus::Nominal).last().unwrap();
    let deaf = Fault::Glitch {
        nodes: Nodes::of(&[craft.board(1).0]),
        duration: ms(2),
        effect: Effect::Recessive,
    };
    craft.twin.wire_mut(Bus::Nominal).schedule(last + ms(249), deaf).unwrap();
    craft.fly_to(3500);

    let off = craft.said(1, "Nominal: error BusOff", last).unwrap_or_else(|| panic!("{}", craft.log(1)));
    let back = craft.said(1, "Nominal: error Active", off).unwrap_or_else(|| panic!("{}", craft.log(1)));
    let pause = ms(10);
    let recovered = pause + can_wire::time::Time::from_us(RECOVERY_US);
    // Slaves may talk meanwhile, and the driver looks every millisecond.
    assert!((recovered..recovered + ms(3)).contains(&back.since(off)), "{} us", back.since(off).as_us());
    for node in [2, 3, 4] {
        assert!(craft.is_operational(node, Bus::Nominal), "node {node}\n{}", craft.log(node));
        assert!(!craft.fell_back(node, last), "node {node}\n{}", craft.log(node));
    }
    assert!(craft.said(1, "active bus", last).is_none(), "{}", craft.log(1));
    craft.assert_nothing_lost();
}
