//! Emergency object: codes, register, producer, decoding.
//!
//! Verifies: ECSS 6.4a

use std::collections::BTreeSet;

use async_canopen::emcy::machine::{Config, Producer};
use async_canopen::emcy::{Emergency, ErrorCode, ErrorRegister};
use async_canopen::types::{CobId, Duration, Instant, NmtState};

use proptest::prelude::*;

use crate::bench::{frame, ms, node};
use crate::random::cases;

const OPERATIONAL: NmtState = NmtState::Operational;

fn producer(inhibit_ms: u64) -> Producer {
    Producer::new(Config { id: Some(CobId::emcy(node(5))), inhibit: Duration::from_millis(inhibit_ms) })
}

/// Verifies: ECSS 6.10a
#[test]
fn its_objects_configure_a_producer() {
    let inhibit = Duration::from_micros(1_500);
    assert_eq!(Config::new(0x0000_0085, 15), Config { id: CobId::new(0x085), inhibit });
    assert_eq!(Config::new(0x8000_0085, 15), Config { id: None, inhibit });
    assert_eq!(Config::new(0x2000_0085, u16::MAX).inhibit, Duration::from_micros(6_553_500));
    assert_eq!(Config::new(0x2000_0085, 0).id, None);
}

/// Everything that goes out at `now`; a node acknowledges it.
fn sent(producer: &mut Producer, now: Instant) -> Vec<Vec<u8>> {
    ended(producer, now, true)
}

/// Everything that goes out at `now`, and is acknowledged or fails.
fn ended(producer: &mut Producer, now: Instant, is_acknowledged: bool) -> Vec<Vec<u8>> {
    let mut all = vec![];
    while let Some(frame) = producer.poll(now, OPERATIONAL) {
        producer.on_end(&frame, is_acknowledged, now);
        all.push(frame.data().to_vec());
    }
    all
}

const BEGIN: [u8; 8] = [0x00, 0x42, 0x09, 1, 0, 0, 0, 0];
const END: [u8; 8] = [0, 0, 0, 0x00, 0x42, 1, 0, 0];

fn raise(producer: &mut Producer) {
    assert!(producer.raise(ErrorCode::TEMPERATURE_DEVICE, [1, 0, 0, 0, 0]));
}

fn clear(producer: &mut Producer) {
    assert!(producer.clear(ErrorCode::TEMPERATURE_DEVICE, 1));
}

/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a: the end of an error is sent before its beginning was acknowledged.
#[test]
fn error_that_ends_before_its_message_was_sent_sends_none() {
    let mut producer = producer(0);
    raise(&mut producer);
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(0)), [[0; 8]; 0]);
    assert_eq!(producer.history().read(1), Ok(0x0001_4200));
    // While the bus has the message, it may still be sent. The bus reports whether it was.
    for (at, is_acknowledged) in [(100, false), (300, true)] {
        raise(&mut producer);
        let frame = producer.poll(ms(at), OPERATIONAL).unwrap();
        clear(&mut producer);
        assert_eq!(sent(&mut producer, ms(at + 1)), [[0; 8]; 0]);
        producer.on_end(&frame, is_acknowledged, ms(at + 2));
        let expected: &[[u8; 8]] = if is_acknowledged { &[END] } else { &[] };
        assert_eq!(sent(&mut producer, ms(at + 100)), expected);
    }
}

#[test]
fn error_that_returns_before_its_end_was_sent_sends_nothing() {
    let mut producer = producer(100);
    raise(&mut producer);
    assert_eq!(sent(&mut producer, ms(0)), [BEGIN]);
    clear(&mut producer);
    raise(&mut producer);
    assert_eq!(producer.deadline(OPERATIONAL), None);
    assert_eq!(producer.history().len(), 1);
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(100)), [END]);
    // It returns while its end is on the way: acknowledged, the error is news again; else it never ended.
    for (at, is_acknowledged) in [(1_000, false), (6_000, true)] {
        producer.confirm();
        raise(&mut producer);
        assert_eq!(sent(&mut producer, ms(at)), [BEGIN]);
        clear(&mut producer);
        let end = producer.poll(ms(at + 1_000), OPERATIONAL).unwrap();
        raise(&mut producer);
        producer.on_end(&end, is_acknowledged, ms(at + 1_001));
        let expected: &[[u8; 8]] = if is_acknowledged { &[BEGIN] } else { &[] };
        assert_eq!(sent(&mut producer, ms(at + 2_000)), expected);
        clear(&mut producer);
        assert_eq!(sent(&mut producer, ms(at + 3_000)), [END]);
    }
}

