//! Structures of the communication profile (CiA 301 7.4.8).

use crate::od::{INVALID, NO_REMOTE, Record};

/// Entries of a PDO mapping.
pub const MAPPED: usize = 8;

/// Communication parameters of a receive PDO (0020h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x20)]
pub struct RpdoParameters {
    /// COB-ID used by PDO
    #[sub(1, rw, default = INVALID | NO_REMOTE)]
    pub cob_id: u32,
    /// Transmission type
    #[sub(2, rw, default = 254)]
    pub transmission: u8,
    /// Inhibit time
    ///
    /// Not used.
    #[sub(3, rw)]
    pub inhibit: u16,
    /// Event timer
    ///
    /// The deadline of the PDO, milliseconds; zero for none.
    #[sub(5, rw)]
    pub event_timer: u16,
}

/// Communication parameters of a transmit PDO (0020h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x20)]
pub struct TpdoParameters {
    /// COB-ID used by PDO
    #[sub(1, rw, default = INVALID | NO_REMOTE)]
    pub cob_id: u32,
    /// Transmission type
    #[sub(2, rw, default = 254)]
    pub transmission: u8,
    /// Inhibit time
    ///
    /// Multiples of 100 us.
    #[sub(3, rw)]
    pub inhibit: u16,
    /// Event timer
    ///
    /// Milliseconds; zero for none.
    #[sub(5, rw)]
    pub event_timer: u16,
    /// SYNC start value
    #[sub(6, rw, high = 240)]
    pub sync_start: u8,
}

/// What a PDO carries (0021h), variable: written by SDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x21)]
pub struct PdoMapping {
    /// Number of mapped objects
    #[sub(0, rw, high = 8)]
    pub count: u8,
    /// Mapped object
    ///
    /// Index in the upper half, then sub-index, then bits.
    #[sub(1.., rw)]
    pub objects: [u32; MAPPED],
}

/// What a PDO carries (0021h), static: as the device was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x21)]
pub struct StaticMapping {
    /// Number of mapped objects
    #[sub(0, ro, high = 8)]
    pub count: u8,
    /// Mapped object
    ///
    /// Index in the upper half, then sub-index, then bits.
    #[sub(1.., ro)]
    pub objects: [u32; MAPPED],
}

/// The mapping parameters of a PDO, variable or static.
pub trait Mapping: 'static + Record + Default + Clone + core::fmt::Debug {
    /// The objects mapped.
    fn objects(&self) -> &[u32];

    /// Maps these, at most [`MAPPED`]; more are cut off.
    fn map(&mut self, objects: &[u32]);
}

/// Both kinds have the same fields.
macro_rules! mapping {
    ($type:ty) => {
        impl Mapping for $type {
            fn objects(&self) -> &[u32] {
                self.objects.get(..usize::from(self.count)).unwrap_or(&self.objects)
            }

            fn map(&mut self, objects: &[u32]) {
                *self = Self::default();
                self.count = objects.len().min(MAPPED) as u8;
                for (slot, object) in self.objects.iter_mut().zip(objects) {
                    *slot = *object;
                }
            }
        }
    };
}

mapping!(PdoMapping);
mapping!(StaticMapping);
