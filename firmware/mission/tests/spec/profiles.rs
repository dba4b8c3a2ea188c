//! The numbers of the two profiles.

use ecss_can::link::access::BusAccess;
use mission::{COMMAND_PERIOD, LIBRECUBE, STANDARD, TELEMETRY_PERIOD};

use crate::{node, span};

#[test]
fn librecube_has_the_numbers_of_the_prototype() {
    let millis = [
        LIBRECUBE.heartbeat,
        LIBRECUBE.consumer,
        LIBRECUBE.sync,
        LIBRECUBE.time,
        COMMAND_PERIOD,
        TELEMETRY_PERIOD,
    ]
    .map(|period| period.as_millis());
    assert_eq!(millis, [250, 2_500, 5_000, 10_000, 100, 100]);
    assert_eq!((LIBRECUBE.ttoggle, LIBRECUBE.ntoggle), (5, 10));
    assert_eq!(LIBRECUBE.access(node(4)), BusAccess::Selective);
    assert_eq!(LIBRECUBE.access(node(3)), BusAccess::Parallel);
    assert_eq!(LIBRECUBE.redundancy().toggling_time(), span(12_500));
}

#[test]
fn standard_is_the_default_of_the_protocol() {
    let millis = [STANDARD.heartbeat, STANDARD.consumer, STANDARD.sync].map(|period| period.as_millis());
    assert_eq!((millis, STANDARD.ttoggle, STANDARD.slaves.len()), ([100, 250, 100], 2, 0));
}
