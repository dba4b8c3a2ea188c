//! Plan of a flight: its boards, images and faults. The seed determines crystals, positions on the bus and power-on
//! times, unless they are given.

mod given;

use std::collections::BTreeSet;
use std::sync::Arc;

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::{Crystal, Ramp};
use can_twin::image::Image;
use can_twin::wire::time::Time;

use super::criterion::Criterion;
use super::fault::{Cause, Fault};
use super::meaning::Scope;
use super::options::{Options, SECONDS};
use super::record::{Bus, CutPlan};
use super::setup::Setup;
use crate::images::support::board::{Board, Profile};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{MASTER, Node, SECOND_MASTER, is_master};

/// The slaves with selective access in the profile `librecube`.
const SELECTIVE: [Node; 2] = [4, 6];

/// Worst crystal in either direction, parts per million.
const CRYSTAL_PPM: f64 = 50.0;

/// Change of a crystal's frequency while its board warms up, parts per million: up at even Node-IDs, down at odd ones.
const WARMING_PPM: f64 = 4.0;

/// Time in which a board warms up: 0.1 ppm/s.
const WARM: Time = Time::from_ms(40_000);

/// White noise of the frequency at 1 s, and its random walk in 1 s, parts per billion.
const WHITE_PPB: f64 = 1.0;
const WALK_PPB: f64 = 2.0;

/// Positions of the slaves, metres from the master's end of the bus.
const PLACES_M: std::ops::Range<f64> = 1.0..30.0;

/// Position of the second one of two masters, metres from the other one: the far end of the bus, behind all slaves.
const SECOND_AT_M: f64 = 31.0;

/// Position of the cut in a flight with one master, metres from the master.
const CUT_AT_M: f64 = 0.5;

/// With two masters the active one loses its power at the second of `--cut-at`. At these shares of that second the standby is
/// reset, and the bus is cut.
const RESET_SHARE: f64 = 0.25;
const CUT_SHARE: f64 = 0.5;

/// Latest power-on of a board after the start of the flight.
const POWER_ON_WITHIN: Time = Time::from_ms(300);

/// Time that a slave with selective access needs in addition to its search: start, boot-up and first command.
const FOUND_WITHIN: Time = Time::from_ms(500);

/// Time from the power-on of a board to its boot-up message: 12 ms, and some reserve.
const BOOTED_WITHIN: Time = Time::from_ms(50);

/// Shortest time that the master stays on a bus while it hears no slave: `dwell` of all profiles.
const SHORTEST_DWELL: Time = Time::from_ms(10_000);

/// Earliest loss of the active master: one is active at a quarter of this time, when the demo resets the other one.
const EARLIEST_LOSS: Time = Time::from_ms(5_000);

/// Longest time from the loss of the active master to slaves that are operational again.
const TAKEN_OVER_WITHIN: Time = Time::from_ms(1_000);

/// Access of a slave to the two buses (ECSS 4.8.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusAccess {
    /// Both buses at the same time.
    Parallel,
    /// One bus at a time.
    Selective,
    /// Determined by an image of the user's.
    Unknown,
}

impl BusAccess {
    /// Returns the term of the standard, if it is known.
    pub fn name(self) -> &'static str {
        match self {
            BusAccess::Parallel => "parallel",
            BusAccess::Selective => "selective",
            BusAccess::Unknown => "",
        }
    }
}

/// A board of the spacecraft.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardPlan {
    /// Its number.
    pub node: Node,
    /// File name of the user's image on it; `None`: the shipped one.
    pub own_image: Option<String>,
    /// It runs the shipped image of the minimal slave.
    pub is_minimal: bool,
    /// It has one controller and two transceivers.
    pub has_one_controller: bool,
    /// Its crystal, which drifts while the board warms up, and makes noise.
    pub crystal: Crystal,
    /// Position on both buses, metres from the master's end.
    pub position_m: f64,
    /// Time of its power-on.
    pub power_on: Time,
}

