//! Flash operations of a board: they take time, and power may fail in the middle of one.
//!
//! While a bank programs or erases, accesses of the core to it wait. While option bytes are programmed, accesses to
//! both banks wait. A core that runs from RAM or from the other bank of a part with 2 MiB continues until it fetches
//! from the busy bank. It is not modelled that a *load* from there would wait too.

use super::EmulatedBoard;
use crate::accelerator::LINE;
use crate::memory::NotMemory;
use crate::model::FLASH_BASE;
use crate::peripherals::Change;
use crate::wire::time::Time;

/// Content of a word or sector after an interrupted operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Remains {
    /// The old content.
    Old,
    /// The intended new content.
    New,
    /// Words of both kinds, and words with bits of both, by this seed.
    Mixed(u64),
}

/// The operation under way.
#[derive(Clone, Copy, Debug)]
struct UnderWay {
    ends: Time,
    /// Instant of its end, or of the power failure before it.
    event: Time,
    cycle: u64,
    cut: Option<Remains>,
}

/// State of flash operations and their faults.
#[derive(Clone, Debug, Default)]
pub(super) struct FlashCare {
    under_way: Option<UnderWay>,
    /// Number of operations after which power fails, and the content that remains.
    cut: Option<(u64, Remains)>,
    /// Words that are worn: address, and the bits that programming does not change.
    pub(super) worn: Vec<(u32, u32)>,
}

impl FlashCare {
    /// Returns the cycle of the next event of the flash.
    pub(super) fn event(&self) -> u64 {
        self.under_way.map_or(u64::MAX, |operation| operation.cycle)
    }

    /// Returns whether an operation is under way.
    pub(super) fn is_busy(&self) -> bool {
        self.under_way.is_some()
    }
}

impl EmulatedBoard {
    /// Makes power fail in the middle of a flash operation; 1 is the next one. Power stays off until it is switched on.
    pub fn cut_power_at(&mut self, operation: u64, remains: Remains) {
        let so_far = self.counters.flash_programs + self.counters.flash_erases;
        self.flash.cut = Some((so_far + operation, remains));
    }

    /// Writes to flash from outside, as a debug probe does.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash.
    pub fn write_flash(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let changed = self.chip.memory.program(address, bytes)?;
        self.core.invalidate(changed);
        Ok(())
    }

    /// Programs the option bytes from outside, as a debug probe does: bits as in FLASH_OPTCR.
    pub fn set_option_bytes(&mut self, optcr: u32) {
        self.chip.peripherals.flash.set_options(optcr);
    }

    /// Sets error flags of FLASH_SR from outside, as a failed operation of a debug probe leaves them.
    pub fn leave_flash_errors(&mut self, sr: u32) {
        self.chip.peripherals.flash.leave_errors(sr);
    }

    /// Returns whether the core waits for the flash.
    pub(super) fn is_stalled(&self) -> bool {
        self.flash.is_busy() && self.runs_from_busy_bank()
    }

    /// Returns whether the core fetches from the bank that is busy.
    #[cold]
    fn runs_from_busy_bank(&self) -> bool {
        // Flash is also mapped at zero.
        let (part, pc) = (self.config.model.part, self.core.pc());
        let offset = pc.checked_sub(FLASH_BASE).unwrap_or(pc);
        let is_busy = match self.chip.peripherals.flash.operation() {
            Some((Change::Options, _)) => true,
            Some((change, _)) => part.bank_of(change.range().start) == part.bank_of(offset),
            None => false,
        };
        offset < part.flash_bytes() && is_busy
    }

