//! An active master yields at each step of its boot-up process, and takes over again.
//!
//! Two master boards; slave 2 is assigned and configured, slave 3 is asked for its device type alone.
//!
//! Verifies: ECSS 8.1a

use std::sync::mpsc::channel;
use std::thread;

use can_twin::wire::time::Time;
use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::node::{Communication, Identity, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::redundancy::TwoBoards;
use ecss_can::types::{Address, Bus, NmtState};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::world::{Sent, World};
use mission::TWO_MASTERS;

use crate::mission_world::MissionMaster;
use crate::support::*;

const PRIME: NodeKey = NodeKey::MASTER;
const SECOND: NodeKey = NodeKey::SECOND_MASTER;

/// Longer than 28 bytes, so it is transferred in blocks.
const TEXT: &[u8] = b"more text than one frame holds";

/// Real time in which one flight ends, of which it needs less than a hundredth. An endless loop in a node takes no
/// virtual time, so a test of the world would not detect it.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(60);

/// Transfers of all kinds: expedited, in segments, in blocks.
const CONFIGURED: Profile = Profile {
    slaves: &[AssignedSlave {
        node: TWO,
        mandatory: true,
        expected: Expected { device_type: 0, identity: [0, 0x5015, 1 << 16, 0], stamp: [100, 200] },
    }],
    settings: &[
        Setting { node: TWO, at: Address::new(0x1029, 1), value: &[2] },
        Setting { node: TWO, at: Address::new(0x6300, 0), value: TEXT },
    ],
    ..TWO_MASTERS
};

/// A profile with an additional object that the slave does not have: it aborts two transfers, twice, and is not
/// started.
const REFUSED: Profile = Profile {
    settings: &[
        CONFIGURED.settings[0],
        CONFIGURED.settings[1],
        Setting { node: TWO, at: Address::new(0x5FFF, 0), value: &[0] },
    ],
    ..CONFIGURED
};

#[derive(Clone, Copy, Debug)]
struct Flight {
    is_refused: bool,
    /// Time at which prime yields.
    yields: Time,
    /// Time at which a foreign node stops slave 2, which is then heard and does not answer.
    stopped: Option<Time>,
}

fn flying(is_refused: bool, stopped: Option<Time>, until: Time) -> MissionWorld {
    let profile = if is_refused { REFUSED } else { CONFIGURED };
    let mut world = MissionWorld::pair(profile, 2, |world| world.seed(7));
    if let Some(stopped) = stopped {
        world.run_until(stopped);
        world.inject(Bus::Nominal, standard(0x000, &[0x02, TWO.get()]));
    }
    world.run_until(until);
    world
}

/// Prime yields, the second board takes over and yields, slave 2 loses its configuration, and prime takes over again.
/// Returns a description of the failure.
fn fly(flight: Flight) -> Result<(), String> {
    let mut world = flying(flight.is_refused, flight.stopped, flight.yields);
    world.request(MasterRequest::StandBy);
    world.run_for(ms(1_000));
    world.reset(TWO);
    // If prime yields right behind its heartbeat, it may itself be the first to miss one.
    if world.active_masters() == [SECOND] {
        world.request_to(SECOND, MasterRequest::StandBy);
    }
    world.run_for(ms(3_000));
    if world.active_masters() != [PRIME] {
        return Err(format!("active: {:?}", world.active_masters()));
    }
    let reader = world.node::<MissionMaster<TwoBoards>>(PRIME);
    let task = world.spawn(PRIME, async move {
        reader.sdo(THREE).read(Communication::IDENTITY.field(Identity::PRODUCT)).await
    });
    world.run_for(ms(100));
    let read = task.take().map(|(_, read)| read);
    let (behaviour, text) = world.slave(TWO, |slave| {
        let objects = slave.objects();
        (objects.communication.nmt.error_behaviour[0], objects.application.store.as_bytes().to_vec())
    });
    let is_configured = (behaviour, &text[..]) == (2, TEXT);
    if read != Some(Ok(0x5015)) || !is_configured || world.all_operational() == flight.is_refused {
        return Err(format!("reads {read:?}, {behaviour}, {text:?}, slave 2: {:?}", world.state(TWO)));
    }
    Ok(())
}

/// Flies all, each within [`PATIENCE`].
fn all_end_well(flights: Vec<Flight>) {
    let (sender, outcomes) = channel();
    let list = flights.clone();
    thread::spawn(move || list.into_iter().try_for_each(|flight| sender.send(fly(flight))));
    for flight in flights {
        let outcome = outcomes.recv_timeout(PATIENCE);
        assert_eq!(outcome, Ok(Ok(())), "{flight:?}");
    }
}

/// SDO frames between the master and slaves 2 and 3 that ended before then.
fn sdo(world: &World, until: Time) -> impl Iterator<Item = &Sent> {
    let is_sdo = |id: u16| [0x582, 0x583, 0x602, 0x603].contains(&id);
    let frames = world.frames(Bus::Nominal).iter().map(|sent| &**sent);
    frames.filter(move |sent| sent.end < until && sent.id().is_some_and(is_sdo))
}

/// Returns times before, in, at the end of and after a frame.
fn around(frame: &Sent) -> [Time; 5] {
    let middle = Time::from_us((frame.start.as_us() + frame.end.as_us()) / 2);
    [Time::from_us(frame.start.as_us() - 20), frame.start, middle, frame.end, frame.end + Time::from_us(5)]
}

/// Returns the instant at which slave 2 was started, in a flight without a fault.
fn started(world: &World) -> Time {
    told(world, TWO, Time::ZERO, entered(NmtState::Operational))[0]
}

/// Given two masters, when prime yields before, in or behind any frame of its boot-up process, then it can take over again, boots
/// its slaves and serves its application.
#[test]
fn master_that_yields_at_any_step_of_boot_up_boots_again() {
    let world = flying(false, None, ms(3_000));
    let frames: Vec<_> = sdo(&world, started(&world) + ms(20)).collect();
    for command in [0x40, 0x43, 0x60, 0xA2, 0xD5] {
        assert!(frames.iter().any(|sent| sent.frame.data[0] == command), "no frame {command:02X}h");
    }
    let yields = frames.into_iter().flat_map(around);
    all_end_well(yields.map(|yields| Flight { is_refused: false, yields, stopped: None }).collect());
}

/// Given a slave without an object that the master wants to set, when prime yields around the end of the transfers that the slave
/// aborts, then it can take over again and serves its application.
#[test]
fn master_that_yields_at_any_abort_of_boot_up_boots_again() {
    let world = flying(true, None, ms(3_000));
    let aborts: Vec<_> = sdo(&world, ms(3_000)).filter(|sent| sent.frame.data[0] == 0x80).collect();
    assert!(aborts.len() >= 4, "{} aborts", aborts.len());
    let yields = aborts.into_iter().flat_map(around);
    all_end_well(yields.map(|yields| Flight { is_refused: true, yields, stopped: None }).collect());
}

/// Given a slave that is stopped in each of its transfers in turn, when prime yields around any time-out and its abort, then it can
/// take over again, boots its slaves and serves its application.
#[test]
fn master_that_yields_at_any_time_out_of_boot_up_boots_again() {
    let world = flying(false, None, ms(3_000));
    let answers = sdo(&world, started(&world)).filter(|sent| sent.id() == Some(0x582));
    let mut flights = vec![];
    for stopped in answers.map(|sent| sent.end) {
        let world = flying(false, Some(stopped), ms(3_000));
        let aborts =
            sdo(&world, ms(3_000)).filter(|sent| sent.id() == Some(0x602) && sent.frame.data[0] == 0x80);
        let yields = aborts.flat_map(around);
        flights.extend(yields.map(|yields| Flight { is_refused: false, yields, stopped: Some(stopped) }));
    }
    assert!(flights.len() > 50, "{} flights", flights.len());
    all_end_well(flights);
}
