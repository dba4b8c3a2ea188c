//! Buses of a node: health of the controllers, and counters of the frames.

use super::Services;
use crate::emcy::ErrorCode;
use crate::link::port::{ErrorState, Health, LastError};
use crate::node::buses::{BusNews, Buses};
use crate::node::counters::BusCounters;
use crate::node::services::extension::Extension;
use crate::node::{Counters, Device, LinkEvent};
use crate::types::{Bus, Frame, Instant, PerBus};

/// Frames, sent and received on a bus, within which a node may have been the first one there.
const FIRST_FRAMES: u32 = 8;

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Returns the buses of the node.
    pub fn buses(&self) -> &Buses {
        &self.buses
    }

    /// Lends the buses for a change that makes nothing due earlier.
    pub fn buses_mut(&mut self) -> &mut Buses {
        self.buses.no_sooner()
    }

    /// Counts an event of a bus and follows the error state of its controller. Returns a change that the node has to report.
    pub fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant) -> Option<BusNews> {
        self.count(bus, event);
        // Recoveries begin and end here.
        self.buses.step(self.dictionary.wakes_mut(), |buses| buses.on_link(bus, event, now))
    }

    /// Takes the error state and the counters of a controller.
    pub fn on_health(&mut self, bus: Bus, health: &Health) {
        let is_passive = match health.state {
            ErrorState::Active => Some(false),
            ErrorState::Passive => (!self.is_first(bus, health)).then_some(true),
            ErrorState::BusOff => None,
        };
        if let Some(is_passive) = is_passive {
            self.set_error(ErrorCode::CAN_PASSIVE, bus.bdefault(), is_passive);
        }
        if self.buses.no_sooner().note_state(bus, health.state) {
            self.occurred(ErrorCode::BUS_OFF_RECOVERED, bus);
        }
    }

    /// Returns whether this node is error passive because it is the first one on its bus. That is no error: no
    /// other node was there yet to acknowledge its frames. The first frames that were acknowledged may be handled
    /// before the state that preceded them, and end its last error.
    fn is_first(&self, bus: Bus, health: &Health) -> bool {
        let counters = &self.counters()[bus];
        matches!(health.last_error, LastError::Ack | LastError::None)
            && counters.received.saturating_add(counters.sent) < FIRST_FRAMES
    }

    /// Shows error states and counters of the buses, where objects have them.
    pub fn refresh_health(&mut self) {
        self.dictionary.objects_mut().extension.show_health(self.buses.health(), self.counters.all());
    }

    /// Returns the counters of the frames of each bus.
    pub const fn counters(&self) -> &PerBus<Counters> {
        self.counters.all()
    }

    /// Resets the counters of both buses to zero.
    pub fn reset_counters(&mut self) {
        self.counters = BusCounters::default();
    }

    /// Returns the number of frames received on each bus; wraps.
    pub fn received_frames(&self) -> PerBus<u32> {
        self.counters.received_frames()
    }

    /// Counts an event of a bus.
    pub fn count(&mut self, bus: Bus, event: &LinkEvent) {
        self.counters.on_link(bus, event);
    }

    /// Counts a received frame.
    pub fn count_received(&mut self, bus: Bus) {
        self.counters.count_received(bus);
    }

    /// Counts a received frame with an error in the protocol.
    pub fn count_malformed(&mut self, bus: Bus) {
        self.counters.count_malformed(bus);
    }

    /// Counts a heartbeat that was taken as malformed if its bit 7 is set.
    pub fn count_heartbeat(&mut self, bus: Bus, heartbeat: &Frame) {
        self.counters.count_heartbeat(bus, heartbeat);
    }

    /// Counts a received frame that is not for this node in this state.
    pub fn count_ignored(&mut self, bus: Bus) {
        self.counters.count_ignored(bus);
    }

    /// Counts a frame that this node refuses to send.
    pub fn count_refused(&mut self, bus: Bus) {
        self.counters.count_refused(bus);
    }
}
