//! Objects of the services: what is stored of them, and what a service does when one has changed.

use super::{Dictionary, FIRST_TOLD, NodeEvent, Services, show};
use crate::emcy;
use crate::emcy::ErrorCode;
use crate::heartbeat::ConsumerSlots;
use crate::node::index::{
    CONFIGURATION, CONSUMER_HEARTBEAT, EMCY_COB_ID, EMCY_INHIBIT, LAST_TPDO_MAPPING, PRE_DEFINED_ERRORS,
    REDUNDANCY, REQUEST_NMT, RESTORE, RPDO, SCET_SET, SELF_TEST_START, STORE, SYNC_COB_ID, SYNC_OVERFLOW,
    SYNCHRONOUS_WINDOW,
};
use crate::node::{Device, NodeObjects, Outbox, SelfTest};
use crate::od::CobIdEntry;
use crate::pdo::PdoSlots;
use crate::store::{Group, Loaded};
use crate::types::{Address, Instant};

impl<D: Device> Services<D> {
    /// Takes all services' parameters from the dictionary, at power-on and when communication is reset.
    pub fn configure(&mut self, now: Instant) {
        let Self { dictionary, server, .. } = self;
        server.reset(dictionary);
        dictionary.written = None;
        dictionary.rpdos.stop();
        dictionary.tpdos.stop();
        self.configure_sync();
        self.configure_emcy();
        for sub in (1..).take(self.consumers()) {
            self.set_monitor(sub);
        }
        // All become invalid first: an old one must not be in the way of a new one.
        let most = D::Pdos::RECEIVE.max(D::Pdos::TRANSMIT);
        (0..most).for_each(|number| self.dictionary.unset_pdos(number, now));
        (0..most).for_each(|number| self.dictionary.set_pdos(number, now));
        self.note_mappings();
        self.dictionary.emcy.restart();
        show(&self.dictionary.emcy, &mut self.dictionary.objects.communication);
    }

    /// Takes an object of its services as the application has changed it.
    pub fn follow(&mut self, at: Address, now: Instant) {
        if at.index == SCET_SET {
            self.clock.set(self.dictionary.objects.spacecraft.scet_set.into(), now);
        }
        if at.index >= FIRST_TOLD && at.index != REDUNDANCY {
            return;
        }
        if matches!(at.index, RPDO..=LAST_TPDO_MAPPING) {
            let number = usize::from(at.index & 0x1FF);
            self.dictionary.unset_pdos(number, now);
            self.dictionary.set_pdos(number, now);
            show(&self.dictionary.emcy, &mut self.dictionary.objects.communication);
        }
        self.on_written(at);
    }

    /// Applies what is stored of a group; the services take it with [`Services::configure`].
    #[inline(never)] // of two callers, neither in a hurry
    pub fn load(&mut self, group: Group) {
        let objects = &mut self.dictionary.objects.communication;
        // Bit 0: on command.
        objects.store = [u32::from(self.dictionary.stored.store.is_some()); 4];
        objects.restore = objects.store;
        match self.dictionary.load(group) {
            Ok(None | Some(Loaded::Nothing | Loaded::Set { skipped: 0, .. })) => {}
            // Defaults hold where nothing was applied: until parameters are saved anew.
            Ok(Some(Loaded::Foreign { .. } | Loaded::Set { .. })) | Err(_) => {
                self.raise(ErrorCode::DATA_SET, [0; 5]);
            }
        }
    }

    /// Returns the object that was written last over the bus, once. A written parameter clears 1020h: the configuration is no
    /// longer the one that was verified (CiA 301 7.5.2.23).
    #[inline]
    pub fn take_written(&mut self) -> Option<Address> {
        let at = self.dictionary.written.take()?;
        // History, signatures, the stamp itself, commands and the time are no parameters.
        let is_parameter = !matches!(
            at.index,
            PRE_DEFINED_ERRORS | STORE | RESTORE | CONFIGURATION | REQUEST_NMT | SCET_SET | SELF_TEST_START
        );
        if is_parameter {
            self.dictionary.objects.communication.configuration = [0; 2];
        }
        Some(at)
    }

    /// An object that is not the application's was written over the bus: services and clock follow.
    pub fn on_own_written<E: NodeEvent>(&mut self, at: Address, now: Instant, out: &mut Outbox<E>) {
        match at.index {
            SCET_SET => {
                self.clock.set(self.dictionary.objects.spacecraft.scet_set.into(), now);
                out.event(E::time(self.clock.at(now)));
            }
            SELF_TEST_START => {
                let running = SelfTest { progress: SelfTest::RUNNING, failures: 0 };
                self.dictionary.objects.spacecraft.self_test = running;
                out.event(E::self_test());
            }
            _ => {}
        }
        if at.index < FIRST_TOLD || at.index == REDUNDANCY {
            self.on_written(at);
            self.next = now;
        }
    }

    /// An object was written over the bus: an event for the application, and for the TPDOs that carry it.
    #[inline]
    pub fn report_written<E: NodeEvent>(&mut self, at: Address, now: Instant, out: &mut Outbox<E>) {
        if at.index >= FIRST_TOLD {
            if self.dictionary.tpdos.has_events() {
                self.dictionary.on_changed(at, now);
                self.wake(self.dictionary.tpdos.deadline());
            }
            out.event(E::written(at));
        }
    }

    /// Follows what was written to an object of its services.
    fn on_written(&mut self, at: Address) {
        match at.index {
            PRE_DEFINED_ERRORS => {
                let Dictionary { objects, emcy, .. } = &mut self.dictionary;
                let _ = emcy.history_mut().write_len(0);
                show(emcy, &mut objects.communication);
            }
            SYNC_COB_ID | SYNCHRONOUS_WINDOW | SYNC_OVERFLOW => self.configure_sync(),
            EMCY_COB_ID | EMCY_INHIBIT => self.configure_emcy(),
            CONSUMER_HEARTBEAT => self.set_monitor(at.sub),
            RPDO..=LAST_TPDO_MAPPING => self.note_mappings(),
            _ => {}
        }
    }

    /// Restarts monitoring by an entry of 1016h and clears its missed-heartbeat error.
    fn set_monitor(&mut self, sub: u8) {
        let entry = usize::from(sub).wrapping_sub(1);
        let value = self.dictionary.objects.consumers.entries().get(entry).copied().unwrap_or(0);
        if let Some(missed) = self.monitor.set(sub, value) {
            self.clear(ErrorCode::HEARTBEAT, missed.get());
        }
    }

    fn configure_sync(&mut self) {
        let communication = &self.dictionary.objects.communication;
        self.sync_id = CobIdEntry::from_raw(communication.sync_cob_id).id();
        self.sync.configure(communication.sync_overflow, communication.synchronous_window);
    }

    fn configure_emcy(&mut self) {
        let Dictionary { objects: NodeObjects { communication, .. }, emcy, .. } = &mut self.dictionary;
        emcy.configure(emcy::Config::new(communication.emcy_cob_id, communication.emcy_inhibit));
    }
}
