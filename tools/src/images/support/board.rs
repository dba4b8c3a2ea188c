//! Boards for which images are built, and mission profiles of images.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use can_twin::description::{self, Description};
use can_twin::model::{Model, Oscillator, Part};
use can_twin::pin::Pin;
use clap::{Args, ValueEnum};

use crate::images::BoardCrate;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::SECOND_MASTER;
use crate::images::support::project;

/// A board, as its `board.toml` describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Board {
    description: Arc<Description>,
    /// Folder of a board that is not of this project, absolute if the folder exists.
    elsewhere: Option<PathBuf>,
}

impl Board {
    /// Name of the board that is used without `--board`.
    pub const DEFAULT: &str = "pyboard-v11";

    /// The board of this project with this name.
    ///
    /// # Panics
    /// When there is none, or its description is wrong.
    pub fn shipped(name: &str) -> Board {
        Board { description: Arc::new(Description::shipped(name)), elsewhere: None }
    }

    /// Boards that the images of this project are built for, [`Board::DEFAULT`] first.
    pub fn built() -> Vec<Board> {
        built_names().iter().map(|name| Board::shipped(name)).collect()
    }

    /// The value of `--board`: the name of a board of this project, or the path of a `board.toml` or of its folder.
    ///
    /// # Errors
    /// When there is no such board, or its description is wrong: what is allowed.
    pub fn parse(text: &str) -> Result<Board, String> {
        if Description::names().iter().any(|name| name == text) {
            return Ok(Board::shipped(text));
        }
        let path = Path::new(text);
        if !path.join(description::FILE).is_file() && !path.is_file() {
            return Err(format!("no such board; {}", allowed()));
        }
        let description = Description::read(path).map_err(|wrong| wrong.to_string())?;
        let folder = absolute(if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) });
        let is_shipped =
            built_names().contains(&description.name) && folder == of_checkout(&description.name);
        Ok(Board { description: Arc::new(description), elsewhere: (!is_shipped).then_some(folder) })
    }

    /// Returns this board with another part or oscillator, and a name that contains them.
    ///
    /// # Errors
    /// When the part lacks a pin of the board.
    pub fn with(&self, part: Option<Part>, oscillator: Option<Oscillator>) -> Result<Board, String> {
        let Model { part: own, oscillator: own_oscillator, pins } = self.description.model;
        let model =
            Model { part: part.unwrap_or(own), oscillator: oscillator.unwrap_or(own_oscillator), pins };
        if let Some(pin) = pins.all().find(|pin| !model.part.has_pin(*pin)) {
            let (part, name) = (model.part, self.name());
            return Err(format!(
                "the {part} has no pin {pin}, which the board {name} uses; allowed are parts with the pins of the board, or \
                 --board FILE with other pins"
            ));
        }
        if model == self.description.model {
            return Ok(self.clone());
        }
        let chip = part.map_or(self.description.chip.clone(), |part| part.to_string());
        let name = format!("{} with {}, {} MHz", self.name(), model.part, model.oscillator.hz as f64 / 1e6);
        let description = Arc::new(Description { name, chip, model });
        Ok(Board { description, elsewhere: self.elsewhere.clone() })
    }

    /// Returns its name: in the command line, in the summary, and as cargo feature of images.
    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// Returns the name of its chip for probe-rs.
    pub fn chip(&self) -> &str {
        &self.description.chip
    }

    /// Its emulation.
    pub fn model(&self) -> Model {
        self.description.model
    }

    /// Returns the straps of a board: four bits from the lowest, then odd parity. A closed strap is tied to ground, an
    /// open one has a pull-up. Slaves have their Node-ID, `2..=15`. The master has 1: in a mission with two masters it
    /// is the prime one; other images ignore it. [`SECOND_MASTER`] has 0. A board without straps has none closed.
    pub fn straps(&self, board: u8) -> Vec<(Pin, bool)> {
        let node = if board == SECOND_MASTER { 0 } else { board };
        self.description.model.pins.straps.map_or(Vec::new(), |straps| straps.closed(node))
    }

    /// The crate of this board, for images of this project.
    pub fn board_crate(&self) -> BoardCrate<'_> {
        match &self.elsewhere {
            Some(folder) => BoardCrate::Elsewhere(folder),
            None => BoardCrate::Shipped(self.name()),
        }
    }

    /// Checks that images of this project can be built for this board; `command` is the subcommand that builds them.
    ///
    /// # Errors
    /// When the board has no crate.
    pub fn check_images(&self, command: &'static str) -> Result<(), Misuse> {
        let BoardCrate::Elsewhere(folder) = self.board_crate() else { return Ok(()) };
        if folder.join("Cargo.toml").is_file() {
            return Ok(());
        }
        let cause = format!(
            "{} has no Cargo.toml, and images of this project cannot be built without the crate of the board; allowed are {}, or a \
             folder with Cargo.toml and board.toml",
            folder.display(),
            built_names().join(", ")
        );
        Err(Misuse::value(command, "--board <BOARD>", self.name(), cause))
    }
}

