//! The registers against RM0090 chapter 3.

use super::*;
use crate::part::tests::part;

const NOW: Time = Time::from_ms(5);
const X32: u32 = 0b10 << 8;

fn unlocked(part: Part) -> Flash {
    let mut flash = Flash::new(part, FlashSpeed::Typical);
    flash.write(NOW, KEYR, 0x4567_0123).unwrap();
    flash.write(NOW, KEYR, 0xCDEF_89AB).unwrap();
    flash
}

#[test]
fn the_lock_opens_to_both_keys_in_their_order_and_closes_again() {
    let mut flash = Flash::new(part("STM32F405RG"), FlashSpeed::Typical);
    assert_eq!(flash.read(CR), Some(0x8000_0000));
    assert_eq!(flash.write(NOW, CR, PG), Err(Refusal::Misuse));
    flash.write(NOW, KEYR, 0x4567_0123).unwrap();
    assert_eq!(flash.read(CR), Some(0x8000_0000));
    flash.write(NOW, KEYR, 0xCDEF_89AB).unwrap();
    assert_eq!(flash.read(CR), Some(0));
    flash.write(NOW, CR, 0x8000_0000).unwrap();
    assert_eq!(flash.read(CR), Some(0x8000_0000));
    assert_eq!(flash.program(NOW, 0, Width::Word, 0), Err(Refusal::Misuse));
}

#[test]
fn a_wrong_key_shuts_the_lock_until_reset() {
    for wrong in [[0xCDEF_89AB, 0x4567_0123], [0x4567_0123, 0x4567_0123]] {
        let mut flash = Flash::new(part("STM32F405RG"), FlashSpeed::Typical);
        let refused = wrong.map(|key| flash.write(NOW, KEYR, key).is_err());
        assert!(refused.contains(&true));
        for key in [0x4567_0123, 0xCDEF_89AB] {
            assert_eq!(flash.write(NOW, KEYR, key), Err(Refusal::Misuse));
        }
        assert_eq!(flash.read(CR), Some(0x8000_0000));
    }
}

/// Makes a flash with the option bytes unlocked.
fn with_options(part: Part) -> Flash {
    let mut flash = unlocked(part);
    flash.write(NOW, OPTKEYR, 0x0819_2A3B).unwrap();
    flash.write(NOW, OPTKEYR, 0x4C5D_6E7F).unwrap();
    flash
}

/// RM0090 3.7.2: a value written to OPTCR takes effect with OPTSTRT; a reset loads the programmed value.
#[test]
fn option_bytes_are_programmed_by_their_start_bit() {
    let mut flash = Flash::new(part("STM32F405RG"), FlashSpeed::Typical);
    assert_eq!(flash.read(OPTCR), Some(0x0FFF_AAED));
    assert_eq!(flash.write(NOW, OPTCR, 0x0FFF_AAE0), Err(Refusal::Misuse));
    let mut flash = with_options(part("STM32F405RG"));
    assert_eq!(flash.read(OPTCR), Some(0x0FFF_AAEC));
    flash.write(NOW, OPTCR, 0x0FFF_AAE0).unwrap();
    assert_eq!((flash.operation(), flash.watches()), (None, (false, false)));
    flash.reset();
    assert_eq!(flash.read(OPTCR), Some(0x0FFF_AAED), "nobody has programmed it");
    let mut flash = with_options(part("STM32F405RG"));
    flash.write(NOW, OPTCR, 0x0FFF_AAE0 | 1 << 1).unwrap();
    assert_eq!((flash.read(SR), flash.read(OPTCR)), (Some(1 << 16), Some(0x0FFF_AAE2)));
    assert_eq!(flash.write(NOW, OPTCR, 0x0FFF_AAEC), Err(Refusal::Misuse), "busy");
    assert_eq!(flash.finish(true), Some(Change::Options));
    flash.reset();
    assert_eq!((flash.read(OPTCR), flash.watches()), (Some(0x0FFF_AAE1), (true, false)));
    assert_eq!((flash.options(0), flash.options(8)), (Some(0xFFFF_AAE1), Some(0xFFFF_FFFF)));
}

