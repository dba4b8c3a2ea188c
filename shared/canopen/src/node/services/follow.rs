//! Objects of the services: applies stored values, and makes the services follow a change.

use super::{FIRST_REPORTED, Services};
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::events::NodeEvent;
use crate::node::index::{CYCLE_PERIOD, LAST_TPDO_MAPPING, RPDO};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::turn::Turn;
use crate::store::Group;
use crate::types::{AbortCode, Address, Instant, Sealed};

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Takes the parameters of all services from the dictionary, at power-on and after a reset of the
    /// communication.
    pub fn configure(&mut self, now: Instant) {
        self.end_transfers();
        self.take_second_sdo();
        self.dictionary.configure(&mut self.monitor, now);
        let sync = &self.dictionary.objects().communication.sync;
        self.sync_id = Sealed::of(sync.id());
        self.sync.configure(sync.overflow, sync.window);
        self.note_mappings();
        if E::IS_GUARDED {
            self.copy_cob_ids();
        }
    }

    /// Lets the application change objects. PDOs that are sent on events go out if their content is another one
    /// afterwards.
    pub fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut NodeObjects<D, E>) -> R) -> R {
        self.dictionary.change(now, change)
    }

    /// Writes an object for the application, with all checks of a write by SDO. Returns the object if a service has
    /// to follow it.
    ///
    /// # Errors
    /// The abort code that a client would receive.
    pub fn write(&mut self, at: Address, value: &[u8], now: Instant) -> Result<Option<Address>, AbortCode> {
        self.dictionary.write_whole(at, value, now)?;
        Ok(self.take_written())
    }

    /// Applies the stored parameters of a group; [`Services::configure`] passes them to the services. If nothing was
    /// applied, the defaults hold, and an emergency reports this until parameters are saved again.
    pub fn load(&mut self, group: Group) {
        self.dictionary.load(group);
    }

    /// Returns the object that a client wrote last, once. A written parameter clears 1020h.
    #[inline] // row `instructions.sdo_download`
    pub fn take_written(&mut self) -> Option<Address> {
        self.dictionary.take_written()
    }

    /// Notes that a client wrote an object of a service: services and clock follow.
    pub fn on_own_written<V: NodeEvent<Extension = E::Event>>(&mut self, at: Address, turn: &mut Turn<V>) {
        E::on_written(self, at, turn);
        if at.index <= E::LAST_RULED {
            self.on_written(at);
        }
    }

    /// Notes that a client wrote an object: an event for the application, and for the TPDOs that carry the
    /// object.
    #[inline] // row `instructions.sdo_download`
    pub fn report_written<V: NodeEvent<Extension = E::Event>>(&mut self, at: Address, turn: &mut Turn<V>) {
        if at.index >= FIRST_REPORTED {
            self.dictionary.on_changed(at, turn.now);
            turn.out.event(V::written(at));
        }
    }

    /// Lets each service follow a write to its objects.
    fn on_written(&mut self, at: Address) {
        self.dictionary.follow_emcy(at);
        let sync = &self.dictionary.objects().communication.sync;
        if self.sync.follow(at, sync) {
            self.sync_id = Sealed::of(sync.id());
        }
        let monitor = self.monitor.change(self.dictionary.wakes_mut());
        if let Some(missed) = monitor.follow(at, &self.dictionary.objects().consumers) {
            self.clear(ErrorCode::HEARTBEAT, missed.get());
        }
        if matches!(at.index, CYCLE_PERIOD | RPDO..=LAST_TPDO_MAPPING) {
            self.note_mappings();
        }
        self.follow_second_sdo(at);
        if E::IS_GUARDED {
            self.copy_written(at);
        }
    }
}
