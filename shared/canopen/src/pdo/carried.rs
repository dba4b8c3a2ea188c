//! What a PDO carries: addresses and bits of its values.

use super::{CobIdOf, MAPPED};
use crate::od::{DataType, Reason};
use crate::types::Address;

/// What a PDO carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Carried {
    bits: u8,
    pub count: u8,
    mapping: [u32; MAPPED],
}

impl Carried {
    pub const NOTHING: Carried = Carried { bits: 0, count: 0, mapping: [0; MAPPED] };

    #[track_caller]
    pub const fn with(mut self, id: CobIdOf, at: Address, of: DataType) -> Carried {
        let Some(bits) = of.bits() else { panic!("a number has a fixed size") };
        if self.count as usize >= MAPPED {
            tell_object(id.tell().text(" has 8 values before "), at).text(": at most 8 are allowed").refuse();
        }
        let all = self.bits as u32 + bits as u32;
        if all > u64::BITS {
            let with = tell_object(id.tell().text(" with "), at).text(" has ").number(all);
            with.text(" bits: at most 64 are allowed").refuse();
        }
        self.mapping[self.count as usize] = (at.index as u32) << 16 | (at.sub as u32) << 8 | bits as u32;
        (self.count, self.bits) = (self.count + 1, all as u8);
        self
    }

    pub const fn bytes(&self) -> u8 {
        self.bits.div_ceil(8)
    }

    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Address and bits of a value that it carries; `None` behind the last.
    pub const fn nth(&self, nth: usize) -> Option<(Address, u8)> {
        if nth >= self.count as usize {
            return None;
        }
        let [index_high, index_low, sub, bits] = self.mapping[nth].to_be_bytes();
        Some((Address::new(u16::from_be_bytes([index_high, index_low]), sub), bits))
    }

    /// Returns the mapped values in the form of objects 1600h and 1A00h.
    pub fn mapping(&self) -> &[u32] {
        self.mapping.get(..usize::from(self.count)).unwrap_or(&self.mapping)
    }
}

/// Adds an object to a text.
pub(super) const fn tell_object(before: Reason, at: Address) -> Reason {
    before.text("object ").hex(at.index, 4).text(" sub-index ").number(at.sub as u32)
}
