//! PDOs that are configured over the bus, and what they carry.
//!
//! Verifies: ECSS 6.2a

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::port::{Filter, Health};
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{Device, Node as _, NodeObjects, Slave, SlaveEvent};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::types::{Address, Bus, CobId, Duration};

use super::fixture::{
    autostarted, done, map_tpdo, operational, payloads, powered, read, run_with_master, write, write_all,
    write_on,
};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, pdos, span};
use crate::instrument::{Instrument, STANDARD};
use crate::slave::TestSlave;

/// Value, and Bdefault, as an entry of a mapping.
const VALUE: u32 = 0x6210_0020;
const BDEFAULT: u32 = 0x2000_0108;

/// Verifies: ECSS 6.10a, 6.10c, 8.2.1a.2, 8.2.2a, 6.5.1a.5
/// Notices: ECSS 8.2.1a.2: a changed filter is set on the active bus only.
/// Notices: ECSS 8.2.2a: changed filters are set in the nominal controller alone.
/// Notices: ECSS 6.5.1a.5: the COB-ID of an RPDO stays after Reset communication.
#[test]
fn a_pdo_takes_another_cob_id_and_the_filters_follow() {
    let mut slave = powered();
    write(&mut slave, 0x1401, 1, &[0x05, 3, 0, 0xC0]);
    assert_eq!(write(&mut slave, 0x1401, 1, &[0x45, 3, 0, 0x40]), done(0x1401, 1));
    let filter = Filter::exact(CobId::new(0x345).unwrap());
    for bus in Bus::ALL {
        assert!(slave.controls.contains(&(bus, BusCommand::Filter { number: 13, filter })));
    }
    assert_eq!(slave.node.filter(13), Some(filter));
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[1; 8]);
    assert_eq!(slave.events, []);
    slave.receive(NOMINAL, 0x345, &[1; 8]);
    assert_eq!(pdos(&slave.events), [Some((NOMINAL, 1, [1; 8]))]);
    // Reset communication goes back to what it was.
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    let filter = Filter::exact(CobId::new(0x305).unwrap());
    assert!(slave.controls.contains(&(NOMINAL, BusCommand::Filter { number: 13, filter })));
    assert_eq!(read(&mut slave, 0x1401, 1), [0x05, 3, 0, 0x40]);
}

#[test]
fn a_pdo_is_mapped_anew_and_sent() {
    let mut slave = powered();
    write_all(&mut slave, &[(0x1801, 5, &[10, 0])]);
    map_tpdo(&mut slave, 2, 254, &[VALUE, 0x2020_0108]);
    assert_eq!(write(&mut slave, 0x6210, 0, &[1, 2, 3, 4]), done(0x6210, 0));
    assert!(slave.events.contains(&SlaveEvent::Written(Address::new(0x6210, 0))));
    slave.health(NOMINAL, Health { tec: 9, ..Health::default() });
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave.run_until(ms(25));
    assert_eq!(slave.times(NOMINAL, 0x285), [10, 20]);
    assert_eq!(
        slave.sent.iter().find(|sent| sent.frame.id().raw() == 0x285).unwrap().frame,
        frame(0x285, &[1, 2, 3, 4, 0])
    );
}

/// A receive PDO changes a value; that a service has to follow, the node learns from an SDO. Objects that may come by PDO
/// are the application's, which hears of each, and the time, which sets the clock.
#[test]
fn what_a_service_has_to_follow_does_not_come_by_pdo() {
    let mut by_pdo = Vec::new();
    NodeObjects::<Instrument>::each_object(&mut |object| {
        if object.entries.iter().any(|entry| entry.is_mappable() && entry.access.is_for_rpdo()) {
            by_pdo.push(object.index);
        }
    });
    by_pdo.sort_unstable();
    assert_eq!(by_pdo, [0x2010, 0x6101, 0x6200, 0x6210]);
}

