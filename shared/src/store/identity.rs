//! Node-ID of a slave: three copies in the parameter store, of which two must agree, and straps (ECSS 6.10e, f, g,
//! k).
//!
//! ```
//! use ecss_can::store::identity::{NoNodeId, Straps, node_id};
//! use ecss_can::types::NodeId;
//!
//! let (three, four) = (NodeId::of::<3>(), NodeId::of::<4>());
//! assert_eq!(node_id(Straps::Closed(three), None), Ok(three));
//! assert_eq!(node_id(Straps::Open, Some(three)), Ok(three));
//! let contradiction = NoNodeId::Contradiction { straps: three, stored: four };
//! assert_eq!(node_id(Straps::Closed(three), Some(four)), Err(contradiction)); // the board stays silent
//! ```
//!
//! A copy is a number of 16 bits:
//!
//! ```text
//! 01 | number, 1 to 3 (2 bits) | Node-ID, 0 for none (7 bits) | CRC (5 bits)
//! ```
//!
//! The last copy of each number counts. So a new Node-ID replaces the old one with the second of its copies.

use thiserror::Error;

use crate::types::NodeId;

/// Node-ID of a board in maintenance mode, whatever its straps and its store contain. No slave of the network has
/// it.
pub const MAINTENANCE: NodeId = NodeId::of::<127>();

/// Returns whether a slave may have this Node-ID: 2 to 126, neither that of the master nor [`MAINTENANCE`].
pub const fn is_slave(id: NodeId) -> bool {
    id.get() != NodeId::MASTER.get() && id.get() != MAINTENANCE.get()
}

/// The upper two bits of a copy.
const MARK: u16 = 0b01;
/// The generator x5 + x2 + 1, of degree 5.
const GENERATOR: u16 = 0b10_0101;
const DEGREE: u32 = 5;

/// Reading of the straps of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Straps {
    /// No strap is closed: the harness of this board has none, and the store decides.
    Open,
    /// The straps have the Node-ID of a slave.
    Closed(NodeId),
    /// A wire is lost or shorted, or the number is not the Node-ID of a slave.
    Wrong,
}

/// Reason why a board has no Node-ID. It does not communicate (ECSS 6.10f).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NoNodeId {
    /// The straps are wrong.
    #[error("the straps of the Node-ID are wrong: close an odd number of them, for a Node-ID from 2")]
    Straps,
    /// No strap is closed, and no two stored copies agree.
    #[error(
        "no strap is closed, and no two stored copies of the Node-ID agree: store it in maintenance mode"
    )]
    Missing,
    /// The store has another Node-ID than the straps.
    #[error("the straps say Node-ID {}, the store says {}", .straps.get(), .stored.get())]
    Contradiction {
        /// Node-ID of the straps.
        straps: NodeId,
        /// Node-ID of the store.
        stored: NodeId,
    },
}

/// Returns the Node-ID of a slave by its straps and its store (ECSS 6.10k).
///
/// # Errors
/// [`NoNodeId`]: the board stays silent.
pub const fn node_id(straps: Straps, stored: Option<NodeId>) -> Result<NodeId, NoNodeId> {
    match (straps, stored) {
        (Straps::Closed(straps), Some(stored)) if is_slave(straps) && straps.get() != stored.get() => {
            Err(NoNodeId::Contradiction { straps, stored })
        }
        (Straps::Closed(id), _) | (Straps::Open, Some(id)) if is_slave(id) => Ok(id),
        (Straps::Closed(_) | Straps::Wrong, _) => Err(NoNodeId::Straps),
        (Straps::Open, _) => Err(NoNodeId::Missing),
    }
}

/// Returns the Node-ID that two of three copies agree on. Each copy is a Node-ID, or 0 for none. `None` if no two
/// agree, or if the number is not the Node-ID of a slave.
pub fn agreed([first, second, third]: [u8; 3]) -> Option<NodeId> {
    let value = if second == third { second } else { first };
    let is_agreed = value == second || value == third;
    NodeId::new(value).filter(|id| is_agreed && is_slave(*id))
}

/// Makes a copy with its `number`, 1 to 3, of a Node-ID or 0: 4001h to 7FFFh.
pub const fn copy(number: u8, id: u8) -> u16 {
    let copy = (MARK << 2 | number as u16) << 7 | id as u16;
    copy << DEGREE | remainder(copy << DEGREE)
}

/// Returns number and Node-ID of a copy. `None` if a bit has changed.
pub const fn of_copy(copy: u16) -> Option<(u8, u8)> {
    let [number, id] = [(copy >> 12 & 0b11) as u8, (copy >> DEGREE & 0x7F) as u8];
    if copy >> 14 != MARK || number == 0 || remainder(copy) != 0 { None } else { Some((number, id)) }
}

/// The remainder of all bits but the mark.
#[inline(never)] // smaller: it has two callers, all of them rare
const fn remainder(copy: u16) -> u16 {
    let mut rest = copy & 0x3FFF;
    let mut bit = 14;
    while bit > DEGREE {
        bit -= 1;
        if rest >> bit & 1 != 0 {
            rest ^= GENERATOR << (bit - DEGREE);
        }
    }
    rest
}
