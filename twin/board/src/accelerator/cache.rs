//! Lines of a cache with the least recently used one replaced.

use std::ops::Range;

use super::LINE;

/// `N` lines, any of them for any line of flash.
#[derive(Clone, Debug)]
pub struct Cache<const N: usize> {
    places: [Place; N],
    /// Place + 1 of each line of flash, 0 for none.
    place_of: Vec<u8>,
    /// The places in the order of their last use: the most recent one and the least recent one.
    newest: u8,
    oldest: u8,
}

#[derive(Clone, Copy, Debug, Default)]
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
    /// Empty, for a flash of so many lines.
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

    pub fn flash_lines(&self) -> u32 {
        self.place_of.len() as u32
    }

    fn place(&self, line: u32) -> Option<usize> {
        usize::from(*self.place_of.get(line as usize)?).checked_sub(1)
    }

    /// Whether the line is there. Uses nothing.
    pub fn holds(&self, line: u32) -> bool {
        self.place(line).is_some()
    }

    /// Uses the line, if it is there.
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

    /// Takes a line in that is not there, in place of the least recently used one.
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

    /// Forgets everything.
    pub fn clear(&mut self) {
        for place in &mut self.places {
            if let Some(line) = place.line.take() {
                self.place_of[line as usize] = 0;
            }
            place.old = None;
        }
    }

    /// Flash changes at `range`, where it held `old`: lines of it go on showing that.
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

    /// Whether a line shows what flash no longer holds.
    pub fn is_stale(&self) -> bool {
        self.places.iter().any(|place| place.old.is_some())
    }

    /// What a line shows that flash no longer holds.
    pub fn stale(&self, line: u32) -> Option<[u8; LINE as usize]> {
        self.places[self.place(line)?].old
    }
}

/// Where in `range`, which is made of whole lines, a line lies.
fn within(range: &Range<u32>, line: u32) -> Option<Range<usize>> {
    let start = (line * LINE).checked_sub(range.start)? as usize;
    (line * LINE < range.end).then_some(start..start + LINE as usize)
}
