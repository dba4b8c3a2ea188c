//! Values: types, limits, access rights, and what follows the Node-ID.
//!
//! Verifies: ECSS 6.6a

use ecss_can::od::checked::find;
use ecss_can::od::{DataType, Objects};
use ecss_can::types::{Address, NodeId};

use crate::fixture::{Fixture, description, fixture};
use crate::ini::{Ini, Section, number};

fn eds() -> Ini {
    Ini::parse(&description().eds("fixture.eds"))
}

#[test]
fn values_of_every_type_are_written_as_readers_expect() {
    let eds = eds();
    let expected = [
        ("6001", "0x0001", Some("1")),
        ("6002", "0x0002", Some("-1")),
        ("6003", "0x0003", Some("-2")),
        ("6004", "0x0004", Some("-69997")),
        ("6005", "0x0005", Some("0x07")),
        ("6006", "0x0006", Some("0x0ABC")),
        ("6007", "0x0007", None), // write-only
        ("6008", "0x0008", Some("-0.1")),
        ("6009", "0x0009", Some("a = b")),
        ("600A", "0x000A", Some("00AB0A")),
        ("600B", "0x000B", Some("hi")),
        ("600C", "0x000C", None), // a time: readers disagree on how it is written
        ("600D", "0x000D", None),
        ("600F", "0x000F", None), // a DOMAIN
        ("6010", "0x0010", Some("-3")),
        ("6011", "0x0011", Some("1e-20")),
        ("6012", "0x0012", Some("-4")),
        ("6013", "0x0013", Some("-5")),
        ("6014", "0x0014", Some("6")),
        ("6015", "0x0015", Some("-9223372036854775808")),
        ("6016", "0x0016", Some("0x000018")),
        ("6018", "0x0018", Some("0x0000000019")),
        ("6019", "0x0019", Some("0x00000000001A")),
        ("601A", "0x001A", Some("0x0000000000001B")),
        ("601B", "0x001B", Some("0xFFFFFFFFFFFFFFFF")),
        ("6020", "0x0008", Some("0")), // without a point: the same as a bit pattern
        ("6021", "0x0011", Some("-0")),
        ("6022", "0x0012", None), // zero of a type that not all know
        ("6023", "0x0019", None),
        ("6024", "0x000B", None),
        ("6200sub0", "0x0005", Some("0x0B")),
    ];
    for (name, data_type, default) in expected {
        let section = eds.section(name);
        assert_eq!((section.get("DataType"), section.find("DefaultValue")), (data_type, default), "{name}");
    }
}

#[test]
fn access_rights_and_mapping_are_told() {
    let eds = eds();
    let told = |name: &str| {
        let section = eds.section(name);
        (section.get("AccessType").to_owned(), section.number("PDOMapping"))
    };
    assert_eq!(told("6002"), ("rw".into(), 0));
    assert_eq!(told("6005"), ("rwr".into(), 1));
    assert_eq!(told("6006"), ("rww".into(), 1));
    assert_eq!(told("6007"), ("wo".into(), 0));
    assert_eq!(told("600A"), ("ro".into(), 0));
    assert_eq!(told("601B"), ("const".into(), 0));
    assert_eq!(told("6100sub3"), ("ro".into(), 1));
    assert_eq!(told("6100sub0"), ("const".into(), 0));
}

#[test]
fn limits_are_told_where_there_are_any() {
    let eds = eds();
    let told = |name: &str| {
        let limit = |keyword| eds.section(name).find(keyword).map(str::to_owned);
        (limit("LowLimit"), limit("HighLimit"))
    };
    assert_eq!(told("6002"), (Some("-100".into()), Some("100".into())));
    assert_eq!(told("6004"), (Some("-70000".into()), None));
    assert_eq!(told("6005"), (None, Some("0xC8".into())));
    assert_eq!(told("6003"), (None, None));
    assert_eq!(told("1029sub1"), (None, Some("0x02".into())));
}

/// The value of a section at a node, and the bytes that the dictionary has.
fn compare(section: &Section, node: u8, data_type: DataType, bytes: &[u8]) {
    let text = section.get("DefaultValue");
    let equal = match data_type {
        DataType::VisibleString => text.as_bytes() == bytes,
        DataType::OctetString => text == bytes.iter().map(|byte| format!("{byte:02X}")).collect::<String>(),
        DataType::UnicodeString => text.encode_utf16().flat_map(u16::to_le_bytes).eq(bytes.iter().copied()),
        DataType::Real32 => text.parse::<f32>().unwrap().to_le_bytes() == bytes,
        DataType::Real64 => text.parse::<f64>().unwrap().to_le_bytes() == bytes,
        _ => number(text, node).to_le_bytes().starts_with(bytes),
    };
    assert!(equal, "{section:?}, node {node}: {bytes:02X?}");
}

