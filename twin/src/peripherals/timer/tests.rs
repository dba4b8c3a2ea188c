//! Behaviour of the timers as RM0090 chapter 18 describes it.

use super::*;

impl Timer {
    /// Returns whether update or compare raises an interrupt line at `cycle`.
    fn irq(&mut self, cycle: u64) -> bool {
        self.irqs(cycle).contains(&true)
    }
}

fn long() -> Timer {
    Timer::new(Kind { bits: 32, trigger: None, drives_pins: true, channels: 4, is_advanced: false }, 1)
}

/// Stores with the width that the register has.
fn put(tim: &mut Timer, cycle: u64, offset: u32, value: u32) {
    let width = if matches!(offset, CNT | ARR | CCR1..=CCR4) { Width::Word } else { Width::Half };
    tim.write(cycle, offset, width, value & crate::mmio::mask(width)).unwrap();
}

/// Stores to several registers at one cycle.
fn set_up<const N: usize>(tim: &mut Timer, cycle: u64, registers: [(u32, u32); N]) {
    registers.into_iter().for_each(|(offset, value)| put(tim, cycle, offset, value));
}

/// 84 timer clocks per count at two HCLK cycles each: 168 cycles per count, as on the board at 1 MHz.
fn at_1_mhz() -> Timer {
    let mut tim = long();
    tim.set_divider(0, 2);
    set_up(&mut tim, 0, [(PSC, 83), (ARR, 0xFFFF), (CR1, URS), (EGR, UIF), (CR1, CEN)]);
    tim
}

#[test]
fn counts_microseconds_and_wraps_at_the_reload_value() {
    let mut tim = at_1_mhz();
    assert_eq!(tim.read(168 * 1000 + 167, CNT), Ok(1000));
    assert_eq!(tim.read(168 * 65_536, CNT), Ok(0));
    assert_eq!(tim.read(168 * 65_537, CNT), Ok(1));
}

#[test]
fn a_compare_match_raises_its_interrupt_at_the_exact_cycle() {
    let mut tim = at_1_mhz();
    set_up(&mut tim, 0, [(CCR1 + 4, 500), (DIER, 1 << 2)]);
    assert_eq!(tim.next_event(0), Some(168 * 500));
    assert!(!tim.irq(168 * 500 - 1));
    assert!(tim.irq(168 * 500));
}

#[test]
fn status_flags_clear_by_writing_zero() {
    let mut tim = at_1_mhz();
    set_up(&mut tim, 0, [(CCR1, 10), (CCR1 + 4, 20)]);
    assert_eq!(tim.read(168 * 30, SR).unwrap() & 0b110, 0b110);
    put(&mut tim, 168 * 30, SR, !0b010);
    assert_eq!(tim.read(168 * 31, SR).unwrap() & 0b110, 0b100);
}

#[test]
fn the_update_flag_rises_at_the_wrap_and_again_one_period_later() {
    let mut tim = at_1_mhz();
    put(&mut tim, 0, DIER, UIF);
    assert_eq!(tim.next_event(0), Some(168 * 65_536));
    assert!(tim.irq(168 * 65_536));
    put(&mut tim, 168 * 65_536, SR, !UIF);
    assert!(!tim.irq(168 * 65_536));
    assert_eq!(tim.next_event(168 * 65_536), Some(168 * 131_072));
}

#[test]
fn a_new_prescaler_waits_for_the_update_event() {
    let mut tim = at_1_mhz();
    put(&mut tim, 0, PSC, 167);
    assert_eq!(tim.read(168 * 65_535, CNT), Ok(65_535));
    assert_eq!(tim.read(168 * 65_536 + 336 * 7, CNT), Ok(7));
}

#[test]
fn a_reset_leaves_the_clock_alone() {
    let mut tim = at_1_mhz();
    tim.reset();
    put(&mut tim, 1000, CR1, CEN);
    assert_eq!(tim.read(1000 + 2 * 50, CNT), Ok(50));
}

