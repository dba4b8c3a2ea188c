//! Numbers of the boards of a spacecraft.

/// Number of a board: 1 is the master, 2 to 15 are slaves, by their Node-IDs; [`SECOND_MASTER`].
pub type Node = u8;

/// The master's Node-ID.
pub const MASTER: Node = 1;

/// The second one of two master boards. Its Node-ID is 1 as well. This number only identifies the board; no slave has
/// it.
pub const SECOND_MASTER: Node = 127;

/// Returns whether a board is a master.
pub const fn is_master(board: Node) -> bool {
    matches!(board, MASTER | SECOND_MASTER)
}

/// First and last Node-ID that the straps of a slave can set.
pub const FIRST: Node = 2;
/// See [`FIRST`].
pub const LAST: Node = 15;
