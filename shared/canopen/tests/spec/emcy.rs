//! Emergency object: codes, register, history, producer, decoding.

use std::collections::BTreeSet;

use async_canopen::emcy::{Config, Emergency, ErrorCode, ErrorRegister, Producer};
use async_canopen::types::{AbortCode, CobId, Duration, Instant, NmtState};

use proptest::prelude::*;

use crate::bench::{frame, ms, node};
use crate::random::cases;

const OPERATIONAL: NmtState = NmtState::Operational;

fn producer(inhibit_ms: u64) -> Producer {
    Producer::new(Config { id: Some(CobId::emcy(node(5))), inhibit: Duration::from_millis(inhibit_ms) })
}

#[test]
fn its_objects_configure_a_producer() {
    let inhibit = Duration::from_micros(1_500);
    assert_eq!(Config::new(0x0000_0085, 15), Config { id: CobId::new(0x085), inhibit });
    assert_eq!(Config::new(0x8000_0085, 15), Config { id: None, inhibit });
    assert_eq!(Config::new(0x2000_0085, u16::MAX).inhibit, Duration::from_micros(6_553_500));
    assert_eq!(Config::new(0x2000_0085, 0).id, None);
}

/// Everything that may go out at `now`.
fn sent(producer: &mut Producer, now: Instant) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| producer.poll(now, OPERATIONAL)).map(|frame| frame.data().to_vec()).collect()
}

/// "No error" answers a message that was sent, or waits before it.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn the_end_of_an_error_that_was_not_sent_is_not_sent() {
    let valid = Config { id: Some(CobId::emcy(node(5))), inhibit: Duration::ZERO };
    let invalid = Config { id: None, ..valid };
    let heartbeat = |producer: &mut Producer| producer.raise(ErrorCode::HEARTBEAT, [7, 0, 0, 0, 0]);
    // Raised while there is no COB-ID.
    let mut silent = Producer::new(invalid);
    assert!(heartbeat(&mut silent));
    silent.configure(valid);
    assert!(silent.clear(ErrorCode::HEARTBEAT, 7), "it was active");
    assert_eq!(sent(&mut silent, ms(0)), [[0; 8]; 0]);
    // The next one is sent, and its end.
    assert!(heartbeat(&mut silent));
    assert!(silent.clear(ErrorCode::HEARTBEAT, 7));
    assert_eq!(sent(&mut silent, ms(1)).len(), 2);
    // Dropped while it waited.
    let mut dropped = Producer::new(valid);
    assert!(heartbeat(&mut dropped));
    dropped.configure(invalid);
    dropped.configure(valid);
    assert!(dropped.clear(ErrorCode::HEARTBEAT, 7));
    assert_eq!(sent(&mut dropped, ms(0)), [[0; 8]; 0]);
    // Lost in a full queue.
    let mut full = Producer::new(valid);
    for source in 0..8 {
        assert!(full.raise(ErrorCode::PDO_LENGTH, [source, 0, 0, 0, 0]));
    }
    assert!(heartbeat(&mut full));
    assert_eq!(full.lost(), 1);
    assert_eq!(sent(&mut full, ms(0)).len(), 8);
    assert!(full.clear(ErrorCode::HEARTBEAT, 7));
    assert_eq!(sent(&mut full, ms(1)), [[0; 8]; 0]);
    assert!(full.clear(ErrorCode::PDO_LENGTH, 3));
    assert_eq!(sent(&mut full, ms(2)), [[0, 0, 0x11, 0x10, 0x82, 3, 0, 0]]);
}

