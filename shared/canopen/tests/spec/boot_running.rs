//! Boot-up process of slaves that run: when they are checked again, and what a check changes.

use async_canopen::boot::{AssignedSlave, BootError, BootProgress, Difference, Expected};
use async_canopen::nmt::Target;
use async_canopen::sdo::Error;
use async_canopen::types::{Address, NmtState};

use crate::bench::ms;
use crate::boot::{
    Asked, Bench, NOT_OWN, POLICY, THREE, TWO, answer, boots_up, configure_two, expected, identify, next,
    sends_nothing, started, transfer,
};

/// Slave 2 went through everything and says that it is Operational.
fn running() -> Bench {
    let mut boot = started(POLICY);
    configure_two(&mut boot);
    assert!(boot.on_heartbeat(TWO, NmtState::Operational, true, false));
    boot
}

/// Given a slave that runs
/// When it is Pre-operational and no command explains that
/// Then it is started at once and checked, once.
///
/// Verifies: ECSS 8.3.3f
#[test]
fn an_unexplained_pre_operational_is_started_then_checked() {
    let mut boot = running();
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false), "the start may be lost");
    identify(&mut boot, 2);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1017, 0)));
    answer(&mut boot, &[100, 0]);
    next(&mut boot, expected());
    answer(&mut boot, &[1, 2, 3, 4, 5, 6]);
    sends_nothing(&mut boot, 2, expected());
    assert_eq!((next(&mut boot, expected()), boot.take_deviation()), (None, None));
    // Heard on the other bus first: checked when it is heard on this one.
    assert!(boot.on_heartbeat(TWO, NmtState::Operational, true, false));
    assert!(!boot.on_heartbeat(TWO, NmtState::PreOperational, false, false));
    assert_eq!(next(&mut boot, expected()), None);
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
}

/// Given slaves that run, when another master is active, then what was known of them is old: they are asked again when they are heard
/// after a takeover.
#[test]
fn a_standby_forgets_how_far_its_slaves_were() {
    let mut boot = running();
    assert!(!boot.poll(ms(1)) && boot.is_released());
    boot.stand_by();
    assert_eq!([TWO, THREE].map(|node| boot.progress(node)), [BootProgress::Awaited; 2]);
    assert!(!boot.is_released());
    boot.start(ms(2_000));
    boot.poll(ms(2_000));
    boots_up(&mut boot, TWO);
    identify(&mut boot, 2);
}

/// Verifies: ECSS 8.3.3f
#[test]
fn a_commanded_pre_operational_is_not_checked() {
    for target in [Target::All, Target::Node(TWO)] {
        let mut boot = running();
        boot.on_commanded(target);
        assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
        assert_eq!(next(&mut boot, expected()), None, "{target:?}");
        // Started again it runs, and its next Pre-operational needs an explanation.
        assert!(boot.on_heartbeat(TWO, NmtState::Operational, true, false));
        assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)), "{target:?}");
    }
    let mut boot = running();
    boot.on_commanded(Target::Node(THREE));
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
    assert!(next(&mut boot, expected()).is_some(), "the command was for another slave");
}

/// Verifies: ECSS 8.3.3f
#[test]
fn pre_operational_first_on_the_new_bus_is_checked() {
    let mut boot = running();
    boot.on_commanded(Target::Node(TWO));
    boot.on_bus_changed();
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
}

