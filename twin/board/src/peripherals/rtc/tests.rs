use super::*;

const LSI: RtcClock = RtcClock { hz: 32_000, divider: 1, since: Time::ZERO };
/// 2028-02-28, a Monday, 23:59:58.
const LEAP: (u32, u32) = (0x0023_5958, 0x0028_2228);

/// On LSI, prescaled by 125 and 256, set to `date`, from `from` on, registers open.
fn running(date: (u32, u32), from: Time) -> Rtc {
    let mut rtc = Rtc::default();
    rtc.set_clock(Time::ZERO, Some(LSI));
    open(&mut rtc, from);
    write(&mut rtc, from, ISR, INIT);
    let ready = from + ticks(2);
    assert_eq!(rtc.read(ready, ISR).unwrap() & INITF, INITF);
    for (offset, value) in [(PRER, 0x007C_00FF), (TR, date.0), (DR, date.1), (ISR, 0)] {
        write(&mut rtc, ready, offset, value);
    }
    rtc
}

/// Periods of RTCCLK.
fn ticks(n: u64) -> Time {
    Time(n * 10_500)
}

/// A second after the calendar of [`running`] began to count.
fn second(from: Time, n: u64) -> Time {
    from + ticks(2 + 4 + n * 32_000)
}

fn open(rtc: &mut Rtc, now: Time) {
    write(rtc, now, WPR, 0xCA);
    write(rtc, now, WPR, 0x53);
}

fn write(rtc: &mut Rtc, now: Time, offset: u32, value: u32) {
    rtc.write(now, offset, value, true).unwrap();
}

fn date(rtc: &mut Rtc, now: Time) -> (u32, u32) {
    (rtc.read(now, TR).unwrap(), rtc.read(now, DR).unwrap())
}

/// RM0090 26.6: the values after a reset of the backup domain.
#[test]
fn registers_begin_as_the_manual_says() {
    let mut rtc = Rtc::default();
    for (offset, value) in [(TR, 0), (DR, 0x2101), (CR, 0), (PRER, 0x007F_00FF), (WUTR, 0xFFFF), (ALRMAR, 0)]
    {
        assert_eq!(rtc.read(Time::ZERO, offset), Some(value), "{offset:X}h");
    }
    assert_eq!(rtc.read(Time::ZERO, ISR).unwrap() & !RSF, 0b111);
}

#[test]
fn calendar_counts_over_the_end_of_a_leap_february() {
    let mut rtc = running(LEAP, Time::ZERO);
    assert_eq!(date(&mut rtc, second(Time::ZERO, 1)), (0x0023_5959, 0x0028_2228));
    assert_eq!(date(&mut rtc, second(Time::ZERO, 2)), (0, 0x0028_4229));
    assert_eq!(date(&mut rtc, second(Time::ZERO, 2 + 86_400)), (0, 0x0028_6301));
    let mut rtc = running((0x0023_5959, 0x0099_F231), Time::ZERO);
    assert_eq!(date(&mut rtc, second(Time::ZERO, 1)), (0, 0x0000_2101));
}

/// SSR counts down from PREDIV_S.
#[test]
fn fractions_of_a_second_count_down() {
    let mut rtc = running(LEAP, Time::ZERO);
    let begin = ticks(6);
    assert_eq!(rtc.read(begin + ticks(124), SSR), Some(255));
    assert_eq!(rtc.read(begin + ticks(127), SSR), Some(254));
    assert_eq!(rtc.read(begin + ticks(31_999), SSR), Some(0));
}

