//! Events that a node reports to its application.

use core::convert::Infallible;

use crate::link::Stamp;
use crate::link::port::Health;
use crate::pdo::{ReceivedPdo, SetRpdo};
use crate::types::{Address, Bus, CobId, Frame, NmtState, NodeId};

/// Events that concern the objects of a node, in each type of events.
pub trait NodeEvent {
    /// Event of the parts beyond CANopen.
    type Extension;

    /// Makes the event: a receive PDO took effect.
    fn pdo(pdo: ReceivedPdo) -> Self;
    /// Makes the event: a synchronous receive PDO took effect.
    fn synchronised(pdo: SetRpdo) -> Self;
    /// Makes the event: a client wrote an object by SDO.
    fn written(at: Address) -> Self;
    /// Makes an event of the parts beyond CANopen.
    fn extension(event: Self::Extension) -> Self;
}

/// Events of a slave, in each type of events: see [`Event`].
pub trait SlaveEvents: NodeEvent {
    /// Makes [`Event::State`].
    fn state(state: NmtState) -> Self;
    /// Makes [`Event::PeerState`].
    fn peer_state(node: NodeId, state: NmtState) -> Self;
    /// Makes [`Event::PeerMissed`].
    fn peer_missed(node: NodeId) -> Self;
    /// Makes [`Event::Sync`].
    fn sync(bus: Bus, stamp: Stamp) -> Self;
    /// Makes [`Event::NotSent`].
    fn not_sent(bus: Bus, id: CobId, data: [u8; 8]) -> Self;
    /// Makes [`Event::Health`].
    fn health(bus: Bus, health: Health) -> Self;
    /// Makes [`Event::BusStalled`].
    fn bus_stalled(bus: Bus) -> Self;
    /// Makes [`Event::BusFailed`].
    fn bus_failed(bus: Bus) -> Self;
    /// Makes [`Event::ResetNode`].
    fn reset_node() -> Self;
}

/// Event that a [`CanopenSlave`](super::CanopenSlave) reports to its application.
///
/// "To do" in the description of an event is the work of an application that the node leaves to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
#[non_exhaustive]
pub enum Event {
    /// The NMT state changed.
    ///
    /// To do: send the first values of PDOs that are sent on events, when the node is Operational.
    State(NmtState),
    /// A receive PDO took effect.
    ///
    /// To do: take its values with [`ReceivedPdo::get`], which returns them if it is the PDO that you name.
    Pdo(ReceivedPdo),
    /// A synchronous receive PDO took effect, at a SYNC.
    ///
    /// To do: compare it with the PDO that you name ([`SetRpdo::is`]), and read its objects.
    Synchronised(SetRpdo),
    /// A frame was not sent, and none replaces it: that of a transmit PDO which is sent on events alone, without
    /// an event timer, and is no [state](crate::pdo::Tpdo::state).
    ///
    /// To do: decide whether it is still useful, and send it again.
    NotSent {
        /// COB-ID of the frame.
        id: CobId,
        /// Payload of the frame, zero above its length.
        data: [u8; 8],
    },
    /// A client wrote an object of the application by SDO.
    ///
    /// To do: apply the new value, which the object has.
    Written(Address),
    /// A node that 1016h monitors reported its first NMT state, or a new one.
    ///
    /// To do: use or ignore its values by its state.
    PeerState {
        /// Node-ID of the peer.
        node: NodeId,
        /// NMT state of the peer.
        state: NmtState,
    },
    /// A heartbeat of a node that 1016h names is overdue.
    ///
    /// To do: do without its values.
    PeerMissed {
        /// Node-ID of the peer.
        node: NodeId,
    },
    /// A frame of [`Device::RAW_FRAMES`](super::Device::RAW_FRAMES) arrived.
    ///
    /// To do: decode it.
    Frame(Frame),
    /// A SYNC arrived.
    ///
    /// To do: sample, if the application samples at SYNC.
    Sync {
        /// End of the SYNC.
        stamp: Stamp,
    },
    /// The error state of the controller changed.
    ///
    /// To do: log it. The node recovers by itself, and reports errors by EMCY.
    Health(Health),
    /// The controller does not join or leave its bus: it is defective, or the bus is dominant all the time.
    ///
    /// To do: log it. The controller goes on trying.
    BusStalled,
    /// The controller went bus-off too often.
    ///
    /// To do: log it. The controller tries again when its window ends
    /// ([`Settings::bus_off`](super::Settings::bus_off)).
    BusFailed,
    /// A reset of this node was requested. The node is silent until then, and reports this event again for each frame that
    /// it receives.
    ///
    /// To do: reset the chip.
    ResetNode,
}

impl NodeEvent for Event {
    type Extension = Infallible;

    fn pdo(pdo: ReceivedPdo) -> Self {
        Event::Pdo(pdo)
    }

    fn synchronised(pdo: SetRpdo) -> Self {
        Event::Synchronised(pdo)
    }

    fn written(at: Address) -> Self {
        Event::Written(at)
    }

    fn extension(event: Infallible) -> Self {
        match event {}
    }
}

impl SlaveEvents for Event {
    fn state(state: NmtState) -> Self {
        Event::State(state)
    }

    fn peer_state(node: NodeId, state: NmtState) -> Self {
        Event::PeerState { node, state }
    }

    fn peer_missed(node: NodeId) -> Self {
        Event::PeerMissed { node }
    }

    fn sync(_: Bus, stamp: Stamp) -> Self {
        Event::Sync { stamp }
    }

    fn not_sent(_: Bus, id: CobId, data: [u8; 8]) -> Self {
        Event::NotSent { id, data }
    }

    fn health(_: Bus, health: Health) -> Self {
        Event::Health(health)
    }

    fn bus_stalled(_: Bus) -> Self {
        Event::BusStalled
    }

    fn bus_failed(_: Bus) -> Self {
        Event::BusFailed
    }

    fn reset_node() -> Self {
        Event::ResetNode
    }
}
