//! What the refused enumerations and the refused structs of PDOs should have been.
#![deny(warnings)]

use ecss_can::od::{DataType, Enumeration, Field, Objects};
use ecss_can::pdo::{CobIdOf, Pdo, PdoValues};
use ecss_can::types::NodeId;

/// A name that Rust has a meaning for, an expression, and a number that follows from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(i8)]
pub enum Mode {
    #[default]
    r#Match = -1,
    On = 1 << 3,
    Next,
}

/// A default that is no unit of the macro.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum Manual {
    Off,
    On,
}

impl Default for Manual {
    fn default() -> Self {
        Manual::On
    }
}

/// A heater.
#[derive(Objects)]
pub struct Heater {
    /// Mode
    #[object(0x6000, rw, pdo, low = -1, high = 8, default = Mode::On)]
    pub mode: Mode,
    /// Manual
    #[object(0x6001, array, rw, pdo)]
    manual: [Manual; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PdoValues)]
pub struct Values<T: ecss_can::od::Number = u8> {
    pub mode: Mode,
    pub payload: T,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PdoValues)]
pub struct Nothing {}

const MODE: Field<Mode> = Heater::MODE;
const VALUES: Pdo<Heater, Values> = Pdo::new(CobIdOf::node(0x280)).map(MODE).skip().into_struct();
const MANUAL: Pdo<Heater, (Manual,)> = Pdo::new(CobIdOf::node(0x380)).map(Heater::MANUAL.sub(2));
const NOTHING: Pdo<Heater, Nothing> = Pdo::new(CobIdOf::node(0x480)).into_struct();

fn main() {
    let (heater, node) = (Heater::default(), NodeId::of::<5>());
    assert_eq!((heater.mode, heater.manual), (Mode::On, [Manual::On; 2]));
    assert_eq!(MODE.data_type(), DataType::Integer8);
    let frame = VALUES.of(node).frame(Values { mode: Mode::r#Match, payload: 7 });
    assert_eq!(frame.data(), [0xFF, 7]);
    assert_eq!(MANUAL.of(node).frame((Manual::Off,)).data(), [0]);
    assert_eq!(NOTHING.of(node).frame(Nothing {}).data(), []);
    assert_ne!(Mode::Next, Mode::On);
}
