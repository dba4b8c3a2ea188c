//! Objects of the master at power-on, and after "reset communication".

use super::declared::MasterObjects;
use crate::emcy::{ActiveErrors, EmcyConsumers, PostMortem};
use crate::heartbeat::machine::longest_time;
use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::node::network_objects::entry;
use crate::node::services::{Services, carries_time};
use crate::node::{NetworkObjects, NodeObjects, SpacecraftDevice};
use crate::pdo::PdoSlots;
use crate::pdo::machine::rules::{LAST_CYCLIC, is_synchronous};
use crate::profile::Profile;
use crate::redundancy::{MasterSetup, Parameters};
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
        let application = application(profile, device);
        let mut objects = NodeObjects::at_power_on(NodeId::MASTER, self.heartbeats(), application);
        objects.extension.set_redundancy(&self.redundancy);
        objects.extension.set_post_mortem(post_mortem);
        self.apply(&mut objects);
        objects
    }

    /// Restores the communication profile of power-on.
    pub fn restore<D: SpacecraftDevice>(&self, objects: &mut NodeObjects<MasterObjects<D>>) {
        objects.restore_communication(NodeId::MASTER, self.heartbeats());
        self.apply(objects);
    }

    /// Returns the period of its own heartbeat. The entries of 1016h are for slaves.
    const fn heartbeats(&self) -> HeartbeatTimes {
        HeartbeatTimes { consumer: Duration::ZERO, producer: self.redundancy.producer }
    }

    /// Applies the periods of the mission to the communication profile.
    fn apply<D: SpacecraftDevice>(&self, objects: &mut NodeObjects<MasterObjects<D>>) {
        objects.communication.sync.cycle_period = self.sync.as_micros() as u32;
        // Entries of 1016h take the time of the profile where the device declares none.
        let time = self.redundancy.consumer.as_millis() as u32 & 0xFFFF;
        for entry in objects.consumers.entries_mut() {
            if *entry >> 16 != 0 && *entry & 0xFFFF == 0 {
                *entry |= time;
            }
        }
        self.apply_time(&mut objects.pdos);
    }

    /// PDOs of the time take the period of the profile where the device declares none: with SYNCs every n-th one.
    fn apply_time(&self, pdos: &mut impl PdoSlots) {
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
