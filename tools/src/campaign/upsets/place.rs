//! Places of upsets, and one upset as a line of text.

use std::fmt;
use std::str::FromStr;

use can_twin::board::CoreRegister;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::grid;

/// Kind of a place that an upset strikes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// Variables and the part of the stack that is in use.
    Ram,
    /// R0 to R15, xPSR and S0 to S31.
    Core,
    /// PRIMASK, BASEPRI and FAULTMASK.
    Masks,
    /// Registers of the peripherals that have a clock, and of NVIC, SysTick, system control block and MPU.
    Peripherals,
    /// The program in flash.
    Flash,
    /// The parameter store in flash. The board is reset after the upset, because it reads the store at its start.
    Store,
}

impl Place {
    /// All places, in the order of the table.
    pub const ALL: [Place; 6] =
        [Place::Ram, Place::Core, Place::Masks, Place::Peripherals, Place::Flash, Place::Store];

    /// Returns the name in options and texts.
    pub fn name(self) -> &'static str {
        match self {
            Place::Ram => "ram",
            Place::Core => "core",
            Place::Masks => "masks",
            Place::Peripherals => "peripherals",
            Place::Flash => "flash",
            Place::Store => "store",
        }
    }
}

/// Register or byte that an upset changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A core register.
    Core(CoreRegister),
    /// Address of a byte of memory, or of a register of a peripheral.
    Address(u32),
}

/// One upset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Upset {
    /// Number of masters, which selects the spacecraft: 1 or 2.
    pub masters: u8,
    /// Kind of the place.
    pub place: Place,
    /// Index of the board, in the order of the cable.
    pub board: usize,
    /// Instant in microseconds, a point of the grid.
    pub at_us: u64,
    /// Byte or register.
    pub target: Target,
    /// Bit of the byte (0 to 7) or of the register (0 to 31).
    pub bit: u32,
}

impl fmt::Display for Upset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Upset { masters, place, board, at_us, target, bit } = self;
        write!(f, "upset masters={masters} place={} board={board} at={at_us} ", place.name())?;
        match target {
            Target::Core(register) => write!(f, "register={register} bit={bit}"),
            Target::Address(address) => write!(f, "address={address:08X} bit={bit}"),
        }
    }
}

impl FromStr for Upset {
    type Err = String;

    /// Parses the first line that is neither empty nor a comment.
    fn from_str(text: &str) -> Result<Upset, String> {
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let line = lines.next().ok_or("no line `upset masters=.. place=.. board=.. at=.. ..`")?;
        let mut words = line.split_whitespace();
        if words.next() != Some("upset") {
            return Err(format!("`{line}`: expected `upset` and pairs KEY=VALUE"));
        }
        let pairs: Vec<(&str, &str)> = words.filter_map(|word| word.split_once('=')).collect();
        let find = |key: &str| pairs.iter().find(|(name, _)| *name == key).map(|(_, value)| *value);
        let value = |key: &str| find(key).ok_or_else(|| format!("`{line}`: {key}=.. is missing"));
        let number = |key: &str, allowed: std::ops::RangeInclusive<u64>| {
            let text = value(key)?;
            let number = text.parse().ok().filter(|number| allowed.contains(number));
            number
                .ok_or_else(|| format!("{key}={text}, allowed are {} to {}", allowed.start(), allowed.end()))
        };
        let place = value("place")?;
        let place = Place::ALL.into_iter().find(|other| other.name() == place).ok_or_else(|| {
            format!("place={place}, allowed are {}", Place::ALL.map(Place::name).join(", "))
        })?;
        let target = match (find("register"), find("address")) {
            (Some(name), None) => {
                let register = CoreRegister::all().find(|register| register.to_string() == name);
                Target::Core(register.ok_or(format!("register={name}: no core register"))?)
            }
            (None, Some(address)) => {
                let parsed = u32::from_str_radix(address, 16);
                Target::Address(parsed.map_err(|_| format!("address={address}: no hexadecimal number"))?)
            }
            _ => return Err(format!("`{line}`: expected register=.. or address=..")),
        };
        if matches!(target, Target::Core(_)) != matches!(place, Place::Core | Place::Masks) {
            return Err(format!("`{line}`: core registers are the places core and masks, and no others"));
        }
        let at_us = number("at", grid::FIRST_US..=grid::at(grid::STEPS - 1))?;
        if !grid::is_on(at_us) {
            let step = grid::STEP_US;
            return Err(format!("at={at_us}, allowed are {} and steps of {step}", grid::FIRST_US));
        }
        let masters = number("masters", 1..=2)?;
        Ok(Upset {
            masters: masters as u8,
            place,
            // Beside the masters there are two slaves.
            board: number("board", 0..=masters + 1)? as usize,
            at_us,
            target,
            bit: number("bit", 0..=31)? as u32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "upset masters=2 place=ram board=1 at=5001009 address=2000ABCD bit=3";

    #[test]
    fn text_of_an_upset_is_read_again() {
        let core = "upset masters=1 place=core board=0 at=5000000 register=S31 bit=30";
        let minimal = "upset masters=2 place=ram board=3 at=5001009 address=2000ABCD bit=3";
        for text in [TEXT, core, minimal] {
            assert_eq!(text.parse::<Upset>().map(|upset| upset.to_string()).as_deref(), Ok(text));
        }
        assert!(format!("# a comment\n\n{TEXT}\n").parse::<Upset>().is_ok());
    }

    #[test]
    fn wrong_text_is_refused_with_what_is_allowed() {
        for (from, to, said) in [
            ("place=ram", "place=moon", "ram, core, masks"),
            ("at=5001009", "at=5001010", "steps of 1009"),
            ("at=5001009", "at=1", "5000000"),
            ("masters=2", "masters=3", "1 to 2"),
            ("masters=2 place=ram board=1", "masters=1 place=ram board=3", "0 to 2"),
            ("board=1", "board=4", "0 to 3"),
            ("bit=3", "", "bit=.. is missing"),
            ("address=2000ABCD", "register=R1", "the places core and masks"),
            ("address=2000ABCD", "address=xyz", "hexadecimal"),
            ("upset", "cut", "expected `upset`"),
        ] {
            let error = TEXT.replace(from, to).parse::<Upset>().expect_err(to);
            assert!(error.contains(said), "{to}: {error}");
        }
        assert!("".parse::<Upset>().is_err());
    }
}
