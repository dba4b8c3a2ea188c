//! RTC: calendar, both alarms, the wake-up timer and the backup registers.
//!
//! RM0090 chapter 26, RM0390 chapter 22. RTCCLK is LSE, LSI or HSE by RTCPRE; LSE and HSE run at their nominal frequency. What it
//! takes cycles of RTCCLK to do takes as many here: initialisation mode, the copy to the shadow registers, the write flags.
//! An alarm is raised by the count that makes it match, not by being enabled while it matches. Refused: the 12-hour format, time
//! stamps, tampers, outputs, the shift and both calibrations.

mod calendar;
#[cfg(test)]
mod tests;

use can_wire::time::{TICKS_PER_US, Time};

use crate::mmio::Refusal;
use calendar::{Date, Match};

const TR: u32 = 0x00;
const DR: u32 = 0x04;
const CR: u32 = 0x08;
const ISR: u32 = 0x0C;
const PRER: u32 = 0x10;
const WUTR: u32 = 0x14;
const CALIBR: u32 = 0x18;
const ALRMAR: u32 = 0x1C;
const ALRMBR: u32 = 0x20;
const WPR: u32 = 0x24;
const SSR: u32 = 0x28;
const TSTR: u32 = 0x30;
const TSSSR: u32 = 0x38;
const CALR: u32 = 0x3C;
const TAFCR: u32 = 0x40;
const ALRMASSR: u32 = 0x44;
const ALRMBSSR: u32 = 0x48;
const BACKUP: u32 = 0x50;
const END: u32 = 0xA0;

const BYPSHAD: u32 = 1 << 5;
const WUTE: u32 = 1 << 10;
const WUTIE: u32 = 1 << 14;
const WUCKSEL: u32 = 0b111;
/// Of alarm A; those of alarm B are one place higher.
const ALRAE: u32 = 1 << 8;
const ALRAIE: u32 = 1 << 12;
/// TSEDGE, BKP, COSEL and POL are kept and do nothing alone.
const CR_BITS: u32 = WUCKSEL | 1 << 3 | BYPSHAD | 0b111 << 8 | 0b111 << 12 | 0b111 << 18;

const ALRAWF: u32 = 1 << 0;
const INITS: u32 = 1 << 4;
const RSF: u32 = 1 << 5;
const INITF: u32 = 1 << 6;
const INIT: u32 = 1 << 7;
const ALRAF: u32 = 1 << 8;
const WUTF: u32 = 1 << 10;
/// Cleared by writing zero, without any key.
const FLAGS: u32 = 0b111 << 8;

/// Cycles of RTCCLK until a write flag or INITF is set, and from one copy to the shadow registers to the next.
const SYNCHRONISED: u64 = 2;
/// Cycles of RTCCLK from the end of initialisation mode until the calendar counts.
const RESTARTED: u64 = 4;
const KEYS: [u32; 2] = [0xCA, 0x53];
/// Lines of EXTI: both alarms, the wake-up timer.
const ALARM_LINE: u32 = 1 << 17;
const WAKE_UP_LINE: u32 = 1 << 22;

/// What drives RTCCLK.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RtcClock {
    /// Hz before the divider.
    pub hz: u64,
    /// RTCCLK is `hz` over this.
    pub divider: u64,
    /// Since when it runs.
    pub since: Time,
}

impl RtcClock {
    fn ticks(self, at: Time) -> u64 {
        let passed = u128::from(at.since(self.since).0) * u128::from(self.hz);
        (passed / (u128::from(self.divider) * u128::from(TICKS_PER_US) * 1_000_000)) as u64
    }

    fn time_of(self, ticks: u64) -> Time {
        let second = u128::from(self.divider) * u128::from(TICKS_PER_US) * 1_000_000;
        self.since + Time((u128::from(ticks) * second).div_ceil(u128::from(self.hz)) as u64)
    }
}

/// The registers. Times are counts of RTCCLK since the backup domain was reset.
#[derive(Clone, Debug)]
pub struct Rtc {
    backup: [u32; 20],
    clock: Option<RtcClock>,
    /// The count before `clock`.
    counted: u64,
    /// Keys of WPR that have come; two open the registers.
    keys: usize,
    cr: u32,
    flags: u32,
    prer: u32,
    wutr: u32,
    alarms: [Match; 2],
    alarm_fractions: [u32; 2],
    /// TR and DR when counting began.
    set: (u32, u32),
    began: u64,
    /// Since when INIT is set.
    initialising: Option<u64>,
    /// When ALRAWF, ALRBWF and WUTWF are set; `None` while theirs is enabled.
    writable: [Option<u64>; 3],
    /// When RSF is set again, and until when the shadow registers hold what they held before.
    synchronised: u64,
    stale_until: u64,
    stale: [u32; 3],
    /// Counts at which reads of SSR and TR have locked TR and DR.
    locks: [Option<u64>; 2],
    /// When the alarms and the wake-up timer next raise their flags.
    next: [Option<u64>; 3],
}

