//! The devices of one network, by their device configuration files: who sends what (ECSS 6.10l, m).

use std::collections::BTreeMap;
use std::fmt;

use crate::{DataSheet, Unreadable};

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

/// Why a file is no DCF of a device: the file, the entry, what was found, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {cause}")]
pub struct FileError {
    file: String,
    cause: Unreadable,
}

/// Two devices that cannot be on one network.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
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
    /// Reads a DCF. `file` names it. Only the entries that name a COB-ID and the Node-ID need to be readable.
    ///
    /// # Errors
    /// [`FileError`]: it is none.
    pub fn of_dcf(file: &str, bytes: &[u8]) -> Result<Sender, FileError> {
        let sender = Sender::of_sheet(file, bytes);
        sender.map_err(|cause| FileError { file: file.to_owned(), cause })
    }

    fn of_sheet(file: &str, bytes: &[u8]) -> Result<Sender, Unreadable> {
        let dcf = DataSheet::read(bytes)?;
        let node = dcf
            .node()?
            .ok_or_else(|| Unreadable::missing("[DeviceComissioning] NodeID: a DCF has 1 to 127"))?;
        let mut sent = vec![(0x700 + u16::from(node), "heartbeat".to_owned())];
        let mut note = |id: u32, from: String| sent.push(((id & 0x7FF) as u16, from));
        let object =
            |index, sub| Ok::<_, Unreadable>(dcf.object(index, sub, node)?.map(|value| value.number));
        if let Some(sync) = object(0x1005, 0)?.filter(|sync| sync & PRODUCES != 0) {
            note(sync, "1005h".into());
        }
        for (index, sub) in
            [(0x1014, 0), (0x1200, 2), (0x1201, 2)].into_iter().chain((0x1800..=0x19FF).map(|tpdo| (tpdo, 1)))
        {
            if let Some(id) = object(index, sub)?.filter(|id| id & INVALID == 0) {
                note(id, format!("{index:X}h"));
            }
        }
        Ok(Sender { file: file.to_owned(), node, sent })
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
