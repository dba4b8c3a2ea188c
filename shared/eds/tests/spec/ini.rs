//! A reader of EDS and DCF that forgives nothing.

use std::collections::BTreeMap;

/// A file: sections in their order, each with its lines in their order.
#[derive(Debug)]
pub struct Ini(Vec<(String, Section)>);

/// A section.
#[derive(Clone, Debug, Default)]
pub struct Section(Vec<(String, String)>);

impl Ini {
    /// Panics at anything but a line of comment, an empty line, a new section, or a new keyword with its value.
    pub fn parse(text: &str) -> Ini {
        let mut sections: Vec<(String, Section)> = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            assert!(line.is_ascii() && line.len() <= 255, "line {number}: {line:?}");
            assert_eq!(line, line.trim(), "line {number}: blanks at its ends");
            if line.is_empty() {
                continue;
            }
            if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                assert!(!sections.iter().any(|(other, _)| other == name), "[{name}] twice");
                sections.push((name.into(), Section::default()));
                continue;
            }
            let (keyword, value) = line.split_once('=').unwrap_or_else(|| panic!("line {number}: {line:?}"));
            let is_whole = !value.contains([';', '#', '\\']) && !value.starts_with(['"', '\'', '`']);
            assert!(is_whole, "line {number}: the value is another one for some readers");
            let (name, section) = sections.last_mut().expect("a section before the first keyword");
            assert!(section.find(keyword).is_none(), "{keyword} twice in [{name}]");
            section.0.push((keyword.into(), value.into()));
        }
        Ini(sections)
    }

    /// A section that must be there.
    pub fn section(&self, name: &str) -> &Section {
        let found = self.0.iter().find(|(other, _)| other == name);
        &found.unwrap_or_else(|| panic!("no section [{name}]")).1
    }

    /// The names of all sections.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// The sections of values, by index and sub-index: those of VARs, DOMAINs and sub-indices.
    pub fn values(&self) -> BTreeMap<(u16, u8), &Section> {
        let value = |(name, section): &'_ (String, Section)| {
            let (index, sub) = name.split_once("sub").unwrap_or((name, "0"));
            let is_object = index.len() == 4 && !(name.len() == 4 && section.find("SubNumber").is_some());
            let index = u16::from_str_radix(index, 16).ok().filter(|_| is_object)?;
            Some((index, u8::from_str_radix(sub, 16).expect("a hexadecimal sub-index")))
        };
        self.0.iter().filter_map(|named| Some((value(named)?, &named.1))).collect()
    }
}

impl Section {
    /// A value that may be there.
    pub fn find(&self, keyword: &str) -> Option<&str> {
        self.0.iter().find(|(other, _)| other == keyword).map(|(_, value)| value.as_str())
    }

    /// A value that must be there.
    pub fn get(&self, keyword: &str) -> &str {
        self.find(keyword).unwrap_or_else(|| panic!("no {keyword} in {self:?}"))
    }

    /// A number that must be there, decimal or hexadecimal.
    pub fn number(&self, keyword: &str) -> i128 {
        number(self.get(keyword), 0)
    }

    /// All keywords.
    pub fn keywords(&self) -> Vec<&str> {
        self.0.iter().map(|(keyword, _)| keyword.as_str()).collect()
    }
}

/// A number, decimal, hexadecimal, or a formula with the Node-ID at its beginning.
pub fn number(text: &str, node: u8) -> i128 {
    if let Some(offset) = text.strip_prefix("$NODEID+") {
        return i128::from(node) + number(offset, node);
    }
    match text.strip_prefix("0x") {
        Some(digits) => i128::from_str_radix(digits, 16),
        None => text.parse(),
    }
    .unwrap_or_else(|_| panic!("{text:?} is no number"))
}
