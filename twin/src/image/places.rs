//! Variables and memory that an image uses in RAM, for reports about upsets.

use std::ops::Range;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};

use super::{Image, Symbol};

/// RAM and CCM.
const RAM: Range<u64> = 0x1000_0000..0x3000_0000;

impl Image {
    /// Returns the sections that a program has in RAM, with their names, by address. Empty for a program without ELF file.
    pub fn ram_sections(&self) -> Vec<(String, Range<u32>)> {
        let Ok(file) = object::File::parse(self.elf()) else { return Vec::new() };
        let is_allocated = |section: &object::Section| matches!(section.flags(), SectionFlags::Elf { sh_flags } if sh_flags & u64::from(elf::SHF_ALLOC) != 0);
        let in_ram = file.sections().filter(|section| {
            section.size() > 0 && RAM.contains(&section.address()) && is_allocated(section)
        });
        let mut sections: Vec<_> = in_ram
            .map(|section| {
                let first = section.address() as u32;
                (section.name().unwrap_or_default().to_owned(), first..first + section.size() as u32)
            })
            .collect();
        sections.sort_by_key(|(_, range)| range.start);
        sections
    }

    /// Returns the variables in RAM with their names, by address. Empty for a program without ELF file.
    pub fn variables(&self) -> Vec<(String, Symbol)> {
        let Ok(file) = object::File::parse(self.elf()) else { return Vec::new() };
        let in_ram = file.symbols().filter(|symbol| {
            symbol.kind() == SymbolKind::Data && symbol.size() > 0 && RAM.contains(&symbol.address())
        });
        let mut variables: Vec<_> = in_ram
            .filter_map(|symbol| {
                let name = format!("{:#}", rustc_demangle::demangle(symbol.name().ok()?));
                Some((name, Symbol { address: symbol.address() as u32, size: symbol.size() as u32 }))
            })
            .collect();
        variables.sort_by_key(|(_, place)| place.address);
        variables
    }
}
