//! Maintenance mode: the only mode in which a Node-ID can be stored (ECSS 6.10g).

use super::Slave;
use crate::node::SpacecraftDevice;
use crate::redundancy::Parameters;
use crate::store::ParameterStore;
use crate::types::{Bus, Duration};

impl<D: SpacecraftDevice> Slave<D> {
    /// Makes it a slave in maintenance mode: see [`Slave::builder`].
    pub(super) fn maintain(&mut self, store: Option<&'static mut (dyn ParameterStore + Send)>) {
        // Without a consumer time there is no search, without a producer time no heartbeat.
        let (consumer, producer) = (Duration::ZERO, Duration::ZERO);
        self.initial = Parameters { consumer, producer, bdefault: Bus::Nominal, ..self.initial };
        self.canopen.maintain();
        // Nothing is loaded; Bdefault is selected.
        self.load_all();
        if let Some(store) = store {
            self.show_node_id(store);
            self.canopen.services_mut().storage_mut().maintain(store);
        }
    }

    /// Object 2046h.
    pub(super) fn show_node_id(&mut self, store: &mut (dyn ParameterStore + Send)) {
        self.canopen.services_mut().objects_mut().extension.show_node_id(store.node_id());
    }
}
