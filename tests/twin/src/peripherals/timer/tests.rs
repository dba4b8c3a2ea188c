//! Behaviour of the timers as RM0090 chapter 18 describes it.

use super::*;

/// Stores with the width that the register has.
fn put(tim: &mut Timer, cycle: u64, offset: u32, value: u32) {
    let width = if matches!(offset, CNT | ARR | CCR1..=CCR4) { Width::Word } else { Width::Half };
    tim.write(cycle, offset, width, value & width.mask()).unwrap();
}

/// 84 timer clocks per count at two HCLK cycles each: 168 cycles per count, as on the board at 1 MHz.
fn at_1_mhz() -> Timer {
    let mut tim = Timer::default();
    tim.set_divider(0, 2);
    put(&mut tim, 0, PSC, 83);
    put(&mut tim, 0, ARR, 0xFFFF);
    put(&mut tim, 0, CR1, URS);
    put(&mut tim, 0, EGR, UIF);
    put(&mut tim, 0, CR1, CEN);
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
    put(&mut tim, 0, CCR1 + 4, 500);
    put(&mut tim, 0, DIER, 1 << 2);
    assert_eq!(tim.next_event(0), Some(168 * 500));
    assert!(!tim.irq(168 * 500 - 1));
    assert!(tim.irq(168 * 500));
}

#[test]
fn status_flags_clear_by_writing_zero() {
    let mut tim = at_1_mhz();
    put(&mut tim, 0, CCR1, 10);
    put(&mut tim, 0, CCR1 + 4, 20);
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
fn a_compare_value_beyond_the_reload_value_matches_at_the_overflow() {
    let mut tim = at_1_mhz();
    put(&mut tim, 0, CCR1, 0x1_0000);
    put(&mut tim, 0, DIER, 1 << 1);
    assert_eq!(tim.next_event(0), Some(168 * 65_536));
}

/// 84 MHz, one count per two HCLK cycles, free running over 32 bits; channels 1 and 2 capture both edges of their own
/// inputs.
fn capturing() -> Timer {
    let mut tim = Timer::default();
    tim.set_divider(0, 2);
    put(&mut tim, 0, CCMR1, 0x0101);
    put(&mut tim, 0, CCER, 0x00BB);
    put(&mut tim, 0, CR1, CEN);
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
    put(&mut tim, 0, CCER, 0);
    put(&mut tim, 0, CCMR1, 0x0102);
    put(&mut tim, 0, CCER, 0x0031);
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
    put(&mut tim, 0, CCER, 0x00B0);
    put(&mut tim, 0, CCMR1, 0x0000);
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
    let mut tim = Timer::default();
    put(&mut tim, 1000, CCMR1, 0x01);
    put(&mut tim, 1000, CR1, CEN);
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
    assert_eq!((tim.requests(), tim.irq(300)), (1, false));
    assert!(tim.edge(1, 310, false));
    assert_eq!((tim.requests(), tim.irq(310)), (1, true));
    tim.acknowledge(1);
    assert_eq!(tim.requests(), 0);
}

#[test]
fn a_request_goes_away_with_its_enable() {
    let mut tim = capturing();
    put(&mut tim, 0, DIER, 1 << 9);
    tim.edge(0, 100, true);
    put(&mut tim, 200, DIER, 0);
    assert_eq!(tim.requests(), 0);
}

#[test]
fn a_compare_match_asks_for_dma_every_time() {
    let mut tim = at_1_mhz();
    put(&mut tim, 0, CCR1 + 8, 500);
    put(&mut tim, 0, DIER, 1 << 11);
    assert_eq!(tim.next_event(0), Some(168 * 500));
    assert!(!tim.irq(168 * 500));
    assert_eq!(tim.requests(), 1 << 2);
    tim.acknowledge(1 << 2);
    assert_eq!(tim.next_event(168 * 500), Some(168 * (65_536 + 500)), "with CC3IF still set");
    tim.irq(168 * (65_536 + 500));
    assert_eq!(tim.requests(), 1 << 2);
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
    let mut tim = Timer::default();
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
    let mut tim = Timer::default();
    // OPM, DIR; MMS; SMS; UDE, TIE; TRC on channel 2.
    for (offset, value) in [
        (CR1, 1 << 3),
        (CR1, 1 << 4),
        (CR2, 1 << 4),
        (SMCR, 4),
        (DIER, 1 << 8),
        (DIER, 1 << 6),
        (CCMR1, 0x0300),
    ] {
        assert_eq!(tim.write(0, offset, Width::Half, value), Err(Refusal::Unmodelled), "{offset:X}h");
    }
}
