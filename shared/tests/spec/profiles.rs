//! The numbers of the two profiles and the objects they stand in.

use ecss_can::od;
use ecss_can::profile::{LIBRECUBE, STANDARD};
use ecss_can::redundancy::{Access, Parameters};

use crate::bench::{node, span};

#[test]
fn librecube_has_the_numbers_of_the_prototype() {
    let millis = [
        LIBRECUBE.heartbeat,
        LIBRECUBE.consumer,
        LIBRECUBE.sync,
        LIBRECUBE.time,
        LIBRECUBE.command,
        LIBRECUBE.telemetry,
    ]
    .map(|period| period.as_millis());
    assert_eq!(millis, [250, 2_500, 5_000, 10_000, 100, 100]);
    assert_eq!((LIBRECUBE.ttoggle, LIBRECUBE.ntoggle), (5, 10));
    assert_eq!(LIBRECUBE.access(node(4)), Access::Selective);
    assert_eq!(LIBRECUBE.access(node(3)), Access::Parallel);
    assert_eq!(LIBRECUBE.redundancy().toggling_time(), span(12_500));
}

/// Verifies: ECSS 8.3.1a, 8.3.1b
#[test]
fn every_node_holds_the_objects_of_tables_8_1_and_8_2() {
    let parameters = Parameters { ctoggle: 3, ..STANDARD.redundancy() };
    let values = [
        (od::CONSUMER_HEARTBEAT, 0, Some(1)),
        (od::CONSUMER_HEARTBEAT, 1, Some(0x0001_00FA)),
        (od::PRODUCER_HEARTBEAT, 0, Some(100)),
        (od::REDUNDANCY, 0, Some(4)),
        (od::REDUNDANCY, 1, Some(0)),
        (od::REDUNDANCY, 2, Some(2)),
        (od::REDUNDANCY, 3, Some(10)),
        (od::REDUNDANCY, 4, Some(3)),
        (od::REDUNDANCY, 5, None),
        (od::SYNC_PERIOD, 0, None),
    ];
    for (index, sub, value) in values {
        assert_eq!(parameters.read(index, sub), value, "{index:04X} sub {sub}");
    }
}

#[test]
fn the_settling_time_covers_a_search_and_two_heartbeats() {
    assert_eq!(STANDARD.redundancy().settling_time(), span(2 * 250 + 2 * 100));
}