/// Given a slave that was reset without being heard
/// When its check finds another date of configuration (1020h)
/// Then that is reported, and the slave is configured before it is started again.
#[test]
fn a_lost_configuration_is_reported_and_written_again() {
    let stamped = Expected { device_type: 0, identity: [0; 4], stamp: [5, 6] };
    let mut boot = running();
    boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    next(&mut boot, stamped);
    answer(&mut boot, &[0; 4]);
    assert_eq!(next(&mut boot, stamped), Some(Asked::Read(2, 0x1020, 1)));
    assert_eq!(boot.take_deviation(), None);
    answer(&mut boot, &[0; 4]);
    let difference = Difference { at: Address::new(0x1020, 1), expected: 5, found: 0 };
    assert_eq!((boot.take_deviation(), boot.take_deviation()), (Some((TWO, difference)), None));
    let goes_on = boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    assert!(!goes_on, "not started before it is configured");
    next(&mut boot, stamped);
    answer(&mut boot, &[0xE8, 3]);
    assert_eq!(next(&mut boot, stamped), Some(Asked::Write(2, 0x1017, 0, vec![100, 0])));
    boot.on_done(Ok(()), NOT_OWN);
    next(&mut boot, stamped);
    answer(&mut boot, &[1, 2, 3, 4, 5, 6]);
    sends_nothing(&mut boot, 2, stamped);
    for (sub, value) in [(1, 5_u32), (2, 6)] {
        let written = Asked::Write(2, 0x1020, sub, value.to_le_bytes().to_vec());
        assert_eq!((next(&mut boot, stamped), boot.take_start()), (Some(written), None));
        boot.on_done(Ok(()), NOT_OWN);
    }
    assert_eq!((boot.take_start(), boot.take_deviation()), (Some(TWO), None));
}

/// Given two mandatory slaves, of which one followed a SYNC and then lost its configuration
/// When the other one follows
/// Then the boot-up is complete when the first one follows again.
#[test]
fn a_slave_that_lost_its_configuration_has_to_follow_sync_again() {
    let mut boot = started(POLICY);
    boot.assign(THREE, AssignedSlave { node: THREE, mandatory: true, expected: expected() }.assignment());
    configure_two(&mut boot);
    boots_up(&mut boot, THREE);
    identify(&mut boot, 3);
    next(&mut boot, expected());
    answer(&mut boot, &[200, 0]);
    sends_nothing(&mut boot, 3, expected());
    assert!(!boot.poll(ms(1)));
    boot.on_sync_sent();
    boot.on_heartbeat(TWO, NmtState::Operational, true, false);
    assert_eq!(boot.progress(TWO), BootProgress::Booted);

    boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    identify(&mut boot, 2);
    next(&mut boot, expected());
    answer(&mut boot, &[0xE8, 3]);
    boot.on_heartbeat(THREE, NmtState::Operational, true, false);
    assert!(!boot.poll(ms(2)), "slave 2 is not configured");

    assert_eq!(next(&mut boot, expected()), Some(Asked::Write(2, 0x1017, 0, vec![100, 0])));
    boot.on_done(Ok(()), NOT_OWN);
    next(&mut boot, expected());
    answer(&mut boot, &[1, 2, 3, 4, 5, 6]);
    sends_nothing(&mut boot, 2, expected());
    boot.on_heartbeat(TWO, NmtState::Operational, true, false);
    assert!(boot.poll(ms(3)));
}

#[test]
fn a_lost_setting_of_a_slave_without_1020h_is_reported() {
    let mut boot = running();
    boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    identify(&mut boot, 2);
    next(&mut boot, expected());
    answer(&mut boot, &[0xE8, 3]);
    let difference = Difference { at: Address::new(0x1017, 0), expected: 100, found: 1000 };
    assert_eq!(boot.take_deviation(), Some((TWO, difference)));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Write(2, 0x1017, 0, vec![100, 0])));
}

/// Verifies: ECSS 8.3.3f
#[test]
fn a_running_slave_that_cannot_be_checked_goes_on() {
    let mut boot = running();
    boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    for _ in 0..3 {
        next(&mut boot, expected());
        boot.on_done(Err(Error::Timeout), NOT_OWN);
    }
    let failure = transfer(TWO, BootError::NoResponse, Address::new(0x1000, 0), 0x0504_0000);
    assert_eq!(boot.take_failure(), failure);
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, false), "started at once as before");
    // Another device in its place is not started.
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, true));
    next(&mut boot, expected());
    answer(&mut boot, &0xBAD_u32.to_le_bytes());
    assert!(boot.take_failure().is_some());
    assert!(!boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
}
