//! The object dictionary of a node, master or slave.

use crate::node::{Communication, Spacecraft};
use crate::od::Objects;
use crate::pdo::{Mapping, PdoMapping, PdoSet};
use crate::redundancy::{Parameters, Redundancy};
use crate::sdo::{SdoParameters, SdoServerObjects};
use crate::types::{CobId, NodeId};

/// Everything a node holds: `A` are the objects of its application, `R` and `T` its receive and transmit PDOs, `M` how
/// these are mapped.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct NodeObjects<A: Objects + Default, const R: usize = 8, const T: usize = 8, M: Mapping = PdoMapping>
{
    /// Of the application
    #[objects]
    pub application: A,
    /// Of ECSS-E-ST-50-15C
    #[objects]
    pub spacecraft: Spacecraft,
    /// Of the communication profile
    #[objects]
    pub communication: Communication<R, T, M>,
    /// Of the SDO server
    #[objects]
    pub sdo: SdoServerObjects,
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> NodeObjects<A, R, T, M> {
    /// The objects at power-on. An application whose indices are those of the node does not compile.
    pub fn new(
        id: NodeId,
        redundancy: &Parameters,
        application: A,
        communication: Communication<R, T, M>,
    ) -> Self {
        const { Self::DECLARED.assert_distinct() };
        let channel = SdoParameters {
            request: u32::from(CobId::sdo_request(id).raw()),
            response: u32::from(CobId::sdo_response(id).raw()),
        };
        let mut objects = NodeObjects {
            application,
            spacecraft: Spacecraft::default(),
            communication,
            sdo: SdoServerObjects { sdo_server: channel },
        };
        objects.set_redundancy(redundancy);
        objects.set_heartbeats(redundancy);
        objects
    }

    /// Objects 1016h and 1017h: the master is consumed first of all (ECSS 6.5.2b).
    pub fn set_heartbeats(&mut self, redundancy: &Parameters) {
        let time = redundancy.consumer.as_millis() as u32 & 0xFFFF;
        if let Some(first) = self.communication.consumer_heartbeat.first_mut() {
            *first = u32::from(NodeId::MASTER.get()) << 16 | time;
        }
        self.communication.producer_heartbeat = redundancy.producer.as_millis() as u16;
    }

    /// Object 2000h.
    pub fn set_redundancy(&mut self, redundancy: &Parameters) {
        self.spacecraft.redundancy = Redundancy {
            bdefault: redundancy.bdefault.bdefault(),
            ttoggle: redundancy.ttoggle,
            ntoggle: redundancy.ntoggle,
            ctoggle: redundancy.ctoggle,
        };
    }
}

/// Stops the build when a node with the application `A` cannot have these PDOs, or when `A` has indices of the node.
/// `#[objects(pdos = ..)]` writes a call of it.
///
/// # Panics
/// When called at run time, for the same reasons.
#[track_caller]
pub const fn assert_pdos<A: Objects + Default, const R: usize, const T: usize>(pdos: &PdoSet<R, T>) {
    let declared = NodeObjects::<A, R, T, PdoMapping>::DECLARED;
    declared.assert_distinct();
    pdos.assert_within(declared);
}
