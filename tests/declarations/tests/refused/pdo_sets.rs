//! PDOs that do not go together.

use ecss_can::emcy::EmcyObjects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoSet, Rpdo, Tpdo};

const fn receive(number: u16) -> Rpdo {
    Pdo::<()>::new(CobIdOf::node(0x200)).skip::<u8>().receive(number)
}

const fn transmit(number: u16, cob_id: CobIdOf) -> Tpdo {
    Pdo::<()>::new(cob_id).map(EmcyObjects::REGISTER).transmit(number)
}

const EMPTY: PdoSet = PdoSet::new(&[Pdo::<()>::new(CobIdOf::node(0x200)).receive(1)], &[]);
const TWICE: PdoSet = PdoSet::new(&[receive(1), receive(2), receive(1)], &[]);
const ONE_BASE: PdoSet =
    PdoSet::new(&[], &[transmit(1, CobIdOf::node(0x180)), transmit(2, CobIdOf::node(0x180))]);
const ONE_OF_A_NODE: PdoSet =
    PdoSet::new(&[], &[transmit(1, CobIdOf::node(0x180)), transmit(2, CobIdOf::fixed(0x185))]);

fn main() {}
