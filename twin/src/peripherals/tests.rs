//! The bus in front of the peripherals.

use super::bench::{Bench, RCC};
use super::*;
use crate::memory::Memory;
use crate::part::tests::part;

#[test]
fn nothing_answers_where_no_peripheral_is_modelled() {
    let mut bench = Bench::pyboard();
    for address in [0x4000_2C00, 0x4000_7400, 0x4002_3850 - 4, 0x5000_0000] {
        assert_eq!(bench.load(address, Width::Word), Err(Refusal::Unmodelled));
    }
}

#[test]
fn a_block_without_clock_refuses() {
    let mut bench = Bench::pyboard();
    let moder = 0x4002_0400;
    assert_eq!(bench.load(moder, Width::Word), Err(Refusal::ClockOff));
    bench.write(RCC + 0x30, 1 << 1);
    assert_eq!(bench.read(moder), 0x280);
}

/// Sets wait states and the PLL (2 MHz times `n`, by 2), then the system clock with APB1 at HCLK / 2^`apb1` and APB2 at
/// HCLK / 2.
fn run_at(Bench { peripherals, .. }: &mut Bench, m: u32, n: u32, apb1: u32) -> Result<(), Refusal> {
    let (starts, runs) = (Now::default(), Now { cycle: 100_000, time: Time::from_us(10_000) });
    let mut write = |now, address, value| peripherals.write(now, address, Width::Word, value);
    write(starts, 0x4002_3C00, 0x705)?;
    write(starts, RCC + 0x04, 7 << 24 | 1 << 22 | n << 6 | m)?;
    // HSEON, HSEBYP as the oscillator of the board asks for, PLLON.
    let bypass = if m == 4 { 1 << 18 } else { 0 };
    write(starts, RCC, 1 << 24 | 1 << 16 | bypass | 0x83)?;
    write(runs, RCC + 0x08, 4 << 13 | (3 + apb1) << 10 | 2)
}

/// DS8626 table 14: 168, 42 and 84 MHz; RM0390 5.1.4: 180 MHz needs over-drive; general operating conditions of DS9405 and
/// DS11189: the same.
#[test]
fn clocks_above_the_limits_of_the_part_are_refused() {
    const PWR_CR: u32 = 0x4000_7000;
    let (one_scale, scale_1, scale_3, over_drive) = (1 << 14, 0b11 << 14, 0b01 << 14, 0b11 << 16);
    let (pyboard, nucleo) = (Model::shipped("pyboard-v11"), Model::shipped("nucleo-f446re"));
    let [f427, f479] = ["STM32F427VI", "STM32F479NI"].map(|name| Model { part: part(name), ..pyboard });
    for (model, m, cr, n, apb1, is_allowed) in [
        (pyboard, 6, one_scale, 168, 2, true),
        (pyboard, 6, one_scale, 180, 2, false),
        (pyboard, 6, one_scale, 168, 1, false),
        (nucleo, 4, scale_1, 168, 2, true),
        (nucleo, 4, scale_3, 168, 2, false),
        (nucleo, 4, scale_1, 180, 2, false),
        (nucleo, 4, scale_1 | over_drive, 180, 2, true),
        (f427, 6, scale_1, 180, 2, false),
        (f427, 6, scale_1 | over_drive, 180, 2, true),
        (f479, 6, scale_1, 180, 2, false),
        (f479, 6, scale_1 | over_drive, 180, 2, true),
    ] {
        let mut bench = Bench::of(model);
        bench.set_up([(RCC + 0x40, 1 << 28), (PWR_CR, cr)]);
        let expected = if is_allowed { Ok(()) } else { Err(Refusal::ClockLimit) };
        let done = run_at(&mut bench, m, n, apb1);
        assert_eq!(done, expected, "{}: PWR_CR {cr:X}h, {n} MHz, APB1 by 2^{apb1}", model.part);
    }
}

#[test]
fn can_takes_words_only() {
    let mut bench = Bench::pyboard();
    bench.write(RCC + 0x40, 1 << 25);
    assert_eq!(bench.load(0x4000_6400, Width::Half), Err(Refusal::Width));
    assert_eq!(bench.read(0x4000_6400), 0x0001_0002);
}

#[test]
fn a_byte_store_to_a_port_keeps_its_neighbours() {
    let mut bench = Bench::pyboard();
    bench.write(RCC + 0x30, 1);
    bench.store(0x4002_0000, Width::Byte, 0x55).unwrap();
    assert_eq!(bench.read(0x4002_0000), 0xA800_0055);
}

