//! The tables of a report.

use super::duration;
use super::kind::Kind;
use can_wire::time::Time;
use maud::{Markup, html};
use twin::pulses::Errors;

use crate::flight::{BoardCount, Flight, Heartbeats};
use crate::meaning::Scope;
use crate::narrator::name;
use crate::plan::BoardPlan;
use crate::record::Bus;

/// Fail-over time of every slave; in a flight of two masters also its time from the loss of the active one.
pub fn failover(flight: &Flight) -> Markup {
    let has_takeover = flight.masters() > 1;
    let took = |time: Option<Time>| {
        unbroken(&time.map_or("\u{2013}".into(), |took| duration(took.as_secs_f64() * 1e3)))
    };
    let rows = flight.observer.slaves().map(|(node, track)| {
        let now = track.now();
        let access = track.kind();
        let second = if access.is_empty() { "\u{2013}".to_owned() } else { access };
        let mut row = vec![text(name(node)), text(second), took(track.failover)];
        row.extend(has_takeover.then(|| took(track.takeover)));
        row.push(html! { (now.phase.name()) ", " (bus(now.bus)) });
        row
    });
    let takeover = has_takeover.then_some("takeover");
    let head = ["slave", "access", "fail-over"].into_iter().chain(takeover).chain(["at the end"]);
    table(&head.map(text).collect::<Vec<_>>(), rows)
}

/// Errors of the clocks of all slaves that were set.
pub fn clocks(flight: &Flight) -> Markup {
    let rows = flight.clocks.iter().map(|clock| {
        let settled = clock.settled();
        let cell = |figure: fn(&Errors) -> f64| {
            let nanoseconds = |errors| format!("{:.0} ns", figure(errors));
            text(settled.as_ref().map_or("\u{2013}".into(), nanoseconds))
        };
        let set = format!("{:.3} s", clock.set.as_secs_f64());
        vec![text(name(clock.node)), text(set), cell(Errors::rms_ns), cell(Errors::worst_ns)]
    });
    table(&["slave", "set at", "settled, rms", "settled, worst"].map(text), rows)
}

/// Completed frames by kind and bus, and the load of the buses.
pub fn frames(flight: &Flight) -> Markup {
    let count =
        |bus, kind| flight.frames().filter(|(_, seen)| seen.bus == bus && Kind::of(seen) == kind).count();
    let scope = flight.plan.scope();
    let counts = |kind: Kind| (kind.name(), Bus::ALL.map(|bus| count(bus, kind)));
    let others = Kind::others(scope).iter().map(|kind| counts(*kind)).filter(|(_, counts)| *counts != [0, 0]);
    let mut rows: Vec<Vec<Markup>> = Kind::rows(flight)
        .into_iter()
        .map(counts)
        .chain(others)
        .map(|(name, [nominal, redundant])| vec![text(name), html! { (nominal) }, html! { (redundant) }])
        .collect();
    let all = Bus::ALL.map(|bus| flight.frames().filter(|(_, seen)| seen.bus == bus).count());
    rows.push(vec![html! { b { "all" } }, html! { b { (all[0]) } }, html! { b { (all[1]) } }]);
    let [nominal, redundant] = Bus::ALL.map(|bus| format!("{:.1} %", flight.load(bus) * 100.0));
    rows.push(vec![text("bus load"), text(nominal), text(redundant)]);
    table(&[text("kind"), bus(Bus::Nominal), bus(Bus::Redundant)], rows)
}

/// The boards, what the seed made of them and what they counted.
pub fn boards(flight: &Flight) -> Markup {
    let scope = flight.plan.scope();
    let traffic: &[&str] = match scope {
        Scope::Mission => &["TC due", "TC executed"],
        Scope::Protocol => &["heartbeats", "longest gap"],
    };
    let second = if scope == Scope::Mission { "access" } else { "image" };
    let head = [
        &["board", second, "crystal", "place", "power on", "instructions"],
        traffic,
        &["frames lost", "aborted"],
    ];
    let rows = flight.plan.boards.iter().zip(&flight.boards).map(|(plan, count)| {
        let [third, fourth] = traffic_of(flight, plan, count);
        let access = flight.observer.nodes()[&plan.node].kind();
        vec![
            name(plan.node),
            if scope == Scope::Mission { access } else { plan.image().to_owned() },
            format!("{:+.1} ppm", plan.crystal_ppm),
            format!("{:.1} m", plan.position_m),
            format!("{:.0} ms", plan.power_on.as_secs_f64() * 1e3),
            format!("{:.1} M", count.instructions as f64 / 1e6),
            third,
            fourth,
            count.lost_frames.to_string(),
            count.aborted_frames.to_string(),
        ]
    });
    cards(&head.concat(), rows)
}

/// Commands due and executed; of a flight with images of the user's heartbeats and their longest gap.
fn traffic_of(flight: &Flight, plan: &BoardPlan, count: &BoardCount) -> [String; 2] {
    let track = &flight.observer.nodes()[&plan.node];
    match (flight.plan.scope(), track.access) {
        (Scope::Mission, Some(_)) => [track.tc_due.to_string(), count.counted(|counters| counters.commands)],
        (Scope::Mission, None) => [String::new(), String::new()],
        (Scope::Protocol, _) => {
            let Heartbeats { count, longest_gap } = flight.heartbeats(plan.node);
            let gap = longest_gap.map_or("\u{2013}".into(), |gap| duration(gap.as_secs_f64() * 1e3));
            [count.to_string(), gap]
        }
    }
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

/// Text as a cell of one line, also where there is little room.
fn unbroken(words: &str) -> Markup {
    text(words.replace(' ', "\u{a0}"))
}

/// Plain text as a cell.
fn text(text: impl Into<String>) -> Markup {
    html! { (text.into()) }
}
