//! What the refused declarations should have been.
#![deny(warnings)]

use ecss_can::od::{Objects, Record};

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

#[derive(Record)]
pub struct Channel {
    /// Gains
    #[sub(1.., rw)]
    pub gains: [u8; 253],
    /// Offset
    #[sub(254, rw)]
    pub offset: u8,
    #[skip]
    pub hidden: u8,
}

fn main() {
    let device = <Thermometer>::default();
    assert_eq!((device.hidden, device.channels[2].hidden), (None, 0));
}