/// Verifies: ECSS 8.3.1a, 8.3.1c, 8.3.3g, 8.3.3l
/// Notices: ECSS 8.3.3l: a PDO carries the Bdefault of before the search.
/// Notices: ECSS 8.3.1c: a written Ctoggle is not shown.
#[test]
fn the_default_bus_and_the_toggles_so_far_go_out_by_pdo() {
    let mut slave = powered();
    map_tpdo(&mut slave, 2, 254, &[BDEFAULT, 0x2000_0408]);
    // The master is lost and found on the other bus.
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    let send = |slave: &mut Bench<TestSlave>| {
        slave.sent.clear();
        slave.touch(|slave, now| slave.send_pdo(1, now));
        slave.frames()
    };
    assert_eq!(send(&mut slave), [(NOMINAL, frame(0x285, &[0, 0]))]);
    slave.run_until(ms(600));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    slave.receive(REDUNDANT, 0x000, &[1, 5]);
    // Ctoggle shows the toggles of the search that ended.
    assert_eq!(send(&mut slave), [(REDUNDANT, frame(0x285, &[1, 1]))]);
    assert_eq!(write_on(&mut slave, REDUNDANT, 0x2000, 4, &[3]), done(0x2000, 4));
    assert_eq!(send(&mut slave), [(REDUNDANT, frame(0x285, &[1, 3]))]);
}

/// Verifies: ECSS 6.9b, 6.9e, 6.3b
/// Notices: ECSS 6.9b: a synchronous TPDO is sent after the end of the window.
/// Notices: ECSS 6.3b: the window of 1007h does not end transmission.
#[test]
fn synchronous_pdo_not_sent_by_the_end_of_the_window_is_stale() {
    let mut slave = autostarted();
    let expires = |slave: &mut Bench<TestSlave>| {
        slave.clear();
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.sent.len(), 1, "the Local Time PDO");
        slave.sent[0].expires.since(slave.now)
    };
    // Half a SYNC period: it is not to be taken for that of the next SYNC.
    let without = expires(&mut slave);
    assert_eq!(without, Duration::from_millis(50));
    // 2 ms.
    assert_eq!(write(&mut slave, 0x1007, 0, &2_000_u32.to_le_bytes()), done(0x1007, 0));
    assert_eq!(expires(&mut slave), Duration::from_millis(2));
    assert_eq!(write(&mut slave, 0x1007, 0, &[0; 4]), done(0x1007, 0));
    assert_eq!(expires(&mut slave), without);
}

/// Makes RPDO 5 a synchronous word, 250h.
fn map_synchronous_word(slave: &mut Bench<TestSlave>) {
    for (index, sub, bytes) in [
        (0x1604, 1, 0x6210_0020_u32.to_le_bytes().to_vec()),
        (0x1604, 0, vec![1]),
        (0x1404, 2, vec![1]),
        (0x1404, 1, 0x4000_0250_u32.to_le_bytes().to_vec()),
    ] {
        assert_eq!(write(slave, index, sub, &bytes), done(index, sub));
    }
}

/// Verifies: ECSS 6.9e, 6.3b, 6.9b
/// Notices: ECSS 6.9b: a synchronous RPDO takes effect on arrival.
#[test]
fn a_synchronous_rpdo_is_taken_again_after_operational_was_left() {
    let mut slave = autostarted();
    write(&mut slave, 0x1007, 0, &2_000_u32.to_le_bytes());
    slave.receive(NOMINAL, 0x080, &[]);
    // RPDO 5 has a frame long after the window of the only SYNC.
    let value = slave.node.objects().application.value;
    map_synchronous_word(&mut slave);
    slave.run_until(ms(100));
    let ignored = |slave: &Bench<TestSlave>| slave.node.status(slave.now).counters[NOMINAL].ignored;
    let before = ignored(&slave);
    slave.receive(NOMINAL, 0x250, &[9, 0, 0, 0]);
    assert_eq!(ignored(&slave), before + 1, "after the window");
    slave.receive(NOMINAL, 0x000, &[0x80, 5]);
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    slave.receive(NOMINAL, 0x250, &[9, 0, 0, 0]);
    assert_eq!(ignored(&slave), before + 1);
    assert_eq!(slave.node.objects().application.value, value);
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(slave.node.objects().application.value, 9);
}

