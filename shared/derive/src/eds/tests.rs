//! Names of constants, and PDOs from default values. The expected values are those of CiA 306 and CiA 301.

use std::path::Path;

use async_canopen_eds::DataSheet;

use super::names::{self, screaming};
use super::pdos::{self, CobId, Part};
use super::{expand, values};

fn sheet(text: &str) -> DataSheet {
    DataSheet::read(text.as_bytes()).unwrap()
}

/// A section of a VAR.
fn var(section: &str, name: &str, data_type: &str) -> String {
    format!(
        "[{section}]\nParameterName={name}\nObjectType=7\nDataType={data_type}\nAccessType=rw\nPDOMapping=1\n"
    )
}

/// A section of an entry with a default.
fn with_default(section: &str, data_type: &str, default: &str) -> String {
    format!("{}DefaultValue={default}\n", var(section, section, data_type))
}

fn names_of(text: &str) -> Vec<String> {
    let values = values::of(&sheet(text), &mut |error| panic!("{error}"));
    names::of(&values, ["TPDO_1".to_owned()].into())
}

#[test]
fn names_are_words_in_capitals() {
    for (title, name) in [
        ("Device type", "DEVICE_TYPE"),
        ("Highest sub-index supported", "HIGHEST_SUB_INDEX_SUPPORTED"),
        ("COB-IDs, EMCY", "COB_IDS_EMCY"),
        ("ProducerHeartbeatTime", "PRODUCER_HEARTBEAT_TIME"),
        ("Temp. (0.1 °C)", "TEMP_0_1_C"),
        ("2nd limit", "_2ND_LIMIT"),
        (" [x] ", "X"),
        ("Öffnung", "FFNUNG"),
        ("°", ""),
    ] {
        assert_eq!(screaming(title), name, "{title}");
    }
}

#[test]
fn doubled_and_reserved_names_have_their_index() {
    let vars = [
        var("6000", "Power", "5"),
        var("6001", "power", "5"),
        var("6002", "Power 6000", "5"),
        var("6003", "TPDO 1", "5"),
        var("6004", "%", "5"),
        var("6005", "Limit", "5"),
    ];
    let record = "[6006]\nParameterName=Limit\nObjectType=9\n".to_owned() + &var("6006sub1A", "Limit", "5");
    let expected = [
        "POWER_6000",
        "POWER_6001",
        "POWER_6000_6002",
        "TPDO_1_6003",
        "_6004",
        "LIMIT_6005",
        "LIMIT_6006_1A",
    ];
    assert_eq!(names_of(&(vars.concat() + &record)), expected);
}

#[test]
fn each_sub_index_of_a_compact_array_has_a_name() {
    let array = "[6000]\nParameterName=Levels\nObjectType=8\nDataType=3\nAccessType=ro\nCompactSubObj=2\n\
                 [6000Name]\nNrOfEntries=1\n2=Oil\n";
    assert_eq!(names_of(array), ["LEVELS_NUMBER_OF_OBJECTS", "LEVELS1", "LEVELS_OIL"]);
}

/// The COB-ID of TPDO 1 with this default.
fn cob_id(default: &str) -> Result<Option<CobId>, String> {
    let sheet = sheet(&with_default("1800sub1", "7", default));
    pdos::cob_id(&sheet, 0x1800).map_err(|error| error.to_string())?.transpose()
}

#[test]
fn cob_id_is_fixed_or_follows_the_node_id() {
    for text in ["$NODEID+0x180", "0x180+$NODEID", "$NODEID+384", "$NODEID + 0600", "$nodeid+0x40000180"] {
        assert_eq!(cob_id(text), Ok(Some(CobId::Node(0x180))), "{text}");
    }
    for text in ["0x185", "389", "0605", "0x40000185"] {
        assert_eq!(cob_id(text), Ok(Some(CobId::Fixed(0x185))), "{text}");
    }
    for text in ["0x80000185", "$NODEID+0xC0000180", "0xA0000185"] {
        assert_eq!(cob_id(text), Ok(None), "{text}");
    }
}

