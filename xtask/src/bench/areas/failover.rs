//! Time without commands after a cut of a bus, in flights of the demo's master and slaves.
//!
//! * Near cut: between the master and all slaves. Partial cut: after the slave next to the master, so that most slaves
//!   are lost. Each is flown with the cut at several times of the heartbeat period, and the worst result counts.
//! * Detection: from the cut to the end of the master's first frame on the other bus.
//! * Command gap: from there to the end of the first command there. Outage: both. In a partial cut commands to the
//!   remaining slave never stop, so none is overdue at the change of the bus. The bound is for the outage.
//! * Standby: of two masters the active one loses its power, at several moments of the heartbeat period (profile standby): from
//!   the end of its last heartbeat to the end of the first message of the other board; the worst counts.
//! * Load of claims: of the bus that is not active in these flights, where the active master sends nothing else. On the active bus
//!   the claims add the same load.
//! * Selective access: from the end of the last heartbeat that reached slave 4 on the cut bus to the end of its own
//!   first frame on the other one; in the flight of `cargo demo`.

use anyhow::Context as _;
use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use ecss_can_cli::fly::Options;
use ecss_can_cli::fly::fault::{Cause, Fault};
use ecss_can_cli::fly::flight::Flight;
use ecss_can_cli::fly::meaning::Meaning;
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::fly::record::{CutPlan, MASTER, Node, Seen};
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::{Context, milliseconds};
use crate::bench::row::Row;

/// Heartbeat period of the profile `librecube`. Its consumer time and Ttoggle follow.
const HEARTBEAT_MS: f64 = 250.0;
const CONSUMER_MS: f64 = 2500.0;
const TTOGGLE: f64 = 5.0;

/// Time that the master may take in addition to a heartbeat period, and from detection to commands.
const MARGIN_MS: f64 = 5.0;
const COMMAND_GAP_MS: f64 = 10.0;

/// Tolerance for the change of the bus by a slave with selective access, percent.
const SELECTIVE_PERCENT: f64 = 5.0;

/// The slave with selective access.
const SELECTIVE: Node = 4;

/// Consumer time of the standby in the profile `standby`. The time that it may take in addition follows.
const STANDBY_CONSUMER_MS: f64 = 400.0;
const STANDBY_MARGIN_MS: f64 = 10.0;
/// A claim of 2 bytes has at most 75 bits, one is sent in each heartbeat period of 100,000 bits.
const CLAIMS_PERCENT: f64 = 0.075;

/// Times at which the active master loses its power, spread over a heartbeat period of 100 ms.
const LOSSES_MS: [u64; 5] = [3000, 3020, 3040, 3060, 3080];

/// Times of the cut, spread over a heartbeat period. All nodes are operational.
const CUTS_MS: [u64; 5] = [2000, 2050, 2100, 2150, 2200];

/// Duration of the flight after the cut, longer than detection may take.
const NEAR_MS: u64 = 500;
const PARTIAL_MS: u64 = 3500;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let near = worst(context, Plan::default().cut().context("the demo has a cut")?.position_m, NEAR_MS)?;
    let partial = worst(context, behind_the_first_slave(&Plan::default()), PARTIAL_MS)?;
    let selective = selective(context.demo()?).context("slave 4 never came to the other bus")?;
    let (standby, claims) = standby(context)?;
    let exact = TTOGGLE * CONSUMER_MS;
    let deviation = 100.0 * (selective - exact).abs() / exact;
    let limit = HEARTBEAT_MS + MARGIN_MS;
    Ok(vec![
        Row::lower("near_cut_detection", near.detection, "ms").within(limit),
        Row::lower("near_cut_command_gap", near.command_gap, "ms").within(COMMAND_GAP_MS),
        Row::lower("partial_cut_detection", partial.detection, "ms").within(limit + CONSUMER_MS),
        Row::lower("partial_cut_command_gap", partial.command_gap, "ms"),
        Row::lower("partial_cut_outage", partial.outage, "ms").within(limit + COMMAND_GAP_MS + CONSUMER_MS),
        Row::lower("standby_takeover", standby, "ms").within(STANDBY_CONSUMER_MS + STANDBY_MARGIN_MS),
        Row::lower("claims_load", claims, "percent").within(CLAIMS_PERCENT),
        Row::lower("selective_access", selective, "ms"),
        Row::lower("selective_access_deviation", deviation, "percent").within(SELECTIVE_PERCENT),
    ])
}

/// Fail-over times, milliseconds.
struct FailOver {
    detection: f64,
    command_gap: f64,
    outage: f64,
}

