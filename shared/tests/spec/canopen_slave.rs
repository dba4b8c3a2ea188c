//! A CANopen slave on one bus, with nothing of ECSS-E-ST-50-15C.

use async_canopen::node::extend::BusCommand;
use async_canopen::node::{CanopenSlave, Device, DeviceNode, Event, Node, Settings};
use ecss_can::emcy::{DeviceError, Emergency, ErrorCode, ErrorRegister};
use ecss_can::heartbeat::{HeartbeatConsumers, HeartbeatTimes};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::types::{AbortCode, CobId, Duration, NmtState, NodeId};

use crate::bench::{Bench, NOMINAL, frame, ms, node, span};

/// An input and an output.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Channel {
    /// Input
    #[object(0x6000, ro, pdo)]
    input: u16,
    /// Output
    #[object(0x6200, rww, pdo)]
    output: u16,
    /// Scale
    #[object(0x6300, rw)]
    scale: u32,
}

impl Device for Channel {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::node(0x200)).map(Channel::OUTPUT).receive(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Channel::INPUT).transmit(1)],
    );
}

/// Without power.
pub fn slave() -> CanopenSlave<Channel> {
    CanopenSlave::new(node(5), &Settings::DEFAULT, Channel::default())
}

fn powered() -> Bench<CanopenSlave<Channel>> {
    Bench::new(slave())
}

/// Started by the master, what it sent before forgotten.
pub fn operational() -> Bench<CanopenSlave<Channel>> {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(slave.node.state(), NmtState::Operational);
    slave.clear();
    slave
}

fn sent(slave: &Bench<CanopenSlave<Channel>>) -> Vec<(u16, Vec<u8>)> {
    slave.frames().into_iter().map(|(_, frame)| (frame.id().raw(), frame.data().to_vec())).collect()
}

/// Verifies: ECSS 6.5.2a, 6.5.3a, 6.5.4a
/// Notices: ECSS 6.5.3a: a plain slave sends no boot-up message at power-on.
/// Notices: ECSS 6.5.4a: a plain slave stays in Initialising after its boot-up message.
#[test]
fn boots_on_its_only_bus() {
    let mut slave = powered();
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join)]);
    assert_eq!(sent(&slave), [(0x705, vec![0x00])]);
    assert_eq!(slave.node.state(), NmtState::PreOperational);
    slave.run_until(ms(250));
    let beats = slave.times(NOMINAL, 0x705);
    assert_eq!(beats.len(), 3, "boot-up, then every 100 ms: {beats:?}");
}

/// Verifies: ECSS 6.5.1a, 6.5.1a.2, 6.5.1a.4, 6.5.3a, 6.5.1a.5
/// Notices: ECSS 6.5.1a: a plain slave does not obey a broadcast.
/// Notices: ECSS 6.5.1a.2: a plain slave does not obey a broadcast.
/// Notices: ECSS 6.5.1a.4: reset node resets the communication of a plain slave alone.
/// Notices: ECSS 6.5.3a: a plain slave sends no boot-up message after reset communication.
/// Notices: ECSS 6.5.1a.5: a plain slave ignores the fourth reset of its communication in a row.
#[test]
fn obeys_every_command_without_a_heartbeat_of_the_master() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x000, &[0x02, 0]);
    assert_eq!(slave.node.state(), NmtState::Stopped);
    slave.clear();
    for _ in 0..10 {
        slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    }
    assert_eq!(sent(&slave), vec![(0x705, vec![0x00]); 10], "resets are not counted");
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x81, 5]);
    assert_eq!(slave.events, [Event::ResetNode]);
    slave.receive(NOMINAL, 0x605, &[0x40, 0x00, 0x60, 0, 0, 0, 0, 0]);
    slave.run_until(ms(5_000));
    assert_eq!(sent(&slave), [], "silent until the chip is reset");
}

