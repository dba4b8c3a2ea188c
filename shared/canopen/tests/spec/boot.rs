//! The boot-up process of the network, sans-IO: what slaves say goes in, SDO transfers come out.

use std::ops::{Deref, DerefMut};

use async_canopen::boot::machine::{Boot, BootAction, BootRequest, Identified};
use async_canopen::boot::{
    AssignedSlave, BootCause, BootError, BootFailure, BootPolicy, BootProgress, Difference, Expected, Setting,
};
use async_canopen::sdo::Error;
use async_canopen::types::{AbortCode, Address, CobId, Instant, NmtState, NodeId};

use crate::bench::{ms, node, span};

pub(crate) const TWO: NodeId = NodeId::of::<2>();
pub(crate) const THREE: NodeId = NodeId::of::<3>();

const SETTINGS: &[Setting] = &[
    Setting { node: TWO, at: Address::new(0x1017, 0), value: &[100, 0] },
    Setting { node: THREE, at: Address::new(0x1017, 0), value: &[200, 0] },
    Setting { node: TWO, at: Address::new(0x6200, 1), value: &[1, 2, 3, 4, 5, 6] },
];

pub(crate) const POLICY: BootPolicy = BootPolicy { time: span_ms(500), goes_on: false };

const fn span_ms(ms: u64) -> async_canopen::types::Duration {
    async_canopen::types::Duration::from_millis(ms)
}

pub(crate) fn expected() -> Expected {
    Expected { device_type: 0x191, identity: [7, 8, 9, 10], stamp: [0; 2] }
}

pub(crate) const OBJECTS: Identified = Identified {
    device_type: 0x1000,
    identity: 0x1018,
    configuration: 0x1020,
    rpdo: 0x1400,
    emergency: 0x1014,
    tpdo: 0x1800,
};

/// A boot-up process, with those of its actions that no test has taken yet.
pub(crate) struct Bench {
    boot: Boot,
    now: Instant,
    actions: Vec<BootAction>,
}

impl Bench {
    pub(crate) fn new(policy: BootPolicy, settings: &'static [Setting]) -> Bench {
        Bench { boot: Boot::new(policy, OBJECTS, settings), now: ms(0), actions: Vec::new() }
    }

    /// Returns whether the end of the boot-up is reported.
    pub(crate) fn poll(&mut self, now: Instant) -> bool {
        self.now = now;
        self.take(|action| (*action == BootAction::ReportCompleted).then_some(())).is_some()
    }

    pub(crate) fn take_start(&mut self) -> Option<NodeId> {
        self.take(|action| if let BootAction::Start(node) = action { Some(*node) } else { None })
    }

    pub(crate) fn take_change(&mut self) -> Option<(NodeId, BootProgress)> {
        self.take(|action| match action {
            BootAction::ReportProgress { node, progress } => Some((*node, *progress)),
            _ => None,
        })
    }

    pub(crate) fn take_deviation(&mut self) -> Option<(NodeId, Difference)> {
        self.take(|action| match action {
            BootAction::Hold { node, difference } => Some((*node, *difference)),
            _ => None,
        })
    }

    pub(crate) fn take_failure(&mut self) -> Option<(NodeId, BootFailure)> {
        self.take(|action| match action {
            BootAction::ReportFailure { node, failure } => Some((*node, *failure)),
            _ => None,
        })
    }

    /// Takes the first action of a kind.
    fn take<R>(&mut self, is_it: impl Fn(&BootAction) -> Option<R>) -> Option<R> {
        let Bench { boot, now, actions } = self;
        actions.extend(std::iter::from_fn(|| boot.poll(*now)));
        let place = actions.iter().position(|action| is_it(action).is_some())?;
        is_it(&actions.remove(place))
    }
}

impl Deref for Bench {
    type Target = Boot;

    fn deref(&self) -> &Boot {
        &self.boot
    }
}

impl DerefMut for Bench {
    fn deref_mut(&mut self) -> &mut Boot {
        &mut self.boot
    }
}

/// Slave 2 mandatory, slave 3 optional.
pub(crate) fn started(policy: BootPolicy) -> Bench {
    let mut boot = Bench::new(policy, SETTINGS);
    for (node, mandatory) in [(TWO, true), (THREE, false)] {
        boot.assign(node, AssignedSlave { node, mandatory, expected: expected() }.assignment());
    }
    boot.start(ms(0));
    boot.poll(ms(0));
    boot
}