/// Verifies: ECSS 5.3.3.2.3d
/// Notices: ECSS 5.3.3.2.3d: an emergency that was lost in the short is never sent.
#[test]
fn message_that_was_not_sent_is_sent_again_and_before_its_end() {
    let mut producer = producer(0);
    raise(&mut producer);
    assert_eq!(ended(&mut producer, ms(0), false), [BEGIN]);
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(50)));
    assert_eq!(sent(&mut producer, ms(50)), [BEGIN]);
    clear(&mut producer);
    assert_eq!(ended(&mut producer, ms(60), false), [END]);
    assert_eq!(sent(&mut producer, ms(109)), [[0; 8]; 0]);
    assert_eq!(sent(&mut producer, ms(110)), [END]);
    // A frame of another node, or another one of this node, ends nothing.
    raise(&mut producer);
    let begin = producer.poll(ms(200), OPERATIONAL).unwrap();
    producer.on_end(&frame(0x086, begin.data()), true, ms(200));
    producer.on_end(&frame(0x085, &begin.data()[..7]), true, ms(200));
    producer.on_end(&frame(0x085, &END), true, ms(200));
    producer.on_end(&begin, false, ms(200));
    assert_eq!(sent(&mut producer, ms(250)), [BEGIN]);
}

#[test]
fn what_the_master_may_not_have_heard_is_sent_again_on_the_next_bus() {
    // Begin acknowledged, and the master heard after it: it knows.
    let mut producer = producer(0);
    raise(&mut producer);
    assert_eq!(sent(&mut producer, ms(0)), [BEGIN]);
    producer.confirm();
    producer.on_bus_changed();
    assert_eq!(sent(&mut producer, ms(1)), [[0; 8]; 0]);
    // The end was acknowledged, but not by the master as far as the node can know.
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(2)), [END]);
    producer.on_bus_changed();
    assert_eq!(sent(&mut producer, ms(3)), [END]);
    producer.confirm();
    producer.on_bus_changed();
    assert_eq!(sent(&mut producer, ms(4)), [[0; 8]; 0]);
    // Neither may have been heard: both, in order.
    raise(&mut producer);
    assert_eq!(sent(&mut producer, ms(5)), [BEGIN]);
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(6)), [END]);
    producer.on_bus_changed();
    assert_eq!(sent(&mut producer, ms(7)), [BEGIN, END]);
    // The bus is left while it has the message.
    raise(&mut producer);
    assert!(producer.poll(ms(8), OPERATIONAL).is_some());
    producer.recall(Instant::ZERO);
    assert_eq!(sent(&mut producer, ms(8)), [BEGIN]);
}

/// Given several errors whose messages wait, then the one that was raised last goes first, and now; also one that was there before.
#[test]
fn newest_error_can_be_hastened() {
    let mut producer = producer(100);
    raise(&mut producer);
    assert_eq!(sent(&mut producer, ms(0)), [BEGIN]);
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(100)), [END]);
    for code in [0x1000, 0x1001, 0x1002] {
        assert!(producer.raise(ErrorCode::new(code), [0; 5]));
    }
    raise(&mut producer);
    producer.hasten();
    assert_eq!(sent(&mut producer, ms(101)), [BEGIN]);
    assert_eq!(sent(&mut producer, ms(102)), [[0; 8]; 0], "the others wait");
}