/// RM0090 26.3.5: both keys in a row, and DBP.
#[test]
fn registers_are_closed_without_their_keys() {
    let mut rtc = Rtc::default();
    rtc.set_clock(Time::ZERO, Some(LSI));
    write(&mut rtc, Time::ZERO, ISR, INIT);
    assert_eq!(rtc.read(Time::from_ms(1), ISR).unwrap() & INIT, 0);
    write(&mut rtc, Time::ZERO, WPR, 0xCA);
    write(&mut rtc, Time::ZERO, WPR, 0xCA);
    write(&mut rtc, Time::ZERO, WPR, 0x53);
    write(&mut rtc, Time::ZERO, CR, BYPSHAD);
    assert_eq!(rtc.read(Time::ZERO, CR), Some(0));
    open(&mut rtc, Time::ZERO);
    rtc.write(Time::ZERO, CR, BYPSHAD, false).unwrap();
    assert_eq!(rtc.read(Time::ZERO, CR), Some(0));
    write(&mut rtc, Time::ZERO, CR, BYPSHAD);
    assert_eq!(rtc.read(Time::ZERO, CR), Some(BYPSHAD));
    write(&mut rtc, Time::ZERO, WPR, 0xFF);
    write(&mut rtc, Time::ZERO, CR, 0);
    assert_eq!(rtc.read(Time::ZERO, CR), Some(BYPSHAD));
}

/// A program that does not wait for INITF sets nothing; without RTCCLK it waits for ever.
#[test]
fn initialisation_takes_two_cycles() {
    let mut rtc = Rtc::default();
    open(&mut rtc, Time::ZERO);
    write(&mut rtc, Time::ZERO, ISR, INIT);
    assert_eq!(rtc.read(Time::from_ms(60_000), ISR).unwrap() & INITF, 0);
    rtc.set_clock(Time::from_ms(60_000), Some(LSI));
    write(&mut rtc, Time::from_ms(60_000), TR, 0x12_0000);
    assert_eq!(rtc.read(Time::from_ms(60_000), TR), Some(0));
    assert_eq!(rtc.read(Time::from_ms(60_000) + ticks(2), ISR).unwrap() & INITF, INITF);
}

#[test]
fn a_date_that_does_not_exist_is_misuse() {
    for date in
        [(0x24_0000, 0x2101), (0x60, 0x2101), (0x1A, 0x2101), (0, 0x2230), (0, 0x0101), (0, 0x3301 | 0x1000)]
    {
        let mut rtc = running(LEAP, Time::ZERO);
        write(&mut rtc, Time::ZERO, ISR, INIT);
        write(&mut rtc, ticks(9), TR, date.0);
        write(&mut rtc, ticks(9), DR, date.1);
        assert_eq!(rtc.write(ticks(9), ISR, 0, true), Err(Refusal::Misuse), "{date:X?}");
    }
}

/// RM0090 26.3.6: a load of SSR or TR locks what is higher until DR is read.
#[test]
fn a_read_of_the_time_locks_the_date() {
    let mut rtc = running(LEAP, Time::ZERO);
    let (before, after) = (second(Time::ZERO, 2) - ticks(10), second(Time::ZERO, 3));
    assert_eq!(rtc.read(before, TR), Some(0x0023_5959));
    assert_eq!(rtc.read(after, DR), Some(0x0028_2228));
    assert_eq!(rtc.read(after, DR), Some(0x0028_4229));
}

/// After a reset of the part the calendar counts on; the shadow registers have it two cycles later.
#[test]
fn a_reset_starts_the_shadow_registers_again() {
    let mut rtc = running(LEAP, Time::ZERO);
    let now = second(Time::ZERO, 2);
    rtc.reset(now);
    assert_eq!(date(&mut rtc, now), (0, 0x2101));
    assert_eq!(rtc.read(now, ISR).unwrap() & RSF, 0);
    assert_eq!(rtc.read(now + ticks(2), ISR).unwrap() & RSF, RSF);
    assert_eq!(date(&mut rtc, now + ticks(2)), (0, 0x0028_4229));
}