/// Returns the longest times of flights with a cut at this place.
fn worst(context: &Context, position_m: f64, flown_on_ms: u64) -> anyhow::Result<FailOver> {
    let mut worst = FailOver { detection: 0.0, command_gap: 0.0, outage: 0.0 };
    for at in CUTS_MS {
        let cut = CutPlan { bus: Bus::Nominal, at: Time::from_ms(at), position_m };
        let end = Time::from_ms(at + flown_on_ms);
        let plan = Plan { end, faults: vec![Fault::cut(cut)], ..Plan::default() };
        let flight = context.fly(plan)?;
        let FailOver { detection, command_gap, outage } = fail_over(&flight)
            .with_context(|| format!("no fail-over within {flown_on_ms} ms of a cut at {at} ms"))?;
        worst.detection = worst.detection.max(detection);
        worst.command_gap = worst.command_gap.max(command_gap);
        worst.outage = worst.outage.max(outage);
    }
    Ok(worst)
}

fn fail_over(flight: &Flight) -> Option<FailOver> {
    let (cut, bus) = flight.cut()?;
    let by_master = |(at, seen): &(Time, &Seen)| *at > cut && seen.bus == bus.other() && seen.from == MASTER;
    let (detection, _) = flight.frames().find(by_master)?;
    let (command, _) = flight.frames().find(|(at, seen)| {
        by_master(&(*at, seen)) && matches!(seen.meaning, Some(Meaning::Telecommand { .. }))
    })?;
    Some(FailOver {
        detection: milliseconds(detection.since(cut)),
        command_gap: milliseconds(command.since(detection)),
        outage: milliseconds(command.since(cut)),
    })
}

/// Returns the time from the last heartbeat on the cut bus to the slave's first frame on the other one, milliseconds.
fn selective(flight: &Flight) -> Option<f64> {
    let (cut, bus) = flight.cut()?;
    let heartbeats = flight.frames().filter(|(_, seen)| {
        let heartbeat = matches!(seen.meaning, Some(Meaning::Heartbeat { node: MASTER, .. }));
        heartbeat && seen.bus == bus && seen.reached.contains(SELECTIVE)
    });
    let (last, _) = heartbeats.last()?;
    let (back, _) =
        flight.frames().find(|(at, seen)| *at > cut && seen.bus == bus.other() && seen.from == SELECTIVE)?;
    Some(milliseconds(back.since(last)))
}

/// Returns the longest time without a master, milliseconds, and the largest load of the inactive bus, percent.
fn standby(context: &Context) -> anyhow::Result<(f64, f64)> {
    let mut options = Options { seconds: 4.0, ..Options::default() };
    options.fleet.target.profile = Profile::Standby;
    let (mut worst, mut load): (f64, f64) = (0.0, 0.0);
    for at in LOSSES_MS {
        let faults = vec![Fault::new(Time::from_ms(at), Cause::LoseActive)];
        let plan = Plan { faults, ..Plan::new(&options)? };
        let flight = context.fly(plan)?;
        let takeover = flight.takeover().with_context(|| format!("no takeover after a loss at {at} ms"))?;
        worst = worst.max(milliseconds(takeover.took()));
        load = load.max(100.0 * flight.load(Bus::Redundant));
    }
    Ok((worst, load))
}

/// Returns the position halfway between the two slaves next to the master, metres.
fn behind_the_first_slave(plan: &Plan) -> f64 {
    let slaves = plan.boards.iter().filter(|board| board.node != MASTER);
    let mut places: Vec<f64> = slaves.map(|board| board.position_m).collect();
    places.sort_by(f64::total_cmp);
    (places[0] + places[1]) / 2.0
}

#[cfg(test)]
mod tests {
    use ecss_can_cli::fly::sample;

    use super::*;

    #[test]
    fn times_are_taken_from_the_frames() {
        // Cut at 20 s, the master's heartbeat on the other bus at 20.6 s, the next command in the grid of 100 ms at
        // 20.605 s; its last heartbeat before the cut at 19.8 s, slave 4 back at 32.35 s.
        let flight = sample::flight();
        let FailOver { detection, command_gap, outage } = fail_over(&flight).unwrap();
        assert_eq!([detection, command_gap, outage].map(f64::round), [600.0, 5.0, 605.0]);
        assert_eq!(selective(&flight).map(f64::round), Some(12_550.0));
    }

    #[test]
    fn most_slaves_are_behind_a_partial_cut() {
        let plan = Plan::default();
        let at = behind_the_first_slave(&plan);
        let lost = plan.boards.iter().filter(|board| board.position_m > at).count();
        assert_eq!(lost, plan.slaves().count() - 1);
    }
}
