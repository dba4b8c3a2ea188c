//! Shared code of the tests of worlds.

use can_twin::wire::fault::{Effect, Fault, Nodes};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::{NEXT_TO_MASTER_M, Sent, World};
use mission::{Command, STANDARD};

pub use crate::mission_world::{MissionWorld, Reaction};

pub const MASTER: NodeId = NodeId::MASTER;
pub const TWO: NodeId = NodeId::of::<2>();
pub const THREE: NodeId = NodeId::of::<3>();
pub const FOUR: NodeId = NodeId::of::<4>();

/// The default profile, with selective access of slave 4.
pub const MIXED: Profile = Profile { selective: &[FOUR], ..STANDARD };

pub fn ms(ms: u64) -> Time {
    Time::from_ms(ms)
}

/// Returns a running system in which all nodes are operational on the nominal bus.
pub fn running(profile: Profile, slaves: u8) -> MissionWorld {
    let mut world = MissionWorld::new(profile, slaves);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Nominal);
    world
}

/// Returns the commands that a slave executed: time, and number of the turn in which the master sent it. The
/// application of the master sends a value, the number itself, in odd turns; it switches the LED on in turns 0, 4, 8
/// and so on, off in turns 2, 6, 10 and so on. Begins with the first value.
pub fn turns(world: &MissionWorld, node: NodeId) -> Vec<(Time, u32)> {
    let mut last = None;
    let executed = world.reactions(node).into_iter().filter_map(|(at, reaction)| {
        let turn = match (reaction, last) {
            (Reaction::Executed(Command::SetValue(value)), _) => value,
            (Reaction::Executed(Command::SetLed(on)), Some(last)) => {
                let rest = if on { 0 } else { 2 };
                (last + 1..).find(|turn| turn % 4 == rest)?
            }
            _ => return None,
        };
        last = Some(turn);
        Some((at, turn))
    });
    executed.collect()
}

/// Returns the number of commands that a slave executed after `from`.
pub fn executed_since(world: &MissionWorld, node: NodeId, from: Time) -> usize {
    let reactions = world.reactions(node).into_iter();
    reactions.filter(|(at, reaction)| *at > from && matches!(reaction, Reaction::Executed(_))).count()
}

pub fn cut_next_to_master(world: &mut World, bus: Bus) {
    world.cut(bus, NEXT_TO_MASTER_M);
}

/// Returns the frames with this identifier that ended in `(from, to]`, oldest first.
pub fn between(world: &World, bus: Bus, id: u16, from: Time, to: Time) -> Vec<Sent> {
    let frames = world.frames(bus).iter().map(|sent| Sent::clone(sent));
    frames.filter(|sent| sent.id() == Some(id) && sent.end > from && sent.end <= to).collect()
}

/// Returns the frames with this identifier that ended after `from`.
pub fn since(world: &World, bus: Bus, id: u16, from: Time) -> Vec<Sent> {
    between(world, bus, id, from, Time::NEVER)
}

/// Frames of the foreign node too.
pub fn standard(id: u16, data: &[u8]) -> WireFrame {
    WireFrame::standard(id, data)
}

/// Returns the times at which a slave reported this event after `from`.
pub fn told(world: &World, node: NodeId, from: Time, which: impl Fn(&SlaveEvent) -> bool) -> Vec<Time> {
    let log = world.log_of(node).into_iter();
    log.filter(|(at, what)| *at >= from && matches!(what, NodeEvent::Slave(event) if which(event)))
        .map(|(at, _)| at)
        .collect()
}

/// Returns the only time at which a slave reported this event after `from`.
pub fn told_once(world: &World, node: NodeId, from: Time, which: impl Fn(&SlaveEvent) -> bool) -> Time {
    let times = told(world, node, from, which);
    assert_eq!(times.len(), 1, "slave {} told it at {times:?}", node.get());
    times[0]
}

/// Returns the events of the master after `from`.
pub fn master_told(world: &World, from: Time) -> Vec<MasterEvent> {
    let log = world.log_of(MASTER).into_iter().filter(|(at, _)| *at >= from);
    log.filter_map(|(_, what)| match what {
        NodeEvent::Master(event) => Some(event),
        _ => None,
    })
    .collect()
}

pub fn switches(world: &World, from: Time) -> usize {
    master_told(world, from).iter().filter(|event| matches!(event, MasterEvent::BusSwitched { .. })).count()
}

pub fn entered(state: NmtState) -> impl Fn(&SlaveEvent) -> bool {
    move |event| *event == SlaveEvent::State(state)
}

pub fn changed_bus(bus: Bus, cause: BusCause) -> impl Fn(&SlaveEvent) -> bool {
    move |event| *event == SlaveEvent::ActiveBus { bus, cause }
}

/// Returns the times between the ends of consecutive frames, microseconds.
pub fn periods_us(frames: &[Sent]) -> Vec<u64> {
    frames.windows(2).map(|pair| pair[1].end.since(pair[0].end).as_us()).collect()
}

/// Makes slave 2 deaf to its own dominant bits on the nominal bus from just before its next heartbeat on. Each bit is a
/// transmission error, until it is bus-off. Returns the start of the fault.
pub fn deafen_two(world: &mut World) -> Time {
    world.run_for(ms(20));
    let last = since(world, Bus::Nominal, 0x702, Time::ZERO).last().expect("it has a heartbeat").start;
    world.run_until(last + ms(99));
    let nodes = Nodes::of(&[world.index(TWO)]);
    world.strike(Bus::Nominal, Fault::Glitch { nodes, duration: ms(5), effect: Effect::Recessive });
    world.now()
}