pub(crate) fn boots_up(boot: &mut Boot, node: NodeId) {
    assert!(!boot.on_heartbeat(node, NmtState::Initialising, true, false), "not before it was checked");
}

/// A failure of the slave without an object.
fn silence(node: NodeId, error: BootError) -> Option<(NodeId, BootFailure)> {
    Some((node, BootFailure { error, cause: BootCause::Silence }))
}

/// A failed transfer.
pub(crate) fn transfer(
    node: NodeId,
    error: BootError,
    at: Address,
    code: u32,
) -> Option<(NodeId, BootFailure)> {
    Some((node, BootFailure { error, cause: BootCause::Transfer { at, code } }))
}

/// The master sends none of the COB-IDs.
pub(crate) const NOT_OWN: fn(CobId) -> bool = |_| false;

/// A transfer, and what is done to it.
#[derive(Debug, PartialEq)]
pub(crate) enum Asked {
    Read(u8, u16, u8),
    Write(u8, u16, u8, Vec<u8>),
}

pub(crate) fn next(boot: &mut Boot, expected: Expected) -> Option<Asked> {
    boot.request(|_| expected, None).map(|request| match request {
        BootRequest::Read { node, at, .. } => Asked::Read(node.get(), at.index, at.sub),
        BootRequest::Write { node, at, value } => Asked::Write(node.get(), at.index, at.sub, value.to_vec()),
    })
}

pub(crate) fn answer(boot: &mut Boot, data: &[u8]) {
    boot.on_data(data);
    boot.on_done(Ok(()), NOT_OWN);
}

/// The slave has neither emergencies nor TPDOs: none of the objects with their COB-IDs exists.
pub(crate) fn sends_nothing(boot: &mut Boot, node: u8, expected: Expected) {
    let objects = [(0x1014, 0)].into_iter().chain((0x1800..0x1808).map(|index| (index, 1)));
    for (index, sub) in objects {
        assert_eq!(next(boot, expected), Some(Asked::Read(node, index, sub)));
        boot.on_done(Err(Error::Abort(AbortCode::NoObject)), NOT_OWN);
    }
}

/// Goes through device type and identity.
pub(crate) fn identify(boot: &mut Boot, node: u8) {
    let values = [(0x1000, 0, 0x191_u32), (0x1018, 1, 7), (0x1018, 2, 8), (0x1018, 3, 9), (0x1018, 4, 10)];
    for (index, sub, value) in values {
        assert_eq!(next(boot, expected()), Some(Asked::Read(node, index, sub)));
        answer(boot, &value.to_le_bytes());
    }
}

#[test]
fn a_slave_is_identified_compared_and_started() {
    let mut boot = started(POLICY);
    assert_eq!(next(&mut boot, expected()), None);
    boots_up(&mut boot, TWO);
    identify(&mut boot, 2);
    assert_eq!(boot.progress(TWO), BootProgress::Comparing);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1017, 0)));
    answer(&mut boot, &[100, 0]);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x6200, 1)));
    // In two parts
    boot.on_data(&[1, 2, 3, 4]);
    answer(&mut boot, &[5, 6]);
    assert_eq!(boot.progress(TWO), BootProgress::Configuring);
    sends_nothing(&mut boot, 2, expected());
    assert_eq!(boot.take_start(), Some(TWO));
    assert_eq!((boot.progress(TWO), next(&mut boot, expected())), (BootProgress::Started, None));
    assert!(!boot.poll(ms(1)) && boot.is_released());
}

#[test]
fn what_differs_is_written_and_nothing_else() {
    // Another value, fewer bytes, more bytes, and an object that can only be written.
    let differing: [(&[u8], Result<(), Error>); 4] = [
        (&[101, 0], Ok(())),
        (&[100], Ok(())),
        (&[], Err(Error::TooLarge)),
        (&[], Err(Error::Abort(AbortCode::WriteOnly))),
    ];
    for (data, outcome) in differing {
        let mut boot = started(POLICY);
        boots_up(&mut boot, THREE);
        identify(&mut boot, 3);
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(3, 0x1017, 0)));
        boot.on_data(data);
        boot.on_done(outcome, NOT_OWN);
        assert_eq!(next(&mut boot, expected()), Some(Asked::Write(3, 0x1017, 0, vec![200, 0])));
        assert_eq!(boot.progress(THREE), BootProgress::Configuring);
        boot.on_done(Ok(()), NOT_OWN);
        sends_nothing(&mut boot, 3, expected());
        assert_eq!((next(&mut boot, expected()), boot.take_start()), (None, Some(THREE)));
    }
}