/// RM0090 18.4.5, CC1IF: beyond the reload value the flag rises at the overflow.
#[test]
fn compare_value_beyond_reload_value_matches_at_the_overflow() {
    let mut tim = at_1_mhz();
    set_up(&mut tim, 0, [(CCR1, 0x1_0000), (DIER, 1 << 1)]);
    assert_eq!(tim.next_event(0), Some(168 * 65_536));
}

/// 84 MHz, one count per two HCLK cycles, free running over 32 bits; channels 1 and 2 capture both edges of their own
/// inputs.
fn capturing() -> Timer {
    let mut tim = long();
    tim.set_divider(0, 2);
    set_up(&mut tim, 0, [(CCMR1, 0x0101), (CCER, 0x00BB), (CR1, CEN)]);
    tim
}

#[test]
fn the_status_register_shows_a_capture_until_its_value_is_read() {
    let mut tim = capturing();
    tim.edge(0, 1001, false);
    // CC1IF is bit 1.
    assert_eq!(tim.read(2000, SR).unwrap() & 0b110, 0b010);
    assert_eq!(tim.read(2000, CCR1), Ok(500));
    assert_eq!(tim.read(2000, SR).unwrap() & 0b110, 0);
    assert_eq!(tim.read(2000, CCR1), Ok(500), "the value stays");
}

#[test]
fn a_second_capture_before_the_first_was_read_is_an_overcapture() {
    let mut tim = capturing();
    tim.edge(1, 1000, false);
    tim.edge(1, 1400, true);
    // CC2IF is bit 2, CC2OF bit 10.
    assert_eq!(tim.read(2000, SR).unwrap() & 0x1E06, 1 << 10 | 1 << 2);
    assert_eq!(tim.read(2000, CCR1 + 4), Ok(700), "the newest value");
    assert_eq!(tim.read(2000, SR).unwrap() & 0x1E06, 1 << 10, "only software clears CC2OF");
    put(&mut tim, 2000, SR, !(1 << 10));
    assert_eq!(tim.read(2000, SR).unwrap() & 0x1E06, 0);
}

/// RM0090 18.4.9: CCxNP/CCxP 00 rising, 01 falling, 11 both.
#[test]
fn the_polarity_selects_the_edge() {
    for (ccer, on_rising, on_falling) in [(0b0001, true, false), (0b0011, false, true), (0b1011, true, true)]
    {
        for (level, expected) in [(true, on_rising), (false, on_falling)] {
            let mut tim = capturing();
            put(&mut tim, 0, CCER, ccer);
            tim.edge(0, 100, level);
            assert_eq!(tim.read(200, SR).unwrap() & 0b10 != 0, expected, "CCER {ccer:04b} level {level}");
        }
    }
}

#[test]
fn the_reserved_polarity_is_refused() {
    let mut tim = capturing();
    assert_eq!(tim.write(0, CCER, Width::Half, 0b1001), Err(Refusal::Misuse));
}

#[test]
fn a_disabled_channel_captures_nothing() {
    let mut tim = capturing();
    put(&mut tim, 0, CCER, 0x00B0);
    tim.edge(0, 100, true);
    assert_eq!((tim.read(200, SR).unwrap() & 0b10, tim.read(200, CCR1)), (0, Ok(0)));
}

/// RM0090 18.4.7, CC1S = 10: IC1 is mapped on TI2, for the other edge of the same line.
#[test]
fn a_channel_can_listen_to_its_neighbours_input() {
    let mut tim = capturing();
    set_up(&mut tim, 0, [(CCER, 0), (CCMR1, 0x0102), (CCER, 0x0031)]);
    tim.edge(1, 200, true);
    tim.edge(1, 400, false);
    tim.edge(0, 600, true);
    assert_eq!((tim.read(1000, CCR1), tim.read(1000, CCR1 + 4)), (Ok(100), Ok(200)));
}

