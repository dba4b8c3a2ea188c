//! Pins of the packages: DS8626, DS8597, DS9405, DS9484, DS10693, DS11189, tables of pins.

use super::Family;
use crate::pin::Pin;

/// Number of pins by the letter of the package.
pub(super) const fn pins(package: char) -> u32 {
    match package {
        'R' => 64,
        'V' => 100,
        'Z' => 144,
        'I' => 176,
        'B' => 208,
        _ => 216,
    }
}

/// Returns whether a package has a pin.
pub(super) fn has(family: Family, package: char, Pin { port, number }: Pin) -> bool {
    let from = match (port, number) {
        ('A'..='C', _) | ('D', 2) | ('H', 0 | 1) => 64,
        ('D' | 'E', _) => 100,
        ('F' | 'G', _) => 144,
        ('H', _) | ('I', 0..=11) => 176,
        ('I' | 'J', _) | ('K', 0..=7) => 208,
        _ => return false,
    };
    let is_taken = match (family, package) {
        // VCAP_1 is in the place of PB11.
        (Family::F446, 'R' | 'V') => matches!((port, number), ('B', 11)),
        // The DSI host has dedicated pins.
        (Family::F469, 'V') => matches!((port, number), ('C', 4 | 5) | ('D', 11..=13) | ('E', 0 | 1 | 3..=6)),
        (Family::F469, 'Z') => matches!((port, number), ('D', 7 | 13) | ('F', 6..=9) | ('G', 13 | 14)),
        (Family::F469, 'I') => matches!((port, number), ('H', 8..=15) | ('I', 2)),
        (Family::F469, _) => matches!((port, number), ('J', 6..=11) | ('K', 0..=2)),
        _ => false,
    };
    from <= pins(package) && !is_taken
}