/// Verifies: ECSS 6.4a.2
#[test]
fn error_that_was_over_at_once_is_reported_with_its_end() {
    let mut producer = producer(0);
    let overrun = |producer: &mut Producer| producer.report(ErrorCode::CAN_OVERRUN, [2, 0, 0, 0, 0]);
    assert!(overrun(&mut producer));
    assert!(!overrun(&mut producer), "its messages wait");
    let both = [[0x10, 0x81, 0x11, 2, 0, 0, 0, 0], [0, 0, 0, 0x10, 0x81, 2, 0, 0]];
    assert_eq!(producer.register().bits(), 0);
    assert_eq!(sent(&mut producer, ms(0)), both);
    assert!(overrun(&mut producer));
    assert_eq!(ended(&mut producer, ms(1), false), both[..1]);
    assert_eq!(sent(&mut producer, ms(51)), both);
    producer.on_bus_changed();
    assert_eq!(sent(&mut producer, ms(52)), both);
    assert_eq!(producer.history().len(), 1);
    // Without a COB-ID the history alone has it.
    let mut silent = Producer::new(Config { id: None, inhibit: Duration::ZERO });
    assert!(overrun(&mut silent));
    silent.configure(Config { id: CobId::new(0x085), inhibit: Duration::ZERO });
    assert_eq!(sent(&mut silent, ms(0)), [[0; 8]; 0]);
    assert_eq!(silent.history().len(), 1);
}

#[test]
fn errors_take_turns() {
    let mut producer = producer(100);
    raise(&mut producer);
    assert!(producer.raise(ErrorCode::VOLTAGE, [0; 5]));
    assert_eq!(sent(&mut producer, ms(0))[0][1], 0x42);
    // The first error has a message to send again; the second one still has its first.
    clear(&mut producer);
    assert_eq!(sent(&mut producer, ms(100))[0][1], 0x30);
    assert_eq!(sent(&mut producer, ms(200))[0], [0, 0, 0x05, 0x00, 0x42, 1, 0, 0]);
}

/// Verifies: ECSS 6.4a.2, 6.4b
/// Notices: ECSS 6.4b: two names of error codes have the code of each other.
#[test]
fn every_error_code_of_cia_301_is_there_and_sets_its_bits() {
    const GENERIC: u8 = 0x01;
    let table = [
        (ErrorCode::NO_ERROR, 0x0000, 0),
        (ErrorCode::GENERIC, 0x1000, GENERIC),
        (ErrorCode::CURRENT, 0x2000, 0x03),
        (ErrorCode::CURRENT_INPUT, 0x2100, 0x03),
        (ErrorCode::CURRENT_INSIDE, 0x2200, 0x03),
        (ErrorCode::CURRENT_OUTPUT, 0x2300, 0x03),
        (ErrorCode::VOLTAGE, 0x3000, 0x05),
        (ErrorCode::VOLTAGE_MAINS, 0x3100, 0x05),
        (ErrorCode::VOLTAGE_INSIDE, 0x3200, 0x05),
        (ErrorCode::VOLTAGE_OUTPUT, 0x3300, 0x05),
        (ErrorCode::TEMPERATURE, 0x4000, 0x09),
        (ErrorCode::TEMPERATURE_AMBIENT, 0x4100, 0x09),
        (ErrorCode::TEMPERATURE_DEVICE, 0x4200, 0x09),
        (ErrorCode::HARDWARE, 0x5000, GENERIC),
        (ErrorCode::SOFTWARE, 0x6000, GENERIC),
        (ErrorCode::SOFTWARE_INTERNAL, 0x6100, GENERIC),
        (ErrorCode::SOFTWARE_USER, 0x6200, GENERIC),
        (ErrorCode::DATA_SET, 0x6300, GENERIC),
        (ErrorCode::MODULES, 0x7000, GENERIC),
        (ErrorCode::MONITORING, 0x8000, GENERIC),
        (ErrorCode::COMMUNICATION, 0x8100, 0x11),
        (ErrorCode::CAN_OVERRUN, 0x8110, 0x11),
        (ErrorCode::CAN_PASSIVE, 0x8120, 0x11),
        (ErrorCode::HEARTBEAT, 0x8130, 0x11),
        (ErrorCode::BUS_OFF_RECOVERED, 0x8140, 0x11),
        (ErrorCode::CAN_ID_COLLISION, 0x8150, 0x11),
        (ErrorCode::PROTOCOL, 0x8200, 0x11),
        (ErrorCode::PDO_LENGTH, 0x8210, 0x11),
        (ErrorCode::PDO_LENGTH_EXCEEDED, 0x8220, 0x11),
        (ErrorCode::MPDO_DESTINATION, 0x8230, 0x11),
        (ErrorCode::SYNC_LENGTH, 0x8240, 0x11),
        (ErrorCode::RPDO_TIMEOUT, 0x8250, 0x11),
        (ErrorCode::EXTERNAL, 0x9000, GENERIC),
        (ErrorCode::ADDITIONAL_FUNCTIONS, 0xF000, 0x21),
        (ErrorCode::DEVICE_SPECIFIC, 0xFF00, 0x81),
    ];
    assert_eq!(
        ErrorCode::ALL.iter().map(|code| code.get()).collect::<Vec<_>>(),
        table.map(|(_, raw, _)| raw)
    );
    for (code, raw, bits) in table {
        assert_eq!(code.get(), raw);
        assert_eq!(ErrorCode::new(raw).get(), raw);
        assert_eq!(ErrorRegister::of(ErrorCode::new(raw)).bits(), bits, "{raw:04X}");
        // The low byte is the device's to define.
        if raw & 0xFF == 0 {
            assert_eq!(ErrorRegister::of(ErrorCode::new(raw | 0x0F)).bits(), bits, "{raw:04X}");
        }
    }
}

