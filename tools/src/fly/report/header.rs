//! Top of a report: the flight, its faults and verdict, and the most important numbers.

use maud::{Markup, html};

use super::duration;
use super::tables::{number, text};
use crate::fly::flight::Flight;
use crate::fly::meaning::Scope;
use crate::fly::narrator::name;
use crate::fly::outcome::UNKNOWN_IMAGES;
use crate::fly::record::{FlightEvent, Node, Occurrence};
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

/// A sentence for each fault, in order of time.
fn faults(flight: &Flight) -> String {
    let sentences = flight.records.iter().filter_map(|record| sentence(flight, record));
    let sentences: Vec<String> = sentences.collect();
    if sentences.is_empty() { "No bus was cut.".into() } else { sentences.join(" ") }
}

/// A sentence about a record, if it is a fault.
fn sentence(flight: &Flight, Occurrence { at, what }: &Occurrence) -> Option<String> {
    let second = at.as_secs_f64();
    Some(match what {
        FlightEvent::Reset(board) if flight.standby_reset() == Some((*at, *board)) => {
            format!("At {second} s {}, the standby, was reset.", name(*board))
        }
        FlightEvent::Reset(board) => format!("At {second} s {} was reset.", name(*board)),
        FlightEvent::Cut(cut) => {
            format!("At {second} s the {} bus was cut {}.", cut.bus.name(), flight.plan.place(cut))
        }
        FlightEvent::PowerOff(board) if flight.loss() == Some((*at, *board)) && flight.masters() > 1 => {
            loss(flight, second, *board)
        }
        FlightEvent::PowerOff(board) => format!("At {second} s {} lost its power.", name(*board)),
        FlightEvent::Other { text, .. } => format!("At {second} s {text}."),
        _ => return None,
    })
}

/// A sentence about the master that lost its power, and about the takeover.
fn loss(flight: &Flight, second: f64, board: Node) -> String {
    let end = flight.takeover().map_or("; no board took over".into(), |takeover| {
        let took = duration(takeover.took().as_secs_f64() * 1e3);
        format!("; {} took over {took} after its last heartbeat", name(takeover.to))
    });
    format!("At {second} s {}, the active one, lost its power{end}.", name(board))
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
