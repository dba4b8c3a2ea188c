//! Parts of a node beyond CANopen: objects of their own, and what follows from them. A node without such parts has
//! [`CanopenOnly`].

use core::fmt::Debug;

use super::Services;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::node::events::{NodeEvent, SlaveEvents};
use crate::node::turn::Turn;
use crate::node::{Counters, Device, Event};
use crate::od::Objects;
use crate::pdo::Mapping;
use crate::store::storage::{NoStore, Storage};
use crate::types::{AbortCode, Address, Bus, Duration, Frame, Instant, NodeId, PerBus};

/// Parts of a node beyond CANopen, for a device `D`. The value itself holds their objects. The image of a node has no code
/// for parts that the node does not have.
///
/// Each function is called by the services of the node, at the place that its documentation names. All of them do nothing
/// unless the extension says otherwise.
pub trait Extension<D: Device>: Objects + Debug + Default {
    /// Type of the parameter store.
    type Storage: Storage;

    /// State beside the objects.
    type State: Debug;

    /// Event of these parts.
    type Event;

    /// Events of a slave with these parts.
    type SlaveEvent: SlaveEvents<Extension = Self::Event>;

    /// `true`: the node looks for flipped bits in its Node-ID, its COB-IDs and its filters.
    const IS_GUARDED: bool = false;

    /// `true`: the node is on two buses. It receives the heartbeats of its master (701h) and of another node with its Node-ID,
    /// sends late heartbeats, and can be maintained. A node on one bus has no code for that.
    const HAS_TWO_BUSES: bool = false;

    /// Index above which no object has a rule: the last one of the communication profile, or a later one of the extension.
    const LAST_RULED: u16 = crate::node::index::LAST_COMMUNICATION;

    /// Index of the object whose parameters [`Extension::parameters`] returns. Zero: none.
    const PARAMETERS: u16 = 0;

    /// Lifetime of a transmit PDO for which [`Extension::is_short_lived`] holds.
    const SHORT_LIFETIME: Duration = Duration::ZERO;

    /// Returns whether a receive PDO with this mapping is more than its objects. Then [`Extension::on_rpdo`] follows it.
    fn is_special(_mapping: &impl Mapping) -> bool {
        false
    }

    /// Returns whether the receive PDO with this number is such a one.
    fn is_special_rpdo(_state: &Self::State, _number: usize) -> bool {
        false
    }

    /// Takes a receive PDO that is more than its objects, after it has filled them.
    fn on_rpdo<V: NodeEvent<Extension = Self::Event>>(
        _services: &mut Services<D, Self>,
        _number: usize,
        _bus: Bus,
        _stamp: &Stamp,
        _turn: &mut Turn<'_, V>,
    ) {
    }

    /// Returns whether frames of the transmit PDO with this number live for [`Extension::SHORT_LIFETIME`] at most.
    fn is_short_lived(_state: &Self::State, _number: usize) -> bool {
        false
    }

    /// Follows the mappings of all PDOs, after each change of one of them.
    fn note_mappings(_services: &mut Services<D, Self>) {}

    /// Returns how long a synchronous PDO lives of which `whole` is the longest lifetime.
    fn synchronous_lifetime(_services: &Services<D, Self>, whole: Duration) -> Duration {
        whole
    }

    /// Takes a SYNC before its PDOs are sampled, if [`Consumer::watch`](crate::sync::Consumer::watch) asked for all of them.
    fn on_sync(_services: &mut Services<D, Self>, _bus: Bus, _stamp: &Stamp) {}

    /// Samples values for transmit PDOs that are due by an event or a timer, at `until`.
    fn sample_events(_services: &mut Services<D, Self>, _until: Instant) {}

    /// Samples values that an SDO request reads.
    fn sample_for(_services: &mut Services<D, Self>, _request: &Frame, _now: Instant) {}

    /// Notes that the NMT state does not allow PDOs any more.
    fn on_pdos_stopped(_state: &mut Self::State) {}

    /// Checks a `value` that a client writes, beyond its type and its limits. An object of the communication profile may
    /// have a rule here, too.
    ///
    /// # Errors
    /// The abort code to answer.
    fn may_write(_id: NodeId, _at: Address, _value: u32) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Checks a `value` of an object with an index above [`Extension::LAST_RULED`].
    ///
    /// # Errors
    /// The abort code to answer.
    fn check_value(_at: Address, _value: u32) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Returns whether the extension takes what a client writes to this object itself, by [`Extension::take`].
    fn takes(_index: u16) -> bool {
        false
    }

    /// Takes what a client writes.
    ///
    /// # Errors
    /// The abort code to answer.
    fn take(&mut self, _stored: &mut Self::Storage, _at: Address, _value: &[u8]) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Returns whether an object is a command or a time: no parameter, whose change the configuration would show (1020h).
    fn is_command(_index: u16) -> bool {
        false
    }

    /// Follows an object of the node that a client wrote.
    fn on_written<V: NodeEvent<Extension = Self::Event>>(
        _services: &mut Services<D, Self>,
        _at: Address,
        _turn: &mut Turn<'_, V>,
    ) {
    }

    /// Shows error states and counters of both buses in the objects.
    fn show_health(&mut self, _health: &PerBus<Health>, _counters: &PerBus<Counters>) {}

    /// Shows in the objects whether there is a parameter store.
    fn show_store(&mut self, _is_there: bool) {}

    /// Returns parameters that decide for long, to be guarded against flipped bits.
    fn parameters(&self) -> u32 {
        0
    }

    /// Takes the parameters in which a flipped bit was corrected.
    fn restore_parameters(&mut self, _parameters: u32) {}

    /// Counts a flipped bit that was mended. Returns how many were.
    fn count_mended(&mut self) -> u16 {
        0
    }
}

/// Extension of a node that has CANopen only.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct CanopenOnly {}

impl<D: Device> Extension<D> for CanopenOnly {
    type Storage = NoStore;

    type State = ();

    type Event = core::convert::Infallible;

    type SlaveEvent = Event;
}
