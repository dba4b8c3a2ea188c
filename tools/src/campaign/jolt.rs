//! Table of scripts in which one cause affects a slave twice: its bus breaks, and it is reset.
//!
//! A jolt of a connector interrupts the stub of a bus and the power of the same slave, or a short circuit resets a
//! slave that drives the bus. The two faults occur in either order, at any distance up to ten seconds.

use ecss_can::types::Bus;

use crate::campaign::kind::Kind;
use crate::campaign::script::{Fault, Script};

/// The slave, the one that has selective access in half of the scripts.
const SLAVE: u8 = 4;
/// Instant at which the bus breaks, microseconds. Every slave has answered the master by then.
const BREAKS_AT: u64 = 18_000_000;
/// Distances of the two faults, milliseconds.
const DISTANCES: [u64; 13] = [0, 50, 100, 200, 300, 500, 700, 1_000, 1_500, 2_000, 3_000, 5_000, 10_000];
/// Kind that breaks the bus, kind that resets the slave, and its duration in microseconds.
const CAUSES: [(Kind, Kind, Option<u64>); 4] = [
    (Kind::Disconnect, Kind::ResetSlave, None),
    (Kind::Disconnect, Kind::PowerSlave, Some(300_000)),
    (Kind::Disconnect, Kind::PowerSlave, Some(4_000_000)),
    (Kind::Short, Kind::ResetSlave, None),
];

/// Returns each cause at each distance, in either order, with and without assigned slaves, with parallel and selective
/// access, with one master and two.
pub fn table() -> Vec<Script> {
    let mut scripts = Vec::new();
    for (breaks, strikes, lasts) in CAUSES {
        for distance in DISTANCES.map(|ms| ms * 1_000) {
            let later = [BREAKS_AT + distance, BREAKS_AT - distance];
            for at in &later[..if distance == 0 { 1 } else { 2 }] {
                let strike = Fault { at: *at, lasts, ..fault(strikes) };
                let faults = if *at < BREAKS_AT { [strike, fault(breaks)] } else { [fault(breaks), strike] };
                scripts.extend((0..8).map(|variant| script(faults, variant)));
            }
        }
    }
    scripts
}

/// Makes a script. `variant`: 0 to 7, a bit for each property.
fn script(faults: [Fault; 2], variant: u8) -> Script {
    let mut script = Script {
        seed: 1,
        masters: 1,
        slaves: 3,
        selective: variant & 1 != 0,
        assigned: variant & 2 != 0,
        length: 0,
        faults: faults.to_vec(),
    };
    script.masters += u8::from(variant & 4 != 0);
    script.length = script.shortest_length();
    script
}

fn fault(kind: Kind) -> Fault {
    Fault {
        at: BREAKS_AT,
        lasts: None,
        kind,
        bus: Bus::Nominal,
        node: if kind == Kind::Short { 0 } else { SLAVE },
        place: if kind == Kind::Short { 2 * u32::from(SLAVE) } else { 0 },
        value: 0,
        times: 0,
        every: 0,
        in_frame: false,
    }
}