/// Verifies: ECSS 11.1d
/// Notices: ECSS 11.1d: the serial number of a slave is not compared.
#[test]
fn every_wrong_part_of_the_identity_has_its_letter() {
    for (wrong, error, letter, at, value) in [
        (0, BootError::DeviceType, 'C', Address::new(0x1000, 0), 0x191),
        (1, BootError::Vendor, 'D', Address::new(0x1018, 1), 7),
        (2, BootError::Product, 'M', Address::new(0x1018, 2), 8),
        (3, BootError::Revision, 'N', Address::new(0x1018, 3), 9),
        (4, BootError::Serial, 'O', Address::new(0x1018, 4), 10),
    ] {
        let mut boot = started(POLICY);
        boots_up(&mut boot, TWO);
        for value in [0x191_u32, 7, 8, 9, 10].into_iter().take(wrong) {
            next(&mut boot, expected());
            answer(&mut boot, &value.to_le_bytes());
        }
        next(&mut boot, expected());
        answer(&mut boot, &0xBAD_u32.to_le_bytes());
        let cause = BootCause::Difference(Difference { at, expected: value, found: 0xBAD });
        assert_eq!(boot.take_failure(), Some((TWO, BootFailure { error, cause })));
        assert_eq!((error.letter(), char::from(error as u8), cause.abort_code()), (letter, letter, 0));
        assert_eq!((boot.progress(TWO), boot.take_start()), (BootProgress::Failed, None));
        // Not started though it waits, and nobody is asked any more.
        assert!(!boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
        assert_eq!(next(&mut boot, expected()), None);
    }
}

#[test]
fn aborts_fail_with_the_letter_of_their_step_and_their_code() {
    let abort = Err(Error::Abort(AbortCode::NoObject));
    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    for _ in 0..2 {
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
        boot.on_done(abort, NOT_OWN);
    }
    let device_type = Address::new(0x1000, 0);
    let failure = transfer(TWO, BootError::NoResponse, device_type, 0x0602_0000);
    assert_eq!(boot.take_failure(), failure);

    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    for _ in 0..2 {
        identify(&mut boot, 2);
        next(&mut boot, expected());
        answer(&mut boot, &[0, 0]);
        next(&mut boot, expected());
        boot.on_done(Err(Error::Abort(AbortCode::ReadOnly)), NOT_OWN);
    }
    let failure = transfer(TWO, BootError::Configuration, Address::new(0x1017, 0), 0x0601_0002);
    assert_eq!(boot.take_failure(), failure);
    assert_eq!(failure.unwrap().1.cause.abort_code(), 0x0601_0002);
}

/// Given a slave that aborts a transfer once, because it is busy, then its check begins again and it is started.
#[test]
fn slave_that_aborts_once_is_checked_again() {
    for busy in [Error::Abort(AbortCode::DeviceState), Error::UnknownAbort(0x1234_5678)] {
        let mut boot = started(POLICY);
        boots_up(&mut boot, TWO);
        next(&mut boot, expected());
        answer(&mut boot, &0x191_u32.to_le_bytes());
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1018, 1)));
        boot.on_done(Err(busy), NOT_OWN);
        assert_eq!((boot.take_failure(), boot.progress(TWO)), (None, BootProgress::Checking));
        identify(&mut boot, 2);
        next(&mut boot, expected());
        answer(&mut boot, &[100, 0]);
        next(&mut boot, expected());
        answer(&mut boot, &[1, 2, 3, 4, 5, 6]);
        sends_nothing(&mut boot, 2, expected());
        assert_eq!((boot.take_start(), boot.take_failure()), (Some(TWO), None));
    }
}