/// HALs write the top byte of RCC_CR separately, and vendor code the bytes of RCC_CFGR.
#[test]
fn a_byte_store_to_rcc_keeps_its_neighbours() {
    use Width::{Byte, Half, Word};
    let mut bench = Bench::pyboard();
    let ahb1enr = RCC + 0x30;
    for (offset, width, value, expected) in
        [(0, Word, 0x0010_0001, 0x0010_0001), (1, Byte, 0x80, 0x0010_8001), (2, Half, 0x0020, 0x0020_8001)]
    {
        bench.store(ahb1enr + offset, width, value).unwrap();
        assert_eq!(bench.read(ahb1enr), expected, "offset {offset}");
    }
}

/// RM0090 2.1: a bridge writes a byte or half-word to the whole register, duplicated.
#[test]
fn a_narrow_store_to_apb_is_duplicated() {
    use Width::{Byte, Half};
    let mut bench = Bench::pyboard();
    bench.write(RCC + 0x44, 1 << 14);
    let exticr1 = 0x4001_3808;
    for (offset, width, value, expected) in [
        (0, Byte, 0x12, 0x1212_1212),
        (3, Byte, 0x34, 0x3434_3434),
        (0, Half, 0x5678, 0x5678_5678),
        (2, Half, 0x9ABC, 0x9ABC_9ABC),
    ] {
        bench.store(exticr1 + offset, width, value).unwrap();
        assert_eq!(bench.read(exticr1), expected, "offset {offset}");
    }
}

/// A half-word store of the key, as the manual allows.
#[test]
fn half_words_start_the_watchdog() {
    let mut bench = Bench::pyboard();
    bench.store(0x4000_3000, Width::Half, 0xCCCC).unwrap();
    assert!(bench.peripherals.watchdog_deadline().is_some());
}

/// Given an error flag in the low byte, when the other byte of SR is stored to, then the flag stays.
#[test]
fn a_byte_store_to_flash_sr_clears_no_other_flag() {
    let mut bench = Bench::pyboard();
    let (keyr, sr) = (0x4002_3C04, 0x4002_3C0C);
    for key in [0x4567_0123, 0xCDEF_89AB] {
        bench.write(keyr, key);
    }
    // Programming without PG: PGSERR, bit 7.
    bench.store(0x080E_0000, Width::Byte, 0).unwrap();
    assert_eq!(bench.read(sr), 0x80);
    bench.store(sr + 1, Width::Byte, 0xFF).unwrap();
    assert_eq!(bench.read(sr), 0x80);
    bench.store(sr, Width::Byte, 0x80).unwrap();
    assert_eq!(bench.read(sr), 0);
}

#[test]
fn the_wire_sees_a_controller_only_behind_its_pins() {
    let mut bench = Bench::pyboard();
    bench.set_up([(RCC + 0x40, 1 << 25), (RCC + 0x30, 1 << 1)]);
    assert!(bench.peripherals.can_line(Side::Can1).is_none());
    bench.write(0x4002_0424, 0x99);
    bench.write(0x4002_0400, 0x000A_0280);
    assert!(bench.peripherals.can_line(Side::Can1).is_some());
}

#[test]
fn an_rcc_reset_returns_a_block_to_its_reset_state() {
    let mut bench = Bench::pyboard();
    bench.write(RCC + 0x40, 1);
    bench.store(0x4000_0028, Width::Half, 83).unwrap();
    bench.write(RCC + 0x20, 1);
    assert_eq!(bench.read(0x4000_0028), 0);
}

#[test]
fn the_f446_has_no_port_i_and_its_own_identity() {
    let mut f446 = Bench::of(Model::shipped("nucleo-f446re"));
    f446.write(RCC + 0x30, 0x1FF);
    let mut read = |address| f446.load(address, Width::Word);
    assert_eq!(read(0x4002_1C00), Ok(0), "port H");
    assert_eq!(read(0x4002_2000), Err(Refusal::Unmodelled), "port I");
    assert_eq!(read(0xE004_2000).map(|id| id & 0xFFF), Ok(0x421));
    assert_eq!(read(0x1FFF_7A20).map(|size| size >> 16), Ok(512));
}

