//! Parameters that outlive a reset, and the configuration that was verified.
//!
//! Verifies: ECSS 6.8a

use crate::instrument::{self, STANDARD};
use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::node::DeviceNode;
use ecss_can::profile::Profile;
use ecss_can::store::{Loss, ParameterStore};
use ecss_can::types::NmtState;

use super::fixture::{
    Memory, NO_INHIBIT, done, errors, operational, payloads, powered, powered_with, read, refused, write,
    write_all,
};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, span};

/// Verifies: ECSS 8.3.1c, 8.3.2a
/// Notices: ECSS 8.3.2a: a stored Bdefault does not make the bus active at power-on.
#[test]
fn stored_values_survive_a_reset_and_defaults_return_on_command() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write(&mut slave, 0x1017, 0, &[50, 0]);
    write(&mut slave, 0x2000, 1, &[1]);
    write(&mut slave, 0x6210, 0, &[7, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    // Written after the save: gone with the power.
    write(&mut slave, 0x2000, 3, &[99]);
    let mut slave = powered_with(&memory);
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT, "Bdefault was stored");
    let objects = slave.node.objects();
    assert_eq!(
        (objects.communication.heartbeat.time, objects.extension.redundancy.parameters.ntoggle),
        (50, 50)
    );
    assert_eq!(objects.application.value, 7);
    slave.clear();
    slave.run_until(ms(100));
    assert_eq!(slave.times(REDUNDANT, 0x705), [50, 100]);
    // Defaults of the communication profile only, from the next reset on.
    slave.receive(REDUNDANT, 0x605, &[0x23, 0x11, 0x10, 2, b'l', b'o', b'a', b'd']);
    slave.finish_save();
    assert!(slave.frames().contains(&(REDUNDANT, frame(0x585, &done(0x1011, 2)))));
    assert_eq!(slave.node.objects().communication.heartbeat.time, 50);
    let slave = powered_with(&memory);
    assert_eq!(slave.node.objects().communication.heartbeat.time, 100);
    assert_eq!(slave.node.objects().application.value, 7);
}

/// Given a slave with another COB-ID for its emergencies, when it is reset, then emergencies have the stored one after power-on and after
/// reset communication. Without a store they have the default.
///
/// Verifies: ECSS 6.10a, 6.10c
/// Notices: ECSS 6.10a: after a reset the emergencies have the COB-ID that they had before.
#[test]
fn emergencies_have_their_stored_cob_id_after_each_reset() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write_all(
        &mut slave,
        &[(0x1014, 0, &[0x85, 0, 0, 0x80]), (0x1014, 0, &[0x86, 0, 0, 0]), (0x1010, 2, b"save")],
    );
    let mut without = powered();
    for (slave, id) in [(&mut slave, 0x86), (&mut without, 0x85)] {
        // Not saved: forgotten by the reset.
        write_all(slave, &[(0x1014, 0, &[id, 0, 0, 0x80]), (0x1014, 0, &[0x87, 0, 0, 0])]);
        slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    }
    for (mut slave, id) in [(powered_with(&memory), 0x086), (slave, 0x086), (without, 0x085)] {
        slave.clear();
        slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::TEMPERATURE, 0), [0; 4]));
        let sent = [0x085, 0x086, 0x087].map(|id| payloads(&slave, id).len());
        assert_eq!(sent, [0x085, 0x086, 0x087].map(|other| usize::from(other == id)), "{id:03X}h");
    }
}

/// Verifies: ECSS 6.5.1a.5
/// Notices: ECSS 6.5.1a.5: Reset communication brings the defaults in place of the stored values.
#[test]
fn reset_communication_restores_stored_communication_profile() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write(&mut slave, 0x1017, 0, &[50, 0]);
    assert_eq!(write(&mut slave, 0x1010, 2, b"save"), done(0x1010, 2));
    write(&mut slave, 0x1017, 0, &[20, 0]);
    write(&mut slave, 0x6210, 0, &[9, 0, 0, 0]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    let objects = slave.node.objects();
    assert_eq!((objects.communication.heartbeat.time, objects.application.value), (50, 9));
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
}

