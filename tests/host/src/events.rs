//! An error and a value that a slave reports while its bus fails: afterwards the active master knows both.

use std::fmt;

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::emcy::{ActiveError, ErrorCode};
use ecss_can::node::MasterEvent;
use ecss_can::prelude::*;
use ecss_can::redundancy::{Strap, TwoBoards};
use ecss_can::runner::extend::WholeNode;
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::{Events, Handle, MockBoard, NEXT_TO_MASTER_M, NodeKey, World, idle};

/// The slave that reports.
pub(crate) const WHEEL: NodeId = NodeId::of::<3>();
/// Second slave, which acknowledges frames of the first one even if no master receives them.
pub(crate) const OTHER: NodeId = NodeId::of::<2>();
/// Position of a cut that isolates the wheel.
const BEFORE_WHEEL_M: f64 = 5.0;
/// Time of the fault. With a standby and selective access all nodes are Operational after 1.2 s.
pub(crate) const STRIKE: Time = Time::from_ms(1_500);
/// Duration of a fault of a whole bus.
const SHORT: Time = Time::from_ms(300);
/// Duration for which a jolted contact is open.
const JOLT: Time = Time::from_ms(40);
/// Longest time from the report until the master knows it. It covers the search of a slave that was not heard, the
/// choice of the bus and the boot-up process.
const BOUND: Time = Time::from_ms(2_500);
/// Longest time if the bus does not change: it has one period of the master's questions more.
const BOUND_OF_JOLT: Time = Time::from_ms(12_500);
/// Duration of a temporary error.
const PASSING: Time = Time::from_ms(20);

/// Error that the wheel reports while the bus fails.
pub(crate) const STAYS: ErrorCode = ErrorCode::TEMPERATURE_DEVICE;
/// Error that ends 20 ms later.
const PASSES: ErrorCode = ErrorCode::CURRENT_INSIDE;
/// Error that was active before, and ends at the same time.
const ENDS: ErrorCode = ErrorCode::VOLTAGE_INSIDE;
pub(crate) const SOURCE: u8 = 1;

/// Part that breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Break {
    /// The active bus, next to the master: the slaves still see each other.
    Near,
    /// The active bus, next to the wheel.
    Far,
    /// The active bus is recessive for 0.3 s, whatever is sent.
    Recessive,
    /// It is dominant for 0.3 s.
    Dominant,
    /// The active master loses its power.
    Master,
    /// The active bus, next to the master, for 40 ms between two of its frames.
    Jolt,
}

impl Break {
    /// Returns the time from a heartbeat of the master and its SYNC to the break.
    fn after_heartbeat(self) -> Time {
        if self == Break::Jolt { Time::from_ms(20) } else { Time::ZERO }
    }

    fn bound(self) -> Time {
        if self == Break::Jolt { BOUND_OF_JOLT } else { BOUND }
    }
}

/// A flight.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Part that breaks at 1.5 s.
    pub what: Break,
    /// Time of the wheel's report, milliseconds after the break.
    pub after_ms: u64,
    /// Whether the wheel has selective access.
    pub is_selective: bool,
    /// Whether there is a second slave.
    pub has_other: bool,
    /// Whether there is a standby.
    pub has_standby: bool,
}

impl fmt::Display for Flight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

/// Returns all flights with reports `0, 1, 2 ..= 200` ms after the break.
pub fn flights() -> Vec<Flight> {
    use Break::{Dominant, Far, Master, Near, Recessive};
    let mut all = Vec::new();
    for what in [Near, Far, Recessive, Dominant, Master] {
        for (has_other, has_standby) in [(false, false), (true, false), (true, true)] {
            for is_selective in [false, true] {
                if has_standby || what != Master {
                    let flight = |after_ms| Flight { what, after_ms, is_selective, has_other, has_standby };
                    all.extend((0..=200).map(flight));
                }
            }
        }
    }
    all
}

