//! Odd data sheets: each oddity of files of other tools alone and in pairs, with the values that a flight needs.
//!
//! The expected values are defined together with the oddities; this module reads no file.

use Layout::{Entries, Lines, Sections, Text};

use super::{Field, Pdo, Sheet};

/// Node-ID of the device.
pub const NODE: u8 = 5;

/// A data sheet under construction, and the expected result of reading it.
#[derive(Clone)]
pub struct Odd {
    sections: Vec<(String, Vec<(String, String)>)>,
    /// Changes of the whole text, in this order.
    layout: Vec<Layout>,
    encode: fn(&str) -> Vec<u8>,
    /// Expected result.
    pub expected: Sheet,
    /// Expected parts of the notes, one for each.
    pub said: Vec<&'static str>,
}

/// A change of the whole text.
#[derive(Clone, Copy)]
enum Layout {
    Text(fn(&str) -> String),
    /// Each line, without its end.
    Lines(fn(&str) -> String),
    /// Each line of a section, from the name on.
    Sections(fn(&str) -> String),
    /// Each line of an entry: key and value.
    Entries(fn(&str, &str) -> String),
}

impl Layout {
    fn change(self, line: &str) -> String {
        match (self, line.strip_prefix('['), line.split_once('=')) {
            (Layout::Lines(change), ..) => change(line),
            (Layout::Sections(change), Some(name), _) => format!("[{}", change(name.trim_end_matches(']'))),
            (Layout::Entries(change), _, Some((key, value))) => change(key, value),
            _ => line.to_owned(),
        }
    }

    fn apply(self, text: &str) -> String {
        match self {
            Layout::Text(change) => change(text),
            _ => text.lines().map(|line| self.change(line) + "\n").collect(),
        }
    }
}

/// An oddity.
pub struct Oddity {
    /// Name of the oddity.
    pub name: String,
    /// Changed part: two oddities that change the same part exclude each other.
    changes: &'static str,
    apply: Box<dyn Fn(&mut Odd)>,
}

fn field(name: &str, data_type: u32, bits: u32) -> Field {
    Field { name: name.into(), data_type, bits }
}

/// A plain data sheet of two transmit PDOs.
fn plain() -> Odd {
    let mut sections: Vec<(String, Vec<_>)> = Vec::new();
    for line in include_str!("plain.eds").lines() {
        match line.split_once('=') {
            Some((key, value)) => {
                let (_, entries) = sections.last_mut().expect("a section");
                entries.push((key.to_owned(), value.to_owned()));
            }
            None => sections.push((line.trim_matches(['[', ']']).to_owned(), Vec::new())),
        }
    }
    let first =
        Pdo { number: 1, id: 0x185, fields: vec![field("Temp", 3, 16), field("Channels, Ten", 5, 8)] };
    let second = Pdo { number: 2, id: 0x285, fields: vec![field("Power", 8, 32)] };
    let identity = [0x191, 0x1234, 0x42, 0x1_0000].map(Some);
    Odd {
        sections,
        layout: Vec::new(),
        encode: |text| text.as_bytes().to_vec(),
        expected: Sheet { pdos: vec![first, second], identity, ..Sheet::default() },
        said: Vec::new(),
    }
}

impl Odd {
    fn section(&mut self, name: &str) -> &mut Vec<(String, String)> {
        if !self.sections.iter().any(|(own, _)| own == name) {
            self.sections.push((name.to_owned(), Vec::new()));
        }
        let section = self.sections.iter_mut().find(|(own, _)| own == name);
        &mut section.expect("it was added").1
    }

    fn set(&mut self, section: &str, key: &str, value: &str) {
        self.without(section, key);
        self.section(section).push((key.to_owned(), value.to_owned()));
    }

    fn without(&mut self, section: &str, key: &str) {
        self.section(section).retain(|(own, _)| own != key);
    }

    fn without_sections(&mut self, sections: &[&str]) {
        self.sections.retain(|(own, _)| !sections.contains(&&**own));
    }

