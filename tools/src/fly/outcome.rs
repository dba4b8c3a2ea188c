//! The table at the end of a flight, for the terminal.

use can_twin::wire::time::Time;

use super::flight::{BoardCount, Flight, Heartbeats};
use super::meaning::Scope;
use super::narrator::{milliseconds, name};
use super::plan::BoardPlan;
use super::record::{Bus, Node};
use super::summary::{MissionCounts, Summary};
use super::track::Track;

/// Returns a table of all boards with the totals below.
pub fn text(flight: &Flight, summary: &Summary) -> String {
    let table = table(flight);
    let traffic = summary.mission.as_ref().map_or(UNKNOWN_IMAGES.to_owned() + "\n", mission_totals);
    let frames: u64 = summary.frames.values().sum();
    let takeover = flight.takeover().map_or(String::new(), |takeover| {
        let (to, took, from) = (name(takeover.to), milliseconds(takeover.took()), name(takeover.from));
        format!("{to} took over {took} after the last heartbeat of {from}\n")
    });
    let [nominal, redundant] = Bus::ALL.map(|bus| summary.bus_load_percent[bus.name()]);
    let (operational, slaves) = (summary.slaves_operational_at_end, flight.observer.slaves().count());
    let (stamps, clocks) = (stamps(flight, summary), unjudged_clocks(summary));
    let Summary { bus_changes, lost_frames, aborted_frames, resets, lockups, panics, .. } = summary;
    let Summary { virtual_seconds, wall_seconds, emulated_mips, .. } = summary;
    format!(
        "{table}\n\
         {takeover}{operational} of {slaves} slaves operational; changes of bus: {bus_changes}; load: nominal {nominal} %, \
         redundant {redundant} %\n\
         {traffic}\
         {frames} frames completed, {lost_frames} lost, {aborted_frames} aborted; {resets} resets, {lockups} lock-ups, {panics} \
         panics\n\
         stamps of SYNC: {stamps}\n{clocks}\
         {virtual_seconds} s of virtual time in {wall_seconds} s on this computer ({emulated_mips} million emulated \
         instructions per second; cycle counts are model cycles,\nflash wait states included)\n"
    )
}

/// Notice of omissions in a flight with images of the user's.
pub const UNKNOWN_IMAGES: &str =
    "images of your own: their commands and telemetry are recorded, but neither read nor judged";

fn mission_totals(mission: &MissionCounts) -> String {
    let MissionCounts { tc_sent, tc_due, tc_executed, tc_repeats, tm_requested, tm_received } = mission;
    format!(
        "TC: {tc_sent} on the wire, {tc_due} due, {tc_executed} executed, {tc_repeats} repeats dropped; TM: {tm_requested} \
         requested, {tm_received} received\n"
    )
}

fn table(flight: &Flight) -> String {
    let [second, third, fourth] = match flight.plan.scope() {
        Scope::Mission => ["access", "TC due", "executed"],
        Scope::Protocol => ["image", "heartbeats", "longest gap"],
    };
    let head = ["board", second, "at the end", fail_over_title(flight), third, fourth, "lost", "aborted"];
    let rows = flight.plan.boards.iter().zip(&flight.boards).map(|(plan, board)| {
        let track = &flight.observer.nodes[&board.node];
        let [second, third, fourth] = cells(flight, plan, board, |gap| gap.map_or("-".into(), milliseconds));
        [
            name(board.node),
            second,
            at_the_end(track),
            fail_over(flight, track),
            third,
            fourth,
            board.lost_frames.to_string(),
            board.aborted.len().to_string(),
        ]
    });
    aligned(&std::iter::once(head.map(String::from)).chain(rows).collect::<Vec<_>>(), 3)
}

/// Returns the cells of a board that depend on the images. Shipped images: its access, and commands due and executed.
/// Images of the user's: its image, and heartbeats with their longest gap, formatted by `span`.
pub fn cells(
    flight: &Flight,
    plan: &BoardPlan,
    count: &BoardCount,
    span: impl Fn(Option<Time>) -> String,
) -> [String; 3] {
    let track = &flight.observer.nodes[&plan.node];
    match (flight.plan.scope(), track.access) {
        (Scope::Mission, Some(_)) => {
            [track.kind(), track.tc_due.to_string(), count.counted(|counters| counters.commands)]
        }
        (Scope::Mission, None) => Default::default(),
        (Scope::Protocol, _) => {
            let Heartbeats { count, longest_gap } = flight.heartbeats(plan.node);
            [plan.image().into(), count.to_string(), span(longest_gap)]
        }
    }
}

