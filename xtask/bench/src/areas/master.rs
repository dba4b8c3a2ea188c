//! What heartbeats cost the master, in cycles.
//!
//! A master and slave 2 are on both buses. A foreign controller on the redundant bus sends the heartbeats of 80 nodes that
//! the master does not know, and one on the nominal bus those of slave 3, whose SDO server has answered: it counts. For each
//! heartbeat the cycles that the master is awake are counted, from the receive interrupt until it sleeps again; the flash has
//! no wait states.
//!
//! What else the master does in a period meets some heartbeats. So a heartbeat arrives at each of many moments of one period, each time
//! in a copy of the spacecraft.

use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::board::{EmulatedBoard, Fittings, FlashTiming};
use twin::spacecraft::{BoardId, Bus, GuestId, Spacecraft, SpacecraftConfig};

use super::Area;
use crate::context::{Context, FLOWN};
use crate::row::Row;
use demo::plan::BoardPlan;
use firmware_images::support::board::Profile;
use firmware_images::support::{fleet, node};

pub const AREA: Area =
    Area { name: "master", about: "model cycles of the master per heartbeat", needs: &[], steps: 1, measure };

/// In this time the master does everything that it does: its application sends commands, and it sends heartbeat, SYNC and time.
const PERIOD: Time = Time::from_ms(100);

/// From one moment to the next.
const STEP: Time = Time::from_us(20);

/// Between the first heartbeats of two nodes: those of 80 nodes take a tenth of a second.
const SPACING: Time = Time::from_us(1_231);

/// Node-IDs that the master does not know.
const FOREIGN_NODES: std::ops::Range<u16> = 40..120;

/// From the start of a heartbeat until the receiver has it, and a little less.
const ON_THE_WIRE: Time = Time::from_us(48);

/// A slave, Operational (CiA 301 7.2.8.3.2.2).
const OPERATIONAL: &[u8] = &[5];

/// Answer of slave 3 to the question for its device type (CiA 301 7.2.4.3.5).
const DEVICE_TYPE: &[u8] = &[0x43, 0x00, 0x10, 0x00, 0, 0, 0, 0];

/// From power-on until slave 2 has been started and knows its master.
const BOOT: Time = Time::from_ms(1_500);

/// Until a question has been asked, or its answer has been heard.
const QUESTION: Time = Time::from_ms(20);

/// Master, slave and foreign controllers.
#[derive(Clone)]
struct Network {
    spacecraft: Spacecraft,
    master: BoardId,
    guests: [GuestId; 2],
}

fn measure(context: &Context, _: u64) -> anyhow::Result<Vec<Row>> {
    let mut network = Network::new(context)?;
    network.send(Bus::Nominal, 0x703, OPERATIONAL)?;
    network.run_for(QUESTION)?;
    network.send(Bus::Nominal, 0x583, DEVICE_TYPE)?;
    network.run_for(QUESTION)?;
    // Once, until all are known.
    for node in FOREIGN_NODES {
        network.send(Bus::Redundant, 0x700 + node, OPERATIONAL)?;
        network.run_for(SPACING)?;
    }
    network.send(Bus::Nominal, 0x703, OPERATIONAL)?;
    network.run_for(QUESTION)?;
    let of_slave = network.clone().heartbeats(Bus::Nominal, 3..4)?;
    let of_foreign_node = network.heartbeats(Bus::Redundant, FOREIGN_NODES)?;
    let row = |name: &str, cycles: &[u64]| {
        let worst = cycles.last().copied().unwrap_or(0);
        let median = cycles.get(cycles.len() / 2).copied().unwrap_or(0);
        let row = |name: String, cycles| Row::lower(name, cycles, "model_cycles");
        [row(format!("heartbeat_of_{name}"), worst), row(format!("heartbeat_of_{name}_median"), median)]
    };
    Ok([row("slave", &of_slave), row("foreign_node", &of_foreign_node)].concat())
}

impl Network {
    /// Long after power-on.
    fn new(context: &Context) -> anyhow::Result<Network> {
        let images = context.images(&FLOWN, Profile::Standard)?;
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let mut board = |node, image| -> anyhow::Result<BoardId> {
            let plan = BoardPlan {
                node,
                own_image: None,
                is_minimal: false,
                has_one_controller: false,
                crystal_ppm: 0.0,
                position_m: f64::from(node),
                power_on: Time::ZERO,
            };
            let config = plan.config(&FLOWN, format!("node {node}"), fleet::image(image)?);
            let fittings = Fittings { flash_timing: FlashTiming::Ideal, ..Fittings::default() };
            Ok(spacecraft.add_board(twin::board::BoardConfig { fittings, ..config }))
        };
        let master = board(node::MASTER, &images.master)?;
        board(2, &images.slave)?;
        let guests = Bus::ALL.map(|bus| spacecraft.add_guest(bus, 0.0));
        let mut network = Network { spacecraft, master, guests };
        network.run_for(BOOT)?;
        Ok(network)
    }

    /// Lets time pass.
    fn run_for(&mut self, time: Time) -> anyhow::Result<()> {
        self.spacecraft.run_until(self.spacecraft.now() + time)?;
        self.spacecraft.take_logs();
        self.spacecraft.take_frames();
        Ok(())
    }

    /// Sends a frame and lets it come to the end of the wire.
    fn send(&mut self, bus: Bus, id: u16, data: &[u8]) -> anyhow::Result<()> {
        let at = self.spacecraft.now() + Time::from_us(1);
        self.spacecraft.inject(self.guests[bus as usize], at, WireFrame::standard(id, data));
        self.run_for(Time::from_us(1) + ON_THE_WIRE)
    }

    /// Sends a heartbeat at each moment of a period, of these nodes in turn. Returns the cycles that the master takes for each, in
    /// rising order.
    fn heartbeats(mut self, bus: Bus, nodes: std::ops::Range<u16>) -> anyhow::Result<Vec<u64>> {
        let moments = PERIOD.0 / STEP.0;
        let mut cycles = Vec::new();
        for (_, node) in (0..moments).zip(nodes.cycle()) {
            self.run_for(STEP)?;
            cycles.push(self.clone().heartbeat(bus, node)?);
        }
        cycles.sort_unstable();
        Ok(cycles)
    }

    /// Cycles that the master takes for a heartbeat that begins now.
    fn heartbeat(mut self, bus: Bus, node: u16) -> anyhow::Result<u64> {
        self.send(bus, 0x700 + node, OPERATIONAL)?;
        let before = self.board().counters().cycles_awake;
        while self.board().counters().cycles_awake == before || self.board().next_event() == Time::ZERO {
            self.run_for(Time(1))?;
        }
        Ok(self.board().counters().cycles_awake - before)
    }

    fn board(&self) -> &EmulatedBoard {
        self.spacecraft.board(self.master)
    }
}
