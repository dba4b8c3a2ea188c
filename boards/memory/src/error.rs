//! Reasons why a board has no memory map.

use std::io;
use std::path::PathBuf;

/// Reason why a board has no memory map, and what to change.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// A file is not TOML.
    #[error("{file}: {reason}")]
    Toml {
        /// Name of the file.
        file: &'static str,
        /// Error of the parser, with the line.
        reason: toml_edit::TomlError,
    },
    /// No feature of embassy-stm32 names a chip.
    #[error(
        "Cargo.toml: embassy-stm32 has no feature that names a chip: add the chip of the board to its features, as \
         in `features = [\"stm32f405rg\"]`"
    )]
    NoChip,
    /// Features of embassy-stm32 name different chips.
    #[error(
        "Cargo.toml: embassy-stm32 has features of several chips, {}: keep the chip of the board, as in \
         `features = [\"{}\"]`",
        chips.join(" and "),
        chips[0]
    )]
    SeveralChips {
        /// Names of the chips, two or more.
        chips: Vec<String>,
    },
    /// The description of the board names no chip.
    #[error("board.toml: no chip: add the chip of the board, as in `chip = \"STM32F405RG\"`")]
    NoChipOfBoard,
    /// Manifest and description of the board name different chips.
    #[error(
        "Cargo.toml has the chip {manifest} (a feature of embassy-stm32), but board.toml has the chip {board}: \
         write the same chip in both"
    )]
    OtherChip {
        /// Chip in the manifest.
        manifest: String,
        /// Chip in the description of the board.
        board: String,
    },
    /// The chip is not supported.
    #[error("{chip} is not supported: {reason}")]
    Chip {
        /// Name of the chip.
        chip: String,
        /// Why, and what is supported.
        reason: String,
    },
}
