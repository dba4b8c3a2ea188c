//! Stamps of SYNCs compared with the true ends of their frames, on a loaded bus with bit errors.
//!
//! A master and three slaves of the profile `standard`, each with its own crystal, and foreign traffic on the nominal
//! bus: 1000 SYNCs at either load. [`can_twin::stamps`] defines true ends and wrong stamps. The demo reports the source of
//! stamps, this area their errors.

use can_twin::board::{BoardConfig, EmulatedBoard};
use can_twin::crystal::Crystal;
use can_twin::spacecraft::{Spacecraft, SpacecraftConfig};
use can_twin::stamps::{Counts, Disturbance, Outcome, Trial};
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::diagnostics::Diagnostics;
use ecss_can_cli::images::support::fleet;

use crate::bench::context::{Context, FLOWN, board};
use crate::bench::row::Row;

const SYNC: u16 = 0x080;
/// SYNC period of the profile `standard`.
const PERIOD: Time = Time::from_ms(100);
const SYNCS: u64 = 1000;

const BIT_ERRORS: f64 = 1e-5;
/// Start of the measurement. All nodes are operational, and no SYNC is near.
const FROM: Time = Time::from_ms(550);

/// Largest allowed error of a stamp.
const TARGET_NS: f64 = 100.0;

/// Node-ID (1 is the master), metres, parts per million.
const BOARDS: [(u8, f64, f64); 4] = [(1, 0.0, 50.0), (2, 9.0, -50.0), (3, 21.0, 17.0), (4, 35.0, -38.0)];

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for percent in [30_u8, 90] {
        let outcome = fly(context, f64::from(percent) / 100.0)?;
        let name = |what: &str| format!("{what}_{percent}");
        rows.extend([
            Row::lower(name("worst_error"), outcome.worst_ns(), "ns").within(TARGET_NS),
            Row::lower(name("rms_error"), outcome.rms_ns(), "ns"),
            Row::lower(name("wrong_frames"), outcome.wrong + outcome.unread, "stamps").within(0_u64),
            Row::higher(name("captured_share"), 100.0 * outcome.captured_share(), "percent"),
            Row::higher(name("syncs"), outcome.frames, "syncs"),
            Row::higher(name("bus_load"), 100.0 * outcome.load, "percent"),
            Row::higher(name("destroyed_frames"), outcome.destroyed, "frames"),
        ]);
        let reasons = ["silent", "mismatched", "late", "ambiguous"].into_iter().zip(outcome.missed);
        rows.extend(reasons.map(|(reason, count)| Row::lower(name(reason), count, "syncs")));
    }
    Ok(rows)
}

fn fly(context: &Context, load: f64) -> anyhow::Result<Outcome> {
    let images = context.images(&FLOWN, Profile::Standard)?;
    let (master, slave) = (fleet::image(&images.master)?, fleet::image(&images.slave)?);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for (node, position_m, ppm) in BOARDS {
        spacecraft.add_board(BoardConfig {
            crystal: Crystal::ppm(ppm),
            position_m,
            power_on_at: Time::from_ms(10 * u64::from(node)),
            ..board(node, if node == 1 { &master } else { &slave })
        });
    }
    let disturbance = Disturbance { load, error_rate: BIT_ERRORS, seed: 1, from: FROM };
    Trial::new(spacecraft, SYNC, disturbance)?.run(SYNCS, PERIOD, counts)
}

fn counts(board: &EmulatedBoard) -> anyhow::Result<Counts> {
    let stamps = Diagnostics::read(board)?.stamps;
    Ok(Counts { captured: stamps.captured, missed: stamps.missed, last: stamps.last })
}