#[test]
fn option_bytes_that_are_cut_off_stay_as_they_were() {
    let mut flash = with_options(part("STM32F446RE"));
    flash.write(NOW, OPTCR, 0x0FFF_AAC0 | 1 << 1).unwrap();
    flash.finish(false);
    flash.reset();
    assert_eq!((flash.read(OPTCR), flash.watches()), (Some(0x0FFF_AAED), (false, false)));
}

/// Sector 2 is neither programmed nor erased and sets WRPERR; other sectors are.
#[test]
fn a_protected_sector_raises_its_flag() {
    let mut flash = with_options(part("STM32F405RG"));
    flash.write(NOW, OPTCR, 0x0FFB_AAEC | 1 << 1).unwrap();
    flash.finish(true);
    flash.write(NOW, CR, PG | X32 | ERRIE).unwrap();
    flash.program(NOW, 0x8000, Width::Word, 0).unwrap();
    assert_eq!((flash.operation(), flash.read(SR), flash.irq()), (None, Some(1 << 4 | 1 << 1), true));
    flash.write(NOW, SR, u32::MAX).unwrap();
    flash.write(NOW, CR, SER | 2 << 3 | X32 | STRT).unwrap();
    assert_eq!((flash.operation(), flash.read(SR)), (None, Some(1 << 4)));
    flash.write(NOW, CR, SER | 3 << 3 | X32 | STRT).unwrap();
    assert!(flash.operation().is_some());
}

#[test]
fn levels_of_protection_that_cannot_be_left_are_refused() {
    let mut flash = with_options(part("STM32F405RG"));
    assert_eq!(flash.write(NOW, OPTCR, 0x0FFF_CCEC | 1 << 1), Err(Refusal::Irrevocable));
    let mut flash = with_options(part("STM32F405RG"));
    flash.write(NOW, OPTCR, 0x0FFF_55EC | 1 << 1).unwrap();
    flash.finish(true);
    assert_eq!(flash.write(NOW, OPTCR, 0x0FFF_AAEC | 1 << 1), Err(Refusal::Unmodelled), "a mass erase");
    // Reading protection of the F446, a sector that it lacks.
    for bits in [0x8FFF_AAEC, 0x0EFF_AAEC] {
        assert_eq!(with_options(part("STM32F446RE")).write(NOW, OPTCR, bits), Err(Refusal::Unmodelled));
    }
}

#[test]
fn a_word_takes_16_us_and_clears_bits_only() {
    let mut flash = unlocked(part("STM32F405RG"));
    flash.write(NOW, CR, PG | X32).unwrap();
    flash.program(NOW, 0xE_0004, Width::Word, 0x1234_5678).unwrap();
    assert_eq!(flash.read(SR), Some(1 << 16));
    let (change, ends) = flash.operation().unwrap().clone();
    assert_eq!(ends, NOW + Time::from_us(16));
    assert_eq!(change.range(), 0xE_0004..0xE_0008);
    // The second word comes too early.
    assert_eq!(flash.program(NOW, 0xE_0008, Width::Word, 0), Err(Refusal::Misuse));
    assert_eq!(flash.write(NOW, CR, 0), Err(Refusal::Misuse));
    let mut content = [0xFF, 0xF0, 0x0F, 0x00];
    flash.finish(true).unwrap().apply(&mut content);
    assert_eq!(content, [0x78, 0x50, 0x04, 0x00]);
    assert_eq!(flash.read(SR), Some(0), "EOP shows only where its interrupt is enabled");
}

