//! COB-IDs in the boot-up process: no two nodes of a network may send the same one (ECSS 6.10l, m).
//!
//! Verifies: ECSS 6.10l, 6.10m

use async_canopen::boot::machine::{Assignment, BootRequest};
use async_canopen::boot::{
    AssignedSlave, BootCause, BootError, BootFailure, BootPolicy, BootProgress, Expected,
};
use async_canopen::sdo::Error;
use async_canopen::types::{AbortCode, Address, CobId, NmtState};

use crate::bench::{ms, node, span};
use crate::boot::Bench;

/// Nothing is expected of a slave.
const ANY: Expected = Expected { device_type: 0, identity: [0; 4], stamp: [0; 2] };

/// A slave: what it answers for its emergencies and TPDOs, in their order. `None`: it has no such object.
type Sent<'a> = &'a [Option<u32>];

/// Slaves 2 to 127 assigned. The master sends 181h and 305h.
struct Network(Bench);

impl Network {
    fn new() -> Network {
        let mut boot = Bench::new(BootPolicy { time: span(0), goes_on: false }, &[]);
        for node in (2..=127).map(node) {
            boot.assign(node, AssignedSlave { node, mandatory: false, expected: ANY }.assignment());
        }
        boot.start(ms(0));
        Network(boot)
    }

    /// Boots a slave. Returns the reason if it is not started.
    fn boot(&mut self, raw: u8, sent: Sent) -> Result<(), BootFailure> {
        let Network(boot) = self;
        boot.on_heartbeat(node(raw), NmtState::Initialising, true, false);
        self.check(raw, sent)
    }

    fn check(&mut self, raw: u8, sent: Sent) -> Result<(), BootFailure> {
        let Network(boot) = self;
        let mut left = sent.iter();
        let is_own = |id: CobId| [0x181, 0x305].contains(&id.raw());
        while let Some(request) = boot.request(|_| ANY, None) {
            let BootRequest::Read { node, at, .. } = request else { panic!("{request:?}") };
            assert_eq!(node.get(), raw);
            let value = if at.index == 0x1000 { Some(0) } else { left.next().copied().flatten() };
            match value {
                Some(value) => {
                    boot.on_data(&value.to_le_bytes());
                    boot.on_done(Ok(()), is_own);
                }
                None => boot.on_done(Err(Error::Abort(AbortCode::NoObject)), is_own),
            }
        }
        match boot.take_failure() {
            Some((_, failure)) => Err(failure),
            None => {
                assert_eq!(boot.take_start(), Some(node(raw)));
                Ok(())
            }
        }
    }
}

fn in_use(at: Address, raw: u16, other: u8) -> Result<(), BootFailure> {
    let cause = BootCause::CobIdInUse { at, id: CobId::new(raw).unwrap(), other: node(other) };
    Err(BootFailure { error: BootError::Configuration, cause })
}

const EMCY: Address = Address::new(0x1014, 0);
const SECOND: Address = Address::new(0x1801, 1);
/// A PDO with bit 31 is not valid; bit 30, no RTR, is always set.
const INVALID: u32 = 1 << 31;
const NO_REMOTE: u32 = 1 << 30;

/// Given slave 2 that sends 3A0h, When slave 3 boots up with that COB-ID in its second TPDO, Then it is not started.
///
/// Verifies: ECSS 7.2.3j, 7.2.2g
/// Notices: ECSS 7.2.3j: two slaves that send one Local Time PDO are started.
#[test]
fn a_slave_with_the_cob_id_of_another_one_is_not_started() {
    let mut network = Network::new();
    assert_eq!(network.boot(2, &[Some(0x82), Some(NO_REMOTE | 0x182), Some(NO_REMOTE | 0x3A0)]), Ok(()));
    let three = [Some(0x83), Some(NO_REMOTE | 0x183), Some(NO_REMOTE | 0x3A0)];
    assert_eq!(network.boot(3, &three), in_use(SECOND, 0x3A0, 2));
    assert_eq!(network.0.progress(node(3)), BootProgress::Failed);
    assert_eq!(network.boot(4, &[Some(0x82)]), in_use(EMCY, 0x82, 2));
    let local_time = Address::new(0x1800, 1);
    assert_eq!(network.boot(4, &[Some(0x84), Some(NO_REMOTE | 0x182)]), in_use(local_time, 0x182, 2));
    // Not valid: not sent.
    let three = [Some(INVALID | 0x82), Some(INVALID | NO_REMOTE | 0x182), Some(INVALID | 0x3A0)];
    assert_eq!(network.boot(3, &three), Ok(()));
}

