//! Top of a report: the flight, its faults and verdict, and the most important numbers.

use maud::{Markup, html};

use super::duration;
use super::tables::{number, text};
use crate::fly::flight::Flight;
use crate::fly::meaning::Scope;
use crate::fly::narrator::name;
use crate::fly::outcome::UNKNOWN_IMAGES;
use crate::fly::summary::Summary;
use crate::fly::verdict::{Outcome, Verdict};

/// Title, verdict and a summary in sentences.
pub fn header(flight: &Flight, summary: &Summary) -> Markup {
    let Verdict { outcome, reasons } = &summary.verdict;
    let (class, verdict) = match outcome {
        Outcome::Passed => ("good", "ran as it should"),
        Outcome::Failed => ("bad", "failed"),
        Outcome::Interrupted => ("bad", "interrupted"),
    };
    let Summary { boards, board, profile, seed, virtual_seconds, own_images, .. } = summary;
    let profile = if own_images.len() < *boards { format!(", profile {profile}") } else { String::new() };
    html! {
        header {
            h1 { "A run on two CAN buses" }
            span.verdict.(class) { (verdict) }
        }
        p.lead {
            (masters(summary)) " and " (boards - summary.masters) " slaves (" (board) (profile) ", seed " (seed) ") ran "
            (format!("{virtual_seconds:.0}")) " s of virtual time. " (faults(flight))
        }
        @if flight.plan.scope() == Scope::Protocol {
            p.lead { (notice(flight)) }
        }
        @if !reasons.is_empty() {
            ul.faults { @for reason in reasons { li { (reason) } } }
        }
    }
}

fn masters(summary: &Summary) -> &'static str {
    if summary.masters == 1 { "One master" } else { "Two masters" }
}

/// A sentence for each fault that the demo caused, in order of time.
fn faults(flight: &Flight) -> String {
    let reset = flight
        .standby_reset()
        .map(|(at, board)| format!("At {} s {}, the standby, was reset.", at.as_secs_f64(), name(board)));
    let cut = flight.cut().map(|(at, bus)| {
        let place = flight.plan.cut.map_or("", |cut| flight.plan.place(&cut));
        format!("At {} s the {} bus was cut {place}.", at.as_secs_f64(), bus.name())
    });
    let faults: Vec<String> = [reset, cut, loss(flight)].into_iter().flatten().collect();
    if faults.is_empty() { "No bus was cut.".into() } else { faults.join(" ") }
}

/// A sentence about the master that lost its power, and about the takeover.
fn loss(flight: &Flight) -> Option<String> {
    let (at, board) = flight.loss()?;
    let end = flight.takeover().map_or("; no board took over".into(), |takeover| {
        let took = duration(takeover.took().as_secs_f64() * 1e3);
        format!("; {} took over {took} after its last heartbeat", name(takeover.to))
    });
    Some(format!("At {} s {}, the active one, lost its power{end}.", at.as_secs_f64(), name(board)))
}

/// Returns a notice about the images of the user's, and the omissions of the report.
fn notice(flight: &Flight) -> String {
    let boards = flight.plan.boards.iter();
    let own = boards.filter_map(|board| Some(format!("{}: {}", name(board.node), board.own_image.as_ref()?)));
    let own = own.collect::<Vec<_>>().join(", ");
    let mut left_out = UNKNOWN_IMAGES.to_owned();
    left_out[..1].make_ascii_uppercase();
    format!("{left_out} ({own}). The verdict is about NMT states, lost frames, lock-ups, panics and resets.")
}

/// The most important numbers.
pub fn tiles(summary: &Summary) -> Markup {
    let slaves = summary.boards - summary.masters;
    let failovers = || summary.failover_ms.values().flatten().copied();
    let operational = number("slaves_operational_at_end", summary.slaves_operational_at_end);
    let mut tiles =
        vec![(html! { (operational) " of " (slaves) }, html! { "slaves operational at the end" })];
    if let Some(mission) = &summary.mission {
        let due = html! { "commands executed, " (number("tc_due", mission.tc_due)) " due" };
        tiles.push((number("tc_executed", mission.tc_executed), due));
        tiles.push((number("tm_received", mission.tm_received), text("telemetry replies received")));
    } else {
        tiles.push((number("bus_changes", summary.bus_changes), text("changes of bus by the master")));
        let highest = summary.bus_load_percent.values().copied().fold(0.0, f64::max);
        tiles.push((text(format!("{highest} %")), text("load of the busier bus")));
    }
    if let (Some(fastest), Some(slowest)) = (failovers().reduce(f64::min), failovers().reduce(f64::max)) {
        tiles.push((text(duration(fastest)), text("fastest fail-over")));
        tiles.push((text(duration(slowest)), text("slowest fail-over")));
    }
    if let Some(takeover) = summary.takeover_ms {
        tiles.push((number("takeover_ms", duration(takeover)), text("without a master's heartbeat")));
    }
    if let Some(slowest) = summary.takeover_failover_ms.values().flatten().copied().reduce(f64::max) {
        tiles.push((text(duration(slowest)), text("slowest slave after the loss of the master")));
    }
    tiles.push((number("lost_frames", summary.lost_frames), text("frames lost")));
    html! {
        .tiles { @for (value, what) in tiles { .tile { b { (value) } span { (what) } } } }
    }
}
