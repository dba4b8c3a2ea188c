//! Tables of emergencies and of other events, in chronological order.

use maud::{Markup, html};

use super::instant;
use super::tables::{bounded, cards, number, plain};
use crate::fly::emergencies::EqualEmergencies;
use crate::fly::flight::Flight;
use crate::fly::line::{Line, Topic};
use crate::fly::narrator::name;
use crate::fly::summary::Summary;

/// All emergency messages: equal ones of a node are one row.
pub fn emergencies(summary: &Summary) -> Markup {
    let row = |message: &EqualEmergencies| {
        let EqualEmergencies { node, code, register, details, buses, count, .. } = message;
        let [first, last] = [message.first_at_seconds, message.last_at_seconds].map(instant);
        let last = if *count > 1 { last } else { String::new() };
        let texts = [buses.join(", "), code.clone(), register.clone(), details.replace(' ', "\u{a0}")];
        [name(*node), count.to_string(), first, last].into_iter().chain(texts).collect()
    };
    let head = ["node", "messages", "first", "last", "bus", "error code", "error register", "details"];
    html! {
        p { (number("emergencies", summary.emergencies)) " emergency messages completed." }
        (bounded(&head, summary.equal_emergencies.iter().map(row).collect(), cards))
    }
}

/// All other events.
pub fn others(flight: &Flight) -> Markup {
    let row = |line: &Line| {
        let bus = line.bus.map_or("", |bus| bus.name());
        let text = line.text.trim_matches(['=', ' ']);
        vec![instant(line.at.as_secs_f64()), bus.into(), line.who.clone(), text.into()]
    };
    let events = flight.story.iter().filter(|line| line.topic == Topic::Event);
    bounded(&["time", "bus", "node", "event"], events.map(row).collect(), plain)
}