/// Verifies: ECSS 6.4a.2, 6.4b
#[test]
fn every_error_code_of_cia_301_is_there_and_sets_its_bits() {
    const GENERIC: u8 = 0x01;
    let table = [
        (0x0000, 0),
        (0x1000, GENERIC),
        (0x2000, 0x03),
        (0x2100, 0x03),
        (0x2200, 0x03),
        (0x2300, 0x03),
        (0x3000, 0x05),
        (0x3100, 0x05),
        (0x3200, 0x05),
        (0x3300, 0x05),
        (0x4000, 0x09),
        (0x4100, 0x09),
        (0x4200, 0x09),
        (0x5000, GENERIC),
        (0x6000, GENERIC),
        (0x6100, GENERIC),
        (0x6200, GENERIC),
        (0x6300, GENERIC),
        (0x7000, GENERIC),
        (0x8000, GENERIC),
        (0x8100, 0x11),
        (0x8110, 0x11),
        (0x8120, 0x11),
        (0x8130, 0x11),
        (0x8140, 0x11),
        (0x8150, 0x11),
        (0x8200, 0x11),
        (0x8210, 0x11),
        (0x8220, 0x11),
        (0x8230, 0x11),
        (0x8240, 0x11),
        (0x8250, 0x11),
        (0x9000, GENERIC),
        (0xF000, 0x21),
        (0xFF00, 0x81),
    ];
    assert_eq!(ErrorCode::ALL.iter().map(|code| code.get()).collect::<Vec<_>>(), table.map(|(code, _)| code));
    for (raw, bits) in table {
        assert_eq!(ErrorCode::new(raw).get(), raw);
        assert_eq!(ErrorRegister::of(ErrorCode::new(raw)).bits(), bits, "{raw:04X}");
        // The low byte is the device's to define.
        if raw & 0xFF == 0 {
            assert_eq!(ErrorRegister::of(ErrorCode::new(raw | 0x0F)).bits(), bits, "{raw:04X}");
        }
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

/// Verifies: ECSS 6.4a, 6.4a.1, 6.4a.2
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
    producer.clear(ErrorCode::TEMPERATURE_DEVICE, 0);
    producer.clear(ErrorCode::VOLTAGE_MAINS, 0);
    producer.clear(ErrorCode::new(0x3101), 0);
    assert_eq!(
        sent(&mut producer, ms(2)),
        [
            [0, 0, 0x05, 0x00, 0x42, 0, 0, 0],
            [0, 0, 0x05, 0x00, 0x31, 0, 0, 0],
            [0, 0, 0, 0x01, 0x31, 0, 0, 0]
        ]
    );
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

#[test]
fn no_error_is_no_error() {
    let mut producer = producer(0);
    assert!(!producer.raise(ErrorCode::NO_ERROR, [1, 2, 3, 4, 5]));
    assert!(!producer.clear(ErrorCode::NO_ERROR, 0));
    assert!(sent(&mut producer, ms(1)).is_empty());
    assert!(producer.history().is_empty());
}

#[test]
fn the_history_has_the_newest_error_first_and_forgets_on_zero() {
    let mut producer = producer(0);
    assert_eq!(producer.history().read(1), Err(AbortCode::NoData));
    for detail in 1..=3 {
        producer.raise(ErrorCode::new(0x1000 + u16::from(detail)), [detail, 0xAB, 0xCD, 0, 0]);
    }
    producer.clear(ErrorCode::new(0x1002), 2);
    assert_eq!(producer.history().len(), 3);
    assert_eq!(producer.history().read(1), Ok(0xAB03_1003));
    assert_eq!(producer.history().read(2), Ok(0xAB02_1002));
    assert_eq!(producer.history().read(3), Ok(0xAB01_1001));
    assert_eq!(producer.history().read(4), Err(AbortCode::NoData));
    assert_eq!(producer.history().read(8), Err(AbortCode::NoData));
    assert_eq!(producer.history().read(9), Err(AbortCode::NoSubIndex));
    assert_eq!(producer.history().read(0), Err(AbortCode::NoSubIndex));
    assert_eq!(producer.history_mut().write_len(1), Err(AbortCode::ValueRange));
    assert_eq!(producer.history().len(), 3);
    assert_eq!(producer.history_mut().write_len(0), Ok(()));
    assert!(producer.history().is_empty());
    assert_eq!(producer.history().read(1), Err(AbortCode::NoData));
    // Errors go on being active.
    assert_eq!(producer.register().bits(), 0x01);
}

#[test]
fn the_oldest_error_leaves_a_full_history() {
    let mut producer = producer(0);
    for number in 1..=10 {
        producer.raise(ErrorCode::new(0xFF00 + number), [0; 5]);
    }
    assert_eq!(producer.history().len(), 8);
    assert_eq!(producer.history().read(1), Ok(0xFF0A));
    assert_eq!(producer.history().read(8), Ok(0xFF03));
}

#[test]
fn the_inhibit_time_delays_and_loses_nothing() {
    let mut producer = producer(50);
    for code in [0x1000, 0x2000, 0x3000] {
        producer.raise(ErrorCode::new(code), [0; 5]);
    }
    assert_eq!(sent(&mut producer, ms(100)), [[0x00, 0x10, 0x01, 0, 0, 0, 0, 0]]);
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(150)));
    assert!(sent(&mut producer, ms(149)).is_empty());
    assert_eq!(sent(&mut producer, ms(150)), [[0x00, 0x20, 0x03, 0, 0, 0, 0, 0]]);
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
    producer.raise(ErrorCode::GENERIC, [0; 5]);
    producer.poll(ms(100), OPERATIONAL);
    producer.clear(ErrorCode::GENERIC, 0);
    let id = Some(CobId::emcy(node(5)));
    producer.configure(Config { id, inhibit: Duration::from_millis(10) });
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(110)));
    producer.configure(Config { id, inhibit: Duration::from_millis(500) });
    assert_eq!(producer.deadline(OPERATIONAL), Some(ms(600)));
}