fn at_the_end(track: &Track) -> String {
    let now = track.now();
    if !now.phase.is_powered() {
        return now.phase.name().into();
    }
    format!("{}, {} bus", track.name_of(now.phase), now.bus.name())
}

fn fail_over_title(flight: &Flight) -> &'static str {
    if flight.masters() > 1 { "fail-over / takeover" } else { "fail-over" }
}

/// Returns the time from the cut; in a flight of two masters also that from the loss of the active one. Empty for a
/// master.
fn fail_over(flight: &Flight, track: &Track) -> String {
    let text = |time: Option<Time>| time.map_or("-".into(), milliseconds);
    match (track.access, flight.masters()) {
        (None, _) => String::new(),
        (Some(_), 1) => text(track.failover),
        (Some(_), _) => format!("{} / {}", text(track.failover), text(track.takeover)),
    }
}

fn stamps(flight: &Flight, summary: &Summary) -> String {
    let compared = flight.stamp_errors.compared;
    match summary.stamp_worst_error_ns {
        Some(worst) => {
            format!("{}; {compared} compared with the truth, at most {worst} ns off", summary.stamp_source)
        }
        None => summary.stamp_source.into(),
    }
}

/// Returns a line with the cause for each slave whose clock has no error in the summary.
fn unjudged_clocks(summary: &Summary) -> String {
    let line = |(node, cause): (&Node, &String)| format!("clock of {} is not judged: {cause}\n", name(*node));
    summary.clock_not_judged.iter().map(line).collect()
}

/// Formats columns of equal width, the first `left` aligned to the left, the others (numbers) to the right.
fn aligned<const N: usize>(rows: &[[String; N]], left: usize) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let cell = |(column, (cell, width)): (usize, (&String, usize))| {
        if column < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    };
    let line =
        |row: &[String; N]| row.iter().zip(widths).enumerate().map(cell).collect::<Vec<_>>().join("   ");
    rows.iter().map(|row| format!("{}\n", line(row).trim_end())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "bb", "1"], ["ccc", "d", "22"]].map(|row| row.map(String::from));
        assert_eq!(aligned(&rows, 2), "a     bb    1\nccc   d    22\n");
    }

    /// Checks that the text of a flight has these parts, and returns it.
    fn assert_text(flight: &Flight, parts: &[&str]) -> String {
        let text = text(flight, &sample::summary(flight));
        parts.iter().for_each(|part| assert!(text.contains(part), "no {part:?} in\n{text}"));
        text
    }

    #[test]
    fn every_board_and_the_totals_are_there() {
        let parts = [
            "master               active, redundant bus     ",
            "node 4   selective   operational, redundant bus   12406.0 ms      271        271",
            "2 of 2 slaves operational; changes of bus: 1; load: nominal 2.25 %, redundant 1.5 %",
            "TC: 778 on the wire, 660 due, 660 executed, 0 repeats dropped",
        ];
        assert_text(&sample::flight(), &parts);
    }

    /// Given a flight whose summary has no error for the clock of a slave, then the text gives the reason.
    #[test]
    fn a_clock_without_an_error_has_a_reason() {
        let mut flight = sample::flight();
        let text_of = |flight: &Flight| text(flight, &sample::summary(flight));
        let without = text_of(&flight);
        let reason = "clock of node 4 is not judged: it received no spacecraft time";
        assert!(without.contains(reason) && !without.contains("clock of node 2"), "{without}");
        flight.clocks[0].set = Time::from_ms(30_000);
        let late = text_of(&flight);
        let reason = "clock of node 2 is not judged: it was set at 30.0 s and the run ended at 40.0 s";
        assert!(late.contains(reason), "{late}");
    }

    /// Both master boards show their roles, and each slave its time from the cut and from the loss of the master.
    #[test]
    fn table_of_two_masters_has_roles_and_both_times() {
        let parts = [
            "fail-over / takeover",
            "master                off ",
            "master 2              active, redundant bus",
            "node 2     parallel   operational, redundant bus   1205.0 ms / 305.0 ms",
            "master 2 took over 399.0 ms after the last heartbeat of master",
        ];
        assert_text(&sample::standby::flight(), &parts);
    }

    #[test]
    fn unknown_images_are_named_and_their_commands_left_out() {
        let mut flight = sample::flight();
        flight.plan.boards[1].own_image = Some("heater".into());
        let parts = ["node 2   heater ", "node 4   shipped", UNKNOWN_IMAGES, "800.0 ms      0         3"];
        let text = assert_text(&flight, &parts);
        assert!(!text.contains("TC"), "{text}");
    }
}