/// Given a producer, when the application raises any error code of CiA 301 but 0000h, then a message with this code goes out, octets
/// from the lowest one on, and 1003h has the code.
///
/// Verifies: ECSS 6.4a.2, 6.4b
/// Notices: ECSS 6.4b: a code whose lower octet is zero is taken for "no error" and not sent.
#[test]
fn every_error_code_of_cia_301_is_sent_and_remembered() {
    for code in ErrorCode::ALL.iter().copied().filter(|code| *code != ErrorCode::NO_ERROR) {
        let mut producer = producer(0);
        assert!(producer.raise(code, [7, 0, 0, 0, 0]), "{code:?}");
        let [low, high] = code.get().to_le_bytes();
        assert_eq!(sent(&mut producer, ms(0))[0][..2], [low, high], "{code:?}");
        assert_eq!(producer.history().read(1), Ok(7 << 16 | u32::from(code.get())));
    }
}

#[test]
fn the_bits_of_the_error_register() {
    use ErrorRegister as R;
    let bits =
        [R::GENERIC, R::CURRENT, R::VOLTAGE, R::TEMPERATURE, R::COMMUNICATION, R::PROFILE, R::MANUFACTURER];
    assert_eq!(bits.map(R::bits), [0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x80]);
    assert!(R::from_bits(0x13).contains(R::COMMUNICATION.and(R::GENERIC)));
    assert!(!R::from_bits(0x03).contains(R::COMMUNICATION));
}

/// Verifies: ECSS 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a: an error that is gone already is ended again.
/// Notices: ECSS 6.4a.2: the octets of the error code are swapped.
#[test]
fn an_error_is_told_once_and_so_is_its_end() {
    let mut producer = producer(0);
    assert!(sent(&mut producer, ms(1)).is_empty());
    assert!(producer.raise(ErrorCode::CAN_PASSIVE, [1, 2, 3, 4, 5]));
    assert!(!producer.raise(ErrorCode::CAN_PASSIVE, [1, 9, 9, 9, 9]));
    assert_eq!(sent(&mut producer, ms(2)), [[0x20, 0x81, 0x11, 1, 2, 3, 4, 5]]);
    assert_eq!(producer.register().bits(), 0x11);
    assert!(producer.clear(ErrorCode::CAN_PASSIVE, 1));
    assert!(!producer.clear(ErrorCode::CAN_PASSIVE, 1));
    assert_eq!(sent(&mut producer, ms(3)), [[0, 0, 0, 0x20, 0x81, 1, 0, 0]]);
    assert_eq!(producer.register().bits(), 0);
    // The next time it is news again.
    assert!(producer.raise(ErrorCode::CAN_PASSIVE, [1, 0, 0, 0, 0]));
    assert_eq!(sent(&mut producer, ms(4)), [[0x20, 0x81, 0x11, 1, 0, 0, 0, 0]]);
}

