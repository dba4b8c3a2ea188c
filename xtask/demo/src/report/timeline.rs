//! The two buses over time: a lane each, a row per kind of frame, a tick per frame.

use std::collections::BTreeSet;

use can_wire::time::Time;

use super::axis::{Axis, Layout};
use super::svg::Svg;
use crate::flight::Flight;
use crate::meaning::{Meaning, Scope};
use crate::narrator::name;
use crate::record::{Bus, MASTER, Seen, is_master};

/// Kinds of frames, in the order of their rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Network,
    Master,
    Slave,
    Time,
    Command,
    Request,
    Reply,
    Sdo,
    MasterPdo,
    SlavePdo,
    Other,
}

impl Kind {
    /// Those with a row of their own in the pictures; the others share the first row.
    pub fn rows(scope: Scope) -> [Kind; ROWS] {
        let [network, master, slave, time] = [Kind::Network, Kind::Master, Kind::Slave, Kind::Time];
        match scope {
            Scope::Mission => [network, master, slave, time, Kind::Command, Kind::Request, Kind::Reply],
            Scope::Protocol => [network, master, slave, time, Kind::Sdo, Kind::MasterPdo, Kind::SlavePdo],
        }
    }

    /// Those without.
    pub fn others(scope: Scope) -> &'static [Kind] {
        match scope {
            Scope::Mission => &[Kind::Sdo, Kind::Other],
            Scope::Protocol => &[Kind::Other],
        }
    }

    /// The kind of a frame.
    pub fn of(seen: &Seen) -> Kind {
        match seen.meaning {
            Some(Meaning::Nmt { .. } | Meaning::BootUp { .. } | Meaning::Emergency { .. }) => Kind::Network,
            Some(Meaning::Sdo { .. }) => Kind::Sdo,
            Some(Meaning::Pdo) if is_master(seen.from) => Kind::MasterPdo,
            Some(Meaning::Pdo) => Kind::SlavePdo,
            Some(Meaning::Heartbeat { node: MASTER, .. }) => Kind::Master,
            Some(Meaning::Heartbeat { .. }) => Kind::Slave,
            Some(Meaning::Sync | Meaning::SpacecraftTime(_) | Meaning::LocalTime { .. }) => Kind::Time,
            Some(Meaning::Telecommand { .. }) => Kind::Command,
            Some(Meaning::TelemetryRequest { .. }) => Kind::Request,
            Some(Meaning::Telemetry { .. } | Meaning::CyclicState { .. }) => Kind::Reply,
            None => Kind::Other,
        }
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Network => "NMT, boot-up, EMCY",
            Kind::Master => "heartbeat, master",
            Kind::Slave => "heartbeats, slaves",
            Kind::Time => "SYNC and time",
            Kind::Command => "TC",
            Kind::Request => "TM request",
            Kind::Reply => "TM reply",
            Kind::Sdo => "SDO",
            Kind::MasterPdo => "PDOs, master",
            Kind::SlavePdo => "PDOs, slaves",
            Kind::Other => "other",
        }
    }

    /// Its name where there is little room.
    fn brief(self) -> &'static str {
        match self {
            Kind::Network => "NMT, EMCY",
            Kind::Master => "HB master",
            Kind::Slave => "HB slaves",
            Kind::Time => "SYNC, time",
            Kind::MasterPdo => "PDO master",
            Kind::SlavePdo => "PDO slaves",
            _ => self.name(),
        }
    }

    /// Its class in the pictures.
    pub fn class(self) -> &'static str {
        match self {
            Kind::Network => "network",
            Kind::Master => "master",
            Kind::Slave => "slave",
            Kind::Time => "time",
            Kind::Command | Kind::MasterPdo => "command",
            Kind::Request | Kind::Sdo => "request",
            Kind::Reply | Kind::SlavePdo => "reply",
            Kind::Other => "other",
        }
    }
}

const ROWS: usize = 7;

const ROW: f64 = 16.0;
const LANE: f64 = ROWS as f64 * ROW + 6.0;
const TITLE: f64 = 32.0;
const AXIS: f64 = 26.0;
const HEIGHT: f64 = 2.0 * (TITLE + LANE) + AXIS;

fn top(bus: Bus) -> f64 {
    TITLE + bus as usize as f64 * (LANE + TITLE)
}

/// The whole flight.
pub fn overview(flight: &Flight, layout: Layout) -> Svg {
    draw(
        flight,
        Axis::new(layout, Time::ZERO, flight.end),
        "",
        "Frames on the two buses over the whole flight",
    )
}

/// The moments around the cut, or the loss of a master, until the slaves with parallel access are back; `None` without.
pub fn close_up(flight: &Flight, layout: Layout) -> Option<Svg> {
    let cut = flight.fault()?;
    let from = cut - Time::from_ms(400);
    let back = flight.observer.slaves().filter_map(|(_, track)| track.failover).min();
    let switch = flight.switch().map(|at| at.since(cut));
    let after = back.or(switch).unwrap_or_default() + Time::from_ms(600);
    let until = (cut + after).min(flight.end);
    (until > cut)
        .then(|| draw(flight, Axis::new(layout, from, until), " close-up", "Frames around the fault"))
}

