//! Redundancy parameters of a master (2000h) over SDO. Profile `standard`: Ttoggle 2, Ntoggle 255, dwell 10 s.
//!
//! Verifies: ECSS 8.3.1b, 8.3.1c

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, Instant, NodeId};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, ms, node, span};
use crate::console;
use crate::device::fixture::Memory;
use crate::instrument::STANDARD;
use crate::master_device::{ask, powered, read, write};

/// Changes of the bus because no slave is heard, with their times in seconds, until the master gives up, and its bus
/// then. The bench is at 1 ms.
fn search(master: &mut Bench<Master>, limit: Instant) -> (Vec<u64>, Option<Bus>) {
    let mut changes = vec![];
    while master.now < limit {
        master.clear();
        let next = master.now + span(100);
        master.run_until(next);
        for event in &master.events {
            match event {
                MasterEvent::BusSwitched { cause, .. } => {
                    assert_eq!(*cause, SwitchCause::Unheard);
                    changes.push(master.now.as_micros() / 1_000_000);
                }
                MasterEvent::GaveUp { bus } => return (changes, Some(*bus)),
                _ => {}
            }
        }
    }
    (changes, None)
}

fn ctoggle(master: &Bench<Master>) -> u8 {
    master.node.objects().extension.redundancy.parameters.ctoggle
}

/// Given Ntoggle 1, When no slave is heard for 11 dwells, Then the master changes the bus once, shows it in Ctoggle, and
/// stays.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.1b: Ctoggle of a master does not show a change of the bus.
/// Notices: ECSS 8.3.1c: a written Ntoggle of a master is not obeyed.
#[test]
fn a_master_changes_the_bus_as_often_as_its_ntoggle_says() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x2000, 3, 1, 1), Ok(()));
    assert_eq!(read(&mut master, 0x2000, 3), 1);
    assert_eq!(search(&mut master, ms(110_000)), (vec![10], Some(REDUNDANT)));
    assert_eq!(search(&mut master, ms(110_000)), (vec![], None));
    assert_eq!(ctoggle(&master), 1);
}

/// Given Ntoggle 50, When 47 is written to Ctoggle, Then three changes are left.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.1c: a written Ctoggle of a master is not obeyed.
#[test]
fn a_master_continues_with_a_written_ctoggle() {
    let mut master = powered(&STANDARD);
    assert_eq!((read(&mut master, 0x2000, 3), read(&mut master, 0x2000, 4)), (255, 0));
    assert_eq!(write(&mut master, 0x2000, 3, 50, 1), Ok(()));
    assert_eq!(write(&mut master, 0x2000, 4, 47, 1), Ok(()));
    assert_eq!(read(&mut master, 0x2000, 4), 47);
    assert_eq!(search(&mut master, ms(110_000)), (vec![10, 20, 30], Some(REDUNDANT)));
    assert_eq!(ctoggle(&master), 50);
}

/// Given Ttoggle 30, Then a dwell is two toggling times of 7.5 s and two heartbeat periods: 15.2 s.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.1c: a written Ttoggle of a master is not obeyed.
#[test]
fn a_master_dwells_for_its_written_ttoggle() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x2000, 2, 30, 1), Ok(()));
    assert_eq!(read(&mut master, 0x2000, 2), 30);
    assert_eq!(search(&mut master, ms(50_000)), (vec![15, 30, 45], None));
}

/// Given Ttoggle, Ntoggle and Ctoggle that a client wrote, when the communication of the master is reset, then 2000h has them still: it
/// is no object of the communication profile. The search makes the three changes that are left, after dwells of 15.2 s.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.1b: Reset communication of a master brings back the Ntoggle of its profile.
#[test]
fn reset_communication_keeps_the_toggles_of_a_master() {
    let mut master = powered(&STANDARD);
    for (sub, value) in [(2, 30), (3, 50), (4, 47)] {
        assert_eq!(write(&mut master, 0x2000, sub, value, 1), Ok(()));
    }
    let target = Target::Node(NodeId::MASTER);
    master.request(MasterRequest::Nmt(NmtMessage { command: Command::ResetCommunication, target }));
    assert_eq!([2, 3, 4].map(|sub| read(&mut master, 0x2000, sub)), [30, 50, 47]);
    assert_eq!(search(&mut master, ms(110_000)), (vec![15, 30, 45], Some(REDUNDANT)));
    assert_eq!(ctoggle(&master), 50);
}

