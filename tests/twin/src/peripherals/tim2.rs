//! TIM2: the time base of the firmware, counting up, with four compare channels in output mode.
//!
//! RM0090 chapter 18. Modelled: prescaler and auto-reload with their buffers, URS, UDIS, UG, update and compare flags,
//! interrupts. Not modelled, and refused: counting down or centre-aligned, slave modes, DMA requests, capture. Nothing
//! is stepped: flags and counter follow from the cycle count when somebody looks.

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCMR2: u32 = 0x1C;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const CCR1: u32 = 0x34;
const CCR4: u32 = 0x40;

const CEN: u32 = 1 << 0;
const UDIS: u32 = 1 << 1;
const URS: u32 = 1 << 2;
const ARPE: u32 = 1 << 7;
const UIF: u32 = 1 << 0;
/// UIF and CC1IF..CC4IF.
const FLAGS: u32 = 0x1F;

/// The registers and the counter's anchor.
#[derive(Debug)]
pub struct Tim2 {
    cr1: u32,
    dier: u32,
    sr: u32,
    ccmr: [u32; 2],
    ccer: u32,
    psc: u32,
    arr: u32,
    ccr: [u32; 4],
    /// Prescaler and auto-reload in effect.
    active_psc: u32,
    active_arr: u32,
    /// HCLK cycles per timer clock.
    divider: u64,
    /// The counter became `anchor_count` at this HCLK cycle; flags are up to date until `seen`.
    anchor_cycle: u64,
    anchor_count: u32,
    seen: u64,
}

impl Default for Tim2 {
    fn default() -> Self {
        Tim2 {
            cr1: 0,
            dier: 0,
            sr: 0,
            ccmr: [0; 2],
            ccer: 0,
            psc: 0,
            arr: u32::MAX,
            ccr: [0; 4],
            active_psc: 0,
            active_arr: u32::MAX,
            divider: 1,
            anchor_cycle: 0,
            anchor_count: 0,
            seen: 0,
        }
    }
}

impl Tim2 {
    /// RCC or a system reset; the timer's clock stays what it is.
    pub fn reset(&mut self) {
        *self = Tim2 { divider: self.divider, ..Tim2::default() };
    }

    fn runs(&self) -> bool {
        self.cr1 & CEN != 0
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
        if self.runs() { (cycle - self.anchor_cycle) / self.count_cycles() } else { 0 }
    }

    fn count(&self, cycle: u64) -> u32 {
        ((u64::from(self.anchor_count) + self.counts(cycle)) % self.period()) as u32
    }

    /// The cycle after `cycle` at which the counter next becomes `value`.
    fn reaches(&self, value: u32, cycle: u64) -> Option<u64> {
        if !self.runs() || value > self.active_arr {
            return None;
        }
        let counts = self.counts(cycle);
        let count = (u64::from(self.anchor_count) + counts) % self.period();
        let ahead = match (u64::from(value) + self.period() - count) % self.period() {
            0 => self.period(),
            ahead => ahead,
        };
        Some(self.anchor_cycle + (counts + ahead) * self.count_cycles())
    }

    /// Flag bit and counter value of the five events. The update event is the return to zero.
    fn events(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let [c1, c2, c3, c4] = self.ccr;
        [(0, 0), (1, c1), (2, c2), (3, c3), (4, c4)].into_iter()
    }

    /// Sets the flags of what happened until `cycle`.
    fn catch_up(&mut self, cycle: u64) {
        if cycle <= self.seen {
            return;
        }
        for (bit, value) in self.events() {
            let update_disabled = bit == 0 && self.cr1 & UDIS != 0;
            if self.sr >> bit & 1 == 0
                && !update_disabled
                && self.reaches(value, self.seen).is_some_and(|at| at <= cycle)
            {
                self.sr |= 1 << bit;
            }
        }
        // A buffered prescaler or reload takes effect at the update event.
        while (self.active_psc, self.active_arr) != (self.psc, self.arr) && self.cr1 & UDIS == 0 {
            match self.reaches(0, self.seen) {
                Some(update) if update <= cycle => {
                    self.anchor_cycle = update;
                    self.anchor_count = 0;
                    self.load_buffers();
                    self.seen = update;
                }
                _ => break,
            }
        }
        self.seen = cycle;
    }

    fn load_buffers(&mut self) {
        self.active_psc = self.psc;
        self.active_arr = self.arr;
    }

    /// Moves the anchor to the last count at or before `cycle`, before the pace changes.
    fn anchor(&mut self, cycle: u64) {
        self.catch_up(cycle);
        self.anchor_count = self.count(cycle);
        self.anchor_cycle =
            if self.runs() { self.anchor_cycle + self.counts(cycle) * self.count_cycles() } else { cycle };
    }

    /// The clock tree changed: `divider` HCLK cycles per timer clock from `cycle` on.
    pub fn set_divider(&mut self, cycle: u64, divider: u64) {
        if divider != self.divider {
            self.anchor(cycle);
            self.divider = divider;
        }
    }

    /// The interrupt line at `cycle`.
    pub fn irq(&mut self, cycle: u64) -> bool {
        self.catch_up(cycle);
        self.sr & self.dier & FLAGS != 0
    }

    /// The cycle of the next interrupt, if the line is low now.
    pub fn next_event(&self, cycle: u64) -> Option<u64> {
        self.events()
            .filter(|&(bit, _)| (self.dier & !self.sr) >> bit & 1 == 1)
            .filter_map(|(_, value)| self.reaches(value, cycle))
            .min()
    }