/// Given a slave that followed the master to the redundant bus, when a frame of a synchronous RPDO and then SYNC arrive there, then SYNC
/// makes it take effect.
///
/// Verifies: ECSS 6.9e, 6.9b
/// Notices: ECSS 6.9e: RPDOs that wait take no effect while the redundant bus is active.
#[test]
fn a_synchronous_rpdo_takes_effect_on_the_redundant_bus() {
    let mut slave = autostarted();
    map_synchronous_word(&mut slave);
    slave.run_until(ms(50));
    slave.receive(REDUNDANT, 0x701, &[5]);
    let value = slave.node.objects().application.value;
    slave.receive(REDUNDANT, 0x250, &[9, 0, 0, 0]);
    assert_eq!(slave.node.objects().application.value, value);
    slave.receive(REDUNDANT, 0x080, &[]);
    assert_eq!(slave.node.objects().application.value, 9);
}

/// Given a synchronous RPDO that waits for SYNC, when the slave leaves Operational and is started again, then the next SYNC does not
/// apply the old value.
///
/// Verifies: ECSS 6.5.1a.2, 6.5.1a.3, 6.9e, 6.9b
/// Notices: ECSS 6.5.1a.2: a value that was received before Stop takes effect after the next Start.
/// Notices: ECSS 6.5.1a.3: a value that was received before Pre-operational takes effect after the next Start.
/// Notices: ECSS 6.9e: a value from before Operational was left is applied with the first SYNC after it.
#[test]
fn an_rpdo_that_waits_is_dropped_when_operational_is_left() {
    for leave in [0x02, 0x80] {
        let mut slave = autostarted();
        map_synchronous_word(&mut slave);
        slave.receive(NOMINAL, 0x250, &[9, 0, 0, 0]);
        slave.receive(NOMINAL, 0x000, &[leave, 5]);
        slave.receive(NOMINAL, 0x000, &[0x01, 5]);
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.node.objects().application.value, 0, "command {leave:02X}h");
        slave.receive(NOMINAL, 0x250, &[7, 0, 0, 0]);
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.node.objects().application.value, 7);
    }
}

/// The local time and the frames received so far, 8 bytes.
const VALUES_OF_THE_MOMENT: [u32; 2] = [0x2011_0120, 0x2020_0520];

/// Of each payload of TPDO 2.
fn values_of_the_moment(slave: &Bench<TestSlave>) -> Vec<(u32, u32)> {
    let number = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    payloads(slave, 0x285).iter().map(|data| (number(&data[..4]), number(&data[4..]))).collect()
}

/// Verifies: ECSS 7.1.2d
/// Notices: ECSS 7.1.2d: a PDO by event timer carries the time of the last read of Local SCET Get.
#[test]
fn pdo_by_event_timer_carries_present_time_and_health() {
    let mut slave = operational();
    write_all(&mut slave, &[(0x2010, 1, &1_000_u32.to_le_bytes()), (0x2010, 2, &[0; 3])]);
    write_all(&mut slave, &[(0x1801, 5, &1_000_u16.to_le_bytes())]);
    map_tpdo(&mut slave, 2, 254, &VALUES_OF_THE_MOMENT);
    let received = slave.node.status(slave.now).counters[NOMINAL].received;
    slave.clear();
    // 10 heartbeats a second, the tenth after the PDO.
    run_with_master(&mut slave, ms(3_000));
    let expected = [(1_001, received + 9), (1_002, received + 19), (1_003, received + 29)];
    assert_eq!(values_of_the_moment(&slave), expected);
}

/// Verifies: ECSS 6.9a, 6.9b, 7.1.2d
/// Notices: ECSS 6.9a: of several synchronous TPDOs the first one alone is sent.
/// Notices: ECSS 7.1.2d: a synchronous PDO carries the time of the last read of Local SCET Get.
#[test]
fn pdo_by_event_or_sync_carries_present_time_and_health() {
    for transmission in [254, 0, 1] {
        let mut slave = operational();
        write_all(&mut slave, &[(0x2010, 1, &1_000_u32.to_le_bytes()), (0x2010, 2, &[0; 3])]);
        map_tpdo(&mut slave, 2, transmission, &VALUES_OF_THE_MOMENT);
        let received = slave.node.status(slave.now).counters[NOMINAL].received;
        run_with_master(&mut slave, ms(1_000));
        slave.clear();
        slave.touch(|slave, now| slave.send_pdo(1, now));
        slave.receive(NOMINAL, 0x080, &[]);
        let syncs = u32::from(transmission != 254);
        assert_eq!(values_of_the_moment(&slave), [(1_001, received + 10 + syncs)], "type {transmission}");
    }
}