impl Default for Rtc {
    /// After a reset of the backup domain.
    fn default() -> Self {
        Rtc {
            backup: [0; 20],
            clock: None,
            counted: 0,
            keys: 0,
            cr: 0,
            flags: 0,
            prer: 0x007F_00FF,
            wutr: 0xFFFF,
            alarms: [Match(0); 2],
            alarm_fractions: [0; 2],
            set: (0, 0x2101),
            began: 0,
            initialising: None,
            writable: [Some(0); 3],
            synchronised: 0,
            stale_until: 0,
            stale: [0, 0x2101, 0],
            locks: [None; 2],
            next: [None; 3],
        }
    }
}

impl Rtc {
    /// A reset of the part, which leaves the backup domain alone: the shadow registers start again.
    pub fn reset(&mut self, now: Time) {
        let ticks = self.ticks(now);
        if self.initialising.take().is_some() {
            self.began = ticks + RESTARTED;
        }
        self.stale = [0, 0x2101, 0];
        (self.synchronised, self.stale_until) = (Self::copied(ticks), Self::copied(ticks));
        self.locks = [None; 2];
    }

    /// RTCCLK is another one from `now` on.
    pub fn set_clock(&mut self, now: Time, clock: Option<RtcClock>) {
        let same = |old: RtcClock, new: RtcClock| (old.hz, old.divider) == (new.hz, new.divider);
        match (self.clock, clock) {
            (None, None) => return,
            (Some(old), Some(new)) if same(old, new) => return,
            _ => {}
        }
        self.catch_up(now);
        self.counted = self.ticks(now);
        self.clock = clock.map(|clock| RtcClock { since: clock.since.max(now), ..clock });
    }

    fn ticks(&self, now: Time) -> u64 {
        let running = self.clock.filter(|clock| now > clock.since);
        self.counted + running.map_or(0, |clock| clock.ticks(now))
    }

    /// The count of the next copy to the shadow registers.
    fn copied(ticks: u64) -> u64 {
        ticks / SYNCHRONISED * SYNCHRONISED + SYNCHRONISED
    }

    fn is_initialising(&self, ticks: u64) -> bool {
        self.initialising.is_some_and(|since| ticks >= since + SYNCHRONISED)
    }

    /// PREDIV_A + 1 and PREDIV_S + 1.
    fn prescalers(&self) -> (u64, u64) {
        (u64::from(self.prer >> 16) + 1, u64::from(self.prer & 0x7FFF) + 1)
    }

    /// Counts of ck_apre since the calendar began.
    fn fractions(&self, ticks: u64) -> u64 {
        if self.is_initialising(ticks) { 0 } else { ticks.saturating_sub(self.began) / self.prescalers().0 }
    }

    /// TR, DR and SSR at a count.
    fn calendar(&self, ticks: u64) -> [u32; 3] {
        let (_, second) = self.prescalers();
        let fractions = self.fractions(ticks);
        let (tr, dr) = match Date::from_registers(self.set.0, self.set.1) {
            Some(date) => date.after(fractions / second).registers(),
            None => self.set,
        };
        [tr, dr, (second - 1 - fractions % second) as u32]
    }

    /// TR, DR and SSR as a program sees them that does not bypass the shadow registers.
    fn shadow(&self, ticks: u64) -> [u32; 3] {
        if ticks < self.stale_until {
            return self.stale;
        }
        self.calendar(ticks / SYNCHRONISED * SYNCHRONISED)
    }

    fn read_calendar(&mut self, ticks: u64, offset: u32) -> u32 {
        if self.cr & BYPSHAD != 0 {
            let [tr, dr, ssr] = self.calendar(ticks);
            return [tr, dr, ssr][if offset == SSR { 2 } else { offset as usize / 4 }];
        }
        match offset {
            SSR => {
                self.locks = self.locks.map(|lock| lock.or(Some(ticks)));
                self.shadow(ticks)[2]
            }
            TR => {
                self.locks[1].get_or_insert(ticks);
                self.shadow(self.locks[0].unwrap_or(ticks))[0]
            }
            _ => {
                let at = self.locks[1].unwrap_or(ticks);
                self.locks = [None; 2];
                self.shadow(at)[1]
            }
        }
    }