/// Verifies: ECSS 6.1a, 6.2a, 6.3a, 6.9b, 6.9e
/// Notices: ECSS 6.3a: a plain slave has no use for SYNC in Operational.
/// Notices: ECSS 6.9b: a synchronous TPDO of a plain slave ignores SYNC.
#[test]
fn exchanges_pdos_and_sdos() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x205, &[0x34, 0x12]);
    assert_eq!(slave.node.objects().application.output, 0x1234);
    slave.touch(|slave, now| slave.send_pdo(0, now));
    assert_eq!(sent(&slave), [(0x185, vec![0, 0])]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0x40, 0x00, 0x62, 0, 0, 0, 0, 0]);
    assert_eq!(sent(&slave), [(0x585, vec![0x4B, 0x00, 0x62, 0, 0x34, 0x12, 0, 0])]);
    slave.clear();
    // 1800h sub 2: with every SYNC.
    slave.receive(NOMINAL, 0x605, &[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(sent(&slave), [(0x185, vec![0, 0])]);
}

/// Given SYNCs that have a counter (1019h) and a TPDO that goes with each, when a SYNC comes without its counter, then
/// the slave sends an emergency and no PDO.
///
/// Verifies: ECSS 6.9e, 6.9b, 6.3b, 6.4a.2
/// Notices: ECSS 6.9b: synchronous PDOs go with a SYNC of wrong length.
/// Notices: ECSS 6.9e: a slave without a clock obeys a SYNC that lacks its counter.
#[test]
fn a_sync_without_its_counter_sends_no_pdo() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x605, &[0x2F, 0x19, 0x10, 0, 10, 0, 0, 0]);
    slave.receive(NOMINAL, 0x605, &[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[1]);
    assert_eq!(sent(&slave), [(0x185, vec![0, 0])]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(sent(&slave), [(0x085, vec![0x40, 0x82, 0x11, 0, 0, 0, 0, 0])]);
}

/// Verifies: ECSS 6.1a, 6.8a
/// Notices: ECSS 6.1a: a read of an object that there is not has another abort code than 0602 0000h.
#[test]
fn has_no_object_beyond_canopen() {
    let mut slave = operational();
    // 1010h: parameter store. 2000h: redundancy. 2010h: time. 2020h: health.
    for index in [0x1010_u16, 0x1011, 0x2000, 0x2010, 0x2011, 0x2020, 0x2030] {
        slave.clear();
        let [low, high] = index.to_le_bytes();
        slave.receive(NOMINAL, 0x605, &[0x40, low, high, 1, 0, 0, 0, 0]);
        assert_eq!(sent(&slave), [(0x585, vec![0x80, low, high, 1, 0, 0, 0x02, 0x06])], "{index:04X}h");
    }
}

/// Verifies: ECSS 6.4a.2, 6.4a, 6.4a.1, 6.5.2a, 6.5.4a
/// Notices: ECSS 6.4a.2: a missed heartbeat has the code 8000h.
/// Notices: ECSS 6.5.2a: the heartbeat of another node ends the error of the missed one.
/// Notices: ECSS 6.5.4a: a plain slave stays Operational after a missed heartbeat although 1029h is 0.
#[test]
fn misses_the_heartbeat_that_1016h_names() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(249));
    assert_eq!(slave.times(NOMINAL, 0x085), Vec::<u64>::new());
    slave.run_until(ms(251));
    assert_eq!(slave.node.state(), NmtState::PreOperational, "1029h");
    let emergency = slave.frames().into_iter().find(|(_, frame)| frame.id().raw() == 0x085);
    assert_eq!(emergency, Some((NOMINAL, frame(0x085, &[0x30, 0x81, 0x11, 1, 0, 0, 0, 0]))));
    // Its return ends the error; heartbeats of others do not, and are not received.
    slave.run_until(ms(500));
    slave.clear();
    slave.receive(NOMINAL, 0x702, &[0x05]);
    assert_eq!((slave.times(NOMINAL, 0x085), slave.node.counters().ignored), (vec![], 1));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(501));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x085, &[0, 0, 0, 0x30, 0x81, 1, 0, 0]))]);
}

/// Verifies: ECSS 6.4a, 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a.1: the end of an error of another source ends this one.
#[test]
fn reports_errors_of_its_device_and_their_end() {
    let mut slave = operational();
    slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::CURRENT, 7), [1, 2, 3, 4]));
    assert_eq!(sent(&slave), [(0x085, vec![0x00, 0x20, 0x03, 7, 1, 2, 3, 4])]);
    slave.clear();
    let emergencies = |slave: &Bench<_>| -> Vec<Vec<u8>> {
        sent(slave).into_iter().filter(|(id, _)| *id == 0x085).map(|(_, data)| data).collect()
    };
    slave.touch(|slave, _| slave.clear(DeviceError::new(ErrorCode::CURRENT, 8)));
    slave.run_until(ms(200));
    assert!(emergencies(&slave).is_empty(), "of another source");
    slave.touch(|slave, _| slave.clear(DeviceError::new(ErrorCode::CURRENT, 7)));
    assert_eq!(emergencies(&slave), [[0x00, 0x00, 0x00, 0x00, 0x20, 7, 0, 0]]);
}