#[test]
fn full_queue_counts_the_message_and_history_has_its_error() {
    let mut producer = producer(1_000);
    for number in 1..=10 {
        assert!(producer.raise(ErrorCode::new(0xFF00 + number), [0; 5]));
    }
    assert_eq!(producer.lost(), 2);
    assert_eq!(producer.history().read(1), Ok(0xFF0A));
    let mut told = vec![];
    for second in 1..=20 {
        told.extend(sent(&mut producer, ms(1_000 * second)).iter().map(|data| data[0]));
    }
    assert_eq!(told, [1, 2, 3, 4, 5, 6, 7, 8]);
}

#[test]
fn more_errors_than_places_are_still_told() {
    let mut producer = producer(0);
    for number in 0..16 {
        producer.raise(ErrorCode::new(0x1000 + number), [0; 5]);
        sent(&mut producer, ms(1));
    }
    assert!(producer.raise(ErrorCode::TEMPERATURE, [0; 5]));
    assert_eq!(sent(&mut producer, ms(2)), [[0x00, 0x40, 0x09, 0, 0, 0, 0, 0]]);
    assert_eq!(producer.history().read(1), Ok(0x4000));
    assert_eq!(producer.register().bits(), 0x01);
    assert!(!producer.clear(ErrorCode::TEMPERATURE, 0));
    // A place that falls free is taken again.
    assert!(producer.clear(ErrorCode::new(0x1007), 0));
    assert!(producer.raise(ErrorCode::TEMPERATURE, [0; 5]));
    assert_eq!(producer.register().bits(), 0x09);
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

#[test]
fn without_a_valid_cob_id_only_register_and_history_go_on() {
    let mut producer = producer(0);
    producer.raise(ErrorCode::GENERIC, [0; 5]);
    producer.configure(Config { id: None, inhibit: Duration::ZERO });
    producer.raise(ErrorCode::CURRENT, [0; 5]);
    assert_eq!(producer.poll(ms(1), OPERATIONAL), None);
    assert_eq!(producer.history().len(), 2);
    assert_eq!(producer.register().bits(), 0x03);
    // Valid again, with another identifier: what is new is told there, what is old is not.
    producer.configure(Config { id: CobId::new(0x0F0), inhibit: Duration::ZERO });
    producer.raise(ErrorCode::VOLTAGE, [0; 5]);
    assert_eq!(producer.poll(ms(2), OPERATIONAL), Some(frame(0x0F0, &[0x00, 0x30, 0x07, 0, 0, 0, 0, 0])));
    assert_eq!(producer.poll(ms(2), OPERATIONAL), None);
    assert_eq!(producer.lost(), 0);
}

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

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn every_change_is_told_in_order_or_counted(
        steps in prop::collection::vec((any::<bool>(), 0..6_usize, 0..3_u8, 0..40_u64), 0..120),
    ) {
        let codes = [0x1000, 0x2310, 0x3111, 0x4200, 0x8130, 0xFF07];
        let bits = [0x01, 0x03, 0x05, 0x09, 0x11, 0x81];
        let mut producer = producer(10);
        let mut active = BTreeSet::new();
        let (mut changes, mut told, mut now, mut last) = (vec![], vec![], 0, None);
        for (appears, kind, source, wait) in steps {
            now += wait;
            let code = ErrorCode::new(codes[kind]);
            let news = if appears { active.insert((kind, source)) } else { active.remove(&(kind, source)) };
            // At most 16 can be known as active.
            prop_assume!(active.len() <= 16);
            let lost = producer.lost();
            let accepted = if appears {
                producer.raise(code, [source, 1, 2, 3, 4])
            } else {
                producer.clear(code, source)
            };
            prop_assert_eq!(accepted, news);
            let register = active.iter().fold(0, |register, (kind, _)| register | bits[*kind]);
            prop_assert_eq!(producer.register().bits(), register);
            if news && producer.lost() == lost {
                changes.push((if appears { codes[kind] } else { 0 }, register));
            }
            while let Some(frame) = producer.poll(ms(now), OPERATIONAL) {
                prop_assert!(last.is_none_or(|last| now >= last + 10), "inhibit time");
                last = Some(now);
                let data = frame.data();
                told.push((u16::from_le_bytes([data[0], data[1]]), data[2]));
            }
        }
        for second in 1..=8 {
            if let Some(frame) = producer.poll(ms(now + 1_000 * second), OPERATIONAL) {
                told.push((u16::from_le_bytes([frame.data()[0], frame.data()[1]]), frame.data()[2]));
            }
        }
        prop_assert_eq!(told, changes);
    }
}