    fn isr(&self, ticks: u64) -> u32 {
        let when = |is: bool, bits: u32| if is { bits } else { 0 };
        let writable = |n: usize| self.writable[n].is_some_and(|from| ticks >= from);
        let is_synchronised =
            ticks >= self.synchronised && self.cr & BYPSHAD == 0 && !self.is_initialising(ticks);
        (0..3).fold(0, |isr, n| isr | when(writable(n), ALRAWF << n))
            | when(self.set.1 >> 16 != 0, INITS)
            | when(is_synchronised, RSF)
            | when(self.is_initialising(ticks), INITF)
            | when(self.initialising.is_some(), INIT)
            | self.flags
    }

    /// A load; `None` for what does not exist.
    pub fn read(&mut self, now: Time, offset: u32) -> Option<u32> {
        self.catch_up(now);
        let ticks = self.ticks(now);
        Some(match offset {
            TR | DR | SSR => self.read_calendar(ticks, offset),
            CR => self.cr,
            ISR => self.isr(ticks),
            PRER => self.prer,
            WUTR => self.wutr,
            ALRMAR | ALRMBR => self.alarms[(offset - ALRMAR) as usize / 4].0,
            ALRMASSR | ALRMBSSR => self.alarm_fractions[(offset - ALRMASSR) as usize / 4],
            WPR | CALIBR | CALR | TAFCR | TSTR..=TSSSR => 0,
            BACKUP..END => self.backup[(offset - BACKUP) as usize / 4],
            _ => return None,
        })
    }

    /// A store; nothing takes one without DBP in PWR_CR (`allowed`).
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for functions that are refused and what does not exist, [`Refusal::Misuse`] for the end of
    /// initialisation mode with a date that does not exist.
    pub fn write(&mut self, now: Time, offset: u32, value: u32, allowed: bool) -> Result<(), Refusal> {
        if !allowed {
            return Ok(());
        }
        self.catch_up(now);
        let ticks = self.ticks(now);
        let (open, initialising) = (self.keys == KEYS.len(), self.is_initialising(ticks));
        let writable = |n: usize| open && self.writable[n].is_some_and(|from| ticks >= from);
        match offset {
            BACKUP..END => self.backup[(offset - BACKUP) as usize / 4] = value,
            WPR => self.keys = if KEYS.get(self.keys) == Some(&(value & 0xFF)) { self.keys + 1 } else { 0 },
            ISR => {
                self.flags &= value | !FLAGS;
                if open {
                    self.write_isr(ticks, value)?;
                }
            }
            CR if value & !CR_BITS != 0 => return Err(Refusal::Unmodelled),
            CR if open => self.write_cr(ticks, value),
            TR if open && initialising => self.set.0 = value & 0x007F_7F7F,
            DR if open && initialising => self.set.1 = value & 0x00FF_FF3F,
            PRER if open && initialising => self.prer = value & 0x007F_7FFF,
            WUTR if writable(2) => self.wutr = value & 0xFFFF,
            ALRMAR | ALRMBR | ALRMASSR | ALRMBSSR => {
                let n = usize::from(matches!(offset, ALRMBR | ALRMBSSR));
                if writable(n) || open && initialising {
                    match offset {
                        ALRMAR | ALRMBR => self.alarms[n] = Match(value),
                        _ => self.alarm_fractions[n] = value & 0x0F00_7FFF,
                    }
                }
            }
            CALIBR | CALR | TAFCR if value == 0 => {}
            TR | DR | CR | PRER | WUTR => {}
            _ => return Err(Refusal::Unmodelled),
        }
        self.plan(ticks);
        Ok(())
    }

    fn write_isr(&mut self, ticks: u64, value: u32) -> Result<(), Refusal> {
        if value & RSF == 0 {
            self.synchronised = Self::copied(ticks);
        }
        match (self.initialising, value & INIT != 0) {
            (None, true) => {
                self.stale = self.shadow(ticks);
                let [tr, dr, _] = self.calendar(ticks);
                self.set = (tr, dr);
                // It stands still once it is in this mode; what passes until then is lost.
                self.initialising = Some(ticks);
            }
            (Some(_), false) => {
                Date::from_registers(self.set.0, self.set.1).ok_or(Refusal::Misuse)?;
                self.initialising = None;
                self.began = ticks + RESTARTED;
                self.synchronised = Self::copied(self.began);
                self.stale_until = self.synchronised;
            }
            _ => {}
        }
        Ok(())
    }