    /// Expects that only the COB-ID of TPDO 1 is read.
    fn loses_the_first(&mut self) {
        let pdo = self.expected.pdos.remove(0);
        self.expected.others.push(pdo.id);
    }

    fn first(&mut self) -> &mut Pdo {
        &mut self.expected.pdos[0]
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut text = String::new();
        for (name, entries) in &self.sections {
            text += &format!("[{name}]\n");
            text.extend(entries.iter().map(|(key, value)| format!("{key}={value}\n")));
        }
        (self.encode)(&self.layout.iter().fold(text, |text, layout| layout.apply(&text)))
    }
}

/// Encodes ° and ü, the only characters of these files that are not ASCII.
fn windows_1252(text: &str) -> Vec<u8> {
    text.chars().map(|letter| u8::try_from(u32::from(letter)).expect("as in Latin-1")).collect()
}

fn utf_16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    "\u{FEFF}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes).collect()
}

fn odd(name: impl Into<String>, changes: &'static str, apply: impl Fn(&mut Odd) + 'static) -> Oddity {
    Oddity { name: name.into(), changes, apply: Box::new(apply) }
}

/// An oddity of the whole text.
fn laid_out(name: &str, changes: &'static str, layout: Layout) -> Oddity {
    odd(name, changes, move |odd| odd.layout.push(layout))
}

/// Returns the oddities of the text's layout. Of two oddities the first one is applied first: comments have no margins,
/// for example.
fn of_text() -> Vec<Oddity> {
    vec![
        laid_out("sections in capitals", "sections", Sections(|name| name.to_uppercase() + "]")),
        laid_out("sections in small letters", "sections", Sections(|name| name.to_lowercase() + "]")),
        laid_out("sub-indices with zeros", "sections", Sections(|name| name.replace("sub", "sub0") + "]")),
        laid_out("keys in capitals", "keys", Entries(|key, value| key.to_uppercase() + "=" + value)),
        laid_out("keys in small letters", "keys", Entries(|key, value| key.to_lowercase() + "=" + value)),
        laid_out("blanks around =", "equals", Entries(|key, value| format!("{key} = {value}"))),
        laid_out("tabs around =", "equals", Entries(|key, value| format!("{key}\t=\t{value}"))),
        laid_out("blanks in brackets", "brackets", Sections(|name| format!(" {name} ]"))),
        laid_out("no closing bracket", "brackets", Sections(str::to_owned)),
        laid_out("comments behind brackets", "brackets", Sections(|name| format!("{name}] ; an object"))),
        laid_out("blanks in front", "margins", Lines(|line| format!("  {line}"))),
        laid_out("blanks behind", "margins", Lines(|line| format!("{line} \t"))),
        laid_out("an entry in front of all sections", "head", Text(|text| format!("DefaultValue=1\n{text}"))),
        laid_out("end of file of DOS", "tail", Text(|text| format!("{text}\u{1A}\n"))),
        laid_out("empty lines", "between", Lines(|line| format!(" \n{line}"))),
        laid_out("comments", "between", Lines(|line| format!("; [1800sub1] DefaultValue=1\n{line}"))),
        laid_out("indented comments", "between", Lines(|line| format!("\t;DefaultValue=1\n{line}"))),
        laid_out("lines with #", "between", Lines(|line| format!("# DefaultValue=1\n{line}"))),
        laid_out("lines without =", "between", Lines(|line| format!("DefaultValue\n{line}"))),
        laid_out("lines without a key", "between", Lines(|line| format!("=1\n{line}"))),
        laid_out("CR LF", "ends", Text(|text| text.replace('\n', "\r\n"))),
        laid_out("CR", "ends", Text(|text| text.replace('\n', "\r"))),
        odd("byte order mark", "encoding", |odd| odd.encode = |text| ["\u{FEFF}", text].concat().into()),
        odd("UTF-8", "encoding", |odd| odd.set("DeviceInfo", "VendorName", "M\u{FC}ller")),
        odd("Windows-1252", "encoding", |odd| {
            odd.set("DeviceInfo", "VendorName", "M\u{FC}ller");
            odd.encode = windows_1252;
        }),
        odd("UTF-16, low byte first", "encoding", |odd| odd.encode = |text| utf_16(text, u16::to_le_bytes)),
        odd("UTF-16, high byte first", "encoding", |odd| odd.encode = |text| utf_16(text, u16::to_be_bytes)),
        odd("unknown sections", "unknown", |odd| {
            odd.set("Tools", "Items", "?");
            odd.set("M1SubExt6000", "DefaultValue", "$MODULE");
            odd.set("2000ObjectLinks", "ObjectLinks", "x");
            odd.set("", "1", "2");
        }),
    ]
}

