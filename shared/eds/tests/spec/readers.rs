//! Readers of others that cannot be run here, as their public sources read: what they would refuse a file for.
//!
//! Verifies: ECSS 6.6a

use std::path::Path;

use crate::fixture::description;
use crate::ini::{Ini, Section};

const BOOLEAN: i128 = 0x01;
const REAL: [i128; 2] = [0x08, 0x11];
const STRINGS: [i128; 3] = [0x09, 0x0A, 0x0B];
const TIMES: [i128; 2] = [0x0C, 0x0D];
const DOMAIN: i128 = 0x0F;

/// The committed files.
fn committed() -> Vec<(String, Ini)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the root of the workspace");
    let entries = std::fs::read_dir(root.join("docs/eds")).expect("they are committed");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let file = |path: std::path::PathBuf| {
        let text = std::fs::read_to_string(&path).expect("a text");
        (path.file_name().expect("a name").to_string_lossy().into_owned(), Ini::parse(&text))
    };
    let files: Vec<_> = paths.map(file).collect();
    assert_eq!(files.len(), 7);
    files
}

fn fixture() -> Ini {
    Ini::parse(&description().eds("fixture.eds"))
}

/// Indices of the values that a reader refuses, once each.
fn refused(file: &Ini, reads: impl Fn(&Section) -> bool) -> Vec<u16> {
    let values = file.values();
    let mut refused: Vec<u16> =
        values.iter().filter(|(_, section)| !reads(section)).map(|((index, _), _)| *index).collect();
    refused.dedup();
    refused
}

fn is_decimal(text: &str) -> bool {
    let digits = text.strip_prefix('-').unwrap_or(text);
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
}

fn is_hexadecimal(text: &str) -> bool {
    let digits = text.strip_prefix("0x").unwrap_or_default();
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// gocanopen: a default of a type that it does not know is an error, and so is a number that does not fit. Its numbers are those of
/// Go's `strconv`: signed ones have no bit pattern, REALs are decimal.
fn gocanopen(section: &Section) -> bool {
    let Some(default) = section.find("DefaultValue") else { return true };
    let bits = match section.number("DataType") {
        data_type if REAL.contains(&data_type) => return default.parse::<f64>().is_ok(),
        0x09 | 0x0A | DOMAIN => return true,
        BOOLEAN | 0x02 | 0x05 => 8,
        0x03 | 0x06 => 16,
        0x04 | 0x07 => 32,
        0x15 | 0x1B => 64,
        _ => return false,
    };
    let is_signed = (0x02..=0x04).contains(&section.number("DataType")) || section.number("DataType") == 0x15;
    let number = crate::ini::number(default.strip_prefix("$NODEID+").unwrap_or(default), 0);
    let (low, high) = if is_signed { (-(1 << (bits - 1)), 1 << (bits - 1)) } else { (0, 1_i128 << bits) };
    (low..high).contains(&number)
}

/// dcf-tools of Lely: limits and defaults of numbers are integers, those of REALs their bit patterns; a formula has the Node-ID
/// first; times are days and milliseconds.
fn dcf_tools(section: &Section) -> bool {
    let data_type = section.number("DataType");
    ["DefaultValue", "LowLimit", "HighLimit"].into_iter().filter_map(|keyword| section.find(keyword)).all(
        |text| {
            let number = text.strip_prefix("$NODEID+").unwrap_or(text);
            match data_type {
                _ if STRINGS.contains(&data_type) => true,
                _ if TIMES.contains(&data_type) => text.split(' ').count() == 2,
                DOMAIN => text.bytes().all(|byte| byte.is_ascii_hexdigit()),
                _ => is_decimal(number) || is_hexadecimal(number),
            }
        },
    )
}

/// eds-utils knows VARs, ARRAYs and RECORDs only; node-canopen refuses `PDOMapping` in an object of code DOMAIN.
fn object_codes(section: &Section) -> bool {
    section.number("ObjectType") == 7 && section.find("PDOMapping").is_some()
}

/// node-canopen asks a default of a time for its date, which no text has.
fn node_canopen(section: &Section) -> bool {
    let data_type = section.number("DataType");
    !TIMES.contains(&data_type) || section.find("DefaultValue").is_none()
}

#[test]
fn committed_files_are_read_by_each_reader() {
    for (name, file) in committed() {
        assert_eq!(refused(&file, gocanopen), Vec::<u16>::new(), "{name}");
        assert_eq!(refused(&file, dcf_tools), Vec::<u16>::new(), "{name}");
        assert_eq!(refused(&file, object_codes), Vec::<u16>::new(), "{name}");
        assert_eq!(refused(&file, node_canopen), Vec::<u16>::new(), "{name}");
        let lists = file.names().filter(|name| name.len() == 4).map(|name| file.section(name));
        assert!(lists.into_iter().all(|object| [7, 8, 9].contains(&object.number("ObjectType"))), "{name}");
    }
}

/// What readers disagree on is written for most of them: a default of an integer of 24 to 56 bits or of a UNICODE_STRING stops
/// gocanopen, a decimal REAL stops dcf-tools. Zero and empty values stop none.
#[test]
fn values_of_every_type_are_read_by_most_readers() {
    let fixture = fixture();
    let rare = [0x600B, 0x6010, 0x6012, 0x6013, 0x6014, 0x6016, 0x6018, 0x6019, 0x601A];
    assert_eq!(refused(&fixture, gocanopen), rare);
    assert_eq!(refused(&fixture, dcf_tools), [0x6008, 0x6011]);
    assert_eq!(refused(&fixture, object_codes), Vec::<u16>::new());
    assert_eq!(refused(&fixture, node_canopen), Vec::<u16>::new());
}

/// gocanopen keeps an ARRAY in a slice of `SubNumber` entries, and refuses one with `CompactSubObj` instead.
#[test]
fn arrays_have_no_holes() {
    for (name, file) in committed() {
        for object in file.names().filter(|name| name.len() == 4) {
            let section = file.section(object);
            if section.number("ObjectType") == 8 {
                let subs = section.number("SubNumber");
                let all = (0..subs).all(|sub| file.names().any(|name| name == format!("{object}sub{sub:X}")));
                assert!(all, "{name} [{object}]");
            }
        }
    }
}
