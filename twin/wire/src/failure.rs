//! Failures of a bus by their names in ECSS-E-ST-50-15C, Table 5-2, as faults.
//!
//! A wire knows levels, not volts: what leaves the bus usable with a smaller margin shows as a raised bit error rate, and
//! what forbids communication as a line that stays recessive. Cases are numbered as in ISO 11898-2.

use crate::controller::NodeIndex;
use crate::fault::Fault;

/// Bit error rate of a bus with a reduced signal-to-noise ratio: about one frame of 110 bits in a hundred is hit. An
/// assumption; the standard gives no number.
pub const REDUCED_MARGIN: f64 = 1e-4;

/// A failure: what begins it, and what ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// Happens when the failure begins.
    pub onset: Fault,
    /// Happens when it is repaired; `None` when the damage stays.
    pub removal: Option<Fault>,
}

impl Failure {
    /// One node becomes disconnected from the bus.
    pub fn node_disconnected(node: NodeIndex) -> Self {
        Failure { onset: Fault::Disconnect(node), removal: Some(Fault::Reconnect(node)) }
    }

    /// One node loses power.
    pub fn node_unpowered(node: NodeIndex) -> Self {
        Failure { onset: Fault::PowerOff(node), removal: Some(Fault::PowerOn(node)) }
    }

    /// One node loses ground: its levels leave the common-mode range of the others, which is like an open stub.
    pub fn ground_lost(node: NodeIndex) -> Self {
        Failure::node_disconnected(node)
    }

    /// Loss of the shield connection at any node.
    pub fn shield_lost(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    /// Case 1.
    pub fn can_h_interrupted(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    /// Case 2.
    pub fn can_l_interrupted(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    /// Case 3a: to at most +7 V.
    pub fn can_h_shorted_to_low_voltage(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    /// Case 3b: to a voltage that the transceivers survive; CAN_L follows through the termination.
    pub fn can_h_shorted_in_range(position_m: f64) -> Self {
        Failure::recessive(position_m)
    }

    /// Case 3c: to a voltage that destroys transceivers.
    pub fn can_h_shorted_out_of_range(position_m: f64) -> Self {
        Failure { removal: None, ..Failure::recessive(position_m) }
    }

    /// Case 4.
    pub fn can_l_shorted_to_ground(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    /// Case 5.
    pub fn can_h_shorted_to_ground(position_m: f64) -> Self {
        Failure::recessive(position_m)
    }

    /// Case 6a: to a voltage that the transceivers survive.
    pub fn can_l_shorted_in_range(position_m: f64) -> Self {
        Failure::recessive(position_m)
    }

    /// Cases 6b and 6c: to a voltage that destroys transceivers.
    pub fn can_l_shorted_out_of_range(position_m: f64) -> Self {
        Failure { removal: None, ..Failure::recessive(position_m) }
    }

    /// Case 7.
    pub fn can_l_shorted_to_can_h(position_m: f64) -> Self {
        Failure::recessive(position_m)
    }

    /// Case 8: both wires at the same location.
    pub fn both_interrupted(position_m: f64) -> Self {
        Failure { onset: Fault::Cut { position_m }, removal: Some(Fault::Restore { position_m }) }
    }

    /// Case 9: one connection to a termination network.
    pub fn termination_lost(seed: u64) -> Self {
        Failure::reduced_margin(seed)
    }

    fn reduced_margin(seed: u64) -> Self {
        Failure {
            onset: Fault::BitErrors { rate: REDUCED_MARGIN, seed },
            removal: Some(Fault::BitErrors { rate: 0.0, seed }),
        }
    }

    fn recessive(position_m: f64) -> Self {
        Failure { onset: Fault::Short { position_m, level: true }, removal: Some(Fault::ClearShorts) }
    }
}
