//! Defects between a machine and the model.
//!
//! A *defect* changes a parameter, an input or an action of a machine from outside. The machine itself is that of the
//! firmware.

use clap::ValueEnum;
use ecss_can::heartbeat;
use ecss_can::redundancy::{BusCause, Parameters};
use ecss_can::types::{Bus, CobId, Frame, NmtState, NodeId};

use crate::profile::{PAIR, PARALLEL, PARAMETERS};
use crate::station::Station;

/// A broken rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum Defect {
    /// The master stays on a bus without slaves: it takes itself to have received frames of a slave on the other bus
    NoDwell,
    /// The master leaves stopped slaves alone: it takes Stopped for Operational
    LeavesStopped,
    /// A slave does not go to the bus of the master: it takes its heartbeats for ones on the selected bus
    StaysBehind,
    /// A search has one switch too many: Ntoggle is 5
    TogglesOnceMore,
    /// Each switch of a search changes Bdefault in the dictionary
    BdefaultByToggle,
    /// Of two active masters none yields: an active one receives no claim
    NeverYields,
    /// No claim reaches another master: equal frames of two merge
    NeverCalls,
    /// A slave that found its master on another bus repeats no announcements
    NeverAnnounces,
    /// A master reads no errors: it knows only received messages
    NeverReads,
}

/// Returns a frame that no node sent, which a master receives before its due actions, and its bus.
pub fn imagined(defect: Option<Defect>, master: &dyn Station) -> Option<(Bus, Frame)> {
    let is_due = defect == Some(Defect::NoDwell);
    is_due.then(|| (master.active().other(), Frame::of(CobId::emcy(PARALLEL), [])))
}

/// Returns the parameters of a slave.
pub fn parameters(defect: Option<Defect>) -> Parameters {
    let more = u8::from(defect == Some(Defect::TogglesOnceMore));
    Parameters { ntoggle: PARAMETERS.ntoggle + more, ..PARAMETERS }
}

/// Returns Bdefault in the dictionary of a slave whose machine has `bdefault`. `reported`: its last report of a bus.
pub fn shown(defect: Option<Defect>, bdefault: Bus, reported: Option<(BusCause, Bus)>) -> Bus {
    match (defect, reported) {
        (Some(Defect::BdefaultByToggle), Some((BusCause::Toggled, bus))) => bus,
        _ => bdefault,
    }
}

/// Returns a frame of `bus` and its bus as the machine of a node receives them. `None`: the machine does not receive
/// it.
pub fn received(
    defect: Option<Defect>,
    node: &dyn Station,
    is_master: bool,
    bus: Bus,
    frame: &Frame,
) -> Option<(Bus, Frame)> {
    let is_claim = PAIR.claim(frame).is_some();
    let stopped = frame.id().node().filter(|node| *frame == heartbeat::encode(*node, NmtState::Stopped));
    match (defect, stopped) {
        (Some(Defect::NeverCalls), _) if is_claim => None,
        (Some(Defect::NeverYields), _) if is_claim && is_master && !node.is_silent() => None,
        (Some(Defect::LeavesStopped), Some(slave)) if is_master => {
            Some((bus, heartbeat::encode(slave, NmtState::Operational)))
        }
        (Some(Defect::StaysBehind), _) if !is_master && frame.id() == CobId::heartbeat(NodeId::MASTER) => {
            Some((node.active(), *frame))
        }
        _ => Some((bus, *frame)),
    }
}