/// Verifies: ECSS 6.4a.2
#[test]
fn register_shows_remaining_errors_when_one_of_several_is_gone() {
    let mut producer = producer(0);
    producer.raise(ErrorCode::VOLTAGE_MAINS, [0; 5]);
    producer.raise(ErrorCode::TEMPERATURE_DEVICE, [0; 5]);
    producer.raise(ErrorCode::new(0x3101), [0; 5]);
    assert_eq!(producer.register().bits(), 0x0D);
    sent(&mut producer, ms(1));
    for (code, end) in [
        (ErrorCode::TEMPERATURE_DEVICE, [0, 0, 0x05, 0x00, 0x42, 0, 0, 0]),
        (ErrorCode::VOLTAGE_MAINS, [0, 0, 0x05, 0x00, 0x31, 0, 0, 0]),
        (ErrorCode::new(0x3101), [0, 0, 0, 0x01, 0x31, 0, 0, 0]),
    ] {
        producer.clear(code, 0);
        assert_eq!(sent(&mut producer, ms(2)), [end]);
    }
}

#[test]
fn errors_of_two_sources_are_two_errors() {
    let mut producer = producer(0);
    assert!(producer.raise(ErrorCode::HEARTBEAT, [3, 0, 0, 0, 0]));
    assert!(producer.raise(ErrorCode::HEARTBEAT, [4, 0, 0, 0, 0]));
    assert!(producer.clear(ErrorCode::HEARTBEAT, 3));
    assert_eq!(producer.register().bits(), 0x11);
    assert!(producer.clear(ErrorCode::HEARTBEAT, 4));
    assert_eq!(producer.register().bits(), 0);
}

/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a.1: a message with code 0000h is sent though no error ended.
#[test]
fn no_error_is_no_error() {
    let mut producer = producer(0);
    assert!(!producer.raise(ErrorCode::NO_ERROR, [1, 2, 3, 4, 5]));
    assert!(!producer.clear(ErrorCode::NO_ERROR, 0));
    assert!(sent(&mut producer, ms(1)).is_empty());
    assert!(producer.history().is_empty());
}

#[test]
fn the_inhibit_time_delays_and_loses_nothing() {
    let mut producer = producer(50);
    for code in [0x1000, 0x2000, 0x3000] {
        producer.raise(ErrorCode::new(code), [0; 5]);
    }
    // The register is that of the instant at which a message goes out.
    assert_eq!(sent(&mut producer, ms(100)), [[0x00, 0x10, 0x07, 0, 0, 0, 0, 0]]);
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(150)));
    assert!(sent(&mut producer, ms(149)).is_empty());
    assert_eq!(sent(&mut producer, ms(150)), [[0x00, 0x20, 0x07, 0, 0, 0, 0, 0]]);
    // Polled late: the time counts from there.
    assert_eq!(sent(&mut producer, ms(230)), [[0x00, 0x30, 0x07, 0, 0, 0, 0, 0]]);
    assert_eq!(producer.deadline(OPERATIONAL), None);
    producer.raise(ErrorCode::EXTERNAL, [0; 5]);
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(280)));
    assert_eq!(producer.lost(), 0);
}

#[test]
fn a_new_inhibit_time_counts_from_the_last_message() {
    let mut producer = producer(50);
    raise(&mut producer);
    assert_eq!(sent(&mut producer, ms(100)), [BEGIN]);
    clear(&mut producer);
    let id = Some(CobId::emcy(node(5)));
    producer.configure(Config { id, inhibit: Duration::from_millis(10) });
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(110)));
    producer.configure(Config { id, inhibit: Duration::from_millis(500) });
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(600)));
}