#[test]
fn an_alarm_matches_what_it_does_not_mask() {
    // Masks of day, hours, minutes, seconds; the weekday.
    for (register, seconds) in [
        (0x8080_8080, 1),
        (0x8080_8005, 7),
        (0x8080_0300, 2 + 180),
        (0x8001_0000, 2 + 3600),
        (0x0200_0000, 2 + 2 * 86_400),
        (0x4300_0000, 2 + 86_400),
        (0x3100_0000, 2 + 31 * 86_400),
    ] {
        let mut rtc = running(LEAP, Time::ZERO);
        write(&mut rtc, ticks(6), ALRMAR, register);
        write(&mut rtc, ticks(6), CR, ALRAE | ALRAIE);
        let at = second(Time::ZERO, seconds);
        assert_eq!(rtc.next_event(), Some(at), "{register:X}h");
        rtc.catch_up(at - Time(1));
        assert_eq!(rtc.lines(), 0);
        rtc.catch_up(at);
        assert_eq!((rtc.lines(), rtc.read(at, ISR).unwrap() & ALRAF), (1 << 17, ALRAF));
        write(&mut rtc, at, ISR, !ALRAF & !INIT);
        assert_eq!(rtc.lines(), 0);
    }
}

/// MASKSS 8: the lowest eight bits of SSR.
#[test]
fn an_alarm_matches_fractions_of_a_second() {
    let mut rtc = running(LEAP, Time::ZERO);
    write(&mut rtc, ticks(6), ALRMBR, 0x8080_8080);
    write(&mut rtc, ticks(6), ALRMBSSR, 8 << 24 | 100);
    write(&mut rtc, ticks(6), CR, (ALRAE | ALRAIE) << 1);
    // SSR is 100 after 155 counts of 125 periods.
    assert_eq!(rtc.next_event(), Some(ticks(6 + 155 * 125)));
    rtc.catch_up(ticks(6 + 155 * 125));
    assert_eq!(rtc.lines(), 1 << 17);
}

#[test]
fn an_alarm_takes_values_while_it_is_off() {
    let mut rtc = running(LEAP, Time::ZERO);
    write(&mut rtc, ticks(6), CR, ALRAE);
    assert_eq!(rtc.read(ticks(9), ISR).unwrap() & ALRAWF, 0);
    write(&mut rtc, ticks(9), ALRMAR, 5);
    assert_eq!(rtc.read(ticks(9), ALRMAR), Some(0));
    write(&mut rtc, ticks(9), CR, 0);
    assert_eq!(rtc.read(ticks(10), ISR).unwrap() & ALRAWF, 0);
    assert_eq!(rtc.read(ticks(11), ISR).unwrap() & ALRAWF, ALRAWF);
    write(&mut rtc, ticks(11), ALRMAR, 5);
    assert_eq!(rtc.read(ticks(11), ALRMAR), Some(5));
}

/// RM0090 26.3.6: WUTR + 1 periods of RTCCLK over 16 to 2, or of a second, with 10000h more behind WUCKSEL 11xb.
#[test]
fn the_wake_up_timer_raises_its_line_again_and_again() {
    for (select, periods) in [(0, 16 * 10), (3, 2 * 10), (4, 32_000 * 10), (6, 32_000 * (10 + 0x1_0000))] {
        let mut rtc = running(LEAP, Time::ZERO);
        write(&mut rtc, ticks(6), WUTR, 9);
        write(&mut rtc, ticks(6), CR, select | WUTE | WUTIE);
        for n in 1..4 {
            let at = ticks(6 + n * periods);
            assert_eq!(rtc.next_event(), Some(at), "WUCKSEL {select}");
            rtc.catch_up(at);
            assert_eq!(rtc.lines(), 1 << 22);
            write(&mut rtc, at, ISR, !WUTF & !INIT);
        }
    }
}

#[test]
fn what_the_calendar_lacks_is_refused() {
    for (offset, value) in [
        (CR, 1 << 6),
        (CR, 1 << 11),
        (CR, 1 << 23),
        (CR, 1 << 16),
        (CALR, 1),
        (CALIBR, 1),
        (TAFCR, 1),
        (0x2C, 1),
    ] {
        let mut rtc = running(LEAP, Time::ZERO);
        assert_eq!(rtc.write(ticks(9), offset, value, true), Err(Refusal::Unmodelled), "{offset:X}h");
    }
}
