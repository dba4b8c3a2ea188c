//! IWDG: the independent watchdog on the LSI oscillator.
//!
//! RM0090 chapter 21. Software starts it, or every reset if the option bytes select that; only a reset stops it. It
//! continues in Sleep, in endless fault handlers and in lock-up. DBG_IWDG_STOP freezes it while a debugger halts the
//! core.

use crate::mmio::Refusal;
use crate::wire::time::{TICKS_PER_US, Time};

const KR: u32 = 0x00;
pub(super) const PR: u32 = 0x04;
pub(super) const RLR: u32 = 0x08;
const SR: u32 = 0x0C;

const KEY_ACCESS: u32 = 0x5555;
const KEY_RELOAD: u32 = 0xAAAA;
const KEY_START: u32 = 0xCCCC;
const FULL: u32 = 0xFFF;
/// LSI cycles that an update of PR or RLR takes at most (RM0090 21.4.4).
const UPDATE_CYCLES: u64 = 5;

/// The registers; all times are virtual time, not the core's.
#[derive(Clone, Debug)]
pub struct Iwdg {
    lsi_hz: u64,
    writable: bool,
    pub(super) pr: u32,
    pub(super) rlr: u32,
    /// Instants at which PVU and RVU are cleared.
    updated: [Time; 2],
    /// Start of the count, and the value from which it counts down.
    counting: Option<(Time, u32)>,
}

impl Iwdg {
    /// After a reset.
    pub fn new(lsi_hz: u32) -> Self {
        Iwdg {
            lsi_hz: u64::from(lsi_hz),
            writable: false,
            pr: 0,
            rlr: FULL,
            updated: [Time::ZERO; 2],
            counting: None,
        }
    }

    /// Stops it, at any reset of the chip.
    pub fn reset(&mut self) {
        *self = Iwdg::new(self.lsi_hz as u32);
    }

    fn divider(&self) -> u64 {
        // 110b and 111b are both 256.
        4 << self.pr.min(6)
    }

    fn span(&self, lsi_cycles: u64) -> Time {
        let ticks = u128::from(lsi_cycles) * u128::from(TICKS_PER_US) * 1_000_000;
        Time(ticks.div_ceil(u128::from(self.lsi_hz)) as u64)
    }

    /// Returns the instant at which it resets the chip unless it is reloaded before.
    pub fn deadline(&self) -> Option<Time> {
        let (since, count) = self.counting?;
        Some(since + self.span((u64::from(count) + 1) * self.divider()))
    }

