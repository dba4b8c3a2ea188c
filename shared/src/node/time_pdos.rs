//! The PDOs of the spacecraft time, as a slave and a master declare them.

use crate::od::U24;
use crate::pdo::{CobIdOf, Pdo, Rpdo, Tpdo};
use crate::time::{LocalScet, ScetGet, ScetSet};
use crate::types::{CobId, NodeId};

/// Receive PDO 1 of a slave that follows the spacecraft time: 181h, TPDO 1 of the master, the time at the last SYNC (ECSS 7.2.3).
pub const SPACECRAFT_TIME: Rpdo = Pdo::<()>::new(SPACECRAFT_TIME_ID)
    .map(LocalScet::SCET_SET.field(ScetSet::FINE))
    .map(LocalScet::SCET_SET.field(ScetSet::COARSE))
    .receive(1)
    .transmission(1);

/// Transmit PDO 1 of a master that distributes the spacecraft time: 181h, the time at the last SYNC (ECSS 7.2.3). Its period is
/// [`Profile::time`](crate::profile::Profile::time). Slaves receive it as [`SPACECRAFT_TIME`].
pub const MASTER_TIME: Tpdo = Pdo::<()>::new(SPACECRAFT_TIME_ID)
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
    .transmit(1)
    .transmission(1);

const SPACECRAFT_TIME_ID: CobIdOf = CobIdOf::fixed(CobId::tpdo(1, NodeId::MASTER).unwrap().raw());

/// Transmit PDO 1 of a slave that sends its local time with every SYNC (ECSS 7.2.3).
pub const LOCAL_TIME: Tpdo = LOCAL_TIME_PDO.transmit(1).transmission(1);

/// Local time of a slave, fine time and coarse time: 180h + node. A master receives it as `LOCAL_TIME_PDO.of(node)`.
pub const LOCAL_TIME_PDO: Pdo<(), (U24, u32)> = Pdo::new(CobIdOf::node(0x180))
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE));
