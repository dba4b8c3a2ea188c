//! Cycles of a slave for the correction of its clock by one pair of SYNC and spacecraft time.
//!
//! A foreign controller acts as the master: SYNC, and the spacecraft time of that SYNC a millisecond later. Time is the
//! core's count of cycles awake, from the entry of `TimeService::pair` until it returns: the prediction, the filter and
//! the correction, without the path of the frame. Interrupts in between are included.

use anyhow::Context as _;
use can_twin::spacecraft::Bus;
use can_twin::wire::encode::encode;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::{FLASH_TIMINGS, MASTER_BEATS, Rig};
use crate::bench::row::Row;

/// Not inlined: PDOs of both kinds call it.
const FUNCTION: &str = "<ecss_can::time::service::TimeService>::pair";

/// Number of measured pairs, after [`SETTLING`] others.
const PAIRS: usize = 200;
const SETTLING: usize = 20;

/// Time between two pairs, a prime number of microseconds, so that the phase to the board's timers varies.
const SPACING: Time = Time::from_us(100_003);

/// Time from the start of a SYNC to that of the spacecraft time.
const LATER: Time = Time::from_us(1_000);

/// Time from earlier activity to the heartbeat of the master that precedes each SYNC.
const BREAK: Time = Time::from_us(500);

/// COB-ID of SYNC and of the Spacecraft Time PDO.
const SYNC: u16 = 0x080;
const SPACECRAFT_TIME: u16 = 0x181;

/// Node-ID of the slave.
const SLAVE: u8 = 2;

/// Returns the largest number of cycles and the median, at each timing of the flash.
///
/// # Errors
/// When the image has no such function, or does not call it.
pub fn rows(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (timing, case) in FLASH_TIMINGS {
        let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, timing)?;
        let function = rig.board().symbol(FUNCTION);
        let entry = function.with_context(|| format!("the image has no function {FUNCTION}"))?.address & !1;
        let mut cycles = Vec::new();
        for pair in 0..SETTLING + PAIRS {
            let taken = follow_pair(&mut rig, entry)?;
            if pair >= SETTLING {
                cycles.push(taken);
            }
        }
        cycles.sort_unstable();
        let row =
            |what: &str, cycles: u64| Row::lower(format!("update_{what}{case}"), cycles, "model_cycles");
        rows.extend([row("cycles", cycles[PAIRS - 1]), row("cycles_median", cycles[PAIRS / 2])]);
    }
    Ok(rows)
}

fn follow_pair(rig: &mut Rig, entry: u32) -> anyhow::Result<u64> {
    let now = rig.spacecraft.now();
    let at = now + SPACING;
    rig.send(Bus::Nominal, now + BREAK, MASTER_BEATS);
    rig.send(Bus::Nominal, at, (SYNC, &[]));
    let data = spacecraft_time(at);
    let end = at + LATER + duration(&data);
    rig.send(Bus::Nominal, at + LATER, (SPACECRAFT_TIME, &data));
    rig.run_until(end)?;
    rig.follow_call(entry)
}

/// Returns the virtual time as 24 bits of a second and seconds.
fn spacecraft_time(at: Time) -> [u8; 7] {
    let second = Time::from_ms(1_000).0;
    let [a, b, c, ..] = ((at.0 % second) * (1 << 24) / second).to_le_bytes();
    let [d, e, f, g, ..] = (at.0 / second).to_le_bytes();
    [a, b, c, d, e, f, g]
}

/// Returns the time from SOF to the last bit but one of EOF, when the receiver has the frame.
fn duration(data: &[u8]) -> Time {
    let frame = WireFrame::standard(SPACECRAFT_TIME, data);
    Time::from_us(encode(&frame).bits().len() as u64 - 2)
}