impl BoardPlan {
    /// Returns the name of its image in texts.
    pub fn image(&self) -> &str {
        self.own_image.as_deref().unwrap_or("shipped")
    }

    /// Replaces what the seed chose by what is given.
    fn set_up(&mut self, setup: Setup) {
        if let Some(place_m) = setup.place_m {
            self.position_m = place_m;
        }
        if let Some(ppm) = setup.crystal_ppm {
            self.crystal = crystal(self.node, ppm);
        }
        if let Some(drift_ppm_per_s) = setup.drift_ppm_per_s {
            (self.crystal.drift_ppm_per_s, self.crystal.ramp) = (drift_ppm_per_s, None);
        }
        if let Some(second) = setup.power_on {
            self.power_on = from_seconds(second);
        }
    }

    /// Returns the configuration of this board on the twin, with a crystal of constant frequency.
    pub fn config(&self, board: &Board, name: String, image: Arc<Image>) -> BoardConfig {
        let model = board.model();
        BoardConfig {
            name,
            model,
            image,
            straps: board.straps(self.node),
            crystal: Crystal::ppm(self.crystal.ppm),
            position_m: self.position_m,
            power_on_at: self.power_on,
            fittings: Fittings {
                transceiver_switch: model.pins.transceiver_switch.filter(|_| self.has_one_controller),
                ..Fittings::default()
            },
        }
    }
}

