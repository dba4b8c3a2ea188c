//! Effects of disturbances.

/// What a disturbance does to the level that a node sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// The other level.
    Invert,
    /// Dominant, whatever is sent.
    Dominant,
    /// Recessive, whatever is sent.
    Recessive,
}
