//! Descriptions of boards: a file `board.toml` for each.
//!
//! A *description* names the part of a board, its oscillator and its pins. [`Description::shipped`] is that of a board of this
//! project, which this crate contains; [`Description::read`] reads any other. The format:
//!
//! ```toml
//! name = "discovery"
//! chip = "STM32F407VGT6"              # as on the part
//! pulse = "PB1"                       # optional: a channel of TIM3
//! transceiver-switch = "PC13"         # optional: two transceivers on one controller
//!
//! [oscillator]
//! frequency = "8MHz"
//! kind = "crystal"                    # or "external"
//!
//! [can1]                              # nominal bus
//! rx = "PD0"
//! tx = "PD1"
//!
//! [can2]                              # redundant bus
//! rx = "PB5"
//! tx = "PB6"
//!
//! [capture]                           # optional: two of PA0 to PA3
//! can1 = "PA2"
//! can2 = "PA3"
//!
//! [straps]                            # optional
//! bits = ["PC0", "PC1", "PC2", "PC3"]
//! parity = "PC4"
//! maintenance = "PC5"                 # optional
//!
//! [leds]                              # optional: up to eight, with names of yours
//! green = "PD12"
//! orange = "PD13"
//! red = "PD14"
//! blue = "PD15"
//! ```
//!
//! A wrong file is refused as a whole: the error names file, field, what was found and what is allowed.

mod check;
mod format;
#[cfg(test)]
mod tests;

use std::path::Path;

use check::Checker;

use crate::model::{Model, Oscillator};

/// Name of the file in the folder of a board.
pub const FILE: &str = "board.toml";

/// The boards of this project in alphabetical order, each with the text of its description.
pub const SHIPPED: [(&str, &str); 3] = [
    ("nucleo-f446re", include_str!("../boards/nucleo-f446re.toml")),
    ("pyboard-v11", include_str!("../boards/pyboard-v11.toml")),
    ("stm32f4discovery", include_str!("../boards/stm32f4discovery.toml")),
];

/// A board as its file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Description {
    /// Name of the board, its folder, and the cargo feature of its images.
    pub name: String,
    /// Name of the part in the file, which debug probes use.
    pub chip: String,
    /// Model that is emulated.
    pub model: Model,
}

/// Error of a description: file, field, the value found, the values allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Wrong(String);

impl Description {
    /// Reads a description: the file itself, or the folder that it is in.
    ///
    /// # Errors
    /// When it cannot be read, or describes no board that the twin can emulate.
    pub fn read(path: &Path) -> Result<Description, Wrong> {
        let path = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
        let text = std::fs::read(&path).map_err(|error| Wrong(format!("{}: {error}", path.display())))?;
        // Comments may have any encoding. A value with other letters than ASCII is refused by its field.
        Description::parse(&String::from_utf8_lossy(&text), &path.display().to_string())
    }

    /// Parses the text of a description; errors name `file`.
    ///
    /// # Errors
    /// When it describes no board that the twin can emulate.
    pub fn parse(text: &str, file: &str) -> Result<Description, Wrong> {
        let raw: format::Board = toml::from_str(text)
            .map_err(|error| Wrong(format!("{file}: {}", error.to_string().trim_end())))?;
        Checker::default().description(&raw).map_err(|error| Wrong(format!("{file}: {error}")))
    }

    /// The board of this project with this name.
    ///
    /// # Panics
    /// When the project has no such board, or its file is wrong: a mistake in the project, not an input.
    pub fn shipped(name: &str) -> Description {
        let found = SHIPPED.iter().find(|(known, _)| *known == name);
        let (_, text) = found.unwrap_or_else(|| panic!("this project has no board {name}"));
        Description::parse(text, name).unwrap_or_else(|wrong| panic!("{wrong}"))
    }

    /// Returns the names of the boards of this project, in alphabetical order.
    pub fn names() -> Vec<String> {
        SHIPPED.iter().map(|(name, _)| (*name).to_owned()).collect()
    }
}

impl Model {
    /// The board of this project with this name.
    ///
    /// # Panics
    /// As [`Description::shipped`].
    pub fn shipped(name: &str) -> Model {
        Description::shipped(name).model
    }
}

/// Reads an oscillator: `8MHz` or `8MHz crystal` is a crystal, `8MHz external` an external clock.
///
/// # Errors
/// The invalid value and the allowed values.
pub fn oscillator(text: &str) -> Result<Oscillator, String> {
    let (frequency, kind) = text.split_once([' ', ',']).unwrap_or((text, "crystal"));
    check::oscillator(frequency, kind).map_err(|(_, error)| error)
}
