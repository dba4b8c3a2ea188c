//! A master and three slaves whose clocks are compared by their pulses.
//!
//! The spacecraft is that of the requirement: slaves at 1, 10 and 20 m from the master, crystals of up to ±50 ppm that
//! drift by 0.1 ppm/s, at the master and at two slaves in opposite directions, with noise; transceivers of 150 ns with
//! errors of ±20 ns, half in the driver and half in the receiver. A guest configures the boards by SDO, as a user
//! would.

use std::sync::LazyLock;

use anyhow::{Context as _, ensure};
use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::{Crystal, Ramp};
use can_twin::guest::GuestEvent;
use can_twin::pin::Pin;
use can_twin::pulses::{Errors, Trial};
use can_twin::spacecraft::{BoardId, Bus, GuestId, Spacecraft, SpacecraftConfig};
use can_twin::traffic::Traffic;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use can_twin::wire::transceiver::Transceiver;
use ecss_can::types::Address;
use ecss_can_cli::fly::stamps::{StampErrors, StampWatch};
use ecss_can_cli::images::Images;
use ecss_can_cli::images::support::fleet;

use crate::bench::context::{FLOWN, board};

/// Node-ID (1 is the master), metres, parts per million, parts per million per second.
const BOARDS: [(u8, f64, f64, f64); 4] =
    [(1, 0.0, 50.0, -0.1), (2, 1.0, -50.0, 0.1), (3, 10.0, 17.0, -0.1), (4, 20.0, -38.0, 0.1)];

/// White noise of the frequency at 1 s, and its random walk in 1 s, parts per billion.
const WHITE_PPB: f64 = 1.0;
const WALK_PPB: f64 = 2.0;

/// Delay of a transceiver, out and in together, ns. The error of each follows.
const TRANSCEIVER_NS: u32 = 150;
const TRANSCEIVER_SPREAD_NS: u32 = 20;
const CABLE_NS_PER_M: f64 = 5.0;
/// Relative error of the user's lengths, which are too long.
const LENGTH_ERROR: f64 = 0.1;

/// Returns the largest constant error that a correction may leave, ns: of the farthest slave's length, and of half a
/// loop at either end.
pub fn most_left_ns() -> f64 {
    let farthest = BOARDS.iter().map(|key| key.1).fold(0.0, f64::max);
    LENGTH_ERROR * CABLE_NS_PER_M * farthest + f64::from(TRANSCEIVER_SPREAD_NS)
}

/// Pin of the pulses.
static PULSE: LazyLock<Pin> = LazyLock::new(|| FLOWN.model().pins.pulse.expect("the board makes pulses"));
/// Period of pulses in spacecraft time.
pub const PULSE_PERIOD: Time = Time::from_ms(10);

/// Objects of the boards.
const SYNC_PERIOD: Address = Address::new(0x1006, 0);
const DELAY_NOMINAL: Address = Address::new(0x2014, 1);
const DELAY_REDUNDANT: Address = Address::new(0x2014, 2);
const BOUND: Address = Address::new(0x2015, 1);
const STEPS: Address = Address::new(0x2015, 5);
const PULSES_PER_SECOND: Address = Address::new(0x6310, 0);

/// Writes that make the master send the spacecraft time after each SYNC: TPDO 1, invalid while its type is changed.
const EVERY_SYNC: [(Address, u32, u8); 3] = [
    (Address::new(0x1800, 1), 0xC000_0181, 4),
    (Address::new(0x1800, 2), 1, 1),
    (Address::new(0x1800, 1), 0x4000_0181, 4),
];

/// Time at which all nodes are operational.
const UP: Time = Time::from_ms(700);
/// Time at which all nodes are configured and traffic starts.
const CONFIGURED: Time = Time::from_ms(1_000);
/// Longest time until an answer to a client.
const PATIENCE: Time = Time::from_ms(300);

/// Parameters of a flight.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Period of SYNC and of the spacecraft time.
    pub sync: Time,
    /// Share of the time for which foreign frames keep the nominal bus busy.
    pub load: f64,
    /// Boards that have the jumper wires to the capture inputs.
    pub wires: Wires,
    /// Whether delays are configured.
    pub corrected: bool,
    /// Crystals of the boards.
    pub crystals: Crystals,
}

/// Boards with the jumper wires to the capture inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wires {
    /// All boards.
    All,
    /// Only slaves.
    Slaves,
    /// No board.
    None,
}

