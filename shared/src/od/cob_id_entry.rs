//! COB-ID entries: what objects like 1005h, 1014h, 1400h and 1800h hold.
//!
//! An unsigned of 32 bits: the identifier in the low 29, and three flags above. Bit 29 asks for an extended frame,
//! which this system does not speak.

use crate::types::{AbortCode, CobId};

/// A COB-ID entry. Anything can be viewed as one; [`CobIdEntry::written`] has the rules of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CobIdEntry(u32);

/// What an entry is for. It decides about flags and restricted identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EntryUse {
    /// 1005h: bit 31 does not matter, bit 30 makes the node produce SYNC.
    Sync,
    /// 1014h: bit 31 is "not valid", bit 30 is reserved.
    Emcy,
    /// 1400h, 1800h and their like: bit 31 is "not valid", bit 30 "no RTR".
    Pdo,
}

/// Bit 31 of a COB-ID entry: the object does not exist, is not valid.
pub const INVALID: u32 = 1 << 31;
/// Bit 30 of a PDO's entry: no remote frames. Always set: there are none here (ECSS Table 11-1, 7.2.2.4.3).
pub const NO_REMOTE: u32 = FLAG;
/// Bit 30.
const FLAG: u32 = 1 << 30;
/// Bit 29 and the identifier bits that only an extended frame has.
const EXTENDED: u32 = 0x3FFF_F800;

impl CobIdEntry {
    /// As it is stored.
    pub const fn from_raw(raw: u32) -> CobIdEntry {
        CobIdEntry(raw)
    }

    /// As it is stored.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// The identifier, whether the object is valid or not.
    pub const fn id(self) -> CobId {
        CobId::low_bits(self.0)
    }

    /// The identifier of a valid object. An entry for extended frames is not valid.
    pub const fn cob_id(self) -> Option<CobId> {
        if self.0 & (INVALID | EXTENDED) == 0 { Some(self.id()) } else { None }
    }

    /// Bit 30: the node produces SYNC (1005h), RTR is not allowed (PDO).
    pub const fn flag(self) -> bool {
        self.0 & FLAG != 0
    }

    /// The entry after a write. While the object is in use (valid, or the producer of SYNC), its identifier stays, also in
    /// the write that ends its use (CiA 301 7.5.2.5, 7.5.2.17, 7.5.2.35).
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for an extended or restricted identifier (ECSS 6.10b) or a reserved bit. Another
    /// identifier for an object in use: [`AbortCode::UnsupportedAccess`] for a PDO, else [`AbortCode::ValueRange`].
    pub const fn written(self, raw: u32, entry_use: EntryUse) -> Result<CobIdEntry, AbortCode> {
        let new = CobIdEntry(raw);
        let reserved = match entry_use {
            EntryUse::Emcy => EXTENDED | FLAG,
            EntryUse::Sync | EntryUse::Pdo => EXTENDED,
        };
        let (fixed, restrictable) = match entry_use {
            // A consumer listens to the identifier as well.
            EntryUse::Sync => (self.flag(), true),
            _ => (self.cob_id().is_some(), new.cob_id().is_some()),
        };
        let id = new.id();
        if raw & reserved != 0 || restrictable && id.is_restricted() {
            return Err(AbortCode::ValueRange);
        }
        match entry_use {
            _ if !fixed || self.id().raw() == id.raw() => Ok(new),
            EntryUse::Pdo => Err(AbortCode::UnsupportedAccess),
            _ => Err(AbortCode::ValueRange),
        }
    }
}
