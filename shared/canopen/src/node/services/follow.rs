//! Objects of the services: applies stored values, and makes the services follow a change.

use super::{Dictionary, FIRST_REPORTED, Services};
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::events::NodeEvent;
use crate::node::index::{
    CONFIGURATION, CYCLE_PERIOD, LAST_TPDO_MAPPING, PRE_DEFINED_ERRORS, RESTORE, RPDO, STORE,
};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::storage::Storage;
use crate::node::turn::Turn;
use crate::od::{ObjectAccess, Transfer};
use crate::store::{Group, Loaded};
use crate::types::{AbortCode, Address, Instant, NodeId, Sealed};

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Takes the parameters of all services from the dictionary, at power-on and after a reset of the
    /// communication.
    pub fn configure(&mut self, now: Instant) {
        self.dictionary.stored.give_up();
        self.reset_servers();
        self.take_second_sdo();
        let Self { dictionary, monitor, wakes, .. } = self;
        dictionary.written = None;
        dictionary.rpdos.no_sooner().stop();
        dictionary.tpdos.no_sooner().stop();
        let communication = &dictionary.objects.communication;
        self.sync_id = Sealed::of(communication.sync.id());
        self.sync.configure(communication.sync.overflow, communication.sync.window);
        let emcy = dictionary.emcy.change(wakes);
        emcy.configure(communication.emcy.config());
        let clear = &mut |missed: NodeId| _ = emcy.clear(ErrorCode::HEARTBEAT, missed.get());
        monitor.change(wakes).configure(&dictionary.objects.consumers, clear);
        dictionary.set_pdos(now, wakes);
        dictionary.emcy.change(wakes).restart();
        self.note_mappings();
        if E::IS_GUARDED {
            self.copy_cob_ids();
        }
        self.dictionary.show_errors();
    }

    /// Lets the application change objects. PDOs that are sent on events go out if their content is another one
    /// afterwards.
    pub fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut NodeObjects<D, E>) -> R) -> R {
        let Dictionary { objects, tpdos, .. } = &mut self.dictionary;
        let has_events = tpdos.has_events();
        if has_events {
            tpdos.no_sooner().remember(objects);
        }
        let result = change(objects);
        if has_events {
            tpdos.step(&mut self.wakes, |tpdos| tpdos.trigger_changed(objects, now));
        }
        result
    }

    /// Writes an object for the application, with all checks of a write by SDO. Returns the object if a service has
    /// to follow it.
    ///
    /// # Errors
    /// The abort code that a client would receive.
    pub fn write(&mut self, at: Address, value: &[u8], now: Instant) -> Result<Option<Address>, AbortCode> {
        let dictionary = &mut self.dictionary;
        dictionary.now = now;
        match dictionary.download(at, Some(value.len()))? {
            Transfer::Whole(_) => {
                dictionary.write(at, value)?;
                dictionary.stored.drop_answer();
            }
            Transfer::Stream(_) => {
                dictionary.write_part(at, 0, value)?;
                dictionary.finish(at, value.len())?;
            }
        }
        Ok(self.take_written())
    }

    /// Applies the stored parameters of a group; [`Services::configure`] passes them to the services. If nothing
    /// was applied, the defaults hold, and an emergency reports this until parameters are saved again. Its second
    /// byte is the [`Loss`](crate::store::Loss) of the store: 1 if the last save did not end, 2 if a set is
    /// damaged, 0 if the set does not fit this node.
    #[inline(never)]
    pub fn load(&mut self, group: Group) {
        let Dictionary { objects, stored, .. } = &mut self.dictionary;
        objects.extension.show_store(stored.is_there());
        let cause = stored.check().map_or(0, |loss| loss as u8);
        let loaded = self.dictionary.load(group);
        let is_applied = matches!(loaded, Ok(None | Some(Loaded::Nothing | Loaded::Set { skipped: 0, .. })));
        if cause != 0 || !is_applied {
            self.raise(ErrorCode::DATA_SET, [0, cause, 0, 0, 0]);
        }
    }

    /// Returns the object that a client wrote last, once. A written parameter clears 1020h: the configuration is
    /// no longer the verified one (CiA 301 7.5.2.23).
    #[inline] // row `instructions.sdo_download`
    pub fn take_written(&mut self) -> Option<Address> {
        let at = self.dictionary.written.take()?;
        // History, signatures, the stamp itself, commands and the time are no parameters.
        let is_command = matches!(at.index, PRE_DEFINED_ERRORS | STORE | RESTORE | CONFIGURATION);
        if !(is_command || E::is_command(at.index)) {
            self.dictionary.objects.communication.configuration = [0; 2];
        }
        Some(at)
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
            if self.dictionary.tpdos.has_events() {
                self.dictionary.on_changed(at, turn.now, &mut self.wakes);
            }
            turn.out.event(V::written(at));
        }
    }

    /// Each service follows what was written to its objects.
    fn on_written(&mut self, at: Address) {
        let Dictionary { objects, emcy, .. } = &mut self.dictionary;
        emcy.change(&mut self.wakes).follow(at, &mut objects.communication.emcy);
        if self.sync.follow(at, &objects.communication.sync) {
            self.sync_id = Sealed::of(objects.communication.sync.id());
        }
        let missed = self.monitor.change(&mut self.wakes).follow(at, &objects.consumers);
        if let Some(missed) = missed {
            self.clear(ErrorCode::HEARTBEAT, missed.get());
        }
        if matches!(at.index, CYCLE_PERIOD | RPDO..=LAST_TPDO_MAPPING) {
            self.note_mappings();
            self.wakes.take(&mut self.dictionary.wakes);
        }
        self.follow_second_sdo(at);
        if E::IS_GUARDED {
            self.copy_written_cob_id(at);
        }
    }
}
