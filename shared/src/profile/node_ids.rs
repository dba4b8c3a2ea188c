//! Check of the Node-IDs of a profile.

use super::Profile;
use crate::od::machine::Reason;
use crate::store::identity::{MAINTENANCE, is_slave};
use crate::types::NodeId;

impl Profile {
    /// Stops the build if the profile has a slave with the Node-ID of the master or of boards in maintenance mode
    /// ([`MAINTENANCE`]).
    #[track_caller]
    pub(super) const fn assert_node_ids(&self) {
        let mut nth = 0;
        while nth < self.slaves.len() {
            assert_slave("`slaves`", self.slaves[nth].node);
            nth += 1;
        }
        nth = 0;
        while nth < self.settings.len() {
            assert_slave("`settings`", self.settings[nth].node);
            nth += 1;
        }
        nth = 0;
        while nth < self.minimal.len() {
            assert_slave("`minimal`", self.minimal[nth].node);
            nth += 1;
        }
        nth = 0;
        while nth < self.selective.len() {
            let node = self.selective[nth];
            if node.get() == MAINTENANCE.get() {
                refuse("`selective`", node);
            }
            nth += 1;
        }
    }
}

#[track_caller]
const fn assert_slave(list: &str, node: NodeId) {
    if !is_slave(node) {
        refuse(list, node);
    }
}

#[track_caller]
const fn refuse(list: &str, node: NodeId) {
    let found = Reason::new(list).text(" has node ").number(node.get() as u32);
    found.text(": slaves are 2 to 126, 1 is the master, 127 a board in maintenance mode").refuse();
}
