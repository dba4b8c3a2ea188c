//! Upsets of a timer: bits that hold state, and what follows when one of them is inverted.
//!
//! The buffers of prescaler and reload value (RM0090 18.3.1) have no address and are not listed.

use super::*;

/// CEN to CKD.
const CR1_BITS: u32 = 0x3FF;
/// DIR and CMS.
const COUNTING_MODE: u32 = 0x70;
/// CCDS, MMS, TI1S.
const CR2_BITS: u32 = 0xF8;
const SMCR_BITS: u32 = 0xFFF7;
/// External clock mode 2 in SMCR.
const ECE: u32 = 1 << 14;
/// UIE to CC4DE, without the bits that are reserved.
const DIER_BITS: u32 = 0x5F5F;
/// UIF to CC4IF, TIF, CC1OF to CC4OF.
const SR_BITS: u32 = 0x1E5F;
const CCER_BITS: u32 = 0xBBBB;
/// OCxFE and OCxCE of an output, or ICxF of an input, which delay a capture by at most 0.6 us when one bit of it is set.
const OUTPUT_DETAILS: u32 = 0x84;
const INPUT_FILTER: u32 = 0xF0;

impl Timer {
    /// Returns the offsets of the registers, and their bits that hold state.
    pub fn stored(&self) -> Vec<(u32, u32)> {
        let count = u32::MAX >> (32 - self.kind.bits);
        let all = [
            (CR1, CR1_BITS),
            (CR2, CR2_BITS),
            (SMCR, SMCR_BITS),
            (DIER, DIER_BITS),
            (SR, SR_BITS),
            (CCMR1, 0xFFFF),
            (CCMR2, 0xFFFF),
            (CCER, CCER_BITS),
            (CNT, count),
            (PSC, 0xFFFF),
            (ARR, count),
        ];
        let compare = (CCR1..=CCR4).step_by(4).map(|offset| (offset, count));
        all.into_iter().chain(compare).filter(|(offset, _)| self.has(*offset)).collect()
    }