/// Folder of a board of this project in the checkout that this program was built in.
fn of_checkout(name: &str) -> PathBuf {
    absolute(&project::path("boards").join(name))
}

/// Makes a path absolute if it exists; otherwise returns it unchanged.
fn absolute(path: &Path) -> PathBuf {
    // No path is the current folder.
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Names of the boards of this project that its images choose from, by a dependency each, [`Board::DEFAULT`] first.
pub fn built_names() -> Vec<String> {
    let manifest: toml::Table = crate::images::shipped::MASTER.parse().unwrap_or_default();
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let is_dependency = |name: &String| {
        let mut targets = targets.into_iter().flat_map(toml::Table::values);
        targets.any(|target| target.get("dependencies").is_some_and(|all| all.get(name).is_some()))
    };
    let mut names: Vec<_> = Description::names().into_iter().filter(is_dependency).collect();
    names.sort_by_key(|name| name != Board::DEFAULT);
    names
}

/// Returns the values allowed for `--board`.
fn allowed() -> String {
    let mut names = Description::names();
    names.sort_by_key(|name| name != Board::DEFAULT);
    format!("allowed are {}, or the path of a board.toml or of its folder", names.join(", "))
}

/// Help of `--board`.
pub fn help() -> String {
    format!("Board; {}", allowed())
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

/// Options of the target of an image, the same in each command that builds images.
#[derive(Args, Clone, Debug)]
pub struct Target {
    /// Board to build for
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, default_value = Board::DEFAULT, help = help())]
    pub board: Board,

    /// Mission profile to build with; standby: two master boards
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    pub profile: Profile,
}

/// A bit rate that images can be built for, in kbit/s, the fastest first: those of CiA 301 that divide the clock of the boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BitRate {
    /// 1 Mbit/s
    #[value(name = "1000")]
    Kbit1000 = 1_000,
    /// 500 kbit/s
    #[value(name = "500")]
    Kbit500 = 500,
    /// 250 kbit/s
    #[value(name = "250")]
    Kbit250 = 250,
    /// 125 kbit/s
    #[value(name = "125")]
    Kbit125 = 125,
    /// 50 kbit/s
    #[value(name = "50")]
    Kbit50 = 50,
    /// 20 kbit/s
    #[value(name = "20")]
    Kbit20 = 20,
    /// 10 kbit/s
    #[value(name = "10")]
    Kbit10 = 10,
}

impl BitRate {
    /// In kbit/s.
    pub fn kbit(self) -> u16 {
        self as u16
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
        Board::shipped("pyboard-v11").straps(node)
    }

    #[test]
    fn each_board_has_its_own_pins() {
        let pins = [('C', 0), ('C', 1), ('B', 0)].map(|(port, number)| (Pin::new(port, number), false));
        assert_eq!(Board::shipped("nucleo-f446re").straps(3), pins);
        let pins = [('E', 7), ('E', 8), ('E', 11)].map(|(port, number)| (Pin::new(port, number), false));
        assert_eq!(Board::shipped("stm32f4discovery").straps(3), pins);
    }

