//! The two spacecraft that upsets strike, and their flights without upset.
//!
//! | masters | profile | boards, from the left end of the cable |
//! | --- | --- | --- |
//! | 1 | `librecube` | master; slave 2 with parallel access; slave 4 with selective access |
//! | 2 | `standby` | prime master; second master; slave 2; minimal slave 5, which decides nothing, because the master does not know it |
//!
//! All are pyboards. At 3 s each full node saves its parameters. The *reference* is the flight without an upset, with its own fail-over
//! probe. It records which bytes of RAM the cores read or write first after each instant.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use anyhow::{Context, ensure};
use can_twin::board::{BoardConfig, Fittings, StateRegister, Uses};
use can_twin::crystal::Crystal;
use can_twin::guest::Presence;
use can_twin::image::Image;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, SpacecraftConfig};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::grid;
use super::outcome::PROBED_US;
use super::places::Places;
use super::record::{Record, Service};
use crate::images::support::board::{Board, Profile};
use crate::images::support::counters::Counters;
use crate::images::support::fleet::{self, image};
use crate::images::support::node::{MASTER, SECOND_MASTER};

/// End of the judged time, 12 to 13 s after an upset, microseconds. The probe follows. With a slave with selective access, which needs
/// 12.5 s to find the master after a change of the bus, flights that are not healthy then are judged again 16 s later.
pub const JUDGED_US: u64 = 18_000_000;
/// Number of instants at which the upsets of a campaign strike.
const INSTANTS: usize = 64;
/// Instant of upsets in the parameter store, and of the resets that other upsets are compared with.
pub const RESET_US: u64 = grid::at(grid::STEPS / 2);
/// Instants at which a flight may have become equal to the reference again, microseconds.
const COMPARED_US: [u64; 14] = [
    6_000_000, 6_500_000, 7_000_000, 7_500_000, 8_000_000, 9_000_000, 10_000_000, 11_000_000, 12_000_000,
    13_000_000, 14_000_000, 15_000_000, 16_500_000, JUDGED_US,
];
/// Instant at which all nodes save their parameters.
const SAVED: Time = Time::from_ms(3_000);

/// A board: number, position on the cable in metres, error of the crystal in ppm, power-on in milliseconds.
type Seat = (u8, f64, f64, u64);

const ONE_MASTER: [Seat; 3] = [(MASTER, 0.0, 12.0, 20), (2, 4.0, -31.0, 110), (4, 23.0, 48.0, 230)];
const TWO_MASTERS: [Seat; 4] =
    [(MASTER, 0.0, 12.0, 20), (SECOND_MASTER, 4.0, -31.0, 20), (2, 15.0, -5.0, 110), (5, 23.0, 48.0, 170)];
/// Node-ID of the minimal slave beside two masters.
const MINIMAL: u8 = 5;

/// Properties of a spacecraft.
struct Plan {
    profile: Profile,
    seats: &'static [Seat],
    /// Position at which the probe cuts the active bus: between masters and slaves.
    cut_m: f64,
    /// End of the judged time of flights that are not healthy at [`JUDGED_US`], microseconds.
    late_us: u64,
    /// Length of the probe, microseconds. A slave with selective access searches for 12.5 s.
    probe_us: u64,
}

fn plan(masters: u8) -> Plan {
    match masters {
        1 => Plan {
            profile: Profile::Librecube,
            seats: &ONE_MASTER,
            cut_m: 0.5,
            late_us: 34_000_000,
            probe_us: 18_000_000,
        },
        _ => Plan {
            profile: Profile::Standby,
            seats: &TWO_MASTERS,
            cut_m: 7.0,
            late_us: JUDGED_US,
            probe_us: 6_000_000,
        },
    }
}

/// Images of a spacecraft: master, slave, minimal slave.
struct Images {
    master: Arc<Image>,
    slave: Arc<Image>,
    minimal: Option<Arc<Image>>,
}

