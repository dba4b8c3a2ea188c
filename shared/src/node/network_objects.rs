//! Objects of a master for the management of its network.

use crate::boot::{BootProgress, Expected};
use crate::od::{INVALID, Objects, Record};
use crate::types::{AbortCode, Address, CobId, NodeId};

/// Slaves that an array has entries for: sub-index is Node-ID.
const NODES: usize = 127;

/// Objects for the management of the network: the boot-up process and its SDO client (CiA 302-2). The sub-index
/// of an entry is the Node-ID of the slave.
#[doc(alias("1280h", "1F80h", "1F81h", "1F82h", "request NMT"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct NetworkObjects {
    /// SDO client parameter
    ///
    /// SDO channel of the running transfer, or of the last one. Not valid (bit 31) before the first.
    #[object(0x1280, record)]
    pub sdo_client: SdoClientParameters,
    /// Expected configuration date
    ///
    /// 1020h of a slave that needs no configuration. Days since 1984-01-01; zero: it is configured at each boot.
    #[object(0x1F26, array, rw)]
    pub configuration_date: [u32; NODES],
    /// Expected configuration time
    ///
    /// Milliseconds since midnight.
    #[object(0x1F27, array, rw)]
    pub configuration_time: [u32; NODES],
    /// NMT slave assignment
    ///
    /// Bit 0: is a slave of this master. Bit 2: is checked, configured and started. Bit 3: SYNC waits for it.
    #[object(0x1F81, array, rw)]
    pub assignment: [u32; NODES],
    /// Request NMT
    ///
    /// Read: 0 unknown, 1 missing, 4 stopped, 5 operational, 127 pre-operational. Written: 4 stop, 5 start, 6 reset
    /// node, 7 reset communication, 127 enter pre-operational. Sub-index 128: all slaves.
    #[object(0x1F82, array, rw)]
    pub request_nmt: [u8; NODES + 1],
    /// Device type identification
    ///
    /// Zero: not checked.
    #[object(0x1F84, array, rw)]
    pub device_type: [u32; NODES],
    /// Vendor identification
    ///
    /// Zero: not checked.
    #[object(0x1F85, array, rw)]
    pub vendor: [u32; NODES],
    /// Product code
    ///
    /// Zero: not checked.
    #[object(0x1F86, array, rw)]
    pub product: [u32; NODES],
    /// Revision number
    ///
    /// Zero: not checked.
    #[object(0x1F87, array, rw)]
    pub revision: [u32; NODES],
    /// Serial number
    ///
    /// Zero: not checked.
    #[object(0x1F88, array, rw)]
    pub serial: [u32; NODES],
    /// Boot time
    ///
    /// Milliseconds from power-on; zero for no limit.
    #[object(0x1F89, ro)]
    pub boot_time: u32,
    /// Boot progress
    ///
    /// 0 unassigned, 1 awaited, 2 queued, 3 checking, 4 comparing, 5 configuring, 6 started, 7 booted, 8 failed.
    #[object(0x2040, array, ro)]
    pub boot_progress: [u8; NODES],
    /// Boot error
    ///
    /// The letter of CiA 302-2; zero for none.
    #[object(0x2041, array, ro)]
    pub boot_error: [u8; NODES],
    /// Boot abort code
    ///
    /// Abort code of the SDO transfer that failed; zero for none.
    #[object(0x2042, array, ro)]
    pub boot_abort: [u32; NODES],
    /// SYNC dither
    ///
    /// Microseconds: each SYNC is late by a random time up to this. Where SYNCs are exactly a second apart, 15
    /// makes the clocks of the slaves better.
    #[object(0x2043, rw, high = 1_000)]
    pub sync_dither: u16,
    /// Heartbeat of a slave
    ///
    /// With 2016h of that slave it measures the cable between both.
    #[object(0x2044, record)]
    pub ranging: Ranging,
    /// Role of this master board
    #[object(0x2045, record)]
    pub role: MasterRole,
}

