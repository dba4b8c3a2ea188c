//! `cargo xtask selftest`: flashes the self-test to a bare board and shows its log, or runs it on the emulated board.

use std::ffi::OsString;
use std::path::Path;

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::Crystal;
use can_twin::rtt::Level;
use can_twin::spacecraft::{Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use clap::Args;
use ecss_can_cli::firmware::flash;
use ecss_can_cli::images::support::board::{Board, help};
use ecss_can_cli::images::support::fleet;
use ecss_can_cli::images::support::output::{self, Silently};

/// Node-ID of the emulated board's straps.
const NODE: u8 = 2;
/// Time by which the emulated board is done, even if it erases flash first.
const FLIGHT: Time = Time::from_ms(3_000);

/// Command line of `selftest`.
#[derive(Args, Debug)]
#[command(
    after_help = "The board hangs on no bus of a spacecraft: it sends one frame on each. Both LEDs on: all is well. Else they blink \
    the number of the first check that failed. Needs probe-rs and a debug probe, but for --twin.\n\
    Exit code: that of probe-rs, which shows the log until Ctrl-C; with --twin 0 all is well, 1 a check failed; 2: wrong command \
    line."
)]
pub struct Options {
    /// Board to check
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, default_value = Board::DEFAULT, help = help())]
    board: Board,

    /// Run it on the emulated board instead
    #[arg(long, conflicts_with = "probe_rs")]
    twin: bool,

    /// Arguments for `probe-rs run`, for example: -- --probe 0483:374b
    #[arg(last = true, value_name = "ARGUMENTS")]
    probe_rs: Vec<OsString>,
}

/// Builds the image, and runs it or replaces this program by `probe-rs run`.
///
/// # Errors
/// When the image cannot be built, probe-rs is missing or fails, or a check fails on the emulated board.
pub fn run(options: &Options) -> anyhow::Result<()> {
    options.board.check_images("selftest")?;
    if !options.twin {
        flash::find_probe_rs()?;
    }
    let image = ecss_can_cli::images::build_check(options.board.board_crate(), "selftest")?;
    if options.twin {
        return fly(&options.board, &image);
    }
    flash::write(options.board.chip(), &image, &options.probe_rs)
}

/// Prints the log of the image on an emulated board.
fn fly(board: &Board, image: &Path) -> anyhow::Result<()> {
    let image = fleet::image(image)?;
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    spacecraft.add_board(BoardConfig {
        name: "selftest".to_owned(),
        model: board.model(),
        image,
        straps: board.straps(NODE),
        crystal: Crystal::ppm(0.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings: Fittings::default(),
    });
    spacecraft.run_until(FLIGHT)?;
    let logs = spacecraft.take_logs();
    logs.iter().try_for_each(|log| output::line(&log.text))?;
    let failed = logs.is_empty() || logs.iter().any(|log| log.level == Some(Level::Error));
    if failed { Err(Silently(1).into()) } else { Ok(()) }
}
