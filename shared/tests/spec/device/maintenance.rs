//! Maintenance mode: a Node-ID is stored there, and nowhere else.

use ecss_can::link::port::Filter;
use ecss_can::node::Node;
use ecss_can::node::extend::BusCommand;
use ecss_can::profile::Profile;
use ecss_can::store::ParameterStore;
use ecss_can::store::identity::MAINTENANCE;
use ecss_can::types::{Bus, CobId, NmtState};

use super::fixture::{Memory, done, powered, powered_with, read, refused, write};
use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, node};
use crate::instrument::{self, STANDARD};
use crate::slave::TestSlave;

/// Stores this Node-ID.
fn storing(id: u8) -> [u8; 4] {
    [id, !id, 0x49, 0x44]
}

/// Of a mission whose slaves start by themselves, on the redundant bus.
fn maintained(memory: Option<&Memory>) -> Bench<TestSlave> {
    let profile = Profile { autostart: true, bdefault: Bus::Redundant, ..STANDARD };
    let slave = instrument::builder(MAINTENANCE, &profile, vec![]);
    Bench::new(match memory {
        Some(memory) => slave.store(Box::leak(Box::new(memory.clone()))).build(),
        None => slave.build(),
    })
}

/// The answer to an SDO request; nothing else may be sent.
fn ask(slave: &mut Bench<TestSlave>, request: [u8; 8]) -> [u8; 8] {
    slave.sent.clear();
    slave.receive(NOMINAL, 0x67F, &request);
    let [sent] = slave.sent[..] else { panic!("one answer to {request:02X?}: {:?}", slave.sent) };
    assert_eq!((sent.bus, sent.frame.id().raw()), (NOMINAL, 0x5FF));
    sent.frame.padded()
}

fn store(slave: &mut Bench<TestSlave>, [a, b, c, d]: [u8; 4]) -> [u8; 8] {
    ask(slave, [0x23, 0x46, 0x20, 1, a, b, c, d])
}

/// Verifies: ECSS 6.10f, 6.10g
/// Notices: ECSS 6.10f: a board in maintenance mode sends a boot-up message.
#[test]
fn a_node_in_maintenance_mode_answers_sdo_and_is_silent_else() {
    let mut slave = maintained(None);
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join)], "one bus");
    let request = Filter::exact(CobId::new(0x67F).unwrap());
    assert!(slave.node.filters().iter().all(|filter| *filter == request), "nothing else is received");
    // What reaches it all the same is not for it.
    for (id, data) in [
        (0x701, &[5][..]),
        (0x000, &[0x01, 0]),
        (0x000, &[0x01, 127]),
        (0x000, &[0x82, 127]),
        (0x000, &[0x81, 127]),
        (0x080, &[]),
        (0x27F, &[0; 8]),
        (0x77F, &[5]),
    ] {
        slave.receive(NOMINAL, id, data);
        slave.receive(REDUNDANT, id, data);
    }
    slave.run_until(ms(60_000));
    assert_eq!(slave.frames(), []);
    let of_a_bus = |(_, command): &&(Bus, BusCommand)| {
        matches!(command, BusCommand::Join | BusCommand::Leave | BusCommand::Listen | BusCommand::Abandon)
    };
    assert_eq!(slave.controls.iter().filter(of_a_bus).count(), 1, "it stays on its bus");
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
    // Device type.
    assert_eq!(ask(&mut slave, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0])[..4], [0x43, 0x00, 0x10, 0]);
    // Errors are not reported: passive, then active.
    let health = |state| ecss_can::link::port::Health { state, ..Default::default() };
    slave.sent.clear();
    slave.health(NOMINAL, health(ecss_can::link::port::ErrorState::Passive));
    slave.run_until(ms(120_000));
    assert_eq!(slave.frames(), []);
}