    /// Starts timing the operation that the program started.
    pub(super) fn follow_flash(&mut self, clocks_changed: bool) {
        let Some((change, ends)) = self.chip.peripherals.flash.operation() else { return };
        if self.flash.under_way.is_none() {
            match change {
                Change::Program { .. } => self.counters.flash_programs += 1,
                Change::Erase(_) => self.counters.flash_erases += 1,
                Change::Options => {}
            }
            let count = self.counters.flash_programs + self.counters.flash_erases;
            let cut = self
                .flash
                .cut
                .take_if(|&mut (at, _)| at == count && *change != Change::Options)
                .map(|(_, remains)| remains);
            let middle = Time(self.now().0.midpoint(ends.0));
            let event = if cut.is_some() { middle } else { *ends };
            self.flash.under_way = Some(UnderWay { ends: *ends, event, cycle: 0, cut });
        } else if !clocks_changed {
            return;
        }
        if let Some(under_way) = &mut self.flash.under_way {
            debug_assert_eq!(under_way.ends, *ends, "one operation at a time");
            under_way.cycle = self.chip.clock.cycle_at(under_way.event) + 1;
        }
    }

    /// Ends the operation in progress, or interrupts it by a power failure.
    pub(super) fn on_flash_event(&mut self) {
        match self.flash.under_way.and_then(|under_way| under_way.cut) {
            Some(remains) => {
                self.leave_flash(remains);
                self.power(false);
            }
            None => {
                self.leave_flash(Remains::New);
                self.refresh();
            }
        }
    }

    /// Interrupts the operation in progress, if any, by a reset or loss of power: the remaining content is undefined.
    pub(super) fn interrupt_flash(&mut self) {
        self.leave_flash(Remains::Mixed(self.chip.clock.now().cycle));
    }

    fn leave_flash(&mut self, remains: Remains) {
        self.flash.under_way = None;
        let Some(change) = self.chip.peripherals.flash.finish(remains == Remains::New) else { return };
        if change == Change::Options {
            return;
        }
        // Extends the range to whole lines of the caches.
        let range = change.range();
        let range = range.start / LINE * LINE..range.end.next_multiple_of(LINE);
        let address = FLASH_BASE + range.start;
        let in_flash = "an operation stays within the memory";
        let mut old = vec![0; range.len()];
        self.chip.memory.copy_out(address, &mut old).expect(in_flash);
        let mut new = old.clone();
        let changed = change.range();
        change.apply(&mut new[(changed.start - range.start) as usize..(changed.end - range.start) as usize]);
        let mut content = match remains {
            Remains::Old => old.clone(),
            Remains::New => new,
            Remains::Mixed(seed) => mixed(&old, &new, seed),
        };
        for &(worn, bits) in &self.flash.worn {
            let bytes = bits.to_le_bytes();
            for ((content, old), at) in content.iter_mut().zip(&old).zip(address..) {
                let bits = at.checked_sub(worn).and_then(|k| bytes.get(k as usize));
                *content |= old & bits.unwrap_or(&0);
            }
        }
        let value;
        let stored = match change {
            Change::Program { offset, width, value: stored } => {
                value = stored.to_le_bytes();
                Some((offset, &value[..width.bytes() as usize]))
            }
            _ => None,
        };
        self.chip.accelerator.change(range, &old, &content, stored);
        self.write_flash(address, &content).expect(in_flash);
    }
}

/// Words of `old`, words of `new`, and words with bits of both.
fn mixed(old: &[u8], new: &[u8], seed: u64) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(seed);
    let words = old.chunks(4).zip(new.chunks(4)).map(|(old, new)| match random.u8(..3) {
        0 => old.to_vec(),
        1 => new.to_vec(),
        _ => old.iter().zip(new).map(|(old, new)| (old ^ new) & random.u8(..) ^ old).collect(),
    });
    words.collect::<Vec<_>>().concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_has_old_words_new_words_and_bits_of_both() {
        let (old, new) = ([0x0F; 400], [0xFF; 400]);
        let content = mixed(&old, &new, 1);
        assert_eq!(content, mixed(&old, &new, 1));
        assert_ne!(content, mixed(&old, &new, 2));
        let count = |word: [u8; 4]| content.chunks(4).filter(|chunk| *chunk == word).count();
        let (olds, news) = (count([0x0F; 4]), count([0xFF; 4]));
        assert!(olds > 10 && news > 10 && olds + news < 90, "{olds} {news}");
        assert!(content.iter().all(|byte| byte & 0x0F == 0x0F), "bits that do not change stay");
    }
}