/// Plan of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Model of the boards with shipped images.
    pub board: Board,
    /// Model of the boards with images of the user's.
    pub own_board: Board,
    /// Mission profile of the shipped images.
    pub profile: Profile,
    /// Seed of crystals, positions and power-on times.
    pub seed: u64,
    /// Master first, then the slaves by Node-ID, then the second master, if there is one.
    pub boards: Vec<BoardPlan>,
    /// Length of the flight.
    pub end: Time,
    /// Faults, those of one instant in the order in which they are caused.
    pub faults: Vec<Fault>,
    /// What must hold in addition to what always must.
    pub criteria: Vec<Criterion>,
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
    /// When the cut lies after the end, or a part is given that lacks pins of the board.
    pub fn new(options: &Options) -> Result<Plan, Misuse> {
        let mut boards = boards(options.seed, &options.nodes());
        for board in &mut boards {
            board.set_up(options.setup(board.node));
            let file = options.fleet.own_image(board.node).and_then(|path| path.file_name());
            board.own_image = file.map(|name| name.to_string_lossy().into_owned());
            board.is_minimal = options.minimal_nodes().contains(&board.node);
            board.has_one_controller = options.one_controller_nodes().contains(&board.node);
        }
        let fault = options.cut_second()?;
        let at = |share| fault.map(|second| from_seconds(share * second));
        let has_standby = boards.iter().any(|board| board.node == SECOND_MASTER);
        let (cut_at, position_m) = if has_standby {
            (at(CUT_SHARE), between_halves(&boards))
        } else {
            (at(1.0), boards[0].position_m + CUT_AT_M)
        };
        let of_masters = |at: Option<Time>, cause| at.filter(|_| has_standby).map(|at| Fault::new(at, cause));
        let reset = of_masters(at(RESET_SHARE), Cause::ResetStandby);
        let cut = cut_at.map(|at| Fault::cut(CutPlan { bus: Bus::Nominal, at, position_m }));
        let loss = of_masters(at(1.0), Cause::LoseActive);
        let faults = options.faults.clone().into_iter().map(|fault| Fault {
            at: from_seconds(fault.second),
            cause: Cause::Command(fault.command),
            origin: fault.origin,
        });
        let plan = Plan {
            board: options.fleet.target.board.clone(),
            own_board: options.fleet.own_board("fly")?,
            profile: options.fleet.target.profile,
            seed: options.seed,
            boards,
            end: from_seconds(options.seconds),
            faults: [reset, cut, loss].into_iter().flatten().chain(faults).collect(),
            criteria: options.criteria.clone(),
        };
        plan.check_faults()?;
        plan.check_criteria()?;
        Ok(plan)
    }

    /// The first cut of a bus.
    pub fn cut(&self) -> Option<CutPlan> {
        self.faults.iter().find_map(Fault::as_cut)
    }

    /// Time at which the standby of two masters is reset.
    pub fn standby_reset(&self) -> Option<Time> {
        self.time_of(&Cause::ResetStandby)
    }

    /// Time at which the active one of two masters loses its power.
    pub fn loss(&self) -> Option<Time> {
        self.time_of(&Cause::LoseActive)
    }

    fn time_of(&self, cause: &Cause) -> Option<Time> {
        self.faults.iter().find(|fault| fault.cause == *cause).map(|fault| fault.at)
    }

    /// Checks that the flight is long enough for its verdict: every slave can be operational again after the last
    /// fault.
    ///
    /// # Errors
    /// When it is shorter: the reason, and the allowed lengths.
    pub fn check_length(&self, options: &Options) -> Result<(), Misuse> {
        // Faults of the user's are not judged by it: what must hold after them is in the criteria.
        let Some(fault) = options.cut_second()?.map(from_seconds) else { return Ok(()) };
        if self.loss().is_some_and(|loss| loss < EARLIEST_LOSS) {
            let (least, end) = (EARLIEST_LOSS.as_secs_f64(), options.seconds);
            let cause = format!(
                "with two masters one of them must be active before the faults begin; allowed are {least} to {end}, the value of \
                 --seconds, or never"
            );
            return Err(Misuse::value("fly", "--cut-at <S>", fault.as_secs_f64(), cause));
        }
        let needed = |fault| {
            let takeover = self.loss().map(|_| {
                (TAKEN_OVER_WITHIN, "slaves are operational again under the other master".to_owned())
            });
            self.longest_search(fault).into_iter().chain(takeover).max_by_key(|(needs, _)| *needs)
        };
        let Some((needs, why)) = needed(fault) else { return Ok(()) };
        if self.end >= fault + needs {
            return Ok(());
        }
        let least = match options.cut_at {
            None => {
                // The cut is half-way: in a longer flight it is later.
                let later = needed(fault.max(self.heard_by())).map_or(Time::ZERO, |(needs, _)| needs);
                2.0 * later.max(self.heard_by()).as_secs_f64()
            }
            Some(_) => (fault + needs).as_secs_f64(),
        };
        let (fault, needs, most) = (fault.as_secs_f64(), needs.as_secs_f64(), SECONDS.end());
        let what = if self.loss().is_some() { "the loss of the master" } else { "the cut" };
        let cause = format!(
            "{why} up to {needs} s after {what} at {fault} s; allowed are {least} to {most}, or --cut-at never"
        );
        Err(Misuse::value("fly", "--seconds <S>", options.seconds, cause))
    }

    /// Longest time from the cut until all shipped slaves are operational again, and the reason; `None` if they follow the master
    /// at once.
    fn longest_search(&self, cut: Time) -> Option<(Time, String)> {
        let selective = self.slaves().find(|(_, access)| *access == BusAccess::Selective);
        let search = self.toggling_time() + FOUND_WITHIN;
        if cut >= self.heard_by() {
            return selective.map(|(node, _)| {
                (search, format!("node {node} has selective access and is operational again"))
            });
        }
        let parallel = self.slaves().find(|(_, access)| *access == BusAccess::Parallel);
        let (node, search) = match (selective, parallel) {
            (Some((node, _)), _) => (node, search),
            (None, Some((node, _))) => (node, FOUND_WITHIN),
            (None, None) => return None,
        };
        let why =
            format!("the master may not have heard a slave before the cut, and node {node} is operational");
        Some((POWER_ON_WITHIN + self.dwell() + search, why))
    }

    /// Returns the time by which the master has heard a slave, unless its bus is cut before: all boards are on, and
    /// have sent a heartbeat.
    fn heard_by(&self) -> Time {
        POWER_ON_WITHIN + BOOTED_WITHIN + self.heartbeat()
    }

    /// Returns the time that the master stays on a bus while it hears no slave (`Profile::dwell` of the images).
    fn dwell(&self) -> Time {
        let search = self.toggling_time() + self.toggling_time() + self.heartbeat() + self.heartbeat();
        search.max(SHORTEST_DWELL)
    }

    /// Returns the model of the boards with shipped images, or that of the others if there are none.
    pub fn flown(&self) -> &Board {
        let is_shipped = self.boards.iter().any(|board| board.own_image.is_none());
        if is_shipped { &self.board } else { &self.own_board }
    }

    /// Model of a board.
    pub fn model(&self, board: &BoardPlan) -> &Board {
        if board.own_image.is_some() { &self.own_board } else { &self.board }
    }

    /// Returns the position of a cut among the boards as text.
    pub fn place(&self, cut: &CutPlan) -> &'static str {
        let mut slaves = self.boards.iter().filter(|board| !is_master(board.node));
        let is_behind = |board: &BoardPlan| board.position_m > cut.position_m;
        match () {
            () if slaves.clone().all(is_behind) => "next to the master",
            () if slaves.any(is_behind) => "between the slaves",
            () => "behind the last slave",
        }
    }

    /// Returns the other one of two master boards.
    pub fn other_master(&self, board: Node) -> Option<Node> {
        self.boards.iter().map(|other| other.node).find(|node| is_master(*node) && *node != board)
    }

    /// Returns the scope of the traffic that is decoded.
    pub fn scope(&self) -> Scope {
        let is_shipped = self.boards.iter().all(|board| board.own_image.is_none());
        if is_shipped { Scope::Mission } else { Scope::Protocol }
    }

    /// The slaves and how they use the buses.
    pub fn slaves(&self) -> impl Iterator<Item = (Node, BusAccess)> + '_ {
        self.boards.iter().filter(|board| !is_master(board.node)).map(|board| {
            let access = match (board.own_image.is_some(), self.profile, board.node) {
                (true, ..) => BusAccess::Unknown,
                _ if board.has_one_controller => BusAccess::Selective,
                (false, Profile::Librecube, node) if SELECTIVE.contains(&node) => BusAccess::Selective,
                (false, ..) => BusAccess::Parallel,
            };
            (board.node, access)
        })
    }

    /// Ttoggle of the shipped slaves.
    pub fn ttoggle(&self) -> u64 {
        match self.profile {
            Profile::Librecube => 5,
            Profile::Standard | Profile::Standby => 2,
        }
    }

    /// Returns the time that they listen on one bus: Ttoggle consumer times.
    pub fn toggling_time(&self) -> Time {
        Time::from_us(self.consumer_time().as_us() * self.ttoggle())
    }

    /// Heartbeat period of the shipped images.
    fn heartbeat(&self) -> Time {
        match self.profile {
            Profile::Librecube => Time::from_ms(250),
            Profile::Standard | Profile::Standby => Time::from_ms(100),
        }
    }

    /// Heartbeat consumer time of the shipped slaves.
    pub fn consumer_time(&self) -> Time {
        match self.profile {
            Profile::Librecube => Time::from_ms(2500),
            Profile::Standard | Profile::Standby => Time::from_ms(250),
        }
    }
}

