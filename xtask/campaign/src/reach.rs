//! What the faults that stay leave of the network.

use ecss_can::types::Bus;

use crate::kind::Kind;
use crate::script::{Fault, Script};

/// Distance between neighbours, metres: node n sits at n times this.
const SPACING: u32 = 2;
/// Babble with a higher priority than this leaves no room for the network.
const URGENT: u32 = 0x100;

/// Slaves with power at the end.
pub fn alive(script: &Script) -> Vec<u8> {
    let is_off = |node| staying(script).any(|fault| fault.kind == Kind::PowerSlave && fault.node == node);
    (2..=script.slaves + 1).filter(|&node| !is_off(node)).collect()
}

/// Slaves with power that a bus joins to the master at the end.
pub fn reached(script: &Script, bus: Bus) -> Vec<u8> {
    let here: Vec<Fault> =
        staying(script).filter(|fault| fault.bus == bus && !fault.kind.is_of_node()).collect();
    if !takes_part(&here, 1) {
        return Vec::new();
    }
    let joined = |node: u8| takes_part(&here, node) && is_same_piece(&here, 1, node);
    if here.iter().any(|fault| blocks(fault).is_some_and(|place| is_same_place(&here, SPACING, place))) {
        return Vec::new();
    }
    alive(script).into_iter().filter(|&node| joined(node)).collect()
}

/// Faults of the end of a run.
fn staying(script: &Script) -> impl Iterator<Item = Fault> {
    script.faults.iter().copied().filter(|fault| fault.kind.lasts() && fault.lasts.is_none())
}

/// Whether the stub and the driver of a node work.
fn takes_part(here: &[Fault], node: u8) -> bool {
    let hinders = |fault: &&Fault| {
        matches!(fault.kind, Kind::Disconnect | Kind::Stuck | Kind::Babble | Kind::Drift)
            && fault.node == node
    };
    !here.iter().any(|fault| hinders(&fault))
}

/// Where a fault makes a piece of cable useless.
fn blocks(fault: &Fault) -> Option<u32> {
    match fault.kind {
        Kind::Short | Kind::Dominant => Some(fault.place),
        Kind::Stuck => Some(u32::from(fault.node) * SPACING),
        Kind::Babble if fault.value < URGENT => Some(u32::from(fault.node) * SPACING),
        _ => None,
    }
}

fn is_same_piece(here: &[Fault], one: u8, other: u8) -> bool {
    is_same_place(here, u32::from(one) * SPACING, u32::from(other) * SPACING)
}

/// Whether no cut lies between two places. What is at a cut belongs to the right piece.
fn is_same_place(here: &[Fault], one: u32, other: u32) -> bool {
    let (left, right) = (one.min(other), one.max(other));
    !here.iter().any(|fault| fault.kind == Kind::Cut && (left + 1..=right).contains(&fault.place))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(faults: &str) -> [Vec<u8>; 2] {
        let script: Script = format!("run slaves=3\n{faults}").parse().unwrap();
        Bus::ALL.map(|bus| reached(&script, bus))
    }

    #[test]
    fn what_stays_decides_and_what_ends_does_not() {
        let all = vec![2, 3, 4];
        assert_eq!(left("cut at=1 lasts=9 place=5"), [all.clone(), all.clone()]);
        // Master at 2 m and slave 2 at 4 m on one side.
        assert_eq!(left("cut at=1 place=5"), [vec![2], all.clone()]);
        assert_eq!(left("short at=1 bus=redundant place=6"), [all.clone(), vec![]]);
        assert_eq!(left("cut at=1 place=3\nshort at=1 place=6"), [vec![], all.clone()]);
        assert_eq!(left("cut at=1 place=7\nshort at=1 place=8"), [vec![2, 3], all.clone()]);
        assert_eq!(
            left("disconnect at=1 node=3\ndisconnect at=1 bus=redundant node=1"),
            [vec![2, 4], vec![]]
        );
        assert_eq!(left("stuck at=1 node=3"), [vec![], all.clone()]);
        assert_eq!(left("babble at=1 node=3 value=16"), [vec![], all.clone()]);
        assert_eq!(left("babble at=1 node=3 value=2032"), [vec![2, 4], all.clone()]);
        assert_eq!(left("power-slave at=1 node=2"), [vec![3, 4], vec![3, 4]]);
        assert_eq!(left("noise at=1 value=4"), [all.clone(), all]);
    }
}