/// DS8626 table 40: 100 us for a word, 2 s for 128 KiB at x32, also after resets.
#[test]
fn the_slowest_flash_takes_the_longest_times_of_the_data_sheet() {
    let mut flash = unlocked(part("STM32F405RG"));
    flash.speed = FlashSpeed::Slowest;
    flash.write(NOW, CR, PG | X32).unwrap();
    flash.program(NOW, 0, Width::Word, 0).unwrap();
    assert_eq!(flash.operation().unwrap().1, NOW + Time::from_us(100));
    flash.reset();
    flash.write(NOW, KEYR, 0x4567_0123).unwrap();
    flash.write(NOW, KEYR, 0xCDEF_89AB).unwrap();
    flash.write(NOW, CR, SER | STRT | 11 << 3 | X32).unwrap();
    assert_eq!(flash.operation().unwrap().1, NOW + Time::from_ms(2_000));
}

#[test]
fn wrong_programming_raises_its_flag_and_programs_nothing() {
    for (cr, offset, width, flag) in [
        (X32, 0, Width::Word, 1 << 7),
        (PG | SER | X32, 0, Width::Word, 1 << 7),
        (PG, 0, Width::Word, 1 << 6),
        (PG | X32, 0, Width::Byte, 1 << 6),
        (PG | 0b01 << 8, 0, Width::Word, 1 << 6),
        (PG | 0b11 << 8, 0, Width::Word, 1 << 6),
        (PG | X32, 14, Width::Word, 1 << 5),
    ] {
        let mut flash = unlocked(part("STM32F405RG"));
        flash.write(NOW, CR, cr).unwrap();
        flash.program(NOW, offset, width, 0).unwrap();
        assert_eq!(flash.read(SR), Some(flag), "CR {cr:X}h, {width:?} at {offset}");
        assert_eq!(flash.operation(), None);
        assert!(!flash.irq());
        flash.write(NOW, SR, flag).unwrap();
        assert_eq!(flash.read(SR), Some(0));
    }
}

#[test]
fn bytes_and_halves_are_programmed_at_their_parallelism() {
    for (psize, width) in [(0, Width::Byte), (1, Width::Half)] {
        let mut flash = unlocked(part("STM32F405RG"));
        flash.write(NOW, CR, PG | psize << 8).unwrap();
        flash.program(NOW, 0x100, width, 0x5A & crate::mmio::mask(width)).unwrap();
        let (_, ends) = flash.operation().unwrap();
        assert_eq!(*ends, NOW + Time::from_us(16));
    }
}

/// DS8626 "Flash memory programming": typical times of 128 KiB, 64 KiB and 16 KiB at x8, x16, x32.
#[test]
fn a_sector_is_erased_as_fast_as_its_parallelism() {
    for (snb, psize, ms) in [
        (11, 0, 2000),
        (11, 1, 1300),
        (11, 2, 1000),
        (4, 0, 1200),
        (4, 1, 700),
        (4, 2, 550),
        (3, 0, 400),
        (3, 1, 300),
        (3, 2, 250),
    ] {
        let mut flash = unlocked(part("STM32F405RG"));
        flash.write(NOW, CR, SER | snb << 3 | psize << 8).unwrap();
        flash.write(NOW, CR, SER | snb << 3 | psize << 8 | STRT).unwrap();
        assert_eq!(flash.read(CR).unwrap() & STRT, STRT);
        let (_, ends) = flash.operation().unwrap();
        assert_eq!(*ends, NOW + Time::from_ms(ms), "sector {snb} at x{}", 8 << psize);
    }
}

