//! Reset communication takes back what was configured over the bus.
//!
//! Verifies: ECSS 6.5.1a.5

use ecss_can::link::port::Filter;
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{Node, SlaveEvent};
use ecss_can::types::{Bus, CobId};

use super::fixture::{done, operational, payloads, powered, read, write, write_all};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, span};
use crate::slave::TestSlave;

/// Reset communication and start: what a SYNC and an event of TPDO 3 send then.
fn reset_and_trigger(slave: &mut Bench<TestSlave>) -> Vec<(u16, usize)> {
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    sent_when_triggered(slave)
}

/// COB-IDs and lengths.
fn sent_when_triggered(slave: &mut Bench<TestSlave>) -> Vec<(u16, usize)> {
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    slave.touch(|slave, now| slave.send_pdo(2, now));
    slave.sent.iter().map(|sent| (sent.frame.id().raw(), sent.frame.data().len())).collect()
}

/// The Local Time PDO and telemetry.
const DEFAULT: [(u16, usize); 2] = [(0x185, 7), (0x385, 8)];

/// Verifies: ECSS 6.2a, 6.10a, 6.10c
/// Notices: ECSS 6.10c: two TPDOs cannot swap their COB-IDs.
#[test]
fn pdos_that_have_swapped_their_cob_ids_have_their_own_again() {
    let mut slave = operational();
    assert_eq!(sent_when_triggered(&mut slave), DEFAULT);
    write_all(
        &mut slave,
        &[
            (0x1800, 1, &[0x85, 1, 0, 0xC0]),
            (0x1802, 1, &[0x85, 3, 0, 0xC0]),
            (0x1800, 1, &[0x85, 3, 0, 0x40]),
            (0x1802, 1, &[0x85, 1, 0, 0x40]),
        ],
    );
    assert_eq!(sent_when_triggered(&mut slave), [(0x385, 7), (0x185, 8)]);
    assert_eq!(reset_and_trigger(&mut slave), DEFAULT);
}

/// Verifies: ECSS 6.2a, 6.10a, 6.10c
#[test]
fn a_pdo_has_its_cob_id_again_that_another_one_took() {
    let mut slave = operational();
    write_all(
        &mut slave,
        &[
            (0x1800, 1, &[0x85, 1, 0, 0xC0]),
            (0x1A03, 0, &[0]),
            (0x1A03, 1, &[32, 0, 0x10, 0x62]),
            (0x1A03, 0, &[1]),
            (0x1803, 2, &[1]),
            (0x1803, 1, &[0x85, 1, 0, 0x40]),
        ],
    );
    assert_eq!(sent_when_triggered(&mut slave), [(0x185, 4), (0x385, 8)]);
    assert_eq!(reset_and_trigger(&mut slave), DEFAULT);
}

/// Given a COB-ID of SYNC that a client wrote, when the slave gets Reset communication, then it takes SYNC with 080h again, and no
/// longer with the written COB-ID.
///
/// Verifies: ECSS 6.3a, 6.10a, 6.10c
/// Notices: ECSS 6.3a: 1005h is restored, and the slave does not take SYNC with it.
/// Notices: ECSS 6.5.1a.5: the slave goes on to take SYNC with the COB-ID that a client wrote.
#[test]
fn sync_has_its_cob_id_again_after_reset_communication() {
    let syncs = |slave: &mut Bench<TestSlave>| {
        [0x080, 0x081].map(|id| {
            slave.clear();
            slave.receive(NOMINAL, id, &[]);
            slave.events.iter().filter(|event| matches!(event, SlaveEvent::Sync { .. })).count()
        })
    };
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x1005, 0, &[0x81, 0, 0, 0]), done(0x1005, 0));
    assert_eq!(syncs(&mut slave), [0, 1]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(syncs(&mut slave), [1, 0]);
}

