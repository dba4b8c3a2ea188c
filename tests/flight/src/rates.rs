//! Checks of images for slower buses, which behave as those for 1 Mbit/s do.
//!
//! Profile `standard`: heartbeat and SYNC 100 ms, consumer time 250 ms.

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;

use crate::*;

const PERIOD: Time = ms(100);
const CUT: Time = ms(1_530);

/// Images of a profile for this bit rate.
pub fn at(kbit: u64, profile: &str) -> Images {
    build("pyboard-v11", &format!("{profile}+kbit-{kbit}"))
}

/// Returns the duration of `count` bits.
fn bits(kbit: u64, count: u64) -> Time {
    Time::from_ns(1_000_000 / kbit * count)
}

/// Given images for this bit rate, then slaves are found, commanded and stamp SYNC. When the nominal bus is cut next to
/// the master, then all this continues on the redundant bus.
pub fn assert_flies(kbit: u64) {
    let images = at(kbit, "standard");
    let mut flight = Flight::with(&MASTER_AND_THREE[..3], &images);
    flight.fly(CUT);
    flight.assert_operational([2, 3], Bus::Nominal);
    for node in [2, 3] {
        // A command each period, since the slave is operational.
        assert!(flight.executed(node) >= 7, "node {node}: {}", flight.executed(node));
        let stamps = flight.diagnostics(node).stamps.captured;
        assert!(stamps >= 7, "node {node} stamped {stamps} SYNCs");
    }
    // A frame without data has 44 bits, and stuff bits in the first 34.
    let sync = flight.sent(MASTER, Bus::Nominal, 0x080).last().unwrap();
    let length = sync.end.since(sync.start);
    let (least, most) = (bits(kbit, 43), bits(kbit, 44 + 33 / 4));
    assert!((least..most).contains(&length), "{} us", length.as_us());

    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    let before = [2, 3].map(|node| flight.executed(node));
    flight.fly(CUT + ms(1_000));
    let first = flight.on(Bus::Redundant).next().unwrap();
    assert_eq!((first.sender, first.id()), (0, Some(0x701)));
    // A heartbeat period, 5 ms, and the time on the bus: 16 attempts with error flags until error passive, and two
    // further frames.
    let bound = PERIOD + ms(5) + bits(kbit, 16 * (135 + 20) + 350);
    let taken = first.start.since(CUT);
    assert!(taken < bound, "{} us of {}", taken.as_us(), bound.as_us());
    flight.assert_operational([2, 3], Bus::Redundant);
    for (node, before) in [2, 3].into_iter().zip(before) {
        assert!(flight.executed(node) >= before + 7, "node {node}");
    }
    flight.assert_nothing_lost();
}

/// Given a master and one slave on a bus that is almost fully loaded (profile `librecube`: heartbeat 250 ms), when its
/// nominal bus is cut, then commands flow on the other one.
pub fn assert_carries_a_slave(kbit: u64) {
    let mut flight = Flight::with(&MASTER_AND_THREE[..2], &at(kbit, "librecube"));
    flight.fly_to(2_000);
    flight.assert_operational([2], Bus::Nominal);
    assert!(flight.executed(2) >= 10, "{}", flight.executed(2));
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    let before = flight.executed(2);
    flight.fly_to(4_000);
    flight.assert_operational([2], Bus::Redundant);
    assert!(flight.executed(2) >= before + 10, "{}", flight.executed(2));
    flight.assert_nothing_lost();
}
