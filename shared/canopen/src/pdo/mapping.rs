//! Mapping of a PDO: the values of the dictionary that it carries, one after the other (CiA 301 7.4.8.2).
//!
//! A mapping is resolved once, when its PDO becomes valid. From then on its values are reached without a search.

use crate::od::{DataType, Objects, Place, Run};
use crate::pdo::MAPPED;
use crate::types::{AbortCode, Address};

/// Direction of a PDO, seen from the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// Receive PDO (RPDO).
    Receive,
    /// Transmit PDO (TPDO).
    Transmit,
}

/// Values in a PDO. From the top: number of their object, which of several in a row, the first sub-index, how many more
/// follow it, bytes of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Slot(u32);

/// Objects that PDOs reach: their numbers are below.
pub(super) const MOST_OBJECTS: u16 = Slot::DUMMY as u16;
/// Objects in a row that PDOs reach.
pub(super) const MOST_IN_A_ROW: u16 = Slot::INSTANCES;

impl Slot {
    const OBJECT: u32 = 23;
    const INSTANCE: u32 = 14;
    const SUB: u32 = 6;
    const MORE: u32 = 4;
    /// Instances fit below it.
    const INSTANCES: u16 = 1 << (Self::OBJECT - Self::INSTANCE);
    /// Most that may follow the first.
    const MOST: u32 = (1 << (Self::SUB - Self::MORE)) - 1;
    /// Number of no object: its bits go nowhere.
    const DUMMY: u32 = u32::MAX >> Self::OBJECT;
    /// End of a mapping: no value has 15 bytes.
    const UNUSED: Slot = Slot(u32::MAX);

    /// `bits` are 1, or whole bytes up to 64.
    const fn dummy(bits: u8) -> Slot {
        Slot((Self::DUMMY << Self::OBJECT) | (bits as u32 / 8))
    }

    /// `bits` are 1, or whole bytes up to 64. `None` beyond 511 objects, or 512 in a row.
    fn new(place: Place, bits: u8) -> Option<Slot> {
        let [object, instance, sub] = [place.object.into(), place.instance.into(), u32::from(place.sub)];
        (object < Self::DUMMY && place.instance < Self::INSTANCES).then_some(Slot(
            object << Self::OBJECT | instance << Self::INSTANCE | sub << Self::SUB | u32::from(bits / 8),
        ))
    }

    /// With `next`, the value of the same object with the next sub-index, if there is room for one more.
    fn with(self, next: Slot) -> Option<Slot> {
        let follows = Slot(self.0.wrapping_add(self.run().count << Self::SUB) & !(Self::MOST << Self::MORE));
        (!self.is_dummy() && follows == next && self.more() < Self::MOST)
            .then_some(Slot(self.0 + (1 << Self::MORE)))
    }

    const fn place(self) -> Place {
        let Slot(raw) = self;
        Place {
            object: (raw >> Self::OBJECT) as u16,
            instance: (raw >> Self::INSTANCE) as u16 & (Self::INSTANCES - 1),
            sub: (raw >> Self::SUB) as u8,
        }
    }

    const fn more(self) -> u32 {
        self.0 >> Self::MORE & Self::MOST
    }

    const fn run(self) -> Run {
        Run { count: self.more() + 1, bytes: self.0 & ((1 << Self::MORE) - 1) }
    }

    /// Bits of all its values.
    #[inline(always)]
    const fn bits(self) -> u32 {
        self.run().count.wrapping_mul(self.run().bits())
    }

    const fn is_dummy(self) -> bool {
        self.0 >> Self::OBJECT == Self::DUMMY
    }

    fn carries(self, place: Place) -> bool {
        let first = self.place();
        let nth = place.sub.checked_sub(first.sub);
        let is_object = !self.is_dummy() && (first.object, first.instance) == (place.object, place.instance);
        is_object && nth.is_some_and(|nth| u32::from(nth) <= self.more())
    }
}

/// Resolved mapping: the places of the dictionary from which the bits of a PDO come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Layout {
    slots: [Slot; MAPPED],
    bytes: u8,
    least: u8,
}

impl Layout {
    /// Layout of a PDO without data.
    pub(crate) const EMPTY: Layout = Layout { slots: [Slot::UNUSED; MAPPED], bytes: 0, least: 0 };

    /// Resolves mapping entries: index, sub-index and bits, as objects 1600h and 1A00h hold them.
    ///
    /// # Errors
    /// [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`]. [`AbortCode::NotMappable`] if a value may not be in PDOs
    /// or not in this direction, or if its type has another number of bits. [`AbortCode::PdoLength`] for more than
    /// [`MAPPED`] entries or 64 bits.
    pub fn new<D: Objects>(direction: Direction, entries: &[u32]) -> Result<Layout, AbortCode> {
        let (mut slots, mut bits, mut least) = ([Slot::UNUSED; MAPPED], 0_u32, 0);
        let mut rest = slots.iter_mut();
        let mut last: Option<(&mut Slot, u8)> = None;
        for (number, entry) in entries.iter().enumerate() {
            let (slot, row, is_optional) = resolve::<D>(direction, *entry)?;
            bits = bits.saturating_add(slot.bits());
            least = if is_optional { least } else { bits };
            if bits > u64::BITS || number >= MAPPED {
                return Err(AbortCode::PdoLength);
            }
            // The next one of the same array moves with the one before.
            if let Some((before, _)) = last.as_mut().filter(|(_, before)| *before == row)
                && let Some(joined) = before.with(slot)
            {
                **before = joined;
            } else if let Some(free) = rest.next() {
                *free = slot;
                last = Some((free, row));
            }
        }
        Ok(Layout { slots, bytes: bits.div_ceil(8) as u8, least: least.div_ceil(8) as u8 })
    }