/// Verifies: ECSS 6.5.1a, 6.5.1a.3
/// Notices: ECSS 6.5.1a: a command of three bytes is obeyed.
/// Notices: ECSS 6.5.1a.3: a slave obeys Enter pre-operational of another node.
#[test]
fn counts_what_is_malformed_and_what_is_for_others() {
    let mut slave = operational();
    let before = *slave.node.counters();
    for data in [&[1][..], &[1, 5, 0], &[3, 5]] {
        slave.receive(NOMINAL, 0x000, data);
    }
    slave.receive(NOMINAL, 0x000, &[0x80, 6]);
    slave.receive(NOMINAL, 0x206, &[1, 2]);
    slave.receive(NOMINAL, 0x606, &[0x40, 0x00, 0x62, 0, 0, 0, 0, 0]);
    slave.transmitted(NOMINAL, frame(0x705, &[5]));
    let after = *slave.node.counters();
    assert_eq!(slave.node.state(), NmtState::Operational);
    assert_eq!(after.received - before.received, 6);
    assert_eq!(after.malformed - before.malformed, 3);
    assert_eq!(after.ignored - before.ignored, 2);
    assert_eq!(after.sent - before.sent, 1);
    assert_eq!(sent(&slave), []);
}

/// Given a plain slave in Pre-operational, Operational or Stopped, when the time object of CiA 301 comes (100h), then it is for others.
///
/// Verifies: ECSS 11.1c
/// Notices: ECSS 11.1c: a plain slave takes the time object.
#[test]
fn takes_no_time_object() {
    for command in [0x80, 0x01, 0x02] {
        let mut slave = operational();
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        slave.clear();
        let before = slave.node.counters().ignored;
        slave.receive(NOMINAL, 0x100, &[0, 0, 0, 0, 0x10, 0x27]);
        assert_eq!((sent(&slave), slave.events.len()), (vec![], 0), "{command:02X}h");
        assert_eq!(slave.node.counters().ignored - before, 1);
    }
}

/// Verifies: ECSS 6.5.2a, 6.8a
/// Notices: ECSS 6.5.2a: a plain slave keeps its heartbeat period when 1017h is written.
/// Notices: ECSS 6.5.2a: a period above 32,767 ms is another one.
#[test]
fn is_written_by_its_application_as_by_a_client() {
    let mut slave = operational();
    slave.touch(|slave, now| slave.change(now, |channel| channel.input = 0x4321));
    assert_eq!(slave.node.objects().application.input, 0x4321);
    // 1017h: from now on a heartbeat every 40 ms.
    assert_eq!(slave.write((0x1017, 0), &[40, 0]), Ok(()));
    slave.run_until(ms(200));
    let beats = slave.times(NOMINAL, 0x705);
    assert!(beats.len() >= 5 && beats.windows(2).all(|two| two[1] - two[0] == 40), "{beats:?}");
    for period in [32_768_u16, u16::MAX] {
        slave.clear();
        let begin = slave.now;
        assert_eq!(slave.write((0x1017, 0), &period.to_le_bytes()), Ok(()));
        slave.run_until(begin + span(3 * u64::from(period)));
        let beats = slave.times(NOMINAL, 0x705);
        assert_eq!(beats.len(), 4, "one at once, then one in each period");
        assert!(beats.windows(2).all(|two| two[1] - two[0] == u64::from(period)), "{beats:?}");
    }
    assert_eq!(slave.write((0x6000, 1), &[0, 0]), Err(AbortCode::NoSubIndex));
    assert!(!slave.node.is_stamped(NOMINAL, &frame(0x080, &[])), "it has no clock");
}

/// Given a node without heartbeats, when its client falls silent in a download, then the SDO timeout of 500 ms ends it by itself.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: a plain slave has no SDO timeout.
#[test]
fn aborts_a_transfer_that_does_not_go_on() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x605, &[0x2B, 0x17, 0x10, 0, 0, 0, 0, 0]);
    slave.run_until(ms(10));
    slave.receive(NOMINAL, 0x605, &[0x21, 0x00, 0x62, 0, 2, 0, 0, 0]);
    slave.clear();
    slave.run_until(ms(509));
    assert_eq!(sent(&slave), []);
    slave.run_until(ms(510));
    assert_eq!(sent(&slave), [(0x585, vec![0x80, 0x00, 0x62, 0, 0, 0, 0x04, 0x05])]);
}

