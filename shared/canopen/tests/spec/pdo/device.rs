//! A device with values of every width, and what is mapped of it.

use async_canopen::od::{
    I24, I40, I48, I56, Objects, Record, TimeDifference, TimeOfDay, U24, U40, U48, U56, VisibleString,
    checked,
};
use async_canopen::types::Address;

/// Values of every kind that PDOs carry, and some that they do not.
#[derive(Clone, Debug, Objects)]
pub struct Device {
    /// Words
    #[object(0x6000, array, rw, pdo)]
    pub words: [u16; 5],
    /// Flags
    #[object(0x6001, array, rw, pdo)]
    pub flags: [bool; 8],
    /// Channels
    #[object(0x6010.., record)]
    pub channels: [Channel; 3],
    /// Read only
    #[object(0x6020, ro, pdo)]
    pub ro: u8,
    /// Write only
    #[object(0x6021, wo, pdo)]
    pub wo: u8,
    /// Read, write, transmit
    #[object(0x6022, rwr, pdo)]
    pub rwr: u8,
    /// Read, write, receive
    #[object(0x6023, rww, pdo)]
    pub rww: u8,
    /// Constant
    #[object(0x6024, constant, pdo)]
    pub constant: u8,
    /// Not for PDOs
    #[object(0x6025, rw)]
    pub private: u8,
    /// Text
    #[object(0x6026, rw)]
    pub text: VisibleString<8>,
    /// Level
    #[object(0x6027, rw, pdo, low = 10, high = 90, default = 10)]
    pub level: u8,
    /// Trims
    #[object(0x6028, record)]
    pub trims: Trims,
    /// Wide values
    #[objects]
    pub wide: Wide,
}

/// A channel.
#[derive(Clone, Copy, Debug, Record)]
pub struct Channel {
    /// Gain
    #[sub(1, rw, pdo)]
    pub gain: U24,
    /// Enabled
    #[sub(2, rw, pdo)]
    pub enabled: bool,
}

/// Trims.
#[derive(Clone, Copy, Debug, Record)]
pub struct Trims {
    /// Trim
    #[sub(1.., rww, pdo, low = -5, high = 5)]
    pub trim: [i8; 3],
}

/// Every type of fixed size.
#[derive(Clone, Debug, Objects)]
pub struct Wide {
    /// INTEGER8
    #[object(0x6102, rw, pdo)]
    pub i8: i8,
    /// INTEGER16
    #[object(0x6103, rw, pdo)]
    pub i16: i16,
    /// INTEGER32
    #[object(0x6104, rw, pdo)]
    pub i32: i32,
    /// UNSIGNED32
    #[object(0x6107, rw, pdo)]
    pub u32: u32,
    /// REAL32
    #[object(0x6108, rw, pdo)]
    pub f32: f32,
    /// TIME_OF_DAY
    #[object(0x610C, ro, pdo)]
    pub time: TimeOfDay,
    /// TIME_DIFFERENCE
    #[object(0x610D, ro, pdo)]
    pub difference: TimeDifference,
    /// INTEGER24
    #[object(0x6110, rw, pdo)]
    pub i24: I24,
    /// REAL64
    #[object(0x6111, rw, pdo)]
    pub f64: f64,
    /// INTEGER40
    #[object(0x6112, rw, pdo)]
    pub i40: I40,
    /// INTEGER48
    #[object(0x6113, rw, pdo)]
    pub i48: I48,
    /// INTEGER56
    #[object(0x6114, rw, pdo)]
    pub i56: I56,
    /// INTEGER64
    #[object(0x6115, rw, pdo)]
    pub i64: i64,
    /// UNSIGNED40
    #[object(0x6118, rw, pdo)]
    pub u40: U40,
    /// UNSIGNED48
    #[object(0x6119, rw, pdo)]
    pub u48: U48,
    /// UNSIGNED56
    #[object(0x611A, rw, pdo)]
    pub u56: U56,
    /// UNSIGNED64
    #[object(0x611B, rw, pdo)]
    pub u64: u64,
}

/// What may go both ways: index, sub-index, bits.
pub const BOTH_WAYS: [(u16, u8, u8); 34] = [
    (0x6000, 1, 16),
    (0x6000, 2, 16),
    (0x6000, 3, 16),
    (0x6000, 4, 16),
    (0x6000, 5, 16),
    (0x6001, 1, 1),
    (0x6001, 2, 1),
    (0x6001, 3, 1),
    (0x6001, 4, 1),
    (0x6001, 5, 1),
    (0x6001, 6, 1),
    (0x6001, 7, 1),
    (0x6001, 8, 1),
    (0x6010, 1, 24),
    (0x6010, 2, 1),
    (0x6011, 1, 24),
    (0x6011, 2, 1),
    (0x6012, 1, 24),
    (0x6012, 2, 1),
    (0x6102, 0, 8),
    (0x6103, 0, 16),
    (0x6104, 0, 32),
    (0x6107, 0, 32),
    (0x6108, 0, 32),
    (0x6110, 0, 24),
    (0x6111, 0, 64),
    (0x6112, 0, 40),
    (0x6113, 0, 48),
    (0x6114, 0, 56),
    (0x6115, 0, 64),
    (0x6118, 0, 40),
    (0x6119, 0, 48),
    (0x611A, 0, 56),
    (0x611B, 0, 64),
];

/// A mapping entry.
pub const fn entry(index: u16, sub: u8, bits: u8) -> u32 {
    (index as u32) << 16 | (sub as u32) << 8 | bits as u32
}

/// Four words: 6000h sub 1 to 4.
pub const WORDS: [u32; 4] =
    [entry(0x6000, 1, 16), entry(0x6000, 2, 16), entry(0x6000, 3, 16), entry(0x6000, 4, 16)];

/// Every value as an SDO reads it.
pub fn dump(device: &mut Device) -> Vec<(Address, Vec<u8>)> {
    let mut addresses = vec![];
    Device::describe(&mut |object, _| {
        for instance in 0..object.count {
            for entry in object.entries {
                for nth in 0..entry.count {
                    addresses.push(Address::new(object.index + instance, entry.sub + nth));
                }
            }
        }
    });
    addresses.into_iter().map(|at| (at, read(device, at))).collect()
}

/// A value as an SDO reads it.
pub fn read(device: &mut Device, at: Address) -> Vec<u8> {
    let mut bytes = [0; 16];
    let len = checked::find(device, at).unwrap().read(0, &mut bytes);
    bytes[..len].to_vec()
}
