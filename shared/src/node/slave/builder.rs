//! Builder of a slave.

use super::Slave;
use crate::emcy::PostMortem;
use crate::node::stored::Stored;
use crate::node::{Hardware, SpacecraftDevice};
use crate::profile::Profile;
use crate::redundancy::Parameters;
use crate::store::identity::MAINTENANCE;
use crate::store::{ParameterStore, RetainedMemory};
use crate::types::{Bus, Duration, NodeId};

/// Builder of a [`Slave`]. A board gives all that its slave uses at once, as `hardware`:
///
/// ```
/// use ecss_can::node::{Hardware, SlaveBuilder, SpacecraftDevice};
/// use ecss_can::prelude::*;
///
/// fn slave<D: SpacecraftDevice + Default>(id: NodeId, hardware: Hardware) -> Slave<D> {
///     Slave::builder(id, &Profile::DEFAULT, D::default()).hardware(hardware).build()
/// }
/// ```
#[derive(Debug)]
#[must_use = "`build` makes the slave"]
pub struct SlaveBuilder<'p, D: SpacecraftDevice> {
    id: NodeId,
    profile: &'p Profile,
    device: D,
    hardware: Hardware,
}

impl<D: SpacecraftDevice> Slave<D> {
    /// Begins a slave without a parameter store and without retained memory.
    ///
    /// `id` is 2 to 126, or 127 ([`MAINTENANCE`]) for maintenance mode. In that mode the node is on the nominal bus
    /// alone, in Pre-operational, and answers SDO requests. It sends and receives nothing else, and neither loads nor
    /// saves parameters. A client stores a Node-ID by object 2046h, which every other mode refuses.
    pub fn builder(id: NodeId, profile: &Profile, device: D) -> SlaveBuilder<'_, D> {
        SlaveBuilder { id, profile, device, hardware: Hardware::default() }
    }
}

impl<D: SpacecraftDevice> SlaveBuilder<'_, D> {
    /// Takes everything that the board has for its slave. It replaces what was set before.
    pub fn hardware(self, hardware: Hardware) -> Self {
        SlaveBuilder { hardware, ..self }
    }

    /// Takes a parameter store: objects 1010h and 1011h work, and the stored parameters apply from power-on.
    pub fn store(mut self, store: &'static mut (dyn ParameterStore + Send)) -> Self {
        self.hardware.store = Some(store);
        self
    }

    /// Takes memory that outlives a reset. The slave starts on the bus where it last found its master, and counts
    /// resets in a row across resets of its chip.
    pub fn retained(mut self, words: &'static mut (dyn RetainedMemory + Send)) -> Self {
        self.hardware.retained = Some(words);
        self
    }

    /// Takes the record of the last reset for object 2032h. An emergency follows the boot-up message: 6100h, 3200h
    /// for a brown-out, 5000h for the oscillator; none without a cause.
    pub fn post_mortem(mut self, record: PostMortem) -> Self {
        self.hardware.post_mortem = record;
        self
    }

    /// Sends some heartbeats late, by [`Profile::late_heartbeat`]. Each heartbeat takes the next bit of `pattern`
    /// and is late if the bit is set. The default is zero: no heartbeat is late.
    ///
    /// Give each chip another pattern, such as a CRC-32 of its unique ID. By it two boards with one Node-ID find
    /// each other when they boot together with equal clocks (EMCY 8150h).
    pub fn late_heartbeats(mut self, pattern: u32) -> Self {
        self.hardware.late_heartbeats = pattern;
        self
    }

    /// Makes the slave, before power-on.
    #[inline(always)] // row `size.pyboard-v11.slave.stack`: made in its place
    pub fn build(self) -> Slave<D> {
        let SlaveBuilder { id, profile, device, hardware } = self;
        let mut slave = Slave::new(id, profile, device, hardware.upsets);
        slave.equip(hardware);
        slave
    }
}

impl<D: SpacecraftDevice> Slave<D> {
    /// Takes what the board has, before power-on.
    fn equip(&mut self, hardware: Hardware) {
        let Hardware { store, retained, post_mortem, late_heartbeats, .. } = hardware;
        self.canopen.services_mut().objects_mut().extension.set_post_mortem(post_mortem);
        if self.canopen.control().id() == MAINTENANCE {
            return self.maintain(store);
        }
        self.canopen.control_mut().set_pattern(late_heartbeats);
        if let Some(words) = retained {
            self.retain(words);
        }
        if let Some(store) = store {
            self.show_node_id(store);
            *self.canopen.services_mut().storage_mut() = Stored::new(Some(store));
            self.load_all();
        }
    }

    /// Makes it a slave in maintenance mode: see [`Slave::builder`].
    fn maintain(&mut self, store: Option<&'static mut (dyn ParameterStore + Send)>) {
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
    fn show_node_id(&mut self, store: &mut (dyn ParameterStore + Send)) {
        self.canopen.services_mut().objects_mut().extension.show_node_id(store.node_id());
    }
}
