//! Limits that exclude each other or that the type cannot reach, and defaults outside the limits.

use ecss_can::od::{Objects, Record, U24};

#[derive(Objects)]
struct Swapped {
    /// Level
    #[object(0x6000, rw, low = 300, high = 200)]
    level: u16,
}

const LOW: i64 = 300;

#[derive(Objects)]
struct SwappedByConstant {
    /// Level
    #[object(0x6000, rw, low = LOW, high = 200)]
    level: u16,
}

#[derive(Objects)]
struct AboveType {
    /// Level
    #[object(0x6000, rw, high = 300)]
    level: u8,
}

#[derive(Objects)]
struct BelowType {
    /// Level
    #[object(0x6000, rw, low = -129, high = 100)]
    level: i8,
}

#[derive(Objects)]
struct NegativeUnsigned {
    /// Level
    #[object(0x6000, rw, low = -1)]
    level: u32,
}

#[derive(Objects)]
struct AboveUnusualType {
    /// Level
    #[object(0x6000, rw, high = 0x100_0000)]
    level: U24,
}

#[derive(Objects)]
struct DefaultTooHigh {
    /// Level
    #[object(0x6000, rw, low = 1, high = 100, default = 101)]
    level: u8,
}

#[derive(Objects)]
struct DefaultTooLow {
    /// Level
    #[object(0x6000, rw, low = -40, default = -41)]
    level: i16,
}

type Percent = U24;

#[derive(Objects)]
struct DefaultsOfArray {
    /// Levels
    #[object(0x6000, array, rw, high = 100, default = [Percent::new(100), Percent::new(101)])]
    levels: [Percent; 2],
}

#[derive(Objects)]
struct DefaultsInRow<const N: usize = 3> {
    /// Levels
    #[object(0x6000.., array, rw, high = 5, default = [[6; 2]; N])]
    levels: [[u8; 2]; N],
}

#[derive(Record)]
struct DefaultInRecord {
    /// Level
    #[sub(1, rw, high = 5, default = 7)]
    level: u8,
}

fn main() {}