    /// Returns the data bytes of the PDO, `0..=8`. The last one may be mapped in part.
    pub const fn bytes(&self) -> u8 {
        self.bytes
    }

    /// Returns the least number of bytes of a frame: up to the last value that is not
    /// [optional](crate::od::PdoUse::Optional).
    pub const fn least(&self) -> u8 {
        self.least
    }

    /// Returns the PDO with the present values. Bits that are not mapped are zero.
    #[inline]
    pub fn pack<D: Objects>(&self, objects: &D) -> u64 {
        match self.only() {
            Some(slot) => read(objects, slot),
            None => self.pack_all(objects),
        }
    }

    #[inline(never)]
    fn pack_all<D: Objects>(&self, objects: &D) -> u64 {
        let (mut pdo, mut at) = (0_u64, 0_u32);
        // A plain loop: built for size, an iterator that ends early is a call for each slot.
        for &slot in &self.slots {
            if slot == Slot::UNUSED {
                break;
            }
            pdo |= read(objects, slot).wrapping_shl(at);
            at = at.wrapping_add(slot.bits());
        }
        pdo
    }

    /// Writes the values of a PDO. Bits that are not mapped are ignored. Returns whether all values were within
    /// their limits; the others are not written.
    #[inline(always)]
    pub fn unpack<D: Objects>(&self, objects: &mut D, pdo: u64) -> bool {
        match self.only() {
            Some(slot) => write(objects, slot, pdo),
            None => self.unpack_all(objects, pdo),
        }
    }

    #[inline(never)]
    fn unpack_all<D: Objects>(&self, objects: &mut D, pdo: u64) -> bool {
        let (mut all, mut rest) = (true, pdo);
        for &slot in &self.slots {
            if slot == Slot::UNUSED {
                break;
            }
            // What lies above belongs to those behind; a value takes its own bits only.
            all &= take(objects, slot, rest);
            // Nothing is behind one of 64 bits.
            rest = shift_down(rest, slot.bits());
        }
        all
    }

    /// The slot of a mapping that has no other. An unused one reads as zero and takes nothing.
    #[inline]
    fn only(&self) -> Option<Slot> {
        let [first, second, ..] = self.slots;
        (second == Slot::UNUSED).then_some(first)
    }

    /// Returns whether the PDO carries this value.
    pub fn carries(&self, place: Place) -> bool {
        self.slots().any(|slot| slot.carries(place))
    }

    fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.slots.iter().copied().take_while(|slot| *slot != Slot::UNUSED)
    }
}

/// `bits` without the lowest `by`, `0..=64`. In words: built for size, a shift of 64 bits is a call.
#[inline]
fn shift_down(bits: u64, by: u32) -> u64 {
    let (high, low) = ((bits >> 32) as u32, bits as u32);
    let (high, low) = if by < 32 {
        (high >> by, low >> by | high.unbounded_shl(32 - by))
    } else {
        (0, high.unbounded_shr(by - 32))
    };
    u64::from(high) << 32 | u64::from(low)
}

/// All that PDOs take from the dictionary: once in an image.
#[inline(never)]
fn read<D: Objects>(objects: &D, slot: Slot) -> u64 {
    objects.bits(slot.place(), slot.run()).unwrap_or(0)
}

/// Writes the value of a PDO with one value. It is apart from PDOs with several values, so that both are short.
#[inline(never)]
fn write<D: Objects>(objects: &mut D, slot: Slot, bits: u64) -> bool {
    take(objects, slot, bits)
}

/// Writes the value of a slot. Returns whether it was within its limits.
#[inline(always)]
fn take<D: Objects>(objects: &mut D, slot: Slot, bits: u64) -> bool {
    objects.set_bits(slot.place(), slot.run(), bits).is_some() || slot.is_dummy()
}

/// The value of an entry, the first sub-index of those alike in a row, and whether a frame may leave it out.
fn resolve<D: Objects>(direction: Direction, entry: u32) -> Result<(Slot, u8, bool), AbortCode> {
    let (index, sub, bits) = ((entry >> 16) as u16, (entry >> 8) as u8, entry as u8);
    if let Some(dummy) = DataType::of_dummy(index) {
        return match sub {
            0 if direction == Direction::Receive && dummy.bits() == Some(bits) => {
                Ok((Slot::dummy(bits), 0, false))
            }
            0 => Err(AbortCode::NotMappable),
            _ => Err(AbortCode::NoSubIndex),
        };
    }
    let (place, declared) = D::find(Address::new(index, sub))?;
    if !direction.carries(declared) || declared.data_type.bits() != Some(bits) {
        return Err(AbortCode::NotMappable);
    }
    let slot = Slot::new(place, bits).ok_or(AbortCode::NotMappable)?;
    Ok((slot, declared.sub, declared.is_optional()))
}