/// ICxPSC = 01: a capture once every two events.
#[test]
fn the_prescaler_skips_events() {
    let mut tim = capturing();
    put(&mut tim, 0, CCMR1, 0x0105);
    tim.edge(0, 200, false);
    assert_eq!(tim.read(300, SR).unwrap() & 0b10, 0);
    tim.edge(0, 400, true);
    assert_eq!(tim.read(500, CCR1), Ok(200));
}

#[test]
fn the_mapping_of_a_channel_changes_only_while_it_is_off() {
    let mut tim = capturing();
    put(&mut tim, 0, CCMR1, 0x0000);
    assert_eq!(tim.read(0, CCMR1), Ok(0x0101));
    set_up(&mut tim, 0, [(CCER, 0x00B0), (CCMR1, 0x0000)]);
    assert_eq!(tim.read(0, CCMR1), Ok(0x0100));
}

#[test]
fn a_capture_register_cannot_be_written() {
    let mut tim = capturing();
    put(&mut tim, 0, CCR1, 77);
    assert_eq!(tim.read(0, CCR1), Ok(0));
}

#[test]
fn an_edge_in_the_past_has_the_count_of_its_own_instant() {
    let mut tim = capturing();
    assert_eq!(tim.read(100_000, CNT), Ok(50_000));
    tim.edge(0, 99_000, true);
    assert_eq!(tim.read(100_000, CCR1), Ok(49_500));
    // Also when the clock tree has changed since.
    tim.set_divider(100_000, 4);
    tim.edge(0, 100_200, true);
    assert_eq!(tim.read(100_400, CCR1), Ok(50_050));
}

#[test]
fn an_edge_before_the_channel_was_set_up_is_not_its_own() {
    let mut tim = long();
    set_up(&mut tim, 1000, [(CCMR1, 0x01), (CR1, CEN)]);
    put(&mut tim, 1200, CCER, 0b1011);
    assert!(!tim.edge(0, 1199, true));
    assert_eq!(tim.read(1300, SR).unwrap() & 0b10, 0);
    tim.edge(0, 1200, false);
    assert_eq!(tim.read(1300, CCR1), Ok(200));
}

#[test]
fn captures_interrupt_and_ask_for_dma_where_enabled() {
    let mut tim = capturing();
    assert!(!tim.edge(0, 100, true), "nobody is told");
    assert!(!tim.irq(200));
    tim.read(200, CCR1).unwrap();
    // CC1DE is bit 9, CC2IE bit 2.
    put(&mut tim, 200, DIER, 1 << 9 | 1 << 2);
    assert!(tim.edge(0, 300, false));
    assert_eq!((tim.requests, tim.irq(300)), (1, false));
    assert!(tim.edge(1, 310, false));
    assert_eq!((tim.requests, tim.irq(310)), (1, true));
    tim.requests &= !1;
    assert_eq!(tim.requests, 0);
}

#[test]
fn a_request_goes_away_with_its_enable() {
    let mut tim = capturing();
    put(&mut tim, 0, DIER, 1 << 9);
    tim.edge(0, 100, true);
    put(&mut tim, 200, DIER, 0);
    assert_eq!(tim.requests, 0);
}

#[test]
fn a_compare_match_asks_for_dma_every_time() {
    let mut tim = at_1_mhz();
    set_up(&mut tim, 0, [(CCR1 + 8, 500), (DIER, 1 << 11)]);
    assert_eq!(tim.next_event(0), Some(168 * 500));
    assert!(!tim.irq(168 * 500));
    assert_eq!(tim.requests, 1 << 2);
    tim.requests &= !(1 << 2);
    assert_eq!(tim.next_event(168 * 500), Some(168 * (65_536 + 500)), "with CC3IF still set");
    tim.irq(168 * (65_536 + 500));
    assert_eq!(tim.requests, 1 << 2);
}

