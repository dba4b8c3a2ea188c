//! Queue, first in, first out, that checks its indices: a flipped bit loses elements, and neither reaches other memory nor
//! makes a loop longer.

use super::depth::Depth;

/// Queue with the number of places of `D`.
///
/// `heapless::Deque` does not check its indices. A flipped bit in one of them is an access out of bounds there.
pub(crate) struct Ring<T, D: Depth> {
    places: D::Ring<T>,
    /// Place of the oldest element.
    first: usize,
    len: usize,
}

impl<T, D: Depth> Ring<T, D> {
    pub fn new() -> Self {
        Ring { places: D::ring(), first: 0, len: 0 }
    }

    /// Puts an element behind the others. Returns `false` if all places are taken.
    pub fn push(&mut self, element: T) -> bool {
        if self.len >= D::PLACES {
            return false;
        }
        if self.first >= D::PLACES {
            self.first = 0;
        }
        if let Some(place) = self.places.as_mut().get_mut(wrapped::<D>(self.first + self.len)) {
            *place = Some(element);
            self.len += 1;
        }
        true
    }

    /// Takes the oldest element.
    pub fn pop(&mut self) -> Option<T> {
        self.len = self.len.min(D::PLACES);
        while self.len > 0 {
            let place = self.places.as_mut().get_mut(self.first);
            self.len -= 1;
            self.first = if self.first < D::PLACES { wrapped::<D>(self.first + 1) } else { 0 };
            // A place without an element is one that a flipped bit points to.
            if let Some(element) = place.and_then(Option::take) {
                return Some(element);
            }
        }
        None
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

/// Returns the place with this number, modulo the number of places.
fn wrapped<D: Depth>(number: usize) -> usize {
    if number < D::PLACES { number } else { number - D::PLACES }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::collections::VecDeque;
    use std::vec::Vec;

    use super::*;
    use crate::link::depth::Places;

    type Small = Ring<u8, Places<8>>;

    fn filled(number: u8) -> Small {
        let mut ring = Small::new();
        // Begins in the middle, so that it wraps.
        for element in 0..5 {
            assert!(ring.push(element) && ring.pop() == Some(element));
        }
        (0..number).for_each(|element| assert!(ring.push(element)));
        ring
    }

    fn taken(ring: &mut Small) -> Vec<u8> {
        core::iter::from_fn(|| ring.pop()).collect()
    }

    #[test]
    fn ring_gives_the_elements_of_a_queue_of_the_library() {
        let (mut ring, mut model) = (Small::new(), VecDeque::new());
        for step in 0..200_u32 {
            // Three of five steps push, so that it is full at times; the last hundred pop more.
            if step % 5 < 3 - step / 100 * 2 {
                assert_eq!(ring.push(step as u8), model.len() < 8);
                if model.len() < 8 {
                    model.push_back(step as u8);
                }
            } else {
                assert_eq!(ring.pop(), model.pop_front());
            }
            assert_eq!((ring.len(), ring.is_empty()), (model.len(), model.is_empty()));
        }
    }

    /// Given a queue with elements, when any bit of its indices flips, then it gives none twice, is empty after at most eight,
    /// and takes and gives new elements in order.
    #[test]
    fn a_flipped_bit_of_an_index_loses_elements_alone() {
        for bit in 0..2 * usize::BITS {
            for number in 0..8 {
                let mut ring = filled(number);
                let index = if bit < usize::BITS { &mut ring.first } else { &mut ring.len };
                *index ^= 1 << (bit % usize::BITS);
                // May be refused once.
                ring.push(100);
                let given = taken(&mut ring);
                assert!(
                    given.len() <= 8 && given.is_sorted_by(|one, next| one != next),
                    "bit {bit}: {given:?}"
                );
                assert!(ring.is_empty(), "bit {bit}");
                (0..8).for_each(|element| assert!(ring.push(element), "bit {bit}"));
                assert!(!ring.push(8), "bit {bit}");
                assert_eq!(taken(&mut ring), [0, 1, 2, 3, 4, 5, 6, 7], "bit {bit}");
            }
        }
    }
}