impl Images {
    fn prepare(masters: u8, no_build: bool) -> anyhow::Result<Images> {
        let board = Board::shipped(Board::DEFAULT);
        let profile = plan(masters).profile;
        let built = fleet::built(&board, profile, no_build)?;
        let minimal = if masters == 1 {
            None
        } else if no_build {
            let built = crate::images::built_minimal(board.board_crate(), profile.name());
            Some(image(&built.context("no minimal slave was built yet: leave out --no-build")?)?)
        } else {
            Some(image(&crate::images::build_minimal(
                board.board_crate(),
                profile.name(),
                crate::images::LOG,
            )?)?)
        };
        Ok(Images { master: image(&built.master)?, slave: image(&built.slave)?, minimal })
    }
}

/// A flight and its record.
#[derive(Clone)]
pub struct Flight {
    /// The spacecraft.
    pub craft: Spacecraft,
    /// What it showed since it was copied.
    pub record: Record,
    nodes: Vec<u8>,
}

impl Flight {
    /// Flies to `until`, with the stops of the grid.
    ///
    /// # Errors
    /// The access that the emulator refused.
    pub fn fly(&mut self, until: Time) -> Result<(), String> {
        while self.craft.now() < until {
            let next = grid::next(self.craft.now()).min(until);
            self.craft.run_until(next).map_err(|refused| refused.to_string())?;
            self.record.read(&mut self.craft, &self.nodes);
        }
        Ok(())
    }

    /// Returns whether this flight continues exactly as the reference, whose boards have these uses later.
    fn continues_as(&self, reference: &Flight, later: &[Uses]) -> bool {
        let counters = |flight: &Flight| {
            let read = |(_, board)| Counters::read(board).ok().flatten();
            flight.craft.boards().map(read).collect::<Vec<_>>()
        };
        self.record.continues_as(&reference.record)
            && self.craft.continues_as(&reference.craft, later)
            && counters(self) == counters(reference)
    }
}

/// Records of a flight that upsets are compared with.
#[derive(Default)]
pub struct Reference {
    /// Without a probe.
    pub calm: Record,
    /// With the probe at [`JUDGED_US`].
    pub probed: Record,
}

/// A value that threads copy in turn.
struct Shared<T>(Mutex<T>);

impl<T: Clone> Shared<T> {
    fn new(value: T) -> Shared<T> {
        Shared(Mutex::new(value))
    }

