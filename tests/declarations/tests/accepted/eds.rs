//! Constants of a node of another maker, from its data sheet: `tests/eds/valve.eds`.
#![deny(warnings)]
#![deny(missing_docs)]

use ecss_can::od::{Domain, Field, NotReadable, NotWritable, Readable, VisibleString, Writable, eds};
use ecss_can::pdo::{CobIdOf, Pdo, PdoSet};
use ecss_can::types::{Address, NodeId};

eds! {
    /// Valve of another maker.
    #[derive(Clone, Copy, Debug)]
    pub struct Valve = "valve.eds";

    /// The same, for this file alone. Most of its constants are not used.
    struct Own = "valve.eds";
}

const OPENING: Field<u8> = Valve::WANTED_OPENING;
const POWER: Field<u8, Readable, NotWritable> = Valve::MOTOR_POWER;
const TEMPERATURE: Field<i16, Readable, NotWritable> = Valve::MOTOR_TEMPERATURE_0_1_C;
const CALIBRATE: Field<bool, NotReadable, Writable> = Valve::CALIBRATE;
const NAME: Field<VisibleString<255>, Readable, NotWritable> = Valve::MANUFACTURER_DEVICE_NAME;
const CURVE: Field<Domain<[u8; 0]>> = Valve::CURVE;
/// A data type of the maker.
const POSITION: Field = Valve::POSITION;

const VALVE: NodeId = NodeId::of::<9>();
const WANTED: Pdo<Valve, (u8,)> = Valve::RPDO_1;
const CHANGE: Pdo<Valve, (u8, i16)> = Valve::TPDO_1;
const PDOS: PdoSet = PdoSet::new(&[CHANGE.of(VALVE).receive(1)], &[]);
/// A PDO that the master configures at the node.
const FURTHER: Pdo<Valve, (i16,)> = Pdo::new(CobIdOf::node(0x280)).map(Valve::MOTOR_TEMPERATURE_0_1_C);

fn main() {
    assert_eq!(OPENING.address(), Address::new(0x6000, 0));
    assert_eq!(POWER.address(), Address::new(0x6001, 1));
    assert_eq!(TEMPERATURE.address(), Address::new(0x6001, 2));
    assert_eq!(CALIBRATE.address(), Address::new(0x6002, 0));
    assert_eq!(NAME.address(), Address::new(0x1008, 0));
    assert_eq!(CURVE.address(), Address::new(0x6003, 0));
    assert_eq!(POSITION.address(), Address::new(0x6004, 0));
    assert_eq!((WANTED.of(VALVE).bytes(), CHANGE.of(VALVE).bytes()), (1, 3));
    assert_eq!((WANTED.cob_id(), CHANGE.cob_id()), (CobIdOf::node(0x200), CobIdOf::node(0x180)));
    assert_eq!(PDOS.rpdos().len(), 1);
    assert_eq!(FURTHER.of(VALVE).bytes(), 2);
    assert_eq!(Own::CALIBRATE.address(), Valve::CALIBRATE.address());
}
