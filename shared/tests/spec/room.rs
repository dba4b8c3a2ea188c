//! Process data that is sent on events waits until the queues of the node have room.
//!
//! Verifies: ECSS 6.2a

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceNode as _, MasterRequest, Slave};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::types::NmtState;

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, node, span};
use crate::console::{self, SLAVES};
use crate::instrument::STANDARD;

/// More than an outbox has places for.
const MANY: usize = 40;

const TPDOS: [Tpdo; MANY] = {
    let mut all =
        [Pdo::<()>::new(CobIdOf::fixed(0x200)).map(Bank::SWITCHES.sub(1)).transmit(1).transmission(0); MANY];
    let mut nth = 0;
    while nth < MANY {
        let pdo = Pdo::<()>::new(CobIdOf::fixed(0x200 + nth as u16)).map(Bank::SWITCHES.sub(nth as u8 + 1));
        all[nth] = pdo.transmit(nth as u16 + 1).transmission(0);
        nth += 1;
    }
    all
};

#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
struct Bank {
    /// Switches
    #[object(0x6000, array, ro, pdo)]
    switches: [u8; MANY],
}

impl Device for Bank {
    type Pdos = PdoObjects<1, MANY>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &TPDOS);
}

/// Given 40 transmit PDOs of type 0 and an event for all but one, when a SYNC comes, then as many go out as the node has room
/// for, the others at the next SYNC, and each once.
///
/// Verifies: ECSS 6.9a, 6.9b
/// Notices: ECSS 6.9a: a synchronous PDO that had no room at a SYNC is lost.
#[test]
fn a_pdo_without_room_at_a_sync_goes_out_at_the_next_one() {
    const IDLE: usize = 17;
    let profile = Profile { autostart: true, ..STANDARD };
    let mut slave = Bench::new(Slave::builder(node(5), &profile, Bank { switches: [0; MANY] }).build());
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.touch(|slave, now| {
        slave.change(now, |bank| {
            (0..MANY).filter(|nth| *nth != IDLE).for_each(|nth| bank.switches[nth] = 1);
        });
    });
    slave.clear();
    let sent = |slave: &Bench<Slave<Bank>>| -> Vec<u16> {
        let ids = slave.sent.iter().map(|sent| sent.frame.id().raw());
        ids.filter(|id| (0x200..0x200 + MANY as u16).contains(id)).collect()
    };
    slave.receive(NOMINAL, 0x080, &[]);
    assert!(sent(&slave).len() < MANY - 1, "{} frames in one step", sent(&slave).len());
    (0..3).for_each(|_| slave.receive(NOMINAL, 0x080, &[]));
    let all: Vec<u16> = (0..MANY).filter(|nth| *nth != IDLE).map(|nth| 0x200 + nth as u16).collect();
    assert_eq!(sent(&slave), all);
}

/// Given a master whose frames wait for the announcement of a bus, as many as it has places for, when eight commands change,
/// then these follow after the announcement.
#[test]
fn commands_wait_while_the_master_holds_too_many_frames() {
    let mut master: Bench<Master> = Bench::new(console::master(&STANDARD));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    (2..10).for_each(|node| master.receive(NOMINAL, 0x700 + node, &[NmtState::Operational.byte()]));
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    let raw = frame(0x190, &[]);
    let held =
        (0..100).take_while(|_| master.touch(|master, now| master.send_frame(raw, now)).is_ok()).count();
    master.clear();
    master.touch(|master, now| master.change(now, |console| console.commands = [7; SLAVES]));
    let until = master.now + span(15);
    master.run_until(until);
    assert_eq!(master.frames(), []);
    master.transmitted(REDUNDANT, frame(0x701, &[5]));
    let until = master.now + span(25);
    master.run_until(until);
    let count = |is_it: &dyn Fn(u16) -> bool| {
        master.sent.iter().filter(|sent| is_it(sent.frame.id().raw()) && sent.bus == REDUNDANT).count()
    };
    assert_eq!(count(&|id| id == 0x190), held);
    assert_eq!(count(&|id| (0x302..0x302 + SLAVES as u16).contains(&id)), SLAVES);
}
