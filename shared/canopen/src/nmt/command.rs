//! Module control: the commands of the NMT master (CiA 301 7.2.8.3.1).

use crate::types::{CobId, Frame, NodeId};

/// Command specifier: the first byte of an NMT frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Command {
    /// Enter the state Operational.
    Start = 0x01,
    /// Enter the state Stopped.
    Stop = 0x02,
    /// Enter the state Pre-operational.
    EnterPreOperational = 0x80,
    /// Reset the whole node.
    ResetNode = 0x81,
    /// Reset only the communication profile area.
    ResetCommunication = 0x82,
}

impl Command {
    const fn from_byte(byte: u8) -> Option<Command> {
        match byte {
            0x01 => Some(Command::Start),
            0x02 => Some(Command::Stop),
            0x80 => Some(Command::EnterPreOperational),
            0x81 => Some(Command::ResetNode),
            0x82 => Some(Command::ResetCommunication),
            _ => None,
        }
    }
}

/// Nodes that a command addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Target {
    /// Every slave: node 0 on the wire.
    All,
    /// The slave with this Node-ID.
    Node(NodeId),
}

impl From<NodeId> for Target {
    fn from(node: NodeId) -> Target {
        Target::Node(node)
    }
}

impl Target {
    /// Returns whether the command addresses `node`.
    pub fn includes(self, node: NodeId) -> bool {
        match self {
            Target::All => true,
            Target::Node(addressed) => addressed == node,
        }
    }
}

/// Module control message of the NMT master.
#[doc(alias("NMT master", "NMT command"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtMessage {
    /// Command to the addressed nodes.
    pub command: Command,
    /// Nodes that the command addresses.
    pub target: Target,
}

impl NmtMessage {
    /// Makes the frame: COB-ID 000h, command, node.
    pub fn encode(self) -> Frame {
        let node = match self.target {
            Target::All => 0,
            Target::Node(node) => node.get(),
        };
        Frame::of(CobId::NMT, [self.command as u8, node])
    }

    /// Decodes a frame. `None` if it is malformed: length other than 2, unknown command, node above 127.
    pub fn decode(frame: &Frame) -> Option<NmtMessage> {
        let &[command, node] = frame.data() else { return None };
        let target = if node == 0 { Target::All } else { Target::Node(NodeId::new(node)?) };
        Some(NmtMessage { command: Command::from_byte(command)?, target })
    }
}
