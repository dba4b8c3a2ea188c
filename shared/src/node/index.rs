//! Indices of the objects that a node checks and follows. Constants take them from the declarations. Their names
//! are those of CiA 301 and ECSS-E-ST-50-15C.

use super::{Communication, NetworkObjects, Spacecraft};
use crate::emcy::EmcyObjects;
use crate::heartbeat::{HeartbeatConsumers, HeartbeatProducer};
use crate::pdo::PdoObjects;
use crate::redundancy::RedundancyObjects;
use crate::store::StoreObjects;
use crate::sync::SyncObjects;
use crate::time::{ClockObjects, LocalScet, LocalUtc};

pub const PRE_DEFINED_ERRORS: u16 = EmcyObjects::ERRORS.index();
pub const SYNC_COB_ID: u16 = SyncObjects::COB_ID.index();
pub const CYCLE_PERIOD: u16 = SyncObjects::CYCLE_PERIOD.index();
pub const SYNC_OVERFLOW: u16 = SyncObjects::OVERFLOW.index();
pub const STORE: u16 = StoreObjects::STORE.index();
pub const RESTORE: u16 = StoreObjects::RESTORE.index();
pub const EMCY_COB_ID: u16 = EmcyObjects::COB_ID.index();
pub const CONSUMER_HEARTBEAT: u16 = <HeartbeatConsumers>::CONSUMER_HEARTBEAT.index();
pub const PRODUCER_HEARTBEAT: u16 = HeartbeatProducer::TIME.index();
pub const CONFIGURATION: u16 = Communication::CONFIGURATION.index();

pub const ASSIGNMENT: u16 = NetworkObjects::ASSIGNMENT.index();
pub const REQUEST_NMT: u16 = NetworkObjects::REQUEST_NMT.index();
pub const SYNC_DITHER: u16 = NetworkObjects::SYNC_DITHER.index();
pub const RANGING: u16 = NetworkObjects::RANGING.index();

pub const REDUNDANCY: u16 = RedundancyObjects::PARAMETERS.index();
pub const SCET_SET: u16 = LocalScet::SCET_SET.index();
pub const SCET_GET: u16 = LocalScet::SCET_GET.index();
pub const UTC_SET: u16 = LocalUtc::UTC_SET.index();
pub const UTC_GET: u16 = LocalUtc::UTC_GET.index();
pub const CLOCK_QUALITY: u16 = ClockObjects::QUALITY.index();
pub const HEARTBEAT_SENT: u16 = ClockObjects::HEARTBEAT_SENT.index();
pub const HEALTH_NOMINAL: u16 = Spacecraft::HEALTH_NOMINAL.index();
pub const HEALTH_REDUNDANT: u16 = Spacecraft::HEALTH_REDUNDANT.index();
pub const SELF_TEST_START: u16 = Spacecraft::SELF_TEST_START.index();
pub const IDENTITY: u16 = Spacecraft::IDENTITY.index();

/// Communication parameter of RPDO 1.
pub const RPDO: u16 = <PdoObjects>::RPDOS.nth(0).index();
/// Mapping parameter of RPDO 1.
pub const RPDO_MAPPING: u16 = <PdoObjects>::RPDO_MAPPINGS.nth(0).index();
/// Communication parameter of TPDO 1.
pub const TPDO: u16 = <PdoObjects>::TPDOS.nth(0).index();
/// Mapping parameter of TPDO 1.
pub const TPDO_MAPPING: u16 = <PdoObjects>::TPDO_MAPPINGS.nth(0).index();

/// Last of 512 indices in a row (CiA 301 7.5.1).
const fn last_of(first: u16) -> u16 {
    first + 0x1FF
}

/// Communication parameter of RPDO 512.
pub const LAST_RPDO: u16 = last_of(RPDO);
/// Mapping parameter of RPDO 512.
pub const LAST_RPDO_MAPPING: u16 = last_of(RPDO_MAPPING);
/// Communication parameter of TPDO 512.
pub const LAST_TPDO: u16 = last_of(TPDO);
/// Mapping parameter of TPDO 512.
pub const LAST_TPDO_MAPPING: u16 = last_of(TPDO_MAPPING);
