//! State and priority of each exception, and the registers of the NVIC (B1.5.4, B3.4).

use crate::cpu::trap::{DEBUG_MONITOR, HARD_FAULT, INTERRUPTS, NMI, PEND_SV, SV_CALL, SYSTICK};

/// Interrupt lines.
pub const LINES: u16 = 97;
/// Numbers of exceptions with room up to whole words.
const EXCEPTIONS: usize = 128;
/// The four bits of a priority that are there.
pub const PRIORITY_BITS: u8 = 0xF0;

/// A set of exceptions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exceptions([u32; EXCEPTIONS / 32]);

impl Exceptions {
    pub fn contains(self, exception: u16) -> bool {
        self.0[usize::from(exception) / 32] >> (exception % 32) & 1 == 1
    }

    pub fn set(&mut self, exception: u16, on: bool) {
        let bit = 1 << (exception % 32);
        let word = &mut self.0[usize::from(exception) / 32];
        *word = if on { *word | bit } else { *word & !bit };
    }

    pub fn count(self) -> u32 {
        self.0.iter().map(|word| word.count_ones()).sum()
    }

    fn and(self, other: Self) -> Self {
        Exceptions(std::array::from_fn(|word| self.0[word] & other.0[word]))
    }

    fn iter(self) -> impl Iterator<Item = u16> {
        (0_u16..).step_by(32).zip(self.0).flat_map(|(base, word)| {
            std::iter::successors(Some(word), |word| Some(word & word.wrapping_sub(1)))
                .take_while(|&word| word != 0)
                .map(move |word| base + word.trailing_zeros() as u16)
        })
    }

    /// 32 interrupts from `32 * word` on, as the registers of the NVIC hold them. Those that are not there are zero.
    fn interrupts(self, word: u32) -> u32 {
        let at = word as usize;
        let Some(&low) = self.0.get(at) else { return 0 };
        let high = self.0.get(at + 1).copied().unwrap_or_default();
        (low >> 16 | high << 16) & lines(word)
    }
}

/// The lines of one register that are there.
pub fn lines(word: u32) -> u32 {
    match u32::from(LINES).saturating_sub(32 * word) {
        count @ 0..32 => (1 << count) - 1,
        _ => u32::MAX,
    }
}

/// State of all exceptions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nvic {
    pub pending: Exceptions,
    pub active: Exceptions,
    /// Exceptions that can be taken; of system exceptions those that SHCSR and DEMCR enable or that always are.
    pub enabled: Exceptions,
    /// Inputs that are high.
    pub lines: Exceptions,
    priorities: [u8; EXCEPTIONS],
}

impl Default for Nvic {
    fn default() -> Self {
        let mut enabled = Exceptions::default();
        for exception in [NMI, HARD_FAULT, SV_CALL, PEND_SV, SYSTICK] {
            enabled.set(exception, true);
        }
        Nvic {
            pending: Exceptions::default(),
            active: Exceptions::default(),
            enabled,
            lines: Exceptions::default(),
            priorities: [0; EXCEPTIONS],
        }
    }
}

impl Nvic {
    /// System reset; inputs keep their level, DEMCR its enable of DebugMonitor.
    pub fn reset(&mut self) {
        let monitor = self.enabled.contains(DEBUG_MONITOR);
        *self = Nvic { lines: self.lines, ..Nvic::default() };
        self.enabled.set(DEBUG_MONITOR, monitor);
        self.pending = self.lines;
    }

    /// Priority group of an exception: -2, -1, or what `group_mask` leaves of its priority.
    pub fn priority(&self, exception: u16, group_mask: u8) -> i16 {
        match exception {
            NMI => -2,
            HARD_FAULT => -1,
            _ => i16::from(self.priorities[usize::from(exception)] & group_mask),
        }
    }

    /// The pending exception of the highest priority and its group (B1.5.4). Of equals the one with the lowest number.
    pub fn first_pending(&self, group_mask: u8) -> Option<(u16, i16)> {
        let exception = self.pending.and(self.enabled).iter().min_by_key(|&exception| {
            // The whole priority decides, and NMI and HardFault come first.
            (self.priority(exception, PRIORITY_BITS), exception)
        })?;
        Some((exception, self.priority(exception, group_mask)))
    }

