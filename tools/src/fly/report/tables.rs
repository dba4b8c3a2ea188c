//! The tables of a report.

use std::collections::BTreeMap;

use can_twin::pulses::Errors;
use can_twin::wire::time::Time;
use maud::{Markup, html};

use super::duration;
use super::instant;
use super::kind::Kind;
use crate::fly::aborted::AbortedFrames;
use crate::fly::checks::CheckResult;
use crate::fly::flight::Flight;
use crate::fly::meaning::Scope;
use crate::fly::narrator::name;
use crate::fly::origin::{ImageFile, Origin};
use crate::fly::outcome::cells;
use crate::fly::pdos::SheetName;
use crate::fly::record::Bus;
use crate::fly::summary::Summary;

/// Greatest number of rows of a list; a longer one is shown without its middle.
const ROWS: usize = 100;

/// Fail-over time of every slave; in a flight of two masters also its time from the loss of the active one.
pub fn failover(flight: &Flight) -> Markup {
    let has_takeover = flight.masters() > 1;
    let took = |key, node, time: Option<Time>| {
        let took = time.map_or("\u{2013}".into(), |took| duration(took.as_secs_f64() * 1e3));
        number(&format!("{key}.{node}"), took.replace(' ', "\u{a0}"))
    };
    let rows = flight.observer.slaves().map(|(node, track)| {
        let now = track.now();
        let access = track.kind();
        let second = if access.is_empty() { "\u{2013}".to_owned() } else { access };
        let mut row = vec![text(name(node)), text(second), took("failover_ms", node, track.failover)];
        row.extend(has_takeover.then(|| took("takeover_failover_ms", node, track.takeover)));
        row.push(html! { (now.phase.name()) ", " (bus(now.bus)) });
        row
    });
    let takeover = has_takeover.then_some("takeover");
    let head = ["slave", "access", "fail-over"].into_iter().chain(takeover).chain(["at the end"]);
    table(&head.map(text).collect::<Vec<_>>(), rows)
}

/// The checks of the verdict.
pub fn checks(summary: &Summary) -> Markup {
    let rows = summary.checks.iter().map(|check| {
        let class = match check.result {
            CheckResult::Held => "held",
            CheckResult::Failed | CheckResult::NotJudged => "failed",
        };
        let result = html! { span class=(class) { (check.result.name()) } };
        vec![text(check.name), text(&*check.limit), text(&*check.measured), result]
    });
    table(&["check", "limit", "measured", "result"].map(text), rows)
}

/// Date, commit and the hash of each image.
pub fn origin(summary: &Summary) -> Markup {
    let Origin { date, commit, modified, images } = &summary.origin;
    let (date, short) = (date.replace('T', " ").replace('Z', " UTC"), commit.get(..12).unwrap_or(commit));
    let state = if *modified == Some(true) { ", modified" } else { "" };
    // Boards with the same image share a row.
    let mut boards: BTreeMap<&ImageFile, Vec<String>> = BTreeMap::new();
    for (node, image) in images {
        boards.entry(image).or_default().push(name(*node));
    }
    let rows = boards.into_iter().map(|(image, boards)| {
        let hash = image.sha256.get(..16).unwrap_or(&image.sha256);
        vec![text(&*image.file), html! { code title=(image.sha256) { (hash) } }, text(boards.join(", "))]
    });
    html! {
        p { "Flown on " span data-text="date" { (date) } ". Commit: " code title=(commit) { (short) } (state) "." }
        table.wrapped { (rows_of(&["image", "SHA-256, first digits", "boards"].map(text), rows)) }
    }
}

/// The last values of the PDOs of boards with data sheets.
pub fn pdos(summary: &Summary) -> Markup {
    let rows = summary.pdo_values.iter().map(|pdo| {
        let (frames, values) = (pdo.frames.to_string(), by_object(&pdo.values));
        vec![name(pdo.node), pdo.cob_id.clone(), frames, values]
    });
    bounded(&["node", "COB-ID", "frames", "values in the last one"], rows.collect(), plain)
}

/// Values with the name of each object once: `Telemetry: Code 288, Data 0`.
fn by_object(values: &[(String, String)]) -> String {
    let object = |name: &str| name.split_once(", ").map(|(object, _)| format!("{object}: "));
    let is_same = |one: &str, other: &str| object(one).is_some() && object(one) == object(other);
    let group = |values: &[(String, String)]| {
        let part = |(name, value): &(String, String)| {
            format!("{} {value}", name.split_once(", ").map_or(&**name, |(_, part)| part))
        };
        let parts: Vec<String> = values.iter().map(part).collect();
        object(&values[0].0).unwrap_or_default() + &parts.join(", ")
    };
    values.chunk_by(|(one, _), (other, _)| is_same(one, other)).map(group).collect::<Vec<_>>().join("; ")
}

