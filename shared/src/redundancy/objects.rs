//! Object 2000h.

use crate::od::{Objects, Record};

/// The object of redundancy.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct RedundancyObjects {
    /// Redundancy
    #[object(0x2000, record)]
    pub parameters: Redundancy,
}

/// Redundancy parameters (2000h, ECSS 8.3.1).
///
/// Written by SDO only, which the redundancy hears of; a PDO would change no more than the value here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Redundancy {
    /// Bdefault
    ///
    /// 0 nominal, 1 redundant.
    #[sub(1, rwr, pdo)]
    pub bdefault: u8,
    /// Ttoggle
    ///
    /// Consumer times.
    #[sub(2, rw)]
    pub ttoggle: u8,
    /// Ntoggle
    #[sub(3, rw)]
    pub ntoggle: u8,
    /// Ctoggle
    ///
    /// Begins at zero (ECSS 8.3.2a).
    #[sub(4, rwr, pdo, volatile)]
    pub ctoggle: u8,
}