/// Integers of 24, 40, 48 and 56 bits and UNICODE_STRINGs: without a default they are zero or empty.
fn is_rare(data_type: DataType) -> bool {
    matches!(data_type.index(), 0x0B | 0x10 | 0x12..=0x14 | 0x16..=0x1A)
}

/// Whether a reader who knows the Node-ID has the values of a fresh device; gives the objects without a default.
pub fn compare_fresh<D: Objects>(eds: &Ini, make: impl Fn(NodeId) -> D) -> Vec<u16> {
    let mut without = Vec::new();
    for node in [2, 3, 127] {
        let mut device = make(NodeId::new(node).unwrap());
        without.clear();
        for ((index, sub), section) in eds.values() {
            let mut found = find(&mut device, Address::new(index, sub)).unwrap();
            let data_type = found.entry.data_type;
            assert_eq!(section.number("DataType"), data_type.index().into());
            let mut bytes = [0; 300];
            let len = found.read(0, &mut bytes);
            match section.find("DefaultValue") {
                Some(_) => compare(section, node, data_type, &bytes[..len]),
                None if is_rare(data_type) && bytes[..len].iter().all(|byte| *byte == 0) => {}
                None => without.push(index),
            }
        }
    }
    without
}

#[test]
fn reader_with_the_node_id_has_every_value_of_a_fresh_device() {
    // Errors of the past; write-only; times; a DOMAIN; what follows the Node-ID in no way that an EDS can tell.
    let others = [0x2030, 0x2103, 0x2104, 0x2105, 0x6007, 0x600C, 0x600D, 0x600F];
    assert_eq!(compare_fresh(&eds(), fixture), [&[0x1003; 8][..], &others].concat());
}

/// Verifies: ECSS 6.10a
#[test]
fn what_follows_the_node_id_is_a_formula_with_the_node_id_first() {
    let eds = eds();
    let default = |name: &str| eds.section(name).get("DefaultValue").to_owned();
    assert_eq!(default("1014"), "$NODEID+0x80");
    assert_eq!(default("1400sub1"), "$NODEID+0xC0000200");
    assert_eq!(default("1803sub1"), "$NODEID+0xC0000480");
    assert_eq!(default("1804sub1"), "0xC0000000");
    assert_eq!(default("1200sub1"), "$NODEID+0x600");
    assert_eq!(default("2101"), "$NODEID+0x0");
    assert_eq!(default("2102"), "$NODEID+0xC0000380");
    assert_eq!(default("1018sub4"), "$NODEID+0x3E8");
}

#[test]
fn device_with_one_node_id_has_numbers_instead_of_formulas() {
    let device = ecss_can_eds::Device { nodes: 5..=5, ..crate::fixture::device() };
    let eds = Ini::parse(&ecss_can_eds::Description::new(&device, fixture).unwrap().eds("one.eds"));
    let default = |name: &str| eds.section(name).get("DefaultValue").to_owned();
    assert_eq!(default("1014"), "0x00000085");
    assert_eq!(default("2103"), "0x000500FA");
}

#[test]
fn defaults_keep_limits_and_everything_keeps_its_type() {
    let eds = eds();
    let mut numbers = 0;
    Fixture::describe(&mut |object, _| {
        for entry in object.entries {
            let Some(bytes) = entry.data_type.size().filter(|_| entry.data_type != DataType::TimeOfDay)
            else {
                continue;
            };
            if matches!(entry.data_type, DataType::Real32 | DataType::Real64) {
                continue;
            }
            let bits = 8 * bytes as u32;
            let (least, most) = if entry.data_type.is_signed() {
                (-(1_i128 << (bits - 1)), (1 << (bits - 1)) - 1)
            } else {
                (0, (1 << bits) - 1)
            };
            for section in sections(&eds, object.index, object.count, entry.sub, entry.count) {
                let limit = |keyword| section.find(keyword).map(|text| number(text, 0));
                let (low, high) = (limit("LowLimit").unwrap_or(least), limit("HighLimit").unwrap_or(most));
                assert!(least <= low && low <= high && high <= most, "{section:?}");
                if let Some(default) = section.find("DefaultValue") {
                    assert!(
                        (1..=127).all(|node| (low..=high).contains(&number(default, node))),
                        "{section:?}"
                    );
                    numbers += 1;
                }
            }
        }
    });
    assert!(numbers > 300, "{numbers}");
}

fn sections(eds: &Ini, index: u16, indices: u16, sub: u8, subs: u8) -> Vec<&Section> {
    let values = eds.values();
    let all = (index..index + indices).flat_map(|index| (sub..sub + subs).map(move |sub| (index, sub)));
    all.map(|at| values[&at]).collect()
}
