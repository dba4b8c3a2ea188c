//! Receive PDOs of the nodes of a world, compared with what the others send.

use ecss_can_eds::pdos;

use crate::World;
use crate::key::NodeKey;

impl World {
    /// Finds receive PDOs that do not match the transmit PDO of another node with the same COB-ID: another length,
    /// another type, or values in another order. A world prints them once on stderr, when all nodes have got power. The
    /// dictionaries are compared as they are now.
    pub fn pdo_mismatches(&self) -> Vec<String> {
        pdos::mismatches(&self.mappings())
    }

    /// Finds receive PDOs with a COB-ID that no transmit PDO of this world has. Nodes without power and minimal slaves are left out, and so
    /// are frames of the test itself and those that the application of a master sends to a slave.
    pub fn unsent_pdos(&self) -> Vec<String> {
        pdos::unsent(&self.mappings())
    }

    fn mappings(&self) -> Vec<pdos::Node> {
        let nodes = self.units().iter().filter_map(|unit| unit.node()?.pdos(&name(unit.key)));
        nodes.collect()
    }
}

/// Returns the name of a board in messages.
fn name(key: NodeKey) -> String {
    match key {
        NodeKey::MASTER => "master".to_owned(),
        NodeKey::SECOND_MASTER => "second master".to_owned(),
        key => format!("node {}", key.node().get()),
    }
}
