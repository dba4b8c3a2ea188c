//! A field of another record than the object has.

use ecss_can::od::{Field, Objects, Record};

#[derive(Objects)]
struct Device {
    /// Channel
    #[object(0x6001, record)]
    channel: Channel,
}

#[derive(Record)]
struct Channel {
    /// Gain
    #[sub(1, rw)]
    gain: u8,
}

#[derive(Record)]
struct Other {
    /// Value
    #[sub(1, rw)]
    value: u8,
}

const VALUE: Field = Device::CHANNEL.field(Other::VALUE);

fn main() {}
