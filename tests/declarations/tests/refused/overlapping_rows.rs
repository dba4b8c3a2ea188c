//! Indices in a row that reach into other objects: seen when constants are evaluated, where the lengths are known.

use ecss_can::od::{Objects, Record};

const CHANNELS: usize = 3;

#[derive(Record)]
struct Channel {
    /// Gain
    #[sub(1, rw)]
    gain: u8,
}

#[derive(Objects)]
struct Amplifier {
    /// Channels
    #[object(0x6000.., record)]
    channels: [Channel; CHANNELS],
    /// Mode
    #[object(0x6002, rw)]
    mode: u8,
}

#[derive(Objects)]
struct Edge {
    /// Channels
    #[object(0xFFFE.., record)]
    channels: [Channel; CHANNELS],
}

#[derive(Record)]
struct Table {
    /// Points
    #[sub(1.., rw)]
    points: [u16; CHANNELS],
    /// Unit
    #[sub(3, rw)]
    unit: u8,
}

#[derive(Record)]
struct Long {
    /// Points
    #[sub(250.., rw)]
    points: [u16; 6],
}

fn main() {}