/// EMCY 6300h with the cause in its second byte, at each start until parameters are saved; the set before is applied.
///
/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a.1: a store without a loss is reported as an error.
#[test]
fn store_loss_is_reported_with_its_cause_until_the_next_save() {
    for (loss, cause) in [(Loss::Interrupted, 1), (Loss::Damaged, 2)] {
        let memory = Memory::default();
        let mut slave = powered_with(&memory);
        write(&mut slave, 0x6210, 0, &[7, 0, 0, 0]);
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
        *memory.loss.lock().unwrap() = Some(loss);
        for _ in 0..2 {
            slave = powered_with(&memory);
            slave.run_until(ms(100));
            assert_eq!(payloads(&slave, 0x085)[0][..5], [0x00, 0x63, 0x01, 0, cause]);
            assert_eq!(slave.node.objects().application.value, 7);
        }
        slave.clear();
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
        slave.run_until(ms(200));
        assert_eq!(errors(&mut slave).0, 0, "it is over");
        let mut slave = powered_with(&memory);
        slave.run_until(ms(100));
        assert!(payloads(&slave, 0x085).is_empty());
    }
}

/// Given a client that saves and restores in a loop, then ten are obeyed, and from then on one every six minutes.
#[test]
fn saves_in_a_loop_are_limited() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    let minutes = |count: u64| ms(count * 60_000);
    for _ in 0..5 {
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
        assert_eq!(write(&mut slave, 0x1011, 3, b"load"), done(0x1011, 3));
    }
    write(&mut slave, 0x6210, 0, &[9, 0, 0, 0]);
    let stored = memory.stored_len();
    let refusals = [(0x1010, 1, b"save"), (0x1010, 2, b"save"), (0x1011, 1, b"load")];
    for (index, sub, signature) in refusals {
        assert_eq!(write(&mut slave, index, sub, signature), refused(index, sub, 0x0800_0022));
    }
    assert_eq!(memory.stored_len(), stored);
    assert_eq!(powered_with(&memory).node.objects().application.value, 0, "nothing was saved");
    // Six minutes after the first one.
    slave.run_until(minutes(6) - span(1));
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), refused(0x1010, 1, 0x0800_0022));
    slave.run_until(minutes(6));
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), refused(0x1010, 1, 0x0800_0022));
    assert_eq!(powered_with(&memory).node.objects().application.value, 9);
    // An hour of patience earns ten saves, not more.
    slave.run_until(minutes(120));
    for _ in 0..10 {
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    }
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), refused(0x1010, 1, 0x0800_0022));
}