/// Data sheets of the boards. Boards with the same one share a row.
pub fn sheets(summary: &Summary) -> Markup {
    let mut boards: BTreeMap<&SheetName, Vec<String>> = BTreeMap::new();
    for (node, sheet) in &summary.data_sheets {
        boards.entry(sheet).or_default().push(name(*node));
    }
    let rows = boards.into_iter().map(|(sheet, boards)| {
        let device = sheet.device.as_deref().unwrap_or("\u{2013}");
        vec![text(&*sheet.file), text(device), text(boards.join(", "))]
    });
    html! { table.wrapped { (rows_of(&["data sheet", "device", "boards"].map(text), rows)) } }
}

/// Aborted frames by board, bus and COB-ID.
pub fn aborted(summary: &Summary) -> Markup {
    let row = |frames: &AbortedFrames| {
        let AbortedFrames { node, bus, cob_id, failed, arbitration_lost, not_attempted, .. } = frames;
        let [first, last] = [frames.first_at_seconds, frames.last_at_seconds].map(instant);
        let counts =
            [frames.frames, *failed, *arbitration_lost, *not_attempted].map(|count| count.to_string());
        [name(*node), (*bus).into(), cob_id.clone()].into_iter().chain(counts).chain([first, last]).collect()
    };
    let head =
        ["board", "bus", "COB-ID", "frames", "failed", "arbitration lost", "not attempted", "first", "last"];
    bounded(&head, summary.aborted.iter().map(row).collect(), cards)
}

/// Slaves whose clock is not judged, with the cause.
pub fn unjudged(summary: &Summary) -> Markup {
    html! {
        @if !summary.clock_not_judged.is_empty() {
            ul {
                @for (node, cause) in &summary.clock_not_judged {
                    li { "The clock of " (name(*node)) " is not judged: " (cause) "." }
                }
            }
        }
    }
}

/// Errors of the clocks of all slaves that were set.
pub fn clocks(flight: &Flight) -> Markup {
    let rows = flight.clocks.iter().map(|clock| {
        let settled = clock.settled();
        let cell = |key, figure: fn(&Errors) -> f64| {
            let nanoseconds = |errors| format!("{:.0} ns", figure(errors));
            let error = settled.as_ref().map_or("\u{2013}".into(), nanoseconds);
            number(&format!("{key}.{}", clock.node), error)
        };
        let set = format!("{:.3} s", clock.set.as_secs_f64());
        let rms = cell("clock_rms_error_ns", Errors::rms_ns);
        let worst = cell("clock_worst_error_ns", Errors::worst_ns);
        vec![text(name(clock.node)), text(set), rms, worst]
    });
    table(&["slave", "set at", "settled, rms", "settled, worst"].map(text), rows)
}

/// Completed frames by kind and bus, and the load of the buses.
pub fn frames(flight: &Flight) -> Markup {
    let count =
        |bus, kind| flight.frames().filter(|(_, seen)| seen.bus == bus && Kind::of(seen) == kind).count();
    let counts = |kind: Kind| (kind.look()[0], Bus::ALL.map(|bus| count(bus, kind)));
    let others = Kind::OTHERS.iter().map(|kind| counts(*kind)).filter(|(_, counts)| *counts != [0, 0]);
    let mut rows: Vec<Vec<Markup>> = Kind::rows(flight)
        .into_iter()
        .map(counts)
        .chain(others)
        .map(|(name, [nominal, redundant])| vec![text(name), html! { (nominal) }, html! { (redundant) }])
        .collect();
    let all = Bus::ALL.map(|bus| flight.frames().filter(|(_, seen)| seen.bus == bus).count());
    let total = |bus: Bus| html! { b { (number(&format!("frames.{}", bus.name()), all[bus as usize])) } };
    rows.push(vec![html! { b { "all" } }, total(Bus::Nominal), total(Bus::Redundant)]);
    let load = |bus: Bus| {
        let load = format!("{:.1} %", flight.load(bus) * 100.0);
        number(&format!("bus_load_percent.{}", bus.name()), load)
    };
    rows.push(vec![text("bus load"), load(Bus::Nominal), load(Bus::Redundant)]);
    table(&[text("kind"), bus(Bus::Nominal), bus(Bus::Redundant)], rows)
}