fn draw(flight: &Flight, axis: Axis, tick_class: &str, title: &str) -> Svg {
    let (layout, scope) = (axis.layout(), flight.plan.scope());
    let mut svg = Svg::new(layout.width, HEIGHT, title);
    let (left, right) = axis.ends();
    svg.rect("paper", 0.0, 0.0, layout.width, HEIGHT);
    for bus in Bus::ALL {
        svg.rect("lane", left, top(bus), right - left, LANE);
    }
    shade_active(flight, &axis, &mut svg);
    axis.draw(&mut svg, top(Bus::Nominal), top(Bus::Redundant) + LANE);
    for bus in Bus::ALL {
        let lane = format!("{} bus", capital(bus.name()));
        // Wider than the names of the rows where there is little room, so it begins at the border.
        let (anchor, x) = if layout.brief { ("", 0.0) } else { (" end", left - 12.0) };
        svg.text(&format!("bus-{}{anchor}", bus.name()), x, top(bus) - 9.0, &lane);
        for (row, kind) in Kind::rows(scope).into_iter().enumerate() {
            let y = row_top(bus, row);
            let name = if layout.brief { kind.brief() } else { kind.name() };
            svg.text("soft end", left - 12.0, y + 11.0, name);
        }
        let others = Kind::others(scope).iter().map(|kind| (0, *kind));
        for (row, kind) in Kind::rows(scope).into_iter().enumerate().chain(others) {
            let places: BTreeSet<i64> = flight
                .frames()
                .filter(|(at, seen)| seen.bus == bus && axis.shows(*at) && Kind::of(seen) == kind)
                .map(|(at, _)| (axis.x(at) * 5.0).round() as i64 * 2)
                .collect();
            svg.ticks(&format!("{}{tick_class}", kind.class()), places, row_top(bus, row), ROW - 4.0);
        }
    }
    annotate(flight, &axis, &mut svg);
    svg
}

fn row_top(bus: Bus, row: usize) -> f64 {
    top(bus) + 5.0 + row as f64 * ROW
}

/// The bus on which the master's heartbeat runs has another ground.
fn shade_active(flight: &Flight, axis: &Axis, svg: &mut Svg) {
    let mut beats = flight
        .frames()
        .filter(|(_, seen)| Kind::of(seen) == Kind::Master)
        .map(|(at, seen)| (at, (seen.bus, seen.from)))
        .peekable();
    while let Some((begin, place)) = beats.next() {
        let (mut last, (bus, board)) = (begin, place);
        while let Some((at, _)) = beats.next_if(|(_, next)| *next == place) {
            last = at;
        }
        // Without a successor it runs to the end, or to the cut or the loss that silenced it.
        let cut = flight.cut().filter(|(at, cut)| *cut == bus && *at >= last).map(|(at, _)| at);
        let silenced = cut.or(flight.loss().filter(|(_, lost)| *lost == board).map(|(at, _)| at));
        let end = silenced.unwrap_or(if beats.peek().is_some() { last } else { flight.end });
        let (x, until) = (axis.x(begin), axis.x(end));
        svg.rect("active", x, top(bus), until - x, LANE);
    }
}

fn annotate(flight: &Flight, axis: &Axis, svg: &mut Svg) {
    annotate_takeover(flight, axis, svg);
    let Some((cut, bus)) = flight.cut().filter(|(at, _)| axis.shows(*at)) else { return };
    let brief = axis.layout().brief;
    let label = if brief { "cut" } else { "cut next to the master" };
    let label = format!("{label}, {:.1} s", cut.as_secs_f64());
    flag(svg, axis, cut, bus, "cut", &label);
    let Some(switch) = flight.switch().filter(|at| *at >= cut && axis.shows(*at)) else { return };
    let delay = switch.since(cut).as_secs_f64() * 1e3;
    let label = if brief {
        format!("switch, +{delay:.1} ms")
    } else {
        format!("master switches, {delay:.1} ms after the cut")
    };
    flag(svg, axis, switch, bus.other(), "switch", &label);
}

/// The loss of a master on the lane of the bus that was active, the takeover on that of the bus where it was.
fn annotate_takeover(flight: &Flight, axis: &Axis, svg: &mut Svg) {
    let brief = axis.layout().brief;
    let bus_at = |at: Time| {
        let beats = flight.frames().filter(|(end, seen)| *end <= at && Kind::of(seen) == Kind::Master);
        beats.last().map_or(Bus::Nominal, |(_, seen)| seen.bus)
    };
    let Some((lost, board)) = flight.loss().filter(|(at, _)| axis.shows(*at)) else { return };
    let label = if brief {
        "off".into()
    } else {
        format!("{} loses its power, {:.1} s", name(board), lost.as_secs_f64())
    };
    flag(svg, axis, lost, bus_at(lost), "cut", &label);
    let Some(takeover) = flight.takeover().filter(|takeover| axis.shows(takeover.first)) else { return };
    let took = takeover.took().as_secs_f64() * 1e3;
    let label = if brief {
        format!("+{took:.1} ms")
    } else {
        format!("{} takes over, {took:.1} ms after the last heartbeat", name(takeover.to))
    };
    // Its words above the other lane, where those of the loss are not in the way.
    let (bus, x) = (bus_at(takeover.first), axis.x(takeover.first));
    svg.line("switch", (x, top(bus) - 8.0), (x, top(bus) + LANE));
    flag(svg, axis, takeover.first, bus.other(), "switch", &label);
}

/// A vertical line through a lane and words above it, on the side where there is room.
fn flag(svg: &mut Svg, axis: &Axis, at: Time, bus: Bus, class: &str, text: &str) {
    let (x, y) = (axis.x(at), top(bus));
    svg.line(class, (x, y - 8.0), (x, y + LANE));
    if axis.layout().has_room(x + 6.0, text) {
        svg.text(&format!("{class}-label"), x + 6.0, y - 9.0, text);
    } else {
        svg.text(&format!("{class}-label end"), x - 6.0, y - 9.0, text);
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
