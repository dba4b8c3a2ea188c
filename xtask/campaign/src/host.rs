//! A run in a world of the host.

use std::panic::{AssertUnwindSafe, catch_unwind};

use can_wire::fault::{Effect, Fault as WireFault, Flip, Nodes, Place};
use can_wire::frame::WireFrame;
use ecss_can::types::{Bus, NodeId};
use host_worlds::world::Sent;
use host_worlds::{Time, World};

use crate::craft;
use crate::judge::Judge;
use crate::kind::Kind;
use crate::outcome::{Effects, Outcome};
use crate::script::{Fault, Script};

/// How often nodes are looked at.
const LOOK: Time = Time::from_ms(100);

/// Flies a script. A panic is a violation.
pub fn fly(script: &Script) -> Outcome {
    let flown = catch_unwind(AssertUnwindSafe(|| attempt(script)));
    flown.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Outcome { violations: vec![format!("panic: {text}")], ..Outcome::default() }
    })
}

/// Something that is done to the world.
#[derive(Clone, Copy)]
enum Act {
    Begin,
    /// A frame of a stranger.
    Send,
    End,
}

fn attempt(script: &Script) -> Outcome {
    let (mut world, notes) = craft::world(script.seed, script.slaves, script.selective);
    let mut judge = Judge::new(script, notes);
    let mut effects = Effects::new(script);
    let mut acts = acts(script);
    acts.sort_by_key(|(at, ..)| std::cmp::Reverse(*at));
    let end = Time::from_us(script.length);
    while world.now() < end {
        let act = acts.last().map_or(Time::NEVER, |(at, ..)| *at);
        let look = Time((world.now().0 / LOOK.0 + 1) * LOOK.0);
        let next = act.min(look).min(end);
        world.run_until(next);
        judge.look(&world);
        while let Some((_, act, index)) = acts.pop_if(|(at, ..)| *at <= next) {
            let fault = &script.faults[index];
            if matches!(act, Act::Begin) {
                effects.begin(index, &world);
            }
            perform(&mut world, fault, act, script.seed);
            if matches!(act, Act::End) {
                effects.end(index, &world);
            }
        }
    }
    let effective = effects.finish(&world, &judge.events);
    judge.finish(&world, effective)
}

/// All acts of a script; each fault begins before anything else of it.
fn acts(script: &Script) -> Vec<(Time, Act, usize)> {
    let mut acts = Vec::new();
    for (index, fault) in script.faults.iter().enumerate() {
        // Those that are sorted to the same instant are taken from the end.
        acts.extend(fault.end().map(|end| (Time::from_us(end), Act::End, index)));
        let frames = if fault.kind.is_foreign() { fault.times } else { 0 };
        let at = |nth: u32| Time::from_us(fault.at + fault.every * u64::from(nth));
        acts.extend((0..frames).rev().map(|nth| (at(nth), Act::Send, index)));
        acts.push((Time::from_us(fault.at), Act::Begin, index));
    }
    acts
}

fn perform(world: &mut World, fault: &Fault, act: Act, seed: u64) {
    let node = NodeId::new(fault.node);
    match (act, fault.kind, node) {
        (Act::Send, ..) => world.inject(fault.bus, foreign(fault)),
        (Act::Begin, Kind::ResetMaster | Kind::ResetSlave, Some(node)) if world.is_powered(node) => {
            world.reset(node)
        }
        (Act::Begin, Kind::PowerMaster | Kind::PowerSlave, Some(node)) => world.power_off(node),
        (Act::End, Kind::PowerMaster | Kind::PowerSlave, Some(node)) => world.power_on(node),
        _ => {
            let of_node = node.filter(|_| fault.kind != Kind::Stranger).map(|node| world.index(node));
            let [begin, end] = on_wire(fault, of_node, seed);
            let wanted = if matches!(act, Act::Begin) { begin } else { end };
            wanted.into_iter().for_each(|wanted| world.strike(fault.bus, wanted));
        }
    }
}

/// A frame of a stranger.
fn foreign(fault: &Fault) -> WireFrame {
    let id = 0x700 + u16::from(fault.node);
    match fault.kind {
        Kind::ForeignNmt => WireFrame::standard(0, &[fault.value as u8, fault.node]),
        Kind::ForeignLoad => WireFrame::standard(fault.value as u16 & 0x7FF, &[0x55; 8]),
        _ => WireFrame::standard(id, &[fault.value as u8]),
    }
}

/// What begins a fault of a wire, and what ends it.
fn on_wire(fault: &Fault, node: Option<usize>, seed: u64) -> [Option<WireFault>; 2] {
    let position_m = f64::from(fault.place);
    let nodes = node.map_or(Nodes::ALL, |node| Nodes::of(&[node]));
    let of = |fault: fn(usize) -> WireFault| node.map(fault);
    match fault.kind {
        Kind::Cut => [Some(WireFault::Cut { position_m }), Some(WireFault::Restore { position_m })],
        Kind::Short => [Some(WireFault::Short { position_m, level: true }), Some(WireFault::ClearShorts)],
        Kind::Dominant => [Some(WireFault::Short { position_m, level: false }), Some(WireFault::ClearShorts)],
        Kind::Disconnect => [of(WireFault::Disconnect), of(WireFault::Reconnect)],
        Kind::Noise => {
            let rate = 10_f64.powi(-(fault.value.clamp(3, 9) as i32));
            [Some(WireFault::BitErrors { rate, seed }), Some(WireFault::BitErrors { rate: 0.0, seed })]
        }
        Kind::Stuck => [of(WireFault::StuckDominant), of(WireFault::ReleaseDriver)],
        Kind::Babble => {
            let frame = WireFrame::standard(fault.value as u16 & 0x7FF, &[0x55; 8]);
            [node.map(|node| WireFault::Babble(node, frame)), of(WireFault::StopBabbling)]
        }
        Kind::Drift => {
            let ppb = i32::try_from(u64::from(fault.value) * 1_000).unwrap_or(i32::MAX);
            [node.map(|node| WireFault::Drift(node, ppb)), node.map(|node| WireFault::Drift(node, 0))]
        }
        Kind::Glitch => {
            let effect = [Effect::Invert, Effect::Dominant, Effect::Recessive][fault.value as usize % 3];
            let duration = Time::from_us(fault.lasts.unwrap_or(1).max(1));
            [Some(WireFault::Glitch { nodes, duration, effect }), None]
        }
        Kind::Flip => {
            let bit = fault.value as usize % 60;
            [Some(WireFault::Flip(Flip::new(Place::Bit(bit), nodes))), None]
        }
        _ => [None, None],
    }
}

/// Frames on a bus so far that were destroyed or that nobody acknowledged.
pub fn disturbance(world: &World, bus: Bus) -> u64 {
    let counters = world.counters(bus);
    counters.destroyed + counters.ack_errors
}

/// Frames of strangers, and of a node that babbles this COB-ID, that completed on a bus so far.
pub fn strange(world: &World, bus: Bus, babbled: Option<u16>) -> usize {
    let is_strange = |sent: &Sent| sent.node.is_none() || babbled.is_some() && sent.id() == babbled;
    world.frames(bus).iter().filter(|sent| is_strange(sent)).count()
}
