//! A forgotten `record` or `array` of an object that travels in PDOs is one error.

use ecss_can::od::{Objects, Record};

#[derive(Record)]
struct Point {
    /// X
    #[sub(1, rw, pdo)]
    x: u8,
}

#[derive(Objects)]
struct RecordWithoutWord {
    /// Point
    #[object(0x6000, rw, pdo)]
    point: Point,
}

#[derive(Objects)]
struct ArrayWithoutWord {
    /// Values
    #[object(0x6000, rw, pdo)]
    values: [u8; 3],
}

#[derive(Objects)]
struct ArrayOfRecords {
    /// Points
    #[object(0x6000, array, rw, pdo)]
    points: [Point; 3],
}

#[derive(Record)]
struct RowOfRecords {
    /// Points
    #[sub(1.., rw, pdo)]
    points: [Point; 2],
}

fn main() {}
