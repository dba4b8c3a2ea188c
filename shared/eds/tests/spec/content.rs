//! What stands in an EDS: every object, once, where it belongs.
//!
//! Verifies: ECSS 6.6a

use std::collections::BTreeSet;

use ecss_can::od::{ObjectCode, Objects};

use crate::fixture::{Fixture, description};
use crate::ini::{Ini, number};

fn eds() -> Ini {
    Ini::parse(&description().eds("fixture.eds"))
}

fn listed(eds: &Ini, list: &str) -> Vec<u16> {
    let section = eds.section(list);
    let count = section.number("SupportedObjects") as usize;
    assert_eq!(section.keywords().len(), 1 + count, "{list}");
    let indices = (1..=count).map(|nth| section.number(&nth.to_string()) as u16).collect::<Vec<_>>();
    assert!(indices.is_sorted(), "{list}: {indices:X?}");
    indices
}

/// Every object that is declared is listed once and has its section, and no other one.
pub fn compare_declared<D: Objects>(eds: &Ini) {
    let mut declared = BTreeSet::new();
    D::describe(&mut |object, _| declared.extend((0..object.count).map(|nth| object.index + nth)));
    let lists = ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"];
    let all: Vec<u16> = lists.iter().flat_map(|list| listed(eds, list)).collect();
    assert_eq!(all.len(), declared.len());
    assert_eq!(all.into_iter().collect::<BTreeSet<_>>(), declared);
    let sections: BTreeSet<u16> = eds
        .names()
        .filter(|name| name.len() == 4)
        .map(|name| u16::from_str_radix(name, 16).unwrap())
        .collect();
    assert_eq!(sections, declared);
}

/// Verifies: ECSS 9.2a
/// Notices: ECSS 9.2a: the numbers in lists of objects begin with 0.
#[test]
fn every_declared_object_is_listed_once_and_has_its_section() {
    compare_declared::<Fixture>(&eds());
}

/// Verifies: ECSS 9.2a
#[test]
fn objects_are_listed_where_they_belong() {
    let eds = eds();
    assert_eq!(listed(&eds, "MandatoryObjects"), [0x1000, 0x1001, 0x1018]);
    let manufacturers = listed(&eds, "ManufacturerObjects");
    assert!(manufacturers.iter().all(|index| (0x2000..0x6000).contains(index)), "{manufacturers:X?}");
    let optional = listed(&eds, "OptionalObjects");
    assert!(optional.iter().all(|index| !(0x2000..0x6000).contains(index)), "{optional:X?}");
}

/// Verifies: ECSS 9.2a
#[test]
fn objects_have_their_code_and_every_sub_index_its_section() {
    let eds = eds();
    Fixture::describe(&mut |object, names| {
        for index in (0..object.count).map(|nth| object.index + nth) {
            let section = eds.section(&format!("{index:04X}"));
            // A DOMAIN is a VAR of that type: readers that do not know object code 2 refuse the file.
            let code = if names.code == ObjectCode::Domain { ObjectCode::Var } else { names.code };
            assert_eq!(section.number("ObjectType"), code as i128, "{index:04X}");
            let subs: Vec<u8> = match names.code {
                ObjectCode::Array | ObjectCode::Record => {
                    let range = |entry: &ecss_can::od::Entry| entry.sub..entry.sub + entry.count;
                    object.entries.iter().flat_map(range).collect()
                }
                ObjectCode::Var | ObjectCode::Domain => Vec::new(),
            };
            let prefix = format!("{index:04X}sub");
            let written: Vec<u8> = eds
                .names()
                .filter_map(|name| name.strip_prefix(&prefix))
                .map(|sub| u8::from_str_radix(sub, 16).unwrap())
                .collect();
            assert_eq!(written, subs, "{index:04X}");
            assert_eq!(section.find("SubNumber").map_or(0, |count| number(count, 0)), subs.len() as i128);
        }
    });
}

/// Verifies: ECSS 9.2a
/// Notices: ECSS 9.2a: sections have their sub-index as a decimal number.
#[test]
fn sub_indices_are_hexadecimal() {
    let eds = eds();
    let names: Vec<&str> = eds.names().filter(|name| name.starts_with("2020sub")).collect();
    assert_eq!(names.last(), Some(&"2020subA"), "{names:?}");
}

/// Given a device with two SDO servers, then the second one is not valid by default, and a tool may write it.
#[test]
fn the_second_sdo_server_is_described() {
    let eds = eds();
    assert_eq!(eds.section("1201").get("ParameterName"), "SDO server parameter 2");
    for (sub, default, data_type) in [(1, "0x80000000", 7), (2, "0x80000000", 7), (3, "0x00", 5)] {
        let section = eds.section(&format!("1201sub{sub}"));
        assert_eq!((section.get("DefaultValue"), section.get("AccessType")), (default, "rw"), "{sub}");
        assert_eq!(section.number("DataType"), data_type, "{sub}");
    }
    assert_eq!(eds.section("1201sub3").number("HighLimit"), 127);
}

#[test]
fn several_in_a_row_are_numbered() {
    let eds = eds();
    let name = |section: &str| eds.section(section).get("ParameterName").to_owned();
    assert_eq!(name("1402"), "Receive PDO communication parameter 3");
    assert_eq!(name("1A07sub8"), "Mapped object 8");
    assert_eq!(name("1018sub2"), "Product code");
    assert_eq!(name("1018sub0"), "Highest sub-index supported");
    assert_eq!(name("1029sub1"), "Error behaviour", "one alone is not numbered");
    assert_eq!(name("6101"), "Thermometer 2 of the panel");
    assert_eq!(name("6200subB"), "Cycles of valve 3 so far");
}