/// What slave 6 has saved.
fn stored_by_another() -> Memory {
    let memory = Memory::default();
    let mut other = Bench::new(
        instrument::builder(node(6), &STANDARD, vec![]).store(Box::leak(Box::new(memory.clone()))).build(),
    );
    other.receive(NOMINAL, 0x606, &[0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
    other.finish_save();
    assert_ne!(memory.stored_len(), 0);
    memory
}

/// Verifies: ECSS 6.4a.1
#[test]
fn that_a_stored_set_is_no_error_any_more_is_told_at_once() {
    // Defaults that come back with the next reset are no error either.
    for (index, signature) in [(0x1010, b"save"), (0x1011, b"load")] {
        let mut slave = powered_with(&stored_by_another());
        write_all(&mut slave, &[NO_INHIBIT, (index, 1, signature)]);
        assert_eq!(payloads(&slave, 0x085), [[0, 0, 0, 0x00, 0x63, 0, 0, 0]]);
        assert_eq!(errors(&mut slave), (0, 1));
    }
}

/// Verifies: ECSS 6.4a.1
#[test]
fn stored_set_that_does_not_apply_is_reported_until_next_save() {
    let memory = stored_by_another();
    // The board is in another place now.
    let mut slave = powered_with(&memory);
    let told: Vec<_> = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x085).collect();
    assert_eq!(told.len(), 1);
    assert_eq!(told[0].frame.data()[..2], [0x00, 0x63]);
    assert_eq!(read(&mut slave, 0x1003, 1), [0x00, 0x63, 0, 0]);
    assert_ne!(read(&mut slave, 0x1001, 0)[0] & 1, 0, "a generic error");
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    assert_eq!(read(&mut slave, 0x1001, 0), [0; 4]);
    // The set is its own from now on.
    let mut again = powered_with(&memory);
    assert_eq!(read(&mut again, 0x1001, 0), [0; 4]);
}

#[test]
fn a_full_store_says_so_and_keeps_what_it_has() {
    let memory = Memory::full();
    let mut slave = powered_with(&memory);
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), refused(0x1010, 1, 0x0800_0022));
    assert_eq!(memory.stored_len(), 0);
    assert_eq!(read(&mut slave, 0x1010, 1), [1, 0, 0, 0]);
}

#[test]
fn a_device_says_whether_it_stores_parameters() {
    let memory = Memory::default();
    for (mut slave, can_store) in [(powered(), 0), (powered_with(&memory), 1)] {
        // Reset communication has no part in it.
        for _ in 0..2 {
            for index in [0x1010, 0x1011] {
                for sub in 1..=4 {
                    assert_eq!(read(&mut slave, index, sub), [can_store, 0, 0, 0], "{index:04X}h:{sub}");
                }
            }
            slave.receive(NOMINAL, 0x000, &[0x82, 5]);
        }
        for (index, signature) in [(0x1010, b"save"), (0x1011, b"load")] {
            for sub in 1..=4 {
                let expected =
                    if can_store == 1 { done(index, sub) } else { refused(index, sub, 0x0800_0020) };
                assert_eq!(write(&mut slave, index, sub, signature), expected);
            }
        }
    }
}

/// Verifies: ECSS 6.5.4a, 11.1a, 6.5.1a.5, 8.1b
/// Notices: ECSS 11.1a: autostart that was stored does not lead to Operational after "reset communication".
/// Notices: ECSS 8.1b: a slave takes a 1F80h that makes it an NMT master.
#[test]
fn startup_is_chosen_by_1f80h_from_the_next_reset_on_and_stored() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    assert_eq!(read(&mut slave, 0x1F80, 0), [4, 0, 0, 0]);
    // An NMT master it cannot be, nor start others.
    for value in [1, 8, 5, 12, 0xFFFF_FFFB_u32] {
        let answer = write(&mut slave, 0x1F80, 0, &value.to_le_bytes());
        assert_eq!(answer, refused(0x1F80, 0, 0x0609_0030), "{value}");
    }
    assert_eq!(read(&mut slave, 0x1F80, 0), [4, 0, 0, 0]);
    write_all(&mut slave, &[(0x1F80, 0, &[0; 4]), (0x1010, 2, b"save")]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
    // Not stored: forgotten by the reset.
    write_all(&mut slave, &[(0x1F80, 0, &[4, 0, 0, 0])]);
    let mut again = powered_with(&memory);
    for slave in [&mut slave, &mut again] {
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[0x82, 5]);
        assert_eq!(slave.sent[0].frame, frame(0x705, &[0]));
        assert_eq!(slave.node.status(slave.now).state, NmtState::Operational);
        slave.run_until(slave.now + span(100));
        assert_eq!(payloads(slave, 0x705), [[0], [5]], "boot-up, heartbeat");
        assert_eq!(read(slave, 0x1F80, 0), [0; 4]);
    }
    // From power-on, too.
    assert_eq!(powered_with(&memory).node.status(ms(0)).state, NmtState::Operational);
    // And back.
    write_all(&mut again, &[(0x1F80, 0, &[4, 0, 0, 0]), (0x1010, 2, b"save")]);
    assert_eq!(powered_with(&memory).node.status(ms(0)).state, NmtState::PreOperational);
}

