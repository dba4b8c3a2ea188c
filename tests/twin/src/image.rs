//! A firmware image: what goes into flash, its symbols, its log table.

use std::collections::HashMap;
use std::fmt;

use defmt_decoder::Table;
use object::{Object, ObjectSymbol};

const FLASH_BASE: u64 = 0x0800_0000;
const FLASH_LEN: u64 = 1 << 20;

/// Name, place and size of a variable or function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// First byte.
    pub address: u32,
    /// Bytes; zero for labels.
    pub size: u32,
}

/// A parsed ELF file. Boards share it.
pub struct Image {
    flash: Vec<u8>,
    symbols: HashMap<String, Symbol>,
    log_table: Option<Table>,
}

/// Why a file is no image for this part.
#[derive(Debug)]
pub enum ImageError {
    /// Not an ELF file, or a damaged one.
    Elf(object::Error),
    /// The defmt section does not parse.
    LogTable(String),
    /// A segment is loaded outside flash, at this address.
    OutsideFlash(u64),
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ImageError::Elf(error) => write!(f, "not a usable ELF file: {error}"),
            ImageError::LogTable(error) => write!(f, "the defmt log table does not parse: {error}"),
            ImageError::OutsideFlash(address) => {
                write!(f, "a segment at {address:08X}h is outside the 1 MiB of flash at 0800 0000h")
            }
        }
    }
}

impl std::error::Error for ImageError {}

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
        let symbols = file
            .symbols()
            .filter_map(|symbol| {
                let name = symbol.name().ok().filter(|name| !name.is_empty())?;
                let place = Symbol { address: symbol.address() as u32, size: symbol.size() as u32 };
                Some((name.to_owned(), place))
            })
            .collect();
        let log_table = Table::parse(elf).map_err(|error| ImageError::LogTable(error.to_string()))?;
        Ok(Image { flash, symbols, log_table })
    }

    /// A program without ELF file: `flash` is the content from 0800 0000h on, vector table first.
    pub fn from_flash(flash: Vec<u8>) -> Image {
        Image { flash, symbols: HashMap::new(), log_table: None }
    }

    /// Content of flash from 0800 0000h on.
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// A variable or function by its name in the ELF file.
    pub fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).copied()
    }

    /// What decodes the image's log, if it logs by defmt.
    pub(crate) fn log_table(&self) -> Option<&Table> {
        self.log_table.as_ref()
    }
}

/// The loadable segments at their physical (load) addresses, which `object`'s portable interface does not give.
fn load_segments(elf: &[u8]) -> Result<Vec<(u64, &[u8])>, ImageError> {
    use object::elf::PT_LOAD;
    use object::read::elf::{ElfFile32, ProgramHeader};
    let file = ElfFile32::<object::Endianness>::parse(elf).map_err(ImageError::Elf)?;
    let endian = file.endian();
    let mut segments = Vec::new();
    for header in file.elf_program_headers() {
        let content = header.data(endian, elf).map_err(|()| ImageError::OutsideFlash(0))?;
        if header.p_type(endian) == PT_LOAD && !content.is_empty() {
            segments.push((u64::from(header.p_paddr(endian)), content));
        }
    }
    Ok(segments)
}