#[test]
fn software_can_capture() {
    let mut tim = capturing();
    put(&mut tim, 1000, EGR, 1 << 1);
    assert_eq!((tim.read(1000, SR).unwrap() & 0b10, tim.read(1100, CCR1)), (0b10, Ok(500)));
}

#[test]
fn the_counter_wraps_at_32_bits_under_capture() {
    let mut tim = capturing();
    put(&mut tim, 0, CNT, 0xFFFF_FFF0);
    tim.edge(0, 2 * 0x0F, true);
    assert_eq!(tim.read(2 * 0x0F, CCR1), Ok(0xFFFF_FFFF));
    tim.edge(0, 2 * 0x10, false);
    assert_eq!(tim.read(2 * 0x10, CCR1), Ok(0));
}

#[test]
fn the_exact_count_is_that_of_captures_and_a_part() {
    let tim = at_1_mhz();
    for (cycle, exact) in [(0, 0.0), (84, 0.5), (168 * 1000, 1000.0), (168 * 1000 + 42, 1000.25)] {
        assert_eq!(tim.exact_count(cycle), exact, "cycle {cycle}");
    }
}

/// RM0090 18.4: 32-bit registers are written by words, the others by half-words or words.
#[test]
fn a_store_has_the_width_of_its_register() {
    let mut tim = long();
    for offset in [CNT, ARR, CCR1, CCR4] {
        assert_eq!(tim.write(0, offset, Width::Half, 1), Err(Refusal::Width));
        assert_eq!(tim.write(0, offset, Width::Word, 0x1_0001), Ok(()));
        assert_eq!(tim.read(0, offset), Ok(0x1_0001));
    }
    assert_eq!(tim.write(0, PSC, Width::Half, 83), Ok(()));
    assert_eq!(tim.write(0, PSC, Width::Byte, 83), Err(Refusal::Width));
}

#[test]
fn what_is_not_modelled_is_refused() {
    let mut tim = long();
    // DIR; MMS: enable; TI1S; SMS: reset, trigger without a source, MSM; UDE, TIE; TRC on channel 2; OC1FE, OC1CE.
    for (offset, value) in [
        (CR1, 1 << 4),
        (CR2, 1 << 4),
        (CR2, 1 << 7),
        (SMCR, 4),
        (SMCR, 2 << 4 | 6),
        (SMCR, 1 << 7),
        (DIER, 1 << 8),
        (DIER, 1 << 6),
        (CCMR1, 0x0300),
        (CCMR1, 0x0004),
        (CCMR1, 0x0080),
        (CCMR1, 0x0011),
        (CCMR1, 0xF100),
    ] {
        assert_eq!(tim.write(0, offset, Width::Half, value), Err(Refusal::Unmodelled), "{offset:X}h");
    }
}

/// A 16-bit timer that ITR2 can start, at one HCLK cycle per count.
fn short() -> Timer {
    Timer::new(Kind { bits: 16, trigger: Some(2), drives_pins: true, channels: 4, is_advanced: false }, 1)
}

/// CCMR2 for channel 4 in an output mode.
fn mode_4(mode: u32) -> u32 {
    mode << 12
}

const CC4E: u32 = 1 << 12;
const CC4P: u32 = 1 << 13;

#[test]
fn a_16_bit_timer_wraps_at_16_bits_and_takes_half_words() {
    let mut tim = short();
    assert_eq!(tim.read(0, ARR), Ok(0xFFFF));
    assert_eq!(tim.write(0, CCR4, Width::Half, 77), Ok(()));
    assert_eq!(tim.write(0, CNT, Width::Word, 0xABCD_FFFE), Ok(()));
    put(&mut tim, 0, CR1, CEN);
    assert_eq!([0, 1, 2].map(|cycle| tim.read(cycle, CNT)), [Ok(0xFFFE), Ok(0xFFFF), Ok(0)]);
}

