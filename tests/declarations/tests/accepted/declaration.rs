//! What the refused declarations should have been.
#![deny(warnings)]

use ecss_can::od::{DataType, Domain, Field, NotWritable, Objects, Readable, Record, Typed, U24, Variable};
use ecss_can::types::Address;

#[derive(Objects)]
pub struct Thermometer<G: Objects + Default = Power, const N: usize = 3> {
    /// Temperature
    #[object(0x6000, ro, pdo)]
    pub temperature: i16,
    /// Limits
    #[object(0x6002, rw, array)]
    pub limits: [u8; 2],
    /// Channels
    #[object(0x6003.., record)]
    pub channels: [Channel; N],
    /// Adjacent
    #[object(0x6006, rw)]
    pub adjacent: u8,
    /// None of them
    #[object(0x6007.., array, rw)]
    pub none: [[u8; 2]; 0],
    /// Last
    #[object(0xFFFF, rww, pdo, optional)]
    pub last: u8,
    #[objects]
    pub group: G,
    #[skip]
    pub hidden: Option<u8>,
}

#[derive(Objects)]
pub struct Power {
    /// Voltage
    #[object(0x6001, ro)]
    pub voltage: u16,
    /// Where others have none
    #[object(0x6008, ro)]
    pub current: u16,
}

/// With a lifetime, and a name that Rust has a meaning for.
#[derive(Objects)]
pub struct Borrowing<'a> {
    /// Type
    #[object(0x6100, ro)]
    pub r#type: u8,
    #[skip]
    pub text: &'a str,
}

#[derive(Record)]
pub struct Channel<V: Typed + Copy + Default = u8> {
    /// Gains
    #[sub(1.., rw)]
    pub gains: [V; 253],
    /// Offset
    #[sub(254, rw)]
    pub offset: u8,
    #[skip]
    pub hidden: u8,
}

/// Limits at the ends of the types, and defaults at the limits.
#[derive(Objects)]
pub struct Limited<V: Typed + Copy + Default = u8, const N: usize = 2> {
    /// Whole range
    #[object(0x6200, rw, low = -128, high = 127, default = -128)]
    pub whole: i8,
    /// One value
    #[object(0x6201, rw, low = 7, high = 7, default = 7)]
    pub one: u64,
    /// Command, which is zero until it is written
    #[object(0x6202, wo, low = 1, high = 1)]
    pub command: u8,
    /// Levels
    #[object(0x6203, array, rw, high = 0xFF_FFFF, default = [U24::new(0xFF_FFFF); N])]
    pub levels: [U24; N],
    /// Rows
    #[object(0x6204.., array, rww, pdo, high = 3, default = [[3; 2]; N])]
    pub rows: [[u8; 2]; N],
    /// Of any type
    #[object(0x6208, rw, low = 0, high = 5)]
    pub any: V,
    /// Mode
    #[object(0x6209, rww, pdo, high = 1, default = Mode(1))]
    mode: Mode,
    /// Image, longer than the arrays that have a default
    #[object(0x620A, rw)]
    pub image: Domain<[u8; 4096]>,
}

/// A type of the device itself, private to it.
#[derive(Clone, Copy)]
struct Mode(u8);

impl Variable for Mode {
    fn bits(&self) -> u64 {
        self.0.into()
    }

    fn set_bits(&mut self, bits: u64) {
        self.0 = bits as u8;
    }
}

impl Typed for Mode {
    const TYPE: DataType = DataType::Unsigned8;
    const SIZE: usize = 1;
}

/// A constant of each field: its address, and what is declared of it.
fn main() {
    const TEMPERATURE: Field<i16, Readable, NotWritable> = Thermometer::TEMPERATURE;
    const GAIN: Address = Thermometer::CHANNELS.nth(1).field(Channel::<u8>::GAINS.nth(2)).address();
    assert_eq!(TEMPERATURE.address(), Address::new(0x6000, 0));
    assert_eq!(TEMPERATURE.data_type(), DataType::Integer16);
    assert_eq!(Thermometer::LIMITS.sub(2).address(), Address::new(0x6002, 2));
    assert_eq!(GAIN, Address::new(0x6004, 3));
    assert_eq!(Thermometer::CHANNELS.nth(2).field(Channel::OFFSET).address(), Address::new(0x6005, 254));
    assert_eq!(Thermometer::CHANNELS.nth(0).index(), 0x6003);
    assert_eq!(Borrowing::TYPE.address(), Address::new(0x6100, 0));
    let device = <Thermometer>::default();
    assert_eq!((device.hidden, device.channels[2].hidden), (None, 0));
    let limited = <Limited>::default();
    assert_eq!((limited.whole, limited.one, limited.levels[1].get()), (-128, 7, 0xFF_FFFF));
    assert_eq!((limited.rows, limited.mode.0), ([[3; 2]; 2], 1));
    assert_eq!(limited.image.as_bytes(), []);
}