/// Forms of numbers that a layout of the text may meet; tests of `eds` have all forms.
fn of_numbers() -> Vec<Oddity> {
    let defaults = [
        ("cob-id", "1800sub1", "0605"),
        ("cob-id", "1800sub1", "$NODEID-0x80+0x200"),
        ("cob-id", "1800sub1", "0x180+$NODEID ; of TPDO 1"),
        ("cob-id", "1800sub1", "0x580 - 0x400 + $NODEID"),
        ("mapping", "1A00sub1", "0x20000010 # Temp"),
        ("second", "1A00sub2", "04002405010"),
        ("mapping", "1A00sub0", "02"),
        ("device type", "1000", "0621"),
    ];
    let default = |(changes, section, text): (_, &'static str, &'static str)| {
        odd(format!("[{section}] {text}"), changes, move |odd| odd.set(section, "DefaultValue", text))
    };
    let data_type = odd("data type 0X3", "type", |odd| odd.set("2000", "DataType", "0X3"));
    defaults.map(default).into_iter().chain([data_type]).collect()
}

/// Names of objects.
fn of_names() -> Vec<Oddity> {
    let mut all = Vec::new();
    for text in ["Temp #", "#1", "Temp ; of the box", "a=b", "C:\\n", "\"Temp\"", "[Temp]", "Temp: box"] {
        all.push(odd(format!("name {text}"), "name", move |odd| {
            odd.set("2000", "ParameterName", text);
            text.clone_into(&mut odd.first().fields[0].name);
        }));
    }
    all.extend([
        odd("name in Windows-1252", "encoding", |odd| {
            odd.set("2002", "ParameterName", "Temp \u{B0}C");
            odd.encode = windows_1252;
            odd.expected.pdos.last_mut().unwrap().fields[0].name = "Temp \u{B0}C".into();
        }),
        odd("empty name", "name", |odd| {
            odd.set("2000", "ParameterName", "");
            odd.first().fields[0].name = "2000h sub 00h".into();
        }),
        odd("no name of the sub-index", "channels", |odd| {
            odd.without("200AsubA", "ParameterName");
            odd.first().fields[1].name = "Channels".into();
        }),
        odd("no name of the object", "channels", |odd| {
            odd.without_sections(&["200A"]);
            odd.first().fields[1].name = "Ten".into();
        }),
        odd("no object", "channels", |odd| {
            odd.without_sections(&["200A", "200Asub0", "200AsubA"]);
            odd.first().fields[1] = field("200Ah sub 0Ah", 0, 8);
        }),
        odd("CompactSubObj with names", "channels", |odd| {
            odd.without_sections(&["200Asub0", "200AsubA"]);
            odd.set("200A", "CompactSubObj", "10");
            odd.set("200A", "DataType", "0x5");
            odd.set("200AName", "NrOfEntries", "1");
            odd.set("200AName", "10", "Tenth");
            odd.first().fields[1].name = "Channels, Tenth".into();
        }),
        odd("CompactSubObj without names", "channels", |odd| {
            odd.without_sections(&["200Asub0", "200AsubA"]);
            odd.set("200A", "CompactSubObj", "0x0A");
            odd.set("200A", "DataType", "5");
            odd.first().fields[1].name = "Channels10".into();
        }),
        odd("CompactSubObj of 0", "compact", |odd| odd.set("2000", "CompactSubObj", "0")),
    ]);
    all
}

