//! The numbers of a profile and the objects they stand in.

use crate::instrument::Instrument;
use crate::instrument::STANDARD;
use ecss_can::node::NodeObjects;
use ecss_can::od::checked::find;
use ecss_can::redundancy::Parameters;
use ecss_can::types::Address;

use crate::bench::{node, span};

/// Verifies: ECSS 8.3.1a
#[test]
fn a_slave_holds_the_objects_of_table_8_1() {
    let parameters = Parameters { ctoggle: 3, ..STANDARD.redundancy() };
    let mut objects = NodeObjects::new(node(5), &parameters, Instrument::default());
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
        let mut found = find(&mut objects, Address::new(index, sub)).expect("it is there");
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
