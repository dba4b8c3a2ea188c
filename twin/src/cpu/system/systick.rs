//! SysTick (B3.3): computed from the cycle on demand, not counted.

const ENABLE: u32 = 1;
const TICKINT: u32 = 1 << 1;
/// Counts core cycles, not the reference clock.
const CLKSOURCE: u32 = 1 << 2;
const COUNTFLAG: u32 = 1 << 16;
const COUNTER: u32 = 0x00FF_FFFF;

/// The timer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SysTick {
    control: u32,
    reload: u32,
    /// Count at the cycle `at`.
    count: u32,
    at: u64,
    /// Core cycles per cycle of the reference clock.
    reference: u32,
    /// The cycle at which the count next becomes zero and pends the exception; `u64::MAX` for never.
    pub deadline: u64,
}

impl SysTick {
    /// A timer after a reset; `reference` is the number of core cycles per cycle of the reference clock.
    pub fn new(reference: u32) -> Self {
        SysTick { control: 0, reload: 0, count: 0, at: 0, reference: reference.max(1), deadline: u64::MAX }
    }

    /// Returns whether the exception is due at `cycle`, once for each time.
    pub fn expires(&mut self, cycle: u64) -> bool {
        if cycle < self.deadline {
            return false;
        }
        self.sync(cycle);
        self.plan();
        true
    }

    /// Stops the timer for `cycles` that have passed up to now.
    pub fn skip(&mut self, cycles: u64) {
        self.at += cycles;
        self.plan();
    }

    fn divisor(&self) -> u64 {
        if self.control & CLKSOURCE != 0 { 1 } else { u64::from(self.reference) }
    }

    /// Counts up to `cycle`.
    fn sync(&mut self, cycle: u64) {
        let ticks = cycle / self.divisor() - self.at / self.divisor();
        self.at = cycle;
        if self.control & ENABLE == 0 || ticks == 0 {
            return;
        }
        let count = u64::from(self.count);
        if ticks < count {
            self.count -= ticks as u32;
            return;
        }
        // After zero the count continues from the reload value down.
        let past_zero = ticks - count;
        let period = u64::from(self.reload) + 1;
        if count > 0 || (self.reload > 0 && past_zero >= period) {
            self.control |= COUNTFLAG;
        }
        self.count = ((period - past_zero % period) % period) as u32;
    }

    fn plan(&mut self) {
        let raises = self.control & (ENABLE | TICKINT) == ENABLE | TICKINT;
        let ticks = match (self.count, self.reload) {
            (0, 0) => None,
            (0, reload) => Some(u64::from(reload) + 1),
            (count, _) => Some(u64::from(count)),
        };
        let divisor = self.divisor();
        self.deadline =
            ticks.filter(|_| raises).map_or(u64::MAX, |ticks| (self.at / divisor + ticks) * divisor);
    }

    /// Reads SYST_CSR, SYST_RVR or SYST_CVR (offsets 0, 4, 8). Reading SYST_CSR clears COUNTFLAG.
    pub fn read(&mut self, offset: u32, cycle: u64) -> u32 {
        self.sync(cycle);
        match offset {
            0 => {
                let control = self.control;
                self.control &= !COUNTFLAG;
                control
            }
            4 => self.reload,
            _ => self.count,
        }
    }

    /// Writes SYST_CSR, SYST_RVR or SYST_CVR. Any write to SYST_CVR clears it and COUNTFLAG.
    pub fn write(&mut self, offset: u32, value: u32, cycle: u64) {
        self.sync(cycle);
        match offset {
            0 => self.control = self.control & COUNTFLAG | value & (ENABLE | TICKINT | CLKSOURCE),
            4 => self.reload = value & COUNTER,
            _ => {
                self.count = 0;
                self.control &= !COUNTFLAG;
            }
        }
        self.plan();
    }

    /// Inverts a bit of SYST_CSR, SYST_RVR or SYST_CVR.
    pub fn flip(&mut self, offset: u32, bit: u32, cycle: u64) {
        self.sync(cycle);
        match offset {
            0 => self.control ^= 1 << bit,
            4 => self.reload ^= 1 << bit,
            _ => self.count ^= 1 << bit,
        }
        self.plan();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Enabled with its exception from cycle 0 on.
    fn running(control: u32, reload: u32) -> SysTick {
        let mut systick = SysTick::new(8);
        systick.write(4, reload, 0);
        systick.write(8, 0, 0);
        systick.write(0, control, 0);
        systick
    }

    #[test]
    fn counts_down_from_reload_and_sets_countflag_at_zero() {
        let mut systick = running(ENABLE | TICKINT | CLKSOURCE, 9);
        assert_eq!(systick.deadline, 10);
        assert_eq!(systick.read(8, 1), 9);
        assert_eq!(systick.read(8, 9), 1);
        assert!(!systick.expires(9));
        assert!(systick.expires(10));
        assert!(!systick.expires(10));
        assert_eq!(systick.deadline, 20);
        assert_eq!(systick.read(0, 11), ENABLE | TICKINT | CLKSOURCE | COUNTFLAG);
        assert_eq!(systick.read(0, 12), ENABLE | TICKINT | CLKSOURCE);
        assert_eq!(systick.read(8, 13), 7);
    }

    #[test]
    fn reference_clock_is_an_eighth() {
        let mut systick = running(ENABLE | TICKINT, 9);
        assert_eq!(systick.deadline, 80);
        assert_eq!(systick.read(8, 7), 0);
        assert_eq!(systick.read(8, 8), 9);
        assert!(systick.expires(83));
        assert_eq!(systick.deadline, 160);
    }

    #[test]
    fn reload_of_zero_stops_at_zero() {
        let mut systick = running(ENABLE | CLKSOURCE, 9);
        systick.write(4, 0, 5);
        assert_eq!(systick.read(8, 100), 0);
        assert_eq!(systick.read(0, 100) & COUNTFLAG, COUNTFLAG);
        assert_eq!(systick.deadline, u64::MAX);
    }

    #[test]
    fn halted_core_lets_the_timer_stand() {
        let mut systick = running(ENABLE | TICKINT | CLKSOURCE, 9);
        systick.skip(100);
        assert_eq!(systick.deadline, 110);
    }
}
