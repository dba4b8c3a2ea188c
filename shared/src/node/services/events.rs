//! Events that masters and slaves report alike.

use crate::node::{MasterEvent, SlaveEvent};
use crate::time::Step;
use crate::types::{Address, Bus, Scet};

/// Events of the objects of a node.
pub trait NodeEvent {
    /// A receive PDO took effect; its payload, zero behind its end.
    fn pdo(bus: Bus, number: u16, data: [u8; 8]) -> Self;
    /// A synchronous receive PDO took effect.
    fn synchronised(number: u16) -> Self;
    /// A spacecraft time arrived.
    fn time(scet: Scet) -> Self;
    /// The clock was set.
    fn step(step: Step) -> Self;
    /// An object was written by SDO.
    fn written(at: Address) -> Self;
    /// The self-test is to start.
    fn self_test() -> Self;
}

/// Both name them alike.
macro_rules! node_event {
    ($event:ident) => {
        impl NodeEvent for $event {
            #[inline]
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
