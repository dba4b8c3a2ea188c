//! A master and minimal slaves (ECSS 9), one of them without heartbeat.

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalSlave, Payload};
use ecss_can::node::{MasterEvent, MasterRequest, Refusal};
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Bus, Instant, NmtState, NodeId, Scet};

use crate::bench::{Bench, Master, NOMINAL, frame, ms, node, span};
use crate::console;
use crate::device::fixture::Memory;
use crate::instrument::STANDARD;
use crate::master_device::{ask, powered, read, write};

const HEARD: u8 = 5;
const SILENT: u8 = 6;
const FOREIGN_NODE: u8 = 7;

const MIXED: Profile = Profile {
    minimal: &[
        MinimalNode { node: NodeId::of::<HEARD>(), has_heartbeat: true },
        MinimalNode { node: NodeId::of::<SILENT>(), has_heartbeat: false },
    ],
    ..STANDARD
};

/// The heartbeat of the master was acknowledged.
fn announced() -> Bench<Master> {
    let mut master = Bench::new(console::master(&MIXED));
    master.run_until(ms(10));
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    master.clear();
    master
}

fn send(master: &mut Bench<Master>, raw: u8, number: usize, data: &[u8]) -> Result<(), Refusal> {
    master.touch(|master, now| master.send_to_minimal(node(raw), number, data, now))
}

/// Returns what a command asks back, under its own number.
#[derive(Default)]
struct Echo {
    commands: Vec<(usize, Vec<u8>)>,
}

impl MinimalDevice for Echo {
    const PDOS: MinimalPdos = MinimalPdos::DEFAULT;

    fn on_pdo(&mut self, number: usize, data: &[u8], _: Instant) -> Option<(usize, Payload)> {
        self.commands.push((number, data.to_vec()));
        (data.first() == Some(&0xA5)).then(|| (number, Payload::from_slice(data).unwrap()))
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        unreachable!("no PDO follows SYNC")
    }
}

/// Commands and requests of any length to a slave that was never heard: it takes each, and answers what asks for it.
///
/// Verifies: ECSS 9.4.1a, 9.4.2a, 9.4.2c, 9.4.1c, 9.4.3b.1
/// Notices: ECSS 9.4.1a: the master pads commands to 8 bytes.
/// Notices: ECSS 9.4.2a: a command of 8 bytes loses its last one.
/// Notices: ECSS 9.4.2c: the master refuses the fourth RPDO.
/// Notices: ECSS 9.4.1c: a slave answers a command that asks for nothing.
#[test]
fn master_sends_commands_and_requests_by_each_of_four_pdos() {
    let mut master = announced();
    let mut slave = Bench::new(MinimalSlave::builder(node(SILENT), &MIXED, Echo::default()).build());
    slave.run_until(ms(1_000));
    assert_eq!(slave.frames(), [], "the profile says that it has no heartbeat");
    for (number, id) in [0x206, 0x306, 0x406, 0x506].into_iter().enumerate() {
        for data in [&[][..], &[1, 2, 3], &[0xA5, 2, 3, 4, 5, 6, 7, 8]] {
            master.clear();
            slave.clear();
            send(&mut master, SILENT, number, data).unwrap();
            assert_eq!(master.frames(), [(NOMINAL, frame(id, data))]);
            slave.receive(NOMINAL, id, data);
            assert_eq!(slave.node.device().commands.last(), Some(&(number, data.to_vec())));
            let answer = (NOMINAL, frame(0x186 + 0x100 * number as u16, data));
            assert_eq!(slave.frames(), if data.len() == 8 { vec![answer] } else { vec![] });
        }
    }
}

/// Verifies: ECSS 9.4.2a, 9.4.2c
/// Notices: ECSS 9.4.2a: a command of more than 8 bytes is cut off and sent.
#[test]
fn commands_to_a_slave_that_takes_none_are_refused() {
    let mut master = announced();
    assert_eq!(send(&mut master, HEARD, 0, &[1]), Err(Refusal::NotOperational), "not heard yet");
    assert_eq!(send(&mut master, FOREIGN_NODE, 0, &[1]), Err(Refusal::NotOperational), "no minimal one");
    assert_eq!(send(&mut master, SILENT, 4, &[1]), Err(Refusal::NotValid), "there are four");
    assert_eq!(send(&mut master, SILENT, 0, &[0; 9]), Err(Refusal::NotValid), "8 bytes at most");
    assert_eq!(master.frames(), []);
    assert_eq!(master.node.status(ms(10)).counters[NOMINAL].refused, 4);
    master.receive(NOMINAL, 0x705, &[0x05]);
    master.clear();
    assert_eq!(send(&mut master, HEARD, 3, &[1]), Ok(()));
    assert_eq!(master.frames(), [(NOMINAL, frame(0x505, &[1]))]);
}

