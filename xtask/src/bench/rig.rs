//! One slave with its image on the twin, and on each bus a foreign controller that acts as the master.
//!
//! On the nominal bus there is a second one, for areas that communicate with the slave. No other node sends, so all
//! activity of the board is caused by these frames.

use anyhow::Context as _;
use can_twin::board::{BoardConfig, EmulatedBoard, Fittings, FlashTiming};
use can_twin::spacecraft::{BoardId, Bus, GuestId, Spacecraft, SpacecraftConfig};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::counters::Counters;
use ecss_can_cli::images::support::diagnostics::Diagnostics;
use ecss_can_cli::images::support::fleet;

use super::context::{Context, FLOWN, board};

/// NMT start of all nodes (CiA 301 7.2.8.3.1.1).
const START_ALL: (u16, &[u8]) = (0x000, &[0x01, 0x00]);

/// Heartbeat of an operational master (CiA 301 7.2.8.3.2.2).
pub const MASTER_BEATS: (u16, &[u8]) = (0x701, &[0x05]);

/// Upper bound of the time from power-on to the end of initialisation.
const BOOT: Time = Time::from_ms(50);

/// Distance of the slave from the guests, metres.
const SLAVE_AT_M: f64 = 10.0;

/// Longest time until a frame is handled.
const PATIENCE: Time = Time::from_ms(2);

/// Exception number of CAN1_RX0, interrupt 20 (RM0090 table 62).
const CAN1_RX0: u32 = 16 + 20;

/// Timings of the flash with which an area is measured, and the ends of the names of its rows.
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
    /// Client on the nominal bus.
    pub client: GuestId,
}

impl Rig {
    /// Makes a rig with slave `node` with a perfect crystal, started by NMT on the nominal bus.
    ///
    /// # Errors
    /// When there is no image, or the slave does not start.
    pub fn new(context: &Context, profile: Profile, node: u8) -> anyhow::Result<Rig> {
        Rig::with_flash(context, profile, node, FlashTiming::AsSet)
    }

    /// Makes a rig with this timing of the slave's flash.
    ///
    /// # Errors
    /// As [`Rig::new`].
    pub fn with_flash(
        context: &Context,
        profile: Profile,
        node: u8,
        flash_timing: FlashTiming,
    ) -> anyhow::Result<Rig> {
        Rig::with_board(context, profile, node, flash_timing, |_| Ok(()))
    }

    /// Makes a rig with this timing of the slave's flash. `prepare` may change the slave before it has power.
    ///
    /// # Errors
    /// As [`Rig::new`], and those of `prepare`.
    pub fn with_board(
        context: &Context,
        profile: Profile,
        node: u8,
        flash_timing: FlashTiming,
        prepare: impl FnOnce(&mut EmulatedBoard) -> anyhow::Result<()>,
    ) -> anyhow::Result<Rig> {
        let images = context.images(&FLOWN, profile)?;
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let slave = spacecraft.add_board(BoardConfig {
            position_m: SLAVE_AT_M,
            fittings: Fittings { flash_timing, ..Fittings::default() },
            ..board(node, &fleet::image(&images.slave)?)
        });
        prepare(spacecraft.board_mut(slave))?;
        let masters = Bus::ALL.map(|bus| spacecraft.add_guest(bus, 0.0));
        let client = spacecraft.add_guest(Bus::Nominal, 0.0);
        let mut rig = Rig { spacecraft, slave, masters, client };
        rig.send(Bus::Nominal, BOOT, MASTER_BEATS);
        rig.send(Bus::Nominal, BOOT, START_ALL);
        rig.run_until(BOOT + Time::from_ms(1))?;
        anyhow::ensure!(rig.diagnostics()?.handled == [2, 0], "the slave has not come up on the twin");
        Ok(rig)
    }

    /// Lets the master of `bus` send a frame at `at`, or after all earlier ones.
    pub fn send(&mut self, bus: Bus, at: Time, (id, data): (u16, &[u8])) {
        self.spacecraft.inject(self.masters[bus as usize], at, WireFrame::standard(id, data));
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// When the twin had to stop the board.
    pub fn run_until(&mut self, until: Time) -> anyhow::Result<()> {
        self.spacecraft.run_until(until).context("the twin stopped the board")?;
        // They are not used, and would accumulate in a long run.
        self.spacecraft.take_logs();
        self.spacecraft.take_frames();
        Ok(())
    }

    /// Follows the next frame through the board, an instruction at a time. `done` gets the board and the cycles awake
    /// since the entry of the receive interrupt of CAN1, until it returns a value.
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

    /// Returns the slave's board.
    pub fn board(&self) -> &EmulatedBoard {
        self.spacecraft.board(self.slave)
    }

    /// Returns the counters of the slave's image.
    ///
    /// # Errors
    /// When the image exports no counters.
    pub fn diagnostics(&self) -> anyhow::Result<Diagnostics> {
        Diagnostics::read(self.board())
    }

    /// Returns the number of commands that the slave's application executed.
    ///
    /// # Errors
    /// When the image counts none.
    pub fn commands(&self) -> anyhow::Result<u32> {
        Ok(Counters::read(self.board())?.context("the image is none of the mission's")?.commands)
    }
}
