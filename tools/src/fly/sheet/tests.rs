//! Data sheets that are read, and frames decoded by them.

use super::*;

const TEXT: &str = "[1800sub1]\nDefaultValue=$NODEID+0x180\n[1801sub1]\nDefaultValue=$NODEID+0x80000280\n\
    [1802sub1]\nDefaultValue=0x40000382\n\
    [1A00sub0]\nDefaultValue=3\n[1A00sub1]\nDefaultValue=0x20000110\n[1A00sub2]\nDefaultValue=0x20010008\n\
    [1A00sub3]\nDefaultValue=0x20020020\n[1A02sub0]\nDefaultValue=0\n\
    [2000]\nParameterName=Heater\n[2000sub1]\nParameterName=Temperature\nDataType=0x0003\n\
    [2001]\nParameterName=State\nDataType=0x0005\n[2002]\nParameterName=Power\nDataType=0x0008\n";

fn read(text: &str) -> Sheet {
    Sheet::read(text.as_bytes(), 5).unwrap()
}

#[test]
fn valid_pdos_with_objects_are_read() {
    let sheet = read(TEXT);
    assert_eq!((sheet.pdos.len(), &sheet.others[..], &sheet.notes[..]), (1, &[0x382][..], &[][..]));
    let Pdo { number, id, fields } = &sheet.pdos[0];
    assert_eq!((*number, *id), (1, 0x185));
    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["Heater, Temperature", "State", "Power"]);
}

/// Given the bytes of -5, 200 and 1.5 as IEEE 754 has it (3FC0 0000h), then they are values with names.
#[test]
fn frames_are_values_by_name() {
    let sheet = read(TEXT);
    let values = values(&sheet.pdos[0], &[0xFB, 0xFF, 200, 0, 0, 0xC0, 0x3F]).unwrap();
    let texts: Vec<_> = values.iter().map(|(name, value)| (*name, value.to_string())).collect();
    let expected = [("Heater, Temperature", "-5"), ("State", "200"), ("Power", "1.5")];
    assert_eq!(texts, expected.map(|(name, value)| (name, value.to_owned())));
    let heights: Vec<_> = values.iter().map(|(_, value)| value.height()).collect();
    assert_eq!(heights, [Some(-5.0), Some(200.0), Some(1.5)]);
    assert_eq!([Number::Bits(7, 8), Number::Short(f32::NAN)].map(Number::height), [None; 2], "no height");
    assert_eq!(super::values(&sheet.pdos[0], &[0; 8]), None, "another length");
}

#[test]
fn value_of_a_dcf_counts_before_the_default() {
    let text = TEXT.replacen("DefaultValue=", "ParameterValue=0x201\nDefaultValue=", 1);
    assert_eq!(read(&text).pdos[0].id, 0x201);
}

/// Given a PDO with an invalid value, then it is left out, and the note names line, section, key and value.
#[test]
fn wrong_value_costs_its_pdo_and_is_named() {
    for (good, wrong, said) in [
        ("$NODEID+0x180", "some", "line 2: [1800sub1] DefaultValue=some: no number of 32 bits"),
        (
            "$NODEID+0x180",
            "0x189AB",
            "line 2: [1800sub1] DefaultValue=0x189AB: allowed are identifiers of 11 bits",
        ),
        ("$NODEID+0x180", "", "[1800sub1] has no value"),
        ("$NODEID+0x180", "0x100000000", "[1800sub1] DefaultValue=0x100000000: no number of 32 bits"),
        ("DefaultValue=3", "DefaultValue=08", "line 8: [1A00sub0] DefaultValue=08: no number"),
        ("DefaultValue=3", "DefaultValue=65", "[1A00sub0] DefaultValue=65: allowed are 0 to 64"),
        ("DefaultValue=3", "DefaultValue=-1", "[1A00sub0] DefaultValue=-1: allowed are 0 to 64"),
        ("DefaultValue=3", "DefaultValue=4", "[1A00sub4] has no value"),
        ("DefaultValue=3", "DefaultValue=", "[1A00sub0] has no value"),
        ("0x20010008", "0x20010000", "line 12: [1A00sub2] DefaultValue=0x20010000: allowed are 1 to 64 bits"),
        ("0x20010008", "0x20010011", "line 14: [1A00sub3] DefaultValue=0x20020020: allowed are 1 to 64 bits"),
    ] {
        assert!(TEXT.contains(good), "{good}");
        let sheet = read(&TEXT.replacen(good, wrong, 1));
        assert_eq!(sheet.pdos, [], "{wrong}");
        assert_eq!(sheet.notes.len(), 1, "{:?}", sheet.notes);
        let note = &sheet.notes[0];
        assert!(note.contains(said) && note.ends_with("; TPDO 1 is left out"), "{note}");
    }
}

/// Given each oddity of files of other tools alone and in pairs, then the PDOs are those of the device, and a note names what is left
/// out.
#[test]
fn odd_data_sheets_are_read_alone_and_in_pairs() {
    let all = odd::all();
    assert!(all.len() > 3_000, "{}", all.len());
    for (name, odd) in all {
        let sheet = Sheet::read(&odd.bytes(), odd::NODE).unwrap_or_else(|error| panic!("{name}: {error}"));
        let Sheet { pdos, others, identity, notes, .. } = sheet;
        let expected = &odd.expected;
        let Sheet { pdos: expected_pdos, others: expected_others, .. } = expected;
        assert_eq!((&pdos, &others), (expected_pdos, expected_others), "{name}");
        assert_eq!(identity, expected.identity, "{name}");
        // Without properties that oddities of the text change: case, blanks, leading zeros of sub-indices.
        let folded = |text: &str| {
            let text: String = text.to_lowercase().split_whitespace().collect();
            text.replace("sub0", "sub").replace("sub0", "sub")
        };
        let notes: Vec<String> = notes.iter().map(|note| folded(note)).collect();
        let is_said = |said: &&str| notes.iter().any(|note| note.contains(&folded(said)));
        let is_all = odd.said.iter().all(is_said) && odd.said.len() == notes.len();
        assert!(is_all, "{name}: {:?} in {notes:?}", odd.said);
    }
}

/// Given a text that is no data sheet, then the error describes a data sheet.
#[test]
fn text_that_is_no_data_sheet_is_refused() {
    for text in [
        "",
        "# Read me\n\nThis device = a heater.\n",
        "<?xml version=\"1.0\"?>\n<ISO15745ProfileContainer/>\n",
        "[package]\nname = \"heater\"\n",
        "[1]\nvalue=2\n",
    ] {
        let error = Sheet::read(text.as_bytes(), 5).unwrap_err().to_string();
        assert!(error.contains("no EDS or DCF") && error.contains("[DeviceInfo]"), "{error}");
    }
    assert!(Sheet::read(b"\x7FELF\x01\x01\xFF\xFE", 5).is_err());
}

/// Given the committed data sheets, then nothing of them is left out.
#[test]
fn shipped_data_sheets_are_read_without_notes() {
    let folder = crate::images::support::project::path("docs/eds");
    for (file, node) in [
        ("master.eds", 1),
        ("master.dcf", 1),
        ("slave.eds", 3),
        ("slave-3.dcf", 3),
        ("minimal.eds", 6),
        ("minimal-librecube.eds", 6),
        ("minimal-6.dcf", 6),
    ] {
        let sheet = Sheet::read(&std::fs::read(folder.join(file)).unwrap(), node).unwrap();
        assert_eq!(sheet.notes, Vec::<String>::new(), "{file}");
        assert!(!sheet.pdos.is_empty() && sheet.identity.iter().all(Option::is_some), "{file}: {sheet:?}");
    }
}
