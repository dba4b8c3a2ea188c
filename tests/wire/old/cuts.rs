//! Cut and healed cables.

mod common;

use can_wire::controller::ErrorKind;
use can_wire::fault::Fault;
use can_wire::frame::WireFrame;
use can_wire::record::{Destruction, Record};
use can_wire::time::Time;
use common::*;
use proptest::prelude::*;

fn frame(id: u16) -> WireFrame {
    WireFrame::standard(id, &[])
}

/// Two nodes on the left (0 m, 1 m), two on the right (11 m, 12 m).
fn four(scripts: [Script; 4]) -> World {
    World::new([0.0, 1.0, 11.0, 12.0].into_iter().zip(scripts).collect())
}

fn kinds(script: &Script) -> Vec<Told> {
    script.errors().into_iter().map(|(_, told)| told).collect()
}

#[test]
fn each_piece_is_a_bus_of_its_own() {
    let mut world = four([
        Script::sending(us(5), frame(0x080)),
        Script::new(),
        Script::sending(us(5), frame(0x100)),
        Script::new(),
    ]);
    world.wire.cut(6.0);
    world.run(us(100), us(20));
    assert_eq!(world.node(1).got().iter().map(|got| got.1).collect::<Vec<_>>(), [frame(0x080)]);
    assert_eq!(world.node(3).got().iter().map(|got| got.1).collect::<Vec<_>>(), [frame(0x100)]);
    let pieces: Vec<(WireFrame, usize, Vec<usize>)> = world
        .wire
        .take_records()
        .into_iter()
        .filter_map(|record| match record {
            Record::Completed { trace, receivers, segment } => {
                Some((trace.frame, segment, receivers.into_iter().map(|(node, _)| node).collect()))
            }
            _ => None,
        })
        .collect();
    assert_eq!(pieces.len(), 2);
    assert!(pieces.contains(&(frame(0x080), 0, vec![1])));
    assert!(pieces.contains(&(frame(0x100), 1, vec![3])));
}

#[test]
fn a_cut_off_transmitter_gets_no_acknowledgement_until_the_cut_heals() {
    let mut world = four([Script::sending(us(5), frame(0x080)), Script::new(), Script::new(), Script::new()]);
    world.wire.cut(0.5);
    world.wire.schedule(us(1000), Fault::Restore { position_m: 0.5 });
    world.run(us(999), us(20));
    assert!(world.wire.counters().ack_errors > 10);
    assert_eq!(world.node(0).sent(), []);
    assert_eq!(world.wire.idle_since(1), Some(Time::ZERO));
    world.run(us(1200), us(20));
    assert_eq!(world.node(0).sent().len(), 1);
    assert_eq!(world.node(3).got().len(), 1);
}

#[test]
fn a_node_at_the_cut_belongs_to_the_right_piece() {
    let mut world = World::new(vec![(0.0, Script::sending(us(5), frame(0x080))), (6.0, Script::new())]);
    world.wire.cut(6.0);
    world.run(us(50), us(20));
    assert_eq!(kinds(world.node(0)), [Told::TxError(ErrorKind::Ack)]);
}

#[test]
fn a_cut_within_a_frame_leaves_it_to_its_own_side() {
    let mut world = four([Script::sending(us(5), frame(0x080)), Script::new(), Script::new(), Script::new()]);
    world.wire.schedule(us(20), Fault::Cut { position_m: 6.0 });
    world.run(us(200), us(20));
    assert_eq!(world.node(0).sent(), [(us(53), frame(0x080))]);
    assert_eq!(world.node(1).got().len(), 1);
    for node in [2, 3] {
        assert_eq!(world.node(node).got(), []);
        assert_eq!(world.node(node).errors(), [(us(26), Told::RxError(ErrorKind::Stuff))]);
    }
    // The error flag of the far side ends 12 bits after the cut.
    assert_eq!(world.wire.idle_since(3), Some(us(32)));
    assert_eq!(world.wire.idle_since(0), Some(us(45)));
    assert!(
        world
            .wire
            .take_records()
            .contains(&Record::Fault { at: us(20), fault: Fault::Cut { position_m: 6.0 } })
    );
}

#[test]
fn a_cut_within_a_frame_may_take_its_only_acknowledger() {
    let mut world = World::new(vec![(0.0, Script::sending(us(5), frame(0x080))), (10.0, Script::new())]);
    world.wire.schedule(us(20), Fault::Cut { position_m: 5.0 });
    world.run(us(50), us(20));
    assert_eq!(world.node(0).errors(), [(us(45), Told::TxError(ErrorKind::Ack))]);
    assert_eq!(world.node(1).errors(), [(us(26), Told::RxError(ErrorKind::Stuff))]);
}

#[test]
fn a_cut_after_the_acknowledgement_harms_nobody_nor_does_its_healing() {
    let mut world = four([Script::new(), Script::new(), Script::new(), Script::sending(us(5), frame(0x080))]);
    world.wire.schedule(us(48), Fault::Cut { position_m: 6.0 });
    world.wire.schedule(us(50), Fault::RestoreAll);
    world.run(us(200), us(20));
    assert_eq!(world.node(3).sent().len(), 1);
    for node in [0, 1, 2] {
        assert_eq!((world.node(node).got().len(), kinds(world.node(node)).len()), (1, 0));
    }
}

