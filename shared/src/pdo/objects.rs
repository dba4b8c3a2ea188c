//! Objects of PDOs: 1400h, 1600h, 1800h, 1A00h and those in a row with them.

use core::fmt::Debug;

use super::{CobIdOf, Mapping, PdoMapping, PdoSet, Rpdo, RpdoParameters, Tpdo, TpdoParameters};
use crate::od::{INVALID, NO_REMOTE, Objects};
use crate::types::NodeId;

/// `R` receive and `T` transmit PDOs, at most 512 of each. `M` is how they are mapped: [`PdoMapping`] or
/// [`StaticMapping`](super::StaticMapping).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct PdoObjects<const R: usize = 8, const T: usize = 8, M: Mapping = PdoMapping> {
    /// Receive PDO communication parameter
    #[object(0x1400.., record)]
    pub rpdos: [RpdoParameters; R],
    /// Receive PDO mapping parameter
    #[object(0x1600.., record)]
    pub rpdo_mappings: [M; R],
    /// Transmit PDO communication parameter
    #[object(0x1800.., record)]
    pub tpdos: [TpdoParameters; T],
    /// Transmit PDO mapping parameter
    #[object(0x1A00.., record)]
    pub tpdo_mappings: [M; T],
}

/// Room for the PDOs of a device: [`PdoObjects`] of any size.
pub trait PdoSlots: Objects + Default + Clone + Debug {
    /// Receive PDOs.
    const RECEIVE: usize;
    /// Transmit PDOs.
    const TRANSMIT: usize;

    /// How they are mapped.
    type Mapping: Mapping;
    /// Something for each receive PDO.
    type Receive<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;
    /// Something for each transmit PDO.
    type Transmit<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;

    /// The same for all receive PDOs.
    fn receive<X: Copy + Debug>(value: X) -> Self::Receive<X>;
    /// The same for all transmit PDOs.
    fn transmit<X: Copy + Debug>(value: X) -> Self::Transmit<X>;

    /// Parameters of receive PDOs, and what these carry.
    fn rpdos(&self) -> (&[RpdoParameters], &[Self::Mapping]);
    /// The same, to be changed.
    fn rpdos_mut(&mut self) -> (&mut [RpdoParameters], &mut [Self::Mapping]);
    /// Parameters of transmit PDOs, and what these carry.
    fn tpdos(&self) -> (&[TpdoParameters], &[Self::Mapping]);
    /// The same, to be changed.
    fn tpdos_mut(&mut self) -> (&mut [TpdoParameters], &mut [Self::Mapping]);

    /// The PDOs of `node` at power-on. Those that are not in the set are not valid and carry nothing; the first four of
    /// each kind then have the COB-IDs of the generic pre-defined connection set (CiA 301 7.3.3).
    fn at_power_on(node: NodeId, set: &PdoSet) -> Self {
        let mut all = Self::default();
        let bases = [0x200_u32, 0x300, 0x400, 0x500];
        let (rpdos, rpdo_mappings) = all.rpdos_mut();
        for (pdo, base) in rpdos.iter_mut().zip(bases) {
            pdo.cob_id = INVALID | NO_REMOTE | (base + u32::from(node.get()));
        }
        let cob_id = |id: CobIdOf| NO_REMOTE | u32::from(id.of(node).raw());
        for pdo in set.rpdos().iter().map(Rpdo::pdo) {
            let slot = pdo.slot();
            if let (Some(to), Some(mapping)) = (rpdos.get_mut(slot), rpdo_mappings.get_mut(slot)) {
                (to.cob_id, to.transmission) = (cob_id(pdo.cob_id), pdo.transmission);
                to.event_timer = pdo.event_timer;
                mapping.map(pdo.mapping());
            }
        }
        let (tpdos, tpdo_mappings) = all.tpdos_mut();
        for (pdo, base) in tpdos.iter_mut().zip(bases) {
            pdo.cob_id = INVALID | NO_REMOTE | (base - 0x80 + u32::from(node.get()));
        }
        for pdo in set.tpdos().iter().map(Tpdo::pdo) {
            let slot = pdo.slot();
            if let (Some(to), Some(mapping)) = (tpdos.get_mut(slot), tpdo_mappings.get_mut(slot)) {
                (to.cob_id, to.transmission) = (cob_id(pdo.cob_id), pdo.transmission);
                (to.inhibit, to.event_timer) = (pdo.inhibit, pdo.event_timer);
                to.sync_start = pdo.sync_start;
                mapping.map(pdo.mapping());
            }
        }
        all
    }
}

impl<const R: usize, const T: usize, M: Mapping> PdoSlots for PdoObjects<R, T, M> {
    const RECEIVE: usize = R;
    const TRANSMIT: usize = T;

    type Mapping = M;
    type Receive<X: Copy + Debug> = [X; R];
    type Transmit<X: Copy + Debug> = [X; T];

    fn receive<X: Copy + Debug>(value: X) -> [X; R] {
        const { assert!(R <= 512, "at most 512 receive PDOs") };
        [value; R]
    }

    fn transmit<X: Copy + Debug>(value: X) -> [X; T] {
        const { assert!(T <= 512, "at most 512 transmit PDOs") };
        [value; T]
    }

    #[inline]
    fn rpdos(&self) -> (&[RpdoParameters], &[M]) {
        (&self.rpdos, &self.rpdo_mappings)
    }

    #[inline]
    fn rpdos_mut(&mut self) -> (&mut [RpdoParameters], &mut [M]) {
        (&mut self.rpdos, &mut self.rpdo_mappings)
    }

    #[inline]
    fn tpdos(&self) -> (&[TpdoParameters], &[M]) {
        (&self.tpdos, &self.tpdo_mappings)
    }

    #[inline]
    fn tpdos_mut(&mut self) -> (&mut [TpdoParameters], &mut [M]) {
        (&mut self.tpdos, &mut self.tpdo_mappings)
    }
}
