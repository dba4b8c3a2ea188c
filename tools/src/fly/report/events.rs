//! Tables of emergencies and of other events, in chronological order.

use super::tables::{bounded, cards, number, plain};
use crate::fly::emergency;
use crate::fly::flight::Flight;
use crate::fly::line::{Line, Topic};
use crate::fly::meaning::Meaning;
use crate::fly::narrator::name;
use can_twin::wire::time::Time;
use maud::{Markup, html};

/// All emergency messages.
pub fn emergencies(flight: &Flight) -> Markup {
    let rows: Vec<_> = flight
        .emergencies()
        .filter_map(|(at, seen)| {
            let Some(Meaning::Emergency { node, code, register, details }) = seen.meaning else {
                return None;
            };
            let details: Vec<String> = details.iter().map(|byte| format!("{byte:02X}")).collect();
            Some(vec![
                seconds(at),
                seen.bus.name().into(),
                name(seen.board(node)),
                format!("{code:04X}h: {}", emergency::meaning(code)),
                format!("{register:02X}h: {}", emergency::register(register)),
                details.join(" "),
            ])
        })
        .collect();
    html! {
        p { (number("emergencies", rows.len())) " emergency messages completed." }
        (bounded(&["time", "bus", "node", "error code", "error register", "details"], rows, cards))
    }
}

/// All other events.
pub fn others(flight: &Flight) -> Markup {
    let row = |line: &Line| {
        let bus = line.bus.map_or("", |bus| bus.name());
        let text = line.text.trim_matches(['=', ' ']);
        vec![seconds(line.at), bus.into(), line.who.clone(), text.into()]
    };
    let events = flight.story.iter().filter(|line| line.topic == Topic::Event);
    bounded(&["time", "bus", "node", "event"], events.map(row).collect(), plain)
}

fn seconds(at: Time) -> String {
    format!("{:.4} s", at.as_secs_f64())
}
