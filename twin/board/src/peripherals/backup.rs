//! The backup domain: what clocks the RTC, and how its alarms reach EXTI.

use can_wire::time::Time;

use super::Peripherals;
use super::rtc::Rtc;

impl Peripherals {
    /// RCC or the watchdog was written: RTCCLK may be another one, and BDRST resets the RTC.
    pub(super) fn follow_backup_domain(&mut self, now: Time) {
        if self.rcc.resets_backup() {
            self.rtc = Rtc::default();
        }
        let (lsi_hz, lsi_runs) = self.iwdg.lsi();
        self.rtc.set_clock(now, self.rcc.rtc_clock(lsi_hz, lsi_runs));
    }

    /// Raises what the RTC raises by `now`.
    pub(super) fn follow_calendar(&mut self, now: Time) {
        self.rtc.catch_up(now);
        let lines = self.rtc.lines();
        self.exti.edges(std::mem::replace(&mut self.rtc_lines, lines), lines);
    }

    /// When the RTC next raises a line of EXTI.
    pub(crate) fn calendar_event(&self) -> Option<Time> {
        self.rtc.next_event()
    }
}
