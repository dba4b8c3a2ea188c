//! What the boot-up process knows of each node.

use core::mem::{replace, take};

use super::{Assignment, BootProgress, PLACES};
use crate::types::NodeId;

/// One node, assigned or not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    pub duty: Duty,
    pub progress: BootProgress,
    /// The progress is to be reported.
    pub has_progressed: bool,
    /// Waits for its turn, or for another one while its process runs.
    pub is_queued: bool,
    pub run: Run,
    /// Its next Pre-operational is not explained by a command of the master.
    pub is_operational: bool,
    /// May have been reset without being heard.
    pub is_doubtful: bool,
    /// Silent when the boot time ended, and to be reported.
    pub is_silent: bool,
}

/// Part of a node in the boot-up of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Duty {
    /// The master does not boot it.
    None,
    Optional,
    /// SYNC waits for it.
    Mandatory,
    /// Mandatory, but SYNC goes on without it: the boot time is over.
    Excused,
}

/// How far a slave came since its boot-up message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Run {
    /// It has to pass the process.
    Waits,
    /// It passed the process, and is started at once whenever it waits.
    Started,
    /// It followed a SYNC.
    Synchronised,
}

impl Duty {
    /// The duty by an entry of 1F81h.
    pub fn of(assignment: Assignment) -> Duty {
        match (assignment.is_booted(), assignment.is_mandatory()) {
            (false, _) => Duty::None,
            (true, false) => Duty::Optional,
            (true, true) => Duty::Mandatory,
        }
    }
}

impl Record {
    /// A node that the master does not boot.
    pub const UNASSIGNED: Record = Record {
        duty: Duty::None,
        progress: BootProgress::Unassigned,
        has_progressed: false,
        is_queued: false,
        run: Run::Waits,
        is_operational: false,
        is_doubtful: false,
        is_silent: false,
    };

    pub fn is_started(&self) -> bool {
        self.run >= Run::Started
    }
}

/// The record of each node.
#[derive(Clone, Debug)]
pub(super) struct Records {
    of: [Record; PLACES],
    /// Number of slaves that wait for their turn.
    queued: u8,
}

impl Records {
    pub const fn new() -> Records {
        Records { of: [Record::UNASSIGNED; PLACES], queued: 0 }
    }

    pub fn get(&self, node: NodeId) -> &Record {
        self.of.get(usize::from(node.get())).unwrap_or(&Record::UNASSIGNED)
    }

    pub fn get_mut(&mut self, node: NodeId) -> Option<&mut Record> {
        self.of.get_mut(usize::from(node.get()))
    }

    pub fn all(&self) -> impl Iterator<Item = &Record> {
        self.of.iter()
    }

    pub fn all_mut(&mut self) -> impl Iterator<Item = &mut Record> {
        self.of.iter_mut()
    }

    /// Discards what the process of a node found out.
    pub fn forget(&mut self, node: NodeId) {
        self.set_queued(node, false);
        if let Some(record) = self.get_mut(node) {
            (record.run, record.is_operational, record.is_doubtful) = (Run::Waits, false, false);
        }
    }

    pub fn set_queued(&mut self, node: NodeId, is_queued: bool) {
        if let Some(record) = self.get_mut(node)
            && replace(&mut record.is_queued, is_queued) != is_queued
        {
            self.queued =
                if is_queued { self.queued.saturating_add(1) } else { self.queued.saturating_sub(1) };
        }
    }

    pub const fn is_any_queued(&self) -> bool {
        self.queued > 0
    }

    /// Returns the slave whose turn comes after that of Node-ID `last`: one that does not answer must not delay the others.
    pub fn next_queued(&self, last: u8) -> Option<NodeId> {
        let mut in_turn = (last.saturating_add(1)..=127).chain(1..=last).filter_map(NodeId::new);
        in_turn.find(|node| self.get(*node).is_queued)
    }

    /// Returns the slave with the lowest Node-ID of those with a flag, and takes the flag.
    pub fn take_first(&mut self, flag: impl Fn(&mut Record) -> &mut bool) -> Option<NodeId> {
        let mut records = self.of.iter_mut().zip(0..);
        records.find_map(|(record, raw)| take(flag(record)).then(|| NodeId::new(raw)))?
    }
}
