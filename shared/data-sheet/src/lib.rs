//! EDS and DCF of others: sections, keys and values (CiA 306).
//!
//! An *entry* is a line `key=value` in a section. Files of other tools differ in what CiA 306 leaves open and in what they get wrong,
//! so the reader takes every form that has one meaning:
//!
//! | in the file | taken |
//! | --- | --- |
//! | text | UTF-8, UTF-16 with a byte order mark, otherwise Windows-1252 |
//! | ends of lines | LF, CR LF, CR |
//! | comments | lines that begin with `;`. A value reaches to the end of its line; only a number ends before `;` or `#` |
//! | sections and keys | upper and lower case, blanks around them |
//! | numbers | decimal, `0x` hexadecimal, leading `0` octal, signs; sums with `$NODEID` at any place |
//! | ARRAYs | a section for each sub-index, or `CompactSubObj` with `[xxxxName]` and `[xxxxValue]` |
//! | an entry that stands twice | the last one; [`DataSheet::doubles`] names both |
//!
//! A line that is no section and no entry is left out. What an entry means is judged when it is asked for: an entry that a caller does
//! not need cannot be wrong.
//!
//! ```
//! use async_canopen_eds::DataSheet;
//!
//! let sheet = DataSheet::read(b"[DeviceInfo]\r\n[1800SUB1]\r\nDefaultValue = 0x180 + $NodeId\r\n")?;
//! assert_eq!(sheet.object(0x1800, 1, 5)?.map(|value| value.number), Some(0x185));
//! # Ok::<(), async_canopen_eds::Unreadable>(())
//! ```
//!
//! Related crates: [`async-canopen`](https://docs.rs/async-canopen),
//! [`async-canopen-derive`](https://docs.rs/async-canopen-derive), [`ecss-can-eds`](https://docs.rs/ecss-can-eds).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

use std::borrow::Cow;
use std::collections::btree_map::Entry as Place;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use encoding_rs::WINDOWS_1252;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

/// An EDS or DCF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataSheet {
    /// By section and key, in small letters.
    entries: BTreeMap<(String, String), Entry>,
    doubles: Vec<String>,
}

/// A line `key=value` with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    line: usize,
    section: String,
    key: String,
    text: String,
}

/// A number with the entry that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value<'a> {
    /// The number. One below zero is its two's complement.
    pub number: u32,
    /// Where it stands.
    pub entry: &'a Entry,
}

/// Why a file or an entry cannot be read: its place, what was found, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unreadable(String);

impl Unreadable {
    /// Returns the error of an entry that is not there.
    pub fn missing(entry: &str) -> Self {
        Unreadable(format!("no entry {entry}"))
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: [{}] {}={}", self.line, self.section, self.key, self.text)
    }
}

impl Entry {
    /// Returns its text, without the blanks around it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the error of a value that is not allowed.
    pub fn wrong(&self, allowed: impl fmt::Display) -> Unreadable {
        Unreadable(format!("{self}: {allowed}"))
    }

    fn number(&self, node: u8) -> Result<u32, Unreadable> {
        number(&self.text, node).ok_or_else(|| {
            self.wrong(
                "no number of 32 bits; allowed are decimal, 0x with hexadecimal digits, 0 with octal digits, and a sum with $NODEID",
            )
        })
    }
}