#[test]
fn more_errors_than_places_are_counted_and_in_the_history() {
    let mut producer = producer(0);
    for number in 0..16 {
        assert!(producer.raise(ErrorCode::new(0x1000 + number), [0; 5]));
    }
    assert_eq!(producer.lost(), 0);
    assert!(producer.raise(ErrorCode::TEMPERATURE, [0; 5]));
    assert_eq!((producer.lost(), producer.history().read(1)), (1, Ok(0x4000)));
    assert_eq!(producer.register().bits(), 0x01);
    assert!(!producer.clear(ErrorCode::TEMPERATURE, 0));
    assert_eq!(sent(&mut producer, ms(1)).len(), 16);
    // One that is over makes room, even before the master was heard.
    assert!(producer.clear(ErrorCode::new(0x1007), 0));
    assert_eq!(sent(&mut producer, ms(2)).len(), 1);
    assert!(producer.raise(ErrorCode::TEMPERATURE, [0; 5]));
    assert_eq!(producer.register().bits(), 0x09);
    assert_eq!(sent(&mut producer, ms(3)), [[0x00, 0x40, 0x09, 0, 0, 0, 0, 0]]);
    assert_eq!(producer.lost(), 1);
}

/// Verifies: ECSS 6.5.4a
#[test]
fn emergencies_wait_for_a_state_that_allows_them() {
    let mut producer = producer(0);
    producer.raise(ErrorCode::GENERIC, [0; 5]);
    for state in [NmtState::Initialising, NmtState::Stopped] {
        assert_eq!(producer.deadline(state), None);
        assert_eq!(producer.poll(ms(10), state), None);
    }
    assert!(producer.deadline(NmtState::PreOperational).is_some_and(|due| due <= ms(10)));
    assert_eq!(
        producer.poll(ms(10), NmtState::PreOperational),
        Some(frame(0x085, &[0x00, 0x10, 0x01, 0, 0, 0, 0, 0]))
    );
}

/// Verifies: ECSS 6.10a, 6.10c
#[test]
fn without_a_valid_cob_id_only_register_and_history_go_on() {
    let mut producer = producer(0);
    producer.raise(ErrorCode::GENERIC, [0; 5]);
    producer.configure(Config { id: None, inhibit: Duration::ZERO });
    producer.raise(ErrorCode::CURRENT, [0; 5]);
    assert_eq!(producer.poll(ms(1), OPERATIONAL), None);
    assert_eq!(producer.history().len(), 2);
    assert_eq!(producer.register().bits(), 0x03);
    // Valid again, with another identifier: the node reports there the errors that are still active.
    assert!(producer.clear(ErrorCode::GENERIC, 0));
    producer.configure(Config { id: CobId::new(0x0F0), inhibit: Duration::ZERO });
    assert_eq!(producer.poll(ms(2), OPERATIONAL), Some(frame(0x0F0, &[0x00, 0x20, 0x03, 0, 0, 0, 0, 0])));
    assert_eq!(producer.poll(ms(2), OPERATIONAL), None);
    assert_eq!(producer.lost(), 0);
}

/// Verifies: ECSS 6.4a.2, 6.10m
#[test]
fn emergencies_of_any_node_are_understood() {
    let data = [0x30, 0x81, 0x11, 7, 0xAA, 0xBB, 0xCC, 0xDD];
    let emergency = Emergency {
        code: ErrorCode::HEARTBEAT,
        register: ErrorRegister::from_bits(0x11),
        info: [7, 0xAA, 0xBB, 0xCC, 0xDD],
    };
    for id in [0x081, 0x0FF] {
        let from = node((id - 0x080) as u8);
        assert_eq!(Emergency::decode(&frame(id, &data)), Some((from, emergency)));
        assert_eq!(emergency.encode(CobId::emcy(from)), frame(id, &data));
    }
}

#[test]
fn malformed_emergencies_are_none() {
    for length in 0..8 {
        assert_eq!(Emergency::decode(&frame(0x085, &[0; 8][..length])), None, "{length} bytes");
    }
    // SYNC, and a PDO.
    assert_eq!(Emergency::decode(&frame(0x080, &[0; 8])), None);
    assert_eq!(Emergency::decode(&frame(0x185, &[0; 8])), None);
}

#[test]
fn end_of_an_error_names_it() {
    let end = Emergency {
        code: ErrorCode::NO_ERROR,
        register: ErrorRegister::default(),
        info: [0x00, 0x42, 7, 0, 0],
    };
    assert_eq!(end.ended(), Some((ErrorCode::TEMPERATURE_DEVICE, 7)));
    assert_eq!(Emergency { code: ErrorCode::TEMPERATURE_DEVICE, ..end }.ended(), None);
    // A node of another make gives no code.
    assert_eq!(Emergency { info: [0; 5], ..end }.ended(), None);
}

