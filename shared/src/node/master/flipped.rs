//! A running master whose memory has a flipped bit.

use super::declared::MasterServices;
use super::{Master, Turn};
use crate::boot::machine::Assignment;
use crate::node::extend::Outbox;
use crate::node::probe::Probe;
use crate::node::services::TimeServices;
use crate::profile::Profile;
use crate::types::{FineInstant, FineScet, Instant, NodeId};

const NOW: Instant = Instant::from_micros(3_000_000);
/// 1F81h, by Node-ID from 1 on: a mandatory slave, an optional one, one that is not booted, and no slave.
const ENTRIES: [u32; 4] = [0xD, 0x5, 0x1, 0];

/// A master with these slaves, after a first look for flipped bits.
fn master() -> Master<Probe> {
    let mut master = Master::builder(&Profile::DEFAULT, Probe::default()).build();
    master.services.network_mut().assignment[..ENTRIES.len()].copy_from_slice(&ENTRIES);
    master.take_assignments();
    scrub(&mut master);
    master
}

fn scrub(master: &mut Master<Probe>) {
    master.scrub(&Turn::new(NOW, &mut Outbox::new()));
}

/// Returns whether the parts of the master have the assignments that were written.
fn is_as_written(master: &Master<Probe>) -> bool {
    let entries = ENTRIES.into_iter().chain([0; 127]);
    entries.zip(1..=127).all(|(raw, node)| {
        let (node, assignment) = (NodeId::new(node).unwrap(), Assignment::from_raw(raw));
        master.services.network().assignment[usize::from(node.get()) - 1] == raw
            && master.boot.agrees(node, assignment)
            && master.redundancy.peers().agrees(node, assignment.is_slave())
            && master.redundancy.peers().counts(node) == assignment.is_slave()
    })
}

/// Given a master, when any bit of 1F81h flips, then the entry and what was taken from it are right after the next look.
#[test]
fn flipped_bit_of_an_assignment_is_corrected() {
    for bit in 0..32 * 127 {
        let mut master = master();
        assert!(is_as_written(&master));
        master.services.network_mut().assignment[bit / 32] ^= 1 << (bit % 32);
        assert!(!is_as_written(&master), "bit {bit}");
        scrub(&mut master);
        assert!(is_as_written(&master), "bit {bit}");
    }
}

/// Given a master, when the boot-up process or the redundancy has another assignment of a node than 1F81h, then it has that of 1F81h
/// after the next look.
#[test]
fn flipped_assignment_of_a_part_is_corrected() {
    for node in (1..=5).filter_map(NodeId::new) {
        for other in ENTRIES {
            let mut master = master();
            master.boot_mut().assign(node, Assignment::from_raw(other));
            master.redundancy_mut().peers_mut().assign(node, other == 0);
            scrub(&mut master);
            assert!(is_as_written(&master), "{node:?}: {other:#x}");
        }
    }
}

/// Given a master whose clock was set, when any bit of the instant at which it was set flips, then it shows the time that it showed
/// before after the next look.
#[test]
fn flipped_bit_of_the_clock_is_corrected() {
    let at = FineInstant::from(NOW);
    for bit in 0..64 {
        let mut master = master();
        master.services.time_mut().set(FineScet::from_units(7 << 32), at);
        scrub(&mut master);
        let before = master.services.time().clock().clone();
        let clock = master.services.time_mut().clock_mut();
        // By a present so early, it takes the start for one in the future, and moves it alone.
        clock.confine(FineInstant::from_units(at.units() ^ 1 << bit), FineInstant::from_units(0));
        scrub(&mut master);
        assert_eq!(*master.services.time().clock(), before, "bit {bit}");
    }
}
