//! The time base of a timer: prescaler, counter, auto-reload, upwards.
//!
//! RM0090 18.3.1 and 18.3.2. The count is computed from the cycle when it is read; nothing is stepped. A count beyond the reload
//! value, by a store or a lower reload value, continues to the largest count and then to zero, which counts as an overflow.

/// Prescaler and reload with their buffers, and the counter's anchor.
#[derive(Clone, Debug)]
pub(super) struct Counter {
    /// PSC and ARR as written.
    pub(super) psc: u32,
    pub(super) arr: u32,
    /// Prescaler and reload in effect.
    active_psc: u32,
    active_arr: u32,
    pub(super) running: bool,
    /// HCLK cycles per timer clock.
    pub(super) divider: u64,
    /// The counter became `anchor_count` at this HCLK cycle.
    anchor_cycle: u64,
    anchor_count: u32,
    /// The largest count, of 16 or 32 bits.
    largest: u32,
}

impl Counter {
    /// Stopped; `largest` is the largest count, of 16 or 32 bits.
    pub(super) fn new(divider: u64, largest: u32) -> Self {
        Counter {
            psc: 0,
            arr: largest,
            active_psc: 0,
            active_arr: largest,
            running: false,
            divider,
            anchor_cycle: 0,
            anchor_count: 0,
            largest,
        }
    }

    /// HCLK cycles per count.
    fn count_cycles(&self) -> u64 {
        self.divider * (u64::from(self.active_psc) + 1)
    }

    fn period(&self) -> u64 {
        u64::from(self.active_arr) + 1
    }

    /// Counts since the anchor, at `cycle`.
    fn counts(&self, cycle: u64) -> u64 {
        if self.running { cycle.saturating_sub(self.anchor_cycle) / self.count_cycles() } else { 0 }
    }

    /// Returns the count at `cycle`. For a cycle before the anchor the present rate is assumed.
    pub(super) fn count(&self, cycle: u64) -> u32 {
        let period = self.period();
        let anchor = u64::from(self.anchor_count);
        let back = match self.anchor_cycle.checked_sub(cycle) {
            Some(early) if self.running => early.div_ceil(self.count_cycles()) % period,
            _ => 0,
        };
        let counts = self.counts(cycle);
        if self.exceeds(self.anchor_count) {
            let to_zero = self.to_zero();
            return match counts.checked_sub(to_zero) {
                Some(counts) => (counts % period) as u32,
                None => (anchor + counts - back) as u32,
            };
        }
        ((anchor + period - back + counts) % period) as u32
    }

    /// Counts from the anchor to zero, for an anchor beyond the reload value.
    fn to_zero(&self) -> u64 {
        u64::from(self.largest) + 1 - u64::from(self.anchor_count)
    }

    /// Returns the count at `cycle` with its fraction.
    pub(super) fn exact(&self, cycle: u64) -> f64 {
        let pace = self.count_cycles();
        let since = i128::from(cycle) - i128::from(self.anchor_cycle);
        let part = if self.running { since.rem_euclid(i128::from(pace)) as f64 / pace as f64 } else { 0.0 };
        f64::from(self.count(cycle)) + part
    }

    /// The cycle after `cycle` at which the counter next becomes `value`; a value beyond the reload value counts as the
    /// overflow (RM0090 18.4.5).
    pub(super) fn reaches(&self, value: u32, cycle: u64) -> Option<u64> {
        if !self.running {
            return None;
        }
        let counts = self.counts(cycle);
        let to_zero = if self.exceeds(self.anchor_count) { self.to_zero() } else { 0 };
        if counts < to_zero {
            let count = self.count(cycle);
            let ahead = match value {
                value if value > count => u64::from(value - count),
                value if self.exceeds(value) => to_zero - counts,
                value => to_zero - counts + u64::from(value),
            };
            return Some(self.anchor_cycle + (counts + ahead) * self.count_cycles());
        }
        let value = if self.exceeds(value) { 0 } else { u64::from(value) };
        let from = if to_zero == 0 { u64::from(self.anchor_count) } else { 0 };
        let count = (from + counts - to_zero) % self.period();
        let ahead = match (value + self.period() - count) % self.period() {
            0 => self.period(),
            ahead => ahead,
        };
        Some(self.anchor_cycle + (counts + ahead) * self.count_cycles())
    }

    /// Returns whether `value` lies beyond the reload value in effect.
    pub(super) fn exceeds(&self, value: u32) -> bool {
        value > self.active_arr
    }

    /// Returns whether a buffered value waits for the update event.
    pub(super) fn is_stale(&self) -> bool {
        (self.active_psc, self.active_arr) != (self.psc, self.arr)
    }

    /// Executes the update event at `cycle`: the count returns to zero, buffered values take effect.
    pub(super) fn update(&mut self, cycle: u64) {
        self.anchor_cycle = cycle;
        self.anchor_count = 0;
        self.active_psc = self.psc;
        self.active_arr = self.arr;
    }

    /// Moves the anchor to the last count at or before `cycle`, before the rate changes.
    fn anchor(&mut self, cycle: u64) {
        let counts = self.counts(cycle);
        self.anchor_count = self.count(cycle);
        self.anchor_cycle =
            if self.running { self.anchor_cycle + counts * self.count_cycles() } else { cycle };
    }

    pub(super) fn run(&mut self, cycle: u64, running: bool) {
        self.anchor(cycle);
        self.running = running;
    }

    pub(super) fn set_count(&mut self, cycle: u64, count: u32) {
        self.anchor(cycle);
        self.anchor_count = count;
    }

    pub(super) fn set_reload(&mut self, cycle: u64, arr: u32, buffered: bool) {
        self.arr = arr;
        if !buffered {
            self.anchor(cycle);
            self.active_arr = arr;
        }
    }

    pub(super) fn set_divider(&mut self, cycle: u64, divider: u64) {
        self.anchor(cycle);
        self.divider = divider;
    }
}
