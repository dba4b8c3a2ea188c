//! Receive and transmit PDOs of a node, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::parameters::MAPPED;
pub use super::receive::{Rpdos, Taken};
pub use super::transmit::{AT_ONCE, Tpdos};

/// Rules for writing the parameters of a PDO by SDO.
pub mod rules {
    pub use crate::pdo::rules::{LAST_CYCLIC, is_synchronous, mapping, parameters, resolve};
}
