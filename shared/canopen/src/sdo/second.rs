//! Object 1201h: a second SDO channel of the server, and the rules for writing it (CiA 301 7.5.2.34).

use core::fmt::Debug;

use super::{SdoServerObjects, SdoServers};
use crate::od::{CobIdEntry, EntryUse, INVALID, Objects, Record};
use crate::types::{AbortCode, Address, NodeId};

/// Parameters of an SDO channel that clients configure (record 0022h). The channel is valid if both COB-IDs are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x22)]
pub struct SdoChannel {
    /// COB-ID client to server
    #[sub(1, rw, default = INVALID)]
    pub request: u32,
    /// COB-ID server to client
    #[sub(2, rw, default = INVALID)]
    pub response: u32,
    /// Node-ID of the SDO client
    ///
    /// 0: not known. The server does not use it.
    #[sub(3, rw, high = 127)]
    pub client: u8,
}

/// Two SDO servers: the default one, and one whose COB-IDs a client writes. At power-on the second one is not valid.
///
/// ```
/// use async_canopen::od::{INVALID, checked};
/// use async_canopen::sdo::{SdoServers, TwoSdoServers};
/// use async_canopen::types::{AbortCode, Address, NodeId};
///
/// let mut servers = TwoSdoServers::at_power_on(NodeId::of::<5>());
/// assert_eq!(servers.cob_ids(), Some([INVALID; 2]));
///
/// let request = Address::new(0x1201, 1);
/// assert_eq!(servers.may_write(request, 0x6C5), Ok(()));
/// checked::write(&mut servers, request, &0x6C5_u32.to_le_bytes()).unwrap();
/// assert_eq!(servers.may_write(request, 0x6C6), Err(AbortCode::ValueRange)); // it is valid: switch it off first
/// ```
#[doc(alias("1201h", "SSDO", "SDO server parameter"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct TwoSdoServers {
    /// Default server
    #[objects]
    pub default: SdoServerObjects,
    /// SDO server parameter 2
    #[object(0x1201, record)]
    pub second: SdoChannel,
}

const SECOND: u16 = TwoSdoServers::SECOND.index();
const REQUEST: Address = TwoSdoServers::SECOND.field(SdoChannel::REQUEST).address();
const RESPONSE: Address = TwoSdoServers::SECOND.field(SdoChannel::RESPONSE).address();

impl SdoServers for TwoSdoServers {
    const SECOND_SERVER: Option<u16> = Some(SECOND);

    type Second<T: Debug> = [T; 1];

    fn second<T: Debug>(mut make: impl FnMut() -> T) -> [T; 1] {
        [make()]
    }

    fn at_power_on(id: NodeId) -> Self {
        TwoSdoServers { default: SdoServerObjects::of(id), second: SdoChannel::default() }
    }

    fn cob_ids(&self) -> Option<[u32; 2]> {
        Some([self.second.request, self.second.response])
    }

    fn cob_ids_mut(&mut self) -> Option<[&mut u32; 2]> {
        Some([&mut self.second.request, &mut self.second.response])
    }

    /// As [`CobIdEntry::written`]. [`AbortCode::ParameterIncompatible`] if both directions would have one identifier.
    fn may_write(&self, at: Address, value: u32) -> Result<(), AbortCode> {
        let (own, other) = match at {
            REQUEST => (self.second.request, self.second.response),
            RESPONSE => (self.second.response, self.second.request),
            _ => return Ok(()),
        };
        let new = CobIdEntry::from_raw(own).written(value, EntryUse::Sdo)?.cob_id();
        if new.is_some() && new == CobIdEntry::from_raw(other).cob_id() {
            return Err(AbortCode::ParameterIncompatible);
        }
        Ok(())
    }
}