/// Returns oddities of entries that a flight does not need, and of missing entries.
fn of_the_rest() -> Vec<Oddity> {
    vec![
        odd("wrong values that no PDO needs", "needless", |odd| {
            odd.set("1800sub2", "DefaultValue", "asynchronous");
            odd.set("1800sub5", "DefaultValue", "0xZZ");
            odd.set("2002", "LowLimit", "$MODULE");
            odd.set("2002", "ObjectType", "VAR");
            odd.set("DeviceInfo", "NrOfTXPDO", "many");
            odd.set("FileInfo", "FileVersion", "1.a");
        }),
        odd("empty values", "needless", |odd| {
            odd.set("DeviceInfo", "VendorNumber", "");
            odd.set("1800", "SubNumber", "");
            odd.set("2002", "DefaultValue", "");
            odd.set("2002", "HighLimit", "");
        }),
        odd("no optional keys", "needless", |odd| {
            let optional = [
                "ObjectType",
                "SubNumber",
                "AccessType",
                "PDOMapping",
                "LowLimit",
                "FileVersion",
                "NrOfTXPDO",
            ];
            for (_, entries) in &mut odd.sections {
                entries.retain(|(key, _)| !optional.contains(&&**key));
            }
        }),
        odd("no [FileInfo]", "file info", |odd| odd.without_sections(&["FileInfo"])),
        odd("no [DeviceInfo]", "device info", |odd| odd.without_sections(&["DeviceInfo"])),
        odd("no device type", "device type", |odd| {
            odd.set("1000", "DefaultValue", "");
            odd.expected.identity[0] = None;
        }),
        odd("wrong device type", "device type", |odd| {
            odd.set("1000", "DefaultValue", "401h");
            odd.expected.identity[0] = None;
            odd.said.push("[1000]DefaultValue=401h:nonumber");
        }),
        odd("wrong data type", "type", |odd| {
            odd.set("2000", "DataType", "INTEGER16");
            odd.first().fields[0].data_type = 0;
            odd.said.push("[2000]DataType=INTEGER16:nonumber");
        }),
        odd("no data type", "type", |odd| {
            odd.without("2000", "DataType");
            odd.first().fields[0].data_type = 0;
        }),
        odd("ParameterValue", "cob-id", |odd| {
            odd.set("1800sub1", "ParameterValue", "0x1A5");
            odd.first().id = 0x1A5;
        }),
        odd("ParameterValue beside a wrong default", "cob-id", |odd| {
            odd.set("1800sub1", "ParameterValue", "0x1A5");
            odd.set("1800sub1", "DefaultValue", "none");
            odd.first().id = 0x1A5;
        }),
        odd("empty ParameterValue", "parameter", |odd| odd.set("1801sub1", "ParameterValue", "")),
        odd("mapping of a DCF", "mapping", |odd| {
            odd.set("1A00sub0", "DefaultValue", "0");
            odd.set("1A00sub0", "ParameterValue", "1");
            odd.first().fields.truncate(1);
        }),
        odd("CompactSubObj of a mapping", "mapping", |odd| {
            odd.without_sections(&["1A00sub0", "1A00sub1", "1A00sub2"]);
            odd.set("1A00", "CompactSubObj", "0x40");
            odd.set("1A00", "DefaultValue", "0");
            odd.set("1A00Value", "NrOfEntries", "2");
            odd.set("1A00Value", "1", "0x20000010");
            odd.set("1A00Value", "2", "0x200A0A08");
        }),
        odd("entries that map nothing", "mapping", |odd| {
            odd.set("1A00sub0", "DefaultValue", "4");
            odd.set("1A00sub3", "DefaultValue", "0x00000000");
            odd.set("1A00sub4", "DefaultValue", "0");
        }),
        odd("commissioning", "commissioning", |odd| odd.set("DeviceComissioning", "NodeID", "05")),
        odd("commissioning in another spelling", "commissioning", |odd| {
            odd.set("DeviceCommissioning", "NodeID", "0x5")
        }),
        odd("commissioning of another node", "commissioning", |odd| {
            odd.set("DeviceComissioning", "NodeID", "7");
            odd.said.push("thatofnode7");
        }),
        odd("commissioning without sense", "commissioning", |odd| {
            odd.set("DeviceComissioning", "NodeID", "five");
            odd.said.push("NodeID=five:noNode-ID");
        }),
    ]
}