    fn write_cr(&mut self, ticks: u64, value: u32) {
        let old = self.cr;
        // WUCKSEL takes a value only while the wake-up timer is off.
        let kept = if old & WUTE != 0 { WUCKSEL } else { 0 };
        self.cr = value & !kept | old & kept;
        for n in 0..3 {
            let enable = ALRAE << n;
            match (old & enable != 0, value & enable != 0) {
                (false, true) => self.writable[n] = None,
                (true, false) => self.writable[n] = Some(ticks + SYNCHRONISED),
                _ => {}
            }
        }
        if value & !old & WUTE != 0 {
            self.next[2] = Some(self.wakes_after(ticks, self.wakes_every()));
        } else if value & WUTE == 0 {
            self.next[2] = None;
        }
    }

    /// Periods of the wake-up timer's clock from one flag to the next (RM0090 26.3.6).
    fn wakes_every(&self) -> u64 {
        u64::from(self.wutr) + 1 + if self.cr & WUCKSEL >= 6 { 0x1_0000 } else { 0 }
    }

    fn wakes_after(&self, ticks: u64, periods: u64) -> u64 {
        if self.cr & WUCKSEL < 4 {
            return ticks + periods * (16 >> (self.cr & WUCKSEL));
        }
        let (fraction, second) = self.prescalers();
        self.began + (self.fractions(ticks) / second + periods) * fraction * second
    }

    /// Plans both alarms after a store.
    fn plan(&mut self, ticks: u64) {
        for n in 0..2 {
            let is_on = self.cr & ALRAE << n != 0 && self.initialising.is_none();
            self.next[n] = is_on.then(|| self.next_match(n, ticks)).flatten();
        }
    }

    /// The first count after `ticks` that makes an alarm match.
    fn next_match(&self, n: usize, ticks: u64) -> Option<u64> {
        let date = Date::from_registers(self.set.0, self.set.1)?;
        let (fraction, second) = self.prescalers();
        let passed = self.fractions(ticks);
        let register = self.alarm_fractions[n];
        let mask = (1_u64 << (register >> 24)).min(1 << 15) - 1;
        // Without mask it is the count of the second that raises it.
        let matches = |at: &u64| mask == 0 || (second - 1 - at) & mask == u64::from(register) & mask;
        let mut from = passed / second;
        for _ in 0..3 {
            let hit = self.alarms[n].next(date, from)?;
            let in_second = (0..if mask == 0 { 1 } else { second }).filter(matches);
            let hits = in_second.map(|at| hit * second + at).find(|at| *at > passed);
            if let Some(at) = hits {
                return Some(self.began + at * fraction);
            }
            from = hit + 1;
        }
        None
    }

    /// Raises the flags that are due.
    pub fn catch_up(&mut self, now: Time) {
        if self.next == [None; 3] {
            return;
        }
        let ticks = self.ticks(now);
        for n in 0..3 {
            let Some(due) = self.next[n].filter(|due| *due <= ticks) else { continue };
            self.flags |= ALRAF << n;
            self.next[n] = if n < 2 {
                self.next_match(n, ticks)
            } else {
                let every = self.wakes_after(due, self.wakes_every()) - due;
                Some(due + ((ticks - due) / every + 1) * every)
            };
        }
    }

    /// Lines of EXTI that are high.
    pub fn lines(&self) -> u32 {
        let alarm = (0..2).any(|n| self.flags & ALRAF << n != 0 && self.cr & ALRAIE << n != 0);
        let wake_up = self.flags & WUTF != 0 && self.cr & WUTIE != 0;
        [(alarm, ALARM_LINE), (wake_up, WAKE_UP_LINE)]
            .iter()
            .filter(|(is, _)| *is)
            .map(|(_, line)| line)
            .sum()
    }

    /// When a line next rises.
    pub fn next_event(&self) -> Option<Time> {
        let clock = self.clock?;
        let waits = |n: &usize| self.cr & ALRAIE << n != 0 && self.flags & ALRAF << n == 0;
        let due = (0..3).filter(waits).filter_map(|n| self.next[n]).min()?;
        Some(clock.time_of(due.saturating_sub(self.counted)))
    }
}