/// CiA 301 7.2.4.3.17: too long, too short. A length that is not told fits.
///
/// Verifies: ECSS 6.1a, 6.8a
/// Notices: ECSS 6.1a: a value that is too long is cut off and written.
#[test]
fn takes_a_number_of_its_length_alone() {
    let mut slave = operational();
    let [long, short] = [0x0607_0012_u32, 0x0607_0013].map(u32::to_le_bytes);
    for (command, code) in
        [(0x2F, Some(short)), (0x27, Some(long)), (0x23, Some(long)), (0x2B, None), (0x22, None)]
    {
        slave.clear();
        slave.receive(NOMINAL, 0x605, &[command, 0x00, 0x62, 0, command, 0x12, 0, 0]);
        let answer = match code {
            Some([a, b, c, d]) => vec![0x80, 0x00, 0x62, 0, a, b, c, d],
            None => vec![0x60, 0x00, 0x62, 0, 0, 0, 0, 0],
        };
        assert_eq!(sent(&slave), [(0x585, answer)], "{command:02X}h");
        let taken = if code.is_some() { 0 } else { u16::from_le_bytes([command, 0x12]) };
        assert_eq!(slave.node.objects().application.output, taken, "{command:02X}h");
    }
}

/// CiA 301 7.2.4.3.3: the four bytes of the first frame are the length of what follows in segments.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: the size in the first frame is written as the value.
#[test]
fn takes_a_number_that_comes_in_a_segment() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x605, &[0x21, 0x00, 0x63, 0, 4, 0, 0, 0]);
    assert_eq!(slave.node.objects().application.scale, 0);
    slave.receive(NOMINAL, 0x605, &[0x07, 0x78, 0x56, 0x34, 0x12, 0, 0, 0]);
    assert_eq!(slave.node.objects().application.scale, 0x1234_5678);
    let answers = [[0x60, 0x00, 0x63, 0, 0, 0, 0, 0], [0x20, 0, 0, 0, 0, 0, 0, 0]];
    assert_eq!(sent(&slave), answers.map(|answer| (0x585, answer.to_vec())));
}

/// Payloads of this COB-ID sent so far.
fn payloads(slave: &Bench<CanopenSlave<Channel>>, id: u16) -> Vec<Vec<u8>> {
    sent(slave).into_iter().filter(|(of, _)| *of == id).map(|(_, data)| data).collect()
}

/// A value is written over SDO.
fn write(slave: &mut Bench<CanopenSlave<Channel>>, index: u16, sub: u8, value: &[u8]) {
    let [low, high] = index.to_le_bytes();
    let mut request = [0x23 | (4 - value.len() as u8) << 2, low, high, sub, 0, 0, 0, 0];
    request[4..][..value.len()].copy_from_slice(value);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &request);
    assert_eq!(sent(slave), [(0x585, vec![0x60, low, high, sub, 0, 0, 0, 0])], "{index:04X}h sub {sub}");
    slave.clear();
}

/// Given a slave without a clock, when it gets Enter pre-operational or Stop, then it has the services of that state (CiA 301 7.3.2.2.5):
/// PDOs in Operational alone, SDO and emergencies in Pre-operational as well, in Stopped heartbeats alone.
///
/// Verifies: ECSS 6.5.1a.3, 6.5.1a.2, 6.5.1a.1, 6.5.4a
/// Notices: ECSS 6.5.1a.3: a plain slave ignores Enter pre-operational.
/// Notices: ECSS 6.5.4a: a plain slave answers SDO requests in Stopped.
#[test]
fn uses_the_services_of_each_nmt_state() {
    use NmtState::{Operational, PreOperational, Stopped};
    // PDO taken and sent, SDO answered, emergency sent.
    for (command, state, pdo, sdo) in
        [(0x80, PreOperational, false, true), (0x02, Stopped, false, false), (0x01, Operational, true, true)]
    {
        for target in [5, 0] {
            let mut slave = operational();
            write(&mut slave, 0x1800, 2, &[1]);
            slave.receive(NOMINAL, 0x000, &[command, target]);
            assert_eq!(slave.node.state(), state);
            slave.clear();
            slave.receive(NOMINAL, 0x205, &[0x34, 0x12]);
            assert_eq!(slave.node.objects().application.output, if pdo { 0x1234 } else { 0 }, "{state:?}");
            slave.receive(NOMINAL, 0x080, &[]);
            assert_eq!(payloads(&slave, 0x185).len(), usize::from(pdo), "{state:?}");
            slave.receive(NOMINAL, 0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
            assert_eq!(payloads(&slave, 0x585).len(), usize::from(sdo), "{state:?}");
            slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::CURRENT, 7), [0; 4]));
            slave.run_until(ms(150));
            assert_eq!(payloads(&slave, 0x085).len(), usize::from(sdo), "{state:?}");
            assert_eq!(payloads(&slave, 0x705).len(), 1, "{state:?}");
        }
    }
}