/// Given two minimal slaves, when the application sends by all four PDOs to both at once, then eight frames go out in that order. To a
/// slave that fell silent none goes out until it is heard again; the other one gets its commands all the time.
///
/// Verifies: ECSS 9.4.2c, 9.4.2a
/// Notices: ECSS 9.4.2c: a slave without a heartbeat gets commands by RPDO 1 alone.
#[test]
fn all_four_pdos_to_two_slaves_are_sent_at_once_and_in_order() {
    const IDS: [[u16; 2]; 4] = [[0x205, 0x206], [0x305, 0x306], [0x405, 0x406], [0x505, 0x506]];
    let send_all = |master: &mut Bench<Master>, expected: Result<(), Refusal>| {
        master.clear();
        master.touch(|master, now| {
            for number in 0..4 {
                assert_eq!(master.send_to_minimal(node(HEARD), number, &[number as u8], now), expected);
                assert_eq!(master.send_to_minimal(node(SILENT), number, &[number as u8], now), Ok(()));
            }
        });
        master.frames().iter().map(|(_, frame)| frame.id().raw()).collect::<Vec<_>>()
    };
    let mut master = announced();
    master.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(send_all(&mut master, Ok(())), IDS.concat());
    // Its consumer time is 250 ms.
    master.run_until(ms(270));
    assert_eq!(send_all(&mut master, Err(Refusal::NotOperational)), IDS.map(|[_, silent]| silent));
    master.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(send_all(&mut master, Ok(())), IDS.concat());
}

/// Given two minimal slaves and a foreign node that are heard together, then the foreign node alone is asked by SDO, and none is started.
#[test]
fn minimal_slaves_are_not_asked_who_they_are() {
    let mut master = announced();
    for id in [0x705, 0x706, 0x707] {
        master.receive(NOMINAL, id, &[0x05]);
    }
    master.run_until(ms(250));
    let asked: Vec<u16> = master.frames().into_iter().map(|(_, frame)| frame.id().raw()).collect();
    assert!(asked.contains(&0x607), "{asked:03X?}");
    assert!(!asked.contains(&0x605) && !asked.contains(&0x606) && !asked.contains(&0), "{asked:03X?}");
    assert_eq!(master.node.slave_state(node(HEARD)), Some(NmtState::Operational));
}

/// Given a minimal slave that reports 7Fh, 04h or 00h, as it must not, then the master sends it no NMT command. It starts a full slave
/// that reports 7Fh at the same time.
///
/// Verifies: ECSS 9.4.6.1a, 8.3.3f
/// Notices: ECSS 9.4.6.1a: the master starts a minimal slave that reports 7Fh.
#[test]
fn minimal_slave_in_any_state_gets_no_nmt_command() {
    let mut master = announced();
    for (nth, state) in (1..).zip([0x7F, 0x04, 0x00, 0x7F]) {
        master.run_until(ms(100 * nth));
        for id in [0x705, 0x706] {
            master.receive(NOMINAL, id, &[state]);
        }
    }
    master.run_until(ms(450));
    assert_eq!(master.node.slave_state(node(HEARD)), Some(NmtState::PreOperational));
    assert_eq!(master.times(NOMINAL, 0x000), []);
    master.receive(NOMINAL, 0x707, &[0x7F]);
    master.run_until(ms(460));
    let commands = master.frames().into_iter().filter(|(_, frame)| frame.id().raw() == 0);
    assert_eq!(commands.collect::<Vec<_>>(), [(NOMINAL, frame(0, &[1, FOREIGN_NODE]))]);
}