/// Given a profile with autostart, then a slave is Operational after power-on and after "reset communication", without a command.
///
/// Verifies: ECSS 11.1a, 6.5.4a
/// Notices: ECSS 11.1a: after "reset communication" a slave with autostart stays in Pre-operational.
/// Notices: ECSS 6.5.4a: a slave with autostart waits in Pre-operational for a command.
#[test]
fn startup_is_as_its_profile_has_it_until_then() {
    let profile = Profile { autostart: true, ..STANDARD };
    let mut slave = Bench::new(instrument::slave(node(5), &profile, vec![]));
    assert_eq!(read(&mut slave, 0x1F80, 0), [0; 4]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::Operational);
    write_all(&mut slave, &[(0x1F80, 0, &[4, 0, 0, 0])]);
    // Without a store the profile's comes back with the reset.
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(read(&mut slave, 0x1F80, 0), [0; 4]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::Operational);
}

#[test]
fn parameter_write_forgets_the_verified_configuration() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    let stamp = |slave: &Bench<_>| {
        let slave: &crate::slave::TestSlave = &slave.node;
        slave.objects().communication.configuration
    };
    let table: [(u16, u8, &[u8], bool); 15] = [
        (0x1003, 0, &[0], false),
        (0x1005, 0, &[0x80, 0, 0, 0], true),
        (0x1010, 1, b"save", false),
        (0x1011, 1, b"load", false),
        (0x1016, 2, &[250, 0, 7, 0], true),
        (0x1017, 0, &[100, 0], true),
        (0x1029, 1, &[1], true),
        (0x1F80, 0, &[0; 4], true),
        (0x1802, 2, &[255], true),
        (0x2000, 2, &[3], true),
        (0x2010, 1, &[1, 0, 0, 0], false),
        (0x2010, 2, &[1, 0, 0], false),
        (0x2030, 0, &[1], false),
        (0x6210, 0, &[9, 0, 0, 0], true),
        (0x1020, 1, &[7, 0, 0, 0], false),
    ];
    for (index, sub, value, forgets) in table {
        write_all(&mut slave, &[(0x1020, 1, &[7, 0, 0, 0]), (0x1020, 2, &[8, 0, 0, 0])]);
        assert_eq!(stamp(&slave), [7, 8]);
        write_all(&mut slave, &[(index, sub, value)]);
        let expected = if forgets { [0, 0] } else { [7, 8] };
        assert_eq!(stamp(&slave), expected, "{index:04X}h:{sub} {value:02X?}");
    }
    // What was refused has changed nothing.
    write(&mut slave, 0x1017, 0, &[1]);
    assert_eq!(stamp(&slave), [7, 8]);
}

/// A PDO brings values, no parameters.
///
#[test]
fn a_configuration_stays_verified_whatever_pdos_bring() {
    let mut slave = operational();
    write_all(&mut slave, &[(0x1020, 1, &[7, 0, 0, 0]), (0x1020, 2, &[8, 0, 0, 0])]);
    slave.receive(NOMINAL, 0x305, &[1; 8]);
    assert_eq!(slave.node.objects().application.telecommand.code, 0x0101);
    assert_eq!(slave.node.objects().communication.configuration, [7, 8]);
}

/// A set of node 5 with these parameters of four bytes, as no client could have saved it.
fn stored(parameters: &[(u16, u8, u32)]) -> Memory {
    let mut memory = Memory::default();
    memory.append(b"EP\x02\x05").unwrap();
    for (index, sub, value) in parameters {
        memory.append(&[&index.to_le_bytes()[..], &[*sub, 1, 4, 0], &value.to_le_bytes()].concat()).unwrap();
    }
    memory.commit().unwrap();
    memory
}

