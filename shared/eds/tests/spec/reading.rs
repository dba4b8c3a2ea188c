//! Files of other tools: numbers as CiA 306 has them, and what two devices of a network send.

use ecss_can_eds::DataSheet;
use ecss_can_eds::network::{Conflict, Sender, conflicts};

/// The value of 2000h at node 5, with this text.
fn number(text: &str) -> Option<u32> {
    let sheet = DataSheet::read(format!("[2000]\nDefaultValue={text}\n").as_bytes()).unwrap();
    sheet.object(0x2000, 0, 5).ok().flatten().map(|value| value.number)
}

#[test]
fn numbers_are_decimal_hexadecimal_and_octal() {
    for (text, expected) in [
        ("0", 0),
        ("00", 0),
        ("0x0", 0),
        ("9", 9),
        ("010", 8),
        ("0376", 254),
        ("0x10", 16),
        ("0Xff", 255),
        ("0xFf", 255),
        ("037777777777", u32::MAX),
        ("4294967295", u32::MAX),
        ("0xFFFFFFFF", u32::MAX),
        ("0x00000000FFFFFFFF", u32::MAX),
        ("-1", u32::MAX),
        ("- 1", u32::MAX),
        ("-2147483648", 0x8000_0000),
        ("-0x10", 0xFFFF_FFF0),
        ("-010", 0xFFFF_FFF8),
        ("+7", 7),
        ("+ 7", 7),
        ("7 ; seven", 7),
    ] {
        assert_eq!(number(text), Some(expected), "{text}");
    }
    for text in [
        "x",
        "0x",
        "08",
        "0o10",
        "0b1",
        "1.0",
        "1e3",
        "12h",
        "0xG",
        "1 2",
        "0x 1",
        "4294967296",
        "-2147483649",
        "--1",
        "1-",
        "+",
        "-",
    ] {
        assert_eq!(number(text), None, "{text}");
    }
}

#[test]
fn node_id_stands_at_any_place_of_a_sum() {
    for text in [
        "$NODEID+0x180",
        "$NODEID + 0x180",
        "0x180+$NODEID",
        "0x180 + $NODEID",
        "$nodeid+0X180",
        "$NodeId+384",
        "0600+$NODEID",
        "+$NODEID+0x180",
        "0x100+$NODEID+0x80",
        "$NODEID\t+\t0x180",
    ] {
        assert_eq!(number(text), Some(0x185), "{text}");
    }
    assert_eq!(number("$NODEID"), Some(5));
    assert_eq!(number("$NODEID+0xC0000180"), Some(0xC000_0185));
    for text in ["$NODEID+", "+", "$NODEID 0x180", "$NODEID*2", "NODEID+1", "$NODEID+0xFFFFFFFF", "$NODE ID"]
    {
        assert_eq!(number(text), None, "{text}");
    }
}

/// Given a value that is no number, then the error names line, section, key, value and what is allowed.
#[test]
fn wrong_entry_is_named_with_its_line() {
    let sheet = DataSheet::read(b"[2000]\r\n;\r\n[ 2000SUB1 ]\r\nDEFAULTVALUE = many\r\n").unwrap();
    let error = sheet.object(0x2000, 1, 5).unwrap_err().to_string();
    let expected = "line 4: [2000SUB1] DEFAULTVALUE=many: no number of 32 bits; allowed are decimal, 0x with hexadecimal digits, 0 with \
                    octal digits, and a sum with $NODEID";
    assert_eq!(error, expected);
}

/// A DCF in Windows-1252 with the COB-IDs of a node, in the forms of several tools.
fn dcf(node: &str, tpdo: &str) -> Vec<u8> {
    let text = format!(
        "[DeviceInfo]\rVendorName=M\u{FC}ller\r[DeviceComissioning]\rNodeID = {node}\r[1005]\rDefaultValue=0x80\r\
         [1014]\rDefaultValue=0x80 + $NODEID\r[1800SUB1]\rDefaultValue=none\rParameterValue = {tpdo}\r\
         [1801sub1]\rDefaultValue=$NODEID+0x80000280\r[1A00sub0]\rDefaultValue=0xFF\r[1A00sub1]\rDefaultValue=\r\
         [2000]\rParameterName=#1\rDefaultValue=many\r"
    );
    text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect()
}

/// Verifies: ECSS 6.10l
#[test]
fn senders_are_read_from_files_of_other_tools() {
    let sender = Sender::of_dcf("a.dcf", &dcf("05", "0605")).unwrap();
    let expected = [(0x705, "heartbeat"), (0x085, "1014h"), (0x185, "1800h")];
    assert_eq!((sender.node, &sender.sent), (5, &expected.map(|(id, from)| (id, from.to_owned())).to_vec()));
    let other = Sender::of_dcf("b.dcf", &dcf("0x6", "0x17F+$NodeID")).unwrap();
    let both = Conflict::CobId(0x185, ["a.dcf (1800h)".into(), "b.dcf (1800h)".into()]);
    assert_eq!(conflicts(&[sender, other]), [both]);
}

/// Given a device with a valid second SDO channel (1201h), then it sends the COB-ID of its answers. One that is not valid counts as nothing.
///
/// Verifies: ECSS 6.10l
#[test]
fn answers_of_a_second_sdo_server_are_sent() {
    let mut file = dcf("5", "0x185");
    file.extend(b"[1201sub2]\rDefaultValue=0x80000000\r");
    let ids = |file: &[u8]| Sender::of_dcf("a.dcf", file).unwrap().sent.into_iter().map(|(id, _)| id);
    assert_eq!(ids(&file).collect::<Vec<_>>(), [0x705, 0x085, 0x185]);
    file.extend(b"ParameterValue=0x6B5\r");
    assert_eq!(ids(&file).collect::<Vec<_>>(), [0x705, 0x085, 0x6B5, 0x185]);
}

/// Given an entry that the comparison needs and that is not understood, then the error names file, line, section, key and value.
#[test]
fn dcf_without_a_needed_value_is_refused() {
    for (node, tpdo, said) in [
        ("0", "1", "a.dcf: line 4: [DeviceComissioning] NodeID=0: no Node-ID; allowed are 1 to 127"),
        ("five", "1", "a.dcf: line 4: [DeviceComissioning] NodeID=five: no Node-ID; allowed are 1 to 127"),
        ("", "1", "a.dcf: no entry [DeviceComissioning] NodeID: a DCF has 1 to 127"),
        ("5", "0x18G", "a.dcf: line 11: [1800SUB1] ParameterValue=0x18G: no number of 32 bits"),
    ] {
        let error = Sender::of_dcf("a.dcf", &dcf(node, tpdo)).unwrap_err().to_string();
        assert!(error.starts_with(said), "{error}");
    }
    let error = Sender::of_dcf("a.dcf", b"just a text").unwrap_err().to_string();
    assert!(error.starts_with("a.dcf: no EDS or DCF (CiA 306)"), "{error}");
}