/// Given slaves whose check failed, by a wrong identity and by silence, when the bus changes, then each is checked again once
/// it is heard on the new bus, not before.
#[test]
fn failed_slave_begins_again_after_a_change_of_bus() {
    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    boots_up(&mut boot, THREE);
    next(&mut boot, expected());
    answer(&mut boot, &0xBAD_u32.to_le_bytes());
    for _ in 0..3 {
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(3, 0x1000, 0)));
        boot.on_done(Err(Error::Timeout), NOT_OWN);
    }
    assert_eq!([TWO, THREE].map(|node| boot.progress(node)), [BootProgress::Failed; 2]);
    boot.on_bus_changed();
    assert_eq!([TWO, THREE].map(|node| boot.progress(node)), [BootProgress::Awaited; 2]);
    assert_eq!(next(&mut boot, expected()), None);
    for node in [TWO, THREE] {
        assert!(
            !boot.on_heartbeat(node, NmtState::PreOperational, true, false),
            "checked before it is started"
        );
    }
    // In turn: 3 was the last one.
    identify(&mut boot, 2);
    assert_eq!(boot.progress(TWO), BootProgress::Comparing);
}

/// Verifies: ECSS 5.3.3.2.2b
/// Notices: ECSS 5.3.3.2.2b: a slave without power is asked without end, and the next slaves wait.
#[test]
fn a_slave_that_does_not_answer_is_asked_three_times() {
    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    for _ in 0..3 {
        assert_eq!(boot.take_failure(), None);
        assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
        boot.on_done(Err(Error::Timeout), NOT_OWN);
    }
    let failure = transfer(TWO, BootError::NoResponse, Address::new(0x1000, 0), 0x0504_0000);
    assert_eq!(boot.take_failure(), failure);
    // The application may try again, the slave may boot up again.
    boot.queue(TWO);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
    boots_up(&mut boot, TWO);
    assert!(!boot.is_asking(), "what was asked before the boot-up is no longer wanted");
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
}

#[test]
fn matching_stamp_skips_comparison_and_other_is_written_last() {
    let stamped = Expected { device_type: 0, identity: [0; 4], stamp: [5, 6] };
    let mut boot = started(POLICY);
    boots_up(&mut boot, THREE);
    assert_eq!(next(&mut boot, stamped), Some(Asked::Read(3, 0x1000, 0)), "read, though not compared");
    answer(&mut boot, &[0xFF; 4]);
    for (sub, value) in [(1, 5_u32), (2, 6)] {
        assert_eq!(next(&mut boot, stamped), Some(Asked::Read(3, 0x1020, sub)));
        answer(&mut boot, &value.to_le_bytes());
    }
    assert_eq!(boot.progress(THREE), BootProgress::Comparing);
    sends_nothing(&mut boot, 3, stamped);
    assert_eq!((next(&mut boot, stamped), boot.take_start()), (None, Some(THREE)));

    boots_up(&mut boot, THREE);
    next(&mut boot, stamped);
    answer(&mut boot, &[0; 4]);
    next(&mut boot, stamped);
    answer(&mut boot, &[0; 4]);
    assert_eq!(next(&mut boot, stamped), Some(Asked::Read(3, 0x1017, 0)));
    answer(&mut boot, &[200, 0]);
    sends_nothing(&mut boot, 3, stamped);
    for (sub, value) in [(1, 5_u32), (2, 6)] {
        assert_eq!(
            next(&mut boot, stamped),
            Some(Asked::Write(3, 0x1020, sub, value.to_le_bytes().to_vec()))
        );
        boot.on_done(Ok(()), NOT_OWN);
    }
    assert_eq!(boot.take_start(), Some(THREE));

    // A slave without 1020h is compared, and not stamped.
    boots_up(&mut boot, THREE);
    next(&mut boot, stamped);
    answer(&mut boot, &[0; 4]);
    next(&mut boot, stamped);
    boot.on_done(Err(Error::Abort(AbortCode::NoObject)), NOT_OWN);
    next(&mut boot, stamped);
    answer(&mut boot, &[200, 0]);
    sends_nothing(&mut boot, 3, stamped);
    assert_eq!((next(&mut boot, stamped), boot.take_start()), (None, Some(THREE)));
}

#[test]
fn slaves_take_turns_and_a_lost_one_makes_room() {
    let mut boot = started(POLICY);
    boots_up(&mut boot, THREE);
    boots_up(&mut boot, TWO);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
    assert_eq!(boot.progress(THREE), BootProgress::Queued);
    boot.on_lost(TWO);
    assert_eq!(boot.take_failure(), silence(TWO, BootError::Lost));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(3, 0x1000, 0)));
    boot.on_lost(THREE);
    // Back without a boot-up message, slave 2 is next.
    assert!(!boot.on_heartbeat(TWO, NmtState::PreOperational, true, true));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
}