    /// Uses the value. It does not change, so a panic of another thread leaves it intact.
    fn with<R>(&self, look: impl FnOnce(&T) -> R) -> R {
        look(&self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn copy(&self) -> T {
        self.with(T::clone)
    }
}

/// One instant of upsets.
pub struct Moment {
    flight: Shared<Flight>,
    /// Stack pointer of each board.
    pub stacks: Vec<u32>,
    /// First uses of the RAM of each board from there to the end of the reference.
    pub uses: Vec<Uses>,
    /// Registers with state of each board.
    pub registers: Vec<Vec<StateRegister>>,
}

/// The reference at an instant at which flights may have become equal to it.
struct Compared {
    flight: Shared<Flight>,
    /// Uses of each board from there to the end of the reference.
    later: Vec<Uses>,
}

/// A spacecraft with its flights without upset.
pub struct World {
    plan: Plan,
    /// Number of masters: 1 or 2.
    pub masters: u8,
    base: Shared<Flight>,
    /// Node-ID of each board.
    nodes: Vec<u8>,
    /// Name of each board.
    names: Vec<String>,
    /// Instants of the campaign, by their microseconds.
    pub moments: BTreeMap<u64, Moment>,
    /// The flights without upset, from `grid::FIRST_US` on.
    pub reference: Reference,
    compared: BTreeMap<u64, Compared>,
    resets: Vec<OnceLock<Reference>>,
    /// Places in the memories of each board.
    pub places: Vec<Places>,
}

impl World {
    /// Builds the images, or uses those that were built last, and flies the reference. `seed` selects the instants.
    ///
    /// # Errors
    /// When images cannot be built or read, or the reference does not recover in its probe.
    ///
    /// # Panics
    /// When the emulator refuses an access of the images without an upset.
    pub fn prepare(masters: u8, seed: u64, no_build: bool) -> anyhow::Result<World> {
        let images = Images::prepare(masters, no_build)?;
        let plan = plan(masters);
        let base = base(&plan, &images);
        let boards = base.craft.boards().map(|(_, board)| Places::of(board)).collect();
        let names = base.craft.boards().map(|(_, board)| board.config().name.clone()).collect();
        let mut world = World {
            plan,
            masters,
            nodes: base.nodes.clone(),
            names,
            base: Shared::new(base),
            moments: BTreeMap::new(),
            reference: Reference::default(),
            compared: BTreeMap::new(),
            resets: Vec::new(),
            places: boards,
        };
        world.resets = world.places.iter().map(|_| OnceLock::new()).collect();
        world.fly_reference(instants(seed));
        let probed = &world.reference.probed;
        let span = world.probed_us() - PROBED_US..world.probed_us();
        ensure!(
            probed.count((MASTER, Service::Frames(0x701)), &span) > 0,
            "no master is heard after the probe"
        );
        Ok(world)
    }

    /// Flies the reference, and keeps copies at the instants and where flights are compared.
    fn fly_reference(&mut self, instants: Vec<u64>) {
        let mut flight = self.base.copy();
        let mut parts: BTreeMap<u64, Vec<Uses>> = BTreeMap::new();
        for us in instants {
            reach(&mut flight, us);
            parts.insert(us, take_uses(&mut flight.craft));
            let registers = flight.craft.boards().map(|(_, board)| board.state_registers()).collect();
            let copy = Flight { record: flight.record.fresh(), ..flight.clone() };
            let stacks = flight.craft.boards().map(|(_, board)| board.registers().r[13]).collect();
            let moment = Moment { flight: Shared::new(copy), stacks, uses: Vec::new(), registers };
            self.moments.insert(us, moment);
            watch(&mut flight.craft);
        }
        for us in COMPARED_US {
            reach(&mut flight, us);
            parts.insert(us, take_uses(&mut flight.craft));
            self.compared.insert(us, Compared { flight: Shared::new(flight.clone()), later: Vec::new() });
            watch(&mut flight.craft);
        }
        self.reference.calm = self.calm(&flight);
        self.probe(&mut flight).expect("a reference without refused accesses");
        self.reference.probed = flight.record.clone();
        // Later uses count where there were no earlier ones.
        let mut later = take_uses(&mut flight.craft);
        for (us, part) in parts.into_iter().rev() {
            if let Some(moment) = self.moments.get_mut(&us) {
                moment.uses.clone_from(&later);
            }
            if let Some(compared) = self.compared.get_mut(&us) {
                compared.later.clone_from(&later);
            }
            let joined = part.into_iter().zip(later).map(|(mut part, later)| {
                part.then(&later);
                part
            });
            later = joined.collect();
        }
    }

    /// Returns a flight at an instant of the grid.
    pub fn flight_at(&self, us: u64) -> Flight {
        if let Some(moment) = self.moments.get(&us) {
            return moment.flight.copy();
        }
        let mut flight = self.base.copy();
        reach(&mut flight, us);
        flight.record = flight.record.fresh();
        flight
    }

    /// Flies to the end of the judged time. Stops early where the flight continues as the reference does, with its probe. Returns the
    /// record completed by that of the reference then.
    ///
    /// # Errors
    /// The access that the emulator refused.
    pub fn fly_judged(&self, flight: &mut Flight) -> Result<Option<Record>, String> {
        for (us, Compared { flight: reference, later }) in &self.compared {
            let at = Time::from_us(*us);
            flight.fly(at)?;
            if reference.with(|reference| flight.continues_as(reference, later)) {
                let mut record = flight.record.clone();
                record.continue_as(&self.reference.calm, at);
                return Ok(Some(record));
            }
        }
        Ok(None)
    }

    /// Cuts the active bus between masters and slaves, switches the active one of two masters off, and flies to the end.
    ///
    /// # Errors
    /// The access that the emulator refused.
    pub fn probe(&self, flight: &mut Flight) -> Result<(), String> {
        if let Some((bus, board)) = flight.record.active {
            flight.craft.wire_mut(bus).cut(self.plan.cut_m);
            if self.masters == 2 {
                flight.craft.power(BoardId(board), false);
            }
        }
        let end = flight.craft.now() + Time::from_us(self.plan.probe_us);
        flight.fly(end)
    }

    /// Returns the record of a flight at [`JUDGED_US`] with what follows without a probe.
    fn calm(&self, flight: &Flight) -> Record {
        let mut calm = flight.clone();
        take_uses(&mut calm.craft);
        reach(&mut calm, self.plan.late_us);
        calm.record
    }

    /// Returns the flights in which the reset pin of a board is pulled at [`RESET_US`].
    ///
    /// # Panics
    /// When the emulator refuses an access of the images without an upset.
    pub fn reset(&self, board: usize) -> &Reference {
        self.resets[board].get_or_init(|| {
            let mut flight = self.flight_at(RESET_US);
            flight.craft.reset(BoardId(board));
            reach(&mut flight, JUDGED_US);
            let calm = self.calm(&flight);
            self.probe(&mut flight).expect("a reset without refused accesses");
            Reference { calm, probed: flight.record }
        })
    }

    /// Returns the end of the judged time of flights that are not healthy at [`JUDGED_US`], microseconds.
    pub fn late_us(&self) -> u64 {
        self.plan.late_us
    }

    /// Returns the end of the probe of the reference, microseconds.
    pub fn probed_us(&self) -> u64 {
        JUDGED_US + self.plan.probe_us
    }

    /// Returns the Node-ID of a board.
    pub fn node(&self, board: usize) -> u8 {
        self.nodes[board]
    }

    /// Returns the name of a board.
    pub fn board_name(&self, board: usize) -> &str {
        &self.names[board]
    }
}

/// Returns the instants of a campaign, ascending.
fn instants(seed: u64) -> Vec<u64> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut numbers = random.choose_multiple(0..grid::STEPS, INSTANTS);
    numbers.sort_unstable();
    numbers.into_iter().map(grid::at).collect()
}

fn reach(flight: &mut Flight, us: u64) {
    flight.fly(Time::from_us(us)).expect("a flight without refused accesses");
}

fn boards(craft: &Spacecraft) -> impl Iterator<Item = BoardId> + use<> {
    (0..craft.boards().count()).map(BoardId)
}

fn watch(craft: &mut Spacecraft) {
    boards(craft).for_each(|id| craft.board_mut(id).watch_memory());
}

fn take_uses(craft: &mut Spacecraft) -> Vec<Uses> {
    boards(craft).filter_map(|id| craft.board_mut(id).take_uses()).collect()
}

/// Flies to the first instant of upsets.
fn base(plan: &Plan, images: &Images) -> Flight {
    let board = Board::shipped(Board::DEFAULT);
    let mut craft = Spacecraft::new(SpacecraftConfig::default());
    let node = |number| if number == SECOND_MASTER { MASTER } else { number };
    for &(number, position_m, ppm, power_on_ms) in plan.seats {
        let (name, image) = match number {
            MASTER => ("master".to_owned(), &images.master),
            SECOND_MASTER => ("second master".to_owned(), &images.master),
            _ => match &images.minimal {
                Some(minimal) if number == MINIMAL => (format!("minimal slave {number}"), minimal),
                _ => (format!("slave {number}"), &images.slave),
            },
        };
        craft.add_board(BoardConfig {
            name,
            model: board.model(),
            image: image.clone(),
            straps: board.straps(number),
            crystal: Crystal::ppm(ppm),
            position_m,
            power_on_at: Time::from_ms(power_on_ms),
            fittings: Fittings::default(),
        });
    }
    let guest = craft.add_guest(Bus::Nominal, 30.0);
    craft.set_presence(guest, Presence::Away);
    boards(&craft).for_each(|id| craft.board_mut(id).tolerate_upsets());
    let nodes: Vec<u8> = plan.seats.iter().map(|(number, ..)| node(*number)).collect();
    let mut flight = Flight { craft, record: Record::default(), nodes };
    flight.fly(SAVED).expect("a start without refused accesses");
    flight.craft.set_presence(guest, Presence::Present);
    for (node, at_ms) in flight.nodes.clone().into_iter().zip((0..).step_by(100)) {
        let save = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
        let frame = WireFrame::standard(0x600 + u16::from(node), &save);
        flight.craft.inject(guest, SAVED + Time::from_ms(at_ms), frame);
    }
    flight.fly(SAVED + Time::from_ms(500)).expect("saves without refused accesses");
    flight.craft.set_presence(guest, Presence::Away);
    reach(&mut flight, grid::FIRST_US);
    flight.record = flight.record.fresh();
    flight
}
