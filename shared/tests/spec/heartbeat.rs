//! Heartbeat, boot-up, SYNC and the periodic timer under them.

use ecss_can::heartbeat::{self, Consumer};
use ecss_can::nmt::NmtState;
use ecss_can::sync;
use ecss_can::time::{Duration, Instant, Periodic};

use crate::bench::{frame, ms, node, span};

#[test]
fn a_periodic_timer_keeps_its_grid() {
    let mut timer = Periodic::new(span(100));
    assert!(!timer.due(ms(1_000)));
    timer.start(ms(10));
    assert!(timer.due(ms(10)));
    assert!(!timer.due(ms(109)));
    assert!(timer.due(ms(117)));
    assert_eq!(timer.deadline(), Some(ms(210)));
    // Far behind: one event, the points in between are skipped.
    assert!(timer.due(ms(555)));
    assert_eq!(timer.deadline(), Some(ms(610)));
    timer.restart(ms(700));
    assert_eq!(timer.deadline(), Some(ms(800)));
    timer.stop();
    assert_eq!(timer.deadline(), None);
}

#[test]
fn a_period_of_zero_never_starts() {
    let mut timer = Periodic::new(Duration::ZERO);
    timer.start(ms(1));
    assert_eq!(timer.deadline(), None);
    assert!(!timer.due(ms(2)));
}

/// Verifies: ECSS 6.5.2a, 6.5.3a
#[test]
fn heartbeat_and_boot_up_on_the_wire() {
    assert_eq!(heartbeat::encode(node(4), NmtState::Operational), frame(0x704, &[0x05]));
    assert_eq!(heartbeat::encode(node(4), NmtState::Initialising), frame(0x704, &[0x00]));
    assert_eq!(heartbeat::decode(&frame(0x701, &[0x7F])), Some(NmtState::PreOperational));
    for data in [&[][..], &[0x05, 0], &[0x01]] {
        assert_eq!(heartbeat::decode(&frame(0x701, data)), None);
    }
}

/// Verifies: ECSS 6.5.2a
#[test]
fn a_producer_tells_the_present_state_every_period() {
    let mut producer = heartbeat::Producer::new(node(2), span(100));
    assert_eq!(producer.poll(ms(5), NmtState::PreOperational), None);
    producer.announce(ms(10));
    assert_eq!(producer.poll(ms(10), NmtState::PreOperational), Some(frame(0x702, &[0x7F])));
    assert_eq!(producer.deadline(), Some(ms(110)));
    assert_eq!(producer.poll(ms(109), NmtState::Operational), None);
    assert_eq!(producer.poll(ms(110), NmtState::Operational), Some(frame(0x702, &[0x05])));
}

/// Verifies: ECSS 6.5.2a
#[test]
fn a_consumer_is_armed_by_the_first_heartbeat() {
    let mut consumer = Consumer::default();
    assert_eq!(consumer.deadline(span(250)), None);
    assert_eq!(consumer.poll(ms(1_000_000), span(250)), None);
    assert!(!consumer.on_heartbeat(ms(1_000_000)));
    assert_eq!(consumer.deadline(span(250)), Some(ms(1_000_250)));
}

#[test]
fn a_missed_heartbeat_is_told_once_and_resolved_by_the_next() {
    let mut consumer = Consumer::default();
    consumer.on_heartbeat(ms(100));
    assert_eq!(consumer.poll(ms(349), span(250)), None);
    assert_eq!(consumer.poll(ms(350), span(250)), Some(ms(100)));
    assert!(consumer.is_missed());
    assert_eq!(consumer.poll(ms(900), span(250)), None);
    assert_eq!(consumer.deadline(span(250)), None);
    assert!(consumer.on_heartbeat(ms(1_000)));
    assert!(!consumer.on_heartbeat(ms(1_100)));
}

#[test]
fn a_consumer_time_of_zero_disables_the_monitoring() {
    let mut consumer = Consumer::default();
    consumer.on_heartbeat(ms(100));
    assert_eq!(consumer.poll(Instant::from_micros(u64::MAX), Duration::ZERO), None);
}

/// Verifies: ECSS 6.3b, 6.9c
#[test]
fn sync_on_the_wire_and_every_period() {
    let mut producer = sync::Producer::new(span(5_000));
    producer.start(ms(0));
    assert_eq!(producer.poll(ms(4_999)), None);
    assert_eq!(producer.poll(ms(5_000)), Some(frame(0x080, &[])));
    assert_eq!(producer.deadline(), Some(ms(10_000)));
}

#[test]
fn a_sync_may_carry_a_counter_and_nothing_more() {
    assert!(sync::is_well_formed(&frame(0x080, &[])));
    assert!(sync::is_well_formed(&frame(0x080, &[240])));
    assert!(!sync::is_well_formed(&frame(0x080, &[1, 2])));
}