/// Verifies: ECSS 6.10g, 6.10j, 6.10k, 9.1a
/// Notices: ECSS 9.1a: a slave stores the Node-ID of the master.
/// Notices: ECSS 6.10j: Node-IDs above those of the straps are refused.
/// Notices: ECSS 6.10k: a Node-ID is stored although a bit of its complement is wrong.
#[test]
fn a_node_id_is_stored_in_maintenance_mode() {
    let memory = Memory::default();
    let mut slave = maintained(Some(&memory));
    assert_eq!(ask(&mut slave, [0x40, 0x46, 0x20, 1, 0, 0, 0, 0]), [0x43, 0x46, 0x20, 1, 0, 0, 0, 0]);
    for id in [2, 15, 126] {
        assert_eq!(store(&mut slave, storing(id)), done(0x2046, 1));
        assert_eq!(memory.clone().node_id(), Some(node(id)));
        assert_eq!(ask(&mut slave, [0x40, 0x46, 0x20, 1, 0, 0, 0, 0])[4..], [id, 0, 0, 0]);
    }
    // It takes effect with the next reset only.
    assert_eq!(ask(&mut slave, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0])[..4], [0x43, 0x00, 0x10, 0]);
    // The master's, that of maintenance mode, and what is none.
    for id in [1, 127, 128, 255] {
        assert_eq!(store(&mut slave, storing(id)), refused(0x2046, 1, 0x0609_0030));
    }
    // Every flipped bit of what is written.
    for bit in 0..32 {
        let value = u32::from_le_bytes(storing(9)) ^ 1 << bit;
        assert_eq!(store(&mut slave, value.to_le_bytes()), refused(0x2046, 1, 0x0800_0020), "bit {bit}");
    }
    // One byte, and the count of flipped bits.
    assert_eq!(ask(&mut slave, [0x2F, 0x46, 0x20, 1, 9, 0, 0, 0])[..4], [0x80, 0x46, 0x20, 1]);
    assert_eq!(ask(&mut slave, [0x2B, 0x46, 0x20, 2, 0, 0, 0, 0]), refused(0x2046, 2, 0x0601_0002));
    assert_eq!(memory.clone().node_id(), Some(node(126)));
    assert_eq!(store(&mut slave, storing(0)), done(0x2046, 1));
    assert_eq!(memory.clone().node_id(), None);
    assert_eq!(ask(&mut slave, [0x40, 0x46, 0x20, 1, 0, 0, 0, 0])[4..], [0; 4]);
}

/// Given a store without room that holds Node-ID 9, or no store, then no Node-ID is stored or deleted. 9 is there as before.
///
/// Verifies: ECSS 6.10g, 6.10j
/// Notices: ECSS 6.10j: 2046h shows a Node-ID that the store did not take.
#[test]
fn a_store_without_room_or_none_refuses_a_node_id() {
    let memory = Memory::full_with(node(9));
    let mut slave = maintained(Some(&memory));
    for id in [3, 0] {
        assert_eq!(store(&mut slave, storing(id)), refused(0x2046, 1, 0x0800_0022));
        assert_eq!(memory.clone().node_id(), Some(node(9)));
        assert_eq!(ask(&mut slave, [0x40, 0x46, 0x20, 1, 0, 0, 0, 0])[4..], [9, 0, 0, 0]);
    }
    assert_eq!(store(&mut maintained(None), storing(3)), refused(0x2046, 1, 0x0800_0022));
}

/// Parameters belong to a Node-ID that this node does not have now.
#[test]
fn no_parameters_are_saved_in_maintenance_mode() {
    let memory = Memory::default();
    let mut slave = maintained(Some(&memory));
    assert_eq!(ask(&mut slave, [0x40, 0x10, 0x10, 1, 0, 0, 0, 0])[4..], [0; 4]);
    assert_eq!(
        ask(&mut slave, [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']),
        refused(0x1010, 1, 0x0800_0020)
    );
    assert_eq!(memory.stored_len(), 0);
}

/// Verifies: ECSS 6.10g, 6.10e
/// Notices: ECSS 6.10g: a write of a Node-ID outside of maintenance is answered as done.
/// Notices: ECSS 6.10e: an SDO client changes the Node-ID of a node in service.
#[test]
fn no_node_id_is_stored_outside_of_maintenance_mode() {
    let mut memory = Memory::default();
    memory.store_node_id(Some(node(5))).unwrap();
    let mut slave = powered_with(&memory);
    assert_eq!(read(&mut slave, 0x2046, 1), [5, 0, 0, 0], "it shows what is stored");
    for state in [0x01, 0x80] {
        slave.receive(NOMINAL, 0x000, &[state, 5]);
        for id in [0, 5, 7] {
            assert_eq!(write(&mut slave, 0x2046, 1, &storing(id)), refused(0x2046, 1, 0x0800_0022));
        }
    }
    // Nor by the application, nor where there is no store.
    assert_eq!(slave.write((0x2046, 1), &storing(7)).map_err(|code| code.code()), Err(0x0800_0022));
    assert_eq!(write(&mut powered(), 0x2046, 1, &storing(7)), refused(0x2046, 1, 0x0800_0022));
    assert_eq!(memory.node_id(), Some(node(5)));
    assert_eq!(read(&mut slave, 0x2046, 1), [5, 0, 0, 0]);
}