/// Returns flights in which a contact opens for a moment, and a slave acknowledges frames that the master does not
/// receive.
pub fn jolts() -> Vec<Flight> {
    let what = Break::Jolt;
    let flight =
        |after_ms, is_selective| Flight { what, after_ms, is_selective, has_other: true, has_standby: false };
    (0..=20)
        .step_by(4)
        .flat_map(|after_ms| [false, true].map(|is_selective| flight(after_ms, is_selective)))
        .collect()
}

/// A reaction wheel.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
struct Wheel {
    /// Temperature
    #[object(0x6000, ro, pdo)]
    temperature: u16,
}

impl Device for Wheel {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet =
        PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Wheel::TEMPERATURE).transmit(1).state()]);
}

/// The master's copy of what the wheel reports.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
struct Watcher {
    /// Temperature of the wheel
    #[object(0x6100, rw, pdo)]
    temperature: u16,
}

impl Device for Watcher {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::fixed(0x280 + WHEEL.get() as u16)).map(Watcher::TEMPERATURE).receive(1)],
        &[],
    );
}

type Board = Master<Watcher, TwoBoards>;

/// Runs the flight: two errors begin and one ends while the bus fails, and a value changes.
///
/// # Errors
/// When the master does not know a report, or received it too often.
pub fn fly(flight: Flight) -> Result<(), String> {
    let mut world = world(flight);
    world.run_until(STRIKE.since(Time::from_ms(200)));
    report(&world, 1, &[(ENDS, true)]);
    world.run_until(STRIKE);
    if !world.all_operational() {
        return Err(format!("{flight}: it did not start"));
    }
    let at = STRIKE + flight.what.after_heartbeat();
    world.run_until(at);
    strike(&mut world, flight.what);
    let at = at + Time::from_ms(flight.after_ms);
    world.run_until(at);
    // After a jolt no further message follows, so no register shows that one was lost.
    let end = (flight.what != Break::Jolt).then_some((ENDS, false));
    report(&world, 2, &[&[(STAYS, true), (PASSES, true)], end.as_slice()].concat());
    world.run_for(PASSING);
    report(&world, 3, &[(PASSES, false)]);
    if flight.what == Break::Jolt {
        let bus = world.master_bus();
        world.run_until(STRIKE + flight.what.after_heartbeat() + JOLT);
        world.heal(bus);
    }
    world.run_until(STRIKE + SHORT);
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::ClearShorts));
    world.run_until(at + flight.what.bound());
    let wrong = check(&world, flight.what);
    if wrong.is_empty() { Ok(()) } else { Err(format!("{flight}: {}", wrong.join("; "))) }
}

fn check(world: &World, what: Break) -> Vec<String> {
    let mut wrong = vec![];
    if !world.all_operational() {
        wrong.push("not all are Operational".to_owned());
    }
    let Some(active) = world.active_masters().first().copied() else { return vec!["no master".to_owned()] };
    let (errors, temperature) = known(world, active);
    let is_known = |code| errors.contains(&ActiveError { node: WHEEL, code, source: SOURCE });
    if [STAYS, PASSES, ENDS].map(is_known) != [true, false, what == Break::Jolt] {
        wrong.push(format!("the master knows {errors:?}"));
    }
    if temperature != 3 {
        wrong.push(format!("the value is {temperature}"));
    }
    for code in [STAYS, PASSES, ENDS] {
        let heard = heard(world, active, code);
        let count = |begins: bool| heard.iter().filter(|is_begin| **is_begin == begins).count();
        let is_alone = code == PASSES && heard.first() == Some(&false);
        if count(true) > 2 || count(false) > 2 || is_alone {
            wrong.push(format!("it heard of {:04X}h, begin or end: {heard:?}", code.get()));
        }
        for is_begin in [true, false] {
            let is_repeated = what != Break::Jolt;
            if is_repeated && was_acknowledged(world, code, is_begin) && !heard.contains(&is_begin) {
                let which = if is_begin { "beginning" } else { "end" };
                wrong.push(format!(
                    "it never heard the {which} of {:04X}h, which a node acknowledged",
                    code.get()
                ));
            }
        }
    }
    wrong
}

