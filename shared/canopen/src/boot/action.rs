//! Decisions of the boot-up process.

use super::{BootFailure, BootProgress, Difference};
use crate::types::NodeId;

/// What a master does or reports for the boot-up process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BootAction {
    /// Command "enter Pre-operational" and report the difference: the slave runs and has lost its configuration. Do it
    /// before the next transfer.
    Hold {
        /// The slave.
        node: NodeId,
        /// First value that differs.
        difference: Difference,
    },
    /// Start the slave.
    Start(NodeId),
    /// Report the progress of a slave.
    ReportProgress {
        /// The slave.
        node: NodeId,
        /// Step that it reached.
        progress: BootProgress,
    },
    /// Report that the boot-up of a slave failed.
    ReportFailure {
        /// The slave.
        node: NodeId,
        /// The reason.
        failure: BootFailure,
    },
    /// Report, once, that all mandatory slaves follow SYNC. Without mandatory slaves it never comes.
    ReportCompleted,
}
