//! Events of a slave and of a master as the services make them.

use async_canopen::node::extend::{NodeEvent, SlaveEvents};

use super::{MasterEvent, SlaveEvent};
use crate::link::Stamp;
use crate::link::port::Health;
use crate::pdo::{ReceivedPdo, SetRpdo};
use crate::time::Step;
use crate::types::{Address, Bus, CobId, NmtState, NodeId, Scet};

/// Event of a node of a spacecraft beyond CANopen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpacecraftEvent {
    /// A spacecraft time arrived.
    Time(Scet),
    /// The clock was set.
    Step(Step),
    /// The self-test is to start.
    SelfTest,
}

/// Implements [`NodeEvent`] for an event type of a node: the variants have the same names in all of them.
macro_rules! node_event {
    ($event:ident) => {
        impl NodeEvent for $event {
            type Extension = SpacecraftEvent;

            fn pdo(pdo: ReceivedPdo) -> Self {
                $event::Pdo(pdo)
            }

            fn synchronised(pdo: SetRpdo) -> Self {
                $event::Synchronised(pdo)
            }

            fn written(at: Address) -> Self {
                $event::Written(at)
            }

            fn extension(event: SpacecraftEvent) -> Self {
                match event {
                    SpacecraftEvent::Time(scet) => $event::Time(scet),
                    SpacecraftEvent::Step(step) => $event::Step(step),
                    SpacecraftEvent::SelfTest => $event::SelfTest,
                }
            }
        }
    };
}

node_event!(SlaveEvent);
node_event!(MasterEvent);

impl SlaveEvents for SlaveEvent {
    fn state(state: NmtState) -> Self {
        SlaveEvent::State(state)
    }

    fn peer_state(node: NodeId, state: NmtState) -> Self {
        SlaveEvent::PeerState { node, state }
    }

    fn peer_missed(node: NodeId) -> Self {
        SlaveEvent::PeerMissed { node }
    }

    fn sync(bus: Bus, stamp: Stamp) -> Self {
        SlaveEvent::Sync { bus, stamp }
    }

    fn not_sent(bus: Bus, id: CobId, data: [u8; 8]) -> Self {
        SlaveEvent::NotSent { bus, id, data }
    }

    fn health(bus: Bus, health: Health) -> Self {
        SlaveEvent::Health { bus, health }
    }

    fn bus_stalled(bus: Bus) -> Self {
        SlaveEvent::BusStalled { bus }
    }

    fn bus_failed(bus: Bus) -> Self {
        SlaveEvent::BusFailed { bus }
    }

    fn reset_node() -> Self {
        SlaveEvent::ResetNode
    }
}
