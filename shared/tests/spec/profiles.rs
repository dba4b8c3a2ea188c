//! The numbers of the two profiles and the objects they stand in.

use ecss_can::node::NodeObjects;
use ecss_can::od::checked::find;
use ecss_can::redundancy::{Access, Parameters};
use ecss_can::types::Address;
use mission::MissionObjects;
use mission::{LIBRECUBE, STANDARD};

use crate::bench::{node, span};

#[test]
fn librecube_has_the_numbers_of_the_prototype() {
    let millis = [
        LIBRECUBE.heartbeat,
        LIBRECUBE.consumer,
        LIBRECUBE.sync,
        LIBRECUBE.time,
        mission::COMMAND_PERIOD,
        mission::TELEMETRY_PERIOD,
    ]
    .map(|period| period.as_millis());
    assert_eq!(millis, [250, 2_500, 5_000, 10_000, 100, 100]);
    assert_eq!((LIBRECUBE.ttoggle, LIBRECUBE.ntoggle), (5, 10));
    assert_eq!(LIBRECUBE.access(node(4)), Access::Selective);
    assert_eq!(LIBRECUBE.access(node(3)), Access::Parallel);
    assert_eq!(LIBRECUBE.redundancy().toggling_time(), span(12_500));
}

/// Verifies: ECSS 8.3.1a
#[test]
fn a_slave_holds_the_objects_of_table_8_1() {
    let parameters = Parameters { ctoggle: 3, ..STANDARD.redundancy() };
    let mut objects = NodeObjects::new(node(5), &parameters, MissionObjects::<Vec<u8>>::default());
    let values: [(u16, u8, &[u8]); 8] = [
        (0x1016, 0, &[8]),
        (0x1016, 1, &[0xFA, 0, 1, 0]),
        (0x1017, 0, &[100, 0]),
        (0x2000, 0, &[4]),
        (0x2000, 1, &[0]),
        (0x2000, 2, &[2]),
        (0x2000, 3, &[50]),
        (0x2000, 4, &[3]),
    ];
    for (index, sub, value) in values {
        let found = find(&mut objects, Address::new(index, sub)).expect("it is there");
        let mut read = [0; 8];
        let len = found.read(0, &mut read);
        assert_eq!(&read[..len], value, "{index:04X} sub {sub}");
    }
    assert!(find(&mut objects, Address::new(0x2000, 5)).is_err());
}

#[test]
fn the_settling_time_covers_a_search_and_two_heartbeats() {
    assert_eq!(STANDARD.redundancy().settling_time(), span(2 * 250 + 2 * 100));
}
