//! Events that slaves and masters have in common.

use crate::time::Step;
use crate::types::Scet;

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

/// Declares the type of events of a role: the events of all roles, and those in the braces.
macro_rules! role_events {
    ($(#[$doc:meta])* $name:ident { $($own:tt)* }) => {
        $(#[$doc])*
        ///
        /// "To do" in the description of an event is the work of an application that the node leaves to it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u32)] // moves in words: see `runner`
        #[non_exhaustive]
        pub enum $name {
            /// The NMT state of this node changed.
            ///
            /// To do: send the first values of PDOs that are sent on events, when the node is Operational.
            State($crate::types::NmtState),
            /// A receive PDO took effect.
            ///
            /// To do: take its values with [`ReceivedPdo::get`](crate::pdo::ReceivedPdo::get), which returns them if it is
            /// the PDO that you name.
            Pdo($crate::pdo::ReceivedPdo),
            /// A synchronous receive PDO took effect, at a SYNC.
            ///
            /// To do: compare it with the PDO that you name ([`SetRpdo::is`](crate::pdo::SetRpdo::is)), and read its objects.
            Synchronised($crate::pdo::SetRpdo),
            /// A frame was not sent, and none replaces it: that of a transmit PDO which is sent on events alone, without an
            /// event timer, and is no [state](crate::pdo::Tpdo::state). At a master, also a command or another frame of the
            /// application.
            ///
            /// To do: decide whether it is still useful, and send it again.
            NotSent {
                /// Bus for which it was meant.
                bus: $crate::types::Bus,
                /// COB-ID of the frame.
                id: $crate::types::CobId,
                /// Payload of the frame, zero above its length.
                data: [u8; 8],
            },
            /// A client wrote an object of the application by SDO.
            ///
            /// To do: apply the new value, which the object has.
            Written($crate::types::Address),
            /// The self-test is requested (ECSS 6.7b).
            ///
            /// To do: run it, and report the result with `report_self_test` of the handle, which is object 2031h.
            SelfTest,
            /// A spacecraft time arrived, and the clock follows it. Nothing to do.
            Time($crate::types::Scet),
            /// The clock was set instead of steered: by command, for the first time, or because it was too far off.
            ///
            /// To do: schedule again what waits for a time of the spacecraft.
            Step($crate::time::Step),
            /// The error state of a controller changed.
            ///
            /// To do: log it. The node recovers by itself, and reports errors by EMCY.
            Health {
                /// Bus of the controller.
                bus: $crate::types::Bus,
                /// Present error state and error counters.
                health: $crate::link::port::Health,
            },
            /// A controller does not join or leave its bus: it is defective, or the bus is dominant all the time.
            ///
            /// To do: log it. The controller goes on trying.
            BusStalled {
                /// Bus of the controller.
                bus: $crate::types::Bus,
            },
            /// A controller went bus-off too often.
            ///
            /// To do: log it. The controller tries again when its window ends
            /// ([`Profile::bus_off`](crate::profile::Profile::bus_off)).
            BusFailed {
                /// Bus of the controller.
                bus: $crate::types::Bus,
            },
            /// This node sends too many frames: a frame with this COB-ID was refused, with EMCY 8100h and object 2047h.
            /// Reported once until no frame was refused for a second.
            ///
            /// Above the budget of the node, it is in Pre-operational and sends no PDO for the time in its
            /// [profile](crate::profile::Profile::budget). A slave then boots up. A master goes on with heartbeat, NMT,
            /// SYNC, time and SDO.
            ///
            /// To do: send fewer frames.
            OverBudget {
                /// COB-ID of the refused frame.
                id: $crate::types::CobId,
            },
            /// A reset of this node is requested: by the master, or at a master by the application or by a client in 1F82h.
            /// A slave is silent until then, and reports this event again for each frame that it receives. A master
            /// continues until then.
            ///
            /// To do: reset the chip.
            ResetNode,
            $($own)*
        }

        impl async_canopen::node::extend::NodeEvent for $name {
            type Extension = $crate::node::SpacecraftEvent;

            fn pdo(pdo: $crate::pdo::ReceivedPdo) -> Self {
                $name::Pdo(pdo)
            }

            fn synchronised(pdo: $crate::pdo::SetRpdo) -> Self {
                $name::Synchronised(pdo)
            }

            fn written(at: $crate::types::Address) -> Self {
                $name::Written(at)
            }

            fn extension(event: $crate::node::SpacecraftEvent) -> Self {
                match event {
                    $crate::node::SpacecraftEvent::Time(scet) => $name::Time(scet),
                    $crate::node::SpacecraftEvent::Step(step) => $name::Step(step),
                    $crate::node::SpacecraftEvent::SelfTest => $name::SelfTest,
                }
            }
        }
    };
}

pub(super) use role_events;
