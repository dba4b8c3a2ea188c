//! COB-IDs in the boot-up process of a master: no slave may send one of its own (ECSS 6.10l).

use ecss_can::boot::{AssignedSlave, BootCause, BootError, BootFailure, Expected};
use ecss_can::node::MasterEvent;
use ecss_can::profile::Profile;
use ecss_can::types::{Address, CobId, NodeId};

use crate::bench::{Bench, Master, NOMINAL, ms};
use crate::console;
use crate::instrument::STANDARD;

/// Nothing is expected of a slave.
const ANY: Expected = Expected { device_type: 0, identity: [0; 4], stamp: [0; 2] };

/// Over the bus: slave 2 sends 302h, the first command PDO of this master.
///
/// Verifies: ECSS 6.10l
#[test]
fn the_boot_process_compares_with_the_pdos_of_the_master() {
    const TWO: NodeId = NodeId::of::<2>();
    const PROFILE: Profile =
        Profile { slaves: &[AssignedSlave { node: TWO, mandatory: false, expected: ANY }], ..STANDARD };
    let mut master: Bench<Master> = Bench::new(console::master(&PROFILE, None));
    master.run_until(ms(1));
    master.receive(NOMINAL, 0x702, &[0x00]);
    let mut count = 0;
    while count < master.sent.len() {
        let frame = master.sent[count].frame;
        count += 1;
        let [0x40, low, high, sub, ..] = frame.padded() else { continue };
        if frame.id().raw() != 0x602 {
            continue;
        }
        let answer = match u16::from_le_bytes([low, high]) {
            0x1800 => [0x43, low, high, sub, 0x02, 0x03, 0, 0x40],
            _ => [0x43, low, high, sub, 0, 0, 0, 0x80],
        };
        master.receive(NOMINAL, 0x582, &answer);
    }
    let cause = BootCause::CobIdInUse {
        at: Address::new(0x1800, 1),
        id: CobId::new(0x302).unwrap(),
        other: NodeId::MASTER,
    };
    let failure = BootFailure { error: BootError::Configuration, cause };
    assert!(master.events.contains(&MasterEvent::BootFailed { node: TWO, failure }), "{:?}", master.events);
}
