//! Frames that a slave loses when both buses are full of frames for it.
//!
//! On each bus a foreign controller sends frames of 8 random bytes back to back for 10 s, their identifiers drawn from
//! all that the slave's filters admit. On the nominal bus there is a heartbeat of the master every 100 frames, so that
//! the slave stays operational and its application runs. A frame is lost if a filter admitted it and the node did not
//! handle it. Both are counted after the buses are quiet again. It is measured with zero wait states, with the flash
//! settings of boards, and without the accelerator of the flash.

use can_twin::board::FlashTiming;
use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::{FLASH_TIMINGS, MASTER_BEATS, Rig};
use crate::bench::row::Row;

/// Random frames on each bus: 10 s of them at 117 bits, their mean length with stuff bits and intermission.
const FRAMES: u64 = 85_500;

/// Random frames from heartbeat to heartbeat: 47 ms.
const BEAT_EVERY: u64 = 400;

/// Time without handled frames after which a node has none left.
const STEP: Time = Time::from_ms(10);

/// Node-ID of the slave.
const SLAVE: u8 = 2;

/// NMT, SYNC, spacecraft time, commands, telemetry requests, heartbeat of the master.
const ADMITTED: [u16; 6] = [0x000, 0x080, 0x181, 0x300 + SLAVE as u16, 0x400 + SLAVE as u16, 0x701];

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let cases = FLASH_TIMINGS.into_iter().map(|(timing, name)| measure_with(context, timing, name));
    Ok(cases.collect::<anyhow::Result<Vec<_>>>()?.concat())
}

fn measure_with(context: &Context, timing: FlashTiming, case: &str) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, timing)?;
    let mut random = fastrand::Rng::with_seed(1);
    let (start, before) = (rig.spacecraft.now() + Time::from_us(1), rig.diagnostics()?);
    let awake_before = rig.board().counters().cycles_awake;
    for bus in Bus::ALL {
        for n in 0..FRAMES {
            if bus == Bus::Nominal && n % BEAT_EVERY == 0 {
                rig.send(bus, start, MASTER_BEATS);
            }
            let id = ADMITTED[random.usize(..ADMITTED.len())];
            rig.send(bus, start, (id, &random.u64(..).to_le_bytes()));
        }
    }
    let (mut last, mut busy_until) = (before, start);
    loop {
        let now = rig.spacecraft.now() + STEP;
        rig.run_until(now)?;
        let told = rig.diagnostics()?;
        if told.frames() == last.frames() {
            break;
        }
        (last, busy_until) = (told, now);
    }
    let frames = last.frames() - before.frames();
    let awake = rig.board().counters().cycles_awake - awake_before;
    let cycles = busy_until.since(start).as_secs_f64() * rig.board().hclk() as f64;
    let name = |name: &str| format!("{name}{case}");
    let lost = Row::lower(name("back_to_back_lost"), last.lost_frames(rig.board()), "frames");
    Ok(vec![
        // Boards never run without the accelerator.
        if timing == FlashTiming::Unaccelerated { lost } else { lost.within(0_u64) },
        Row::higher(name("back_to_back_handled"), frames, "frames"),
        Row::lower(name("app_overflows"), u64::from(last.app_overflows - before.app_overflows), "events"),
        Row::lower(name("cycles_per_frame"), awake / frames.max(1), "model_cycles"),
        Row::lower(name("processor"), 100.0 * awake as f64 / cycles, "percent"),
    ])
}