    /// Inverts a bit of a register.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for a mode that the model does not have.
    pub fn flip(&mut self, cycle: u64, offset: u32, bit: u32) -> Result<(), Refusal> {
        self.catch_up(cycle);
        self.calm_until = 0;
        let mask = 1 << bit;
        match offset {
            CR1 if mask & COUNTING_MODE != 0 => return Err(Refusal::Unmodelled),
            CR1 => return self.write(cycle, CR1, Width::Word, self.cr1 ^ mask),
            // No modelled timer listens to a timer without pins, and nothing arrives at its inputs.
            CR2 if !self.kind.drives_pins => self.cr2 ^= mask,
            SMCR if !self.kind.drives_pins => {
                self.smcr ^= mask;
                let is_starved = self.smcr & ECE != 0 || !matches!(self.smcr & SMS, 0 | 0b100 | TRIGGER_MODE);
                self.clock(cycle, !is_starved);
            }
            CR2 => return self.set_trigger_output(cycle, self.cr2 ^ mask),
            SMCR => return self.write(cycle, SMCR, Width::Word, self.smcr ^ mask),
            // The other requests and interrupts have no cause or no stream.
            DIER if mask & (FLAGS | CHANNEL_REQUESTS) == 0 => {}
            DIER => return self.write(cycle, DIER, Width::Word, self.dier ^ mask),
            SR => self.sr ^= mask,
            CCMR1 | CCMR2 => return self.flip_mode(cycle, (offset - CCMR1) / 4, bit),
            // An output without a pin changes nothing.
            CCER if !self.kind.drives_pins => {
                self.ccer ^= mask;
                self.set_up_at = cycle;
            }
            CCER => return self.set_enables(cycle, self.ccer ^ mask),
            CNT => {
                let count = self.counter.count(cycle) ^ mask;
                self.counter.set_count(cycle, count);
                self.set_up_at = cycle;
                self.follow_modes(cycle);
            }
            PSC => self.counter.psc ^= mask,
            ARR => self.counter.set_reload(cycle, self.counter.arr ^ mask, self.cr1 & ARPE != 0),
            CCR1..=CCR4 => {
                self.ccr[(offset - CCR1) as usize / 4] ^= mask;
                self.follow_modes(cycle);
            }
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    /// Inverts a bit of CCMR1 (pair 0) or CCMR2, also while its channel is on.
    fn flip_mode(&mut self, cycle: u64, pair: u32, bit: u32) -> Result<(), Refusal> {
        let mode = self.ccmr[pair as usize] ^ 1 << bit;
        let half = mode >> (bit / 8 * 8) & 0xFF;
        let without_effect = match half & 0b11 {
            0b11 => return Err(Refusal::Unmodelled),
            0 => OUTPUT_DETAILS,
            _ => INPUT_FILTER,
        };
        if without_effect >> (bit % 8) & 1 == 1 {
            return Ok(());
        }
        if half & without_effect != 0 {
            return Err(Refusal::Unmodelled);
        }
        let before = self.outputs();
        self.ccmr[pair as usize] = mode;
        self.set_up_at = cycle;
        self.note_outputs(cycle, before);
        self.follow_modes(cycle);
        Ok(())
    }

    /// Stops the clock of the timer, or lets it run again. Its registers stay as they are.
    pub fn clock(&mut self, cycle: u64, on: bool) {
        self.catch_up(cycle);
        self.calm_until = 0;
        self.counter.run(cycle, on && self.cr1 & CEN != 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As TIM2 of the time driver: 16 of its 32 bits are in use.
    fn running() -> Timer {
        let kind = Kind { bits: 32, trigger: None, drives_pins: false, channels: 4, is_advanced: false };
        let mut timer = Timer::new(kind, 1);
        for (offset, value) in [(ARR, 0xFFFF), (CCR1, 0x8000), (CR1, CEN)] {
            timer.write(0, offset, Width::Word, value).unwrap();
        }
        timer
    }

    /// RM0090 18.3.2: the counter overflows when it equals the reload value, and a count beyond it does not.
    #[test]
    fn count_beyond_the_reload_value_runs_to_its_end() {
        for bit in 16..32 {
            let mut timer = running();
            timer.flip(100, CNT, bit).unwrap();
            let count = 100 + (1 << bit);
            assert_eq!(timer.read(100, CNT), Ok(count), "bit {bit}");
            assert_eq!(timer.read(0x1_0000, CNT), Ok(count + 0x1_0000 - 100));
            let to_zero = (1_u64 << 32) - u64::from(count);
            assert_eq!(timer.counter.reaches(0x8000, 100), Some(100 + to_zero + 0x8000));
            assert_eq!(timer.counter.reaches(0, 100), Some(100 + to_zero));
            assert_eq!(timer.read(100 + to_zero + 7, CNT), Ok(7));
            assert_eq!(timer.counter.reaches(0x8000, 100 + to_zero + 7), Some(100 + to_zero + 0x8000));
        }
    }

    #[test]
    fn reload_value_below_the_count_is_passed() {
        let mut timer = running();
        timer.flip(0xC000, ARR, 15).unwrap();
        assert_eq!(timer.read(0xC000 + 0x5000, CNT), Ok(0x1_1000));
    }

    #[test]
    fn a_timer_without_clock_keeps_its_count() {
        let mut timer = running();
        timer.clock(100, false);
        assert_eq!((timer.read(500, CNT), timer.next_event(500)), (Ok(100), None));
        timer.clock(600, true);
        assert_eq!(timer.read(650, CNT), Ok(150));
        assert_eq!(timer.read(650, CR1), Ok(CEN));
    }

    #[test]
    fn each_bit_flips_or_is_refused() {
        let mut refused = Vec::new();
        for (offset, bits) in running().stored() {
            for bit in (0..32).filter(|bit| bits >> bit & 1 == 1) {
                if running().flip(100, offset, bit).is_err() {
                    refused.push((offset, bit));
                }
            }
        }
        let counting = [(CR1, 4), (CR1, 5), (CR1, 6)];
        assert!(counting.iter().all(|bit| refused.contains(bit)), "{refused:?}");
        assert!(refused.iter().all(|(offset, _)| *offset == CR1), "{refused:?}");
    }

    /// Given a timer that counts edges of an input without a signal, then it stands.
    #[test]
    fn external_clock_without_a_signal_stops_the_counter() {
        for bit in [0, 1, 14] {
            let mut timer = running();
            timer.flip(100, SMCR, bit).unwrap();
            assert_eq!(timer.read(500, CNT), Ok(100), "bit {bit}");
        }
    }
}