/// Given a slave without a clock that gets commands, then its heartbeats have its state: 7Fh, 05h or 04h.
///
/// Verifies: ECSS 6.5.2a
/// Notices: ECSS 6.5.2a: heartbeats of a plain slave have 7Fh in Stopped.
#[test]
fn has_its_state_in_its_heartbeats() {
    let mut slave = powered();
    for (command, state) in [(None, 0x7F), (Some(0x01), 0x05), (Some(0x02), 0x04), (Some(0x80), 0x7F)] {
        slave.clear();
        if let Some(command) = command {
            slave.receive(NOMINAL, 0x000, &[command, 5]);
        }
        slave.run_until(slave.now + span(250));
        let states = payloads(&slave, 0x705);
        assert!(states.len() >= 2 && states.iter().all(|found| *found == [state]), "{command:?}: {states:?}");
    }
}

/// Given a slave without a clock, when it misses node 1, then it enters the state that 1029h names (CiA 301 7.5.2.32): 0
/// Pre-operational, 1 the same as before, 2 Stopped. Its next heartbeat has that state.
///
/// Verifies: ECSS 6.5.2a, 6.5.4a
/// Notices: ECSS 6.5.2a: a plain slave enters Pre-operational whatever 1029h is.
#[test]
fn enters_the_state_of_1029h_when_it_misses_a_heartbeat() {
    for (behaviour, state) in [(0, 0x7F), (1, 0x05), (2, 0x04)] {
        let mut slave = operational();
        write(&mut slave, 0x1029, 1, &[behaviour]);
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.run_until(ms(240));
        assert_eq!(payloads(&slave, 0x705), [[0x05], [0x05]], "not missed yet");
        slave.clear();
        // Missed at 250 ms.
        slave.run_until(ms(300));
        assert_eq!(payloads(&slave, 0x705), [[state]], "1029h is {behaviour}");
    }
}

/// Given a slave without a clock and an RPDO of two bytes, when one byte or three arrive, then it sends an emergency: 8210h, too short, or
/// 8220h, too long (CiA 301, table of error codes). Two bytes of the right length end it. Of three the first two are taken.
///
/// Verifies: ECSS 6.2a, 6.4a.2
/// Notices: ECSS 6.2a: a plain slave takes an RPDO that is too short.
/// Notices: ECSS 6.4a.2: an RPDO that is too long is reported as one that is too short.
#[test]
fn reports_an_rpdo_of_the_wrong_length() {
    for (data, code, output) in [(&[1][..], 0x10, 0), (&[1, 2, 3], 0x20, 0x0201)] {
        let mut slave = operational();
        write(&mut slave, 0x1015, 0, &[0, 0]);
        slave.receive(NOMINAL, 0x205, data);
        assert_eq!(sent(&slave), [(0x085, vec![code, 0x82, 0x11, 0, 0, 0, 0, 0])]);
        assert_eq!(slave.node.objects().application.output, output, "{data:?}");
        slave.clear();
        slave.receive(NOMINAL, 0x205, &[7, 8]);
        assert_eq!(sent(&slave), [(0x085, vec![0, 0, 0, code, 0x82, 0, 0, 0])]);
        assert_eq!(slave.node.objects().application.output, 0x0807);
    }
}

/// Given a TPDO of a slave without a clock with an inhibit time of 30 ms (sub-index 3, in 100 us) and an event timer of 70 ms (sub-index
/// 5), then it goes 70 ms after the last one, and at an event 30 ms after the last one at the earliest.
///
/// Verifies: ECSS 6.2a
/// Notices: ECSS 6.2a: a plain slave ignores the inhibit time of a TPDO.
/// Notices: ECSS 6.2a: a plain slave ignores the event timer of a TPDO.
#[test]
fn obeys_inhibit_time_and_event_timer() {
    let mut slave = operational();
    write(&mut slave, 0x1800, 1, &[0x85, 0x01, 0, 0xC0]);
    write(&mut slave, 0x1800, 2, &[254]);
    write(&mut slave, 0x1800, 3, &300_u16.to_le_bytes());
    write(&mut slave, 0x1800, 5, &70_u16.to_le_bytes());
    write(&mut slave, 0x1800, 1, &[0x85, 0x01, 0, 0x40]);
    slave.run_until(ms(80));
    slave.touch(|slave, now| slave.send_pdo(0, now));
    slave.run_until(ms(300));
    // The event at 80 ms waits until 100 ms. From then on the timer runs again.
    assert_eq!(slave.times(NOMINAL, 0x185), [70, 100, 170, 240]);
}