/// Returns the boards with their random properties and counters.
pub fn boards(flight: &Flight) -> Markup {
    let (second, traffic) = match flight.plan.scope() {
        Scope::Mission => ("access", ["TC due", "TC executed"]),
        Scope::Protocol => ("image", ["heartbeats", "longest gap"]),
    };
    let head = [
        &["board", second, "crystal", "place", "power on", "instructions"][..],
        &traffic,
        &["frames lost", "aborted"],
    ];
    let rows = flight.plan.boards.iter().zip(&flight.boards).map(|(plan, count)| {
        let gap = |gap: Option<Time>| gap.map_or("\u{2013}".into(), |gap| duration(gap.as_secs_f64() * 1e3));
        let [second, third, fourth] = cells(flight, plan, count, gap);
        vec![
            name(plan.node),
            second,
            format!("{:+.1} ppm", plan.crystal.ppm),
            format!("{:.1} m", plan.position_m),
            format!("{:.0} ms", plan.power_on.as_secs_f64() * 1e3),
            format!("{:.1} M", count.instructions as f64 / 1e6),
            third,
            fourth,
            count.lost_frames.to_string(),
            count.aborted.len().to_string(),
        ]
    });
    cards(&head.concat(), rows.collect())
}

fn bus(bus: Bus) -> Markup {
    html! { span class=(bus.name()) { (bus.name()) } }
}

/// A table.
fn table(head: &[Markup], rows: impl IntoIterator<Item = Vec<Markup>>) -> Markup {
    html! { table { (rows_of(head, rows)) } }
}

fn rows_of(head: &[Markup], rows: impl IntoIterator<Item = Vec<Markup>>) -> Markup {
    html! {
        tr { @for title in head { th { (title) } } }
        @for row in rows { tr { @for cell in row { td { (cell) } } } }
    }
}

/// A table of at most [`ROWS`] rows: the first and the last half of a longer list, with the number of those left out.
pub fn bounded(
    head: &[&str],
    mut rows: Vec<Vec<String>>,
    table: fn(&[&str], Vec<Vec<String>>) -> Markup,
) -> Markup {
    let left_out = rows.len().saturating_sub(ROWS);
    if left_out > 0 {
        rows.drain(ROWS / 2..ROWS / 2 + left_out);
    }
    html! {
        @if left_out > 0 { p { (left_out) " rows in the middle are left out." } }
        @if !rows.is_empty() { .list { (table(head, rows)) } }
    }
}

/// A table of plain text.
pub fn plain(head: &[&str], rows: Vec<Vec<String>>) -> Markup {
    let head: Vec<Markup> = head.iter().copied().map(text).collect();
    table(&head, rows.into_iter().map(|row| row.into_iter().map(text).collect()))
}

/// Returns a table; on narrow pages each row becomes a list.
pub fn cards(head: &[&str], rows: Vec<Vec<String>>) -> Markup {
    html! {
        table.cards {
            tr { @for title in head { th { (title) } } }
            @for row in rows { tr { @for (title, cell) in head.iter().zip(row) { td data-label=(title) { (cell) } } } }
        }
    }
}

/// Formats a number of `summary.json`; `key` is its path there, with dots.
pub fn number(key: &str, value: impl maud::Render) -> Markup {
    html! { span data-key=(key) { (value) } }
}

/// Plain text as a cell.
pub fn text(text: impl Into<String>) -> Markup {
    html! { (text.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_objects_are_not_repeated() {
        let values =
            [("State", "7"), ("Telemetry, Code", "288"), ("Telemetry, Data", "0"), ("Time, Fine", "5")];
        let values = values.map(|(name, value)| (name.to_owned(), value.to_owned()));
        assert_eq!(by_object(&values), "State 7; Telemetry: Code 288, Data 0; Time: Fine 5");
    }

    #[test]
    fn long_lists_lose_their_middle_and_say_so() {
        let rows = |count: usize| (0..count).map(|row| vec![format!("<{row}>")]).collect();
        let whole = bounded(&["row"], rows(ROWS), plain).into_string();
        assert!(!whole.contains("left out") && whole.contains("&lt;99&gt;"), "{whole}");
        let long = bounded(&["row"], rows(ROWS + 7), plain).into_string();
        assert!(long.contains("<p>7 rows in the middle are left out"), "{long}");
        assert_eq!(long.matches("&lt;").count(), ROWS);
        for (row, is_there) in [(49, true), (50, false), (56, false), (57, true), (106, true)] {
            assert_eq!(long.contains(&format!("&lt;{row}&gt;")), is_there, "{row}");
        }
    }
}
