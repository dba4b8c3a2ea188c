//! Numbers, transmission types and COB-IDs that no PDO may have.

use ecss_can::pdo::{CobIdOf, Rpdo, Tpdo};

const ID: CobIdOf = CobIdOf::node(0x280);

const ZERO: Rpdo = Rpdo::new(0, ID);
const BEYOND: Tpdo = Tpdo::new(513, ID);
const RESERVED: Rpdo = Rpdo::new(1, ID).transmission(241);
const REMOTE: Tpdo = Tpdo::new(1, ID).transmission(252);
const START: Tpdo = Tpdo::new(1, ID).transmission(1).sync_start(241);
const SYNC: CobIdOf = CobIdOf::fixed(0x080);
const NMT: CobIdOf = CobIdOf::fixed(0x000);
const EXTENDED: CobIdOf = CobIdOf::fixed(0x800);
const SDO: CobIdOf = CobIdOf::node(0x580);
const HEARTBEAT: CobIdOf = CobIdOf::node(0x700);
const PARTLY: CobIdOf = CobIdOf::node(0x680);
const EMCY: Tpdo = Tpdo::new(1, CobIdOf::node(0x080));
const EMCY_OF_ONE: Tpdo = Tpdo::new(1, CobIdOf::fixed(0x085));

fn main() {}