#[test]
fn frames_on_both_sides_destroy_each_other_when_the_cut_heals() {
    let mut world = four([
        Script::sending(us(5), frame(0x080)),
        Script::new(),
        Script::sending(us(10), frame(0x100)),
        Script::new(),
    ]);
    world.wire.cut(6.0);
    world.wire.schedule(us(30), Fault::RestoreAll);
    world.run(us(31), us(20));
    for (node, told) in [
        (0, Told::TxError(ErrorKind::BitRecessive)),
        (1, Told::RxError(ErrorKind::Stuff)),
        (2, Told::TxError(ErrorKind::BitRecessive)),
        (3, Told::RxError(ErrorKind::Stuff)),
    ] {
        assert_eq!(world.node(node).errors(), [(us(31), told)], "node {node}");
    }
    let merged = |record: &Record| matches!(record, Record::Destroyed { cause: Destruction::Merged, at, .. } if *at == us(30));
    assert_eq!(world.wire.take_records().iter().filter(|record| merged(record)).count(), 2);
    // Both try again together, and the lower identifier wins.
    world.run(us(300), us(20));
    let got: Vec<WireFrame> = world.node(3).got().into_iter().map(|(_, frame)| frame).collect();
    assert_eq!(got, [frame(0x080), frame(0x100)]);
}

#[test]
fn a_frame_on_one_side_goes_on_when_the_cut_heals() {
    let mut world = four([Script::sending(us(5), frame(0x080)), Script::new(), Script::new(), Script::new()]);
    world.wire.cut(6.0);
    world.wire.schedule(us(30), Fault::Restore { position_m: 6.0 });
    world.run(us(200), us(20));
    assert_eq!(world.node(0).sent().len(), 1);
    assert_eq!(world.node(1).got().len(), 1);
    assert_eq!(world.node(2).log, []);
}

#[test]
fn cutting_twice_and_healing_what_is_whole_change_nothing() {
    let mut world = four([Script::sending(us(5), frame(0x080)), Script::new(), Script::new(), Script::new()]);
    world.wire.cut(6.0);
    world.wire.cut(6.0);
    world.wire.restore(3.0);
    world.wire.restore(6.0);
    world.run(us(100), us(20));
    assert_eq!(world.node(3).got().len(), 1);
}

#[test]
fn an_arbitration_lost_after_the_cut_is_told_before_the_stuff_error() {
    // 111 1111 1110 and 111 1111 1111 differ in the last bit of the identifier, 14 bits (with stuffing) after SOF.
    let mut world = four([
        Script::sending(us(5), frame(0x7FE)),
        Script::new(),
        Script::sending(us(5), frame(0x7FF)),
        Script::new(),
    ]);
    world.wire.schedule(us(8), Fault::Cut { position_m: 6.0 });
    world.run(us(25), us(20));
    assert_eq!(
        world.node(2).log.iter().map(|(at, told)| (*at, told.clone())).collect::<Vec<_>>(),
        [(us(5), Told::Started), (us(8), Told::Lost), (us(14), Told::RxError(ErrorKind::Stuff))]
    );
}

proptest! {
    /// What happens on one side of a cut does not depend on the other side.
    #[test]
    fn pieces_do_not_know_of_each_other(
        left in proptest::collection::vec((0u64..100_000, 0u16..=0x7FF), 0..6),
        right in proptest::collection::vec((0u64..100_000, 0u16..=0x7FF), 0..6),
        cut in 1.5..10.5f64,
    ) {
        let queue = |requests: &[(u64, u16)]| {
            let mut script = Script::new();
            script.queue = requests.iter().map(|&(at, id)| (Time(at), frame(id))).collect();
            script.queue.sort_by_key(|&(at, _)| at);
            script
        };
        let run = |left: &[(u64, u16)], right: &[(u64, u16)]| {
            let mut world = four([queue(left), Script::new(), queue(right), Script::new()]);
            world.wire.cut(cut);
            world.run(us(1500), us(20));
            world.scripts.0.into_iter().map(|script| script.log).collect::<Vec<_>>()
        };
        let both = run(&left, &right);
        prop_assert_eq!(&both[..2], &run(&left, &[])[..2]);
        prop_assert_eq!(&both[2..], &run(&[], &right)[2..]);
    }

    /// However often the cable breaks and heals: once whole, everything arrives, and nothing is sent twice.
    #[test]
    fn a_healed_cable_delivers_everything(
        faults in proptest::collection::vec((0u64..400_000, 0u8..3, prop::sample::select(vec![0.5, 6.0, 11.5])), 0..12),
        requests in proptest::collection::vec(0u64..400_000, 4),
        quantum in prop::sample::select(vec![1u64, 5, 20]),
    ) {
        let scripts: Vec<Script> = requests
            .iter()
            .zip(1u16..)
            .map(|(&at, id)| Script::sending(Time(at), frame(0x100 * id)))
            .collect();
        let mut world = four(scripts.try_into().expect("four requests"));
        for &(at, kind, position_m) in &faults {
            let fault = match kind {
                0 | 1 => Fault::Cut { position_m },
                _ => Fault::Restore { position_m },
            };
            world.wire.schedule(Time(at), fault);
        }
        world.wire.schedule(Time(400_000), Fault::RestoreAll);
        world.run(us(3000), us(quantum));
        for node in 0..4 {
            prop_assert_eq!(world.node(node).sent().len(), 1);
        }
        prop_assert_eq!(world.wire.counters().completed, 4);
        prop_assert_eq!(world.wire.next_event(), None);
        let records = world.wire.take_records();
        let time = |record: &Record| match record {
            Record::Completed { trace, .. } => trace.end,
            Record::Destroyed { at, .. } | Record::Fault { at, .. } => *at,
        };
        prop_assert!(records.windows(2).all(|pair| time(&pair[0]) <= time(&pair[1])));
    }
}