/// Returns the active errors and the temperature that a master knows.
pub(crate) fn known(world: &World, master: NodeKey) -> (Vec<ActiveError>, u16) {
    world.node::<Board>(master).with(|master: &mut Board, _| {
        (master.active_errors().collect(), master.objects().application.device.temperature)
    })
}

/// Returns the messages of an error that a master received since the break. `true` is the start of the error.
fn heard(world: &World, master: NodeKey, code: ErrorCode) -> Vec<bool> {
    let log = world.log_of(master).into_iter().filter(|(at, _)| *at >= STRIKE);
    let heard = log.filter_map(|(_, event)| match event {
        NodeEvent::Master(MasterEvent::Emergency { node: WHEEL, emergency, .. })
            if emergency.code == code =>
        {
            Some(true)
        }
        NodeEvent::Master(MasterEvent::Emergency { node: WHEEL, emergency, .. }) => {
            (emergency.ended() == Some((code, SOURCE))).then_some(false)
        }
        _ => None,
    });
    heard.collect()
}

/// Returns whether a node acknowledged the start or the end of an error since the break, on either bus.
fn was_acknowledged(world: &World, code: ErrorCode, is_begin: bool) -> bool {
    let [low, high] = code.get().to_le_bytes();
    let mut frames = Bus::ALL.into_iter().flat_map(|bus| world.frames(bus));
    frames.any(|sent| match sent.frame.payload() {
        _ if sent.id() != Some(CobId::emcy(WHEEL).raw()) || sent.end < STRIKE => false,
        [0, 0, _, a, b, ..] => !is_begin && [*a, *b] == [low, high],
        [a, b, ..] => is_begin && [*a, *b] == [low, high],
        _ => false,
    })
}

/// Lets the wheel report another temperature, and the start or end of errors.
pub(crate) fn report(world: &World, temperature: u16, errors: &[(ErrorCode, bool)]) {
    world.slave::<Wheel>(WHEEL).with(|wheel: &mut Slave<Wheel>, now| {
        for (code, begins) in errors {
            if *begins {
                wheel.raise(DeviceError::new(*code, SOURCE), [0; 4]);
            } else {
                wheel.clear(DeviceError::new(*code, SOURCE));
            }
        }
        wheel.change(now, |wheel| wheel.temperature = temperature);
    });
}

pub(crate) fn strike(world: &mut World, what: Break) {
    let active = world.active_masters().first().copied();
    let bus = active.map_or(Bus::Nominal, |master| world.status(master).active);
    match what {
        Break::Near | Break::Jolt => world.cut(bus, NEXT_TO_MASTER_M),
        Break::Far => world.cut(bus, BEFORE_WHEEL_M),
        Break::Recessive => world.strike(bus, Fault::Short { position_m: NEXT_TO_MASTER_M, level: true }),
        Break::Dominant => world.strike(bus, Fault::Short { position_m: NEXT_TO_MASTER_M, level: false }),
        Break::Master => {
            let active = world.active_masters();
            active.into_iter().for_each(|master| world.power_off(master));
        }
    }
}

pub(crate) fn world(flight: Flight) -> World {
    let profile = Profile {
        standby: flight.has_standby.then_some(Profile::PAIR),
        selective: if flight.is_selective { &[WHEEL] } else { &[] },
        ..Profile::DEFAULT
    };
    let master = move |strap| {
        move |_: MockBoard| Master::builder(&profile, Watcher::default()).one_of_two(strap).build()
    };
    let slave = move |board: MockBoard| {
        Slave::builder(board.node_id, &profile, Wheel::default()).hardware(board.hardware).build()
    };
    let mut world = World::builder().master(master(Strap::Prime), idle).slave(WHEEL, slave, wheel);
    if flight.has_other {
        world = world.slave(OTHER, slave, wheel);
    }
    if flight.has_standby {
        world = world.board(NodeKey::SECOND_MASTER, master(Strap::Second), idle);
    }
    world.build()
}

/// Resets the board when it is asked to.
async fn wheel(_: Handle<Slave<Wheel>>, mut events: Events<Slave<Wheel>>) {
    loop {
        if let SlaveEvent::ResetNode = events.next().await {
            events.reset();
        }
    }
}
