//! Parts of the network that remain connected under faults.

use can_twin::wire::time::Time;
use ecss_can::link::access::BusAccess;
use ecss_can::types::{Bus, PerBus};
use ecss_can_worlds::judge::{MASTERS, Master, Slave, View};

use crate::campaign::kind::Kind;
use crate::campaign::script::{Fault, SECOND_BOARD, SELECTIVE, Script};

/// Babble with a lower COB-ID than this blocks the network.
const URGENT: u32 = 0x100;
/// Longest wait of a fault for its frame, and longest after-effect in controllers.
const UNSURE_US: u64 = 300_000;
/// Duration of a frame of a foreign node that sends back to back, including the delay of others, in microseconds.
const FOREIGN_FRAME_US: u64 = 300;

/// Returns the slaves at the end, with the buses that join them to the first master board and to the second one.
pub fn slaves(script: &Script) -> Vec<Slave> {
    slaves_with(script, &PerBus::from_fn(|bus| staying_on(script, bus)))
}

/// Returns whether at some time no bus reached all reachable slaves of a master board.
pub fn was_split(script: &Script, master: usize) -> bool {
    script.faults.iter().any(|fault| {
        let slaves = slaves_with(script, &PerBus::from_fn(|bus| lasting_on(script, bus, fault.at)));
        let masters = [Master { is_powered: true, ..Master::default() }; MASTERS];
        View { masters: &masters, slaves: &slaves, joins_masters: PerBus::default() }.is_split(master)
    })
}

/// Returns the slaves with these faults on the buses, without observed state.
fn slaves_with(script: &Script, here: &PerBus<Vec<Fault>>) -> Vec<Slave> {
    let is_off = |node| staying(script).any(|fault| fault.kind == Kind::PowerSlave && fault.node == node);
    let is_selective = |node| script.selective && node == SELECTIVE.get();
    let wired = |master, node| PerBus::from_fn(|bus| is_joined(script, &here[bus], master, node));
    let slave = |node| Slave {
        is_powered: !is_off(node),
        access: if is_selective(node) { BusAccess::Selective } else { BusAccess::Parallel },
        wired: [1, SECOND_BOARD].map(|master| wired(master, node)),
        ..Slave::default()
    };
    (2..=script.slaves + 1).map(slave).collect()
}

/// Returns whether a bus joins both master boards at the end.
pub fn joins_masters(script: &Script, bus: Bus) -> bool {
    is_joined(script, &staying_on(script, bus), 1, SECOND_BOARD)
}

/// Returns whether a bus certainly joins both master boards at an instant.
pub fn surely_joins_masters(script: &Script, bus: Bus, at: Time) -> bool {
    let at = at.as_us();
    let begun = |fault: &&Fault| {
        let is_over = fault.end().is_some_and(|end| end + load_us(fault) + UNSURE_US <= at);
        fault.bus == bus && !fault.kind.is_of_node() && fault.at <= at && !is_over
    };
    let begun: Vec<Fault> = script.faults.iter().filter(begun).copied().collect();
    let is_clear = |fault: &Fault| match fault.kind {
        Kind::ForeignNmt | Kind::ForeignMaster | Kind::UnknownNode | Kind::Clash | Kind::Flip => true,
        Kind::Noise => false,
        kind => kind.lasts() && fault.lasts.is_none() && fault.at + UNSURE_US <= at,
    };
    begun.iter().all(is_clear) && is_joined(script, &begun, 1, SECOND_BOARD)
}

/// Returns the instants at which the result of [`surely_joins_masters`] may change.
pub fn changes(script: &Script) -> impl Iterator<Item = Time> {
    let of = |fault: &Fault| {
        let sure = fault.end().unwrap_or(fault.at) + load_us(fault) + UNSURE_US;
        [fault.at, sure].map(Time::from_us)
    };
    script.faults.iter().flat_map(of)
}

/// Returns the duration of back-to-back frames of a foreign node, in microseconds.
fn load_us(fault: &Fault) -> u64 {
    if fault.kind == Kind::ForeignLoad { u64::from(fault.times) * FOREIGN_FRAME_US } else { 0 }
}

/// Returns the faults that last to the end of a run.
fn staying(script: &Script) -> impl Iterator<Item = Fault> {
    script.faults.iter().copied().filter(|fault| fault.kind.lasts() && fault.lasts.is_none())
}

/// Returns the faults of a bus at an instant, in microseconds.
fn lasting_on(script: &Script, bus: Bus, at: u64) -> Vec<Fault> {
    let is_there = |fault: &&Fault| {
        let is_over = fault.end().is_some_and(|end| end <= at);
        fault.bus == bus && fault.kind.lasts() && !fault.kind.is_of_node() && fault.at <= at && !is_over
    };
    script.faults.iter().filter(is_there).copied().collect()
}

/// Returns the faults of a bus that last to the end.
fn staying_on(script: &Script, bus: Bus) -> Vec<Fault> {
    staying(script).filter(|fault| fault.bus == bus && !fault.kind.is_of_node()).collect()
}

