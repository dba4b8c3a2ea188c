//! Slaves that are lost on one bus while the other one fails whenever the master comes there.
//!
//! Heartbeat 40 ms, consumer time 100 ms, Ttoggle 3: hold time 260 ms, settling time 380 ms. Silent share 50 %.
//!
//! Verifies: ECSS 8.3.3b

use ecss_can::link::port::{ErrorState, Health};
use ecss_can::redundancy::SwitchCause;
use ecss_can::redundancy::machine::{Action, Manager};
use ecss_can::types::Bus;

use crate::bench::{NOMINAL, REDUNDANT, ms};
use crate::manager::{ALONE, decisions, started, switched};
use crate::trial::fly;

const ALL: [u8; 6] = [2, 3, 4, 5, 6, 7];
const OFF: Health = Health { state: ErrorState::BusOff, tec: 255, ..ALONE };

/// The controller of this bus went off too often; a while later it is back.
fn fail(manager: &mut Manager, bus: Bus, at: u64) -> Vec<(u64, Action)> {
    manager.on_health(bus, OFF, true, ms(at));
    decisions(manager, at)
}

/// Half of the slaves are cut off on the nominal bus at 1000 ms. The redundant one fails 80 ms after the master came there,
/// and its controller recovers at 2100 ms, as it does on a bus where recessive bits can be read but no dominant ones sent.
fn half_is_lost() -> Manager {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &ALL, &[]), []);
    let done = fly(&mut manager, 1_000, 1_100, &[2, 3, 4], &[]);
    assert_eq!(done, [(1_080, switched(NOMINAL, SwitchCause::SlavesSilent))]);
    assert_eq!(fly(&mut manager, 1_100, 1_160, &[], &[]), []);
    let done = fail(&mut manager, REDUNDANT, 1_160);
    assert_eq!(done, [(1_160, switched(REDUNDANT, SwitchCause::BusOff))]);
    assert_eq!(fly(&mut manager, 1_180, 2_100, &[2, 3, 4], &[]), []);
    manager.on_health(REDUNDANT, Health::default(), false, ms(2_100));
    manager
}

#[test]
fn a_bus_that_serves_some_is_not_left_for_one_that_failed() {
    let mut manager = half_is_lost();
    assert_eq!(fly(&mut manager, 2_100, 60_000, &[2, 3, 4], &[]), []);
    assert_eq!(manager.active(), NOMINAL);
}

#[test]
fn bus_without_acknowledgement_is_no_better_than_a_failed_one() {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &ALL, &[]), []);
    manager.on_health(NOMINAL, ALONE, false, ms(1_000));
    assert_eq!(decisions(&mut manager, 1_005), [(1_002, switched(NOMINAL, SwitchCause::Isolated))]);
    manager.on_health(NOMINAL, Health::default(), false, ms(1_010));
    assert_eq!(fly(&mut manager, 1_020, 60_000, &[2, 3, 4], &[]), []);
    assert_eq!(manager.active(), REDUNDANT);
}

/// When the slaves that are lost are heard on the mended bus for the hold time, then it is tried.
#[test]
fn failed_bus_is_tried_when_lost_slaves_are_heard_there() {
    let mut manager = half_is_lost();
    assert_eq!(fly(&mut manager, 2_100, 5_000, &[2, 3, 4], &[]), []);
    let done = fly(&mut manager, 5_000, 5_300, &[2, 3, 4], &[5, 6, 7]);
    assert_eq!(done, [(5_260, switched(NOMINAL, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 5_300, 60_000, &ALL, &[]), []);
    assert_eq!(manager.active(), REDUNDANT);
}

/// A bus on which nobody is heard is no better than one that failed.
#[test]
fn failed_bus_is_tried_again_when_no_slave_is_heard_any_more() {
    let mut manager = half_is_lost();
    let done = fly(&mut manager, 2_100, 2_300, &[], &[]);
    assert_eq!(done, [(2_180, switched(NOMINAL, SwitchCause::SlavesSilent))]);
}

/// When all slaves were heard on the bus to which the master fled, then the share counts again.
///
/// Verifies: ECSS 5.3.3.2.3k
/// Notices: ECSS 5.3.3.2.3k: slaves behind a cut that is healed are never forgotten, and the next cut changes no bus.
#[test]
fn what_failed_long_ago_is_forgotten() {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &ALL, &[]), []);
    assert_eq!(fail(&mut manager, NOMINAL, 1_000), [(1_000, switched(NOMINAL, SwitchCause::BusOff))]);
    manager.on_health(NOMINAL, Health::default(), false, ms(1_010));
    assert_eq!(fly(&mut manager, 1_020, 5_000, &ALL, &[]), []);
    let done = fly(&mut manager, 5_000, 5_100, &[2, 3, 4], &[]);
    assert_eq!(done, [(5_080, switched(REDUNDANT, SwitchCause::SlavesSilent))]);
}
