//! Heartbeat, boot-up and the periodic timer under them.
//!
//! Verifies: ECSS 6.5.2a

use async_canopen::heartbeat;
use async_canopen::heartbeat::HeartbeatConsumers;
use async_canopen::heartbeat::machine::{Consumer, Heard, Missed, Monitor, Staggered};
use async_canopen::types::{AbortCode, Duration, Instant, NmtState, Periodic};
use proptest::prelude::*;

use crate::bench::{frame, ms, node, span};
use crate::random::cases;

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

/// Given a timer of 100 ms, when it is due 2^n µs from now or ago, then it is on schedule up to 2^17 µs, which are 131 ms, and not
/// from 2^18 µs on, which are 262 ms. A stopped timer is not on schedule.
#[test]
fn a_timer_is_on_schedule_within_two_periods() {
    let mut timer = Periodic::new(span(100));
    assert!(!timer.is_on_schedule(ms(0)));
    for bit in 0..64 {
        let (early, late) = (Instant::ZERO, Instant::from_micros(1 << bit));
        for (due, now) in [(late, early), (early, late)] {
            timer.start(due);
            assert_eq!(timer.is_on_schedule(now), bit <= 17, "due at {due:?}, now {now:?}");
        }
    }
}

/// Given a producer of 100 ms, then it is on schedule while it is stopped and while its heartbeats are taken when due, and not two
/// periods after one that was not taken. Without a period it is always on schedule.
#[test]
fn a_producer_is_off_schedule_when_a_heartbeat_is_not_taken() {
    let mut producer = Staggered::new(node(5), span(100), Duration::ZERO);
    assert!(producer.is_on_schedule(ms(5_000)), "silent until it is started");
    producer.announce(ms(5_000));
    for at in (5_000..6_000).step_by(100) {
        assert!(producer.poll(ms(at), NmtState::Operational).is_some());
        assert!(producer.is_on_schedule(ms(at)));
    }
    // The next one is due at 6,000.
    assert!(producer.is_on_schedule(ms(6_199)));
    assert!(!producer.is_on_schedule(ms(6_200)));
    producer.stop();
    assert!(producer.is_on_schedule(ms(6_200)));
    producer.announce(ms(7_000));
    producer.set_period(Duration::ZERO, ms(7_000));
    assert!(producer.is_on_schedule(ms(9_000)));
}

#[test]
fn a_period_of_zero_never_starts() {
    let mut timer = Periodic::new(Duration::ZERO);
    timer.start(ms(1));
    assert_eq!(timer.deadline(), None);
    assert!(!timer.due(ms(2)));
}

/// Verifies: ECSS 6.5.3a
#[test]
fn heartbeat_and_boot_up_on_the_wire() {
    assert_eq!(heartbeat::encode(node(4), NmtState::Operational), frame(0x704, &[0x05]));
    assert_eq!(heartbeat::encode(node(4), NmtState::Initialising), frame(0x704, &[0x00]));
    assert_eq!(heartbeat::decode(&frame(0x701, &[0x7F])), Some(NmtState::PreOperational));
    for data in [&[][..], &[0x05, 0], &[0x01], &[0x80], &[0x85, 0]] {
        assert_eq!(heartbeat::decode(&frame(0x701, data)), None);
    }
}

#[test]
fn heartbeat_with_bit_7_has_a_state_and_is_noted() {
    assert_eq!(heartbeat::decode(&frame(0x704, &[0x85])), Some(NmtState::Operational));
    assert!(heartbeat::is_toggled(&frame(0x704, &[0x85])));
    assert!(!heartbeat::is_toggled(&frame(0x704, &[0x05])));
    // "Enter Pre-operational" is no heartbeat.
    assert!(!heartbeat::is_toggled(&frame(0x000, &[0x80, 4])));
}

/// Verifies: ECSS 8.3.3a, 8.3.3d
#[test]
fn a_producer_tells_the_present_state_every_period() {
    let mut producer = heartbeat::machine::Producer::new(node(2), span(100));
    assert_eq!(producer.poll(ms(5), NmtState::PreOperational), None);
    producer.announce(ms(10));
    assert_eq!(producer.poll(ms(10), NmtState::PreOperational), Some(frame(0x702, &[0x7F])));
    assert_eq!(producer.deadline(), Some(ms(110)));
    assert_eq!(producer.poll(ms(109), NmtState::Operational), None);
    assert_eq!(producer.poll(ms(110), NmtState::Operational), Some(frame(0x702, &[0x05])));
}

