//! Objects that a minimal slave may have (ECSS Tables 9-11 and 9-12), as a table for the checks of constants.
//!
//! A minimal slave has no dictionary at run time. The dictionary of its data sheet is checked here.

use super::pdos::{MinimalPdos, PDOS};
use crate::od::Objects;
use crate::types::Address;

/// Permission of an object of a minimal slave by Table 9-12. Table 9-11 authorises every data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Permission {
    /// The object is requested, authorised, or not in the tables (ECSS 9.4.10a).
    Authorised,
    /// The object is only for tests, after agreement.
    Tests,
    /// The object is not used if it exists, and has its unused value.
    Forbidden,
}

/// First and last index of what Table 9-12 does not authorise without a condition.
const RESTRICTED: [(u16, u16, Permission); 11] = [
    (0x1007, 0x1007, Permission::Forbidden),
    (0x100C, 0x100D, Permission::Forbidden),
    (0x1010, 0x1015, Permission::Forbidden),
    (0x1200, 0x1200, Permission::Tests),
    (0x1201, 0x127F, Permission::Forbidden),
    (0x1280, 0x1280, Permission::Tests),
    (0x1281, 0x12FF, Permission::Forbidden),
    (0x1404, 0x15FF, Permission::Forbidden),
    (0x1604, 0x17FF, Permission::Forbidden),
    (0x1804, 0x19FF, Permission::Forbidden),
    (0x1A04, 0x1BFF, Permission::Forbidden),
];

/// Communication and mapping parameters of PDO 1: receive, transmit.
const RPDO: [u16; 2] = [0x1400, 0x1600];
const TPDO: [u16; 2] = [0x1800, 0x1A00];
/// COB-ID and transmission type of a PDO.
const FIXED: [u8; 2] = [1, 2];
/// Inhibit time and event timer of a PDO.
const TIMERS: [u8; 2] = [3, 5];

/// Returns the permission of the object with this index by Table 9-12.
pub const fn permission(index: u16) -> Permission {
    let mut nth = 0;
    while nth < RESTRICTED.len() {
        let (first, last, permission) = RESTRICTED[nth];
        if index >= first && index <= last {
            return permission;
        }
        nth += 1;
    }
    Permission::Authorised
}

/// Stops the build if the dictionary `D` is not that of a minimal slave with these PDOs. The reasons are:
///
/// - an object that is forbidden or only for tests (ECSS 9.4.10b);
/// - a PDO in use without parameters or mapping (9.4.10e);
/// - an inhibit time or an event timer (9.4.1d, 9.4.4b);
/// - a PDO in use whose COB-ID or transmission type is missing or can be written (9.4.2d, 9.4.4c);
/// - a mapping that can be written (9.4.5a).
///
/// # Panics
/// When called at run time, for the same reasons.
pub const fn assert_minimal<D: Objects>(pdos: &MinimalPdos) {
    let mut nth = 0;
    while nth < RESTRICTED.len() {
        let (first, last, _) = RESTRICTED[nth];
        let mut index = first;
        while index <= last {
            assert!(!exists::<D>(index), "an object that Table 9-12 of the standard does not authorise");
            index += 1;
        }
        nth += 1;
    }
    let mut pdo = 0;
    while pdo < PDOS {
        assert_pdo::<D>(RPDO, pdo as u16, pdos.receive[pdo].is_some());
        assert_pdo::<D>(TPDO, pdo as u16, pdos.transmit[pdo].is_some());
        pdo += 1;
    }
}

const fn exists<D: Objects>(index: u16) -> bool {
    D::DECLARED.find(Address::new(index, 0)).is_some()
}

const fn assert_pdo<D: Objects>([parameters, mapping]: [u16; 2], pdo: u16, is_used: bool) {
    let (parameters, mapping) = (parameters + pdo, mapping + pdo);
    let has_both = exists::<D>(parameters) && exists::<D>(mapping);
    assert!(!is_used || has_both, "a PDO in use without its parameters or its mapping");
    let mut nth = 0;
    while nth < TIMERS.len() {
        let timer = D::DECLARED.find(Address::new(parameters, TIMERS[nth]));
        assert!(timer.is_none(), "a PDO with an inhibit time or an event timer");
        nth += 1;
    }
    nth = 0;
    while nth < FIXED.len() {
        let is_fixed = match D::DECLARED.find(Address::new(parameters, FIXED[nth])) {
            Some((_, _, entry)) => !entry.access.is_writable(),
            None => !is_used,
        };
        assert!(is_fixed, "a PDO whose COB-ID or transmission type is missing or can be written");
        nth += 1;
    }
    let mut sub = 0;
    while sub <= MOST_MAPPED {
        if let Some((_, _, entry)) = D::DECLARED.find(Address::new(mapping, sub)) {
            assert!(!entry.access.is_writable(), "a mapping that can be written");
        }
        sub += 1;
    }
}

/// Objects in a PDO of 64 bits (CiA 301 7.5.2.36).
const MOST_MAPPED: u8 = 64;