/// Role of this board among two master boards (2045h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct MasterRole {
    /// Role
    ///
    /// 0 listening, 1 standby, 2 active.
    #[sub(1, ro, pdo, default = 2)]
    pub role: u8,
    /// Strap
    ///
    /// 0 prime, 1 second; 0 where there is one board.
    #[sub(2, ro, pdo)]
    pub strap: u8,
    /// Times that it became active
    ///
    /// Since power-on; 0 where there is one board.
    #[sub(3, ro, pdo)]
    pub taken: u8,
}

/// Instant at which the heartbeat of a slave was received (2044h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Ranging {
    /// Node-ID
    ///
    /// Whose heartbeats on the active bus are stamped; zero: of none.
    #[sub(1, rw, high = 127)]
    pub node: u8,
    /// Time
    ///
    /// Local SCET at the end of the last one, units of 2^-32 s; zero before the first.
    #[sub(2, ro)]
    pub heard: u64,
}

/// SDO parameters of a client (record 0022h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x22)]
pub struct SdoClientParameters {
    /// COB-ID client to server
    #[sub(1, ro, default = INVALID)]
    pub request: u32,
    /// COB-ID server to client
    #[sub(2, ro, default = INVALID)]
    pub response: u32,
    /// Node-ID of the server
    #[sub(3, ro)]
    pub node: u8,
}

/// Entry of a slave.
pub(super) fn entry<T>(array: &mut [T], node: NodeId) -> Option<&mut T> {
    array.get_mut(usize::from(node.get()).wrapping_sub(1))
}

const REQUEST_NMT: u16 = NetworkObjects::REQUEST_NMT.index();

impl NetworkObjects {
    /// Checks a `value` that a client writes. Accepts every value for objects of other services.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for a request that is none.
    pub(super) fn may_write(at: Address, value: u32) -> Result<(), AbortCode> {
        let is_none = at.index == REQUEST_NMT && !matches!(value, 4..=7 | 127);
        if is_none { Err(AbortCode::ValueRange) } else { Ok(()) }
    }

    /// Returns the identity that the master expects of a slave: 1F26h, 1F27h, 1F84h to 1F88h.
    pub(super) fn expected(&self, node: NodeId) -> Expected {
        let nth = usize::from(node.get()).wrapping_sub(1);
        let of = |array: &[u32; NODES]| array.get(nth).copied().unwrap_or(0);
        Expected {
            device_type: of(&self.device_type),
            identity: [of(&self.vendor), of(&self.product), of(&self.revision), of(&self.serial)],
            stamp: [of(&self.configuration_date), of(&self.configuration_time)],
        }
    }

    pub(super) fn expect(&mut self, node: NodeId, expected: &Expected) {
        let [vendor, product, revision, serial] = expected.identity;
        let [date, time] = expected.stamp;
        let all = [
            (&mut self.device_type, expected.device_type),
            (&mut self.vendor, vendor),
            (&mut self.product, product),
            (&mut self.revision, revision),
            (&mut self.serial, serial),
            (&mut self.configuration_date, date),
            (&mut self.configuration_time, time),
        ];
        for (array, value) in all {
            if let Some(entry) = entry(array, node) {
                *entry = value;
            }
        }
    }

    pub(super) fn show_client(&mut self, node: NodeId) {
        self.sdo_client = SdoClientParameters {
            request: u32::from(CobId::sdo_request(node).raw()),
            response: u32::from(CobId::sdo_response(node).raw()),
            node: node.get(),
        };
    }

    /// A slave that is past its error has none.
    pub(super) fn show_progress(&mut self, node: NodeId, progress: BootProgress) {
        if let Some(shown) = entry(&mut self.boot_progress, node) {
            *shown = progress as u8;
        }
        if progress == BootProgress::Started {
            self.show_error(node, 0, 0);
        }
    }

    pub(super) fn show_error(&mut self, node: NodeId, letter: u8, abort: u32) {
        if let (Some(error), Some(code)) =
            (entry(&mut self.boot_error, node), entry(&mut self.boot_abort, node))
        {
            (*error, *code) = (letter, abort);
        }
    }
}
