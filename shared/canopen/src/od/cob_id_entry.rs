//! COB-ID entries: the values of objects such as 1005h, 1014h, 1201h, 1400h and 1800h.
//!
//! An entry is an unsigned number of 32 bits. The identifier is in the low 29 bits, and three flags are above. Bit
//! 29 requests an extended frame, which this system does not support.

use crate::types::{AbortCode, CobId};

/// COB-ID entry. Any number can be viewed as one; [`CobIdEntry::written`] has the rules for writing.
#[doc(alias = "COB-ID")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CobIdEntry(u32);

/// Object that an entry belongs to. It decides about flags and restricted identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EntryUse {
    /// Entry of 1005h: bit 31 is ignored, bit 30 makes the node produce SYNC.
    Sync,
    /// Entry of 1014h: bit 31 is "not valid", bit 30 is reserved.
    Emcy,
    /// Entry of 1201h: bit 31 is "not valid", bit 30 is refused, because no COB-ID is assigned dynamically.
    Sdo,
    /// Entry of 1400h, 1800h and the following: bit 31 is "not valid", bit 30 is "no RTR".
    Pdo,
}

/// Bit 31 of a COB-ID entry: the communication object is not valid.
pub const INVALID: u32 = 1 << 31;
/// Bit 30 of the entry of a PDO: no remote frames. Always set, because this system has none.
pub const NO_REMOTE: u32 = FLAG;
/// Bit 30.
const FLAG: u32 = 1 << 30;
/// Bit 29 and the identifier bits that only an extended frame has.
const EXTENDED: u32 = 0x3FFF_F800;

impl CobIdEntry {
    /// Views the value of an object as an entry.
    pub const fn from_raw(raw: u32) -> CobIdEntry {
        CobIdEntry(raw)
    }

    /// Returns the value of the object.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// Returns the identifier, even if the communication object is not valid.
    pub const fn id(self) -> CobId {
        CobId::low_bits(self.0)
    }

    /// Returns the identifier if the communication object is valid. An entry for extended frames is not valid.
    pub const fn cob_id(self) -> Option<CobId> {
        if self.0 & (INVALID | EXTENDED) == 0 { Some(self.id()) } else { None }
    }

    /// Returns bit 30: the node produces SYNC (1005h), or RTR is not allowed (PDO).
    pub const fn flag(self) -> bool {
        self.0 & FLAG != 0
    }

    /// Returns the entry after a write.
    ///
    /// The identifier stays while the communication object is in use: valid, or the producer of SYNC (CiA 301
    /// 7.5.2.5, 7.5.2.17, 7.5.2.34, 7.5.2.35). The write that makes a PDO invalid may change it. That is how configuration
    /// tools move a PDO. The write that ends the use of another object may not.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for an extended or restricted identifier or a reserved bit. Another
    /// identifier while in use: [`AbortCode::UnsupportedAccess`] for a PDO, otherwise [`AbortCode::ValueRange`].
    pub const fn written(self, raw: u32, entry_use: EntryUse) -> Result<CobIdEntry, AbortCode> {
        let new = CobIdEntry(raw);
        let reserved = match entry_use {
            EntryUse::Emcy | EntryUse::Sdo => EXTENDED | FLAG,
            EntryUse::Sync | EntryUse::Pdo => EXTENDED,
        };
        let (fixed, restrictable) = match entry_use {
            // A consumer listens to the identifier as well.
            EntryUse::Sync => (self.flag(), true),
            EntryUse::Emcy | EntryUse::Sdo => (self.cob_id().is_some(), new.cob_id().is_some()),
            EntryUse::Pdo => (self.cob_id().is_some() && raw & INVALID == 0, new.cob_id().is_some()),
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
