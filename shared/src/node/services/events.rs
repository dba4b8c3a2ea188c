//! Events that masters and slaves have in common.

use crate::node::{MasterEvent, SlaveEvent};
use crate::time::Step;
use crate::types::{Address, Bus, Scet};

/// Event that concerns the objects of a node.
pub trait NodeEvent {
    /// Makes the event: a receive PDO took effect. `data` is its payload, zero above its length.
    fn pdo(bus: Bus, number: u16, data: [u8; 8]) -> Self;
    /// Makes the event: a synchronous receive PDO took effect.
    fn synchronised(number: u16) -> Self;
    /// Makes the event: a spacecraft time arrived.
    fn time(scet: Scet) -> Self;
    /// Makes the event: the clock was set.
    fn step(step: Step) -> Self;
    /// Makes the event: a client wrote an object by SDO.
    fn written(at: Address) -> Self;
    /// Makes the event: the self-test is to start.
    fn self_test() -> Self;
}

/// Implements [`NodeEvent`] for an event type of a node: the variants have the same names in all of them.
macro_rules! node_event {
    ($event:ident) => {
        impl NodeEvent for $event {
            fn pdo(bus: Bus, number: u16, data: [u8; 8]) -> Self {
                $event::Pdo { bus, number, data }
            }

            fn synchronised(number: u16) -> Self {
                $event::Synchronised { number }
            }

            fn time(scet: Scet) -> Self {
                $event::Time(scet)
            }

            fn step(step: Step) -> Self {
                $event::Step(step)
            }

            fn written(at: Address) -> Self {
                $event::Written(at)
            }

            fn self_test() -> Self {
                $event::SelfTest
            }
        }
    };
}

node_event!(SlaveEvent);
node_event!(MasterEvent);