    /// Accounts for a freeze of `span`.
    pub fn stood_still(&mut self, span: Time) {
        if let Some((since, _)) = &mut self.counting {
            *since += span;
        }
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist.
    pub fn read(&self, now: Time, offset: u32) -> Result<u32, Refusal> {
        Ok(match offset {
            KR => 0,
            PR => self.pr,
            RLR => self.rlr,
            SR => (0..2).filter(|&n| now < self.updated[n]).fold(0, |sr, n| sr | 1 << n),
            _ => return Err(Refusal::Unmodelled),
        })
    }

    /// Stores to a register. PR and RLR ignore stores before the access key.
    ///
    /// # Errors
    /// [`Refusal::Misuse`] for a second value while the update with the first is in progress, [`Refusal::Unmodelled`]
    /// for what does not exist.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Result<(), Refusal> {
        match offset {
            KR => {
                self.writable = value & 0xFFFF == KEY_ACCESS;
                match value & 0xFFFF {
                    KEY_START => self.start(now),
                    KEY_RELOAD if self.counting.is_some() => self.counting = Some((now, self.rlr)),
                    _ => {}
                }
            }
            PR | RLR if !self.writable => {}
            PR | RLR => {
                let index = usize::from(offset == RLR);
                if now < self.updated[index] {
                    return Err(Refusal::Misuse);
                }
                self.updated[index] = now + self.span(UPDATE_CYCLES);
                if offset == PR {
                    self.set_prescaler(now, value & 0b111);
                } else {
                    self.rlr = value & FULL;
                }
            }
            SR => {}
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    /// Starts it from FFFh, independent of RLR (RM0090 21.3). Has no effect while it runs.
    pub fn start(&mut self, now: Time) {
        self.counting.get_or_insert((now, FULL));
    }

    pub(super) fn set_prescaler(&mut self, now: Time, pr: u32) {
        if let Some((since, count)) = &mut self.counting {
            let per_count = u128::from(TICKS_PER_US) * 1_000_000 * u128::from(4_u64 << self.pr.min(6));
            let passed = u128::from(now.since(*since).0) * u128::from(self.lsi_hz) / per_count;
            *count = count.saturating_sub(passed as u32);
            *since = now;
        }
        self.pr = pr;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn started(lsi_hz: u32, pr: u32, rlr: u32) -> Iwdg {
        let mut iwdg = Iwdg::new(lsi_hz);
        for (offset, value) in [(KR, KEY_ACCESS), (PR, pr), (RLR, rlr), (KR, KEY_START), (KR, KEY_RELOAD)] {
            iwdg.write(Time::ZERO, offset, value).unwrap();
        }
        iwdg
    }

    /// RM0090 table 107: timeouts at 32 kHz, shortest and longest of each prescaler.
    #[test]
    fn timeouts_are_those_of_the_manual() {
        let table = [
            (0, 125, 512_000),
            (1, 250, 1_024_000),
            (2, 500, 2_048_000),
            (3, 1_000, 4_096_000),
            (4, 2_000, 8_192_000),
            (5, 4_000, 16_384_000),
            (6, 8_000, 32_768_000),
            (7, 8_000, 32_768_000),
        ];
        for (pr, shortest, longest) in table {
            assert_eq!(started(32_000, pr, 0).deadline(), Some(Time::from_us(shortest)), "PR {pr}");
            assert_eq!(started(32_000, pr, FULL).deadline(), Some(Time::from_us(longest)), "PR {pr}");
        }
    }

    #[test]
    fn a_slow_oscillator_stretches_the_timeout() {
        // DS8626 table 41: 17 to 47 kHz. 4 * 4096 cycles at 17 kHz last 963.764 705... ms.
        assert_eq!(started(17_000, 0, FULL).deadline(), Some(Time(323_824_942)));
    }

    #[test]
    fn it_starts_from_fffh_and_reloads_from_rlr() {
        let mut iwdg = Iwdg::new(32_000);
        iwdg.write(Time::ZERO, KR, KEY_ACCESS).unwrap();
        iwdg.write(Time::ZERO, RLR, 7).unwrap();
        assert_eq!(iwdg.deadline(), None);
        iwdg.write(Time::ZERO, KR, KEY_START).unwrap();
        assert_eq!(iwdg.deadline(), Some(Time::from_ms(512)));
        iwdg.write(Time::from_ms(100), KR, KEY_RELOAD).unwrap();
        assert_eq!(iwdg.deadline(), Some(Time::from_ms(101)));
    }

    #[test]
    fn starting_again_does_not_reload() {
        let mut iwdg = started(32_000, 0, FULL);
        iwdg.write(Time::from_ms(100), KR, KEY_START).unwrap();
        assert_eq!(iwdg.deadline(), Some(Time::from_ms(512)));
    }

    #[test]
    fn prescaler_and_reload_value_need_the_access_key() {
        let mut iwdg = Iwdg::new(32_000);
        iwdg.write(Time::ZERO, PR, 3).unwrap();
        iwdg.write(Time::ZERO, KR, KEY_ACCESS).unwrap();
        iwdg.write(Time::ZERO, KR, KEY_RELOAD).unwrap();
        iwdg.write(Time::ZERO, RLR, 3).unwrap();
        assert_eq!((iwdg.read(Time::ZERO, PR), iwdg.read(Time::ZERO, RLR)), (Ok(0), Ok(0xFFF)));
    }

    #[test]
    fn an_update_takes_five_cycles_of_the_lsi() {
        let mut iwdg = Iwdg::new(32_000);
        iwdg.write(Time::ZERO, KR, KEY_ACCESS).unwrap();
        iwdg.write(Time::ZERO, PR, 1).unwrap();
        assert_eq!(iwdg.read(Time::from_us(156), SR), Ok(1));
        assert_eq!(iwdg.write(Time::from_us(156), PR, 2), Err(Refusal::Misuse));
        iwdg.write(Time::from_us(156), RLR, 2).unwrap();
        assert_eq!(iwdg.read(Time::from_us(157), SR), Ok(2));
        iwdg.write(Time::from_us(157), PR, 2).unwrap();
    }

    #[test]
    fn a_new_prescaler_applies_to_what_is_left() {
        let mut iwdg = started(32_000, 0, 15);
        // 16 counts of 125 us; 8 have elapsed, the others take 250 us each.
        iwdg.write(Time::from_ms(1), KR, KEY_ACCESS).unwrap();
        iwdg.write(Time::from_ms(1), PR, 1).unwrap();
        assert_eq!(iwdg.deadline(), Some(Time::from_ms(3)));
    }
}
