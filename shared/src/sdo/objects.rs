//! Object 1200h.

use crate::od::{Objects, Record};
use crate::types::{CobId, NodeId};

/// SDO parameters (0022h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x22)]
pub struct SdoParameters {
    /// COB-ID client to server
    #[sub(1, ro)]
    pub request: u32,
    /// COB-ID server to client
    #[sub(2, ro)]
    pub response: u32,
}

/// The default SDO channel of a server.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct SdoServerObjects {
    /// SDO server parameter
    #[object(0x1200, record)]
    pub sdo_server: SdoParameters,
}

impl SdoServerObjects {
    /// The channel of a node.
    pub fn of(id: NodeId) -> Self {
        let request = u32::from(CobId::sdo_request(id).raw());
        let response = u32::from(CobId::sdo_response(id).raw());
        SdoServerObjects { sdo_server: SdoParameters { request, response } }
    }
}
