//! Data sheets that cannot be read, wrong entries of one, and uses that access rights forbid.

use ecss_can::od::{Field, NotWritable, Readable, eds};

eds! {
    struct Nowhere = "/nowhere/valve.eds";
    struct Text = "text.eds";
    struct Empty = "empty.eds";
    struct Wrong = "wrong.eds";
    struct Valve = "valve.eds";
}

/// The other values of a file with errors are usable.
const USABLE: Field<u8, Readable, NotWritable> = Wrong::USABLE;
const POWER_IS_READ_ONLY: Field<u8> = Valve::MOTOR_POWER;

fn main() {}