#[test]
fn a_slave_with_a_cob_id_of_the_master_is_not_started() {
    let mut network = Network::new();
    assert_eq!(network.boot(5, &[None, None, Some(0x305)]), in_use(SECOND, 0x305, 1));
}

/// Given a slave that boots up again, Then its own COB-IDs are no clash. When it has moved one, Then another slave may
/// have that one.
#[test]
fn a_slave_that_boots_again_has_its_own_cob_ids() {
    let mut network = Network::new();
    for _ in 0..3 {
        assert_eq!(network.boot(2, &[Some(0x82), Some(0x3A0), Some(0x3A1)]), Ok(()));
    }
    assert_eq!(network.boot(2, &[Some(0x82), Some(0x3A2)]), Ok(()));
    assert_eq!(network.boot(3, &[Some(0x83), Some(0x3A0)]), Ok(()));
    // One that is not assigned any more has none.
    network.0.assign(node(3), Assignment::from_raw(0));
    assert_eq!(network.boot(4, &[Some(0x84), Some(0x3A0)]), Ok(()));
}

/// A device may have TPDO 1 and 8 alone.
#[test]
fn the_first_eight_tpdos_are_compared_with_gaps() {
    let mut network = Network::new();
    assert_eq!(network.boot(2, &[Some(0x82), Some(0x3A0)]), Ok(()));
    let eighth = [None, None, None, None, None, None, None, None, Some(0x3A0)];
    assert_eq!(network.boot(3, &eighth), in_use(Address::new(0x1807, 1), 0x3A0, 2));
}

/// Given a slave that runs, When a check finds that it sends a COB-ID of another one, Then it is not started again.
#[test]
fn a_running_slave_that_took_a_cob_id_is_not_started_again() {
    let mut network = Network::new();
    assert_eq!(network.boot(2, &[Some(0x82), Some(0x3A0)]), Ok(()));
    assert_eq!(network.boot(3, &[Some(0x83), Some(0x3A1)]), Ok(()));
    assert!(network.0.on_heartbeat(node(3), NmtState::PreOperational, true, true));
    assert_eq!(network.check(3, &[Some(0x83), Some(0x3A0)]), in_use(Address::new(0x1800, 1), 0x3A0, 2));
    assert!(!network.0.on_heartbeat(node(3), NmtState::PreOperational, true, false));
}

/// Given a slave that uses 183h while slave 3 does not send it, Then it may, and slave 3 may not send it later.
#[test]
fn a_predefined_cob_id_belongs_to_the_slave_that_sends_it_first() {
    let mut network = Network::new();
    assert_eq!(network.boot(3, &[Some(0x83)]), Ok(()));
    assert_eq!(network.boot(2, &[Some(0x82), Some(0x183)]), Ok(()));
    assert_eq!(network.boot(3, &[Some(0x83), Some(0x183)]), in_use(Address::new(0x1800, 1), 0x183, 2));
}

/// All 126 slaves with the COB-IDs of the pre-defined connection set are compared. The table has room for 64 others.
#[test]
fn a_network_with_too_many_cob_ids_is_reported() {
    let mut network = Network::new();
    for slave in 2..=127 {
        let own = [0x80, 0x180, 0x280, 0x380, 0x480].map(|function| Some(function + u32::from(slave)));
        assert_eq!(network.boot(slave, &own), Ok(()), "{slave}");
    }
    let eight = |first: u32| -> Vec<Option<u32>> { (first..first + 8).map(Some).collect() };
    for slave in 2..10 {
        assert_eq!(network.boot(slave, &eight(0x500 + 8 * u32::from(slave))), Ok(()));
    }
    let failure = BootFailure { error: BootError::Configuration, cause: BootCause::TooManyCobIds };
    assert_eq!(network.boot(10, &[Some(0x680)]), Err(failure));
    assert_eq!(network.boot(10, &[Some(0x8A)]), Ok(()));
}