/// For a minute: neither lost nor unheard, and the master stays where it is.
#[test]
fn slave_without_heartbeat_is_never_missed() {
    let mut master = announced();
    for beat in 1..600 {
        master.run_until(ms(100 * beat + 50));
        master.transmitted(NOMINAL, frame(0x701, &[0x05]));
        // Of a slave that counts.
        master.receive(NOMINAL, 0x702, &[0x05]);
        if beat == 1 {
            master.receive(NOMINAL, 0x582, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
        }
    }
    let missed = master.events.iter().filter(|event| {
        matches!(
            event,
            MasterEvent::SlaveLost { .. }
                | MasterEvent::SlaveUnheard { .. }
                | MasterEvent::BusSwitched { .. }
        )
    });
    assert_eq!(missed.count(), 0);
    assert!(master.node.may_command(node(SILENT)) && !master.node.may_command(node(HEARD)));
}

/// The master has the SYNC of Tables 9-7 to 9-10 in its dictionary, with the producer bit of CiA 301 in 1005h, and sends it in the period
/// that stands there. The synchronous window is zero: no node has one.
///
/// Verifies: ECSS 9.4.7.3b, 9.4.7.3b.1, 9.4.7.3d, 9.4.7.3a, 9.4.7.3b.2
/// Notices: ECSS 9.4.7.3b: SYNC is sent in twice the period of 1006h.
/// Notices: ECSS 9.4.7.3b.1: the period is in 1007h, and 1006h is zero.
/// Notices: ECSS 9.4.7.3a: 1005h of the master lacks the producer bit.
#[test]
fn master_requests_data_by_sync_in_the_period_of_its_dictionary() {
    let mut master = powered(&MIXED);
    assert_eq!(read(&mut master, 0x1005, 0), 0x4000_0080);
    assert_eq!(read(&mut master, 0x1006, 0), 100_000, "microseconds");
    assert_eq!(read(&mut master, 0x1007, 0), 0);
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    master.clear();
    master.run_until(ms(1_050));
    let syncs = master.times(NOMINAL, 0x080);
    assert!(syncs.len() >= 9, "{syncs:?}");
    assert!(syncs.windows(2).all(|pair| pair[1] - pair[0] == 100), "{syncs:?}");
    assert!(
        master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x080).all(|sent| sent.frame.dlc() == 0)
    );
}

/// Given a time stamp object (100h) and a master whose time is set, then its controllers do not admit it, it changes nothing, and the
/// master sends its time by 181h alone.
///
/// Verifies: ECSS 9.4.7.1b, 7.2.2b, 7.2.3f
/// Notices: ECSS 9.4.7.1b: the filters of the master admit 100h.
/// Notices: ECSS 7.2.3f: the time is sent by the time object of CiA 301 as well.
#[test]
fn master_neither_takes_nor_sends_time_stamps() {
    let mut master = announced();
    master.request(MasterRequest::SetTime(Scet::new(1_000, 0).unwrap()));
    master.clear();
    for bus in Bus::ALL {
        assert!(!master.admits(bus, 0x100));
        master.receive(bus, 0x100, &[0, 0, 0, 0, 0x10, 0x27]);
        assert_eq!((master.frames(), master.events.len()), (vec![], 0));
    }
    master.run_until(ms(10_000));
    let of = |id| master.sent.iter().filter(move |sent| sent.frame.id().raw() == id);
    assert!(of(0x181).count() >= 8);
    assert_eq!(of(0x100).count(), 0);
    let last = of(0x181).next_back().expect("a time");
    let time = Scet::decode(last.frame.data()).expect("7 bytes");
    assert_eq!(u64::from(time.coarse()), 1_000 + (last.at.as_micros() - 10_000) / 1_000_000);
}