impl Wires {
    fn of(self, node: u8) -> bool {
        match self {
            Wires::All => true,
            Wires::Slaves => node != 1,
            Wires::None => false,
        }
    }
}

/// Behaviour of the boards' crystals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crystals {
    /// Those of the requirement.
    Required,
    /// Those of the requirement, which drift until then and keep their frequency afterwards.
    Settling(Time),
    /// They do not drift, except that those of the slaves change by 2 ppm within 10 s.
    Ramp,
    /// That of the master is 100 ppm fast, those of the slaves are 100 ppm slow. They drift by 0.02 ppm/s.
    Far,
}

/// Times at which the temperature of slaves changes.
const RAMP: Ramp = Ramp { from: Time::from_ms(32_300), to: Time::from_ms(42_300), ppm: 2.0 };

impl Crystals {
    /// Returns the crystal of a node, without noise.
    fn of(self, node: u8, ppm: f64, drift_ppm_per_s: f64) -> Crystal {
        match self {
            Crystals::Required => Crystal { drift_ppm_per_s, ..Crystal::ppm(ppm) },
            Crystals::Settling(end) => {
                let ramp = Ramp { from: Time::ZERO, to: end, ppm: drift_ppm_per_s * end.as_secs_f64() };
                Crystal { ramp: Some(ramp), ..Crystal::ppm(ppm) }
            }
            Crystals::Ramp if node == 1 => Crystal::ppm(ppm),
            Crystals::Ramp => Crystal { ramp: Some(RAMP), ..Crystal::ppm(ppm) },
            Crystals::Far => {
                let ppm = if node == 1 { 100.0 } else { -100.0 };
                Crystal { drift_ppm_per_s: drift_ppm_per_s / 5.0, ..Crystal::ppm(ppm) }
            }
        }
    }
}

/// A flight.
pub struct Flight {
    trial: Trial,
    client: GuestId,
    stamps: StampWatch,
}

