//! A firmware image: content of flash, symbols, log table.

mod places;

use std::collections::HashMap;
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::OnceLock;

use defmt_decoder::Table;
use object::{Object, ObjectSymbol, SymbolKind};

use crate::cpu::Code;
use crate::part::Part;

const FLASH_BASE: u64 = 0x0800_0000;
const FLASH_LEN: u64 = 1 << 20;
/// CCM and SRAM. The stack grows down from the end of one of them.
const RAM: RangeInclusive<u32> = 0x1000_0001..=0x3000_0000;
/// Absolute symbol of images that declare their chip. Its value is DEV_ID of DBGMCU_IDCODE.
const DEVICE_ID: &str = "__device_id";

/// Name, place and size of a variable or function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// First byte.
    pub address: u32,
    /// Bytes; zero for labels.
    pub size: u32,
}

/// A parsed ELF file. Boards share it.
#[derive(Default)]
pub struct Image {
    /// The ELF file, from which an image is identified by its hash.
    elf: Vec<u8>,
    flash: Vec<u8>,
    code: OnceLock<Code>,
    symbols: HashMap<String, Symbol>,
    /// Functions in the order of their addresses.
    functions: Vec<(Symbol, String)>,
    /// `None` for an image that does not log by defmt.
    log: Option<Result<Table, String>>,
}

/// Hint for an image that was built without linker script.
const LINKER_SCRIPT: &str = "addresses and vector table come from the linker script: add a build.rs with the link argument -Tlink.x to \
                             the package of the image";

/// Reason why a file is not a usable image.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// Not an ELF file, or a damaged one.
    #[error("not a usable ELF file: {0}")]
    Elf(object::Error),
    /// The file ends inside a segment.
    #[error("the ELF file ends inside a segment")]
    Truncated,
    /// A segment is loaded outside flash, at this address.
    #[error("a segment at {0:08X}h is outside the 1 MiB of flash at 0800 0000h; {script}", script = LINKER_SCRIPT)]
    OutsideFlash(u64),
    /// Flash does not begin with a vector table. The field is the number of bytes that are loaded into flash.
    #[error("no vector table at 0800 0000h, {0} bytes for flash; {script}", script = LINKER_SCRIPT)]
    NoVectorTable(usize),
}

/// Reason why an image cannot run on a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Misfit {
    /// It was linked for another chip.
    #[error(
        "the image was linked for DEV_ID {linked_for:03X}h ({lines}), the board has an {part} ({:03X}h)",
        .part.device_id(),
        lines = lines_with(*.linked_for)
    )]
    OtherChip {
        /// DEV_ID that it was linked for.
        linked_for: u32,
        /// The part of the board.
        part: Part,
    },
    /// It is larger than the flash.
    #[error("the image has {bytes} bytes, the board has an {part} with {} bytes of flash", .part.flash_bytes())]
    TooLarge {
        /// Size of the image, bytes.
        bytes: usize,
        /// The part of the board.
        part: Part,
    },
}

/// Names of the lines of parts with this DEV_ID.
fn lines_with(device_id: u32) -> String {
    let lines = Part::lines_with(device_id);
    if lines.is_empty() { "no part that the twin models".into() } else { lines.join(", ") }
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Image")
            .field("flash_bytes", &self.flash.len())
            .field("symbols", &self.symbols.len())
            .finish_non_exhaustive()
    }
}

