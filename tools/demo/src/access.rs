//! Access of a slave to the two buses.

/// Access of a slave to the two buses (ECSS 4.8.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusAccess {
    /// Both controllers live.
    Parallel,
    /// One bus at a time.
    Selective,
    /// An image of the user's decides.
    Unknown,
}

impl BusAccess {
    /// The word of the standard, if it is known.
    pub fn name(self) -> &'static str {
        match self {
            BusAccess::Parallel => "parallel",
            BusAccess::Selective => "selective",
            BusAccess::Unknown => "",
        }
    }
}
