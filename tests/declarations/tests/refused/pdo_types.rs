//! `pdo` at types that no mapping accepts: strings and DOMAINs, whatever their length.

use ecss_can::od::{Domain, Objects, OctetString, Record, UnicodeString, VisibleString};

#[derive(Objects)]
struct OfDomain {
    /// Table
    #[object(0x6000, rw, pdo)]
    table: Domain<[u8; 4]>,
}

#[derive(Objects)]
struct OfText {
    /// Name
    #[object(0x6000, rw, pdo)]
    name: VisibleString<8>,
}

#[derive(Objects)]
struct OfConstantText {
    /// Name
    #[object(0x6000, constant, pdo, default = "heater")]
    name: &'static str,
}

#[derive(Objects)]
struct OfBytes {
    /// Key
    #[object(0x6000, rww, pdo, optional)]
    key: OctetString<2>,
}

#[derive(Objects)]
struct OfArray {
    /// Names
    #[object(0x6000, array, ro, pdo)]
    names: [UnicodeString<4>; 2],
}

#[derive(Record)]
struct OfRecord {
    /// Key
    #[sub(1, rw, pdo)]
    key: OctetString<16>,
}

fn main() {}
