//! Flags of a timeline: lines through the lanes at a cut, at the loss of a master and at the reactions, with texts
//! above them.

use can_twin::wire::time::Time;

use super::axis::Axis;
use super::kind::Kind;
use super::lanes::{Lanes, lane_title};
use crate::fly::drawing::labels::{self, Label};
use crate::fly::drawing::{Picture, text_width};
use crate::fly::flight::Flight;
use crate::fly::narrator::name;
use crate::fly::record::{Bus, MASTER, Node};

/// Height of letters that are as wide as those of the title of a lane.
const TITLE: f64 = 17.5;

/// A line through a lane, and its text.
#[derive(Clone)]
struct Flag {
    at: Time,
    /// Lane of the line.
    bus: Bus,
    /// Lane above which the text is.
    words: Bus,
    class: &'static str,
    text: String,
}

/// The flags of a picture.
pub struct Flags {
    flags: Vec<(Flag, Label)>,
    /// Height of the words above the first row, per lane.
    heights: [f64; 2],
}

impl Flags {
    /// The flags that an axis shows.
    pub fn of(flight: &Flight, axis: &Axis) -> Flags {
        let layout = axis.layout;
        let all = [of_cut(flight, axis), of_loss(flight, axis)].concat();
        let mut flags = Vec::new();
        let heights = Bus::ALL.map(|bus| {
            let mine: Vec<Flag> = all.iter().filter(|flag| flag.words == bus).cloned().collect();
            let mut labels: Vec<Label> =
                mine.iter().map(|flag| Label::beside(layout, axis.x(flag.at), &flag.text)).collect();
            // In a narrow layout the title of the lane extends over the plot.
            let title = if layout.brief { text_width(&lane_title(bus), TITLE) + labels::APART } else { 0.0 };
            let rows = labels::arrange(&mut labels, title);
            flags.extend(mine.into_iter().zip(labels));
            rows as f64 * labels::ROW
        });
        Flags { flags, heights }
    }

    /// Returns the height that the texts of a lane need in addition to a single row.
    pub fn height(&self, bus: Bus) -> f64 {
        self.heights[bus as usize]
    }

    /// Draws lines and texts.
    pub fn draw(&self, picture: &mut Picture, lanes: &Lanes) {
        for (Flag { bus, words, class, text, .. }, label) in &self.flags {
            let (x, top, up) = (label.line, lanes.top(*words), label.row as f64 * labels::ROW);
            if bus != words {
                picture.line(class, (x, lanes.top(*bus) - 8.0), (x, lanes.bottom(*bus)));
            }
            picture.line(class, (x, top - 8.0 - up), (x, lanes.bottom(*words)));
            let (end, x) = if label.is_right() { ("", label.left) } else { (" end", label.right) };
            picture.text(&format!("{class}-label{end}"), x, top - 9.0 - up, text);
        }
    }
}

/// Returns the flag of the cut on its lane, and that of the change of the bus on the other one.
fn of_cut(flight: &Flight, axis: &Axis) -> Vec<Flag> {
    let mut flags = Vec::new();
    let Some((cut, bus)) = flight.cut().filter(|(at, _)| axis.shows(*at)) else { return flags };
    let brief = axis.layout.brief;
    let place = flight
        .plan
        .cut()
        .filter(|_| !brief)
        .map_or(String::new(), |cut| format!(" {}", flight.plan.place(&cut)));
    let text = format!("cut{place}, {:.1} s", cut.as_secs_f64());
    flags.push(Flag { at: cut, bus, words: bus, class: "cut", text });
    if let Some(switch) = flight.switch().filter(|at| *at >= cut && axis.shows(*at)) {
        let delay = switch.since(cut).as_secs_f64() * 1e3;
        let text = if brief {
            format!("switch, +{delay:.1} ms")
        } else {
            format!("{} switches, {delay:.1} ms after the cut", name(active_at(flight, switch).1))
        };
        let bus = bus.other();
        flags.push(Flag { at: switch, bus, words: bus, class: "switch", text });
    }
    flags
}

/// Returns the flag of the loss of a master on the lane of the active bus, and that of the takeover on its bus.
fn of_loss(flight: &Flight, axis: &Axis) -> Vec<Flag> {
    let mut flags = Vec::new();
    let Some((lost, board)) = flight.loss().filter(|(at, _)| axis.shows(*at)) else { return flags };
    let brief = axis.layout.brief;
    let text = if brief {
        "off".into()
    } else {
        format!("{} loses its power, {:.1} s", name(board), lost.as_secs_f64())
    };
    let (bus, _) = active_at(flight, lost);
    flags.push(Flag { at: lost, bus, words: bus, class: "cut", text });
    if let Some(takeover) = flight.takeover().filter(|takeover| axis.shows(takeover.first)) {
        let took = takeover.took().as_secs_f64() * 1e3;
        let text = if brief {
            format!("+{took:.1} ms")
        } else {
            format!("{} takes over, {took:.1} ms after the last heartbeat", name(takeover.to))
        };
        let (bus, _) = active_at(flight, takeover.first);
        // Above the other lane, because the text of the loss is near.
        flags.push(Flag { at: takeover.first, bus, words: bus.other(), class: "switch", text });
    }
    flags
}

/// Bus and sender of the last heartbeat of a master up to an instant.
fn active_at(flight: &Flight, at: Time) -> (Bus, Node) {
    let beats = flight.frames().filter(|(end, seen)| *end <= at && Kind::of(seen) == Kind::Master);
    beats.last().map_or((Bus::Nominal, MASTER), |(_, seen)| (seen.bus, seen.from))
}
