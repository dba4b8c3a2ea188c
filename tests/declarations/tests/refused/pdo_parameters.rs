//! Numbers, transmission types and COB-IDs that no PDO may have.

use ecss_can::pdo::{CobIdOf, Pdo, Rpdo, Tpdo};

const ID: CobIdOf = CobIdOf::node(0x280);

const ZERO: Rpdo = Pdo::<()>::new(ID).receive(0);
const BEYOND: Tpdo = Pdo::<()>::new(ID).transmit(513);
const RESERVED: Rpdo = Pdo::<()>::new(ID).receive(1).transmission(241);
const REMOTE: Tpdo = Pdo::<()>::new(ID).transmit(1).transmission(252);
const START: Tpdo = Pdo::<()>::new(ID).transmit(1).transmission(1).sync_start(241);
const SYNC: CobIdOf = CobIdOf::fixed(0x080);
const NMT: CobIdOf = CobIdOf::fixed(0x000);
const EXTENDED: CobIdOf = CobIdOf::fixed(0x800);
const SDO: CobIdOf = CobIdOf::node(0x580);
const HEARTBEAT: CobIdOf = CobIdOf::node(0x700);
const PARTLY: CobIdOf = CobIdOf::node(0x680);
const EMCY: Tpdo = Pdo::<()>::new(CobIdOf::node(0x080)).transmit(1);
const EMCY_OF_ONE: Tpdo = Pdo::<()>::new(CobIdOf::fixed(0x085)).transmit(1);

fn main() {}
