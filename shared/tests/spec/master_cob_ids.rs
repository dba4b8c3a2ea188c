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
/// Verifies: ECSS 6.10l, 6.10m
/// Notices: ECSS 6.10l: a slave that sends a command PDO of the master is started.
#[test]
fn the_boot_process_compares_with_the_pdos_of_the_master() {
    assert_cob_id_in_use(Address::new(0x1800, 1), 0x4000_0302);
}

/// Over the bus: slave 2 reports its errors with 081h, as the master does.
///
/// Verifies: ECSS 6.10l, 6.10m
/// Notices: ECSS 6.10l: a slave may take the COB-ID of the EMCY of the master.
/// Notices: ECSS 6.10m: a slave whose emergencies have the COB-ID of those of the master is started.
#[test]
fn the_boot_process_compares_with_the_emergencies_of_the_master() {
    assert_cob_id_in_use(Address::new(0x1014, 0), 0x0000_0081);
}

/// Asserts that slave 2 is not started whose entry at `at` has a COB-ID of the master.
fn assert_cob_id_in_use(at: Address, entry: u32) {
    const TWO: NodeId = NodeId::of::<2>();
    const PROFILE: Profile =
        Profile { slaves: &[AssignedSlave { node: TWO, mandatory: false, expected: ANY }], ..STANDARD };
    let mut master: Bench<Master> = Bench::new(console::master(&PROFILE));
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
        let is_it = Address::new(u16::from_le_bytes([low, high]), sub) == at;
        let [a, b, c, d] = if is_it { entry } else { 0x8000_0000 }.to_le_bytes();
        master.receive(NOMINAL, 0x582, &[0x43, low, high, sub, a, b, c, d]);
    }
    let id = CobId::new(entry as u16).unwrap();
    let cause = BootCause::CobIdInUse { at, id, other: NodeId::MASTER };
    let failure = BootFailure { error: BootError::Configuration, cause };
    assert!(master.events.contains(&MasterEvent::BootFailed { node: TWO, failure }), "{:?}", master.events);
}
