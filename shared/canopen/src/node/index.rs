//! Indices of the objects that a node checks and follows. Constants take them from the declarations. Their names
//! are those of CiA 301.

use crate::emcy::EmcyObjects;
use crate::heartbeat::{HeartbeatConsumers, HeartbeatProducer};
use crate::nmt::NmtObjects;
use crate::node::Communication;
use crate::pdo::PdoObjects;
use crate::store::StoreObjects;
use crate::sync::SyncObjects;

/// Pre-defined error field.
pub const PRE_DEFINED_ERRORS: u16 = EmcyObjects::ERRORS.index();
/// COB-ID of SYNC.
pub const SYNC_COB_ID: u16 = SyncObjects::COB_ID.index();
/// Communication cycle period.
pub const CYCLE_PERIOD: u16 = SyncObjects::CYCLE_PERIOD.index();
/// Synchronous counter overflow value.
pub const SYNC_OVERFLOW: u16 = SyncObjects::OVERFLOW.index();
/// Synchronous window length.
pub const SYNC_WINDOW: u16 = SyncObjects::WINDOW.index();
/// Store parameters.
pub const STORE: u16 = StoreObjects::STORE.index();
/// Restore default parameters.
pub const RESTORE: u16 = StoreObjects::RESTORE.index();
/// COB-ID of emergencies.
pub const EMCY_COB_ID: u16 = EmcyObjects::COB_ID.index();
/// Inhibit time of emergencies.
pub const EMCY_INHIBIT: u16 = EmcyObjects::INHIBIT.index();
/// Error behaviour.
pub const ERROR_BEHAVIOUR: u16 = NmtObjects::ERROR_BEHAVIOUR.index();
/// NMT start-up.
pub const STARTUP: u16 = NmtObjects::STARTUP.index();
/// Consumer heartbeat time.
pub const CONSUMER_HEARTBEAT: u16 = <HeartbeatConsumers>::CONSUMER_HEARTBEAT.index();
/// Producer heartbeat time.
pub const PRODUCER_HEARTBEAT: u16 = HeartbeatProducer::TIME.index();
/// Verify configuration.
pub const CONFIGURATION: u16 = Communication::CONFIGURATION.index();

/// Last index of the communication profile.
pub const LAST_COMMUNICATION: u16 = 0x1FFF;

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