/// RM0090 18.4.7, OC1M: the reference for each mode before, at and after the first match, and after the second.
#[test]
fn an_output_follows_its_mode() {
    let (low, high) = (Some(false), Some(true));
    for (mode, expected) in [
        (0b000, [low, low, low, low]),
        (0b001, [low, high, high, high]),
        (0b010, [low, low, low, low]),
        (0b011, [low, high, high, low]),
        (0b100, [low, low, low, low]),
        (0b101, [high, high, high, high]),
        (0b110, [high, low, low, low]),
        (0b111, [low, high, high, high]),
    ] {
        let mut tim = short();
        set_up(&mut tim, 0, [(CCR4, 100), (CCMR2, mode_4(mode)), (CCER, CC4E), (CR1, CEN)]);
        let levels = [99, 100, 101, 0x1_0000 + 100].map(|cycle| {
            tim.catch_up(cycle);
            tim.output(3)
        });
        assert_eq!(levels, expected, "mode {mode:03b}");
    }
}

#[test]
fn an_output_that_is_active_becomes_inactive_on_match() {
    let mut tim = short();
    set_up(&mut tim, 0, [(CCER, CC4E), (CCMR2, mode_4(0b101)), (CCR4, 100)]);
    set_up(&mut tim, 0, [(CCMR2, mode_4(0b010)), (CR1, CEN)]);
    tim.catch_up(0x1_0000);
    let changes = [(0, 3, Some(false)), (0, 3, Some(true)), (100, 3, Some(false))];
    assert_eq!(tim.take_changes(), changes);
}

/// PWM mode 1: active from the return to zero to the match, every period.
#[test]
fn a_pwm_output_changes_twice_a_period() {
    let mut tim = short();
    set_up(&mut tim, 0, [(ARR, 999), (CCR4, 400), (CCMR2, mode_4(0b110)), (CCER, CC4E | CC4P), (CR1, CEN)]);
    assert_eq!(tim.next_event(0), Some(400));
    tim.catch_up(2000);
    let cycles: Vec<_> = tim.take_changes().into_iter().map(|(at, _, level)| (at, level)).collect();
    let (low, high) = (Some(false), Some(true));
    assert_eq!(cycles, [(0, low), (400, high), (1000, low), (1400, high), (2000, low)], "active low");
}

#[test]
fn outputs_that_match_together_change_together() {
    let mut tim = short();
    set_up(&mut tim, 0, [(CCR4 - 4, 10), (CCR4, 10), (CCMR2, 0x3030), (CCER, CC4E | 1 << 8)]);
    tim.take_changes();
    put(&mut tim, 0, CR1, CEN);
    tim.catch_up(0x1_0000 + 9);
    assert_eq!(tim.take_changes(), [(10, 2, Some(true)), (10, 3, Some(true))]);
}

/// RM0090 18.3.10: the counter stops at the update event.
#[test]
fn one_pulse_mode_stops_at_the_reload() {
    let mut tim = short();
    set_up(&mut tim, 0, [(ARR, 500), (CR1, OPM | CEN)]);
    assert_eq!((tim.read(500, CR1), tim.read(500, CNT)), (Ok(OPM | CEN), Ok(500)));
    assert_eq!((tim.read(501, CR1), tim.read(501, CNT)), (Ok(OPM), Ok(0)));
    assert_eq!(tim.read(10_000, CNT), Ok(0));
    put(&mut tim, 20_000, CR1, OPM | CEN);
    assert_eq!(tim.read(20_007, CNT), Ok(7));
}

/// Returns a timer that outputs one pulse after its trigger.
fn one_pulse(compare: u32) -> Timer {
    let mut tim = short();
    set_up(&mut tim, 0, [(ARR, 1000), (CCR4, compare), (CCMR2, mode_4(0b111)), (CCER, CC4E)]);
    set_up(&mut tim, 0, [(SMCR, 2 << 4 | TRIGGER_MODE), (CR1, OPM)]);
    tim.take_changes();
    tim
}

