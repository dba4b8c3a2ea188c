//! What a seed decides before a flight: crystals, places on the bus, power-on times.

use can_wire::time::Time;

use super::observer::Access;
use super::options::Options;
use super::record::{Bus, MASTER, Node};
use support::board::Board;
use support::board::Profile;
use support::misuse::Misuse;

/// The mission profile that both images are built with.
pub const PROFILE: Profile = Profile::Librecube;

/// The slave with selective access in that profile.
const SELECTIVE: Node = 4;

/// Worst crystal in either direction, parts per million.
const CRYSTAL_PPM: f64 = 50.0;

/// Where the slaves sit, metres from the master's end of the bus.
const PLACES_M: std::ops::Range<f64> = 1.0..30.0;

/// Where the bus is cut, metres from the master.
const CUT_AT_M: f64 = 0.5;

/// Latest power-on of a board after the start of the flight, microseconds.
const POWER_ON_WITHIN_US: u64 = 300_000;

/// A board of the spacecraft.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardPlan {
    /// Node-ID; 1 is the master.
    pub node: Node,
    /// Error of its crystal, parts per million.
    pub crystal_ppm: f64,
    /// Place on both buses, metres from the master's end.
    pub position_m: f64,
    /// When it gets power.
    pub power_on: Time,
}

/// A flight to be flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Model of all boards.
    pub board: Board,
    /// Where the numbers below come from.
    pub seed: u64,
    /// Master first, then the slaves by Node-ID.
    pub boards: Vec<BoardPlan>,
    /// Length of the flight.
    pub end: Time,
    /// The cut: which bus, when, and how far from the master's end.
    pub cut: Option<CutPlan>,
}

/// A cut to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlan {
    /// The bus.
    pub bus: Bus,
    /// When.
    pub at: Time,
    /// Metres from the master's end.
    pub position_m: f64,
}

impl Default for Plan {
    /// The flight of `cargo demo` without options.
    fn default() -> Self {
        Plan::new(&Options::default()).expect("the defaults fit together")
    }
}

impl Plan {
    /// From the command line.
    ///
    /// # Errors
    /// When the cut lies after the end.
    pub fn new(options: &Options) -> Result<Plan, Misuse> {
        let mut random = fastrand::Rng::with_seed(options.seed);
        let boards = (MASTER..=MASTER + options.slaves)
            .map(|node| BoardPlan {
                node,
                crystal_ppm: (2.0 * random.f64() - 1.0) * CRYSTAL_PPM,
                position_m: match node {
                    MASTER => 0.0,
                    _ => PLACES_M.start + random.f64() * (PLACES_M.end - PLACES_M.start),
                },
                power_on: Time::from_us(random.u64(..POWER_ON_WITHIN_US)),
            })
            .collect();
        let cut = options.cut_second()?.map(|second| CutPlan {
            bus: Bus::Nominal,
            at: from_seconds(second),
            position_m: CUT_AT_M,
        });
        Ok(Plan { board: options.board, seed: options.seed, boards, end: from_seconds(options.seconds), cut })
    }

    /// The slaves and how they use the buses.
    pub fn slaves(&self) -> impl Iterator<Item = (Node, Access)> + '_ {
        self.boards.iter().filter(|board| board.node != MASTER).map(|board| {
            let access = if board.node == SELECTIVE { Access::Selective } else { Access::Parallel };
            (board.node, access)
        })
    }
}

fn from_seconds(seconds: f64) -> Time {
    Time::from_us((seconds * 1e6).round() as u64)
}
