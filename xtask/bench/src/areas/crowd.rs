//! As many slaves as CANopen can number, in a world of the host: how fast it is on this computer.
//!
//! A master and 126 slaves with heartbeats of 400 ms and a SYNC each second, which all slaves answer at once. After 60 s of
//! virtual time all of them must be operational.

use std::time::Instant;

use anyhow::ensure;
use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::{Duration, NodeId};
use host_worlds::{World, idle};

use super::Area;
use crate::context::Context;
use crate::row::Row;

pub const AREA: Area =
    Area { name: "crowd", about: "126 slaves in a world of the host", needs: &[], steps: 1, measure };

/// Virtual time of the flight.
const SPAN: Time = Time::from_ms(60_000);

/// The bus has room for 126 of these.
const PROFILE: Profile = Profile {
    heartbeat: Duration::from_millis(400),
    consumer: Duration::from_millis(1_000),
    sync: Duration::from_millis(1_000),
    ..mission::STANDARD
};

fn measure(_: &Context, _: u64) -> anyhow::Result<Vec<Row>> {
    let mut builder = World::builder().master(|_| mission::master(&PROFILE, None), idle);
    for node in (2..=127).filter_map(NodeId::new) {
        let slave = move |_| mission::slave(node, &PROFILE, Vec::<u8>::new());
        builder = builder.slave(node, slave, idle);
    }
    let mut world = builder.seed(1).build();
    let start = Instant::now();
    world.run_until(SPAN);
    let ratio = SPAN.as_secs_f64() / start.elapsed().as_secs_f64();
    ensure!(world.all_operational(), "not all of 126 slaves are operational");
    Ok(vec![Row::higher("real_time", ratio, "times").noisy()])
}
