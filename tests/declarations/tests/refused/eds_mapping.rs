//! A value without `PDOMapping` in its data sheet.

use ecss_can::od::eds;
use ecss_can::pdo::{CobIdOf, Pdo};

eds! {
    struct Valve = "valve.eds";
}

const WRONG: Pdo<Valve, (bool,)> = Pdo::new(CobIdOf::node(0x280)).map(Valve::CALIBRATE);

fn main() {}