impl DataSheet {
    /// Reads a file.
    ///
    /// # Errors
    /// When it has neither a section `[DeviceInfo]` nor one of an object.
    pub fn read(bytes: &[u8]) -> Result<DataSheet, Unreadable> {
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            // It also finds the byte order mark of UTF-16.
            Err(_) => WINDOWS_1252.decode(bytes).0,
        };
        let text = text.trim_start_matches('\u{FEFF}').replace("\r\n", "\n").replace('\r', "\n");
        let mut sheet = DataSheet { entries: BTreeMap::new(), doubles: Vec::new() };
        let (mut section, mut is_sheet) = (String::new(), false);
        for (line, text) in (1..).zip(text.split('\n').map(str::trim)) {
            if text.starts_with(';') {
                continue;
            }
            if let Some(rest) = text.strip_prefix('[') {
                section = rest.split(']').next().unwrap_or(rest).trim().to_owned();
                let folded = folded(&section);
                is_sheet |= folded == "deviceinfo" || indices(&folded).is_some();
            } else if let Some((key, text)) = text.split_once('=') {
                let (key, text) = (key.trim().to_owned(), text.trim().to_owned());
                sheet.insert(Entry { line, section: section.clone(), key, text });
            }
        }
        if !is_sheet {
            let text = "no EDS or DCF (CiA 306): such a file has a section [DeviceInfo], and one for each object, such as [1000] \
                        and [1018sub1], with lines KEY=VALUE";
            return Err(Unreadable(text.into()));
        }
        Ok(sheet)
    }

    fn insert(&mut self, entry: Entry) {
        match self.entries.entry((folded(&entry.section), entry.key.to_lowercase())) {
            Place::Vacant(place) => drop(place.insert(entry)),
            Place::Occupied(mut place) => {
                let earlier = place.insert(entry);
                let entry = place.get();
                if earlier.text != entry.text {
                    let Entry { line, text, .. } = &earlier;
                    self.doubles.push(format!("{entry}: line {line} has {text}; the last one counts"));
                }
            }
        }
    }

    /// Entries that stand twice with different values, in words.
    pub fn doubles(&self) -> &[String] {
        &self.doubles
    }

    /// Returns the indices of the objects that have a section, in rising order.
    pub fn indices(&self) -> impl Iterator<Item = u16> {
        let sections =
            self.entries.keys().map(|(section, _)| section.strip_suffix("value").unwrap_or(section));
        let indices = sections.filter_map(indices);
        indices.map(|(index, _)| index).collect::<BTreeSet<_>>().into_iter()
    }

    /// Returns an entry, if it is there and not empty.
    pub fn entry(&self, section: &str, key: &str) -> Option<&Entry> {
        let entry = self.entries.get(&(folded(section), key.to_lowercase()));
        entry.filter(|entry| !entry.text.is_empty())
    }

    /// Returns the number of an entry for the device with this Node-ID.
    ///
    /// # Errors
    /// When it is no number of 32 bits.
    pub fn number(&self, section: &str, key: &str, node: u8) -> Result<Option<Value<'_>>, Unreadable> {
        let entry = self.entry(section, key);
        entry.map(|entry| Ok(Value { number: entry.number(node)?, entry })).transpose()
    }

    /// Returns the Node-ID of a DCF, 1 to 127. `None`: the file has none, as an EDS.
    ///
    /// # Errors
    /// When it is no such number.
    pub fn node(&self) -> Result<Option<u8>, Unreadable> {
        // Some tools do not spell the section as CiA 306 does.
        let sections = ["DeviceComissioning", "DeviceCommissioning"];
        let Some(entry) = sections.into_iter().find_map(|section| self.entry(section, "NodeID")) else {
            return Ok(None);
        };
        let node = number(&entry.text, 0).and_then(|node| u8::try_from(node).ok());
        let node = node.filter(|node| (1..=127).contains(node));
        node.map(Some).ok_or_else(|| entry.wrong("no Node-ID; allowed are 1 to 127"))
    }

    /// Returns the value of an object for the device with this Node-ID: what the device has (`ParameterValue`), or else its default.
    /// `None`: the file has none.
    ///
    /// # Errors
    /// When it is no number of 32 bits.
    pub fn object(&self, index: u16, sub: u8, node: u8) -> Result<Option<Value<'_>>, Unreadable> {
        let (own, whole) = (of_sub(index, sub), of_object(index));
        let (values, nth) = (format!("{whole}Value"), sub.to_string());
        let places = [(&own, "ParameterValue"), (&values, &nth), (&own, "DefaultValue")];
        let entry = places.into_iter().find_map(|(section, key)| self.entry(section, key));
        if let Some(entry) = entry {
            return Ok(Some(Value { number: entry.number(node)?, entry }));
        }
        match (self.highest(index)?, sub) {
            (Some(highest), 0) => Ok(Some(highest)),
            (Some(highest), _) if u32::from(sub) <= highest.number => {
                self.number(&whole, "DefaultValue", node)
            }
            (None, 0) => match self.number(&whole, "ParameterValue", node)? {
                None => self.number(&whole, "DefaultValue", node),
                value => Ok(value),
            },
            _ => Ok(None),
        }
    }

    /// The highest sub-index of an object whose sub-indices have no sections.
    fn highest(&self, index: u16) -> Result<Option<Value<'_>>, Unreadable> {
        Ok(self.number(&of_object(index), "CompactSubObj", 0)?.filter(|highest| highest.number > 0))
    }

    /// Returns the name of an object and that of its sub-index: `Heater, Temperature`.
    pub fn name(&self, index: u16, sub: u8) -> String {
        let whole = of_object(index);
        let text = |section: &str, key: &str| self.entry(section, key).map(Entry::text);
        let own = text(&of_sub(index, sub), "ParameterName");
        let own = own.or_else(|| text(&format!("{whole}Name"), &sub.to_string()));
        match (text(&whole, "ParameterName"), own) {
            (Some(object), Some(own)) if object != own => format!("{object}, {own}"),
            (None, Some(name)) => name.to_owned(),
            (Some(object), None) if sub > 0 && matches!(self.highest(index), Ok(Some(_))) => {
                format!("{object}{sub}")
            }
            (Some(name), _) => name.to_owned(),
            (None, None) => format!("{index:04X}h sub {sub:02X}h"),
        }
    }

    /// Returns the data type of a value, its index in CiA 301 table 44. `None`: the file has none.
    ///
    /// # Errors
    /// When it is no number of 32 bits.
    pub fn data_type(&self, index: u16, sub: u8) -> Result<Option<u32>, Unreadable> {
        let entry = self.property(index, sub, "DataType");
        entry.map(|entry| entry.number(0)).transpose()
    }

    /// Returns an entry of a sub-index, or else of its object.
    pub fn property(&self, index: u16, sub: u8, key: &str) -> Option<&Entry> {
        self.entry(&of_sub(index, sub), key).or_else(|| self.entry(&of_object(index), key))
    }

    /// Returns the sub-indices of an ARRAY or a RECORD, in rising order. A VAR has none.
    ///
    /// # Errors
    /// When `CompactSubObj` is no number of 32 bits.
    pub fn sub_indices(&self, index: u16) -> Result<Vec<u8>, Unreadable> {
        let own = self.entries.keys().filter_map(|(section, _)| match indices(section)? {
            (of, sub) if of == index => sub,
            _ => None,
        });
        let mut all: BTreeSet<u8> = own.collect();
        if let Some(highest) = self.highest(index)? {
            // Sub-index 255 is the structure of the object (CiA 301 7.4.3).
            all.extend(0..=highest.number.min(254) as u8);
        }
        Ok(all.into_iter().collect())
    }

    /// Returns whether a sub-index has no section: the object has it by `CompactSubObj`.
    ///
    /// # Errors
    /// When `CompactSubObj` is no number of 32 bits.
    pub fn is_compact(&self, index: u16, sub: u8) -> Result<bool, Unreadable> {
        let has_section = self.entry(&of_sub(index, sub), "ParameterName").is_some();
        Ok(!has_section && self.highest(index)?.is_some())
    }
}