/// Uses the accesses and widths of embassy-stm32 0.6 when it sets up a ring of captures: timer, input capture, ring
/// buffer, start.
#[test]
fn the_hals_way_to_a_ring_of_captures_is_accepted() {
    use Width::{Half, Word};
    const TIM5: u32 = 0x4000_0C00;
    const DMA1: u32 = 0x4002_6000;
    let mut bench = Bench::pyboard();
    bench.set_up([(RCC + 0x30, 1 << 21), (RCC + 0x40, 1 << 3), (RCC + 0x20, 1 << 3), (RCC + 0x20, 0)]);
    let cr = 6 << 25 | 3 << 16 | 2 << 13 | 2 << 11 | 1 << 10 | 1 << 8 | 0b111 << 2;
    for (address, width, value) in [
        (TIM5, Word, 0),
        (TIM5 + 0x28, Half, 0),
        (TIM5 + 0x14, Word, 1),
        (TIM5 + 0x2C, Word, u32::MAX),
        (TIM5, Word, 1 << 2),
        (TIM5, Word, 0),
        (TIM5, Word, 1),
        (TIM5 + 0x18, Word, 0x0001),
        (TIM5 + 0x20, Word, 0x000A),
        (TIM5 + 0x20, Word, 0x000B),
        (TIM5 + 0x0C, Word, 1 << 9),
        // HTIF, TCIF, TEIF of stream 2; its addresses, length, direct mode, configuration, start.
        (DMA1 + 0x08, Word, 1 << 19 | 1 << 20 | 1 << 21),
        (DMA1 + 0x48, Word, TIM5 + 0x34),
        (DMA1 + 0x4C, Word, 0x2000_0000),
        (DMA1 + 0x44, Word, 64),
        (DMA1 + 0x54, Word, 0),
        (DMA1 + 0x40, Word, cr),
        (DMA1 + 0x40, Word, cr | 1),
    ] {
        assert_eq!(bench.store(address, width, value), Ok(()), "{address:08X}h");
    }
    assert_eq!(bench.read(DMA1 + 0x40), cr | 1);
    assert_eq!(bench.read(DMA1 + 0x44), 64);
}

/// Uses the accesses of embassy-stm32 0.6 for a watchdog.
#[test]
fn the_hals_watchdog_is_accepted() {
    const IWDG: u32 = 0x4000_3000;
    let mut bench = Bench::pyboard();
    bench.set_up([(IWDG, 0x5555), (IWDG + 0x04, 2), (IWDG + 0x08, 0x3E7), (IWDG, 0xCCCC), (IWDG, 0xAAAA)]);
}

/// A pyboard whose wire of CAN1 ends at channel `n` of TIM5, 0 to 3, and that of CAN2 at the next one.
fn capturing(n: usize) -> Bench {
    let pyboard = Model::shipped("pyboard-v11");
    let capture = Some([CAPTURE_PINS[n], CAPTURE_PINS[(n + 1) % 4]]);
    Bench::of(Model { pins: Pins { capture, ..pyboard.pins }, ..pyboard })
}

/// RM0090 table 42: TIM5_CH1 asks stream 2, CH2 stream 4, CH3 stream 0, CH4 streams 1 and 3, all on channel 6; no other pair moves
/// them.
#[test]
fn a_request_reaches_its_stream_on_its_channel() {
    const TIM5: u32 = 0x4000_0C00;
    const DMA1: u32 = 0x4002_6000;
    let streams: [&[u32]; 4] = [&[2], &[4], &[0], &[1, 3]];
    for (n, streams) in streams.into_iter().enumerate() {
        for stream in 0..8 {
            for channel in 0..8 {
                let mut bench = capturing(n);
                let mut memory = Memory::new(bench.peripherals.part, &[]);
                bench.write(RCC + 0x30, 1 << 21 | 1);
                bench.write(RCC + 0x40, 1 << 3);
                let base = DMA1 + 0x10 + stream * 0x18;
                bench.set_up([
                    (0x4002_0020, 0x2222),
                    (0x4002_0000, 0x0000_00AA),
                    (TIM5 + 0x18, 0x0101),
                    (TIM5 + 0x1C, 0x0101),
                    (TIM5 + 0x20, 0xBBBB),
                    (TIM5 + 0x0C, 0xF << 9),
                    (base + 0x08, TIM5 + 0x34 + 4 * n as u32),
                    (base + 0x0C, 0x2000_0000),
                    (base + 0x04, 1),
                    (base, channel << 25 | 2 << 11 | 1),
                ]);
                bench.peripherals.capture_edge(Side::Can1, 10, false);
                let moved = bench.peripherals.transfer(Now { cycle: 20, time: Time::ZERO }, &mut memory);
                let expected = channel == 6 && streams.contains(&stream);
                assert_eq!(moved, expected, "TIM5_CH{} stream {stream} channel {channel}", n + 1);
            }
        }
    }
}

#[test]
fn edge_is_captured_only_by_a_pin_in_its_alternate_function() {
    let (moder, afrl, tim5) = (0x4002_0000, 0x4002_0020, 0x4000_0C00);
    for n in 0..4 {
        let mut bench = capturing(n);
        bench.write(RCC + 0x30, 1);
        bench.write(RCC + 0x40, 1 << 3);
        bench.set_up([(tim5 + 0x18, 0x0101), (tim5 + 0x1C, 0x0101), (tim5 + 0x20, 0xBBBB)]);
        let mut captured = |mode: u32, function: u32, level: bool| {
            bench.write(moder, mode << (2 * n));
            bench.write(afrl, function << (4 * n));
            bench.peripherals.capture_edge(Side::Can1, 10, level);
            let high = bench.peripherals.pin_level(Pin::new('A', n as u8));
            assert_eq!(high, level, "the pin itself follows");
            // CC1IF to CC4IF.
            bench.read(tim5 + 0x10) & 0x1E
        };
        assert_eq!(captured(0, 2, true), 0, "an input");
        assert_eq!(captured(2, 1, false), 0, "another alternate function");
        assert_eq!(captured(2, 2, true), 1 << (n + 1), "TIM5_CH{}", n + 1);
    }
}