/// Returns boards with crystals, positions and power-on times by the seed. Those of a node do not depend on the other
/// nodes.
pub fn boards(seed: u64, nodes: &BTreeSet<Node>) -> Vec<BoardPlan> {
    let mut random = fastrand::Rng::with_seed(seed);
    let last = nodes.last().copied().unwrap_or(MASTER);
    (MASTER..=last)
        .map(|node| BoardPlan {
            node,
            own_image: None,
            is_minimal: false,
            has_one_controller: false,
            crystal: crystal(node, (2.0 * random.f64() - 1.0) * CRYSTAL_PPM),
            position_m: match node {
                MASTER => 0.0,
                SECOND_MASTER => SECOND_AT_M,
                _ => PLACES_M.start + random.f64() * (PLACES_M.end - PLACES_M.start),
            },
            power_on: Time::from_us(random.u64(..POWER_ON_WITHIN.as_us())),
        })
        .filter(|board| nodes.contains(&board.node))
        .collect()
}

/// Returns the crystal of a board with this error at time zero, in parts per million.
pub fn crystal(node: Node, ppm: f64) -> Crystal {
    let warming = if node.is_multiple_of(2) { WARMING_PPM } else { -WARMING_PPM };
    Crystal {
        ramp: Some(Ramp { from: Time::ZERO, to: WARM, ppm: warming }),
        white_ppb: WHITE_PPB,
        walk_ppb: WALK_PPB,
        // Derived from the error, and so different for each board.
        seed: ppm.to_bits(),
        ..Crystal::ppm(ppm)
    }
}

