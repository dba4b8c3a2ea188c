//! Object 1200h: the SDO channel of the server.

use crate::od::{Objects, Record};
use crate::types::{CobId, NodeId};

/// SDO parameters (record 0022h).
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

/// Default SDO channel of the server (1200h).
#[doc(alias("1200h", "SSDO", "SDO server parameter"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct SdoServerObjects {
    /// SDO server parameter
    #[object(0x1200, record)]
    pub sdo_server: SdoParameters,
}

impl SdoServerObjects {
    /// Returns the channel of a node.
    pub fn of(id: NodeId) -> Self {
        let request = u32::from(CobId::sdo_request(id).raw());
        let response = u32::from(CobId::sdo_response(id).raw());
        SdoServerObjects { sdo_server: SdoParameters { request, response } }
    }
}