/// COB-IDs of SYNC and of emergencies, and the emergency that a set was not taken as it is.
fn cob_ids(memory: &Memory) -> (u32, u32, Vec<Vec<u8>>) {
    let mut slave = powered_with(memory);
    slave.run_until(ms(10));
    let communication = &slave.node.objects().communication;
    let told = slave
        .sent
        .iter()
        .filter(|sent| sent.frame.data().get(..2) == Some(&[0x00, 0x63]))
        .map(|sent| sent.frame.data().to_vec());
    (communication.sync.cob_id, communication.emcy.cob_id, told.collect())
}

/// Verifies: ECSS 6.9d, 6.10b, 6.10d
/// Notices: ECSS 6.9d: a stored 1005h makes a slave a second producer of SYNC.
#[test]
fn stored_cob_ids_that_no_client_may_write_are_not_taken() {
    let refused = [
        (0x1005, 0x0000_0605),
        (0x1005, 0x0000_0701),
        (0x1005, 0x4000_0080),
        (0x1005, 0x2000_0080),
        (0x1014, 0x0000_0101),
        (0x1014, 0x0000_0705),
        (0x1014, 0x4000_0085),
    ];
    for (index, value) in refused {
        let (sync, emcy, told) = cob_ids(&stored(&[(index, 0, value)]));
        assert_eq!((sync, emcy, told.len()), (0x80, 0x85, 1), "{index:X}h {value:X}h");
    }
}

/// Verifies: ECSS 6.10b, 6.10d
#[test]
fn stored_sync_and_emergencies_never_share_an_identifier() {
    let memory = stored(&[(0x1005, 0, 0x6C5), (0x1014, 0, 0x6C5)]);
    let (sync, emcy, told) = cob_ids(&memory);
    assert_eq!((sync, emcy, told.len()), (0x80, 0x85, 1));
}

/// Given a set with what a client can only write in steps (an identifier in use stays), then it is taken as it is.
///
/// Verifies: ECSS 6.10c
#[test]
fn stored_cob_ids_that_clients_write_in_steps_are_taken() {
    let memory = stored(&[(0x1005, 0, 0x85), (0x1014, 0, 0x6C5)]);
    assert_eq!(cob_ids(&memory), (0x85, 0x6C5, vec![]));
}

/// Given a stored TPDO with the identifier of SYNC, or a restricted one, then it is not valid.
///
/// Verifies: ECSS 6.10b, 6.10d
#[test]
fn stored_pdos_with_an_identifier_of_others_are_not_valid() {
    for id in [0x80, 0x605, 0x701, 0x085] {
        let mut slave = powered_with(&stored(&[(0x1800, 1, 0x4000_0000 | id)]));
        assert_eq!(read(&mut slave, 0x1800, 1)[3] & 0x80, 0x80, "{id:X}h");
    }
}

/// Given a slave whose stored heartbeat period is zero, when it boots up, at power-on and by command, then it sends its boot-up message and
/// no heartbeat.
///
/// Verifies: ECSS 6.5.3a, 6.5.2a
/// Notices: ECSS 6.5.3a: a slave without heartbeats boots up without a message.
/// Notices: ECSS 6.5.2a: a slave whose 1017h is zero sends heartbeats.
#[test]
fn slave_without_heartbeats_sends_its_boot_up_message() {
    let memory = Memory::default();
    write_all(&mut powered_with(&memory), &[(0x1017, 0, &[0, 0]), (0x1010, 2, b"save")]);
    let mut slave = powered_with(&memory);
    slave.run_until(ms(400));
    assert_eq!(payloads(&slave, 0x705), [[0]], "power-on");
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.run_until(slave.now + span(300));
    assert_eq!(payloads(&slave, 0x705), [[0]], "reset communication");
}