/// Verifies: ECSS 8.3.1c
/// Notices: ECSS 6.5.2a: the first heartbeat with a new period waits for that period.
#[test]
fn a_new_producer_time_takes_effect_at_once() {
    let mut producer = heartbeat::machine::Producer::new(node(2), span(1_000));
    // Before the boot-up message it is a setting and no more.
    producer.set_period(span(500), ms(0));
    assert_eq!(producer.deadline(), None);
    producer.restart(ms(10));
    assert_eq!(producer.deadline(), Some(ms(510)));
    producer.set_period(span(100), ms(20));
    assert!(producer.poll(ms(20), NmtState::Operational).is_some());
    assert_eq!(producer.deadline(), Some(ms(120)));
    producer.set_period(Duration::ZERO, ms(30));
    assert_eq!(producer.deadline(), None);
    producer.set_period(span(200), ms(1_000));
    assert!(producer.poll(ms(1_000), NmtState::Operational).is_some());
    assert_eq!(producer.deadline(), Some(ms(1_200)));
    producer.stop();
    producer.set_period(span(100), ms(1_100));
    assert_eq!(producer.deadline(), None);
}

/// Instants at which heartbeats go out, microseconds, when each is polled at its deadline.
fn sent(producer: &mut Staggered, count: usize) -> Vec<u64> {
    let beat = |_| {
        let due = producer.deadline().unwrap();
        assert!(producer.poll(Instant::from_micros(due.as_micros() - 1), NmtState::Operational).is_none());
        assert!(producer.poll(due, NmtState::Operational).is_some());
        producer.arrange_next();
        due.as_micros()
    };
    (0..count).map(beat).collect()
}

/// Given a pattern, then a heartbeat whose bit is set is late by the delay, and all others are on the grid. After 32 heartbeats
/// the pattern comes again.
///
/// Verifies: ECSS 8.3.3d
#[test]
fn heartbeats_are_late_by_the_pattern_and_the_grid_stays() {
    let mut producer = Staggered::new(node(2), Duration::ZERO, Duration::from_micros(540));
    producer.set_pattern(0b10110);
    producer.set_period(span(100), ms(0));
    producer.restart(ms(10));
    let late = |number: u64| if [1, 2, 4].contains(&(number % 32)) { 540 } else { 0 };
    let expected: Vec<u64> = (0..70).map(|number| 10_000 + 100_000 * (number + 1) + late(number)).collect();
    assert_eq!(sent(&mut producer, 70), expected);
}

/// Given a short period, then the delay is a tenth of it.
#[test]
fn delay_is_at_most_a_tenth_of_the_period() {
    let mut producer = Staggered::new(node(2), Duration::ZERO, Duration::from_micros(540));
    producer.set_pattern(u32::MAX);
    producer.set_period(span(5), ms(0));
    producer.restart(ms(0));
    assert_eq!(sent(&mut producer, 4), [5_000, 10_500, 15_500, 20_500]);
}

/// Given a late heartbeat that waits, when another one is announced or the period changes, then that is on time and begins a
/// new grid.
#[test]
fn announced_heartbeat_is_on_time() {
    let mut producer = Staggered::new(node(2), Duration::ZERO, Duration::from_micros(540));
    producer.set_pattern(u32::MAX);
    producer.set_period(span(100), ms(0));
    producer.restart(ms(0));
    assert_eq!(sent(&mut producer, 2), [100_000, 200_540]);
    assert!(!producer.is_held_back(ms(300)) && producer.is_held_back(Instant::from_micros(300_001)));
    producer.announce(ms(300));
    assert_eq!(sent(&mut producer, 2), [300_000, 400_540]);
    producer.set_period(span(50), ms(420));
    assert_eq!(sent(&mut producer, 2), [420_000, 470_540]);
    producer.stop();
    assert_eq!(producer.deadline(), None);
}