/// Returns the position half-way between the two slaves in the middle of the bus, metres. With an odd number of slaves
/// the half of the first master has one more; with one slave, the other half contains only the second master.
fn between_halves(boards: &[BoardPlan]) -> f64 {
    let slaves = boards.iter().filter(|board| !is_master(board.node));
    let mut places: Vec<f64> = slaves.map(|board| board.position_m).collect();
    places.sort_by(f64::total_cmp);
    let first_half = places.len().div_ceil(2);
    places.push(SECOND_AT_M);
    places[..=first_half].iter().rev().take(2).sum::<f64>() / 2.0
}

fn from_seconds(seconds: f64) -> Time {
    Time::from_us((seconds * 1e6).round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(slaves: u8) -> Plan {
        let mut options = Options::default();
        options.fleet.target.profile = Profile::Standby;
        options.fleet.slaves = slaves;
        Plan::new(&options).expect("the options fit together")
    }

    #[test]
    fn what_is_given_replaces_what_the_seed_chose() {
        let mut board = boards(1, &[5].into()).remove(0);
        let before = board.clone();
        board.set_up(Setup::default());
        assert_eq!(board, before);
        board.set_up(Setup { place_m: Some(7.0), drift_ppm_per_s: Some(0.5), ..Setup::default() });
        assert_eq!((board.position_m, board.crystal.ppm), (7.0, before.crystal.ppm));
        assert_eq!((board.crystal.drift_ppm_per_s, board.crystal.ramp), (0.5, None));
    }

    #[test]
    fn flight_of_two_masters_has_three_faults() {
        let plan = planned(3);
        let at = [plan.standby_reset(), plan.cut().map(|cut| cut.at), plan.loss()];
        assert_eq!(at, [5, 10, 20].map(|second| Some(Time::from_ms(1000 * second))));
        let one = Plan::default();
        assert_eq!((one.standby_reset(), one.loss()), (None, None));
        let cut = one.cut().map(|cut| (cut.at, one.place(&cut)));
        assert_eq!(cut, Some((Time::from_ms(20_000), "next to the master")));
    }

    /// Given 1, 2, 3 or 14 slaves, then the half of the first master has 1, 1, 2 or 7 of them, and the second master is in the other
    /// half.
    #[test]
    fn cut_parts_the_slaves_into_halves() {
        for (slaves, first_half) in [(1, 1), (2, 1), (3, 2), (14, 7)] {
            let plan = planned(slaves);
            let cut = plan.cut().expect("a cut");
            let near = plan.boards.iter().filter(|board| board.position_m < cut.position_m);
            let near = near.filter(|board| !is_master(board.node)).count();
            assert_eq!(near, first_half, "{slaves} slaves");
            let mut far = plan.boards.iter().filter(|board| board.position_m > cut.position_m);
            assert!(far.any(|board| board.node == SECOND_MASTER), "{slaves} slaves");
            let place = if slaves == 1 { "behind the last slave" } else { "between the slaves" };
            assert_eq!(plan.place(&cut), place, "{slaves} slaves");
        }
    }
}
