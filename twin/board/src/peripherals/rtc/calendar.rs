//! Dates and times as the RTC counts them, and when an alarm next matches one.

/// Seconds of a day.
const DAY: u64 = 86_400;
/// The date that matches longest after another one: the 31st, from the 31st of July on or over February.
const LONGEST_WAIT_DAYS: u64 = 62;

/// A date and time from 2000 to 2099, in 24 hours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Date {
    /// 0 to 99.
    pub year: u32,
    /// 1 to 12.
    pub month: u32,
    /// 1 to 31.
    pub day: u32,
    /// 1 is Monday. The calendar counts it on its own: it need not suit the date.
    pub weekday: u32,
    /// Seconds since midnight.
    pub seconds: u64,
}

fn from_bcd(bcd: u32) -> u32 {
    (bcd >> 4) * 10 + (bcd & 0xF)
}

fn to_bcd(value: u32) -> u32 {
    (value / 10) << 4 | (value % 10)
}

fn days_of(year: u32, month: u32) -> u32 {
    match month {
        2 if year.is_multiple_of(4) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

impl Date {
    /// From TR and DR (RM0090 26.6.1, 26.6.2); `None` for a date that does not exist.
    pub fn from_registers(tr: u32, dr: u32) -> Option<Date> {
        let nibbles = [tr, tr >> 8, tr >> 16, dr, dr >> 8 & 0x1F, dr >> 16, dr >> 20];
        let (hour, minute, second) =
            (from_bcd(tr >> 16 & 0x3F), from_bcd(tr >> 8 & 0x7F), from_bcd(tr & 0x7F));
        let (year, month, day) = (from_bcd(dr >> 16 & 0xFF), from_bcd(dr >> 8 & 0x1F), from_bcd(dr & 0x3F));
        let weekday = dr >> 13 & 0b111;
        let exists = nibbles.iter().all(|nibble| nibble & 0xF < 10)
            && (hour < 24 && minute < 60 && second < 60)
            && ((1..=12).contains(&month) && year < 100 && weekday > 0)
            && (1..=days_of(year, month)).contains(&day);
        let seconds = u64::from(hour * 3600 + minute * 60 + second);
        exists.then_some(Date { year, month, day, weekday, seconds })
    }

    /// TR and DR.
    pub fn registers(self) -> (u32, u32) {
        let seconds = self.seconds as u32;
        let tr = to_bcd(seconds / 3600) << 16 | to_bcd(seconds / 60 % 60) << 8 | to_bcd(seconds % 60);
        let dr = to_bcd(self.year) << 16 | self.weekday << 13 | to_bcd(self.month) << 8 | to_bcd(self.day);
        (tr, dr)
    }

    /// This many seconds later. After 2099 comes 2000.
    pub fn after(mut self, seconds: u64) -> Date {
        let seconds = self.seconds + seconds;
        self.seconds = seconds % DAY;
        (0..seconds / DAY).for_each(|_| self.next_day());
        self
    }

    fn next_day(&mut self) {
        self.weekday = self.weekday % 7 + 1;
        self.day += 1;
        if self.day > days_of(self.year, self.month) {
            (self.day, self.month) = (1, self.month + 1);
        }
        if self.month > 12 {
            (self.month, self.year) = (1, (self.year + 1) % 100);
        }
    }
}

/// What an alarm compares: ALRMxR (RM0090 26.6.7).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Match(pub u32);

impl Match {
    const DAY: u32 = 1 << 31;
    const BY_WEEKDAY: u32 = 1 << 30;
    const HOUR: u32 = 1 << 23;
    const MINUTE: u32 = 1 << 15;
    const SECOND: u32 = 1 << 7;

    fn is(self, unless: u32, shift: u32, mask: u32, value: u32) -> bool {
        self.0 & unless != 0 || from_bcd(self.0 >> shift & mask) == value
    }

    fn takes_day(self, date: Date) -> bool {
        let weekday = self.0 & Self::BY_WEEKDAY != 0;
        self.is(
            Self::DAY,
            24,
            if weekday { 0xF } else { 0x3F },
            if weekday { date.weekday } else { date.day },
        )
    }

    /// Seconds from `date` to the first match that is not before `from` seconds after it; `None`: the registers match no time.
    pub fn next(self, date: Date, from: u64) -> Option<u64> {
        let start = date.after(from);
        let midnight = Date { seconds: 0, ..start };
        for day in 0..=LONGEST_WAIT_DAYS {
            if !self.takes_day(midnight.after(day * DAY)) {
                continue;
            }
            let first = if day == 0 { start.seconds } else { 0 };
            if let Some(second) = self.next_in_day(first) {
                return Some(from + day * DAY + second - start.seconds);
            }
        }
        None
    }

    fn next_in_day(self, first: u64) -> Option<u64> {
        for hour in (first / 3600..24).filter(|hour| self.is(Self::HOUR, 16, 0x3F, *hour as u32)) {
            for minute in (0..60).filter(|minute| self.is(Self::MINUTE, 8, 0x7F, *minute as u32)) {
                let begin = hour * 3600 + minute * 60;
                let mut seconds = (begin.max(first)..begin + 60).map(|at| (at, at % 60));
                let hit = seconds.find(|(_, second)| self.is(Self::SECOND, 0, 0x7F, *second as u32));
                if let Some((at, _)) = hit {
                    return Some(at);
                }
            }
        }
        None
    }
}