/// Given a grid of 100 ms and a delay of 540 us, then a heartbeat was just due for the delay and a millisecond, late or on time.
#[test]
fn heartbeat_is_just_due_for_its_delay_and_a_millisecond() {
    for pattern in [0, u32::MAX] {
        let mut producer = Staggered::new(node(2), span(100), Duration::from_micros(540));
        producer.set_pattern(pattern);
        producer.restart(ms(0));
        sent(&mut producer, 3);
        let is_due =
            [299_999, 300_000, 301_539, 301_540].map(|us| producer.is_just_due(Instant::from_micros(us)));
        assert_eq!(is_due, [false, true, true, false], "{pattern:X}");
    }
}

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

const OPERATIONAL: NmtState = NmtState::Operational;
const PRE_OPERATIONAL: NmtState = NmtState::PreOperational;
const BOOT_UP: NmtState = NmtState::Initialising;

/// Nodes 3 (100 ms) and 9 (250 ms).
fn monitor() -> Monitor<HeartbeatConsumers> {
    let mut monitor = Monitor::default();
    assert_eq!(monitor.set(1, 0x0003_0064), None);
    assert_eq!(monitor.set(8, 0x0009_00FA), None);
    monitor
}

fn missed(monitor: &mut Monitor<HeartbeatConsumers>, now: u64) -> Vec<(u8, Instant)> {
    std::iter::from_fn(|| monitor.poll(ms(now))).map(|Missed { node, last }| (node.get(), last)).collect()
}

#[test]
fn monitoring_of_a_node_starts_with_its_first_heartbeat() {
    let mut monitor = monitor();
    assert_eq!(monitor.deadline(), None);
    assert!(missed(&mut monitor, 1_000_000).is_empty());
    // The boot-up message is none.
    let first = Heard { before: None, resolved: false };
    assert_eq!(monitor.on_heartbeat(node(3), BOOT_UP, ms(1_000_000)), Some(first));
    assert_eq!(monitor.deadline(), None);
    let second = Heard { before: Some(BOOT_UP), resolved: false };
    assert_eq!(monitor.on_heartbeat(node(3), PRE_OPERATIONAL, ms(1_000_010)), Some(second));
    assert_eq!(monitor.deadline(), Some(ms(1_000_110)));
}

#[test]
fn every_monitored_node_is_missed_once_at_its_own_time() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(1_000));
    monitor.on_heartbeat(node(9), OPERATIONAL, ms(1_000));
    assert_eq!(monitor.deadline(), Some(ms(1_100)));
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(1_090));
    // The deadline may be early: then nothing is overdue, and the next look is at the right time.
    assert!(missed(&mut monitor, 1_100).is_empty());
    assert_eq!(monitor.deadline(), Some(ms(1_190)));
    assert!(missed(&mut monitor, 1_189).is_empty());
    assert_eq!(missed(&mut monitor, 1_190), [(3, ms(1_090))]);
    assert_eq!(monitor.deadline(), Some(ms(1_250)));
    assert_eq!(missed(&mut monitor, 1_250), [(9, ms(1_000))]);
    assert_eq!(monitor.deadline(), None);
    assert!(missed(&mut monitor, 100_000).is_empty());
}

#[test]
fn two_nodes_missed_at_one_instant_are_both_told() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(9), OPERATIONAL, ms(1_000));
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(1_150));
    assert_eq!(missed(&mut monitor, 5_000), [(3, ms(1_150)), (9, ms(1_000))]);
}

/// Verifies: ECSS 5.3.3.2.3g
/// Notices: ECSS 5.3.3.2.3g: the miss of a node stays after its heartbeats resume.
#[test]
fn the_next_heartbeat_resolves_a_miss_and_is_monitored_again() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
    missed(&mut monitor, 100);
    let heard = monitor.on_heartbeat(node(3), OPERATIONAL, ms(500));
    assert_eq!(heard, Some(Heard { before: Some(OPERATIONAL), resolved: true }));
    let heard = monitor.on_heartbeat(node(3), OPERATIONAL, ms(550));
    assert_eq!(heard, Some(Heard { before: Some(OPERATIONAL), resolved: false }));
    assert_eq!(missed(&mut monitor, 650), [(3, ms(550))]);
}