/// RM0090 18.4.7, OC1FE: from an edge of the trigger to the output are at least five clocks.
#[test]
fn a_trigger_starts_a_pulse_five_clocks_later() {
    let mut tim = one_pulse(1);
    assert_eq!(tim.next_event(0), None);
    tim.trigger(2000);
    assert_eq!((tim.read(2001, CR1), tim.read(2001, SR).unwrap() & TIF), (Ok(OPM | CEN), TIF));
    tim.catch_up(9_000);
    let changes = [(2005, 3, Some(true)), (2000 + 4 + 1001, 3, Some(false))];
    assert_eq!(tim.take_changes(), changes);
    assert_eq!(tim.read(9_000, CR1), Ok(OPM), "stopped");
    // Once more.
    tim.trigger(10_000);
    tim.catch_up(10_006);
    assert_eq!(tim.take_changes(), [(10_005, 3, Some(true))]);
}

#[test]
fn trigger_has_no_effect_while_running_or_without_trigger_mode() {
    let mut tim = one_pulse(1);
    tim.trigger(2000);
    tim.trigger(2500);
    tim.catch_up(9_000);
    assert_eq!(tim.take_changes().len(), 2);
    put(&mut tim, 9_000, SMCR, 0);
    tim.trigger(10_000);
    tim.catch_up(20_000);
    assert_eq!(tim.take_changes(), []);
}

#[test]
fn a_stop_before_the_counter_began_calls_the_pulse_off() {
    let mut tim = one_pulse(1);
    tim.trigger(2000);
    put(&mut tim, 2002, CR1, OPM);
    tim.catch_up(9_000);
    assert_eq!(tim.take_changes(), []);
}

/// MMS 100 to 111: OC1REF to OC4REF is the trigger output (RM0090 18.4.2). It rises at the match, once until it is inactive again.
#[test]
fn a_match_raises_the_trigger_output() {
    for (mms, compare, modes, shift) in [
        (0b100, CCR1, CCMR1, 4),
        (0b101, CCR1 + 4, CCMR1, 12),
        (0b110, CCR1 + 8, CCMR2, 4),
        (0b111, CCR1 + 12, CCMR2, 12),
    ] {
        let mut tim = at_1_mhz();
        tim.take_rises();
        set_up(&mut tim, 0, [(CR2, mms << 4), (compare, 500), (modes, 0b001 << shift)]);
        assert_eq!(tim.next_event(0), Some(168 * 500), "MMS {mms:03b}");
        tim.catch_up(168 * 200_000);
        assert_eq!(tim.take_rises(), [168 * 500], "MMS {mms:03b}");
        assert_eq!(tim.next_event(168 * 200_000), None, "MMS {mms:03b}: it is high");
        set_up(&mut tim, 168 * 200_000, [(modes, 0b100 << shift), (modes, 0b001 << shift)]);
        tim.catch_up(168 * 300_000);
        assert_eq!(tim.take_rises(), [168 * (3 * 65_536 + 500 + 65_536)], "MMS {mms:03b}");
    }
}

/// MMS 000: UG is the trigger output.
#[test]
fn an_update_by_software_raises_the_trigger_output() {
    let mut tim = long();
    put(&mut tim, 70, EGR, UIF);
    assert_eq!(tim.take_rises(), [70]);
}

/// MMS selects a reference that is high already.
#[test]
fn the_trigger_output_rises_when_it_is_selected() {
    let mut tim = long();
    put(&mut tim, 0, CCMR2, 0b101 << 4);
    put(&mut tim, 50, CR2, 0b110 << 4);
    assert_eq!(tim.take_rises(), [50]);
}

#[test]
fn an_output_without_a_modelled_pin_is_refused() {
    let mut tim =
        Timer::new(Kind { bits: 32, trigger: None, drives_pins: false, channels: 4, is_advanced: false }, 1);
    assert_eq!(tim.write(0, CCER, Width::Half, 1), Err(Refusal::Unmodelled));
}