/// PDOs that are left out, and those that are not valid.
fn of_left_out() -> Vec<Oddity> {
    let mut all = Vec::new();
    for (text, said) in [
        ("0xFE", "[1A00sub0]DefaultValue=0xFE:amultiplexPDO"),
        ("255", "[1A00sub0]DefaultValue=255:amultiplexPDO"),
        ("0376", "[1A00sub0]DefaultValue=0376:amultiplexPDO"),
        ("", "[1A00sub0]hasnovalue"),
        ("3", "[1A00sub3]hasnovalue"),
    ] {
        all.push(odd(format!("number of objects '{text}'"), "first", move |odd| {
            odd.set("1A00sub0", "DefaultValue", text);
            odd.loses_the_first();
            odd.said.push(said);
        }));
    }
    for (text, said) in [
        ("0589", Some("[1800sub1]DefaultValue=0589:nonumber")),
        (
            "$NODEID+0x20000180",
            Some("[1800sub1]DefaultValue=$NODEID+0x20000180:allowedareidentifiersof11bits"),
        ),
        ("", Some("[1800sub1]hasnovalue")),
        ("0x80000185", None),
        ("$NODEID+0x80000180", None),
        ("-2147483259", None),
    ] {
        all.push(odd(format!("COB-ID '{text}'"), "first", move |odd| {
            odd.set("1800sub1", "DefaultValue", text);
            odd.expected.pdos.remove(0);
            odd.said.extend(said);
        }));
    }
    all.extend([
        odd("a PDO that is not valid, with a wrong mapping", "third", |odd| {
            odd.set("1802sub1", "DefaultValue", "0x80000000");
            odd.set("1A02sub0", "DefaultValue", "many");
        }),
        odd("a PDO without COB-ID and mapping", "third", |odd| {
            odd.set("1802sub1", "DefaultValue", "");
            odd.set("1A02sub0", "DefaultValue", "0");
        }),
        odd("a PDO without a mapping", "third", |odd| {
            odd.set("1802sub1", "DefaultValue", "$NODEID+0x380");
            odd.expected.others.push(0x385);
        }),
        odd("a section twice", "doubles", |odd| {
            let power = odd.section("2002").clone();
            odd.sections.push(("2002".into(), power));
        }),
        odd("an entry twice with two values", "doubles", |odd| {
            odd.section("1801sub1").push(("DefaultValue".into(), "$NODEID+0x480".into()));
            odd.expected.pdos.last_mut().unwrap().id = 0x485;
            odd.said.push("DefaultValue=$NODEID+0x480:line");
        }),
    ]);
    all
}

/// Oddities that change TPDO 1 exclude those that leave it out.
fn exclude_each_other(one: &Oddity, other: &Oddity) -> bool {
    const OF_FIRST: [&str; 6] = ["cob-id", "mapping", "second", "type", "name", "channels"];
    let is_of_first = |oddity: &Oddity| OF_FIRST.contains(&oddity.changes);
    one.changes == other.changes
        || one.changes == "first" && is_of_first(other)
        || other.changes == "first" && is_of_first(one)
}

/// Each oddity alone, then each pair that does not exclude each other, with its name.
pub fn all() -> Vec<(String, Odd)> {
    let oddities: Vec<Oddity> =
        [of_text(), of_numbers(), of_names(), of_the_rest(), of_left_out()].into_iter().flatten().collect();
    let made = |of: &[&Oddity]| {
        let mut odd = plain();
        of.iter().for_each(|oddity| (oddity.apply)(&mut odd));
        (of.iter().map(|oddity| oddity.name.as_str()).collect::<Vec<_>>().join(" and "), odd)
    };
    let mut all = vec![made(&[])];
    for (nth, one) in oddities.iter().enumerate() {
        all.push(made(&[one]));
        let others = oddities[..nth].iter().filter(|other| !exclude_each_other(one, other));
        all.extend(others.map(|other| made(&[other, one])));
    }
    all
}