/// Verifies: ECSS 8.3.2a
/// Notices: ECSS 8.3.2a: a stored Bdefault of the master does not make the bus active.
#[test]
fn a_master_starts_on_its_stored_bdefault() {
    let memory = Memory::default();
    let powered = || {
        let store: &'static mut (dyn ecss_can::store::ParameterStore + Send) =
            Box::leak(Box::new(memory.clone()));
        let mut master = Bench::new(console::master_with(&STANDARD, store));
        master.run_until(ms(1));
        master
    };
    let mut master = powered();
    assert_eq!(master.node.status(master.now).active, NOMINAL);
    assert_eq!(write(&mut master, 0x2000, 1, 2, 1), Err(0x0609_0030));
    assert_eq!(write(&mut master, 0x2000, 1, 1, 1), Ok(()));
    assert_eq!(read(&mut master, 0x2000, 1), 1);
    assert_eq!(write(&mut master, 0x1010, 1, u32::from_le_bytes(*b"save"), 4), Ok(()));
    assert_eq!(master.node.status(master.now).active, NOMINAL, "it holds from power-on");
    let master = powered();
    assert_eq!(master.node.status(master.now).active, REDUNDANT);
}

/// Given a master with eight slaves to monitor, then a client reads the objects of Table 8-2 with the sizes of that table: one entry of 1016h
/// for each slave in four bytes, of which the upper two have the Node-ID, 1017h in two, the parts of 2000h in one.
///
/// Notices: ECSS 8.3.1b: 1016h of a master lacks its last slave.
/// Notices: ECSS 8.3.1b: an answer with one byte says that it has four.
#[test]
fn master_has_the_objects_of_table_8_2_in_their_sizes() {
    let mut master = powered(&STANDARD);
    let slaves = (1..=8).map(|sub| [0x43, 0x16, 0x10, sub, 0xFA, 0, sub + 1, 0]);
    let others = [
        [0x4F, 0x16, 0x10, 0, 8, 0, 0, 0],
        [0x4B, 0x17, 0x10, 0, 100, 0, 0, 0],
        [0x4F, 0, 0x20, 1, 0, 0, 0, 0],
        [0x4F, 0, 0x20, 2, 2, 0, 0, 0],
        [0x4F, 0, 0x20, 3, 255, 0, 0, 0],
        [0x4F, 0, 0x20, 4, 0, 0, 0, 0],
    ];
    for answer in slaves.chain(others) {
        let [_, low, high, sub, ..] = answer;
        assert_eq!(ask(&mut master, [0x40, low, high, sub, 0, 0, 0, 0]), answer);
    }
    for (index, sub, len) in [(0x1016, 1, 4), (0x1017, 0, 2), (0x2000, 1, 1), (0x2000, 2, 1), (0x2000, 3, 1)]
    {
        for other in (1..=4).filter(|other| *other != len) {
            let code = if other > len { 0x0607_0012 } else { 0x0607_0013 };
            assert_eq!(
                write(&mut master, index, sub, 0, other),
                Err(code),
                "{index:04X}h sub {sub}, {other}"
            );
        }
    }
}

/// Given a master that hears slave 2, when a client writes another consumer time of that slave to 1016h, then the master misses the slave
/// that time after its last heartbeat: later or earlier than the 250 ms of before.
///
/// Verifies: ECSS 6.5.2a
/// Notices: ECSS 8.3.1c: a time that a client writes to 1016h while the slave is heard has no effect.
#[test]
fn consumer_time_written_in_flight_is_when_slave_is_lost() {
    for times in [&[600_u16][..], &[150], &[600, 250], &[150, 250]] {
        let mut master = powered(&STANDARD);
        for beat in 0..20 {
            master.run_until(ms(10 + 50 * beat));
            master.receive(NOMINAL, 0x702, &[5]);
            if beat == 0 {
                // The answer to the question for 1000h: it is one that counts.
                master.receive(NOMINAL, 0x582, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
            }
            if beat >= 10
                && let Some(time) = times.get(usize::try_from(beat).unwrap() - 10)
            {
                assert_eq!(write(&mut master, 0x1016, 1, 2 << 16 | u32::from(*time), 4), Ok(()));
            }
        }
        master.clear();
        let (time, last) = (u64::from(*times.last().unwrap()), master.now);
        let lost = MasterEvent::SlaveLost { node: node(2) };
        master.run_until(last + span(time - 1));
        assert!(!master.events.contains(&lost), "{times:?}");
        master.run_until(last + span(time));
        assert!(master.events.contains(&lost), "{times:?}");
    }
}
