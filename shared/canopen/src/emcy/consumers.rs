//! Object 1028h: the nodes whose emergencies a master consumes.

use crate::od::{INVALID, Objects};
use crate::types::{AbortCode, Address, CobId, NodeId};

/// Slaves that an array has entries for: sub-index is Node-ID.
const NODES: usize = 127;

/// Emergencies that a node consumes (CiA 301 7.5.2).
#[doc(alias("1028h", "emergency consumer object"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct EmcyConsumers {
    /// Emergency consumer object
    ///
    /// Sub-index is Node-ID. COB-ID of its emergencies, 80h + Node-ID; with bit 31 set they are not consumed.
    #[object(0x1028, array, rw)]
    pub cob_ids: [u32; NODES],
}

impl EmcyConsumers {
    /// Consumes the emergencies of all nodes except `own`.
    #[inline(never)] // made in its place
    pub fn of_others(own: NodeId) -> EmcyConsumers {
        let entry = |nth: usize| {
            let node = NodeId::new(nth as u8 + 1)?;
            Some(emergencies_of(node) | if node == own { INVALID } else { 0 })
        };
        EmcyConsumers { cob_ids: core::array::from_fn(|nth| entry(nth).unwrap_or(INVALID)) }
    }

    /// Returns whether the emergencies of `node` are consumed.
    pub fn consumes(&self, node: NodeId) -> bool {
        let nth = usize::from(node.get()).wrapping_sub(1);
        self.cob_ids.get(nth).is_some_and(|cob_id| cob_id & INVALID == 0)
    }

    /// Checks a `value` that a client writes at a node with the Node-ID `own`. Accepts every value for objects of other
    /// services.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for another COB-ID than that of the pre-defined connection set, and
    /// for the emergencies of the node itself.
    pub fn may_write(own: NodeId, at: Address, value: u32) -> Result<(), AbortCode> {
        let Some(node) = NodeId::new(at.sub).filter(|_| at.index == EmcyConsumers::COB_IDS.index()) else {
            return Ok(());
        };
        let is_invalid = value & INVALID != 0;
        let is_free = value & !INVALID == emergencies_of(node) && (is_invalid || node != own);
        if is_free || value == INVALID { Ok(()) } else { Err(AbortCode::ValueRange) }
    }
}

fn emergencies_of(node: NodeId) -> u32 {
    u32::from(CobId::emcy(node).raw())
}
