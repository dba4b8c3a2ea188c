//! Emergencies of a node: errors are raised and cleared, and what may not have been heard is sent again.

use super::Services;
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::device::has_states;
use crate::node::services::extension::Extension;
use crate::types::{Bus, CobId, Frame, Instant};

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

    /// Notes that the NMT state may allow emergencies from now on.
    pub fn allow_emergencies(&mut self) {
        self.dictionary.emcy_mut();
    }

    /// Notes that the master was heard on the active bus: it knows the emergencies that were acknowledged.
    pub fn confirm_emergencies(&mut self) {
        self.dictionary.confirm_emergencies();
    }

    /// Notes that the bus does not send the emergencies that it has. They are due again from `at` on.
    pub fn recall_emergencies(&mut self, at: Instant) {
        self.dictionary.emcy_mut().recall(at);
    }

    /// Lets the emergency of the error that was raised last go out first, and now.
    pub fn hasten_emergencies(&mut self) {
        self.dictionary.emcy_mut().hasten();
    }

    /// Returns whether this is the COB-ID of the emergencies of this node.
    pub fn is_emergency(&self, id: CobId) -> bool {
        self.dictionary.emcy().id().is(id)
    }

    /// Sends emergencies and states again: the active bus changed, or another master is there.
    #[inline(never)] // seldom
    pub fn announce(&mut self, now: Instant) {
        self.dictionary.emcy_mut().on_bus_changed();
        self.send_states(now);
    }

    /// Takes the end of a frame of this node on its active bus: a node acknowledged it, or it was not sent. Then an
    /// emergency or a state is due again.
    pub fn on_frame_end(&mut self, frame: &Frame, is_acknowledged: bool, now: Instant) {
        if self.is_emergency(frame.id()) {
            self.dictionary.emcy_mut().on_end(frame, is_acknowledged, now);
        } else if const { has_states::<D>() } && !is_acknowledged {
            self.dictionary.tpdos_mut().on_failed(frame.id(), now);
        }
    }

    /// Returns whether a frame that was not sent is an event which no later frame replaces.
    pub fn is_lost_event(&self, frame: &Frame) -> bool {
        self.dictionary.tpdos().is_event(frame.id())
    }
}
