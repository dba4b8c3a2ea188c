//! Interrupts of a controller whose bus is cut.
//!
//! A slave with selective access stays on its bus for 12.5 s after the loss of the master, and keeps trying to send its
//! heartbeat, which no node acknowledges, in thousands of attempts per second. They must not cause interrupts. The
//! image counts them in `DIAGNOSTICS`. The measured second starts one second after the cut.

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::{MASTER_BEATS, Rig};
use crate::bench::row::Row;

/// The slave with selective access in the profile `librecube`.
const SLAVE: u8 = 4;

/// The guests are at 0 m, the slave is beyond.
const CUT_AT_M: f64 = 1.0;

/// Time of the cut. Start and end of the measured second follow.
const CUT: Time = Time::from_ms(1000);
const FROM: Time = Time::from_ms(2000);
const TO: Time = Time::from_ms(3000);

/// Ten for each of the four heartbeats in a second, each of which may expire. There are a hundred times as many
/// attempts.
const TARGET: u64 = 40;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::new(context, Profile::Librecube, SLAVE)?;
    for ms in (250..1000).step_by(250) {
        rig.send(Bus::Nominal, Time::from_ms(ms), MASTER_BEATS);
    }
    rig.run_until(CUT)?;
    rig.spacecraft.wire_mut(Bus::Nominal).cut(CUT_AT_M);
    rig.run_until(FROM)?;
    let before = rig.diagnostics()?.interrupts;
    rig.run_until(TO)?;
    let after = rig.diagnostics()?.interrupts;
    let [transmit, receive, error] = [0, 1, 2].map(|kind| u64::from(after[kind] - before[kind]));
    let unit = "interrupts_per_second";
    Ok(vec![
        Row::lower("cut_bus", transmit + receive + error, unit).within(TARGET),
        Row::lower("cut_bus_transmit", transmit, unit),
        Row::lower("cut_bus_receive", receive, unit),
        Row::lower("cut_bus_error", error, unit),
    ])
}
