//! The tables of a report.

use super::duration;
use super::timeline::Kind;
use maud::{Markup, html};

use crate::flight::Flight;
use crate::narrator::name;
use crate::record::Bus;

/// Fail-over time of every slave.
pub fn failover(flight: &Flight) -> Markup {
    let rows = flight.observer.slaves().map(|(node, track)| {
        let took = track.failover.map_or("\u{2013}".into(), |took| duration(took.as_secs_f64() * 1e3));
        let now = track.now();
        vec![
            text(name(node)),
            text(track.access.map_or("", |access| access.name())),
            text(took),
            html! { (now.phase.name()) ", " (bus(now.bus)) },
        ]
    });
    table(&["slave", "access", "fail-over", "at the end"].map(text), rows)
}

/// Completed frames by kind and bus.
pub fn frames(flight: &Flight) -> Markup {
    let count =
        |bus, kind| flight.frames().filter(|(_, seen)| seen.bus == bus && Kind::of(seen) == kind).count();
    let mut rows: Vec<Vec<Markup>> = Kind::ROWS
        .into_iter()
        .chain([Kind::Other])
        .map(|kind| (kind.name(), Bus::BOTH.map(|bus| count(bus, kind))))
        .filter(|(name, counts)| *name != Kind::Other.name() || counts.iter().any(|count| *count > 0))
        .map(|(name, [nominal, redundant])| vec![text(name), html! { (nominal) }, html! { (redundant) }])
        .collect();
    let all = Bus::BOTH.map(|bus| flight.frames().filter(|(_, seen)| seen.bus == bus).count());
    rows.push(vec![html! { b { "all" } }, html! { b { (all[0]) } }, html! { b { (all[1]) } }]);
    table(&[text("kind"), bus(Bus::Nominal), bus(Bus::Redundant)], rows)
}

/// The boards, what the seed made of them and what they counted.
pub fn boards(flight: &Flight) -> Markup {
    let rows = flight.plan.boards.iter().zip(&flight.boards).map(|(plan, count)| {
        let track = &flight.observer.nodes()[&plan.node];
        let (due, executed) = match track.access {
            Some(_) => (track.tc_due.to_string(), count.telltale.commands.to_string()),
            None => ("".into(), "".into()),
        };
        vec![
            name(plan.node),
            track.access.map_or("", |access| access.name()).to_owned(),
            format!("{:+.1} ppm", plan.crystal_ppm),
            format!("{:.1} m", plan.position_m),
            format!("{:.0} ms", plan.power_on.as_secs_f64() * 1e3),
            format!("{:.1} M", count.instructions as f64 / 1e6),
            due,
            executed,
            count.lost_frames.to_string(),
            count.aborted_frames.to_string(),
        ]
    });
    let head = [
        "board",
        "access",
        "crystal",
        "place",
        "power on",
        "instructions",
        "TC due",
        "TC executed",
        "frames lost",
        "aborted",
    ];
    cards(&head, rows)
}

fn bus(bus: Bus) -> Markup {
    html! { span class=(bus.name()) { (bus.name()) } }
}

/// A table.
fn table(head: &[Markup], rows: impl IntoIterator<Item = Vec<Markup>>) -> Markup {
    html! {
        table {
            tr { @for title in head { th { (title) } } }
            @for row in rows { tr { @for cell in row { td { (cell) } } } }
        }
    }
}

/// A table; where there is little room each row becomes a list of its own.
fn cards(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Markup {
    html! {
        table.cards {
            tr { @for title in head { th { (title) } } }
            @for row in rows { tr { @for (title, cell) in head.iter().zip(row) { td data-label=(title) { (cell) } } } }
        }
    }
}

/// Plain text as a cell.
fn text(text: impl Into<String>) -> Markup {
    html! { (text.into()) }
}
