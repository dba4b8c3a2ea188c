//! Emergencies of a node: errors are raised and cleared, by the health of the buses, too. What may not have been heard is sent
//! again.

use super::Services;
use crate::emcy::{self, ErrorCode};
use crate::link::port::{ErrorState, Health, LastError};
use crate::node::Device;
use crate::node::device::has_states;
use crate::node::services::extension::Extension;
use crate::types::{Bus, CobId, Frame, Instant};

/// Frames, sent and received on a bus, within which a node may have been the first one there.
const FIRST_FRAMES: u32 = 8;

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Takes an error that appeared: history and register in the dictionary follow. Returns `false` if the error
    /// is active already.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        self.dictionary.raise(code, info)
    }

    /// Notes that an error is gone. Returns whether it was there.
    pub fn clear(&mut self, code: ErrorCode, source: u8) -> bool {
        self.dictionary.clear(code, source)
    }

    /// Raises or clears the error `code` of `source`. Returns whether it was newly raised.
    pub fn set_error(&mut self, code: ErrorCode, source: u8, is_there: bool) -> bool {
        if !is_there {
            self.clear(code, source);
            return false;
        }
        self.raise(code, [source, 0, 0, 0, 0])
    }

    /// Reports an error that has already ended.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`
    pub fn report_past(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.dictionary.report_past(code, info);
    }

    /// Reports an error of a bus that has already ended.
    pub fn occurred(&mut self, code: ErrorCode, bus: Bus) {
        self.report_past(code, [bus.bdefault(), 0, 0, 0, 0]);
    }

    /// Lends the producer of emergencies for a change. The node runs at the end of its step.
    pub fn emcy_mut(&mut self) -> &mut emcy::Producer {
        self.dictionary.emcy_mut()
    }

    /// Notes that the master was heard on the active bus: it knows the emergencies that were acknowledged.
    pub fn confirm_emergencies(&mut self) {
        self.dictionary.confirm_emergencies();
    }

    /// Returns whether this is the COB-ID of the emergencies of this node.
    pub fn is_emergency(&self, id: CobId) -> bool {
        self.dictionary.emcy().id().is(id)
    }

    /// Sends emergencies and states again: the active bus changed, or another master is there.
    pub fn announce(&mut self, now: Instant) {
        self.emcy_mut().on_bus_changed();
        self.send_states(now);
    }

    /// Takes the end of a frame of this node on its active bus: a node acknowledged it, or it was not sent. Then an
    /// emergency or a state is due again.
    pub fn on_frame_end(&mut self, frame: &Frame, is_acknowledged: bool, now: Instant) {
        if self.is_emergency(frame.id()) {
            self.emcy_mut().on_end(frame, is_acknowledged, now);
        } else if const { has_states::<D>() } && !is_acknowledged {
            self.dictionary.tpdos_mut().on_failed(frame.id(), now);
        }
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
        let counters = &self.buses.counters()[bus];
        matches!(health.last_error, LastError::Ack | LastError::None)
            && counters.received.saturating_add(counters.sent) < FIRST_FRAMES
    }

    /// Shows error states and counters of the buses, where objects have them.
    pub fn refresh_health(&mut self) {
        self.dictionary.objects_mut().extension.show_health(self.buses.health(), self.buses.counters());
    }
}
