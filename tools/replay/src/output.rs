//! Outputs of a node that its machine decides.

use std::fmt;

use ecss_can::redundancy::Pair;
use ecss_can::types::{Bus, CobId, Frame, NodeId};

/// Output of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// The node requests the transmission of this frame.
    Frame(Bus, Frame),
    /// The node reports this error by an EMCY: error code, first byte of the manufacturer's part.
    Emergency(u16, u8),
    /// The node logs this line.
    Line(String),
}

/// Kind of output. Outputs of one kind are compared in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stream {
    /// Heartbeats and boot-up messages.
    Heartbeat,
    /// NMT commands of a master.
    Command,
    /// Claims of one of two masters on this bus.
    Claim(Bus),
    /// Begins of SDO transfers of a master with a new slave.
    Question,
    /// EMCYs of a missed master and of a collision.
    Emergency,
    /// Lines of the log.
    Line,
}

impl Stream {
    /// All kinds.
    pub const ALL: [Stream; 7] = [
        Stream::Heartbeat,
        Stream::Command,
        Stream::Claim(Bus::Nominal),
        Stream::Claim(Bus::Redundant),
        Stream::Question,
        Stream::Emergency,
        Stream::Line,
    ];
}

impl Output {
    /// Returns the stream of an output of node `own`. `None`: no machine decides it.
    pub fn stream(&self, own: NodeId, pair: Option<&Pair>) -> Option<Stream> {
        let (bus, frame) = match self {
            Output::Emergency(..) => return Some(Stream::Emergency),
            Output::Line(_) => return Some(Stream::Line),
            Output::Frame(bus, frame) => (*bus, frame),
        };
        let id = frame.id();
        if id == CobId::heartbeat(own) {
            Some(Stream::Heartbeat)
        } else if id == CobId::NMT {
            Some(Stream::Command)
        } else if pair.is_some_and(|pair| pair.both_claims().contains(&id)) {
            Some(Stream::Claim(bus))
        } else {
            let is_request = id.node().is_some_and(|node| id == CobId::sdo_request(node));
            let begins = matches!(frame.data().first().map(|command| command >> 5), Some(1 | 2));
            (is_request && begins).then_some(Stream::Question)
        }
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Output::Frame(bus, frame) => write!(f, "{frame:?} on {bus:?}"),
            Output::Emergency(code, source) => write!(f, "EMCY {code:04X}h of source {source}"),
            Output::Line(line) => write!(f, "\"{line}\""),
        }
    }
}
