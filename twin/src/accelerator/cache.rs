//! Lines of a cache with the least recently used one replaced.

use std::ops::Range;

use super::LINE;

/// Fully associative cache with `N` lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Cache<const N: usize> {
    places: [Place; N],
    /// For each line of flash: its place in the cache plus 1, or 0 if it is not cached.
    place_of: Vec<u8>,
    /// The places in the order of their last use: the most recent one and the least recent one.
    newest: u8,
    oldest: u8,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Place {
    /// Line of flash in this place.
    line: Option<u32>,
    /// Content of the line, if flash no longer holds it.
    old: Option<[u8; LINE as usize]>,
    /// Neighbours in the order of the last use. The next one was used earlier.
    previous: u8,
    next: u8,
}

impl<const N: usize> Cache<N> {
    /// Makes an empty cache for a flash of `flash_lines` lines.
    pub fn new(flash_lines: u32) -> Self {
        let place = |n: usize| Place {
            previous: n.saturating_sub(1) as u8,
            next: (n + 1).min(N - 1) as u8,
            ..Place::default()
        };
        Cache {
            places: std::array::from_fn(place),
            place_of: vec![0; flash_lines as usize],
            newest: 0,
            oldest: (N - 1) as u8,
        }
    }

    /// Returns whether another cache holds the same lines with the same order of uses, in whatever places.
    pub fn continues_as(&self, other: &Cache<N>) -> bool {
        self.in_order().eq(other.in_order())
    }

    /// Returns lines and their outdated content, the most recently used one first.
    fn in_order(&self) -> impl Iterator<Item = (Option<u32>, Option<[u8; LINE as usize]>)> + '_ {
        let mut at = self.newest;
        (0..N).map(move |_| {
            let Place { line, old, next, .. } = self.places[usize::from(at)];
            at = next;
            (line, old)
        })
    }

    pub fn flash_lines(&self) -> u32 {
        self.place_of.len() as u32
    }

    fn place(&self, line: u32) -> Option<usize> {
        usize::from(*self.place_of.get(line as usize)?).checked_sub(1)
    }

    /// Returns whether the line is cached, without marking it as used.
    pub fn holds(&self, line: u32) -> bool {
        self.place(line).is_some()
    }

    /// Marks the line as used if it is cached. Returns whether it is.
    pub fn find(&mut self, line: u32) -> bool {
        let place = self.place(line);
        if let Some(place) = place {
            self.note_use(place as u8);
        }
        place.is_some()
    }

    /// Makes a place the newest one.
    fn note_use(&mut self, place: u8) {
        if place == self.newest {
            return;
        }
        let Place { previous, next, .. } = self.places[usize::from(place)];
        self.places[usize::from(previous)].next = next;
        if place == self.oldest {
            self.oldest = previous;
        } else {
            self.places[usize::from(next)].previous = previous;
        }
        self.places[usize::from(self.newest)].previous = place;
        self.places[usize::from(place)].next = self.newest;
        self.newest = place;
    }

    /// Inserts a line that is not cached, in place of the least recently used one.
    pub fn insert(&mut self, line: u32) {
        let place = self.oldest;
        self.note_use(place);
        let slot = &mut self.places[usize::from(place)];
        if let Some(replaced) = slot.line {
            self.place_of[replaced as usize] = 0;
        }
        (slot.line, slot.old) = (Some(line), None);
        self.place_of[line as usize] = place + 1;
    }

    /// Empties the cache.
    pub fn clear(&mut self) {
        for place in &mut self.places {
            if let Some(line) = place.line.take() {
                self.place_of[line as usize] = 0;
            }
            place.old = None;
        }
    }

    /// Handles a change of flash at `range`, where it held `old`: cached lines keep that content.
    pub fn keep(&mut self, range: &Range<u32>, old: &[u8]) {
        for place in &mut self.places {
            let Some(at) = place.line.and_then(|line| within(range, line)) else { continue };
            place.old = place.old.or_else(|| old[at].try_into().ok());
        }
    }

    /// The core has stored `bytes` at `offset`, and flash changes from `old` to `new` at `range`: a line shows the bytes that were
    /// stored, whatever flash made of them.
    pub fn write_through(
        &mut self,
        range: &Range<u32>,
        old: &[u8],
        new: &[u8],
        (offset, bytes): (u32, &[u8]),
    ) {
        for place in &mut self.places {
            let Some(line) = place.line else { continue };
            let Some(at) = within(range, line) else { continue };
            let mut shown = place.old.unwrap_or_else(|| std::array::from_fn(|k| old[at.start + k]));
            for (k, byte) in (line * LINE..).zip(&mut shown) {
                let stored = k.checked_sub(offset).and_then(|k| bytes.get(k as usize));
                *byte = stored.copied().unwrap_or(*byte);
            }
            place.old = (shown != new[at]).then_some(shown);
        }
    }

    /// Returns whether a line differs from flash.
    pub fn is_stale(&self) -> bool {
        self.places.iter().any(|place| place.old.is_some())
    }

    /// Returns the content of a line that differs from flash.
    pub fn stale(&self, line: u32) -> Option<[u8; LINE as usize]> {
        self.places[self.place(line)?].old
    }
}

/// Returns the part of `range`, which consists of whole lines, that is this line.
fn within(range: &Range<u32>, line: u32) -> Option<Range<usize>> {
    let start = (line * LINE).checked_sub(range.start)? as usize;
    (line * LINE < range.end).then_some(start..start + LINE as usize)
}