/// Section of an object.
pub fn of_object(index: u16) -> String {
    format!("{index:X}")
}

/// Section of a sub-index.
pub fn of_sub(index: u16, sub: u8) -> String {
    format!("{index:X}sub{sub:X}")
}

/// The name of a section as all files have it: without blanks, in small letters, numbers without leading zeros.
fn folded(section: &str) -> String {
    let small: String = section.to_lowercase().split_whitespace().collect();
    match indices(&small) {
        Some((index, None)) => of_object(index).to_lowercase(),
        Some((index, Some(sub))) => of_sub(index, sub).to_lowercase(),
        None => small,
    }
}

/// Index and sub-index of a section of an object.
fn indices(folded: &str) -> Option<(u16, Option<u8>)> {
    let (index, sub) = folded.split_once("sub").map_or((folded, None), |(index, sub)| (index, Some(sub)));
    let is_hex = |digits: &str| !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    if !is_hex(index) || !sub.is_none_or(is_hex) {
        return None;
    }
    let index = u16::from_str_radix(index, 16).ok().filter(|index| *index >= 0x1000)?;
    Some((index, sub.map(|sub| u8::from_str_radix(sub, 16)).transpose().ok()?))
}

/// A sum of numbers and `$NODEID`. No number has `;` or `#`: what follows them is a comment.
fn number(text: &str, node: u8) -> Option<u32> {
    let signed = text.split([';', '#']).next()?.trim().replace('-', "+-");
    let terms = signed.strip_prefix('+').unwrap_or(&signed).split('+');
    let sum: i64 = terms.map(|text| term(text.trim(), node)).sum::<Option<i64>>()?;
    u32::try_from(sum).or_else(|_| i32::try_from(sum).map(i32::cast_unsigned)).ok()
}

fn term(text: &str, node: u8) -> Option<i64> {
    if let Some(text) = text.strip_prefix('-') {
        return term(text.trim_start(), node).map(|value| -value);
    }
    let text = text.to_ascii_lowercase();
    let (digits, radix) = match text.strip_prefix('0') {
        _ if text == "$nodeid" => return Some(node.into()),
        Some("") | None => (&*text, 10),
        Some(rest) => rest.strip_prefix('x').map_or((rest, 8), |digits| (digits, 16)),
    };
    u32::from_str_radix(digits, radix).ok().map(i64::from)
}
