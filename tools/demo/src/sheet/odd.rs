//! Odd data sheets: each oddity of files of other tools alone and in pairs, with the values that a flight needs.
//!
//! The expected values stand beside the oddities; nothing here reads a file.

use super::{Field, Pdo, Sheet};

/// Node-ID of the device.
pub const NODE: u8 = 5;

/// A data sheet that is being made, and what is to be read from it.
#[derive(Clone)]
pub struct Odd {
    sections: Vec<(String, Vec<(String, String)>)>,
    /// Lines in front of the first section, and behind the last one.
    around: [Vec<&'static str>; 2],
    /// A line in front of each other line.
    between: &'static str,
    ends: &'static str,
    equals: &'static str,
    brackets: [&'static str; 2],
    margins: [&'static str; 2],
    section_case: fn(&str) -> String,
    key_case: fn(&str) -> String,
    encode: fn(&str) -> Vec<u8>,
    /// What is read.
    pub expected: Sheet,
    /// Parts of the notes, one for each.
    pub said: Vec<&'static str>,
}

/// An oddity.
pub struct Oddity {
    /// In words.
    pub name: String,
    /// What it changes: two that change the same exclude each other.
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
    Odd {
        sections,
        around: [Vec::new(), Vec::new()],
        between: "",
        ends: "\n",
        equals: "=",
        brackets: ["[", "]"],
        margins: ["", ""],
        section_case: str::to_owned,
        key_case: str::to_owned,
        encode: |text| text.as_bytes().to_vec(),
        expected: Sheet {
            pdos: vec![
                Pdo {
                    number: 1,
                    id: 0x185,
                    fields: vec![field("Temp", 3, 16), field("Channels, Ten", 5, 8)],
                },
                Pdo { number: 2, id: 0x285, fields: vec![field("Power", 8, 32)] },
            ],
            others: Vec::new(),
            received: Vec::new(),
            identity: [Some(0x191), Some(0x1234), Some(0x42), Some(0x1_0000)],
            notes: Vec::new(),
        },
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

    /// TPDO 1 is not read, but its COB-ID.
    fn loses_the_first(&mut self) {
        let pdo = self.expected.pdos.remove(0);
        self.expected.others.push(pdo.id);
    }

    fn first(&mut self) -> &mut Pdo {
        &mut self.expected.pdos[0]
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut lines: Vec<String> = self.around[0].iter().map(|line| (*line).to_owned()).collect();
        let ([open, close], [left, right]) = (self.brackets, self.margins);
        for (name, entries) in &self.sections {
            lines.push(format!("{left}{open}{}{close}{right}", (self.section_case)(name)));
            for (key, value) in entries {
                lines.push(format!("{left}{}{}{value}{right}", (self.key_case)(key), self.equals));
            }
        }
        lines.extend(self.around[1].iter().map(|line| (*line).to_owned()));
        let line = |line: &String| {
            let between = if self.between.is_empty() { "" } else { self.ends };
            format!("{}{between}{line}{}", self.between, self.ends)
        };
        (self.encode)(&lines.iter().map(line).collect::<String>())
    }
}

/// ° and ü, the only letters of these files that are not ASCII.
fn windows_1252(text: &str) -> Vec<u8> {
    text.chars().map(|letter| u8::try_from(u32::from(letter)).expect("as in Latin-1")).collect()
}

fn utf_16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    "\u{FEFF}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes).collect()
}

fn odd(name: impl Into<String>, changes: &'static str, apply: impl Fn(&mut Odd) + 'static) -> Oddity {
    Oddity { name: name.into(), changes, apply: Box::new(apply) }
}

/// What the layout of the text changes.
fn of_text() -> Vec<Oddity> {
    vec![
        odd("CR LF", "ends", |odd| odd.ends = "\r\n"),
        odd("CR", "ends", |odd| odd.ends = "\r"),
        odd("byte order mark", "encoding", |odd| {
            odd.encode = |text| ["\u{FEFF}", text].concat().into_bytes()
        }),
        odd("UTF-8", "encoding", |odd| odd.set("DeviceInfo", "VendorName", "M\u{FC}ller")),
        odd("Windows-1252", "encoding", |odd| {
            odd.set("DeviceInfo", "VendorName", "M\u{FC}ller");
            odd.encode = windows_1252;
        }),
        odd("UTF-16, low byte first", "encoding", |odd| odd.encode = |text| utf_16(text, u16::to_le_bytes)),
        odd("UTF-16, high byte first", "encoding", |odd| odd.encode = |text| utf_16(text, u16::to_be_bytes)),
        odd("end of file of DOS", "tail", |odd| odd.around[1].push("\u{1A}")),
        odd("empty lines", "between", |odd| odd.between = " "),
        odd("comments", "between", |odd| odd.between = "; [1800sub1] DefaultValue=1"),
        odd("indented comments", "between", |odd| odd.between = "\t;DefaultValue=1"),
        odd("lines with #", "between", |odd| odd.between = "# DefaultValue=1"),
        odd("lines without =", "between", |odd| odd.between = "DefaultValue"),
        odd("lines without a key", "between", |odd| odd.between = "=1"),
        odd("blanks around =", "equals", |odd| odd.equals = " = "),
        odd("tabs around =", "equals", |odd| odd.equals = "\t=\t"),
        odd("blanks in brackets", "brackets", |odd| odd.brackets = ["[ ", " ]"]),
        odd("no closing bracket", "brackets", |odd| odd.brackets = ["[", ""]),
        odd("comments behind brackets", "brackets", |odd| odd.brackets = ["[", "] ; an object"]),
        odd("blanks in front", "margins", |odd| odd.margins = ["  ", ""]),
        odd("blanks behind", "margins", |odd| odd.margins = ["", " \t"]),
        odd("sections in capitals", "sections", |odd| odd.section_case = |name| name.to_uppercase()),
        odd("sections in small letters", "sections", |odd| odd.section_case = |name| name.to_lowercase()),
        odd("keys in capitals", "keys", |odd| odd.key_case = |key| key.to_uppercase()),
        odd("keys in small letters", "keys", |odd| odd.key_case = |key| key.to_lowercase()),
        odd("an entry in front of all sections", "head", |odd| odd.around[0].push("DefaultValue=1")),
        odd("sub-indices with leading zeros", "sections", |odd| {
            odd.section_case = |name| name.replace("sub", "sub0")
        }),
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
    let mut all = Vec::new();
    for text in ["0605", "$NODEID-0x80+0x200", "0x180+$NODEID ; of TPDO 1", "0x580 - 0x400 + $NODEID"] {
        all.push(odd(format!("COB-ID {text}"), "cob-id", move |odd| {
            odd.set("1800sub1", "DefaultValue", text)
        }));
    }
    for (name, section, text) in [
        ("mapping", "1A00sub1", "0x20000010 # Temp"),
        ("second", "1A00sub2", "04002405010"),
        ("mapping", "1A00sub0", "02"),
        ("device type", "1000", "0621"),
    ] {
        all.push(odd(format!("[{section}] {text}"), name, move |odd| odd.set(section, "DefaultValue", text)));
    }
    all.push(odd("data type 0X3", "type", |odd| odd.set("2000", "DataType", "0X3")));
    all
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

/// What a flight does not need, and what is not there.
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