impl Flight {
    /// Flies until all nodes are configured.
    ///
    /// # Errors
    /// When there is no image, or a board refuses its configuration.
    pub fn new(images: &Images, scenario: Scenario, seed: u64) -> anyhow::Result<Flight> {
        let (master, slave) = (fleet::image(&images.master)?, fleet::image(&images.slave)?);
        let mut random = fastrand::Rng::with_seed(seed);
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        for (node, position_m, ppm, drift_ppm_per_s) in BOARDS {
            let spread = TRANSCEIVER_NS - TRANSCEIVER_SPREAD_NS..=TRANSCEIVER_NS + TRANSCEIVER_SPREAD_NS;
            let transceiver = Some(Transceiver::with_loop(random.u32(spread)));
            spacecraft.add_board(BoardConfig {
                crystal: Crystal {
                    white_ppb: WHITE_PPB,
                    walk_ppb: WALK_PPB,
                    seed: random.u64(..),
                    ..scenario.crystals.of(node, ppm, drift_ppm_per_s)
                },
                position_m,
                power_on_at: Time::from_ms(10 * u64::from(node)),
                fittings: Fittings {
                    capture_wires: scenario.wires.of(node),
                    transceiver,
                    ..Fittings::default()
                },
                ..board(node, if node == 1 { &master } else { &slave })
            });
        }
        let traffic = Traffic::new(&mut spacecraft, Bus::Nominal, scenario.load, seed, CONFIGURED);
        let client = spacecraft.add_guest(Bus::Nominal, 0.0);
        let trial = Trial::new(spacecraft, *PULSE, Some(traffic));
        let mut flight = Flight { trial, client, stamps: StampWatch::default() };
        flight.run_until(UP)?;
        flight.set_sync(scenario.sync)?;
        for (address, value, len) in EVERY_SYNC {
            flight.write(1, address, value, len)?;
        }
        for (node, position_m, ..) in BOARDS {
            if scenario.corrected {
                let cable = CABLE_NS_PER_M * (1.0 + LENGTH_ERROR) * position_m;
                let delay = (cable + f64::from(TRANSCEIVER_NS) / 2.0).round() as u32;
                flight.write(node, DELAY_NOMINAL, delay, 4)?;
                flight.write(node, DELAY_REDUNDANT, delay, 4)?;
            }
        }
        flight.run_until(CONFIGURED)?;
        Ok(flight)
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// When the twin had to stop a board.
    pub fn run_until(&mut self, until: Time) -> anyhow::Result<()> {
        let stamps = &mut self.stamps;
        self.trial.run_until(until, |spacecraft, records| {
            records.iter().for_each(|record| stamps.on(record));
            stamps.look(spacecraft);
            anyhow::Ok(())
        })
    }

    /// Lets the master send SYNC and the spacecraft time every `period` from now on, or never if it is zero.
    ///
    /// # Errors
    /// When it refuses the period.
    pub fn set_sync(&mut self, period: Time) -> anyhow::Result<()> {
        self.write(1, SYNC_PERIOD, period.as_us() as u32, 4)
    }

    /// Lets all boards make a pulse every [`PULSE_PERIOD`] of their clocks, from their next second on. Until then they
    /// make one per second, which simulates faster.
    ///
    /// # Errors
    /// When a board refuses that.
    pub fn begin_pulses(&mut self) -> anyhow::Result<()> {
        let count = (1_000_000 / PULSE_PERIOD.as_us()) as u32;
        BOARDS.iter().try_for_each(|&(node, ..)| self.write(node, PULSES_PER_SECOND, count, 2))
    }

    /// Cuts the nominal bus beside the master.
    pub fn cut_beside_master(&mut self) {
        self.trial.spacecraft().wire_mut(Bus::Nominal).cut(0.5);
    }

    /// Returns the errors of each slave's clock relative to the master between two instants.
    pub fn errors(&self, from: Time, to: Time) -> [Errors; 3] {
        [1, 2, 3].map(|slave| self.trial.errors(BoardId(0), BoardId(slave), PULSE_PERIOD, from, to))
    }

    /// Returns the present time of the twin.
    pub fn now(&mut self) -> Time {
        self.trial.spacecraft().now()
    }

    /// Returns the errors of SYNC stamps so far.
    pub fn stamps(&self) -> StampErrors {
        self.stamps.errors()
    }

    /// Returns the error bound that each slave reports, ns.
    ///
    /// # Errors
    /// When a slave does not answer.
    pub fn bounds(&mut self) -> anyhow::Result<[u32; 3]> {
        self.read_of_slaves(BOUND)
    }

    /// Returns how often the clock of each slave was set.
    ///
    /// # Errors
    /// When a slave does not answer.
    pub fn steps(&mut self) -> anyhow::Result<[u32; 3]> {
        self.read_of_slaves(STEPS)
    }

    fn read_of_slaves(&mut self, address: Address) -> anyhow::Result<[u32; 3]> {
        Ok([self.read(2, address)?, self.read(3, address)?, self.read(4, address)?])
    }

    /// Makes an expedited download of `len` bytes (CiA 301 7.2.4.3.3).
    fn write(&mut self, node: u8, address: Address, value: u32, len: u8) -> anyhow::Result<()> {
        let response = self.ask(node, address, 0x23 | (4 - len) << 2, value)?;
        ensure!(response[0] == 0x60, "node {node} refuses {value} in {address:?}: {response:X?}");
        Ok(())
    }

    /// Makes an expedited upload (CiA 301 7.2.4.3.5).
    fn read(&mut self, node: u8, address: Address) -> anyhow::Result<u32> {
        let [command, _, _, _, a, b, c, d] = self.ask(node, address, 0x40, 0)?;
        ensure!(command & 0xE3 == 0x43, "node {node} does not give {address:?}: command {command:02X}h");
        let unused = 8 * u32::from(command >> 2 & 0b11);
        Ok(u32::from_le_bytes([a, b, c, d]) << unused >> unused)
    }

    fn ask(&mut self, node: u8, address: Address, command: u8, value: u32) -> anyhow::Result<[u8; 8]> {
        let ([low, high], [a, b, c, d]) = (address.index.to_le_bytes(), value.to_le_bytes());
        let request = [command, low, high, address.sub, a, b, c, d];
        let response = WireId::Standard(0x580 + u16::from(node));
        let request = WireFrame::standard(0x600 + u16::from(node), &request);
        let start = self.now();
        self.trial.spacecraft().take_heard(self.client);
        self.trial.spacecraft().inject(self.client, start, request);
        while self.now() < start + PATIENCE {
            let next = self.now() + Time::from_ms(1);
            self.run_until(next)?;
            for (_, event) in self.trial.spacecraft().take_heard(self.client) {
                if let GuestEvent::Received(frame) = event
                    && frame.id == response
                    && frame.data[1..4] == request.data[1..4]
                {
                    return Ok(frame.data);
                }
            }
        }
        Err(anyhow::anyhow!("no answer within {} us", PATIENCE.as_us()))
            .with_context(|| format!("node {node} was asked for {address:?}"))
    }
}
