//! Sectors of the main memory and the duration of operations.
//!
//! Times are those of DS8626 and DS10693, tables "Flash memory programming": erasing goes by the parallelism in PSIZE,
//! programming takes the same for a byte and a word.

use std::ops::Range;

use crate::part::Part;
use crate::wire::time::Time;

const KIB: u32 = 1 << 10;
/// Four sectors of 16 KiB, one of 64 KiB, then only 128 KiB: in each bank.
const SMALL: u32 = 4;
/// Sectors of a bank of 1 MiB.
pub const IN_BANK: u32 = 12;
const BANK: u32 = 1024 * KIB;

/// Bytes and offset of a sector; `None` beyond the part's memory (RM0090 tables 5 and 6, RM0390 table 4, RM0386 chapter 3). Sectors from 12
/// on are in the second bank of a part with 2 MiB.
pub fn sector(part: Part, number: u32) -> Option<Range<u32>> {
    let base = number / IN_BANK * BANK;
    let range = match number % IN_BANK {
        n @ 0..SMALL => n * 16 * KIB..(n + 1) * 16 * KIB,
        SMALL => 64 * KIB..128 * KIB,
        n => (n - SMALL) * 128 * KIB..(n - SMALL + 1) * 128 * KIB,
    };
    let range = base + range.start..base + range.end;
    (range.end <= part.flash_bytes()).then_some(range)
}

/// The sector that SNB in CR names: 0 to 11, and from 16 on those of the second bank (RM0090 3.9.8).
pub fn sector_by_code(snb: u32) -> Option<u32> {
    match snb {
        0..IN_BANK => Some(snb),
        0x10..0x1C => Some(snb - 0x10 + IN_BANK),
        _ => None,
    }
}

/// Number of sectors.
pub fn sectors(part: Part) -> u32 {
    (0..2 * IN_BANK).filter(|number| sector(part, *number).is_some()).count() as u32
}

/// The number of the sector at this offset.
pub fn sector_of(part: Part, offset: u32) -> Option<u32> {
    (0..2 * IN_BANK).find(|number| sector(part, *number).is_some_and(|sector| sector.contains(&offset)))
}

/// Duration of programming and erasing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FlashSpeed {
    /// The typical times: 16 us for a word.
    #[default]
    Typical,
    /// The longest times: 100 us for a word, erasing twice the typical time.
    Slowest,
}

/// Programming one byte, half-word or word.
pub const fn program(speed: FlashSpeed) -> Time {
    match speed {
        FlashSpeed::Typical => Time::from_us(16),
        FlashSpeed::Slowest => Time::from_us(100),
    }
}

/// Erasing and programming the option bytes.
pub fn options(speed: FlashSpeed) -> Time {
    erase(speed, 16 * KIB, 2)
}

/// Erasing a sector of `bytes` at a parallelism of 8 << `psize` bits.
pub fn erase(speed: FlashSpeed, bytes: u32, psize: u32) -> Time {
    let by_parallelism = match bytes / KIB {
        16 => [400, 300, 250],
        64 => [1200, 700, 550],
        _ => [2000, 1300, 1000],
    };
    let ms = by_parallelism[psize.min(2) as usize];
    match speed {
        FlashSpeed::Typical => Time::from_ms(ms),
        FlashSpeed::Slowest => Time::from_ms(2 * ms),
    }
}