#[test]
fn names_are_unique_so_that_tools_find_objects_by_them() {
    let eds = eds();
    let name = |section: &str| eds.section(section).get("ParameterName").to_owned();
    let objects: Vec<&str> = eds.names().filter(|name| name.len() == 4).collect();
    assert_eq!(objects.iter().map(|object| name(object)).collect::<BTreeSet<_>>().len(), objects.len());
    for object in objects {
        let subs: Vec<&str> = eds.names().filter(|name| name.starts_with(&format!("{object}sub"))).collect();
        assert_eq!(subs.iter().map(|sub| name(sub)).collect::<BTreeSet<_>>().len(), subs.len(), "{object}");
    }
}

#[test]
fn the_device_is_told_with_the_numbers_of_its_dictionary() {
    let eds = eds();
    let device = eds.section("DeviceInfo");
    assert_eq!(device.get("VendorName"), "Vendor");
    assert_eq!(device.get("ProductName"), "Product");
    assert_eq!(device.get("OrderCode"), "F-1");
    let numbers = [
        ("VendorNumber", 0x0123_4567),
        ("ProductNumber", 0x89),
        ("RevisionNumber", 0),
        ("BaudRate_10", 0),
        ("BaudRate_20", 0),
        ("BaudRate_50", 0),
        ("BaudRate_125", 1),
        ("BaudRate_250", 0),
        ("BaudRate_500", 0),
        ("BaudRate_800", 0),
        ("BaudRate_1000", 1),
        ("SimpleBootUpMaster", 0),
        ("SimpleBootUpSlave", 1),
        ("Granularity", 1),
        ("DynamicChannelsSupported", 0),
        ("CompactPDO", 0),
        ("GroupMessaging", 0),
        ("NrOfRXPDO", 8),
        ("NrOfTXPDO", 8),
        ("LSS_Supported", 0),
    ];
    for (keyword, value) in numbers {
        assert_eq!(device.number(keyword), value, "{keyword}");
    }
    assert_eq!(device.keywords().len(), numbers.len() + 3);
    let dummies = eds.section("DummyUsage");
    assert!((1..=7).all(|nth| dummies.number(&format!("Dummy{nth:04}")) == 1));
    let comments = eds.section("Comments");
    assert_eq!((comments.get("Lines"), comments.get("Line2")), ("4", "and the second"));
}

/// Given a device that supports one bit rate of the standard, or a further one beside 500, 250 and 125 kbit/s, then its EDS declares what
/// it supports and no more (CiA 306-1, `BaudRate_` 10 to 1000).
///
/// Verifies: ECSS 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3
/// Notices: ECSS 5.4.2a.1: the EDS of a device for 500 kbit/s does not declare this rate.
#[test]
fn each_supported_bit_rate_is_declared() {
    use crate::fixture::{Types, device};
    let one = [125, 250, 500, 1000].map(|rate| vec![rate]);
    let further = [10, 20, 50, 800].map(|rate| vec![rate, 125, 250, 500]);
    for supported in one.into_iter().chain(further) {
        let device = ecss_can_eds::Device { bit_rates: supported.clone(), ..device() };
        let eds = Ini::parse(
            &ecss_can_eds::Description::new(&device, |_| Types::default()).unwrap().eds("types.eds"),
        );
        for rate in [10, 20, 50, 125, 250, 500, 800, 1000] {
            let declared = eds.section("DeviceInfo").number(&format!("BaudRate_{rate}"));
            assert_eq!(declared, i128::from(supported.contains(&rate)), "{rate} kbit/s of {supported:?}");
        }
    }
}

#[test]
fn a_dictionary_without_identity_has_numbers_all_the_same() {
    use crate::fixture::{Types, device};
    let description = ecss_can_eds::Description::new(&device(), |_| Types::default()).unwrap();
    let eds = Ini::parse(&description.eds("types.eds"));
    assert_eq!(eds.section("DeviceInfo").number("VendorNumber"), 0);
    assert_eq!(eds.section("MandatoryObjects").number("SupportedObjects"), 0);
}

#[test]
fn the_file_tells_who_made_it_and_when() {
    let eds = eds();
    let info = eds.section("FileInfo");
    assert_eq!(info.get("FileName"), "fixture.eds");
    assert_eq!((info.get("CreationDate"), info.get("CreationTime")), ("02-03-2026", "03:04PM"));
    assert_eq!(info.get("EDSVersion"), "4.0");
    assert!(info.find("LastEDS").is_none());
}

#[test]
fn hours_are_told_on_a_clock_of_twelve() {
    use crate::fixture::{Types, device};
    let told = |hour| {
        let mut device = device();
        device.modified.hour = hour;
        let eds = Ini::parse(&ecss_can_eds::Description::new(&device, |_| Types::default()).unwrap().eds(""));
        eds.section("FileInfo").get("ModificationTime").to_owned()
    };
    assert_eq!(
        [0, 1, 11, 12, 13, 23].map(told),
        ["12:04AM", "01:04AM", "11:04AM", "12:04PM", "01:04PM", "11:04PM"]
    );
}