impl Image {
    /// Parses an ELF file linked for flash at 0800 0000h.
    ///
    /// # Errors
    /// [`ImageError`], see there.
    pub fn parse(elf: &[u8]) -> Result<Image, ImageError> {
        let file = object::File::parse(elf).map_err(ImageError::Elf)?;
        let mut flash = Vec::new();
        for (address, content) in load_segments(elf)? {
            let end = address + content.len() as u64;
            if address < FLASH_BASE || end > FLASH_BASE + FLASH_LEN {
                return Err(ImageError::OutsideFlash(address));
            }
            let (from, to) = ((address - FLASH_BASE) as usize, (end - FLASH_BASE) as usize);
            if flash.len() < to {
                flash.resize(to, 0xFF);
            }
            flash[from..to].copy_from_slice(content);
        }
        if !has_vector_table(&flash) {
            return Err(ImageError::NoVectorTable(flash.len()));
        }
        let named = file.symbols().filter_map(|symbol| {
            let name = symbol.name().ok().filter(|name| !name.is_empty())?;
            let place = Symbol { address: symbol.address() as u32, size: symbol.size() as u32 };
            Some((symbol.kind(), format!("{:#}", rustc_demangle::demangle(name)), place))
        });
        let (mut symbols, mut functions) = (HashMap::new(), Vec::new());
        for (kind, name, place) in named {
            if kind == SymbolKind::Text && place.size > 0 {
                // Bit 0 says Thumb.
                functions.push((Symbol { address: place.address & !1, ..place }, name.clone()));
            }
            symbols.insert(name, place);
        }
        functions.sort_by_key(|(place, _)| place.address);
        let log = Table::parse(elf).map_err(|error| error.to_string()).transpose();
        let elf = elf.to_vec();
        Ok(Image { elf, flash, code: OnceLock::new(), symbols, functions, log })
    }

    /// A program without ELF file: `flash` is the content from 0800 0000h on, vector table first.
    pub fn from_flash(flash: Vec<u8>) -> Image {
        Image { flash, ..Image::default() }
    }

    /// Adds a symbol to a program without ELF file.
    #[must_use]
    pub fn with_symbol(mut self, name: &str, place: Symbol) -> Image {
        self.symbols.insert(name.to_owned(), place);
        self
    }

    /// The ELF file; empty for a program without one.
    pub fn elf(&self) -> &[u8] {
        &self.elf
    }

    /// Content of flash from 0800 0000h on.
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// The content of flash, decoded once for all boards that run the image.
    pub(crate) fn code(&self) -> &Code {
        self.code.get_or_init(|| Code::decode(FLASH_BASE as u32, &self.flash))
    }

    /// Returns a variable or function by its name: that in the ELF file, its path in Rust, or the end of a path if it
    /// is unique, such as `DIAGNOSTICS`. Of several instances of a generic function it returns one.
    pub fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).copied().or_else(|| {
            let is_end =
                |path: &&String| path.strip_suffix(name).is_some_and(|before| before.ends_with("::"));
            let mut paths = self.symbols.keys().filter(is_end);
            let only = paths.next().filter(|_| paths.next().is_none())?;
            self.symbols.get(only).copied()
        })
    }

    /// Checks that the image was linked for this part, by its symbol `__device_id`. An image without that symbol is
    /// accepted for any part whose flash is large enough.
    ///
    /// # Errors
    /// [`Misfit`].
    pub fn check_part(&self, part: Part) -> Result<(), Misfit> {
        let linked_for = self.symbols.get(DEVICE_ID).map(|symbol| symbol.address);
        if let Some(linked_for) = linked_for.filter(|id| *id != part.device_id()) {
            return Err(Misfit::OtherChip { linked_for, part });
        }
        let bytes = self.flash.len();
        if bytes > part.flash_bytes() as usize { Err(Misfit::TooLarge { bytes, part }) } else { Ok(()) }
    }

    /// The function that has an instruction at `address`, by the symbols of the ELF file.
    pub fn function_at(&self, address: u32) -> Option<&str> {
        let after = self.functions.partition_point(|(place, _)| place.address <= address);
        let (place, name) = self.functions.get(after.checked_sub(1)?)?;
        (address - place.address < place.size).then_some(name)
    }

    /// Returns the table that decodes the image's log; `None` for an image that does not log by defmt.
    ///
    /// # Errors
    /// When its section `.defmt` cannot be parsed, for example because of its version. The image runs, and its log is
    /// not shown.
    pub fn log_table(&self) -> Result<Option<&Table>, &str> {
        self.log.as_ref().map(|table| table.as_ref().map_err(String::as_str)).transpose()
    }
}

