//! Cost of the check of the program in the background.
//!
//! A slave without traffic flies for ten seconds twice: with its image as it is, and with an erased seal, by which it does
//! not check its program. The difference contains the timer of the check.

use anyhow::Context as _;
use can_twin::board::{EmulatedBoard, FlashTiming};
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::Rig;
use crate::bench::row::Row;

/// Node-ID of the slave.
const SLAVE: u8 = 2;
const SECONDS: u64 = 10;
const SEAL: &str = "__program_seal";

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let checked = awake(context, |_| Ok(()))?;
    let unchecked = awake(context, |board| {
        let seal = board.symbol(SEAL).context("the image has no seal")?.address;
        board.write_flash(seal, &[0xFF; 8]).ok().context("the seal is not in flash")
    })?;
    let cycles = (checked - unchecked) / SECONDS;
    Ok(vec![Row::lower("scrub_cycles", cycles, "model_cycles_per_second")])
}

/// Returns the cycles awake of a slave after `prepare`.
fn awake(
    context: &Context,
    prepare: impl FnOnce(&mut EmulatedBoard) -> anyhow::Result<()>,
) -> anyhow::Result<u64> {
    let mut rig = Rig::with_board(context, Profile::Standard, SLAVE, FlashTiming::AsSet, prepare)?;
    let before = rig.board().counters().cycles_awake;
    rig.run_until(rig.spacecraft.now() + Time::from_ms(1_000 * SECONDS))?;
    Ok(rig.board().counters().cycles_awake - before)
}