#[test]
fn a_queued_slave_that_is_lost_is_awaited() {
    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    boot.on_lost(TWO);
    assert_eq!((boot.progress(TWO), next(&mut boot, expected())), (BootProgress::Awaited, None));
}

#[test]
fn boot_after_bus_switch_waits_for_slaves_heard_on_new_bus() {
    let mut boot = started(POLICY);
    boots_up(&mut boot, TWO);
    boots_up(&mut boot, THREE);
    next(&mut boot, expected());
    boot.on_bus_changed();
    assert_eq!((boot.is_asking(), next(&mut boot, expected())), (false, None));
    assert!(!boot.on_heartbeat(THREE, NmtState::PreOperational, false, false));
    assert_eq!(next(&mut boot, expected()), None);
    boot.on_heartbeat(THREE, NmtState::PreOperational, true, false);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(3, 0x1000, 0)));
    assert_eq!(boot.take_failure(), None);
}

/// Slave 2 goes through everything.
pub(crate) fn configure_two(boot: &mut Bench) {
    boots_up(boot, TWO);
    identify(boot, 2);
    next(boot, expected());
    answer(boot, &[100, 0]);
    next(boot, expected());
    answer(boot, &[1, 2, 3, 4, 5, 6]);
    sends_nothing(boot, 2, expected());
    assert_eq!(boot.take_start(), Some(TWO));
}

/// Verifies: ECSS 5.3.3.2.3k.2, 8.3.3f
/// Notices: ECSS 5.3.3.2.3k.2: a slave that returns is not checked.
#[test]
fn started_slave_is_started_again_at_once_until_it_boots_up() {
    let mut boot = started(POLICY);
    configure_two(&mut boot);
    assert!(
        boot.on_heartbeat(TWO, NmtState::PreOperational, true, false),
        "it toggled, or missed the master"
    );
    assert_eq!(next(&mut boot, expected()), None);
    // It was lost and returns: started at once, and checked, because its boot-up may have been missed.
    assert!(boot.on_heartbeat(TWO, NmtState::PreOperational, true, true));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
    // A boot-up message on the other bus counts as well.
    assert!(!boot.on_heartbeat(TWO, NmtState::Initialising, false, false));
    assert!(!boot.on_heartbeat(TWO, NmtState::PreOperational, true, false));
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
}

#[test]
fn completion_is_never_told_without_mandatory_slaves() {
    let mut boot = Bench::new(POLICY, SETTINGS);
    boot.assign(THREE, AssignedSlave { node: THREE, mandatory: false, expected: expected() }.assignment());
    boot.start(ms(0));
    assert!(!boot.poll(ms(0)) && boot.is_released());
    boot.on_sync_sent();
    assert!(!boot.poll(ms(1)) && !boot.poll(ms(2)));
}

/// Verifies: ECSS 6.9d
#[test]
fn sync_waits_for_mandatory_slaves_completion_until_they_follow() {
    let mut boot = started(POLICY);
    assert!(!boot.poll(ms(1)) && !boot.is_released());
    configure_two(&mut boot);
    boot.on_heartbeat(TWO, NmtState::Operational, true, false);
    assert!(!boot.poll(ms(2)) && boot.is_released());
    assert_eq!(boot.progress(TWO), BootProgress::Started, "no SYNC yet");
    boot.on_sync_sent();
    assert!(!boot.poll(ms(3)));
    boot.on_synchronous(TWO);
    assert_eq!(boot.progress(TWO), BootProgress::Booted);
    assert!(boot.poll(ms(4)), "slave 3 is optional");
    assert!(!boot.poll(ms(5)), "told once");
}

/// Verifies: ECSS 6.9d
#[test]
fn after_the_boot_time_silent_mandatory_slaves_are_told_once() {
    let mut boot = started(POLICY);
    assert_eq!(boot.deadline(), Some(ms(500)));
    boot.poll(ms(499));
    assert_eq!(boot.take_failure(), None);
    boot.poll(ms(500));
    assert_eq!(boot.take_failure(), silence(TWO, BootError::Silent));
    assert_eq!((boot.take_failure(), boot.deadline(), boot.is_released()), (None, None, false));
    configure_two(&mut boot);
    boot.poll(ms(600));
    assert!(boot.is_released());

    let mut boot = started(BootPolicy { goes_on: true, ..POLICY });
    boot.poll(ms(500));
    assert!(boot.take_failure().is_some() && boot.is_released());
    boot.on_sync_sent();
    assert!(boot.poll(ms(501)), "nobody waits for it any more");
}

