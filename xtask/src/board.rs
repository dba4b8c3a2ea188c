//! The boards that images are built for and flown on.

use clap::ValueEnum;

/// A supported board; its name on the command line is that of the firmware's cargo feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// pyboard v1.1: STM32F405RG at 168 MHz, two bxCAN controllers
    #[value(name = "pyboard-v11")]
    PyboardV11,
}

impl Board {
    /// Its name: cargo feature, command line, summary.
    pub fn name(self) -> &'static str {
        match self {
            Board::PyboardV11 => "pyboard-v11",
        }
    }
}
