//! Runs the demo without faults and reports how many instructions the emulated cores executed. `cargo xtask bench
//! --only twin` counts the instructions of the host that it needs.
//!
//!     flight SECONDS MASTER.elf SLAVE.elf

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::Context;
use can_twin::wire::time::Time;
use ecss_can_cli::fly::mission;
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::images::support::fleet;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut next = || arguments.next().context("usage: flight SECONDS MASTER.elf SLAVE.elf");
    let seconds: u64 = next()?.parse().context("SECONDS is a whole number")?;
    let images =
        ecss_can_cli::images::Images { master: PathBuf::from(next()?), slave: PathBuf::from(next()?) };
    let plan = Plan { end: Time::from_ms(1000 * seconds), faults: Vec::new(), ..Plan::default() };
    let images = fleet::shipped(&images, plan.boards.iter().map(|board| board.node))?;
    let flight = mission::fly(plan, &images, |_, _| ControlFlow::Continue(()))?;
    let instructions: u64 = flight.boards.iter().map(|board| board.instructions).sum();
    println!("{instructions} instructions of {} boards", flight.boards.len());
    Ok(())
}
