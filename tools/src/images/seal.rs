//! The *seal* of a program: its length, and a word with which its CRC is zero. The running image checks its flash by it.
//!
//! `ecss-can-stm32f4` reserves eight bytes of flash under the name `__program_seal`. The linker leaves them erased. The
//! seal is written here, into each image that this program builds. The CRC is that of the CRC unit of the chip
//! (CRC-32/MPEG-2 of the words) from 0800 0000h to the end of the last segment. Gaps between segments, and the rest of the last line of
//! four words, count as erased flash.

use std::ops::Range;

use crc::{CRC_32_MPEG_2, Crc};
use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol};

const SYMBOL: &str = "__program_seal";
/// Length and balance, little-endian.
const BYTES: usize = 8;
const WORD: usize = 4;
const LINE: usize = 16;
const FLASH: u64 = 0x0800_0000;
/// The largest flash of a chip.
const FLASH_BYTES: usize = 2 << 20;

/// Writes the seal into an ELF file. A file that is no image, or one that reserves no seal, stays unchanged.
pub(in crate::images) fn write(elf: &mut [u8]) {
    if let Some((place, seal)) = seal(elf) {
        elf[place].copy_from_slice(&seal);
    }
}

/// Returns the place of the seal in an ELF file, and its value.
fn seal(elf: &[u8]) -> Option<(Range<usize>, [u8; BYTES])> {
    let file = ElfFile32::<Endianness>::parse(elf).ok()?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(SYMBOL))?;
    let at = usize::try_from(symbol.address().checked_sub(FLASH)?).ok()?;
    let (endian, mut flash, mut place) = (file.endian(), Vec::new(), None);
    for header in file.elf_program_headers().iter().filter(|header| header.p_type(endian) == PT_LOAD) {
        let content = header.data(endian, elf).ok()?;
        if content.is_empty() {
            continue;
        }
        let from = usize::try_from(u64::from(header.p_paddr(endian)).checked_sub(FLASH)?).ok()?;
        let to = from.checked_add(content.len()).filter(|to| *to <= FLASH_BYTES)?;
        if flash.len() < to {
            flash.resize(to, 0xFF);
        }
        flash[from..to].copy_from_slice(content);
        if from <= at && at + BYTES <= to {
            let offset = header.p_offset(endian) as usize + at - from;
            place = Some(offset..offset + BYTES);
        }
    }
    let place = place?;
    flash.resize(flash.len().next_multiple_of(LINE), 0xFF);
    let bytes = (flash.len() as u32).to_le_bytes();
    flash[at..at + WORD].copy_from_slice(&bytes);
    let balance = balance(&flash, at + WORD).to_le_bytes();
    Some((place, [bytes, balance].concat().try_into().ok()?))
}

/// Returns the word at the offset `at` with which the CRC of all words is zero.
fn balance(flash: &[u8], at: usize) -> u32 {
    let word = |word: &[u8]| word.iter().rfold(0, |word, byte| word << 8 | u32::from(*byte));
    let (before, behind) = (&flash[..at], &flash[at + WORD..]);
    let crc = Crc::<u32>::new(&CRC_32_MPEG_2);
    let mut digest = crc.digest();
    before.chunks(WORD).for_each(|bytes| digest.update(&word(bytes).to_be_bytes()));
    // Backwards from the zero at the end: the CRC before each word.
    let wanted = behind.rchunks(WORD).fold(0, |crc, bytes| before_word(crc) ^ word(bytes));
    digest.finalize() ^ before_word(wanted)
}