/// TIM3 outputs one pulse of 1000 counts on channel 4 whenever OC3REF of TIM5 rises; TIM5 matches at 5000. `mode` is
/// that of PB1 in MODER, `function` its alternate function.
fn with_a_pulse(mode: u32, function: u32) -> Bench {
    const TIM3: u32 = 0x4000_0400;
    const TIM5: u32 = 0x4000_0C00;
    let mut bench = Bench::pyboard();
    bench.write(RCC + 0x30, 1 << 1);
    bench.write(RCC + 0x40, 1 << 1 | 1 << 3);
    bench.set_up([
        (0x4002_0420, function << 4),
        (0x4002_0400, 0x280 | mode << 2),
        (TIM3 + 0x2C, 1000),
        (TIM3 + 0x40, 1),
        (TIM3 + 0x1C, 0b111 << 12),
        (TIM3 + 0x20, 1 << 12),
        (TIM3 + 0x08, 2 << 4 | 0b110),
        (TIM3, 1 << 3),
        (TIM5 + 0x04, 0b110 << 4),
        (TIM5 + 0x3C, 5000),
        (TIM5 + 0x1C, 0b001 << 4),
        (TIM5, 1),
    ]);
    bench
}

fn timed(pin: Pin, cycle: u64, high: bool) -> TimedChange {
    TimedChange { cycle, pin, high }
}

#[test]
fn tim5_starts_a_pulse_of_tim3_at_its_pin() {
    let Bench { mut peripherals, .. } = with_a_pulse(2, 2);
    let at = |cycle| Now { cycle, time: Time::ZERO };
    let pin = Pin::new('B', 1);
    assert_eq!(peripherals.next_timer_event(at(0)), Some(5000));
    peripherals.irq_levels(at(5000));
    assert_eq!(peripherals.next_timer_event(at(5000)), Some(5004));
    peripherals.irq_levels(at(5004));
    assert_eq!(peripherals.next_timer_event(at(5004)), Some(5005));
    assert!(!peripherals.pin_level(pin));
    peripherals.irq_levels(at(5005));
    assert!(peripherals.pin_level(pin));
    peripherals.irq_levels(at(100_000));
    assert_eq!(peripherals.take_timed_changes(), [timed(pin, 5005, true), timed(pin, 6005, false)]);
    assert_eq!(peripherals.next_timer_event(at(100_000)), None);
}

#[test]
fn a_pulse_needs_its_pin_and_both_clocks() {
    for (mode, function) in [(0, 2), (1, 2), (3, 2), (2, 1)] {
        let Bench { mut peripherals, .. } = with_a_pulse(mode, function);
        peripherals.run_timers(100_000);
        assert_eq!(peripherals.take_timed_changes(), [], "mode {mode} function {function}");
        assert!(!peripherals.pin_level(Pin::new('B', 1)));
    }
    let mut bench = with_a_pulse(2, 2);
    bench.write(RCC + 0x40, 1 << 3);
    let Bench { mut peripherals, .. } = bench;
    peripherals.run_timers(100_000);
    assert_eq!(peripherals.take_timed_changes(), [], "TIM3 has no clock");
}

/// Given a pin that both harness and timer drive, then the timer wins. Another pin of the channel is unchanged.
#[test]
fn a_timer_wins_over_the_harness() {
    let Bench { mut peripherals, .. } = with_a_pulse(2, 2);
    peripherals.drive(Pin::new('B', 1), Some(true));
    assert!(!peripherals.pin_level(Pin::new('B', 1)));
    peripherals.run_timers(5500);
    assert!(!peripherals.pin_level(Pin::new('C', 9)));
}

#[test]
fn a_reset_ends_a_pulse() {
    let Bench { mut peripherals, .. } = with_a_pulse(2, 2);
    peripherals.run_timers(5500);
    assert!(peripherals.pin_level(Pin::new('B', 1)));
    peripherals.reset(Time::ZERO, ResetCause::Pin);
    peripherals.run_timers(5600);
    assert!(!peripherals.pin_level(Pin::new('B', 1)));
    assert_eq!(peripherals.next_timer_event(Now { cycle: 5600, time: Time::ZERO }), None);
}