/// SNB names sectors 12 to 23, in the second bank of a part with 2 MiB, by 10h to 1Bh (RM0090 3.9.8). A part with less has none of them,
/// and SNB of an F405 has four bits.
#[test]
fn sectors_lie_where_the_manual_puts_them() {
    for (name, snb, expected) in [
        ("STM32F405RG", 0, Ok(0..0x4000)),
        ("STM32F405RG", 3, Ok(0xC000..0x1_0000)),
        ("STM32F405RG", 4, Ok(0x1_0000..0x2_0000)),
        ("STM32F405RG", 5, Ok(0x2_0000..0x4_0000)),
        ("STM32F405RG", 11, Ok(0xE_0000..0x10_0000)),
        ("STM32F405RG", 12, Err(Refusal::Misuse)),
        ("STM32F405RG", 0x10, Ok(0..0x4000)),
        ("STM32F407VG", 12, Err(Refusal::Misuse)),
        ("STM32F446RE", 7, Ok(0x6_0000..0x8_0000)),
        ("STM32F446RE", 8, Err(Refusal::Misuse)),
        ("STM32F446RC", 5, Ok(0x2_0000..0x4_0000)),
        ("STM32F446RC", 6, Err(Refusal::Misuse)),
        ("STM32F429ZI", 11, Ok(0xE_0000..0x10_0000)),
        ("STM32F429ZI", 12, Err(Refusal::Misuse)),
        ("STM32F429ZI", 0x10, Ok(0x10_0000..0x10_4000)),
        ("STM32F429ZI", 0x14, Ok(0x11_0000..0x12_0000)),
        ("STM32F429ZI", 0x1C, Err(Refusal::Misuse)),
        ("STM32F429ZG", 0x10, Err(Refusal::Misuse)),
        ("STM32F469NI", 0x1B, Ok(0x1E_0000..0x20_0000)),
    ] {
        let mut flash = unlocked(part(name));
        let erased = flash.write(NOW, CR, SER | snb << 3 | X32 | STRT);
        assert_eq!(erased.map(|()| flash.finish(true).unwrap().range()), expected, "{name}: {snb:X}h");
    }
}

/// Given a part with two banks, then operations that are not modelled are refused: mass erase (MER1), DB1M, BFB2 and
/// the protection of the second bank.
#[test]
fn operations_on_whole_banks_are_refused() {
    for bits in [MER1, MER | MER1] {
        let refusal = unlocked(part("STM32F429ZI")).write(NOW, CR, bits | STRT);
        assert_eq!(refusal, Err(Refusal::Unmodelled), "{bits:X}h");
    }
    for (offset, value) in [(OPTCR, 0x4FFF_AAEC), (OPTCR, 0x0FFF_AAFC), (0x18, 0x0FFF_0000)] {
        let refusal = with_options(part("STM32F429ZI")).write(NOW, offset, value);
        assert_eq!(refusal, Err(Refusal::Unmodelled), "{value:08X}h");
    }
}

#[test]
fn what_cannot_be_erased_is_refused() {
    for (cr, refusal) in [
        (STRT, Refusal::Misuse),
        (SER | MER | STRT, Refusal::Misuse),
        (SER | 0b11 << 8 | STRT, Refusal::Misuse),
        (MER | STRT, Refusal::Unmodelled),
    ] {
        assert_eq!(unlocked(part("STM32F405RG")).write(NOW, CR, cr), Err(refusal), "CR {cr:X}h");
    }
}

#[test]
fn the_interrupt_tells_ends_and_errors_where_enabled() {
    let mut flash = unlocked(part("STM32F405RG"));
    flash.write(NOW, CR, PG | X32 | EOPIE | ERRIE).unwrap();
    flash.program(NOW, 0, Width::Word, 0).unwrap();
    assert!(!flash.irq());
    flash.finish(true);
    assert_eq!((flash.read(SR), flash.irq()), (Some(1), true));
    flash.write(NOW, SR, 1).unwrap();
    assert!(!flash.irq());
    flash.program(NOW, 0, Width::Byte, 0).unwrap();
    assert_eq!((flash.read(SR), flash.irq()), (Some(1 << 6 | 1 << 1), true));
}

#[test]
fn caches_are_reset_only_while_they_are_off() {
    let mut flash = Flash::new(part("STM32F405RG"), FlashSpeed::Typical);
    flash.write(NOW, ACR, 0x705).unwrap();
    assert_eq!(flash.read(ACR), Some(0x705));
    assert_eq!(flash.write(NOW, ACR, 0x1505), Err(Refusal::Misuse));
    flash.write(NOW, ACR, 0x105).unwrap();
    flash.write(NOW, ACR, 0x1105).unwrap();
}
