//! Indices of the objects that a node of a spacecraft checks and follows, beside those of CANopen. Constants take them from the
//! declarations. Their names are those of CiA 302-2 and ECSS-E-ST-50-15C.

use super::{NetworkObjects, Spacecraft};
use crate::redundancy::RedundancyObjects;
use crate::time::{ClockObjects, LocalScet, LocalUtc};
pub use async_canopen::node::extend::index::*;

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