#[test]
fn a_change_of_state_is_seen() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(9), PRE_OPERATIONAL, ms(0));
    let heard = monitor.on_heartbeat(node(9), OPERATIONAL, ms(50)).unwrap();
    assert_eq!(heard.before, Some(PRE_OPERATIONAL));
    let heard = monitor.on_heartbeat(node(9), OPERATIONAL, ms(100)).unwrap();
    assert_eq!(heard.before, Some(OPERATIONAL));
}

/// Verifies: ECSS 6.5.3a, 11.1d
/// Notices: ECSS 11.1d: a boot-up message of a monitored node does not restart its consumer time.
#[test]
fn boot_up_of_monitored_node_is_seen_and_it_stays_monitored() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
    let heard = monitor.on_heartbeat(node(3), BOOT_UP, ms(80));
    assert_eq!(heard, Some(Heard { before: Some(OPERATIONAL), resolved: false }));
    assert_eq!(missed(&mut monitor, 180), [(3, ms(80))]);
    // Back from silence with a boot-up message: resolved, and missed again when nothing follows.
    let heard = monitor.on_heartbeat(node(3), BOOT_UP, ms(400));
    assert_eq!(heard, Some(Heard { before: Some(BOOT_UP), resolved: true }));
    assert_eq!(missed(&mut monitor, 500), [(3, ms(400))]);
}

#[test]
fn heartbeats_of_others_are_not_monitored() {
    let mut monitor = monitor();
    assert_eq!(monitor.on_heartbeat(node(4), OPERATIONAL, ms(0)), None);
    assert_eq!(monitor.deadline(), None);
}

#[test]
fn entries_without_a_node_or_a_time_are_not_in_use() {
    for value in [0, 0x0000_0064, 0x0080_0064, 0x00FF_0064, 0x0003_0000] {
        let mut monitor = Monitor::<HeartbeatConsumers<1>>::new();
        monitor.set(1, 0x0003_0064);
        monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
        monitor.set(1, value);
        assert_eq!(monitor.on_heartbeat(node(3), OPERATIONAL, ms(10)), None, "{value:08X}");
        assert_eq!(monitor.poll(ms(100_000)), None);
    }
}

/// Given an entry with the longest consumer time there is, then its node is missed after that time.
///
/// Notices: ECSS 6.5.2a: consumer times of 32768 ms and more are too short.
#[test]
fn a_consumer_time_has_16_bits() {
    let mut monitor = Monitor::<HeartbeatConsumers>::new();
    monitor.set(1, 0x0003_FFFF);
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
    assert_eq!(missed(&mut monitor, 65_534), []);
    assert_eq!(missed(&mut monitor, 65_535), [(3, ms(0))]);
}

/// Verifies: ECSS 8.3.1c
#[test]
fn writing_an_entry_arms_it_anew() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
    assert_eq!(monitor.set(1, 0x0003_01F4), None);
    assert!(missed(&mut monitor, 10_000).is_empty());
    let heard = monitor.on_heartbeat(node(3), OPERATIONAL, ms(20_000));
    assert_eq!(heard, Some(Heard { before: None, resolved: false }));
    assert_eq!(monitor.deadline(), Some(ms(20_500)));
}

#[test]
fn a_miss_that_nobody_will_resolve_is_handed_over() {
    let mut monitor = monitor();
    monitor.on_heartbeat(node(3), OPERATIONAL, ms(0));
    missed(&mut monitor, 100);
    assert_eq!(monitor.set(1, 0x0004_0064), Some(node(3)));
    assert_eq!(monitor.set(1, 0), None);
    // No such sub-index.
    assert_eq!((monitor.set(0, 0x0005_0064), monitor.set(9, 0x0005_0064)), (None, None));
    assert_eq!(monitor.on_heartbeat(node(5), OPERATIONAL, ms(200)), None);
}

