//! An error and a value that a slave reports while its bus fails: afterwards the active master knows both.

use std::fmt;

use can_wire::fault::Fault;
use can_wire::time::Time;
use ecss_can::emcy::{ActiveError, ErrorCode};
use ecss_can::node::MasterEvent;
use ecss_can::prelude::*;
use ecss_can::redundancy::{Strap, TwoBoards};
use host_worlds::log::NodeEvent;
use host_worlds::{Events, Handle, MockBoard, NEXT_TO_MASTER_M, NodeKey, World, idle};

/// The slave that reports.
const WHEEL: NodeId = NodeId::of::<3>();
/// A slave beside it, which acknowledges its frames where no master hears them.
const OTHER: NodeId = NodeId::of::<2>();
/// Cut that leaves the wheel alone.
const BEFORE_WHEEL_M: f64 = 5.0;
/// When the fault strikes: with a standby and selective access all are Operational after 1.2 s.
const STRIKE: Time = Time::from_ms(2_000);
/// How long a fault of a whole bus lasts.
const SHORT: Time = Time::from_ms(300);
/// From the report on, until the master knows: the search of a slave that it did not hear, the choice of the bus, the
/// boot-up process.
const BOUND: Time = Time::from_ms(3_000);

const ERROR: ErrorCode = ErrorCode::TEMPERATURE_DEVICE;
const SOURCE: u8 = 1;

/// What breaks.
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
}

/// What the wheel reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Report {
    /// An error that stays, and a new value.
    Error,
    /// An error that is gone 20 ms later.
    Passing,
    /// The end of an error that was there before, and a new value.
    End,
}

/// A flight.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// What breaks, at 2 s.
    pub what: Break,
    /// What is reported.
    pub report: Report,
    /// When: milliseconds after the break.
    pub after_ms: u64,
    /// The slaves have selective access.
    pub is_selective: bool,
    /// A second slave is there.
    pub has_other: bool,
    /// A standby is there.
    pub has_standby: bool,
}

impl fmt::Display for Flight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

/// All flights whose report comes `0, step, 2 * step ..= 200` ms after the break.
pub fn flights(step: usize) -> impl Iterator<Item = Flight> {
    use Break::{Dominant, Far, Master, Near, Recessive};
    let breaks = [Near, Far, Recessive, Dominant, Master].into_iter();
    breaks.flat_map(move |what| {
        [Report::Error, Report::Passing, Report::End].into_iter().flat_map(move |report| {
            let crews = [(false, false), (true, false), (true, true)].into_iter();
            crews.filter(move |(_, has_standby)| *has_standby || what != Master).flat_map(
                move |(has_other, has_standby)| {
                    [false, true].into_iter().flat_map(move |is_selective| {
                        (0..=200).step_by(step).map(move |after_ms| Flight {
                            what,
                            report,
                            after_ms,
                            is_selective,
                            has_other,
                            has_standby,
                        })
                    })
                },
            )
        })
    })
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
        PdoSet::new(&[], &[Tpdo::new(1, CobIdOf::node(0x280)).state().map(Wheel::TEMPERATURE)]);
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
        &[Rpdo::new(1, CobIdOf::fixed(0x280 + WHEEL.get() as u16)).map(Watcher::TEMPERATURE)],
        &[],
    );
}

type Board = Master<Watcher, TwoBoards>;

/// Flies it.
///
/// # Errors
/// What the master does not know, or heard too often.
pub fn fly(flight: Flight) -> Result<(), String> {
    let mut world = world(flight);
    world.run_until(Time::from_ms(1_500));
    if flight.report == Report::End {
        change(&world, 1, true);
    }
    world.run_until(STRIKE);
    if !world.all_operational() {
        return Err(format!("{flight}: it did not start"));
    }
    strike(&mut world, flight.what);
    let report = STRIKE + Time::from_ms(flight.after_ms);
    world.run_until(report);
    change(&world, 2, flight.report != Report::End);
    if flight.report == Report::Passing {
        world.run_for(Time::from_ms(20));
        change(&world, 3, false);
    }
    world.run_until(STRIKE + SHORT);
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::ClearShorts));
    world.run_until(report + BOUND);
    check(&world, flight)
}

fn check(world: &World, flight: Flight) -> Result<(), String> {
    let active = *world.active_masters().first().ok_or_else(|| format!("{flight}: no master"))?;
    let (errors, temperature) = world.node::<Board>(active).with(|master, _| {
        (master.active_errors().collect::<Vec<_>>(), master.objects().application.device.temperature)
    });
    let mut wrong = vec![];
    let error = ActiveError { node: WHEEL, code: ERROR, source: SOURCE };
    let (is_known, is_active) = (errors.contains(&error), flight.report == Report::Error);
    if is_known != is_active {
        wrong.push(format!("the master knows {errors:?}"));
    }
    let expected = if flight.report == Report::Passing { 3 } else { 2 };
    if temperature != expected {
        wrong.push(format!("the value is {temperature}"));
    }
    // Since the break: begin and end in turn, each twice at most.
    let mut heard = vec![];
    for (at, event) in world.log_of(active) {
        if let NodeEvent::Master(MasterEvent::Emergency { node: WHEEL, emergency, .. }) = event
            && at >= STRIKE
        {
            let is_begin = emergency.code == ERROR;
            if is_begin || emergency.ended() == Some((ERROR, SOURCE)) {
                heard.push(is_begin);
            }
        }
    }
    let count = |begins: bool| heard.iter().filter(|is_begin| **is_begin == begins).count();
    if count(true) > 2 || count(false) > 2 {
        wrong.push(format!("heard {heard:?}"));
    }
    if flight.report == Report::Passing && heard.first() == Some(&false) {
        wrong.push("an end alone".to_owned());
    }
    if !world.all_operational() {
        wrong.push("not all are Operational".to_owned());
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("{flight}: {}", wrong.join("; "))) }
}

/// The wheel reports.
fn change(world: &World, temperature: u16, is_hot: bool) {
    world.slave::<Wheel>(WHEEL).with(|wheel: &mut Slave<Wheel>, now| {
        if is_hot {
            wheel.raise(ERROR, [SOURCE, 0, 0, 0, 0]);
        } else {
            wheel.clear(ERROR, SOURCE);
        }
        wheel.change(now, |wheel| wheel.temperature = temperature);
    });
}

fn strike(world: &mut World, what: Break) {
    let bus = world.master_bus();
    match what {
        Break::Near => world.cut(bus, NEXT_TO_MASTER_M),
        Break::Far => world.cut(bus, BEFORE_WHEEL_M),
        Break::Recessive => world.strike(bus, Fault::Short { position_m: NEXT_TO_MASTER_M, level: true }),
        Break::Dominant => world.strike(bus, Fault::Short { position_m: NEXT_TO_MASTER_M, level: false }),
        Break::Master => {
            let active = world.active_masters();
            active.into_iter().for_each(|master| world.power_off(master));
        }
    }
}

fn world(flight: Flight) -> World {
    const SELECTIVE: &[NodeId] = &[OTHER, WHEEL];
    let profile = Profile {
        standby: flight.has_standby.then_some(Profile::PAIR),
        selective: if flight.is_selective { SELECTIVE } else { &[] },
        ..Profile::DEFAULT
    };
    let master = move |strap| move |_: MockBoard| Master::of_two(&profile, strap, Watcher::default(), None);
    let slave = move |board: MockBoard| {
        let slave = Slave::new(board.node_id, &profile, Wheel::default());
        slave.with_retained(board.retained).with_store(board.store)
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
