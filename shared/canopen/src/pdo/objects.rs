//! Objects of PDOs: 1400h, 1600h, 1800h, 1A00h and the following ones.

use core::fmt::Debug;
use core::ops::{Deref, DerefMut};

use super::{Direction, Mapping, PdoMapping, PdoParameters, RpdoParameters};
use crate::od::Objects;

/// PDOs of a device: `R` receive and `T` transmit PDOs, at most 512 of each. `M` is the kind of their mapping:
/// [`PdoMapping`] or [`StaticMapping`](super::StaticMapping).
#[doc(alias("1400h", "1600h", "1800h", "1A00h"))]
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
    pub tpdos: [PdoParameters; T],
    /// Transmit PDO mapping parameter
    #[object(0x1A00.., record)]
    pub tpdo_mappings: [M; T],
}

/// Storage for the PDOs of a device: [`PdoObjects`] of any size.
pub trait PdoSlots: Objects + Default + Clone + Debug {
    /// Number of receive PDOs.
    const RECEIVE: usize;
    /// Number of transmit PDOs.
    const TRANSMIT: usize;

    /// Kind of their mapping.
    type Mapping: Mapping;
    /// Array with one element for each receive PDO.
    type Receive<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;
    /// Array with one element for each transmit PDO.
    type Transmit<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;

    /// Returns an array with the same value for all receive PDOs.
    fn receive<X: Copy + Debug>(value: X) -> Self::Receive<X>;
    /// Returns an array with the same value for all transmit PDOs.
    fn transmit<X: Copy + Debug>(value: X) -> Self::Transmit<X>;

    /// Returns parameters and mappings of the receive PDOs.
    fn rpdos(&self) -> (&[RpdoParameters], &[Self::Mapping]);
    /// Returns parameters and mappings of the receive PDOs, to be changed.
    fn rpdos_mut(&mut self) -> (&mut [RpdoParameters], &mut [Self::Mapping]);
    /// Returns parameters and mappings of the transmit PDOs.
    fn tpdos(&self) -> (&[PdoParameters], &[Self::Mapping]);
    /// Returns parameters and mappings of the transmit PDOs, to be changed.
    fn tpdos_mut(&mut self) -> (&mut [PdoParameters], &mut [Self::Mapping]);

    /// Returns one PDO, counted from zero.
    fn pdo(&self, direction: Direction, number: usize) -> Option<(&PdoParameters, &Self::Mapping)> {
        match direction {
            Direction::Receive => {
                let (parameters, mappings) = self.rpdos();
                parameters.get(number).map(Deref::deref).zip(mappings.get(number))
            }
            Direction::Transmit => {
                let (parameters, mappings) = self.tpdos();
                parameters.get(number).zip(mappings.get(number))
            }
        }
    }

    /// Returns one PDO, counted from zero, to be changed.
    fn pdo_mut(
        &mut self,
        direction: Direction,
        number: usize,
    ) -> Option<(&mut PdoParameters, &mut Self::Mapping)> {
        match direction {
            Direction::Receive => {
                let (parameters, mappings) = self.rpdos_mut();
                parameters.get_mut(number).map(DerefMut::deref_mut).zip(mappings.get_mut(number))
            }
            Direction::Transmit => {
                let (parameters, mappings) = self.tpdos_mut();
                parameters.get_mut(number).zip(mappings.get_mut(number))
            }
        }
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
    fn tpdos(&self) -> (&[PdoParameters], &[M]) {
        (&self.tpdos, &self.tpdo_mappings)
    }

    #[inline]
    fn tpdos_mut(&mut self) -> (&mut [PdoParameters], &mut [M]) {
        (&mut self.tpdos, &mut self.tpdo_mappings)
    }
}