/// Given a master that sends SYNC, when 1006h is written, then SYNC has that period, and is not sent with zero. Any other number of
/// 32 bits is taken, but those below 100 us. A reset of its communication brings back the period of the profile, and 1005h says that
/// the master still produces SYNC.
///
/// Verifies: ECSS 9.4.7.3a, 9.4.7.3b, 9.4.7.3b.1, 9.4.7.3b.2, 6.9d
/// Notices: ECSS 9.4.7.3a: after a reset of the communication 1005h of the master is 80h.
/// Notices: ECSS 9.4.7.3b: a written 1006h counts from the next start.
/// Notices: ECSS 9.4.7.3b: with zero in 1006h SYNC goes on.
/// Notices: ECSS 9.4.7.3b.1: after a reset of the communication 1006h is zero.
/// Notices: ECSS 9.4.7.3b.2: 1006h takes 65,535 us at most.
/// Notices: ECSS 9.4.7.3b.2: SYNC has the low 24 bits of 1006h.
/// Notices: ECSS 9.4.7.3b: after a reset of the communication SYNC keeps a period that 1006h does not show.
/// Notices: ECSS 9.4.7.3b.1: after a reset of the communication SYNC keeps a period that 1006h does not show.
/// Notices: ECSS 6.9d: SYNC ends when 1006h is written.
#[test]
fn sync_has_the_period_that_stands_in_the_dictionary() {
    let mut master = powered(&MIXED);
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    let gaps = |master: &mut Bench<Master>, period: u32| {
        assert_eq!(write(master, 0x1006, 0, period, 4), Ok(()));
        assert_eq!(read(master, 0x1006, 0), period);
        master.clear();
        master.run_until(master.now + span(500));
        master.times(NOMINAL, 0x080).windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>()
    };
    assert_eq!(gaps(&mut master, 50_000), [50; 9]);
    assert_eq!(gaps(&mut master, u32::MAX), []);
    // 2^24 us more than 50 ms.
    assert_eq!(gaps(&mut master, 16_827_216), []);
    assert_eq!(gaps(&mut master, 200_000), [200]);
    assert_eq!(gaps(&mut master, 0), []);
    assert_eq!(master.times(NOMINAL, 0x080), []);
    let reset = NmtMessage { command: Command::ResetCommunication, target: Target::Node(NodeId::MASTER) };
    master.request(MasterRequest::Nmt(reset));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master.run_until(master.now + span(1));
    assert_eq!(read(&mut master, 0x1005, 0), 0x4000_0080);
    assert_eq!(read(&mut master, 0x1006, 0), 100_000);
    master.clear();
    master.run_until(master.now + span(500));
    let syncs = master.times(NOMINAL, 0x080);
    assert!(syncs.len() >= 4 && syncs.windows(2).all(|pair| pair[1] - pair[0] == 100), "{syncs:?}");
}

/// Given a master that stored a 1006h of 50 ms, when it is powered on again, then its dictionary has 50 ms and SYNC that period.
///
/// Verifies: ECSS 9.4.7.3b.1, 9.4.7.3b
/// Notices: ECSS 9.4.7.3b.1: after power-on SYNC has the period of the profile, and 1006h the stored one.
#[test]
fn sync_has_the_stored_period_after_power_on() {
    let memory = Memory::default();
    let powered = || {
        let mut master = Bench::new(console::master_with(&MIXED, Box::leak(Box::new(memory.clone()))));
        master.run_until(ms(1));
        master
    };
    let mut master = powered();
    assert_eq!(write(&mut master, 0x1006, 0, 50_000, 4), Ok(()));
    assert_eq!(write(&mut master, 0x1010, 1, u32::from_le_bytes(*b"save"), 4), Ok(()));
    let mut master = powered();
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    assert_eq!(read(&mut master, 0x1006, 0), 50_000);
    master.clear();
    master.run_until(ms(301));
    let syncs = master.times(NOMINAL, 0x080);
    assert!(syncs.len() >= 5 && syncs.windows(2).all(|pair| pair[1] - pair[0] == 50), "{syncs:?}");
}

/// Given a master, then 1006h is an UNSIGNED32 as in Table 9-9: read in four bytes, and written in no other number of bytes. Periods from
/// 100 us to the greatest number are taken, and the one that was refused changes nothing.
///
/// Verifies: ECSS 9.4.7.3b.2, 9.4.7.3b
/// Notices: ECSS 9.4.7.3b.2: 1006h takes 31 bits.
#[test]
fn communication_cycle_period_is_an_unsigned32_of_table_9_9() {
    let mut master = powered(&MIXED);
    assert_eq!(
        ask(&mut master, [0x40, 0x06, 0x10, 0, 0, 0, 0, 0]),
        [0x43, 0x06, 0x10, 0, 0xA0, 0x86, 0x01, 0]
    );
    assert_eq!(
        ask(&mut master, [0x40, 0x06, 0x10, 1, 0, 0, 0, 0]),
        [0x80, 0x06, 0x10, 1, 0x11, 0, 0x09, 0x06]
    );
    for len in 1..=3 {
        assert_eq!(write(&mut master, 0x1006, 0, 200, len), Err(0x0607_0013), "{len} bytes");
    }
    for period in [1, 50, 99] {
        assert_eq!(write(&mut master, 0x1006, 0, period, 4), Err(0x0609_0032), "{period} us");
    }
    assert_eq!(read(&mut master, 0x1006, 0), 100_000);
    for period in [100, 0xFFFF, 0x1_0000, u32::MAX, 0] {
        assert_eq!(write(&mut master, 0x1006, 0, period, 4), Ok(()), "{period} us");
        assert_eq!(read(&mut master, 0x1006, 0), period);
    }
}
