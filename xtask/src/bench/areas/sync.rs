//! Cycles for the stamp of a SYNC.
//!
//! A foreign controller sends SYNCs to an operational slave while the twin runs one instruction at a time. Time is the
//! core's count of cycles awake, from the exception entry of the receive interrupt of CAN1. It is read when the port
//! counts the stamp in `DIAGNOSTICS`: the edges of the SYNC have been searched. `rx` measures the same path without a
//! search. Flash has zero wait states. A [sweep](crate::bench::sweep) adds SYNCs that arrive while the board does timed
//! actions. The figure is the worst of both.

use can_twin::board::FlashTiming;
use can_twin::spacecraft::Bus;
use can_twin::wire::encode::encode;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::diagnostics::Stamps;

use crate::bench::context::Context;
use crate::bench::rig::Rig;
use crate::bench::row::Row;
use crate::bench::sweep::series;

/// Number of measured SYNCs.
const SYNCS: u32 = 200;

/// Time between two SYNCs, a prime number of microseconds, so that the phase to the board's timers varies.
const SPACING: Time = Time::from_us(11_003);

/// Slightly less than the time from SOF to the last bit but one of EOF of a SYNC.
const ON_THE_WIRE: Time = Time::from_us(40);

/// SYNC without counter (CiA 301 7.2.5.3.1).
const SYNC: (u16, &[u8]) = (0x080, &[]);

/// Node-ID of the slave.
const SLAVE: u8 = 2;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, FlashTiming::Ideal)?;
    let end = Time::from_us(encode(&WireFrame::standard(SYNC.0, SYNC.1)).bits().len() as u64 - 1);
    let series = series(&mut rig, (SYNCS, SPACING), |_| end, |rig, at, _| stamp(rig, at))?;
    let cycles = series.cycles(|cycles| *cycles);
    let row = |name: &str, cycles: u64| Row::lower(name, cycles, "model_cycles");
    Ok(vec![row("interrupt_to_stamp", cycles.worst), row("interrupt_to_stamp_median", cycles.median)])
}

/// Sends a SYNC at `at`, and returns the cycles to its stamp.
fn stamp(rig: &mut Rig, at: Time) -> anyhow::Result<u64> {
    rig.send(Bus::Nominal, at, SYNC);
    rig.run_until(at + ON_THE_WIRE)?;
    let before = decided(rig)?;
    rig.follow(|rig, cycles| Ok((decided(rig)? > before).then_some(cycles)))
}

/// Returns the number of SYNCs that the port has stamped by their edges or, if it did not find them, by the interrupt.
fn decided(rig: &Rig) -> anyhow::Result<u32> {
    let Stamps { captured, missed, .. } = rig.diagnostics()?.stamps;
    Ok(captured + missed.iter().sum::<u32>())
}
