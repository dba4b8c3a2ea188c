//! Objects of the master at power-on, and after "reset communication".

use super::declared::MasterObjects;
use crate::emcy::{ActiveErrors, EmcyConsumers, PostMortem};
use crate::heartbeat::machine::longest_time;
use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::node::network_objects::entry;
use crate::node::services::{Services, carries_time};
use crate::node::{
    Communication, Device, NetworkObjects, NodeObjects, Spacecraft, SpacecraftDevice, assert_device,
};
use crate::pdo::PdoSlots;
use crate::pdo::machine::rules::{LAST_CYCLIC, is_synchronous};
use crate::profile::Profile;
use crate::redundancy::{MasterSetup, Parameters};
use crate::sdo::SdoServerObjects;
use crate::types::{Duration, NodeId};

/// Transmission type of a PDO that goes with each SYNC.
const EVERY_SYNC: u8 = 1;

/// Numbers of the profile that power-on and reset communication begin with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Initial {
    redundancy: Parameters,
    sync: Duration,
    time: Duration,
}

/// Returns the numbers of the redundancy at power-on.
pub(super) fn setup(profile: &Profile) -> MasterSetup {
    MasterSetup {
        parameters: profile.master_redundancy(),
        silent_share: profile.silent_share,
        dwell: profile.dwell,
        grace: profile.grace,
        access: profile.access(NodeId::MASTER),
        lifetime: profile.heartbeat,
    }
}

impl Initial {
    pub fn new(profile: &Profile) -> Initial {
        Initial { redundancy: profile.master_redundancy(), sync: profile.sync, time: profile.time }
    }

    /// Makes the objects at power-on.
    pub fn objects<D: SpacecraftDevice>(
        &self,
        profile: &Profile,
        device: D,
        post_mortem: PostMortem,
    ) -> NodeObjects<MasterObjects<D>> {
        const { assert_device::<MasterObjects<D>>() };
        NodeObjects {
            application: application(profile, device),
            extension: self.spacecraft(post_mortem),
            communication: self.communication::<D>(),
            consumers: self.consumers::<D>(),
            pdos: self.pdos::<D>(),
            sdo: SdoServerObjects::of(NodeId::MASTER),
        }
    }

    /// Restores the communication profile of power-on.
    pub fn restore<D: SpacecraftDevice>(&self, objects: &mut NodeObjects<MasterObjects<D>>) {
        objects.communication = self.communication::<D>();
        objects.consumers = self.consumers::<D>();
        objects.pdos = self.pdos::<D>();
    }

    fn spacecraft(&self, post_mortem: PostMortem) -> Spacecraft {
        let mut spacecraft = Spacecraft::default();
        spacecraft.set_redundancy(&self.redundancy);
        spacecraft.set_post_mortem(post_mortem);
        spacecraft
    }

    /// Returns the communication profile with the periods of the mission.
    pub fn communication<D: SpacecraftDevice>(&self) -> Communication {
        let mut communication = MasterObjects::<D>::communication(NodeId::MASTER);
        communication.heartbeat.time = self.redundancy.producer.as_millis() as u16;
        communication.sync.cycle_period = self.sync.as_micros() as u32;
        communication
    }

    /// 1016h: entries take the time of the profile where the device declares none.
    fn consumers<D: SpacecraftDevice>(&self) -> D::Consumers {
        let mut consumers = D::consumers(NodeId::MASTER);
        let time = self.redundancy.consumer.as_millis() as u32 & 0xFFFF;
        for entry in consumers.entries_mut() {
            if *entry >> 16 != 0 && *entry & 0xFFFF == 0 {
                *entry |= time;
            }
        }
        consumers
    }

    /// PDOs of the time take the period of the profile where the device declares none: with SYNCs every n-th one.
    fn pdos<D: SpacecraftDevice>(&self) -> D::Pdos {
        let mut pdos = D::pdos(NodeId::MASTER);
        let period = self.time.as_millis().min(u64::from(u16::MAX)) as u16;
        let syncs = self.time.as_micros() / self.sync.as_micros().max(1);
        let (tpdos, mappings) = pdos.tpdos_mut();
        for (tpdo, mapping) in tpdos.iter_mut().zip(mappings) {
            if !carries_time(mapping) {
                continue;
            }
            match tpdo.transmission {
                EVERY_SYNC => tpdo.transmission = syncs.clamp(1, u64::from(LAST_CYCLIC)) as u8,
                by_event if !is_synchronous(by_event) && tpdo.event_timer == 0 => tpdo.event_timer = period,
                _ => {}
            }
        }
        pdos
    }
}

fn application<D: SpacecraftDevice>(profile: &Profile, device: D) -> MasterObjects<D> {
    MasterObjects {
        device,
        emergencies: EmcyConsumers::of_others(NodeId::MASTER),
        errors: ActiveErrors::default(),
        network: network(profile),
    }
}

/// The slaves of the profile.
fn network(profile: &Profile) -> NetworkObjects {
    let boot_time = profile.boot.time.as_millis() as u32;
    let mut network = NetworkObjects { boot_time, ..NetworkObjects::default() };
    for slave in profile.slaves {
        if let Some(assignment) = entry(&mut network.assignment, slave.node) {
            *assignment = slave.assignment().raw();
        }
        network.expect(slave.node, &slave.expected);
    }
    network
}

/// The redundancy parameters as the dictionary has them (1016h, 1017h, 2000h). Without an entry of 1016h in use the
/// consumer time is that of power-on.
pub(super) fn written_redundancy<D: SpacecraftDevice>(
    services: &Services<MasterObjects<D>>,
    initial: &Initial,
) -> Parameters {
    // The longest: no decision goes before a slave's own time.
    let objects = services.objects();
    let consumer = longest_time(objects.consumers.entries()).unwrap_or(initial.redundancy.consumer);
    let producer = services.heartbeat_period();
    objects.extension.redundancy(HeartbeatTimes { consumer, producer })
}
