//! Structures of the communication profile for PDOs (CiA 301 7.4.8).

use core::ops::{Deref, DerefMut};

use crate::od::{Entry, INVALID, NO_REMOTE, Record, Variable};

/// Most entries of a PDO mapping.
pub const MAPPED: usize = 8;

/// Communication parameters of a transmit PDO (record 0020h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x20)]
pub struct PdoParameters {
    /// COB-ID used by PDO
    #[sub(1, rw, default = INVALID | NO_REMOTE)]
    pub cob_id: u32,
    /// Transmission type
    #[sub(2, rw, default = 254)]
    pub transmission: u8,
    /// Inhibit time
    ///
    /// Multiples of 100 us. A receive PDO does not use it.
    #[sub(3, rw)]
    pub inhibit: u16,
    /// Event timer
    ///
    /// Milliseconds; zero for none. Of a receive PDO it is the deadline.
    #[sub(5, rw)]
    pub event_timer: u16,
    /// SYNC start value
    #[sub(6, rw, high = 240)]
    pub sync_start: u8,
}

/// Communication parameters of a receive PDO: the same without the SYNC start value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RpdoParameters(PdoParameters);

impl Deref for RpdoParameters {
    type Target = PdoParameters;

    fn deref(&self) -> &PdoParameters {
        &self.0
    }
}

impl DerefMut for RpdoParameters {
    fn deref_mut(&mut self) -> &mut PdoParameters {
        &mut self.0
    }
}

impl Record for RpdoParameters {
    const ENTRIES: &'static [Entry] = {
        let [_, cob_id, transmission, inhibit, event_timer, _] = PdoParameters::ENTRIES else {
            panic!("six entries")
        };
        &[Entry::highest(5), *cob_id, *transmission, *inhibit, *event_timer]
    };
    const NAMES: &'static [&'static str] = {
        let Some((_, names)) = PdoParameters::NAMES.split_last() else { panic!("six names") };
        names
    };
    const STRUCTURE: u16 = PdoParameters::STRUCTURE;

    fn variable(&mut self, sub: u8) -> Option<&mut dyn Variable> {
        if sub < 6 { self.0.variable(sub) } else { None }
    }
}

/// Variable mapping of a PDO (record 0021h): clients write it by SDO.
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

/// Static mapping of a PDO (record 0021h): the device fixes it.
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

/// Mapping parameters of a PDO, variable or static.
pub trait Mapping: 'static + Record + Default + Clone + core::fmt::Debug {
    /// Returns the mapped objects: index, sub-index, bits.
    fn objects(&self) -> &[u32];

    /// Maps these objects, at most [`MAPPED`]. More are cut off.
    fn map(&mut self, objects: &[u32]);

    /// Lends the number of mapped objects and all entries, also those beyond the number.
    fn parts_mut(&mut self) -> (&mut u8, &mut [u32; MAPPED]);
}

/// Implements [`Mapping`] for both kinds, which have the same fields.
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

            fn parts_mut(&mut self) -> (&mut u8, &mut [u32; MAPPED]) {
                (&mut self.count, &mut self.objects)
            }
        }
    };
}

mapping!(PdoMapping);
mapping!(StaticMapping);
