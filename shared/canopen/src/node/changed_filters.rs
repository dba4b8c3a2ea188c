//! Acceptance filters that changed, on their way to the buses of a node.

use super::turn::{Part, Turn};
use super::{BusCommand, MAX_FILTERS};
use crate::link::depth::Depth;
use crate::link::port::Filter;
use crate::types::{Bus, Duration, Instant};

/// Retry interval for changed filters.
const PAUSE: Duration = Duration::from_millis(1);

/// Filters that changed and that the buses do not have yet, by their numbers, below [`MAX_FILTERS`].
#[derive(Clone, Copy, Debug)]
pub struct ChangedFilters {
    /// A bit for each of them.
    numbers: u32,
    /// Those that found no room wait for a short pause.
    not_before: Instant,
}

impl Default for ChangedFilters {
    fn default() -> Self {
        ChangedFilters { numbers: 0, not_before: Instant::ZERO }
    }
}

impl ChangedFilters {
    /// Notes that a filter changed. The node does not send it if `number` is [`MAX_FILTERS`] or more.
    pub fn note(&mut self, number: usize) {
        if number < MAX_FILTERS {
            (self.numbers, self.not_before) = (self.numbers | 1 << number, Instant::ZERO);
        }
    }

    /// Notes that the first `count` filters may have changed. A controller that has one already is not disturbed.
    pub fn note_all(&mut self, count: usize) {
        (0..count).for_each(|number| self.note(number));
    }

    /// Sends changed filters to `buses` while there is room beside the frames, those with the highest numbers first. `filter`
    /// returns the filter with a number.
    pub fn send<E, D: Depth>(
        &mut self,
        buses: &[Bus],
        filter: impl Fn(usize) -> Filter,
        turn: &mut Turn<'_, E, D>,
    ) {
        while turn.out.has_room()
            && let Some(number) = self.numbers.checked_ilog2()
        {
            self.numbers &= !(1 << number);
            let command = BusCommand::Filter { number: number as u8, filter: filter(number as usize) };
            buses.iter().for_each(|bus| turn.out.command(*bus, command));
        }
        self.not_before = turn.now + PAUSE;
    }
}

impl Part for ChangedFilters {
    fn earliest(&self) -> Option<Instant> {
        (self.numbers != 0).then_some(self.not_before)
    }
}
