//! `cargo xtask firmware`: both images, where they are and how big.

use std::ops::Range;
use std::path::Path;

use anyhow::Context;
use clap::{Args, ValueEnum};
use object::{Object, ObjectSection, SectionFlags, SectionKind, elf};

use crate::board::Board;

/// CCM and SRAM of the STM32F4, by address.
const RAM: Range<u64> = 0x1000_0000..0x3000_0000;
const FLASH: Range<u64> = 0x0800_0000..0x1000_0000;

/// Command line of `firmware`.
#[derive(Args, Debug)]
pub struct Options {
    /// Board to build for
    #[arg(long, value_name = "BOARD", value_enum, default_value_t = Board::PyboardV11)]
    board: Board,

    /// Mission profile to build with
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    profile: Profile,
}

/// A mission profile that the firmware knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Numbers of the LibreCube prototype of 2017
    Librecube,
    /// Our defaults for ECSS-E-ST-50-15C
    Standard,
}

impl Profile {
    /// Its name: cargo feature, command line, summary.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Librecube => "librecube",
            Profile::Standard => "standard",
        }
    }
}

/// Bytes of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Size {
    /// Code, constants and the initial values of variables.
    flash: u64,
    /// Variables; the stack takes what is left.
    ram: u64,
}

/// Builds both images, prints paths and sizes.
///
/// # Errors
/// When an image cannot be built or read.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let images = firmware_images::build(options.board.name(), options.profile.name())?;
    for (role, path) in [("master", &images.master), ("slave", &images.slave)] {
        let Size { flash, ram } = size(path)?;
        println!("{role:<6}  {flash:>7} bytes of flash  {ram:>6} bytes of static RAM  {}", path.display());
    }
    Ok(())
}

/// Lints boards and firmware as they are compiled for a board.
///
/// # Errors
/// When there is a warning.
pub fn clippy(options: &Options) -> anyhow::Result<()> {
    Ok(firmware_images::clippy(options.board.name(), options.profile.name())?)
}

fn size(path: &Path) -> anyhow::Result<Size> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = object::File::parse(&*bytes).with_context(|| format!("{} is no ELF file", path.display()))?;
    Ok(file.sections().filter(is_loaded).fold(Size::default(), |mut size, section| {
        let stored = section.kind() != SectionKind::UninitializedData;
        if RAM.contains(&section.address()) {
            size.ram += section.size();
        }
        if FLASH.contains(&section.address()) || (stored && RAM.contains(&section.address())) {
            size.flash += section.size();
        }
        size
    }))
}

fn is_loaded(section: &object::Section) -> bool {
    matches!(section.flags(), SectionFlags::Elf { sh_flags } if sh_flags & u64::from(elf::SHF_ALLOC) != 0)
}