/// Returns whether flash begins with valid reset values (ARMv7-M B1.5.5): a stack pointer in RAM, and the address of
/// Thumb code in flash.
fn has_vector_table(flash: &[u8]) -> bool {
    let word = |at: usize| Some(u32::from_le_bytes(flash.get(at..at + 4)?.try_into().ok()?));
    let (Some(stack), Some(reset)) = (word(0), word(4)) else { return false };
    let offset = u64::from(reset).checked_sub(FLASH_BASE);
    RAM.contains(&stack) && reset % 2 == 1 && offset.is_some_and(|offset| offset < flash.len() as u64)
}

/// The loadable segments at their physical (load) addresses, which `object`'s portable interface does not give.
fn load_segments(elf: &[u8]) -> Result<Vec<(u64, &[u8])>, ImageError> {
    use object::elf::PT_LOAD;
    use object::read::elf::{ElfFile32, ProgramHeader};
    let file = ElfFile32::<object::Endianness>::parse(elf).map_err(ImageError::Elf)?;
    let endian = file.endian();
    let mut segments = Vec::new();
    for header in file.elf_program_headers() {
        let content = header.data(endian, elf).map_err(|()| ImageError::Truncated)?;
        if header.p_type(endian) == PT_LOAD && !content.is_empty() {
            segments.push((u64::from(header.p_paddr(endian)), content));
        }
    }
    Ok(segments)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stack at the end of 128 KiB of SRAM, and a reset handler behind the table.
    const TABLE: [u8; 10] = [0x00, 0x00, 0x02, 0x20, 0x09, 0x00, 0x00, 0x08, 0xFE, 0xE7];

    /// An ELF header for ARM and one loadable segment at `address`.
    fn elf(address: u32, content: &[u8]) -> Vec<u8> {
        let mut file = vec![0x7F, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        for half in [2_u16, 40] {
            file.extend(half.to_le_bytes());
        }
        for word in [1_u32, address, 52, 0, 0] {
            file.extend(word.to_le_bytes());
        }
        for half in [52_u16, 32, 1, 40, 0, 0] {
            file.extend(half.to_le_bytes());
        }
        let length = content.len() as u32;
        for word in [1, 84, address, address, length, length, 5, 4] {
            file.extend(word.to_le_bytes());
        }
        file.extend(content);
        file
    }

    /// The same with a section `.defmt` without the symbol that names its version.
    fn elf_with_unknown_log() -> Vec<u8> {
        const NAMES: &[u8] = b"\0.names\0.defmt\0";
        let mut file = elf(0x0800_0000, &TABLE);
        let names = file.len() as u32;
        file.extend(NAMES);
        file.resize(file.len().next_multiple_of(4), 0);
        let headers = (file.len() as u32).to_le_bytes();
        file[32..36].copy_from_slice(&headers);
        for (place, half) in [(46, 40_u16), (48, 3), (50, 1)] {
            file[place..place + 2].copy_from_slice(&half.to_le_bytes());
        }
        let (strings, program) = (3, 1);
        for [name, kind, offset, size] in
            [[0; 4], [1, strings, names, NAMES.len() as u32], [8, program, names, 4]]
        {
            let header = [name, kind, 0, 0, offset, size, 0, 0, 1, 0];
            file.extend(header.into_iter().flat_map(u32::to_le_bytes));
        }
        file
    }

    /// Given an image whose log has an unknown version, then it runs, and the reason is stored.
    #[test]
    fn image_flies_without_the_log_that_is_not_understood() {
        let image = Image::parse(&elf_with_unknown_log()).unwrap();
        assert_eq!(image.flash(), TABLE);
        let Err(reason) = image.log_table() else { panic!("it has no version") };
        assert!(reason.contains("version"), "{reason}");
        assert!(matches!(Image::parse(&elf(0x0800_0000, &TABLE)).unwrap().log_table(), Ok(None)));
    }

    #[test]
    fn a_segment_goes_where_it_is_loaded() {
        let image = Image::parse(&elf(0x0800_0000, &TABLE)).unwrap();
        assert_eq!(image.flash(), TABLE);
        assert_eq!(image.symbol("_SEGGER_RTT"), None);
    }

    /// Given images that were linked without a linker script, then they have no content, or no valid vector table.
    #[test]
    fn image_without_vector_table_is_refused_with_the_cause() {
        let changed = |at: usize, byte: u8| {
            let mut table = TABLE;
            table[at] = byte;
            table
        };
        for (content, bytes) in [
            (&[][..], 0),
            (&TABLE[..4], 4),
            (&[0xFF; 16], 16),
            (&changed(3, 0x40), 10), // the stack among the peripherals
            (&changed(4, 0x08), 10), // no Thumb code
            (&changed(7, 0x20), 10), // reset in RAM
        ] {
            let error = Image::parse(&elf(0x0800_0000, content)).unwrap_err().to_string();
            let said = format!("no vector table at 0800 0000h, {bytes} bytes for flash");
            assert!(error.contains(&said) && error.contains("build.rs"), "{content:?}: {error}");
        }
        let above = Image::parse(&elf(0x0800_4000, &TABLE)).unwrap_err();
        assert!(matches!(above, ImageError::NoVectorTable(0x400A)), "{above}");
    }

    fn linked_for(device_id: u32) -> Image {
        Image::from_flash(vec![0; 4]).with_symbol(DEVICE_ID, Symbol { address: device_id, size: 0 })
    }

    /// DEV_ID by the chapters "Debug support" of RM0090, RM0390 and RM0386.
    #[test]
    fn image_for_another_chip_is_refused_with_both_chips() {
        for (device_id, fitting, other, message) in [
            (
                0x413,
                &["STM32F405RG", "STM32F407VG", "STM32F415RG", "STM32F417VE"][..],
                "STM32F446RE",
                "the image was linked for DEV_ID 413h (STM32F405, STM32F407, STM32F415, STM32F417), the board has an \
                 STM32F446RE (421h)",
            ),
            (
                0x421,
                &["STM32F446RE"],
                "STM32F405RG",
                "the image was linked for DEV_ID 421h (STM32F446), the board has an STM32F405RG (413h)",
            ),
            (
                0x419,
                &["STM32F427VG", "STM32F429ZI", "STM32F437ZG", "STM32F439NI"],
                "STM32F469NI",
                "the image was linked for DEV_ID 419h (STM32F427, STM32F429, STM32F437, STM32F439), the board has an \
                 STM32F469NI (434h)",
            ),
            (
                0x434,
                &["STM32F469NI", "STM32F479ZG"],
                "STM32F429ZI",
                "the image was linked for DEV_ID 434h (STM32F469, STM32F479), the board has an STM32F429ZI (419h)",
            ),
            (
                0x431,
                &[],
                "STM32F405RG",
                "the image was linked for DEV_ID 431h (no part that the twin models), the board has an STM32F405RG (413h)",
            ),
        ] {
            let image = linked_for(device_id);
            for name in fitting {
                assert_eq!(image.check_part(Part::named(name).unwrap()), Ok(()), "{device_id:03X}h {name}");
            }
            let error = image.check_part(Part::named(other).unwrap()).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }

    #[test]
    fn image_without_chip_fits_a_part_with_enough_flash() {
        let part = |name| Part::named(name).unwrap();
        let image = Image::from_flash(vec![0; 600 << 10]);
        assert_eq!(image.check_part(part("STM32F405RG")), Ok(()));
        assert_eq!(image.check_part(part("STM32F429ZI")), Ok(()));
        let error = image.check_part(part("STM32F446RE")).unwrap_err().to_string();
        assert_eq!(
            error,
            "the image has 614400 bytes, the board has an STM32F446RE with 524288 bytes of flash"
        );
    }

    #[test]
    fn files_that_are_no_images_are_told_apart() {
        assert!(matches!(Image::parse(b"not an ELF file at all"), Err(ImageError::Elf(_))));
        assert!(matches!(
            Image::parse(&elf(0x2000_0000, &TABLE)),
            Err(ImageError::OutsideFlash(0x2000_0000))
        ));
        let whole = elf(0x0800_0000, &TABLE);
        assert!(matches!(Image::parse(&whole[..86]), Err(ImageError::Truncated)));
    }
}
