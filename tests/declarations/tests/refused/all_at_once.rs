//! Several errors in one declaration: each is shown, at its own place.

use ecss_can::od::{Objects, Record};

#[derive(Objects)]
#[objects(verify = check)]
struct Thermometer {
    /// Temperature
    #[object(0x6000, pdo)]
    temperature: i16,
    #[object(0x6001, rw)]
    nameless: u8,
    /// Limits
    #[object(0x6002, rw, array)]
    limits: u8,
    /// Mode
    #[object(0x6003, readonly, quick = 4, rw)]
    mode: u8,
    /// Counter
    #[object(0x6000, ro, pdo)]
    counter: u32,
    /// Far away
    #[object(0x1_0000, ro)]
    far: u8,
    forgotten: u8,
    /// Two ways
    #[object(0x6004, ro)]
    #[objects]
    both: u8,
    /// Two rights
    #[object(0x6005, ro, rw)]
    rights: u8,
    /// Twice the same word
    #[object(0x6006, rw, pdo, pdo)]
    twice: u8,
    /// Left out by frames, but in none
    #[object(0x6007, rww, optional)]
    optional: u8,
    /// Kept and not kept
    #[object(0x6009, rw, keep, volatile)]
    kept: u8,
    /// Calibration
    #[object(0x6008, record, pdo)]
    calibration: Calibration,
}

#[derive(Record)]
struct Calibration {
    /// Offset
    #[sub(1)]
    offset: i16,
    /// Gain
    #[sub(1, rw)]
    gain: i16,
    /// Table
    #[sub(2, rw, array)]
    table: [u8; 4],
    /// Beyond
    #[sub(255, rw)]
    beyond: u8,
    forgotten: u8,
}

/// Uses of a refused type add no errors.
fn main() {
    let mut thermometer = Thermometer::default();
    let found = ecss_can::od::checked::find(&mut thermometer, ecss_can::types::Address::new(0x6000, 0));
    assert!(found.is_err() && Calibration::ENTRIES.is_empty());
}
