//! History of errors, object 1003h.
//!
//! Verifies: ECSS 6.4a

use async_canopen::emcy::ErrorCode;
use async_canopen::emcy::machine::{Config, Producer};
use async_canopen::types::{AbortCode, Duration};

fn producer() -> Producer {
    Producer::new(Config { id: None, inhibit: Duration::ZERO })
}

#[test]
fn the_history_has_the_newest_error_first_and_forgets_on_zero() {
    let mut producer = producer();
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

/// Given a history of eight places, when ten errors come, then it has the last eight, the newest first.
///
/// Verifies: ECSS 11.1b
/// Notices: ECSS 11.1b: the last place of 1003h is never filled.
#[test]
fn the_oldest_error_leaves_a_full_history() {
    let mut producer = producer();
    for number in 1..=10 {
        producer.raise(ErrorCode::new(0xFF00 + number), [0; 5]);
    }
    assert_eq!(producer.history().len(), 8);
    assert_eq!(producer.history().read(1), Ok(0xFF0A));
    assert_eq!(producer.history().read(8), Ok(0xFF03));
}

/// Given an error that is active, when two others come and go a hundred times, then the history has each once, the newest first: a
/// master finds the one that is active.
#[test]
fn an_error_that_comes_and_goes_displaces_no_other_one() {
    let mut producer = producer();
    producer.raise(ErrorCode::TEMPERATURE_DEVICE, [1, 0, 0, 0, 0]);
    for _ in 0..100 {
        for (code, source) in [(ErrorCode::CAN_PASSIVE, 0), (ErrorCode::CAN_PASSIVE, 1)] {
            producer.raise(code, [source, 0, 0, 0, 0]);
            producer.clear(code, source);
        }
    }
    let entries: Vec<u32> =
        (1..=producer.history().len()).map(|sub| producer.history().read(sub).unwrap()).collect();
    assert_eq!(entries, [0x0001_8120, 0x0000_8120, 0x0001_4200]);
}
