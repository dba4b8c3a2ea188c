//! Recovery from bus-off.
//!
//! Verifies: ECSS 5.6.2a

use ecss_can::link::bus_off::{BusOffPolicy, BusOffRecovery, RecoveryStep};
use ecss_can::link::port::ErrorState::{Active, BusOff, Passive};

use crate::bench::ms;

const POLICY: BusOffPolicy =
    BusOffPolicy { pause: span_const(10), patience: span_const(50), attempts: 2, window: span_const(1_000) };

const fn span_const(ms: u64) -> ecss_can::types::Duration {
    ecss_can::types::Duration::from_millis(ms)
}

#[test]
fn a_pause_and_then_the_recovery_once() {
    let mut recovery = BusOffRecovery::new(POLICY);
    assert_eq!(recovery.on_state(Passive, ms(90)), None);
    assert_eq!(recovery.deadline(), None);
    assert_eq!(recovery.on_state(BusOff, ms(100)), None);
    assert_eq!(recovery.poll(ms(109)), None);
    assert_eq!(recovery.poll(ms(110)), Some(RecoveryStep::Recover));
    assert_eq!(recovery.poll(ms(111)), None);
    assert_eq!(recovery.on_state(Active, ms(112)), None);
    assert!(!recovery.is_failed());
}

/// Verifies: ECSS 5.3.3.2.3j, 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3h, 5.3.3.2.3k.1
/// Notices: ECSS 5.3.3.2.3j: attempts of an old window count against a later short.
/// Notices: ECSS 5.3.3.2.3d: attempts of an old window count against a later short.
/// Notices: ECSS 5.3.3.2.3k.1: recoveries of earlier windows make the bus failed.
#[test]
fn too_many_bus_offs_in_a_window_fail_the_bus_until_it_recovers() {
    let mut recovery = BusOffRecovery::new(POLICY);
    for at in [100, 200] {
        assert_eq!(recovery.on_state(BusOff, ms(at)), None);
        assert_eq!(recovery.poll(ms(at + 10)), Some(RecoveryStep::Recover));
        recovery.on_state(Active, ms(at + 12));
    }
    assert_eq!(recovery.on_state(BusOff, ms(300)), Some(RecoveryStep::Failed));
    assert!(recovery.is_failed());
    // The window began at 100 ms: one more try when it ends.
    assert_eq!(recovery.deadline(), Some(ms(1_100)));
    assert_eq!(recovery.poll(ms(1_100)), Some(RecoveryStep::Recover));
    assert!(recovery.is_failed());
    recovery.on_state(Active, ms(1_102));
    assert!(!recovery.is_failed());
    // A new window.
    assert_eq!(recovery.on_state(BusOff, ms(1_200)), None);
}

#[test]
fn a_bus_that_was_left_is_not_recovered() {
    let mut recovery = BusOffRecovery::new(POLICY);
    recovery.on_state(BusOff, ms(100));
    recovery.leave();
    assert_eq!(recovery.deadline(), None);
    assert_eq!(recovery.poll(ms(500)), None);
}

/// Verifies: ECSS 5.3.3.2.3g, 5.3.3.2.3d, 5.3.3.2.3h, 5.3.3.2.3j
/// Notices: ECSS 5.3.3.2.3g: a recovery that found the bus still dominant is the last one.
/// Notices: ECSS 5.6.2a: a recovery from bus-off that does not end is waited for without end.
/// Notices: ECSS 5.3.3.2.3h: a recovery in vain is the last one.
#[test]
fn unending_recovery_is_retried_and_counted_until_bus_failed() {
    let mut recovery = BusOffRecovery::new(POLICY);
    recovery.on_state(BusOff, ms(100));
    assert_eq!(recovery.poll(ms(110)), Some(RecoveryStep::Recover));
    // The bus is dominant all the time: no 11 recessive bits come.
    assert_eq!((recovery.deadline(), recovery.poll(ms(159))), (Some(ms(160)), None));
    assert_eq!(recovery.poll(ms(160)), None);
    assert_eq!(recovery.poll(ms(170)), Some(RecoveryStep::Recover));
    assert_eq!(recovery.poll(ms(220)), Some(RecoveryStep::Failed));
    // Once in each window from then on, and failed as long as it lasts.
    assert_eq!(recovery.deadline(), Some(ms(1_100)));
    assert_eq!(recovery.poll(ms(1_100)), Some(RecoveryStep::Recover));
    assert_eq!(recovery.poll(ms(1_150)), None);
    assert!(recovery.is_failed());
    recovery.on_state(Active, ms(1_151));
    assert_eq!((recovery.is_failed(), recovery.deadline()), (false, None));
}

/// Given a recovery from bus-off that has ended because the short is gone, when the longest time of a recovery is over, then the
/// controller is left alone, and all attempts of a new window are there for the next short.
///
/// Verifies: ECSS 5.3.3.2.3h, 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3j
/// Notices: ECSS 5.3.3.2.3h: a recovery that has ended counts as another bus-off when its longest time is over.
#[test]
fn recovered_controller_is_left_alone() {
    let mut recovery = BusOffRecovery::new(POLICY);
    recovery.on_state(BusOff, ms(100));
    assert_eq!(recovery.poll(ms(110)), Some(RecoveryStep::Recover));
    recovery.on_state(Active, ms(112));
    assert_eq!(recovery.deadline(), None);
    for at in [160, 170, 1_100] {
        assert_eq!((recovery.poll(ms(at)), recovery.is_failed()), (None, false), "{at} ms");
    }
    for at in [1_200, 1_300] {
        assert_eq!(recovery.on_state(BusOff, ms(at)), None);
        assert_eq!(recovery.poll(ms(at + 10)), Some(RecoveryStep::Recover));
        recovery.on_state(Active, ms(at + 12));
    }
}

#[test]
fn bus_off_before_end_of_the_first_was_reported_is_new_attempt() {
    let mut recovery = BusOffRecovery::new(POLICY);
    recovery.on_state(BusOff, ms(100));
    assert_eq!(recovery.poll(ms(110)), Some(RecoveryStep::Recover));
    recovery.on_state(Active, ms(113));
    recovery.on_state(BusOff, ms(113));
    assert_eq!(recovery.deadline(), Some(ms(123)));
    assert_eq!(recovery.poll(ms(123)), Some(RecoveryStep::Recover));
    recovery.on_state(Active, ms(126));
    assert_eq!(recovery.on_state(BusOff, ms(126)), Some(RecoveryStep::Failed));
}