/// Given a boot time after which the network goes on, when a mandatory slave is disconnected or loses power while it is checked, then
/// SYNC begins for the others at the end of the boot time.
///
/// Verifies: ECSS 5.3.3.2.2a, 5.3.3.2.2b, 6.9d
/// Notices: ECSS 5.3.3.2.2a: SYNC waits for ever for a slave that was heard and then disconnected.
/// Notices: ECSS 5.3.3.2.2b: SYNC waits for ever for a slave that lost power during its boot-up.
#[test]
fn slave_lost_in_its_boot_up_does_not_hold_others_up() {
    let mut boot = started(BootPolicy { goes_on: true, ..POLICY });
    boots_up(&mut boot, TWO);
    boot.on_heartbeat(TWO, NmtState::PreOperational, true, false);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(2, 0x1000, 0)));
    boot.on_lost(TWO);
    assert_eq!(boot.progress(TWO), BootProgress::Failed);
    boot.poll(ms(499));
    assert!(!boot.is_released());
    boot.poll(ms(500));
    assert!(boot.is_released());
}

/// Verifies: ECSS 6.9d, 8.3.3f
#[test]
fn no_boot_time_reports_no_silence_and_no_slaves_release_sync() {
    let boot = started(BootPolicy { time: span(0), ..POLICY });
    assert_eq!(boot.deadline(), None);
    let mut boot = Bench::new(POLICY, &[]);
    boot.start(ms(0));
    boot.poll(ms(0));
    assert!(boot.is_released());
    assert!(boot.on_heartbeat(node(9), NmtState::PreOperational, true, false), "started as it is");
    boot.on_sync_sent();
    assert!(!boot.poll(ms(1)), "there was no process to complete");
}

/// Verifies: ECSS 8.3.3f
#[test]
fn slave_assigned_in_flight_boots_at_heartbeat_until_released() {
    let mut boot = started(POLICY);
    let nine = AssignedSlave { node: node(9), mandatory: false, expected: expected() }.assignment();
    boot.assign(node(9), nine);
    boot.on_heartbeat(node(9), NmtState::Operational, true, false);
    assert_eq!(next(&mut boot, expected()), Some(Asked::Read(9, 0x1000, 0)));
    boot.assign(node(9), async_canopen::boot::machine::Assignment::from_raw(0));
    assert_eq!((boot.is_asking(), boot.progress(node(9))), (false, BootProgress::Unassigned));
    boot.queue(node(9));
    assert_eq!(next(&mut boot, expected()), None);
    assert!(boot.on_heartbeat(node(9), NmtState::PreOperational, true, false));
}

#[test]
fn changes_of_progress_are_told_once_each() {
    let mut boot = started(POLICY);
    assert_eq!(boot.take_change(), Some((TWO, BootProgress::Awaited)));
    assert_eq!(boot.take_change(), Some((THREE, BootProgress::Awaited)));
    assert_eq!((boot.take_change(), boot.is_due()), (None, false));
    boots_up(&mut boot, THREE);
    assert!(boot.is_due() && boot.is_busy());
    assert_eq!(boot.take_change(), Some((THREE, BootProgress::Queued)));
}

/// The pre-defined connection set, unless a setting moves a TPDO of a slave.
///
/// Verifies: ECSS 6.10m
#[test]
fn pdo_of_a_slave_is_known_by_its_configured_cob_id() {
    let cob_id =
        |index, sub| Setting { node: TWO, at: Address::new(index, sub), value: &[0xC3, 0x04, 0, 0x40] };
    let producer = |settings: &'static [Setting], raw| {
        Bench::new(POLICY, settings).producer(async_canopen::types::CobId::new(raw).unwrap())
    };
    assert_eq!(producer(SETTINGS, 0x4C3), NodeId::new(0x43));
    let moved: &[Setting] = Box::leak(Box::new([cob_id(0x1802, 1)]));
    assert_eq!(producer(moved, 0x4C3), Some(TWO));
    assert_eq!(producer(moved, 0x383), Some(THREE));
    for other in [cob_id(0x1802, 2), cob_id(0x1402, 1), cob_id(0x1A00, 1)] {
        assert_eq!(producer(Box::leak(Box::new([other])), 0x4C3), NodeId::new(0x43));
    }
}