/// Verifies: ECSS 6.5.3a, 6.10a, 6.10c, 8.2.2a
/// Notices: ECSS 6.10a: a written COB-ID of SYNC is not admitted by the filters.
/// Notices: ECSS 6.5.1a.5: 1016h keeps what a client wrote.
#[test]
fn all_filters_return_to_defaults_beside_the_boot_up_message() {
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x1005, 0, &[0x81, 0, 0, 0]), done(0x1005, 0));
    for sub in 1..=8 {
        assert_eq!(write(&mut slave, 0x1016, sub, &[250, 0, 20 + sub, 0]), done(0x1016, sub));
    }
    for number in 0..8 {
        let (pdo, mapping) = (0x1400 + u16::from(number), 0x1600 + u16::from(number));
        let mut cob_id = read(&mut slave, pdo, 1);
        cob_id[3] |= 0x80;
        write_all(
            &mut slave,
            &[
                (pdo, 1, &cob_id),
                (pdo, 1, &[0x41 + number, 2, 0, 0xC0]),
                (mapping, 0, &[0]),
                (mapping, 1, &[32, 0, 0x10, 0x62]),
                (mapping, 0, &[1]),
                (pdo, 1, &[0x41 + number, 2, 0, 0x40]),
            ],
        );
    }
    let of = |id| Filter::exact(CobId::new(id).unwrap());
    let filters: Vec<_> = slave.node.filters().into_iter().collect();
    let written = (0x715..=0x71C).chain(0x241..=0x248).chain([0x705]).map(of);
    assert_eq!(filters, [0x000, 0x081, 0x605, 0x701].map(of).into_iter().chain(written).collect::<Vec<_>>());

    slave.run_until(ms(50));
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(slave.sent[0].frame, frame(0x705, &[0]), "at once");
    slave.run_until(slave.now + span(20));
    // NMT stands where there is nothing to admit.
    let defaults = [0x080, 0x701, 0, 0, 0, 0, 0, 0, 0, 0x181, 0x305, 0x405, 0, 0, 0, 0, 0].map(of);
    let numbers = [1].into_iter().chain(4..20);
    let expected: Vec<_> =
        numbers.zip(defaults).map(|(number, filter)| BusCommand::Filter { number, filter }).collect();
    for bus in [NOMINAL, REDUNDANT] {
        let mut told: Vec<_> = slave.controls.iter().filter(|(on, _)| *on == bus).collect();
        assert_eq!(told.len(), 17, "each once");
        told.sort_by_key(|(_, command)| match command {
            BusCommand::Filter { number, .. } => *number,
            other => panic!("{other:?}"),
        });
        assert!(told.iter().map(|(_, command)| command).eq(&expected), "{told:?}");
    }
    let counters = slave.node.status(slave.now).counters;
    assert!(Bus::ALL.into_iter().all(|bus| counters[bus].failed() == 0));
    assert_eq!(payloads(&slave, 0x705), [[0]]);
}

/// Given consumer and producer times that a client wrote, when the slave gets Reset communication, then 1016h and 1017h have those of
/// its profile again: 250 ms of node 1, and 100 ms.
///
/// Verifies: ECSS 8.3.1a
/// Notices: ECSS 8.3.1a: after Reset communication 1016h lacks the master and its time.
#[test]
fn heartbeat_times_of_table_8_1_return_to_those_of_the_profile() {
    let mut slave = powered();
    write_all(&mut slave, &[(0x1016, 1, &[0x58, 2, 1, 0]), (0x1017, 0, &[50, 0])]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(read(&mut slave, 0x1016, 1), [250, 0, 1, 0]);
    assert_eq!(read(&mut slave, 0x1017, 0), [100, 0, 0, 0]);
}

/// Given a heartbeat period of 50 ms that a client wrote, when the slave gets Reset communication, then its heartbeats have the period
/// of its profile, 100 ms, from the boot-up message on.
///
/// Verifies: ECSS 6.5.2a, 8.3.3d
/// Notices: ECSS 6.5.2a: after Reset communication the heartbeats keep the period that a client wrote.
#[test]
fn heartbeats_have_the_period_of_the_profile_after_reset() {
    let mut slave = powered();
    write_all(&mut slave, &[(0x1017, 0, &[50, 0])]);
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.run_until(ms(240));
    assert_eq!(slave.times(NOMINAL, 0x705), [0, 100, 200]);
}
