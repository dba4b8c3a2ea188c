//! Debug: the cycle counter of the DWT, DHCSR, DEMCR and DFSR (C1.6, C1.8).

/// BKPT in DFSR.
pub const DFSR_BKPT: u32 = 1 << 1;

/// DHCSR: halting debug is on; registers can be transferred; an instruction retired; a reset has been.
const C_DEBUGEN: u32 = 1;
const S_REGRDY: u32 = 1 << 16;
const S_RETIRE_ST: u32 = 1 << 24;
const S_RESET_ST: u32 = 1 << 25;

/// DEMCR: DWT and ITM are on; DebugMonitor is enabled, pending; a flag for programs. Vector catch and stepping are not there.
const TRCENA: u32 = 1 << 24;
pub const MON_EN: u32 = 1 << 16;
pub const MON_PEND: u32 = 1 << 17;
const MON_REQ: u32 = 1 << 19;
pub const DEMCR_BITS: u32 = TRCENA | MON_EN | MON_PEND | MON_REQ;

/// DWT_CTRL: four comparators; the cycle counter runs.
const NUMCOMP: u32 = 4 << 28;
const CYCCNTENA: u32 = 1;

/// Debug state.
#[derive(Clone, Debug, Default)]
pub struct Debug {
    /// A debugger has set C_DEBUGEN.
    pub attached: bool,
    had_reset: bool,
    pub demcr: u32,
    pub dfsr: u32,
    dwt_enabled: bool,
    /// While the counter stands: its value. While it runs: the cycle at which it would have been zero.
    count: u32,
    zero: u64,
}

/// Of the value of the counter and its zero only one counts.
impl PartialEq for Debug {
    fn eq(&self, other: &Debug) -> bool {
        let state = |debug: &Debug| {
            let count = if debug.counts() { (0, debug.zero) } else { (debug.count, 0) };
            (debug.attached, debug.had_reset, debug.demcr, debug.dfsr, debug.dwt_enabled, count)
        };
        state(self) == state(other)
    }
}

impl Debug {
    /// System reset: DEMCR and an attached debugger stay.
    pub fn reset(&mut self) {
        *self = Debug { attached: self.attached, had_reset: true, demcr: self.demcr, ..Debug::default() };
    }

    /// Reads DHCSR, and clears S_RESET_ST with it. A program that reads it is neither halted nor asleep.
    pub fn dhcsr(&mut self) -> u32 {
        let attached = if self.attached { C_DEBUGEN } else { 0 };
        let reset = if std::mem::take(&mut self.had_reset) { S_RESET_ST } else { 0 };
        attached | S_REGRDY | S_RETIRE_ST | reset
    }

    fn counts(&self) -> bool {
        self.dwt_enabled && self.demcr & TRCENA != 0
    }

    pub fn set_demcr(&mut self, value: u32, cycle: u64) {
        let count = self.cycle_count(cycle);
        self.demcr = value & DEMCR_BITS;
        self.set_cycle_count(count, cycle);
    }

    pub fn dwt_control(&self) -> u32 {
        NUMCOMP | if self.dwt_enabled { CYCCNTENA } else { 0 }
    }

    /// Writes DWT_CTRL. `false`: it asks for more than the cycle counter.
    pub fn set_dwt_control(&mut self, value: u32, cycle: u64) -> bool {
        let count = self.cycle_count(cycle);
        self.dwt_enabled = value & CYCCNTENA != 0;
        self.set_cycle_count(count, cycle);
        value & !(NUMCOMP | CYCCNTENA) == 0
    }

    /// DWT_CYCCNT.
    pub fn cycle_count(&self, cycle: u64) -> u32 {
        if self.counts() { cycle.wrapping_sub(self.zero) as u32 } else { self.count }
    }

    pub fn set_cycle_count(&mut self, count: u32, cycle: u64) {
        self.count = count;
        self.zero = cycle.wrapping_sub(u64::from(count));
    }

    /// Stops the counter for `cycles` that have passed while the core slept or was halted.
    pub fn skip(&mut self, cycles: u64) {
        self.zero = self.zero.wrapping_add(cycles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycle_counter_needs_trcena_and_cyccntena() {
        let mut debug = Debug::default();
        assert!(debug.set_dwt_control(NUMCOMP | CYCCNTENA, 100));
        assert_eq!(debug.cycle_count(200), 0);
        debug.set_demcr(TRCENA, 200);
        assert_eq!(debug.cycle_count(250), 50);
        debug.set_cycle_count(7, 300);
        debug.skip(10);
        assert_eq!(debug.cycle_count(320), 17);
        debug.set_demcr(0, 320);
        assert_eq!(debug.cycle_count(999), 17);
    }
}