    #[test]
    fn an_odd_number_of_straps_is_tied_to_ground() {
        assert_eq!(tied(2), [(Pin::new('A', 3), false)]);
        assert_eq!(tied(3), [2, 3, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(15), [2, 3, 4, 5, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(1), [(Pin::new('A', 2), false)], "prime");
        assert_eq!(tied(SECOND_MASTER), [(Pin::new('A', 6), false)]);
    }

    #[test]
    fn board_is_a_name_a_file_or_its_folder() {
        let pyboard = Board::shipped("pyboard-v11");
        let folder = of_checkout("pyboard-v11");
        assert_eq!(Board::parse("pyboard-v11"), Ok(pyboard.clone()));
        assert_eq!(Board::parse(&folder.to_string_lossy()), Ok(pyboard.clone()));
        assert_eq!(Board::parse(&folder.join("board.toml").to_string_lossy()), Ok(pyboard));
        let error = Board::parse("pyboard-v12").unwrap_err();
        let allowed = "pyboard-v11, nucleo-f446re, stm32f4discovery, or the path of a board.toml";
        assert!(error.contains(allowed), "{error}");
    }

    #[test]
    fn images_are_built_for_the_boards_that_they_depend_on() {
        let names: Vec<_> = Board::built().iter().map(|board| board.name().to_owned()).collect();
        assert_eq!(names[0], "pyboard-v11");
        for expected in ["nucleo-f446re", "stm32f4discovery"] {
            assert!(names.iter().any(|name| name == expected), "{names:?}");
        }
    }

    /// Given the description of the pyboard in another folder, then its images are built for the crate there, if there is one.
    #[test]
    fn board_in_another_folder_is_another_crate() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("board.toml");
        std::fs::copy(of_checkout("pyboard-v11").join("board.toml"), &file).unwrap();
        let board = Board::parse(&file.to_string_lossy()).unwrap();
        assert_eq!(board.board_crate(), BoardCrate::Elsewhere(&folder.path().canonicalize().unwrap()));
        let error = board.check_images("fly").unwrap_err().to_string();
        for part in ["no Cargo.toml", "pyboard-v11, nucleo-f446re", "a folder with Cargo.toml and board.toml"]
        {
            assert!(error.contains(part), "{error}");
        }
        std::fs::write(folder.path().join("Cargo.toml"), "").unwrap();
        assert_eq!(board.check_images("fly"), Ok(()));
        let shipped = of_checkout("pyboard-v11");
        let shipped = Board::parse(&shipped.to_string_lossy()).unwrap();
        assert_eq!(shipped.board_crate(), BoardCrate::Shipped("pyboard-v11"));
    }

    /// Given the pins of the pyboard, then they can be combined with any part whose package has them, and with another
    /// oscillator.
    #[test]
    fn other_part_has_the_pins_of_the_board_or_is_refused() {
        let pyboard = Board::shipped("pyboard-v11");
        let (part, oscillator) =
            (Part::named("STM32F407VG").unwrap(), description::oscillator("8MHz").unwrap());
        let other = pyboard.with(Some(part), Some(oscillator)).unwrap();
        assert_eq!((other.chip(), other.model().part), ("STM32F407VG", part));
        assert_eq!(other.model().oscillator.hz, 8_000_000);
        assert_eq!(other.model().pins, pyboard.model().pins);
        assert_eq!(other.name(), "pyboard-v11 with STM32F407VG, 8 MHz");
        assert_eq!(pyboard.with(None, None), Ok(pyboard.clone()));
        let text = "name = \"big\"\nchip = \"STM32F407VG\"\noscillator = { frequency = \"8MHz\", kind = \"crystal\" }\n\
                    can1 = { rx = \"PD0\", tx = \"PD1\" }\ncan2 = { rx = \"PB12\", tx = \"PB13\" }\n";
        let description = Arc::new(Description::parse(text, "board.toml").unwrap());
        let big = Board { description, elsewhere: None };
        let error = big.with(Some(pyboard.model().part), None).unwrap_err();
        assert!(error.contains("STM32F405RG has no pin PD0"), "{error}");
    }
}
