//! The PDOs of the spacecraft time, as a slave declares them.

use crate::pdo::{CobIdOf, Rpdo, Tpdo};
use crate::time::{LocalScet, ScetGet, ScetSet};
use crate::types::{CobId, NodeId};

/// Receive PDO 1 of a slave that follows the spacecraft time: 181h, TPDO 1 of the master, the time at the last SYNC (ECSS 7.2.3).
pub const SPACECRAFT_TIME: Rpdo = Rpdo::new(1, CobIdOf::fixed(CobId::tpdo(1, NodeId::MASTER).unwrap().raw()))
    .transmission(1)
    .map(LocalScet::SCET_SET.field(ScetSet::FINE))
    .map(LocalScet::SCET_SET.field(ScetSet::COARSE));

/// Transmit PDO 1 of a slave that sends its local time with every SYNC: 180h + node (ECSS 7.2.3).
pub const LOCAL_TIME: Tpdo = Tpdo::new(1, CobIdOf::node(0x180))
    .transmission(1)
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE));
