//! The tables of a report.

use super::duration;
use super::timeline::Kind;
use crate::flight::Flight;
use crate::narrator::name;
use crate::record::Bus;

/// Fail-over time of every slave.
pub fn failover(flight: &Flight) -> String {
    let rows = flight.observer.slaves().map(|(node, track)| {
        let took = track.failover.map_or("\u{2013}".into(), |took| duration(took.as_secs_f64() * 1e3));
        let now = track.now();
        vec![
            name(node),
            track.access.map_or("", |access| access.name()).to_owned(),
            took,
            format!("{}, {}", now.phase.name(), bus(now.bus)),
        ]
    });
    table("", &["slave", "access", "fail-over", "at the end"], rows)
}

/// Completed frames by kind and bus.
pub fn frames(flight: &Flight) -> String {
    let count =
        |bus, kind| flight.frames().filter(|(_, seen)| seen.bus == bus && Kind::of(seen) == kind).count();
    let mut rows: Vec<Vec<String>> = Kind::ROWS
        .into_iter()
        .chain([Kind::Other])
        .map(|kind| (kind.name(), Bus::BOTH.map(|bus| count(bus, kind))))
        .filter(|(name, counts)| *name != Kind::Other.name() || counts.iter().any(|count| *count > 0))
        .map(|(name, [nominal, redundant])| vec![name.into(), nominal.to_string(), redundant.to_string()])
        .collect();
    let all = Bus::BOTH.map(|bus| flight.frames().filter(|(_, seen)| seen.bus == bus).count());
    rows.push(vec!["<b>all</b>".into(), format!("<b>{}</b>", all[0]), format!("<b>{}</b>", all[1])]);
    table("", &["kind", &bus(Bus::Nominal), &bus(Bus::Redundant)], rows)
}

/// The boards, what the seed made of them and what they counted.
pub fn boards(flight: &Flight) -> String {
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
    table("cards", &head, rows)
}

fn bus(bus: Bus) -> String {
    format!("<span class=\"{0}\">{0}</span>", bus.name())
}

/// A table; of class `cards`, which is for plain heads only, each row becomes a list of its own where there is little room.
fn table(class: &str, head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let label = |column: usize| match class {
        "cards" => format!(" data-label=\"{}\"", head[column]),
        _ => String::new(),
    };
    let titles: String = head.iter().map(|cell| format!("<th>{cell}</th>")).collect();
    let rows: String = rows
        .into_iter()
        .map(|row| {
            let cells = row.iter().enumerate();
            let cells: String =
                cells.map(|(column, cell)| format!("<td{}>{cell}</td>", label(column))).collect();
            format!("<tr>{cells}</tr>\n")
        })
        .collect();
    format!("<table class=\"{class}\">\n<tr>{titles}</tr>\n{rows}</table>\n")
}
