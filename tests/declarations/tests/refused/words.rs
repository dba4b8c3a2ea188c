//! Words about "save" where they change nothing, limits of what is no integer, more sub-indices than there can be.

use ecss_can::od::{Domain, Objects};

#[derive(Objects)]
struct NotKeptAnyway {
    /// Counter
    #[object(0x6000, ro, volatile)]
    counter: u32,
}

#[derive(Objects)]
struct NotKeptAsDomain {
    /// Table
    #[object(0x6000, rw, volatile)]
    table: Domain<[u8; 16]>,
}

#[derive(Objects)]
struct KeptAnyway {
    /// Mode
    #[object(0x6000, rw, keep)]
    mode: u8,
}

#[derive(Objects)]
struct Unlimited {
    /// Level
    #[object(0x6000, rw, low = 1)]
    level: f32,
}

#[derive(Objects)]
struct TooMany {
    /// Table
    #[object(0x6000, rw, array)]
    table: [u8; 255],
}

fn main() {}
