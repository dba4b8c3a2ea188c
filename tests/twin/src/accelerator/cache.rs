//! Lines of a cache with the least recently used one replaced.

use std::ops::Range;

use super::LINE;

/// `N` lines, any of them for any line of flash.
#[derive(Clone, Debug)]
pub struct Cache<const N: usize> {
    /// Line of flash in each place, when it was last used, and what it shows if flash no longer holds that.
    places: [Place; N],
    /// Place + 1 of each line of flash, 0 for none.
    place_of: Vec<u8>,
    uses: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Place {
    line: Option<u32>,
    used: u64,
    old: Option<[u8; LINE as usize]>,
}

impl<const N: usize> Cache<N> {
    /// Empty, for a flash of so many lines.
    pub fn new(flash_lines: u32) -> Self {
        Cache { places: [Place::default(); N], place_of: vec![0; flash_lines as usize], uses: 0 }
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
            self.uses += 1;
            self.places[place].used = self.uses;
        }
        place.is_some()
    }

    /// Takes a line in that is not there.
    pub fn insert(&mut self, line: u32) {
        let oldest = self.places.iter().enumerate().min_by_key(|(_, place)| place.used);
        let place = oldest.map_or(0, |(place, _)| place);
        if let Some(replaced) = self.places[place].line {
            self.place_of[replaced as usize] = 0;
        }
        self.uses += 1;
        self.places[place] = Place { line: Some(line), used: self.uses, old: None };
        self.place_of[line as usize] = place as u8 + 1;
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        for place in &mut self.places {
            if let Some(line) = std::mem::take(place).line {
                self.place_of[line as usize] = 0;
            }
        }
    }

    /// Flash changes at `range`, where it held `old`: lines of it go on showing that.
    pub fn keep(&mut self, range: &Range<u32>, old: &[u8]) {
        for place in &mut self.places {
            let Some(at) = place.line.and_then(|line| within(range, line)) else { continue };
            place.old = place.old.or_else(|| old[at].try_into().ok());
        }
    }

    /// Flash changes from `old` to `new` at `range`: a line that shows something else takes the bytes that change.
    pub fn write_through(&mut self, range: &Range<u32>, old: &[u8], new: &[u8]) {
        for place in &mut self.places {
            let (Some(line), Some(shown)) = (place.line, &mut place.old) else { continue };
            if let Some(at) = within(range, line) {
                let bytes = old[at.clone()].iter().zip(&new[at]);
                shown
                    .iter_mut()
                    .zip(bytes)
                    .filter(|(_, (old, new))| old != new)
                    .for_each(|(byte, (_, new))| *byte = *new);
            }
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