    /// A load; `None` for what is not modelled.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Option<u32> {
        self.catch_up(cycle);
        Some(match offset {
            CR1 => self.cr1,
            CR2 | SMCR => 0,
            DIER => self.dier,
            SR => self.sr,
            EGR => 0,
            CCMR1 => self.ccmr[0],
            CCMR2 => self.ccmr[1],
            CCER => self.ccer,
            CNT => self.count(cycle),
            PSC => self.psc,
            ARR => self.arr,
            CCR1..=CCR4 => self.ccr[(offset - CCR1) as usize / 4],
            _ => return None,
        })
    }

    /// A store; `None` for what is not modelled.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) -> Option<()> {
        self.catch_up(cycle);
        match offset {
            // DIR, CMS and OPM change how it counts.
            CR1 if value & 0x78 != 0 => return None,
            CR1 => {
                self.anchor(cycle);
                self.cr1 = value;
            }
            CR2 | SMCR => return (value == 0).then_some(()),
            // TDE, COMDE, CCxDE, UDE are DMA requests, TIE comes from slave modes.
            DIER if value & !FLAGS != 0 => return None,
            DIER => self.dier = value,
            // Flags clear by writing 0; writing 1 keeps them.
            SR => self.sr &= value,
            EGR => self.generate(cycle, value),
            // CCxS other than zero is capture.
            CCMR1 | CCMR2 if value & 0x0303 != 0 => return None,
            CCMR1 => self.ccmr[0] = value,
            CCMR2 => self.ccmr[1] = value,
            CCER => self.ccer = value,
            CNT => {
                self.anchor(cycle);
                self.anchor_count = value;
            }
            PSC => self.psc = value & 0xFFFF,
            ARR => {
                self.arr = value;
                if self.cr1 & ARPE == 0 {
                    self.anchor(cycle);
                    self.active_arr = value;
                }
            }
            CCR1..=CCR4 => self.ccr[(offset - CCR1) as usize / 4] = value,
            _ => return None,
        }
        Some(())
    }

    fn generate(&mut self, cycle: u64, value: u32) {
        if value & UIF != 0 && self.cr1 & UDIS == 0 {
            self.anchor_cycle = cycle;
            self.anchor_count = 0;
            self.load_buffers();
            if self.cr1 & URS == 0 {
                self.sr |= UIF;
            }
        }
        self.sr |= value & FLAGS & !UIF;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 84 timer clocks per count at two HCLK cycles each: 168 cycles per count, as on the board at 1 MHz.
    fn at_1_mhz() -> Tim2 {
        let mut tim = Tim2::default();
        tim.set_divider(0, 2);
        tim.write(0, PSC, 83).unwrap();
        tim.write(0, ARR, 0xFFFF).unwrap();
        tim.write(0, CR1, URS).unwrap();
        tim.write(0, EGR, UIF).unwrap();
        tim.write(0, CR1, CEN).unwrap();
        tim
    }

    #[test]
    fn counts_microseconds_and_wraps_at_the_reload_value() {
        let mut tim = at_1_mhz();
        assert_eq!(tim.read(168 * 1000 + 167, CNT), Some(1000));
        assert_eq!(tim.read(168 * 65_536, CNT), Some(0));
        assert_eq!(tim.read(168 * 65_537, CNT), Some(1));
    }

    #[test]
    fn a_compare_match_raises_its_interrupt_at_the_exact_cycle() {
        let mut tim = at_1_mhz();
        tim.write(0, CCR1 + 4, 500).unwrap();
        tim.write(0, DIER, 1 << 2).unwrap();
        assert_eq!(tim.next_event(0), Some(168 * 500));
        assert!(!tim.irq(168 * 500 - 1));
        assert!(tim.irq(168 * 500));
    }

    #[test]
    fn status_flags_clear_by_writing_zero() {
        let mut tim = at_1_mhz();
        tim.write(0, CCR1, 10).unwrap();
        tim.write(0, CCR1 + 4, 20).unwrap();
        assert_eq!(tim.read(168 * 30, SR).unwrap() & 0b110, 0b110);
        tim.write(168 * 30, SR, !0b010).unwrap();
        assert_eq!(tim.read(168 * 31, SR).unwrap() & 0b110, 0b100);
    }

    #[test]
    fn the_update_flag_rises_at_the_wrap_and_again_one_period_later() {
        let mut tim = at_1_mhz();
        tim.write(0, DIER, UIF).unwrap();
        assert_eq!(tim.next_event(0), Some(168 * 65_536));
        assert!(tim.irq(168 * 65_536));
        tim.write(168 * 65_536, SR, !UIF).unwrap();
        assert!(!tim.irq(168 * 65_536));
        assert_eq!(tim.next_event(168 * 65_536), Some(168 * 131_072));
    }

    #[test]
    fn a_new_prescaler_waits_for_the_update_event() {
        let mut tim = at_1_mhz();
        tim.write(0, PSC, 167).unwrap();
        assert_eq!(tim.read(168 * 65_535, CNT), Some(65_535));
        assert_eq!(tim.read(168 * 65_536 + 336 * 7, CNT), Some(7));
    }

    #[test]
    fn a_reset_leaves_the_clock_alone() {
        let mut tim = at_1_mhz();
        tim.reset();
        tim.write(1000, CR1, CEN).unwrap();
        assert_eq!(tim.read(1000 + 2 * 50, CNT), Some(50));
    }

    #[test]
    fn a_compare_value_beyond_the_reload_value_never_matches() {
        let mut tim = at_1_mhz();
        tim.write(0, CCR1, 0x1_0000).unwrap();
        tim.write(0, DIER, 1 << 1).unwrap();
        assert_eq!(tim.next_event(0), None);
    }
}
