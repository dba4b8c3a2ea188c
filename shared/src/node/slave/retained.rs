//! Start of a slave on the Bdefault that outlived a reset.

use super::Slave;
use crate::node::SpacecraftDevice;
use crate::node::services::SpacecraftServices;
use crate::node::slave::Turn;
use crate::redundancy::Retained;
use crate::store::{Group, RetainedMemory};
use crate::types::Bus;

/// Memory that outlives a reset, if the board has some.
#[derive(Default)]
pub(super) struct Memory(Option<&'static mut (dyn RetainedMemory + Send)>);

impl core::fmt::Debug for Memory {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Memory").field(&self.0.is_some()).finish()
    }
}

impl Memory {
    pub fn write(&mut self, retained: Retained) {
        if let Some(words) = &mut self.0 {
            words.write(retained.encode());
        }
    }
}

impl<D: SpacecraftDevice> Slave<D> {
    /// Takes memory that outlives a reset, before power-on.
    pub(super) fn retain(&mut self, words: &'static mut (dyn RetainedMemory + Send)) {
        let retained = Retained::decode(words.read()).unwrap_or_default();
        self.memory = Memory(Some(words));
        self.select_bdefault(retained);
    }

    /// Takes the stored parameters, before power-on.
    pub(super) fn load_all(&mut self) {
        self.show_bdefault(self.initial.bdefault);
        self.canopen.services_mut().load(Group::All);
        self.select_bdefault(self.redundancy.retained());
    }

    /// Selects the retained Bdefault, else the stored one, which the dictionary has (ECSS 8.3.2a).
    fn select_bdefault(&mut self, retained: Retained) {
        let services = self.canopen.services();
        let (access, stored) = (services.buses().access(), services.written_redundancy());
        self.redundancy.no_sooner().restart(access, stored, retained);
        self.show_bdefault(self.redundancy.selected());
    }

    fn show_bdefault(&mut self, bus: Bus) {
        self.canopen.services_mut().objects_mut().extension.set_bdefault(bus);
    }

    /// "save" or "load" was written: the next reset starts on the Bdefault that is stored now.
    pub(super) fn on_stored(&mut self, is_saved: bool, turn: &mut Turn) {
        let written = self.canopen.services().written_redundancy().bdefault;
        let stored = if is_saved { written } else { self.initial.bdefault };
        self.decide(turn, |redundancy, step| redundancy.on_stored(stored, step));
    }
}
