//! Choice of upsets: which board, instant, byte or register, and bit.
//!
//! Boards and instants are equally likely, and so are the bits of a place on a board. The seed of the campaign and the number of the draw
//! determine the upset.

use std::ops::Range;

use can_twin::board::{StateRegister, Use};

use super::place::{Place, Target, Upset};
use super::places::core_registers;
use super::world::{Moment, RESET_US, World};

/// Bits of a byte.
const BYTE: u32 = 8;

/// An upset of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The upset.
    pub upset: Upset,
    /// The reference shows that it has no effect: the byte is not read any more, or is written first.
    pub is_unused: bool,
}

/// Returns the upset with this number among those of a place; `None` where the place has no bits, as a parameter store without content.
pub fn choose(world: &World, seed: u64, place: Place, number: u64) -> Option<Draw> {
    let mut random =
        fastrand::Rng::with_seed(seed ^ (number << 8 | place as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let instants: Vec<u64> = world.moments.keys().copied().collect();
    let struck = *random.choice(&instants)?;
    let moment = &world.moments[&struck];
    let at_us = if place == Place::Store { RESET_US } else { struck };
    let mut boards: Vec<usize> = (0..world.places.len()).collect();
    random.shuffle(&mut boards);
    boards.into_iter().find_map(|board| {
        let (target, bit) = strike(world, moment, place, board, &mut random)?;
        let upset = Upset { masters: world.masters, place, board, at_us, target, bit };
        Some(Draw { upset, is_unused: is_unused(moment, &upset) })
    })
}

fn strike(
    world: &World,
    moment: &Moment,
    place: Place,
    board: usize,
    random: &mut fastrand::Rng,
) -> Option<(Target, u32)> {
    match place {
        Place::Core | Place::Masks => {
            let all: Vec<_> =
                core_registers(place).into_iter().map(|register| (register, register.bits())).collect();
            let (register, bit) = bit_of(&all, random)?;
            Some((Target::Core(register), bit))
        }
        Place::Peripherals => {
            let bits = |register: &StateRegister| (register.address, register.bits);
            let all: Vec<(u32, u32)> = moment.registers[board].iter().map(bits).collect();
            let (address, bit) = bit_of(&all, random)?;
            Some((Target::Address(address), bit))
        }
        Place::Ram | Place::Flash | Place::Store => {
            let ranges = world.places[board].ranges(place, moment.stacks[board]);
            let address = byte_of(&ranges, random)?;
            Some((Target::Address(address), random.u32(0..BYTE)))
        }
    }
}

/// Returns one of the bits of some registers.
fn bit_of<T: Copy>(registers: &[(T, u32)], random: &mut fastrand::Rng) -> Option<(T, u32)> {
    let count: u32 = registers.iter().map(|(_, bits)| bits.count_ones()).sum();
    let mut left = if count > 0 { random.u32(0..count) } else { return None };
    registers.iter().find_map(|&(register, bits)| {
        let here = bits.count_ones();
        let bit = (0..u32::BITS).filter(|bit| bits >> bit & 1 == 1).nth(left as usize);
        left = left.saturating_sub(here.min(left));
        bit.filter(|_| here > 0).map(|bit| (register, bit))
    })
}

/// Returns one of the bytes of some ranges.
fn byte_of(ranges: &[Range<u32>], random: &mut fastrand::Rng) -> Option<u32> {
    let count: usize = ranges.iter().map(Range::len).sum();
    let number = if count > 0 { random.usize(0..count) } else { return None };
    ranges.iter().cloned().flatten().nth(number)
}

fn is_unused(moment: &Moment, upset: &Upset) -> bool {
    let Target::Address(address) = upset.target else { return false };
    upset.place == Place::Ram && moment.uses[upset.board].at(address) != Use::Read
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_bit_of_registers_is_chosen_and_no_other() {
        let registers = [('a', 0b101), ('b', 0), ('c', 1 << 31)];
        let mut random = fastrand::Rng::with_seed(1);
        let chosen: BTreeSet<(char, u32)> =
            (0..200).filter_map(|_| bit_of(&registers, &mut random)).collect();
        assert_eq!(chosen, BTreeSet::from([('a', 0), ('a', 2), ('c', 31)]));
        assert_eq!(bit_of(&[('a', 0)], &mut random), None);
    }

    #[test]
    fn each_byte_of_ranges_is_chosen_and_no_other() {
        let mut random = fastrand::Rng::with_seed(1);
        let chosen: BTreeSet<u32> =
            (0..200).filter_map(|_| byte_of(&[4..6, 9..9, 20..21], &mut random)).collect();
        assert_eq!(chosen, BTreeSet::from([4, 5, 20]));
        assert_eq!(byte_of(&[3..3, 9..9], &mut random), None);
    }
}
