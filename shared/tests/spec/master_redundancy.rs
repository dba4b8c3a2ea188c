//! Redundancy parameters of a master (2000h) over SDO. Profile `standard`: Ttoggle 2, Ntoggle 255, dwell 10 s.
//!
//! Verifies: ECSS 8.3.1b, 8.3.1c

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, Instant, NodeId};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, ms};
use crate::console;
use crate::device::fixture::Memory;
use crate::instrument::STANDARD;
use crate::master_device::{powered, read, write};

/// Changes of the bus because no slave is heard, with their times in seconds, until the master gives up, and its bus
/// then. The bench is at 1 ms.
fn search(master: &mut Bench<Master>, limit: Instant) -> (Vec<u64>, Option<Bus>) {
    let mut changes = vec![];
    while master.now < limit {
        master.clear();
        let next = master.now + ecss_can::types::Duration::from_millis(100);
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
    master.node.objects().spacecraft.redundancy.parameters.ctoggle
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
        let mut master = Bench::new(console::master(&STANDARD, Some(store)));
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