    /// The highest priority group of an active exception.
    pub fn active_priority(&self, group_mask: u8) -> Option<i16> {
        self.active.iter().map(|exception| self.priority(exception, group_mask)).min()
    }

    /// Returns whether an interrupt is pending, enabled or not.
    pub fn is_interrupt_pending(&self) -> bool {
        (0..4).any(|word| self.pending.interrupts(word) != 0)
    }

    /// Reads a word at an offset from E000_E100h.
    pub fn read(&self, offset: u32) -> u32 {
        let word = offset / 4 % 16;
        match offset {
            0x000..0x040 | 0x080..0x0C0 => self.enabled.interrupts(word),
            0x100..0x140 | 0x180..0x1C0 => self.pending.interrupts(word),
            0x200..0x240 => self.active.interrupts(word),
            0x300..0x3F0 => self.priorities(INTERRUPTS + (offset - 0x300) as u16),
            _ => 0,
        }
    }

    /// Writes a word at an offset from E000_E100h but the set-pending registers; `mask` has the bits that the access covers.
    pub fn write(&mut self, offset: u32, value: u32, mask: u32) {
        let word = offset / 4 % 16;
        let first = INTERRUPTS + (word * 32) as u16;
        let chosen = value & lines(word);
        match offset {
            0x000..0x040 => set_all(&mut self.enabled, first, chosen, true),
            0x080..0x0C0 => set_all(&mut self.enabled, first, chosen, false),
            0x180..0x1C0 => {
                // A line that is still high pends again at once, unless its interrupt is active.
                let high = self.lines.interrupts(word) & !self.active.interrupts(word);
                set_all(&mut self.pending, first, chosen & !high, false);
            }
            0x300..0x3F0 => self.set_priorities(INTERRUPTS + (offset - 0x300) as u16, value, mask),
            _ => {}
        }
    }

    /// The interrupts that a write of `value` to a set-pending register names.
    pub fn named(offset: u32, value: u32) -> impl Iterator<Item = u16> {
        let word = offset / 4 % 16;
        let first = INTERRUPTS + (word * 32) as u16;
        let chosen = value & lines(word);
        (0..32).filter(move |bit| chosen >> bit & 1 == 1).map(move |bit| first + bit)
    }

    /// Priorities of four exceptions from `first` on.
    pub fn priorities(&self, first: u16) -> u32 {
        let at = |k| self.priorities.get(usize::from(first + k)).copied().unwrap_or_default();
        u32::from_le_bytes([at(0), at(1), at(2), at(3)])
    }

    pub fn set_priorities(&mut self, first: u16, value: u32, mask: u32) {
        for (exception, (value, mask)) in
            (first..).zip(value.to_le_bytes().into_iter().zip(mask.to_le_bytes()))
        {
            if mask != 0 && exception < INTERRUPTS + LINES {
                self.priorities[usize::from(exception)] = value & PRIORITY_BITS;
            }
        }
    }
}

fn set_all(set: &mut Exceptions, first: u16, bits: u32, on: bool) {
    for bit in (0..32).filter(|bit| bits >> bit & 1 == 1) {
        set.set(first + bit, on);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_equal_priorities_the_lowest_number_comes_first() {
        let mut nvic = Nvic::default();
        nvic.write(0x000, 0b110, u32::MAX);
        for exception in [17, 18] {
            nvic.pending.set(exception, true);
        }
        assert_eq!(nvic.first_pending(0xFF), Some((17, 0)));
        nvic.set_priorities(16, 0x0000_1000, 0x0000_FF00);
        assert_eq!(nvic.first_pending(0xFF), Some((18, 0)));
        assert_eq!(nvic.read(0x300), 0x0000_1000);
    }

    #[test]
    fn only_97_lines_are_there() {
        let mut nvic = Nvic::default();
        nvic.write(0x00C, u32::MAX, u32::MAX);
        nvic.write(0x010, u32::MAX, u32::MAX);
        assert_eq!((nvic.read(0x00C), nvic.read(0x010)), (1, 0));
    }
}
