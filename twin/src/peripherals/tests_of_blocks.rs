//! Timers, the backup domain and option bytes, register by register; and absent peripherals.

use super::bench::{Bench, RCC};
use super::*;

const TIM1: u32 = 0x4001_0000;
const TIM4: u32 = 0x4000_0800;
const TIM6: u32 = 0x4000_1000;
const TIM12: u32 = 0x4000_1800;
const PWR: u32 = 0x4000_7000;

/// A pyboard with every clock of APB1, APB2 and port A on.
fn bench() -> Bench {
    let mut bench = Bench::pyboard();
    bench.set_up([(RCC + 0x30, 1), (RCC + 0x34, 1 << 6)]);
    bench.set_up([(RCC + 0x40, u32::MAX), (RCC + 0x44, u32::MAX)]);
    bench
}

/// Update and compare are one line of TIM4, two of TIM1 (RM0090 table 61).
#[test]
fn timers_raise_their_lines() {
    for (timer, compare, update) in [(TIM4, 30, 30), (TIM1, 27, 25)] {
        let mut bench = bench();
        bench.set_up([(timer + 0x2C, 999), (timer + 0x34, 100), (timer + 0x0C, 0b10), (timer, 1)]);
        assert_eq!(bench.peripherals.next_timer_event(bench.now()), Some(100));
        bench.cycle = 100;
        assert_eq!(bench.irqs(), [compare], "{timer:08X}h");
        bench.write(timer + 0x10, 0);
        bench.write(timer + 0x0C, 1);
        bench.cycle = 1000;
        assert_eq!(bench.irqs(), [update], "{timer:08X}h");
    }
}

#[test]
fn a_timer_has_only_its_own_channels() {
    let mut bench = bench();
    for (timer, there, missing) in
        [(TIM6, 0x2C, 0x34), (TIM12, 0x38, 0x3C), (TIM4, 0x40, 0x44), (TIM1, 0x44, 0x50)]
    {
        assert_eq!(bench.store(timer + there, Width::Word, 5), Ok(()), "{timer:08X}h");
        assert_eq!(bench.store(timer + missing, Width::Word, 5), Err(Refusal::Unmodelled), "{timer:08X}h");
    }
}

/// The source of RTCCLK needs DBP and stays until BDRST.
#[test]
fn the_backup_domain_takes_stores_when_it_is_open() {
    const BDCR: u32 = RCC + 0x70;
    let mut bench = bench();
    bench.write(BDCR, 1 << 15 | 2 << 8);
    assert_eq!(bench.read(BDCR), 0, "DBP is off");
    bench.write(PWR, 0x4100);
    bench.write(BDCR, 1 << 15 | 2 << 8);
    bench.write(BDCR, 1 << 15 | 1 << 8);
    assert_eq!(bench.read(BDCR), 1 << 15 | 2 << 8, "LSI stays");
    bench.write(BDCR, 1 << 16);
    assert_eq!(bench.read(BDCR), 1 << 16);
}

/// Given peripherals that are not modelled, then each access is refused with the name of the peripheral.
#[test]
fn absent_peripherals_refuse_by_their_names() {
    let mut bench = bench();
    for (address, register) in [
        (0x4000_2800, "RTC.TR"),
        (0x4000_4400, "USART2.SR"),
        (0x4001_2000, "ADC1.SR"),
        (0x4001_3000, "SPI1.CR1"),
        (0x5006_0800, "RNG.CR"),
    ] {
        assert_eq!(bench.store(address, Width::Word, 0), Err(Refusal::Unmodelled), "{register}");
        assert_eq!(name(bench.peripherals.part, address).as_deref(), Some(register));
    }
}

/// Given the CRC unit with and without its clock, and a reset line, then it computes, refuses, and begins again. Its remainder takes
/// words alone.
#[test]
fn crc_unit_has_a_clock_and_a_reset() {
    let mut bench = Bench::pyboard();
    let (dr, ahb1enr, ahb1rstr) = (0x4002_3000, 0x4002_3830, 0x4002_3810);
    assert_eq!(bench.store(dr, Width::Word, 0), Err(Refusal::ClockOff));
    bench.store(ahb1enr, Width::Word, 1 << 12).unwrap();
    bench.store(dr, Width::Word, 0).unwrap();
    // Four bytes of zero, CRC-32/MPEG-2.
    assert_eq!(bench.read(dr), 0xC704_DD7B);
    assert_eq!(bench.store(dr, Width::Byte, 0), Err(Refusal::Width));
    bench.store(ahb1rstr, Width::Word, 1 << 12).unwrap();
    bench.store(ahb1rstr, Width::Word, 0).unwrap();
    assert_eq!(bench.read(dr), u32::MAX);
}

/// Given the CRC unit with its clock, then bits of the remainder and of the independent byte flip. Others, and all without clock, do not.
#[test]
fn bits_of_the_crc_unit_flip() {
    let mut bench = Bench::pyboard();
    let (dr, idr, cr) = (0x4002_3000, 0x4002_3004, 0x4002_3008);
    let flip = |bench: &mut Bench, address, bit| bench.peripherals.flip(bench.now(), address, bit);
    assert_eq!(flip(&mut bench, dr, 0), Err(Refusal::Unmodelled));
    bench.set_up([(RCC + 0x30, 1 << 12), (idr, 0x1A5)]);
    for (address, bit, flipped) in [(dr, 31, 0x7FFF_FFFF), (idr, 7, 0x25)] {
        assert_eq!(flip(&mut bench, address, bit), Ok(()));
        assert_eq!(bench.read(address), flipped);
    }
    for (address, bit) in [(idr, 8), (cr, 0)] {
        assert_eq!(flip(&mut bench, address, bit), Err(Refusal::Unmodelled));
    }
    bench.write(cr, 1);
    assert_eq!([dr, idr, cr].map(|address| bench.read(address)), [u32::MAX, 0x25, 0]);
}

/// WDG_SW clear: the watchdog runs from every reset on, with FFFh counts of 4 periods of 32 kHz.
#[test]
fn the_option_bytes_start_the_watchdog() {
    let mut bench = bench();
    assert_eq!(bench.read(0x1FFF_C000), 0xFFFF_AAED);
    assert_eq!(bench.store(0x1FFF_C000, Width::Word, 0), Err(Refusal::Unmodelled));
    bench.peripherals.flash.set_options(0x0FFF_AACC);
    assert_eq!(bench.peripherals.watchdog_deadline(), None);
    bench.peripherals.reset(Time::from_ms(100), ResetCause::Pin);
    assert_eq!(bench.peripherals.watchdog_deadline(), Some(Time::from_ms(612)));
}