/// Returns the CRC before a word of zeros that leads to `crc`.
fn before_word(crc: u32) -> u32 {
    (0..u32::BITS).fold(crc, |crc, _| match crc & 1 {
        0 => crc >> 1,
        _ => (crc ^ CRC_32_MPEG_2.poly) >> 1 | 1 << 31,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of headers: of the file and of two segments.
    const HEADERS: u32 = 52 + 2 * 32;
    const ERASED: [u8; BYTES] = [0xFF; BYTES];

    fn words(words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// An ELF file with two segments, each at an address of flash and, behind the first, another one in RAM; and with a symbol.
    fn elf(segments: [(u32, &[u8]); 2], symbol: (&str, u32)) -> Vec<u8> {
        let [(_, first), (_, second)] = segments;
        let behind = (HEADERS + (first.len() + second.len()) as u32).next_multiple_of(4);
        let strings = format!("\0{}\0", symbol.0);
        let sections = (behind + 32 + strings.len() as u32).next_multiple_of(4);
        let mut file = [&b"\x7FELF\x01\x01\x01"[..], &[0; 9], &[2, 0, 40, 0]].concat();
        file.extend(words(&[1, 0x0800_0001, 52, sections, 0]));
        // Sizes and numbers: of this header, of segments, of sections; section with names.
        file.extend([52_u16, 32, 2, 40, 3, 2].into_iter().flat_map(u16::to_le_bytes));
        let mut offset = HEADERS;
        for ((load, content), run) in segments.into_iter().zip([segments[0].0, 0x2000_0000]) {
            let length = content.len() as u32;
            file.extend(words(&[PT_LOAD, offset, run, load, length, length, 5, 4]));
            offset += length;
        }
        file.extend([first, second].concat());
        file.resize(behind as usize, 0);
        // The empty symbol, and a global variable in the section 1.
        file.extend(words(&[0, 0, 0, 0, 1, symbol.1, BYTES as u32, 1 << 16 | 0x11]));
        file.extend(strings.as_bytes());
        file.resize(sections as usize, 0);
        file.extend([0; 40]);
        file.extend(words(&[0, 2, 0, 0, behind, 32, 2, 1, 4, 16]));
        file.extend(words(&[0, 3, 0, 0, behind + 32, strings.len() as u32, 0, 0, 1, 0]));
        file
    }

    /// Bytes of words as the CRC unit takes them, the highest byte first.
    fn as_words(bytes: &[u8]) -> Vec<u8> {
        bytes.chunks(4).flat_map(|word| word.iter().rev().copied()).collect()
    }

    fn crc(bytes: &[u8]) -> u32 {
        Crc::<u32>::new(&CRC_32_MPEG_2).checksum(&as_words(bytes))
    }

    /// Given a program with its seal in the middle, and a last line of two bytes, then the seal has the length in whole lines, the
    /// CRC with the seal is zero, and the rest is unchanged.
    #[test]
    fn program_with_its_seal_has_the_crc_zero() {
        let first = [b"1234", &ERASED[..], b"5678"].concat();
        let mut file = elf([(0x0800_0000, &first), (0x0800_0010, b"9A")], (SYMBOL, 0x0800_0004));
        let before = file.clone();
        write(&mut file);
        let at = HEADERS as usize + 4;
        assert_eq!(file[at..at + 4], [32, 0, 0, 0]);
        let flash = [&file[at - 4..at + BYTES + 4], b"9A", &[0xFF; 14]].concat();
        assert_eq!(crc(&flash), 0);
        file[at..at + BYTES].fill(0xFF);
        assert_eq!(file, before, "the rest is unchanged");
    }

    /// Given a program that ends with its seal, then the balance is the CRC of what is before it.
    #[test]
    fn balance_at_the_end_is_the_crc_before_it() {
        let first = [b"12345678", &ERASED[..]].concat();
        let mut file = elf([(0x0800_0000, &first), (0x2000_0000, &[])], (SYMBOL, 0x0800_0008));
        write(&mut file);
        let at = HEADERS as usize + 8;
        let balance = crc(b"12345678\x10\0\0\0").to_le_bytes();
        assert_eq!(file[at..at + BYTES], [&[16, 0, 0, 0], &balance[..]].concat());
    }

    /// Given a gap between two segments, then it counts as erased.
    #[test]
    fn gap_between_segments_counts_as_erased() {
        let first = [&ERASED[..], b"1234"].concat();
        let mut file = elf([(0x0800_0000, &first), (0x0800_0014, b"5678")], (SYMBOL, 0x0800_0000));
        write(&mut file);
        let at = HEADERS as usize;
        let flash = [&file[at..at + 12], &[0xFF; 8], b"5678", &[0xFF; 8]].concat();
        assert_eq!(file[at..at + 4], [32, 0, 0, 0]);
        assert_eq!(crc(&flash), 0);
    }

    /// Given a file without symbol, one whose symbol is in no segment, one for RAM, and none at all, then it stays unchanged.
    #[test]
    fn file_without_a_place_for_the_seal_stays_unchanged() {
        for (segments, symbol) in [
            ([(0x0800_0000, &ERASED[..]), (0x0800_0008, &[1])], ("__program", 0x0800_0000)),
            ([(0x0800_0000, &ERASED), (0x0800_0008, &[1])], (SYMBOL, 0x0800_0004)),
            ([(0x2000_0000, &ERASED), (0x2000_0008, &[1])], (SYMBOL, 0x2000_0000)),
            ([(0x0800_0000, &ERASED), (0x0A00_0000, &[1])], (SYMBOL, 0x0800_0000)),
        ] {
            let mut file = elf(segments, symbol);
            let before = file.clone();
            write(&mut file);
            assert_eq!(file, before, "{segments:X?}");
        }
        let mut text = *b"not an ELF file";
        write(&mut text);
        assert_eq!(&text, b"not an ELF file");
    }
}
