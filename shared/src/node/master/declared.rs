//! Objects of a master beside those of every node.

use easy_ext::ext;

use super::{Master, Turn};
use crate::emcy::{ActiveErrors, DeviceError, EmcyConsumers};
use crate::nmt::NmtStartup;
use crate::node::services::Services;
use crate::node::{
    Communication, Device, DeviceNode, DeviceObjects, DeviceTime, NetworkObjects, SpacecraftDevice,
};
use crate::od::Objects;
use crate::pdo::PdoSet;
use crate::redundancy::MasterBoards;
use crate::sdo::{SdoServerObjects, SdoServers};
use crate::time::LocalUtc;
use crate::types::{AbortCode, Address, Instant, NodeId, UtcRelation};

/// 1005h: it produces SYNC.
const PRODUCES: u32 = 1 << 30;

/// Objects of a master beside those of every node: the objects of its device and of its network management.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct MasterObjects<D: SpacecraftDevice> {
    /// Objects of the device
    #[objects]
    pub device: D,
    /// Objects of the EMCY consumer
    #[objects]
    pub(crate) emergencies: EmcyConsumers,
    /// Active errors of the slaves
    #[objects]
    pub errors: ActiveErrors,
    /// Objects of the network management
    #[objects]
    pub network: NetworkObjects,
}

/// Its constructor is checked by [`Master`](super::Master).
#[diagnostic::do_not_recommend]
impl<D: SpacecraftDevice> DeviceObjects for MasterObjects<D> {
    type Sdo = SdoServerObjects;
}

#[diagnostic::do_not_recommend]
impl<D: SpacecraftDevice> Device for MasterObjects<D> {
    type Pdos = D::Pdos;
    type Consumers = D::Consumers;

    const PDOS: PdoSet = {
        assert!(
            D::Sdo::SECOND_SERVER.is_none(),
            "a master has one SDO server: its device has no `sdo_servers = 2`"
        );
        D::PDOS
    };

    /// Produces SYNC (ECSS 6.9d), and reports its errors as a slave does (1014h).
    fn communication(id: NodeId) -> Communication {
        let mut communication = D::communication(id);
        communication.sync.cob_id |= PRODUCES;
        communication.nmt.startup = NmtStartup::MASTER.raw();
        communication
    }

    fn consumers(id: NodeId) -> D::Consumers {
        D::consumers(id)
    }

    fn pdos(id: NodeId) -> D::Pdos {
        D::pdos(id)
    }
}

#[diagnostic::do_not_recommend]
impl<D: SpacecraftDevice> DeviceTime for MasterObjects<D> {
    const FINE_BITS: u32 = D::FINE_BITS;
    const UTC: Option<UtcRelation> = D::UTC;
    const SUBMILLISECONDS: bool = D::SUBMILLISECONDS;

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        self.device.utc()
    }
}

/// Objects of the master that its parts read and show.
#[ext(MasterServices)]
impl<D: SpacecraftDevice> Services<MasterObjects<D>> {
    pub fn network(&self) -> &NetworkObjects {
        &self.objects().application.network
    }

    pub fn network_mut(&mut self) -> &mut NetworkObjects {
        &mut self.objects_mut().application.network
    }

    pub fn errors(&self) -> &ActiveErrors {
        &self.objects().application.errors
    }

    pub fn errors_mut(&mut self) -> &mut ActiveErrors {
        &mut self.objects_mut().application.errors
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> DeviceNode for Master<D, B> {
    type Device = D;

    fn device(&self) -> &D {
        &self.objects().application.device
    }

    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut D) -> R) -> R {
        self.services.change(now, |objects| change(&mut objects.application.device))
    }

    fn write(&mut self, at: Address, value: &[u8], turn: &mut Turn) -> Result<(), AbortCode> {
        if let Some(at) = self.services.write(at, value, turn.now)? {
            self.on_written(at, turn);
        }
        self.run_all(turn);
        Ok(())
    }

    fn raise(&mut self, error: DeviceError, info: [u8; 4]) {
        self.services.raise(error.code, error.field(info));
    }

    fn clear(&mut self, error: DeviceError) {
        self.services.clear(error.code, error.source);
    }
}