/// Verifies: ECSS 8.3.1c
#[test]
fn a_node_is_monitored_by_one_entry_only() {
    let present = [0x0003_0064, 0x0009_00FA, 0x0005_0000, 0];
    let check = |sub, value| heartbeat::machine::check_entry(&present, sub, value);
    assert_eq!(check(4, 0x0003_0001), Err(AbortCode::ParameterIncompatible));
    assert_eq!(check(1, 0x0009_0064), Err(AbortCode::ParameterIncompatible));
    // Itself, entries not in use, several not in use.
    assert_eq!(check(1, 0x0003_0001), Ok(()));
    assert_eq!(check(4, 0x0005_0064), Ok(()));
    assert_eq!(check(4, 0x0003_0000), Ok(()));
    assert_eq!(check(4, 0x0080_0064), Ok(()));
    assert_eq!(check(1, 0), Ok(()));
    assert_eq!(check(1, 0x0103_0064), Err(AbortCode::ValueRange));
    assert_eq!(check(0, 0), Err(AbortCode::NoSubIndex));
    assert_eq!(check(5, 0), Err(AbortCode::NoSubIndex));
}

/// One thing that happens to a monitor, with the milliseconds before it.
#[derive(Clone, Copy, Debug)]
enum Step {
    Heard(u64, u8, NmtState),
    Written(u8, u32),
}

fn step() -> impl Strategy<Value = Step> {
    let state = prop::sample::select(vec![BOOT_UP, NmtState::Stopped, OPERATIONAL, PRE_OPERATIONAL]);
    let value = (1..=5_u32, 0..=300_u32).prop_map(|(node, time)| node << 16 | time);
    prop_oneof![
        9 => (0..200_u64, 1..=5_u8, state).prop_map(|(wait, node, state)| Step::Heard(wait, node, state)),
        1 => (1..=4_u8, value).prop_map(|(sub, value)| Step::Written(sub, value)),
    ]
}

/// The consumer of one entry, by the book: one timer, looked at every millisecond.
#[derive(Clone, Copy, Default)]
struct Reference {
    node: u8,
    time: u64,
    left: Option<u64>,
    missed: bool,
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn a_monitor_does_what_one_timer_for_each_entry_does(steps in prop::collection::vec(step(), 0..200)) {
        let mut monitor = Monitor::<HeartbeatConsumers<4>>::new();
        let mut present = [0; 4];
        let mut references = [Reference::default(); 4];
        let mut now = 0;
        for step in steps {
            match step {
                Step::Written(sub, value) => {
                    if heartbeat::machine::check_entry(&present, sub, value).is_ok() {
                        let place = usize::from(sub) - 1;
                        present[place] = value;
                        let was = references[place];
                        prop_assert_eq!(monitor.set(sub, value), was.missed.then(|| node(was.node)));
                        let time = u64::from(value & 0xFFFF);
                        let node = if time == 0 { 0 } else { (value >> 16) as u8 };
                        references[place] = Reference { node, time, left: None, missed: false };
                    }
                }
                Step::Heard(wait, from, state) => {
                    let mut expected = vec![];
                    for _ in 0..wait {
                        for reference in &mut references {
                            reference.left = reference.left.map(|left| left - 1);
                            if reference.left == Some(0) {
                                (reference.left, reference.missed) = (None, true);
                                expected.push(reference.node);
                            }
                        }
                    }
                    // As a node does it: from deadline to deadline.
                    let mut told = vec![];
                    while let Some(due) = monitor.deadline().filter(|due| *due <= ms(now + wait)) {
                        told.extend(std::iter::from_fn(|| monitor.poll(due)).map(|missed| missed.node.get()));
                        prop_assert!(monitor.deadline().is_none_or(|next| next > due));
                    }
                    now += wait;
                    told.sort_unstable();
                    expected.sort_unstable();
                    prop_assert_eq!(told, expected);
                    let reference = references.iter_mut().find(|reference| reference.node == from);
                    let heard = monitor.on_heartbeat(node(from), state, ms(now));
                    prop_assert_eq!(heard.is_some(), reference.is_some());
                    if let Some(reference) = reference {
                        prop_assert_eq!(heard.unwrap().resolved, reference.missed);
                        if state != BOOT_UP || reference.missed || reference.left.is_some() {
                            (reference.left, reference.missed) = (Some(reference.time), false);
                        }
                    }
                }
            }
        }
    }
}
