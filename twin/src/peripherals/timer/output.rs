//! Outputs of a timer: OCxREF by output mode, outputs at pins, the trigger for another timer.
//!
//! RM0090 18.3.8 to 18.3.10 and 18.3.15.

use super::{CEN, MMS, SMS, TIF, TRIGGER_CLOCKS, TRIGGER_MODE, Timer};
use crate::mmio::Refusal;

/// OCxM.
const ACTIVE_ON_MATCH: u32 = 0b001;
const INACTIVE_ON_MATCH: u32 = 0b010;
const TOGGLE: u32 = 0b011;
const FORCE_INACTIVE: u32 = 0b100;
const FORCE_ACTIVE: u32 = 0b101;
const PWM_1: u32 = 0b110;
const PWM_2: u32 = 0b111;

impl Timer {
    /// OCxM of channel 0..=3; 0 for an input, as for a frozen output.
    fn output_mode(&self, channel: u32) -> u32 {
        if self.is_input(channel) {
            return 0;
        }
        self.ccmr[channel as usize / 2] >> (8 * (channel % 2) + 4) & 0b111
    }

    /// Returns whether any channel is an output that counting changes.
    fn has_outputs(&self) -> bool {
        (self.ccmr[0] | self.ccmr[1]) & 0x7070 != 0
    }

    fn reference(&self, channel: u32) -> bool {
        self.references >> channel & 1 == 1
    }

    /// Returns the level of OCx at its pin; `None` while the output is off.
    pub fn output(&self, channel: u32) -> Option<bool> {
        let polarity = self.polarity(channel);
        (!self.is_input(channel) && polarity & 1 == 1).then(|| self.reference(channel) ^ (polarity & 2 != 0))
    }

    pub(super) fn outputs(&self) -> [Option<bool>; 4] {
        std::array::from_fn(|channel| self.output(channel as u32))
    }

    /// Records how outputs differ from `before`.
    pub(super) fn note_outputs(&mut self, cycle: u64, before: [Option<bool>; 4]) {
        for (channel, before) in (0..4).zip(before) {
            let now = self.output(channel);
            if now != before {
                self.changes.push((cycle, channel, now));
            }
        }
    }

    /// The level of the trigger output that MMS selects, OC1REF to OC4REF.
    fn trigger_output(&self) -> bool {
        let source = (self.cr2 & MMS) >> 4;
        source >= 4 && self.reference(source - 4)
    }

    /// CR2: UG (000) or OC1REF to OC4REF (100 to 111) as trigger output.
    pub(super) fn set_trigger_output(&mut self, cycle: u64, value: u32) -> Result<(), Refusal> {
        if value & !MMS != 0 || (1..4).contains(&(value >> 4)) {
            return Err(Refusal::Unmodelled);
        }
        let before = self.trigger_output();
        self.cr2 = value;
        self.note_trigger(cycle, before);
        Ok(())
    }

    fn note_trigger(&mut self, cycle: u64, before: bool) {
        if !before && self.trigger_output() {
            self.rises.push(cycle);
        }
    }

    fn set_reference(&mut self, cycle: u64, channel: u32, level: bool) {
        let (outputs, trigger) = (self.outputs(), self.trigger_output());
        self.references = self.references & !(1 << channel) | u32::from(level) << channel;
        self.note_outputs(cycle, outputs);
        self.note_trigger(cycle, trigger);
    }

    /// Updates forced and PWM references after the program changed a mode, a compare value or the count.
    pub(super) fn follow_modes(&mut self, cycle: u64) {
        let count = self.counter.count(cycle);
        for channel in 0..4 {
            let compare = self.ccr[channel as usize];
            let level = match self.output_mode(channel) {
                FORCE_INACTIVE => false,
                FORCE_ACTIVE => true,
                PWM_1 => count < compare,
                PWM_2 => count >= compare,
                _ => continue,
            };
            self.set_reference(cycle, channel, level);
        }
    }

    /// Returns the next change of a reference by counting after `cycle`: cycle, channel, new level.
    pub(super) fn next_change(&self, cycle: u64) -> Option<(u64, u32, bool)> {
        if !self.counter.running || !self.has_outputs() {
            return None;
        }
        (0..4).filter_map(|channel| self.next_change_of(channel, cycle)).min_by_key(|(at, ..)| *at)
    }

    fn next_change_of(&self, channel: u32, cycle: u64) -> Option<(u64, u32, bool)> {
        let (compare, level) = (self.ccr[channel as usize], self.reference(channel));
        let mode = self.output_mode(channel);
        if !matches!(mode, ACTIVE_ON_MATCH..=TOGGLE | PWM_1 | PWM_2) || self.counter.exceeds(compare) {
            return None;
        }
        // A compare value of zero holds a PWM reference.
        let value = match mode {
            ACTIVE_ON_MATCH if level => return None,
            INACTIVE_ON_MATCH if !level => return None,
            PWM_1 | PWM_2 if compare == 0 => return None,
            PWM_1 if !level => 0,
            PWM_2 if level => 0,
            _ => compare,
        };
        self.counter.reaches(value, cycle).map(|at| (at, channel, !level))
    }

    /// Changes references as counting until `cycle` does.
    pub(super) fn set_outputs(&mut self, cycle: u64) {
        let mut from = self.seen;
        while let Some((at, ..)) = self.next_change(from).filter(|(at, ..)| *at <= cycle) {
            for channel in 0..4 {
                if let Some((same, _, level)) = self.next_change_of(channel, from)
                    && same == at
                {
                    self.set_reference(at, channel, level);
                }
            }
            from = at;
        }
    }

    /// Changes of outputs since the last call: cycle, channel, level.
    pub fn take_changes(&mut self) -> Vec<(u64, u32, Option<bool>)> {
        std::mem::take(&mut self.changes)
    }

    /// Cycles at which the trigger output rose since the last call.
    pub fn take_rises(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.rises)
    }

    /// Handles a rising trigger input at `cycle`.
    pub fn trigger(&mut self, cycle: u64) {
        if self.smcr & SMS != TRIGGER_MODE {
            return;
        }
        self.catch_up(cycle);
        self.calm_until = 0;
        self.sr |= TIF;
        if self.cr1 & CEN == 0 {
            self.cr1 |= CEN;
            self.starts_at = Some(cycle + TRIGGER_CLOCKS * self.counter.divider);
        }
    }
}