/// A display of what others report: emergencies of nodes 5 and 6.
#[derive(Debug, Objects)]
#[objects(device)]
struct Display {}

impl Device for Display {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);
    const RAW_FRAMES: &'static [CobId] = &[CobId::emcy(NodeId::of::<5>()), CobId::emcy(NodeId::of::<6>())];
}

/// Given a slave whose device names the emergencies of nodes 5 and 6, when nodes 5, 6 and 7 send one each, then the first two pass
/// the filters and are events, in every state; the third is ignored. The slave counts none of the others as malformed.
#[test]
fn passes_on_the_frames_that_its_device_names() {
    let mut slave = Bench::new(CanopenSlave::new(node(9), &Settings::DEFAULT, Display::default()));
    for state in [NmtState::PreOperational, NmtState::Operational, NmtState::Stopped] {
        slave.clear();
        for from in [5, 6, 7] {
            slave.receive(NOMINAL, 0x080 + from, &[0x10, 0x81, 0x11, 0, 0, 0, 0, from as u8]);
        }
        let decoded =
            |event: &Event| if let Event::Frame(frame) = event { Emergency::decode(frame) } else { None };
        let found: Vec<_> = slave.events.iter().filter_map(decoded).collect();
        let expected = [5, 6].map(|from| {
            let info = [0, 0, 0, 0, from];
            (
                node(from),
                Emergency { code: ErrorCode::CAN_OVERRUN, register: ErrorRegister::from_bits(0x11), info },
            )
        });
        assert_eq!((slave.node.state(), found), (state, expected.to_vec()));
        let command = if state == NmtState::PreOperational { 1 } else { 2 };
        slave.receive(NOMINAL, 0x000, &[command, 9]);
    }
    let admitted = slave.node.filters();
    let admits = |raw| admitted.iter().filter(|filter| filter.admits(CobId::new(raw).unwrap())).count();
    assert_eq!([0x085, 0x086, 0x087].map(admits), [1, 1, 0]);
    let set_again: Vec<_> = (0..admitted.len() + 1).map(|number| slave.node.filter(number)).collect();
    assert_eq!(set_again[..admitted.len()], admitted.iter().copied().map(Some).collect::<Vec<_>>());
    assert_eq!(set_again[admitted.len()], None);
}

/// Monitors node 7, and no master.
#[derive(Debug, Objects)]
#[objects(device)]
struct Follower {}

impl Device for Follower {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);

    fn consumers(_: NodeId) -> HeartbeatConsumers<1> {
        HeartbeatConsumers { consumer_heartbeat: [0x0007_0064] }
    }
}

/// Given a slave without a consumer time for the master, whose device monitors node 7 for 100 ms (1016h), when node 7 is heard and
/// then silent, then the slave reports its state, and 100 ms later that it is missed.
///
/// Verifies: ECSS 6.5.2a
#[test]
fn monitors_what_its_device_says_in_a_network_without_a_master() {
    let heartbeats = HeartbeatTimes { consumer: Duration::ZERO, ..Settings::DEFAULT.heartbeats };
    let settings = Settings { heartbeats, ..Settings::DEFAULT };
    let mut slave = Bench::new(CanopenSlave::new(node(9), &settings, Follower::default()));
    assert_eq!(slave.node.objects().consumers.consumer_heartbeat, [0x0007_0064]);
    slave.receive(NOMINAL, 0x707, &[0x05]);
    slave.run_until(ms(99));
    let peer = [Event::PeerState { node: node(7), state: NmtState::Operational }];
    let of_peer = |slave: &Bench<CanopenSlave<Follower>>| -> Vec<Event> {
        let is_peer = |event: &&Event| matches!(event, Event::PeerState { .. } | Event::PeerMissed { .. });
        slave.events.iter().filter(is_peer).copied().collect()
    };
    assert_eq!(of_peer(&slave), peer);
    slave.run_until(ms(101));
    assert_eq!(of_peer(&slave), [peer[0], Event::PeerMissed { node: node(7) }]);
}