/// Returns whether a bus with these faults joins two nodes.
fn is_joined(script: &Script, here: &[Fault], one: u8, other: u8) -> bool {
    let (left, right) = (script.place(one), script.place(other));
    let is_blocked =
        here.iter().any(|fault| blocks(script, fault).is_some_and(|place| is_same_place(here, left, place)));
    takes_part(here, one) && takes_part(here, other) && is_same_place(here, left, right) && !is_blocked
}

/// Returns whether the stub and the driver of a node work.
fn takes_part(here: &[Fault], node: u8) -> bool {
    let hinders = |fault: &&Fault| {
        matches!(fault.kind, Kind::Disconnect | Kind::Stuck | Kind::Babble | Kind::Drift)
            && fault.node == node
    };
    !here.iter().any(|fault| hinders(&fault))
}

/// Returns the position of a fault that blocks its piece of cable.
fn blocks(script: &Script, fault: &Fault) -> Option<u32> {
    match fault.kind {
        Kind::Short | Kind::Dominant => Some(fault.place),
        Kind::Stuck => Some(script.place(fault.node)),
        Kind::Babble if fault.value < URGENT => Some(script.place(fault.node)),
        _ => None,
    }
}

/// Returns whether there is no cut between two positions. A position at a cut belongs to the right piece.
fn is_same_place(here: &[Fault], one: u32, other: u32) -> bool {
    let (left, right) = (one.min(other), one.max(other));
    !here.iter().any(|fault| fault.kind == Kind::Cut && (left + 1..=right).contains(&fault.place))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the slaves with power that a bus joins to a master board.
    fn reached(script: &Script, master: usize, bus: Bus) -> Vec<u8> {
        let slaves = slaves(script).into_iter().zip(2..);
        slaves
            .filter(|(slave, _)| slave.is_powered && slave.wired[master][bus])
            .map(|(_, node)| node)
            .collect()
    }

    fn left(faults: &str) -> [Vec<u8>; 2] {
        let script: Script = format!("run slaves=3\n{faults}").parse().unwrap();
        Bus::ALL.map(|bus| reached(&script, 0, bus))
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

    #[test]
    fn a_split_is_when_faults_of_both_buses_meet() {
        let was = |faults: &str| {
            let script: Script = format!("run slaves=3\n{faults}").parse().unwrap();
            was_split(&script, 0)
        };
        assert!(!was("cut at=1 place=5"));
        assert!(was("cut at=1 place=5\ndisconnect at=9 lasts=5 bus=redundant node=2"));
        assert!(!was("cut at=1 lasts=8 place=5\ndisconnect at=9 bus=redundant node=2"));
        assert!(!was("cut at=1 place=5\nreset-slave at=9 node=3"));
        // Slave 3 is on no bus, and the redundant bus, or each bus, reaches all others.
        assert!(!was("cut at=1 place=5\ndisconnect at=9 lasts=5 bus=redundant node=3"));
        assert!(!was("disconnect at=1 node=3\ndisconnect at=9 bus=redundant node=3"));
    }

    /// Master at 2 m, slaves 2 to 4 at 4 to 8 m, second master at 10 m.
    #[test]
    fn second_master_is_at_the_other_end() {
        let pair = |faults: &str| -> Script { format!("run masters=2 slaves=3\n{faults}").parse().unwrap() };
        let script = pair("cut at=9 place=5");
        assert_eq!([0, 1].map(|master| reached(&script, master, Bus::Nominal)), [vec![2], vec![3, 4]]);
        assert_eq!(Bus::ALL.map(|bus| joins_masters(&script, bus)), [false, true]);
        let script = pair("disconnect at=9 node=128");
        assert_eq!([0, 1].map(|master| reached(&script, master, Bus::Nominal)), [vec![2, 3, 4], vec![]]);
        assert!(!joins_masters(&pair("short at=9 place=10"), Bus::Nominal));
        assert!(joins_masters(&pair("disconnect at=9 node=3\ncut at=9 lasts=9 place=5"), Bus::Nominal));
    }

    #[test]
    fn masters_are_joined_beyond_doubt_where_no_fault_is_near() {
        let sure = |faults: &str, at_ms| {
            let script: Script = format!("run masters=2 slaves=3\n{faults}").parse().unwrap();
            surely_joins_masters(&script, Bus::Nominal, Time::from_ms(at_ms))
        };
        let cut = "cut at=1000000 lasts=1000000 place=5";
        assert_eq!([999, 1_000, 2_299, 2_300].map(|at| sure(cut, at)), [true, false, false, true]);
        assert_eq!([999, 1_000, 9_000].map(|at| sure("cut at=1000000 place=5", at)), [true, false, false]);
        let stub = "disconnect at=1000000 node=3";
        assert_eq!([999, 1_000, 1_300].map(|at| sure(stub, at)), [true, false, true]);
        assert!(!sure("noise at=1000000 value=5", 9_000) && sure("flip at=1000000 value=5", 1_001));
        // 1000 frames.
        let load = "foreign-load at=1000000 value=5 times=1000";
        assert_eq!([1_599, 1_600].map(|at| sure(load, at)), [false, true]);
    }
}
