//! Structs that are not the values of a PDO.

use ecss_can::od::{Objects, VisibleString};
use ecss_can::pdo::{CobIdOf, Pdo, PdoValues};

#[derive(Objects)]
struct Heater {
    /// Temperature
    #[object(0x6000, ro, pdo)]
    temperature: i16,
    /// Power
    #[object(0x6001, ro, pdo)]
    power: u8,
}

#[derive(PdoValues)]
struct Change {
    temperature: i16,
    power: u8,
}

#[derive(PdoValues)]
struct Swapped {
    power: u8,
    temperature: i16,
}

#[derive(PdoValues)]
struct Short {
    temperature: i16,
}

struct Underived {
    temperature: i16,
    power: u8,
}

#[derive(PdoValues)]
struct WithoutNames(i16, u8);

#[derive(PdoValues)]
struct Nine {
    one: u8,
    two: u8,
    three: u8,
    four: u8,
    five: u8,
    six: u8,
    seven: u8,
    eight: u8,
    nine: u8,
}

#[derive(PdoValues)]
struct WithText {
    text: VisibleString<4>,
}

const TUPLE: Pdo<Heater, (i16, u8)> = Pdo::new(CobIdOf::node(0x280)).map(Heater::TEMPERATURE).map(Heater::POWER);
const CHANGE: Pdo<Heater, Change> = TUPLE.into_struct();
const UNNAMED: Pdo<Heater, WithoutNames> = TUPLE.into_struct();
const SWAPPED: Pdo<Heater, Swapped> = TUPLE.into_struct();
const SHORT: Pdo<Heater, Short> = TUPLE.into_struct();
const UNDERIVED: Pdo<Heater, Underived> = TUPLE.into_struct();
const FORGOTTEN: Pdo<Heater, Change> = TUPLE;

fn main() {}