/// The master's end of two buses: it hears what is acknowledged, unless its bus is cut.
#[derive(Default)]
struct Listener {
    heard: BTreeSet<(u16, u8)>,
    /// Errors whose beginning a node acknowledged.
    told: BTreeSet<(u16, u8)>,
    is_cut: bool,
}

impl Listener {
    fn on_message(&mut self, data: &[u8]) -> Result<(), TestCaseError> {
        let &[low, high, _, a, b, c, ..] = data else { return Err(TestCaseError::fail("length")) };
        let code = u16::from_le_bytes([low, high]);
        if code == 0 {
            let error = (u16::from_le_bytes([a, b]), c);
            prop_assert!(self.told.contains(&error), "an end alone");
            if !self.is_cut {
                self.heard.remove(&error);
            }
        } else {
            self.told.insert((code, a));
            if !self.is_cut {
                self.heard.insert((code, a));
            }
        }
        Ok(())
    }
}

/// What happens around a producer.
#[derive(Clone, Copy, Debug)]
enum Step {
    Raise(u16, u8),
    Clear(u16, u8),
    /// The producer hands out this number of frames. A node acknowledges all of them, or none.
    Send(u8, bool),
    /// The bus is cut next to the master: another node still acknowledges.
    Cut,
    /// Master and node meet on the other bus.
    Meet,
    /// The master's heartbeat, unless the bus is cut.
    Heartbeat,
}

fn step() -> impl Strategy<Value = Step> {
    let error = || (prop::sample::select(vec![0x1000, 0x2310, 0x4200, 0x8130]), 0..3_u8);
    prop_oneof![
        4 => error().prop_map(|(code, source)| Step::Raise(code, source)),
        4 => error().prop_map(|(code, source)| Step::Clear(code, source)),
        4 => (1..4_u8, any::<bool>()).prop_map(|(number, is_acknowledged)| Step::Send(number, is_acknowledged)),
        1 => Just(Step::Cut),
        1 => Just(Step::Meet),
        2 => Just(Step::Heartbeat),
    ]
}

proptest! {
    #![proptest_config(cases(256))]

    /// Verifies: ECSS 6.4a.1
    #[test]
    fn after_the_last_fault_the_master_knows_what_is_active(steps in prop::collection::vec(step(), 0..120)) {
        let mut producer = producer(10);
        let mut listener = Listener::default();
        let (mut active, mut now) = (BTreeSet::new(), 0);
        let end = [Step::Meet, Step::Send(40, true), Step::Heartbeat];
        for step in steps.into_iter().chain(end) {
            match step {
                Step::Raise(code, source) => {
                    prop_assert_eq!(producer.raise(ErrorCode::new(code), [source, 1, 2, 3, 4]), active.insert((code, source)));
                }
                Step::Clear(code, source) => {
                    prop_assert_eq!(producer.clear(ErrorCode::new(code), source), active.remove(&(code, source)));
                }
                Step::Send(number, is_acknowledged) => {
                    for _ in 0..number {
                        now += 10;
                        let Some(frame) = producer.poll(ms(now), OPERATIONAL) else { continue };
                        prop_assert!(producer.poll(ms(now + 9), OPERATIONAL).is_none(), "inhibit time");
                        if is_acknowledged {
                            listener.on_message(frame.data())?;
                        }
                        producer.on_end(&frame, is_acknowledged, ms(now));
                    }
                    now += 50;
                }
                Step::Cut => listener.is_cut = true,
                Step::Meet => {
                    listener.is_cut = false;
                    producer.recall(Instant::ZERO);
                    producer.on_bus_changed();
                }
                Step::Heartbeat if listener.is_cut => {}
                Step::Heartbeat => producer.confirm(),
            }
            let bits = active.iter().map(|(code, _)| ErrorRegister::of(ErrorCode::new(*code)));
            prop_assert_eq!(producer.register(), bits.fold(ErrorRegister::default(), ErrorRegister::and));
        }
        prop_assert_eq!(listener.heard, active);
        prop_assert_eq!((producer.lost(), producer.deadline(OPERATIONAL)), (0, None));
    }
}
