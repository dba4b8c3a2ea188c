//! One slave with its image on the twin, and on each bus a foreign controller that plays the master.
//!
//! On the nominal bus there is one more, for areas that hold a dialogue with the slave. Nothing else sends, so what happens
//! on the board is what its one slave does with the frames handed to it.

use anyhow::Context as _;
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::board::{BoardConfig, EmulatedBoard, Fittings, FlashTiming};
use twin::spacecraft::{BoardId, Bus, GuestId, Spacecraft, SpacecraftConfig};

use super::context::{Context, FLOWN, board};
use firmware_images::support::board::Profile;
use firmware_images::support::counters::Counters;
use firmware_images::support::diagnostics::Diagnostics;
use firmware_images::support::fleet;

/// NMT start of all nodes (CiA 301 7.2.8.3.1.1).
const START_ALL: (u16, &[u8]) = (0x000, &[0x01, 0x00]);

/// Heartbeat of an operational master (CiA 301 7.2.8.3.2.2).
pub const MASTER_BEATS: (u16, &[u8]) = (0x701, &[0x05]);

/// From power-on to the end of initialisation, and more.
const BOOT: Time = Time::from_ms(50);

/// Where the slave sits, metres from the guests.
const SLAVE_AT_M: f64 = 10.0;

/// By when a frame must have been dealt with.
const PATIENCE: Time = Time::from_ms(2);

/// Exception number of CAN1_RX0, interrupt 20 (RM0090 table 62).
const CAN1_RX0: u32 = 16 + 20;

/// Timings of the flash under which an area is measured, and what the names of its rows end in.
pub const FLASH_TIMINGS: [(FlashTiming, &str); 3] = [
    (FlashTiming::Ideal, ""),
    (FlashTiming::AsSet, "_accelerated"),
    (FlashTiming::Unaccelerated, "_unaccelerated"),
];

/// The slave and its masters.
pub struct Rig {
    /// The twin.
    pub spacecraft: Spacecraft,
    slave: BoardId,
    masters: [GuestId; 2],
    /// On the nominal bus.
    pub client: GuestId,
}

impl Rig {
    /// Slave `node` with a perfect crystal, started by NMT on the nominal bus.
    ///
    /// # Errors
    /// When there is no image, or it does not come up.
    pub fn new(context: &Context, profile: Profile, node: u8) -> anyhow::Result<Rig> {
        Rig::with_flash(context, profile, node, FlashTiming::AsSet)
    }

    /// The same with this timing of its flash.
    ///
    /// # Errors
    /// As [`Rig::new`].
    pub fn with_flash(
        context: &Context,
        profile: Profile,
        node: u8,
        flash_timing: FlashTiming,
    ) -> anyhow::Result<Rig> {
        let images = context.images(&FLOWN, profile)?;
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let slave = spacecraft.add_board(BoardConfig {
            position_m: SLAVE_AT_M,
            fittings: Fittings { flash_timing, ..Fittings::default() },
            ..board(node, &fleet::image(&images.slave)?)
        });
        let masters = Bus::ALL.map(|bus| spacecraft.add_guest(bus, 0.0));
        let client = spacecraft.add_guest(Bus::Nominal, 0.0);
        let mut rig = Rig { spacecraft, slave, masters, client };
        rig.send(Bus::Nominal, BOOT, MASTER_BEATS);
        rig.send(Bus::Nominal, BOOT, START_ALL);
        rig.run_until(BOOT + Time::from_ms(1))?;
        anyhow::ensure!(rig.diagnostics()?.handled == [2, 0], "the slave has not come up on the twin");
        Ok(rig)
    }

    /// The master of `bus` sends a frame at `at`, or when all before it is sent.
    pub fn send(&mut self, bus: Bus, at: Time, (id, data): (u16, &[u8])) {
        self.spacecraft.inject(self.masters[bus as usize], at, WireFrame::standard(id, data));
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// When the twin had to stop the board.
    pub fn run_until(&mut self, until: Time) -> anyhow::Result<()> {
        self.spacecraft.run_until(until).context("the twin stopped the board")?;
        // Nobody reads them, and a long run would pile them up.
        self.spacecraft.take_logs();
        self.spacecraft.take_frames();
        Ok(())
    }

    /// Follows the next frame through the board, an instruction at a time. `done` sees the board and the cycles
    /// awake since it entered the receive interrupt of CAN1, until it returns something.
    ///
    /// # Errors
    /// When that takes longer than [`PATIENCE`], and those of `done`.
    pub fn follow<T>(
        &mut self,
        mut done: impl FnMut(&Rig, u64) -> anyhow::Result<Option<T>>,
    ) -> anyhow::Result<T> {
        let end = self.spacecraft.now() + PATIENCE;
        let mut entered = None;
        while self.spacecraft.now() < end {
            let awake = self.board().counters().cycles_awake;
            self.run_until(self.spacecraft.now() + Time(1))?;
            if entered.is_none() && self.board().registers().xpsr & 0x1FF == CAN1_RX0 {
                entered = Some(awake);
            }
            let Some(start) = entered else { continue };
            if let Some(found) = done(self, self.board().counters().cycles_awake - start)? {
                return Ok(found);
            }
        }
        anyhow::bail!("a frame was not dealt with within {} us", PATIENCE.as_us())
    }

    /// Follows the next call of the function at `entry`, an instruction at a time, and returns the cycles awake until it returns.
    ///
    /// # Errors
    /// When it is not called, or does not return, within [`PATIENCE`].
    pub fn follow_call(&mut self, entry: u32) -> anyhow::Result<u64> {
        let end = self.spacecraft.now() + PATIENCE;
        let mut call = None;
        while self.spacecraft.now() < end {
            let [sp, lr, pc] = [13, 14, 15].map(|register| self.board().registers().r[register]);
            let awake = self.board().counters().cycles_awake;
            match call {
                None if pc == entry => call = Some((sp, lr & !1, awake)),
                Some((of, back, before)) if (sp, pc) == (of, back) => return Ok(awake - before),
                _ => {}
            }
            self.run_until(self.spacecraft.now() + Time(1))?;
        }
        anyhow::bail!("no call of the function at {entry:08X}h ended within {} us", PATIENCE.as_us())
    }

    /// The slave's board.
    pub fn board(&self) -> &EmulatedBoard {
        self.spacecraft.board(self.slave)
    }

    /// What the slave's image counted.
    ///
    /// # Errors
    /// When the image exports no counters.
    pub fn diagnostics(&self) -> anyhow::Result<Diagnostics> {
        Diagnostics::read(self.board())
    }

    /// Commands that the slave's application executed.
    ///
    /// # Errors
    /// When the image counts none.
    pub fn commands(&self) -> anyhow::Result<u32> {
        Ok(Counters::read(self.board())?.context("the image is none of the mission's")?.commands)
    }
}
