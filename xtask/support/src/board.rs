//! The boards that images are built for and flown on, and the mission profiles that they are built with.

use clap::{Args, ValueEnum};
use twin::model::Model;
use twin::peripherals::Pin;

use crate::craft::SECOND_MASTER;

/// A supported board; its name on the command line is that of the firmware's cargo feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoardName {
    /// pyboard v1.1: STM32F405RG at 168 MHz, two bxCAN controllers
    #[value(name = "pyboard-v11")]
    PyboardV11,
    /// NUCLEO-F446RE: STM32F446RE at 168 MHz, two bxCAN controllers, external transceivers
    #[value(name = "nucleo-f446re")]
    NucleoF446re,
}

/// The pin that selects the transceiver of a minimal slave with one controller, on each board (docs/wiring.md).
pub const TRANSCEIVER_SWITCH: Pin = Pin::new('B', 13);

impl BoardName {
    /// Its name: cargo feature, command line, summary.
    pub fn name(self) -> &'static str {
        match self {
            BoardName::PyboardV11 => "pyboard-v11",
            BoardName::NucleoF446re => "nucleo-f446re",
        }
    }

    /// Its chip, as probe-rs knows it.
    pub fn chip(self) -> &'static str {
        match self {
            BoardName::PyboardV11 => "STM32F405RG",
            BoardName::NucleoF446re => "STM32F446RETx",
        }
    }

    /// Its emulation.
    pub fn model(self) -> Model {
        match self {
            BoardName::PyboardV11 => Model::PYBOARD_V11,
            BoardName::NucleoF446re => Model::NUCLEO_F446RE,
        }
    }

    /// How the harness closes the straps of a board: four bits from the lowest, then odd parity; a closed strap is tied to
    /// ground, an open one has a pull-up. Slaves have their Node-ID, `2..=15`. The master has 1: in a mission with two masters
    /// it is strapped prime, and other images do not look; [`SECOND_MASTER`] has 0.
    pub fn straps(self, board: u8) -> Vec<(Pin, bool)> {
        let node = if board == SECOND_MASTER { 0 } else { board };
        let pins = match self {
            BoardName::PyboardV11 => [('A', 2), ('A', 3), ('A', 4), ('A', 5), ('A', 6)],
            BoardName::NucleoF446re => [('C', 0), ('C', 1), ('C', 2), ('C', 3), ('B', 0)],
        };
        let parity = node.count_ones().is_multiple_of(2).then_some(4);
        let closed = (0..4).filter(|bit| node >> bit & 1 == 1).chain(parity);
        closed.map(|strap| pins[strap]).map(|(port, number)| (Pin::new(port, number), false)).collect()
    }
}

/// A mission profile that the firmware knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Numbers of the LibreCube prototype of 2017
    Librecube,
    /// Our defaults for ECSS-E-ST-50-15C
    Standard,
    /// Our defaults with two master boards, one of them the standby of the other
    Standby,
}

impl Profile {
    /// Its name: cargo feature, command line, summary.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Librecube => "librecube",
            Profile::Standard => "standard",
            Profile::Standby => "standby",
        }
    }
}

/// Options that choose what an image is built for: the same in each command that builds images.
#[derive(Args, Clone, Copy, Debug)]
pub struct Target {
    /// Board to build for
    #[arg(long, value_name = "BOARD", value_enum, default_value_t = BoardName::PyboardV11)]
    pub board: BoardName,

    /// Mission profile to build with; standby: two master boards
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    pub profile: Profile,
}

/// A bit rate that images can be built for: those of CiA 301 that divide the clock of the boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BitRate {
    /// 1 Mbit/s
    #[value(name = "1000")]
    Kbit1000,
    /// 500 kbit/s
    #[value(name = "500")]
    Kbit500,
    /// 250 kbit/s
    #[value(name = "250")]
    Kbit250,
    /// 125 kbit/s
    #[value(name = "125")]
    Kbit125,
    /// 50 kbit/s
    #[value(name = "50")]
    Kbit50,
    /// 20 kbit/s
    #[value(name = "20")]
    Kbit20,
    /// 10 kbit/s
    #[value(name = "10")]
    Kbit10,
}

impl BitRate {
    /// All of them, the fastest first.
    pub const ALL: [BitRate; 7] = [
        BitRate::Kbit1000,
        BitRate::Kbit500,
        BitRate::Kbit250,
        BitRate::Kbit125,
        BitRate::Kbit50,
        BitRate::Kbit20,
        BitRate::Kbit10,
    ];

    /// In kbit/s.
    pub fn kbit(self) -> u16 {
        match self {
            BitRate::Kbit1000 => 1_000,
            BitRate::Kbit500 => 500,
            BitRate::Kbit250 => 250,
            BitRate::Kbit125 => 125,
            BitRate::Kbit50 => 50,
            BitRate::Kbit20 => 20,
            BitRate::Kbit10 => 10,
        }
    }

    /// The features of images of a profile for this bit rate, joined by a plus sign.
    pub fn configuration(self, profile: Profile) -> String {
        match self {
            BitRate::Kbit1000 => profile.name().to_owned(),
            slower => format!("{}+kbit-{}", profile.name(), slower.kbit()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tied(node: u8) -> Vec<(Pin, bool)> {
        BoardName::PyboardV11.straps(node)
    }

    #[test]
    fn each_board_has_its_own_pins() {
        let pins = [('C', 0), ('C', 1), ('B', 0)].map(|(port, number)| (Pin::new(port, number), false));
        assert_eq!(BoardName::NucleoF446re.straps(3), pins);
    }

    #[test]
    fn an_odd_number_of_straps_is_tied_to_ground() {
        assert_eq!(tied(2), [(Pin::new('A', 3), false)]);
        assert_eq!(tied(3), [2, 3, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(15), [2, 3, 4, 5, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(1), [(Pin::new('A', 2), false)], "prime");
        assert_eq!(tied(SECOND_MASTER), [(Pin::new('A', 6), false)]);
    }
}