#[test]
fn cob_id_that_pdos_may_not_have_is_a_reason() {
    for (text, reason) in [
        ("0x20000185", "its COB-ID has 29 bits"),
        ("$NODEID+$NODEID+0x180", "its COB-ID follows the Node-ID in another way than base + Node-ID"),
        ("0x80", "COB-ID 080h is not for PDOs"),
        ("0x701", "COB-ID 701h is not for PDOs"),
        ("$NODEID+0x700", "COB-ID 701h is not for PDOs"),
        ("$NODEID+0x680", "COB-ID 6E0h is not for PDOs"),
        ("", "1800h sub-index 1 has no default"),
        ("0x18G", "line 7: [1800sub1] DefaultValue=0x18G: no number of 32 bits"),
    ] {
        let error = cob_id(text).unwrap_err();
        assert!(error.starts_with(reason), "{text}: {error}");
    }
}

/// What the first receive PDO carries, or the reason why it has no constant.
fn mapped(count: &str, entries: &[&str]) -> Result<Vec<Part>, String> {
    let mut text = with_default("1400sub1", "7", "$NODEID+0x200") + &with_default("1600sub0", "5", count);
    for (sub, entry) in (1..).zip(entries) {
        text += &with_default(&format!("1600sub{sub}"), "7", entry);
    }
    text += &(var("6000", "Opening", "5") + &var("6001", "Name", "9") + &var("6002", "Flag", "1"));
    let sheet = sheet(&text);
    let values = values::of(&sheet, &mut |error| panic!("{error}"));
    let mut pdos = pdos::of(&sheet, &values, &mut |error| panic!("{error}"));
    assert_eq!(pdos.len(), 1);
    pdos.remove(0).mapped.map(|mapped| mapped.parts)
}

#[test]
fn mapping_of_objects_and_gaps() {
    let opening = || Part::Object { at: (0x6000, 0), title: "Opening".into(), data_type: 5 };
    assert_eq!(mapped("1", &["0x60000008"]), Ok(vec![opening()]));
    assert_eq!(mapped("2", &["0x00060010", "1610612744"]), Ok(vec![Part::Gap { data_type: 6 }, opening()]));
}

#[test]
fn mapping_without_constant_has_a_reason() {
    for (count, entries, reason) in [
        ("0", &[][..], "1600h maps nothing"),
        ("2", &["0", "0x00000000"], "1600h maps nothing"),
        ("", &[], "1600h sub-index 0 has no default"),
        ("254", &[], "1600h maps 254 values, at most 8 are allowed"),
        ("1", &[], "1600h sub-index 1 has no default"),
        ("1", &["0x60030008"], "it carries 6003h sub-index 0, which is no value of the data sheet"),
        ("1", &["0x60000010"], "it carries 16 bits of 6000h sub-index 0, whose type UNSIGNED8 has 8"),
        ("1", &["0x60020008"], "it carries 8 bits of 6002h sub-index 0, whose type BOOLEAN has 1"),
        ("1", &["0x60010008"], "it carries 6001h sub-index 0, which is no number"),
        ("1", &["0x00080020"], "it carries 0008h sub-index 0, which is no value of the data sheet"),
        ("3", &["0x00070020", "0x00070020", "0x60000008"], "1600h maps 72 bits, at most 64 are allowed"),
    ] {
        assert_eq!(mapped(count, entries), Err(reason.to_owned()), "{count} {entries:?}");
    }
}

/// Given two declarations, one of which has no file, then the error has the whole path and the other one is there.
#[test]
fn missing_file_is_named_with_its_whole_path() {
    let nodes = syn::parse_str("struct A = \"none.eds\"; struct B = \"Cargo.toml\";").unwrap();
    let expanded = expand(&nodes, Path::new(env!("CARGO_MANIFEST_DIR"))).to_string();
    assert!(
        expanded.contains(concat!("no file ", env!("CARGO_MANIFEST_DIR"), "/none.eds: the path")),
        "{expanded}"
    );
    assert!(expanded.contains("Cargo.toml: no EDS or DCF (CiA 306)"), "{expanded}");
    assert!(expanded.contains("struct A") && expanded.contains("struct B"), "{expanded}");
    assert_eq!(expanded.matches("include_bytes").count(), 1);
}
