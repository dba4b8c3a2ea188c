//! What a PDO carries: values of the dictionary, one behind the other (CiA 301 7.4.8.2).
//!
//! A mapping is resolved once, when its PDO becomes valid. From then on its values are reached without searching.

use crate::od::communication::MAPPED;
use crate::od::{AbortCode, Address, DataType, Objects, Place};

/// Which way a PDO goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// RPDO.
    Receive,
    /// TPDO.
    Transmit,
}

/// A value in a PDO. From the top: number of its object, which of several in a row, sub-index, bits less one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Slot(u32);

impl Slot {
    const OBJECT: u32 = 23;
    const INSTANCE: u32 = 14;
    const SUB: u32 = 6;
    /// Instances fit below it.
    const INSTANCES: u16 = 1 << (Self::OBJECT - Self::INSTANCE);
    /// Number of no object: its bits go nowhere.
    const DUMMY: u32 = u32::MAX >> Self::OBJECT;
    /// Where a mapping ends: no dummy has 64 bits.
    const UNUSED: Slot = Slot(u32::MAX);

    /// `bits` are 1 to 64.
    const fn dummy(bits: u8) -> Slot {
        Slot(Self::DUMMY << Self::OBJECT | (bits as u32).wrapping_sub(1))
    }

    /// `bits` are 1 to 64. `None` beyond 511 objects, or 512 in a row.
    fn new(place: Place, bits: u8) -> Option<Slot> {
        let [object, instance, sub] = [place.object.into(), place.instance.into(), u32::from(place.sub)];
        (object < Self::DUMMY && place.instance < Self::INSTANCES).then_some(Slot(
            object << Self::OBJECT
                | instance << Self::INSTANCE
                | sub << Self::SUB
                | u32::from(bits).wrapping_sub(1),
        ))
    }

    const fn place(self) -> Place {
        let Slot(raw) = self;
        Place {
            object: (raw >> Self::OBJECT) as u16,
            instance: (raw >> Self::INSTANCE) as u16 & (Self::INSTANCES - 1),
            sub: (raw >> Self::SUB) as u8,
        }
    }

    const fn bits(self) -> u32 {
        (self.0 & ((1 << Self::SUB) - 1)) + 1
    }

    const fn is_dummy(self) -> bool {
        self.0 >> Self::OBJECT == Self::DUMMY
    }
}

/// A resolved mapping: where in the dictionary the bits of a PDO are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Layout {
    slots: [Slot; MAPPED],
    bytes: u8,
}

impl Layout {
    /// Of a PDO without data.
    pub const EMPTY: Layout = Layout { slots: [Slot::UNUSED; MAPPED], bytes: 0 };

    /// Resolves mapping entries: index, sub-index and bits, as objects 1600h and 1A00h hold them.
    ///
    /// # Errors
    /// [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`]; [`AbortCode::NotMappable`]: a value is not for PDOs or not for
    /// this direction, or its type has another number of bits; [`AbortCode::PdoLength`] for more than [`MAPPED`] entries
    /// or 64 bits.
    pub fn new<D: Objects>(direction: Direction, entries: &[u32]) -> Result<Layout, AbortCode> {
        let (mut layout, mut bits) = (Layout::EMPTY, 0_u32);
        let mut free = layout.slots.iter_mut();
        for entry in entries {
            let slot = resolve::<D>(direction, *entry)?;
            bits = bits.saturating_add(slot.bits());
            *free.next().filter(|_| bits <= u64::BITS).ok_or(AbortCode::PdoLength)? = slot;
        }
        layout.bytes = bits.div_ceil(8) as u8;
        Ok(layout)
    }

    /// Data bytes of the PDO, `0..=8`. The last one may be mapped in part.
    pub const fn bytes(&self) -> u8 {
        self.bytes
    }

    /// The PDO with the present values. Bits that are not mapped are zero.
    pub fn pack<D: Objects>(&self, objects: &D) -> u64 {
        let (mut pdo, mut at) = (0_u64, 0_u32);
        for slot in self.slots() {
            pdo |= read(objects, slot).wrapping_shl(at);
            at = at.wrapping_add(slot.bits());
        }
        pdo
    }

    /// Writes the values of a PDO. Bits that are not mapped do not matter. Returns whether all values were within their
    /// limits; others are not written.
    #[inline(never)] // all that the dictionary takes from PDOs: once in an image
    pub fn unpack<D: Objects>(&self, objects: &mut D, pdo: u64) -> bool {
        let (mut all, mut rest) = (true, pdo);
        for slot in self.slots() {
            // What lies above belongs to those behind; a value takes its own bits only.
            if objects.set_bits(slot.place(), rest).is_none() {
                all &= slot.is_dummy();
            }
            // Nothing is behind one of 64 bits.
            rest = rest.wrapping_shr(slot.bits());
        }
        all
    }

    /// Where the values are, without dummies.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        self.slots().filter(|slot| !slot.is_dummy()).map(Slot::place)
    }

    /// Whether it has this value.
    pub fn carries(&self, place: Place) -> bool {
        self.places().any(|own| own == place)
    }

    fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.slots.iter().copied().take_while(|slot| *slot != Slot::UNUSED)
    }
}

/// A function of its own, lest the compiler reads the whole dictionary before the loop because nothing in it changes meanwhile.
#[inline(never)]
fn read<D: Objects>(objects: &D, slot: Slot) -> u64 {
    objects.bits(slot.place()).unwrap_or(0)
}

fn resolve<D: Objects>(direction: Direction, entry: u32) -> Result<Slot, AbortCode> {
    let (index, sub, bits) = ((entry >> 16) as u16, (entry >> 8) as u8, entry as u8);
    if let Some(dummy) = DataType::of_dummy(index) {
        return match sub {
            0 if direction == Direction::Receive && dummy.bits() == Some(bits) => Ok(Slot::dummy(bits)),
            0 => Err(AbortCode::NotMappable),
            _ => Err(AbortCode::NoSubIndex),
        };
    }
    let (place, declared) = D::find(Address::new(index, sub))?;
    let allowed = match direction {
        Direction::Receive => declared.access.is_for_rpdo(),
        Direction::Transmit => declared.access.is_for_tpdo(),
    };
    if !declared.mappable || !allowed || declared.data_type.bits() != Some(bits) {
        return Err(AbortCode::NotMappable);
    }
    Slot::new(place, bits).ok_or(AbortCode::NotMappable)
}
