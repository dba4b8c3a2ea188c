//! What it costs to stamp a SYNC, in cycles.
//!
//! A slave, operational, is sent SYNCs by a foreign controller while the twin runs one instruction at a time. The clock is
//! the core's count of cycles awake, from the exception entry of the receive interrupt of CAN1. It is read when the port
//! counts the stamp in `DIAGNOSTICS`: the edges of the SYNC have been searched and found. `rx` is the same way without a
//! search. Zero wait states.

use can_wire::time::Time;
use twin::board::FlashTiming;
use twin::spacecraft::Bus;

use super::Area;
use crate::context::Context;
use crate::rig::{MASTER_BEATS, Rig};
use crate::row::Row;
use support::board::Profile;

pub const AREA: Area =
    Area { name: "sync", about: "model cycles to the stamp of a SYNC", needs: &[], steps: 1, measure };

/// SYNCs that are followed.
const SYNCS: u32 = 200;

/// Between two SYNCs: a prime number of microseconds meets the board's timers at ever other moments.
const SPACING: Time = Time::from_us(11_003);

/// From the end of a SYNC to the heartbeat of the master, whose edges are then in the ring with those of the node's PDOs.
const BREAK: Time = Time::from_us(500);

/// From SOF to the last bit but one of EOF of a SYNC, and a little less.
const ON_THE_WIRE: Time = Time::from_us(40);

/// Without counter (CiA 301 7.2.5.3.1).
const SYNC: (u16, &[u8]) = (0x080, &[]);

/// Node-ID of the slave.
const SLAVE: u8 = 2;

fn measure(context: &Context, _: u64) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, FlashTiming::Ideal)?;
    let mut at = rig.spacecraft.now();
    let mut cycles = Vec::new();
    for _ in 0..SYNCS {
        at += SPACING;
        rig.send(Bus::Nominal, rig.spacecraft.now() + BREAK, MASTER_BEATS);
        rig.send(Bus::Nominal, at, SYNC);
        rig.run_until(at + ON_THE_WIRE)?;
        let before = rig.diagnostics()?.stamps.captured;
        cycles.push(
            rig.follow(|rig, cycles| Ok((rig.diagnostics()?.stamps.captured > before).then_some(cycles)))?,
        );
    }
    cycles.sort_unstable();
    let row = |name: &str, cycles: u64| Row::lower(name, cycles, "model_cycles");
    Ok(vec![
        row("interrupt_to_stamp", cycles[cycles.len() - 1]),
        row("interrupt_to_stamp_median", cycles[cycles.len() / 2]),
    ])
}