/// Verifies: ECSS 8.3.3g, 8.3.3l
/// Notices: ECSS 8.3.3l: a slave that follows its master keeps its Bdefault.
#[test]
fn change_of_bus_triggers_the_pdo_that_carries_the_default_bus() {
    let mut slave = operational();
    map_tpdo(&mut slave, 2, 254, &[BDEFAULT]);
    run_with_master(&mut slave, ms(200));
    slave.clear();
    // It follows the master, which was not missed yet.
    slave.receive(REDUNDANT, 0x701, &[5]);
    let of_pdo = |slave: &Bench<TestSlave>| -> Vec<_> {
        slave.frames().into_iter().filter(|(_, frame)| frame.id().raw() == 0x285).collect()
    };
    assert_eq!(of_pdo(&slave), [(REDUNDANT, frame(0x285, &[1]))]);
    // Nothing changes, nothing is sent.
    slave.clear();
    slave.run_until(slave.now + Duration::from_millis(100));
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!(of_pdo(&slave), []);
    // In search of the master it is in Pre-operational: no PDO, and none later of what was then.
    slave.run_until(slave.now + Duration::from_millis(600));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
    slave.receive(NOMINAL, 0x701, &[5]);
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, NOMINAL);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(of_pdo(&slave), []);
}

/// Verifies: ECSS 6.9e, 6.9b
/// Notices: ECSS 6.9b: a PDO of type 0 is sent at its event, not at SYNC.
#[test]
fn triggered_pdo_goes_out_at_the_sync_despite_writes_before() {
    let mut slave = operational();
    map_tpdo(&mut slave, 2, 0, &[VALUE]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(payloads(&slave, 0x285), [[0; 4]; 0], "no event yet");
    slave.touch(|slave, now| slave.send_pdo(1, now));
    write_all(&mut slave, &[(0x1801, 5, &[100, 0])]);
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(payloads(&slave, 0x285), [[0; 4]]);
    // Once.
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(payloads(&slave, 0x285), [[0; 4]; 0]);
    // It becomes event-driven: what waited for the SYNC goes at once.
    slave.touch(|slave, now| slave.send_pdo(1, now));
    slave.clear();
    write_all(&mut slave, &[(0x1801, 2, &[254])]);
    slave.run_until(slave.now);
    assert_eq!(payloads(&slave, 0x285), [[0; 4]]);
}

/// A slave with one filter too many: the 29th RPDO has none.
#[derive(Debug, Objects)]
#[objects(device)]
struct Wide {
    /// Output
    #[object(0x6200, rww, pdo)]
    output: u16,
}

impl Device for Wide {
    type Pdos = PdoObjects<29, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);
}

/// Given more RPDOs than filters, when the COB-ID of the last one changes, then no filter does.
#[test]
fn an_rpdo_without_a_filter_changes_none() {
    let mut slave = Bench::new(Slave::builder(node(5), &STANDARD, Wide::default()).build());
    slave.run_until(ms(5));
    for (index, changed) in [(0x141A, Some(31)), (0x141B, None), (0x141C, None)] {
        write(&mut slave, index + 0x200, 1, &[16, 0, 0, 0x62]);
        write(&mut slave, index + 0x200, 0, &[1]);
        slave.controls.clear();
        assert_eq!(write(&mut slave, index, 1, &[0x45, 3, 0, 0x40]), done(index, 1));
        slave.run_until(slave.now + span(5));
        let filter = Filter::exact(CobId::new(0x345).unwrap());
        let expected = changed.map(|number| BusCommand::Filter { number, filter });
        let told: Vec<_> = slave.controls.iter().map(|(_, command)| *command).collect();
        assert_eq!(told, expected.map_or(vec![], |command| vec![command; 2]), "{index:04X}h");
    }
}
