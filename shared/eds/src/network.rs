//! The devices of one network, by their device configuration files: who sends what (ECSS 6.10l, m).

use std::collections::BTreeMap;
use std::fmt;

use configparser::ini::Ini;

/// Bits of a COB-ID entry: not valid; the producer of SYNC.
const INVALID: u32 = 1 << 31;
const PRODUCES: u32 = 1 << 30;

/// What one device sends, by its DCF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sender {
    /// Name of the file.
    pub file: String,
    /// Node-ID of the device.
    pub node: u8,
    /// COB-IDs with the objects that they come from.
    pub sent: Vec<(u16, String)>,
}

/// Why a file is no DCF of a device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// It has no sections and keys.
    #[error("{0} is no DCF: {1}")]
    Syntax(String, String),
    /// An entry is missing or is no number.
    #[error("{file}: [{section}] {key} is no number of 32 bits")]
    Number {
        /// Name of the file.
        file: String,
        /// Section of the entry.
        section: String,
        /// Key of the entry.
        key: String,
    },
}

/// Two devices that cannot be on one network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Conflict {
    /// Both have this Node-ID.
    NodeId(u8, [String; 2]),
    /// Both send this COB-ID.
    CobId(u16, [String; 2]),
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Conflict::NodeId(node, [one, other]) => write!(f, "{one} and {other} have Node-ID {node}"),
            Conflict::CobId(id, [one, other]) => write!(f, "{one} and {other} send COB-ID {id:03X}h"),
        }
    }
}

impl Sender {
    /// Reads a DCF. `file` names it.
    ///
    /// # Errors
    /// [`FileError`]: it is none.
    pub fn of_dcf(file: &str, text: &str) -> Result<Sender, FileError> {
        let mut ini = Ini::new();
        ini.read(text.to_owned()).map_err(|error| FileError::Syntax(file.to_owned(), error))?;
        let dcf = Dcf { file, ini: &ini };
        let node = dcf.number("DeviceComissioning", "NodeID", 0)?;
        let node = node.and_then(|node| u8::try_from(node).ok()).filter(|node| (1..=127).contains(node));
        let node = node.ok_or_else(|| dcf.wrong("DeviceComissioning", "NodeID"))?;
        let mut sent = vec![(0x700 + u16::from(node), "heartbeat".to_owned())];
        let mut note = |id: u32, from: String| sent.push(((id & 0x7FF) as u16, from));
        if let Some(sync) = dcf.object("1005", node)?.filter(|sync| sync & PRODUCES != 0) {
            note(sync, "1005h".into());
        }
        for (section, of) in [("1014", "1014h"), ("1200sub2", "1200h")] {
            if let Some(id) = dcf.object(section, node)?.filter(|id| id & INVALID == 0) {
                note(id, of.into());
            }
        }
        for index in 0x1800..=0x19FF {
            let id = dcf.object(&format!("{index:X}sub1"), node)?;
            if let Some(id) = id.filter(|id| id & INVALID == 0) {
                note(id, format!("{index:X}h"));
            }
        }
        Ok(Sender { file: file.to_owned(), node, sent })
    }
}

/// A file that is being read.
struct Dcf<'a> {
    file: &'a str,
    ini: &'a Ini,
}

impl Dcf<'_> {
    /// The value of an object: what the device has, or else its default. `None`: it has no such object.
    fn object(&self, section: &str, node: u8) -> Result<Option<u32>, FileError> {
        match self.number(section, "ParameterValue", node)? {
            None => self.number(section, "DefaultValue", node),
            value => Ok(value),
        }
    }

    /// A number, decimal or with `0x`; `$NODEID+` adds the Node-ID (CiA 306).
    fn number(&self, section: &str, key: &str, node: u8) -> Result<Option<u32>, FileError> {
        let Some(text) = self.ini.get(section, key).filter(|text| !text.trim().is_empty()) else {
            return Ok(None);
        };
        let upper = text.trim().to_uppercase();
        let (base, digits) = match upper.strip_prefix("$NODEID+") {
            Some(digits) => (u32::from(node), digits),
            None => (0, upper.as_str()),
        };
        let value = match digits.strip_prefix("0X") {
            Some(digits) => u32::from_str_radix(digits, 16),
            None => digits.parse(),
        };
        let sum = value.ok().and_then(|value| value.checked_add(base));
        sum.map(Some).ok_or_else(|| self.wrong(section, key))
    }

    fn wrong(&self, section: &str, key: &str) -> FileError {
        FileError::Number { file: self.file.to_owned(), section: section.to_owned(), key: key.to_owned() }
    }
}

/// Finds devices with one Node-ID, and COB-IDs that two devices send.
pub fn conflicts(senders: &[Sender]) -> Vec<Conflict> {
    let mut conflicts = Vec::new();
    let mut nodes: BTreeMap<u8, &Sender> = BTreeMap::new();
    let mut ids: BTreeMap<u16, (&Sender, String)> = BTreeMap::new();
    for sender in senders {
        if let Some(other) = nodes.insert(sender.node, sender) {
            conflicts.push(Conflict::NodeId(sender.node, [other.file.clone(), sender.file.clone()]));
        }
        for (id, from) in &sender.sent {
            let named = format!("{} ({from})", sender.file);
            if let Some((_, other)) = ids.insert(*id, (sender, named.clone())) {
                conflicts.push(Conflict::CobId(*id, [other, named]));
            }
        }
    }
    conflicts
}
