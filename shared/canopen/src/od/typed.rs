//! Types of the constants of a declaration: what SDO clients may do with a value, and numbers as they travel.

use super::Typed;

/// In the type of a [`Field`](super::Field): SDO clients may read the value.
#[derive(Debug)]
pub enum Readable {}

/// In the type of a [`Field`](super::Field): the value is write only (`wo`).
#[derive(Debug)]
pub enum NotReadable {}

/// In the type of a [`Field`](super::Field): SDO clients may write the value.
#[derive(Debug)]
pub enum Writable {}

/// In the type of a [`Field`](super::Field): the value is read only (`ro`, `constant`).
#[derive(Debug)]
pub enum NotWritable {}

/// Right of SDO clients in the type of a [`Field`](super::Field).
pub trait Right {
    /// Whether clients have the right.
    const GRANTED: bool;
}

impl Right for Readable {
    const GRANTED: bool = true;
}

impl Right for NotReadable {
    const GRANTED: bool = false;
}

impl Right for Writable {
    const GRANTED: bool = true;
}

impl Right for NotWritable {
    const GRANTED: bool = false;
}

/// Type of a [`Field`](super::Field) whose constant does not know that of the value.
#[derive(Debug)]
pub enum Untyped {}

/// Number of the object dictionary: a value of a fixed size of at most eight bytes.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a number of the object dictionary",
    note = "no PDO carries a string or a DOMAIN; SDO clients move it as bytes, by `read_bytes` and `write_bytes`",
    note = "the values of a record have their types by `field`, not by `sub`"
)]
pub trait Number: Typed + Copy + Default {
    /// Returns the number that the low bits are. `None` if they are no value of an enumeration.
    fn from_bits(bits: u64) -> Option<Self> {
        let mut value = Self::default();
        value.set_bits(bits);
        Some(value)
    }
}
