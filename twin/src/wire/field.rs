//! Position of a bit within a frame or between frames.

/// The part of the bus traffic that a bit belongs to, as one node sees it (ISO 11898-1, 10.4 to 10.9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Field {
    /// Start of frame.
    Sof,
    /// The 11 bits of a standard identifier, or the first 11 of an extended one; 0 is sent first.
    Identifier(u8),
    /// RTR of a standard frame, SRR of an extended one.
    Rtr,
    /// IDE.
    Ide,
    /// The last 18 bits of an extended identifier; 0 is sent first.
    Extension(u8),
    /// RTR of an extended frame.
    ExtendedRtr,
    /// r1, r0.
    Reserved(u8),
    /// DLC; 0 is sent first.
    Dlc(u8),
    /// Data bits, counted through all bytes; 0 is sent first.
    Data(u8),
    /// CRC sequence; 0 is sent first.
    Crc(u8),
    /// A stuff bit.
    Stuff,
    /// CRC delimiter.
    CrcDelimiter,
    /// ACK slot.
    AckSlot,
    /// ACK delimiter.
    AckDelimiter,
    /// End of frame, 0 to 6.
    Eof(u8),
    /// Intermission, 0 to 2.
    Intermission(u8),
    /// Suspend transmission, 0 to 7.
    Suspend(u8),
    /// A node's own error flag; 0 is its first bit.
    ErrorFlag(u8),
    /// A node's own overload flag; 0 is its first bit.
    OverloadFlag(u8),
    /// After the own flag, while other nodes hold the line dominant, and the first recessive bit of the delimiter.
    Superposition(u8),
    /// Error or overload delimiter from its second bit on, 1 to 7.
    Delimiter(u8),
    /// The bus is idle, or the node does not take part.
    Idle,
}
