//! An image as a file: bytes in flash and RAM, symbols, compiler.

use std::ops::Range;
use std::path::Path;

use anyhow::Context;
use object::{File, Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, SymbolKind, elf};

/// CCM and SRAM of the STM32F4, by address.
const RAM: Range<u64> = 0x1000_0000..0x3000_0000;
const FLASH: Range<u64> = 0x0800_0000..0x1000_0000;
/// Absolute symbol of an image: DEV_ID of its chip.
const DEVICE_ID: &str = "__device_id";

/// Bytes of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Code, constants and the initial values of variables.
    pub flash: u64,
    /// Variables; the rest is for the stack.
    pub ram: u64,
}

/// A function or variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Its path as it is written in Rust, without hashes.
    pub name: String,
    /// Memory that contains it.
    pub memory: Memory,
    /// Size in bytes.
    pub bytes: u64,
}

/// A memory of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Memory {
    /// Flash.
    Flash,
    /// SRAM or CCM.
    Ram,
}

impl Memory {
    /// Returns the name in texts.
    pub fn name(self) -> &'static str {
        match self {
            Memory::Flash => "flash",
            Memory::Ram => "RAM",
        }
    }
}

/// Facts about an image from its ELF file.
#[derive(Clone, Debug)]
pub struct Facts {
    /// The whole image.
    pub size: Size,
    /// Its functions and variables, the biggest first.
    pub symbols: Vec<Symbol>,
    /// `rustc` and its version; `None` when the image does not say.
    pub compiler: Option<String>,
}

impl Facts {
    /// Reads the facts about the image at `path`.
    ///
    /// # Errors
    /// When it cannot be read or is no ELF file.
    pub fn read(path: &Path) -> anyhow::Result<Facts> {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let file = File::parse(&*bytes).with_context(|| format!("{} is no ELF file", path.display()))?;
        Ok(Facts { size: size(&file), symbols: symbols(&file), compiler: compiler(&file) })
    }
}

/// Returns DEV_ID of the chip that the image at `path` was linked for. `None`: it does not name one.
///
/// # Errors
/// When it cannot be read or is no ELF file.
pub fn device_id(path: &Path) -> anyhow::Result<Option<u32>> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = File::parse(&*bytes).with_context(|| format!("{} is no ELF file", path.display()))?;
    let id = file.symbols().find(|symbol| symbol.name() == Ok(DEVICE_ID));
    Ok(id.and_then(|symbol| u32::try_from(symbol.address()).ok()))
}

fn size(file: &File) -> Size {
    file.sections().filter(is_loaded).fold(Size::default(), |mut size, section| {
        let stored = section.kind() != SectionKind::UninitializedData;
        if RAM.contains(&section.address()) {
            size.ram += section.size();
        }
        if FLASH.contains(&section.address()) || (stored && RAM.contains(&section.address())) {
            size.flash += section.size();
        }
        size
    })
}

fn is_loaded(section: &object::Section) -> bool {
    matches!(section.flags(), SectionFlags::Elf { sh_flags } if sh_flags & u64::from(elf::SHF_ALLOC) != 0)
}

fn symbols(file: &File) -> Vec<Symbol> {
    let mut found: Vec<(u64, Symbol)> = file
        .symbols()
        .filter(|symbol| matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data) && symbol.size() > 0)
        .filter_map(|symbol| {
            let memory = match symbol.address() {
                at if FLASH.contains(&at) => Memory::Flash,
                at if RAM.contains(&at) => Memory::Ram,
                _ => return None,
            };
            let name = format!("{:#}", rustc_demangle::demangle(symbol.name().ok()?));
            Some((symbol.address(), Symbol { name, memory, bytes: symbol.size() }))
        })
        .collect();
    // Equal functions are folded into one: two names, the same bytes.
    found.sort_by(|(a, left), (b, right)| (a, &left.name).cmp(&(b, &right.name)));
    found.dedup_by_key(|(address, _)| *address);
    let mut symbols: Vec<Symbol> = found.into_iter().map(|(_, symbol)| symbol).collect();
    symbols.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.name.cmp(&b.name)));
    symbols
}

/// Finds the compiler in the section `.comment`, which contains texts with a zero byte at the end.
fn compiler(file: &File) -> Option<String> {
    let section = file.section_by_name(".comment")?;
    let texts = section.data().ok()?.split(|byte| *byte == 0);
    let mut texts = texts.map(String::from_utf8_lossy);
    texts.find_map(|text| Some(format!("rustc {}", text.strip_prefix("rustc version ")?)))
}
