//! What the demonstration mission takes of its boards and buses, by profile and role.
//!
//! A run of 10 s from power-on without faults: the master, in profile `standby` two of them, three slaves and a minimal slave. A role has
//! the worst of its boards. Flash and RAM of profile `standard` are rows of `size`.

use can_twin::wire::time::Time;
use ecss_can_cli::fly::Options;
use ecss_can_cli::fly::flight::{BoardCount, Flight};
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::fly::record::{Bus, is_master};
use ecss_can_cli::images::LOG;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::elf::Facts;

use crate::bench::context::{Context, FLOWN};
use crate::bench::row::Row;

/// Length of a run, virtual seconds.
const SECONDS: f64 = 10.0;

/// Clock of the cores, cycles per second.
const HCLK: f64 = 168e6;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let profiles = [Profile::Standard, Profile::Standby, Profile::Librecube];
    let rows = profiles.into_iter().map(|profile| measure_profile(context, profile));
    Ok(rows.collect::<anyhow::Result<Vec<_>>>()?.concat())
}

fn measure_profile(context: &Context, profile: Profile) -> anyhow::Result<Vec<Row>> {
    let mut options = Options { minimal: 1, seconds: SECONDS, ..Options::default() };
    options.fleet.target.profile = profile;
    let plan = Plan { faults: Vec::new(), ..Plan::new(&options)? };
    let flight = context.fly(plan)?;
    let roles = ["master", "standby", "slave", "minimal"];
    let mut rows: Vec<Row> = roles.into_iter().flat_map(|role| of_role(&flight, role)).collect();
    let load = |bus: Bus| Row::lower(format!("{}_load", bus.name()), flight.load(bus) * 100.0, "percent");
    rows.extend(Bus::ALL.map(load));
    if profile != Profile::Standard {
        rows.extend(sizes(context, profile)?);
    }
    Ok(rows.into_iter().map(|row| Row { name: format!("{}.{}", profile.name(), row.name), ..row }).collect())
}

/// Stack and processor time of the boards of a role; none if there is no such board.
fn of_role(flight: &Flight, role: &str) -> Vec<Row> {
    let boards: Vec<&BoardCount> =
        flight.boards.iter().filter(|board| role_of(flight, board) == role).collect();
    let Some(stack) = boards.iter().map(|board| board.stack).max() else { return Vec::new() };
    let processor = boards.iter().map(|board| processor(flight, board)).fold(0.0, f64::max);
    vec![
        Row::lower(format!("{role}_stack"), u64::from(stack), "bytes"),
        Row::lower(format!("{role}_processor"), processor, "percent"),
    ]
}

fn role_of(flight: &Flight, board: &BoardCount) -> &'static str {
    if flight.observer.active_master() == Some(board.node) {
        "master"
    } else if is_master(board.node) {
        "standby"
    } else if flight.plan.boards.iter().any(|plan| plan.node == board.node && plan.is_minimal) {
        "minimal"
    } else {
        "slave"
    }
}

/// Share of the cycles since power-on in which a board was awake, in percent.
fn processor(flight: &Flight, board: &BoardCount) -> f64 {
    let plan = flight.plan.boards.iter().find(|plan| plan.node == board.node);
    let powered = flight.end.since(plan.map_or(Time::ZERO, |plan| plan.power_on));
    board.cycles_awake as f64 / (powered.as_secs_f64() * HCLK) * 100.0
}

fn sizes(context: &Context, profile: Profile) -> anyhow::Result<Vec<Row>> {
    let images = context.images(&FLOWN, profile)?;
    let minimal = ecss_can_cli::images::build_minimal(FLOWN.name(), profile.name(), LOG)?;
    let mut rows = Vec::new();
    for (role, image) in [("master", &images.master), ("slave", &images.slave), ("minimal", &minimal)] {
        let size = Facts::read(image)?.size;
        rows.push(Row::lower(format!("{role}_flash"), size.flash, "bytes"));
        rows.push(Row::lower(format!("{role}_ram"), size.ram, "bytes"));
    }
    Ok(rows)
}
