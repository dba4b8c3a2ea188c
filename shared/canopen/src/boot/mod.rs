//! Boot-up of the network by its master: every slave is checked, configured and started, then SYNC begins.
//!
//! A slave is *assigned* if 1F81h of the master names it, and *mandatory* if SYNC has to wait for it. The *boot-up
//! process* of a slave reads its device type and identity, compares its configuration, writes the values that
//! differ, checks that no other node sends one of its COB-IDs, and starts it. CiA 302-2 has the objects and the errors.
//!
//! ```
//! use async_canopen::boot::{AssignedSlave, BootPolicy, BootProgress, Expected};
//! use async_canopen::boot::machine::{Boot, BootAction, BootRequest, Identified};
//! use async_canopen::sdo::Error;
//! use async_canopen::types::{AbortCode, Address, Duration, Instant, NmtState, NodeId};
//!
//! let node = NodeId::of::<2>();
//! let expected = Expected { device_type: 0x191, identity: [0; 4], stamp: [0; 2] };
//! let objects = Identified {
//!     device_type: 0x1000,
//!     identity: 0x1018,
//!     configuration: 0x1020,
//!     rpdo: 0x1400,
//!     emergency: 0x1014,
//!     tpdo: 0x1800,
//! };
//! let mut boot = Boot::new(BootPolicy { time: Duration::from_millis(500), goes_on: false }, objects, &[]);
//! boot.assign(node, AssignedSlave { node, mandatory: true, expected }.assignment());
//! boot.start(Instant::ZERO);
//! boot.on_heartbeat(node, NmtState::Initialising, true, false); // its boot-up message on the active bus
//!
//! let request = boot.request(|_| expected, None);
//! assert_eq!(request, Some(BootRequest::Read { node, at: Address::new(0x1000, 0), most: 4 }));
//! boot.on_data(&0x191_u32.to_le_bytes());
//! boot.on_done(Ok(()), |_| false);
//! // It has neither emergencies nor TPDOs: 1014h and 1800h to 1807h do not exist.
//! while boot.request(|_| expected, None).is_some() {
//!     boot.on_done(Err(Error::Abort(AbortCode::NoObject)), |_| false);
//! }
//! let actions: Vec<BootAction> = std::iter::from_fn(|| boot.poll(Instant::ZERO)).collect();
//! let reported = BootAction::ReportProgress { node, progress: BootProgress::Started };
//! assert_eq!(actions, [reported, BootAction::Start(node)]);
//! ```
//!
//! The process runs for every assigned slave that boots up, is heard for the first time, or was lost and returns.
//! After it the slave is started at once whenever it waits, until it boots up again. So a change of the bus does
//! not wait for SDO.
//!
//! # A slave that was reset without being heard
//!
//! If no command of the master explains why a slave waits, the slave may have been reset. The process then runs
//! after the start. A slave that lost its configuration returns to Pre-operational, is configured, and is started
//! again.
//!
//! # Limits
//!
//! - There is one SDO transfer at a time, in the order of the Node-IDs.
//! - COB-IDs of emergencies and of the first eight TPDOs are compared, of the master and of slaves that were checked
//!   since its power-on. A slave is not started if the network then has more than 64 of them outside the
//!   pre-defined connection set.
//! - Without mandatory slaves SYNC does not wait, and the end of the boot-up is never reported.

mod action;
mod expected;
pub mod machine;
mod network;
mod overheard;
mod process;
mod progress;
mod record;
mod senders;

pub(crate) use action::BootAction;
pub(crate) use expected::Assignment;
pub use expected::{AssignedSlave, BootPolicy, Expected, Setting};
pub(crate) use network::Boot;
pub(crate) use process::{BootRequest, CommonPdo, Identified};
pub use progress::{BootCause, BootError, BootFailure, BootProgress, Difference};

/// Node-IDs 0..=127.
const PLACES: usize = 128;
