//! A declaration with a parameter that has no default is checked where its constructor is used.

use ecss_can::od::Objects;

#[derive(Objects)]
struct Device<G: Objects + Default> {
    /// Mode
    #[object(0x6100, rw)]
    mode: u8,
    #[objects]
    group: G,
}

#[derive(Objects)]
struct Group {
    /// Mode
    #[object(0x6100, rw)]
    mode: u8,
}

fn main() {
    Device::<Group>::default();
}
