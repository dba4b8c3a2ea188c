use can_twin::wire::frame::WireFrame;

use super::*;
use crate::fly::flight::Flight;
use crate::fly::record::{CutPlan, Nodes, SECOND_MASTER};
use crate::fly::sample;

const START_ALL: (u16, &[u8]) = (0x000, &[0x01, 0]);
const COMMAND_2: (u16, &[u8]) = (0x302, &[1, 0]);
const COMMAND_4: (u16, &[u8]) = (0x304, &[1, 0]);
const MASTER_BEATS: (u16, &[u8]) = (0x701, &[0x05]);
const OPERATIONAL: Phase = Phase::Nmt(NmtState::Operational);

/// Slave 2 with parallel, slave 4 with selective access.
struct World {
    observer: Observer,
}

impl World {
    /// Makes the world of the sample plan with a change, before power-on.
    fn of(change: impl Fn(&mut Plan)) -> Self {
        let mut plan = sample::plan();
        change(&mut plan);
        World { observer: Observer::new(&plan) }
    }

    /// Both slaves booted on the nominal bus at 0.
    fn booted(change: impl Fn(&mut Plan)) -> Self {
        let mut world = World::of(change);
        for node in [2, 4] {
            world.happens(0, FlightEvent::PowerOn(node));
            world.sees(0, Bus::Nominal, (0x700 + u16::from(node), &[0x00]), &[1]);
        }
        world
    }

    /// Both slaves booted, and started at 20 ms.
    fn started(change: impl Fn(&mut Plan)) -> Self {
        let mut world = World::booted(change);
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world
    }

    fn happens(&mut self, ms: u64, what: FlightEvent) -> Vec<Change> {
        self.observer.on(&sample::at(ms, what))
    }

    fn sees(&mut self, ms: u64, bus: Bus, (id, data): (u16, &[u8]), reached: &[Node]) -> Vec<Change> {
        let frame = WireFrame::standard(id, data);
        let reached: Nodes = reached.iter().copied().collect();
        self.happens(ms, FlightEvent::Frame(Seen::new(bus, frame, self.observer.scope, 0, reached)))
    }

    /// A frame of a board that reaches both slaves.
    fn sent(&mut self, ms: u64, bus: Bus, from: Node, (id, data): (u16, &[u8])) -> Vec<Change> {
        self.observer.on(&sample::frame(ms, bus, from, id, data, &[2, 4]))
    }

    fn phases(&self, node: Node) -> Vec<&'static str> {
        let track = &self.observer.nodes[&node];
        track.spans.iter().map(|span| track.name_of(span.phase)).collect()
    }

    fn due(&self, node: Node) -> u64 {
        self.observer.nodes[&node].tc_due
    }

    fn cut(&mut self, ms: u64) {
        let cut = CutPlan { bus: Bus::Nominal, at: Time::from_ms(ms), position_m: 0.5 };
        self.happens(ms, FlightEvent::Cut(cut));
    }
}

/// Does not change the plan.
fn usual(_: &mut Plan) {}

/// Gives slave 2 an image of the user's.
fn own_2(plan: &mut Plan) {
    plan.boards[1].own_image = Some("own".into());
}

/// Given flights of the shipped images, whose access is planned, then their heartbeats show the same access. Node 4 of the second
/// flight is pre-operational when the master moves, and shows nothing.
#[test]
fn access_by_behaviour_is_that_of_the_plan() {
    let found =
        |flight: Flight| flight.observer.slaves().map(|(_, track)| track.follow.found()).collect::<Vec<_>>();
    assert_eq!(found(sample::flight()), [Some(BusAccess::Parallel), Some(BusAccess::Selective)]);
    assert_eq!(found(sample::standby::flight()), [Some(BusAccess::Parallel), None]);
}

/// Given an image of the user's that stays operational on the redundant bus after the master has moved there, then it has parallel
/// access. Behind a cut of that bus it shows nothing.
#[test]
fn access_of_an_own_image_is_found_by_its_heartbeat() {
    for (cut, expected) in [(Bus::Nominal, Some(BusAccess::Parallel)), (Bus::Redundant, None)] {
        let mut world = World::started(own_2);
        assert_eq!(world.observer.nodes[&2].seen_access(), None);
        world.sees(100, Bus::Nominal, (0x702, &[0x05]), &[1]);
        world.happens(110, FlightEvent::Cut(CutPlan { bus: cut, at: Time::from_ms(110), position_m: 0.5 }));
        world.sees(120, Bus::Redundant, MASTER_BEATS, &[]);
        world.sees(122, Bus::Redundant, (0x702, &[0x05]), &[1]);
        assert_eq!(world.observer.nodes[&2].seen_access(), expected, "{cut}");
    }
}

#[test]
fn a_command_is_due_only_after_start() {
    let mut world = World::booted(usual);
    world.sees(10, Bus::Nominal, COMMAND_2, &[2, 4]);
    assert_eq!(world.due(2), 0);
    world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
    world.sees(21, Bus::Nominal, COMMAND_2, &[2, 4]);
    assert_eq!((world.due(2), world.due(4)), (1, 0));
}

#[test]
fn a_command_that_did_not_reach_the_slave_is_not_due() {
    let mut world = World::started(usual);
    world.sees(21, Bus::Nominal, COMMAND_2, &[4]);
    world.sees(22, Bus::Redundant, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 0);
}

#[test]
fn start_for_one_node_starts_no_other() {
    let mut world = World::booted(usual);
    world.sees(20, Bus::Nominal, (0x000, &[0x01, 4]), &[2, 4]);
    world.sees(21, Bus::Nominal, COMMAND_2, &[2, 4]);
    world.sees(21, Bus::Nominal, COMMAND_4, &[2, 4]);
    assert_eq!((world.due(2), world.due(4)), (0, 1));
}

#[test]
fn stop_boot_up_and_silence_end_operation() {
    for ending in [(0x000, &[0x02, 2][..]), (0x702, &[0x00])] {
        let mut world = World::started(usual);
        world.sees(30, Bus::Nominal, ending, &[1, 2]);
        world.sees(31, Bus::Nominal, COMMAND_2, &[2]);
        assert_eq!(world.due(2), 0, "{ending:02X?}");
    }
    let mut world = World::started(usual);
    world.sees(2519, Bus::Nominal, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 1);
    world.sees(2521, Bus::Nominal, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 1, "2500 ms after the last message of the master it has left operational");
}

#[test]
fn a_parallel_slave_follows_the_master_and_stays_operational() {
    let mut world = World::started(usual);
    world.cut(100);
    world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
    let changes = world.sees(201, Bus::Redundant, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 1);
    assert_eq!(changes, [Change::Recovered(2, Since::Cut, Time::from_ms(101))]);
}

#[test]
fn a_selective_slave_follows_when_it_says_so() {
    let mut world = World::started(usual);
    world.cut(100);
    world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
    world.sees(201, Bus::Redundant, COMMAND_4, &[2]);
    assert_eq!(world.due(4), 0);
    world.sees(12_520, Bus::Redundant, (0x704, &[0x7F]), &[1, 2]);
    world.sees(12_521, Bus::Redundant, (0x000, &[0x01, 4]), &[2, 4]);
    world.sees(12_522, Bus::Redundant, COMMAND_4, &[2, 4]);
    assert_eq!(world.due(4), 1);
    let track = &world.observer.nodes[&4];
    assert_eq!(track.failover, Some(Time::from_ms(12_422)));
    let phases: Vec<_> = track.spans.iter().map(|span| (span.phase.name(), span.bus)).collect();
    let nominal = ["off", "starting", "pre-operational", "operational", "pre-operational"];
    let redundant = ["pre-operational", "operational"].map(|phase| (phase, Bus::Redundant));
    assert_eq!(phases, [&nominal.map(|phase| (phase, Bus::Nominal))[..], &redundant].concat());
}

/// Given slave 4 as a minimal one, then its heartbeat makes it operational, and neither NMT nor a silent master changes that.
#[test]
fn a_minimal_slave_is_operational_from_its_first_heartbeat_on() {
    let mut world = World::of(|plan| plan.boards[2].is_minimal = true);
    world.happens(0, FlightEvent::PowerOn(4));
    world.sees(10, Bus::Nominal, COMMAND_4, &[4]);
    assert_eq!(world.due(4), 0);
    world.sees(20, Bus::Nominal, (0x704, &[0x05]), &[1]);
    world.sees(21, Bus::Nominal, MASTER_BEATS, &[4]);
    for command in [0x02, 0x80, 0x81, 0x82] {
        world.sees(30, Bus::Nominal, (0x000, &[command, 0]), &[4]);
    }
    world.sees(9_000, Bus::Nominal, COMMAND_4, &[4]);
    assert_eq!(world.due(4), 1);
    let track = &world.observer.nodes[&4];
    assert_eq!((track.now().phase, track.resets_due), (OPERATIONAL, 0));
    assert_eq!(track.kind(), "selective, minimal");
}

/// Given slave 2 as a minimal one, then a heartbeat of the master moves it to the other bus, but an NMT command does
/// not.
#[test]
fn a_minimal_slave_follows_heartbeats_alone() {
    let mut world = World::of(|plan| plan.boards[1].is_minimal = true);
    world.happens(0, FlightEvent::PowerOn(2));
    world.sees(20, Bus::Nominal, (0x702, &[0x05]), &[1]);
    world.sees(100, Bus::Redundant, START_ALL, &[2]);
    assert_eq!(world.observer.nodes[&2].now().bus, Bus::Nominal);
    world.sees(110, Bus::Redundant, MASTER_BEATS, &[2]);
    assert_eq!(world.observer.nodes[&2].now().bus, Bus::Redundant);
}

#[test]
fn a_heartbeat_that_waited_while_the_command_came_is_old_news() {
    let mut world = World::started(usual);
    world.sees(21, Bus::Nominal, (0x702, &[0x7F]), &[1, 4]);
    world.sees(22, Bus::Nominal, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 1);
    world.sees(270, Bus::Nominal, (0x702, &[0x7F]), &[1, 4]);
    world.sees(271, Bus::Nominal, COMMAND_2, &[2]);
    assert_eq!(world.due(2), 1, "the next one is believed");
}

/// Given slave 2 with an image of the user's, then only its own frames show its bus, no silence of the master ends its
/// operation, and its heartbeat as operational on the other bus is its recovery.
#[test]
fn an_unknown_image_is_where_its_heartbeats_are() {
    let mut world = World::started(own_2);
    world.cut(100);
    let changes = world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
    assert!(changes.iter().all(|change| matches!(change, Change::Now(MASTER, _))), "{changes:?}");
    assert_eq!(world.sees(201, Bus::Redundant, COMMAND_2, &[2]), []);
    let moved = Span { from: Time::from_ms(260), phase: OPERATIONAL, bus: Bus::Redundant };
    let expected = [Change::Now(2, moved), Change::Recovered(2, Since::Cut, Time::from_ms(160))];
    assert_eq!(world.sees(260, Bus::Redundant, (0x702, &[0x05]), &[1]), expected);
    assert_eq!(world.due(2), 0);
    for beat in 2..36 {
        world.sees(260 * beat, Bus::Redundant, (0x702, &[0x05]), &[1]);
    }
    world.sees(9_200, Bus::Redundant, (0x080, &[]), &[2]);
    assert_eq!(world.observer.nodes[&2].now(), moved);
}

/// Given slave 2 with an image of the user's and a heartbeat every 100 ms, when its heartbeats stop, then it is silent three periods
/// after the last one, and no command of the master makes it operational again. Its next heartbeat does.
#[test]
fn unknown_image_without_heartbeats_is_silent() {
    let mut world = World::started(own_2);
    for ms in [100, 200, 300] {
        world.sees(ms, Bus::Nominal, (0x702, &[0x05]), &[1]);
    }
    let silent = Span { from: Time::from_ms(600), phase: Phase::Silent, bus: Bus::Nominal };
    let changes = world.sees(700, Bus::Nominal, MASTER_BEATS, &[2, 4]);
    assert!(changes.contains(&Change::Now(2, silent)), "{changes:?}");
    world.sees(710, Bus::Nominal, START_ALL, &[2, 4]);
    assert_eq!(world.observer.nodes[&2].now(), silent);
    world.sees(800, Bus::Nominal, (0x702, &[0x05]), &[1]);
    assert_eq!(world.observer.nodes[&2].now().phase, OPERATIONAL);
}

/// Given slave 2 with an image of the user's that also sends a heartbeat at each change of its state or bus, then the first of them,
/// some milliseconds apart, are no period: the slave is operational all the time.
#[test]
fn heartbeats_at_changes_of_state_are_no_period() {
    let mut world = World::booted(own_2);
    let beats = [(4, 0x7F, Bus::Nominal), (14, 0x05, Bus::Nominal), (18, 0x05, Bus::Redundant)];
    let later = [268, 518, 768].map(|ms| (ms, 0x05, Bus::Redundant));
    for (ms, state, bus) in beats.into_iter().chain(later) {
        world.sees(ms, bus, (0x702, &[state]), &[1]);
    }
    let expected = ["off", "starting", "pre-operational", "operational", "operational"];
    assert_eq!(world.phases(2), expected, "{:?}", world.observer.nodes[&2].spans);
    world.sees(1_600, Bus::Redundant, MASTER_BEATS, &[2]);
    let silent = Span { from: Time::from_ms(1_518), phase: Phase::Silent, bus: Bus::Redundant };
    assert_eq!(world.observer.nodes[&2].now(), silent, "three periods of 250 ms after the last one");
}

/// Given a shipped slave whose heartbeats stop while the master goes on, then it is silent at the end of the flight.
#[test]
fn shipped_image_without_heartbeats_is_silent_at_the_end() {
    let mut world = World::started(usual);
    for ms in [250, 500, 750] {
        world.sees(ms, Bus::Nominal, (0x702, &[0x05]), &[1]);
        world.sees(ms + 1, Bus::Nominal, MASTER_BEATS, &[2, 4]);
    }
    world.sees(3_000, Bus::Nominal, MASTER_BEATS, &[2, 4]);
    world.observer.conclude(Time::from_ms(3_100));
    let silent = Span { from: Time::from_ms(1_500), phase: Phase::Silent, bus: Bus::Nominal };
    assert_eq!(world.observer.nodes[&2].now(), silent);
}

#[test]
fn commanded_resets_are_counted_where_they_arrive() {
    let mut world = World::booted(usual);
    world.sees(20, Bus::Nominal, (0x000, &[0x81, 2]), &[2, 4]);
    world.sees(30, Bus::Nominal, (0x000, &[0x81, 0]), &[4]);
    world.sees(40, Bus::Nominal, (0x000, &[0x82, 4]), &[4]);
    let resets = [2, 4].map(|node| world.observer.nodes[&node].resets_due);
    assert_eq!(resets, [1, 1]);
}

/// Two masters, both with power since 10 ms.
fn two_masters() -> World {
    let mut world = World::booted(|plan| {
        plan.boards.push(crate::fly::plan::BoardPlan { node: SECOND_MASTER, ..plan.boards[0].clone() });
    });
    for board in [MASTER, SECOND_MASTER] {
        world.happens(10, FlightEvent::PowerOn(board));
    }
    world
}

/// Given two masters, when the active one loses its power, then the other one is its standby up to its first message, and a
/// slave works for it from the first command on.
#[test]
fn a_standby_takes_over_from_a_lost_master() {
    let mut world = two_masters();
    let standby = Span { from: Time::from_ms(20), phase: Phase::Standby, bus: Bus::Nominal };
    let changes = world.sent(20, Bus::Nominal, MASTER, MASTER_BEATS);
    assert!(changes.contains(&Change::Now(SECOND_MASTER, standby)));
    world.sent(30, Bus::Nominal, MASTER, START_ALL);
    world.happens(50, FlightEvent::PowerOff(MASTER));
    let (last, first) = (Time::from_ms(20), Time::from_ms(420));
    let takeover = Takeover { from: MASTER, to: SECOND_MASTER, last, first };
    let changes = world.sent(420, Bus::Nominal, SECOND_MASTER, (0x701, &[0]));
    assert!(changes.contains(&Change::TookOver(takeover)));
    assert_eq!(takeover.took(), Time::from_ms(400));
    let changes = world.sent(450, Bus::Nominal, SECOND_MASTER, COMMAND_2);
    assert_eq!(changes, [Change::Recovered(2, Since::Loss, Time::from_ms(400))]);
    world.sent(520, Bus::Nominal, SECOND_MASTER, MASTER_BEATS);
    assert_eq!(world.phases(MASTER), ["off", "starting", "active", "off"]);
    assert_eq!(world.phases(SECOND_MASTER), ["off", "starting", "standby", "pre-operational", "active"]);
    assert_eq!(world.observer.slaves().count(), 2);
    assert_eq!((world.observer.takeover(), world.observer.rivalry()), (Some(takeover), None));
}

/// Given a standby, when it is reset and the bus is cut, then it is the standby again from the next 701h on, and follows 701h to
/// the other bus.
#[test]
fn a_standby_that_was_reset_is_the_standby_again() {
    let mut world = two_masters();
    world.sent(20, Bus::Nominal, MASTER, MASTER_BEATS);
    world.happens(50, FlightEvent::Reset(SECOND_MASTER));
    world.sent(120, Bus::Nominal, MASTER, MASTER_BEATS);
    world.cut(150);
    world.sent(220, Bus::Redundant, MASTER, MASTER_BEATS);
    assert_eq!(world.phases(SECOND_MASTER), ["off", "starting", "standby", "starting", "standby", "standby"]);
    let standby = Span { from: Time::from_ms(220), phase: Phase::Standby, bus: Bus::Redundant };
    assert_eq!(world.observer.nodes[&SECOND_MASTER].now(), standby);
    assert_eq!(world.observer.rivalry(), None);
}

/// Given a cut and then the loss of the active master, then a slave has a recovery time from each of them.
#[test]
fn recoveries_from_cut_and_loss_are_two_times() {
    let mut world = two_masters();
    world.sent(20, Bus::Nominal, MASTER, MASTER_BEATS);
    world.sent(30, Bus::Nominal, MASTER, START_ALL);
    world.cut(100);
    world.sent(300, Bus::Redundant, MASTER, MASTER_BEATS);
    let changes = world.sent(310, Bus::Redundant, MASTER, COMMAND_2);
    assert_eq!(changes, [Change::Recovered(2, Since::Cut, Time::from_ms(210))]);
    world.happens(400, FlightEvent::PowerOff(MASTER));
    assert_eq!(world.sent(700, Bus::Redundant, 2, (0x382, &[1, 0])), [], "no board has taken over yet");
    world.sent(710, Bus::Redundant, SECOND_MASTER, (0x701, &[0]));
    let changes = world.sent(750, Bus::Redundant, SECOND_MASTER, COMMAND_2);
    assert_eq!(changes, [Change::Recovered(2, Since::Loss, Time::from_ms(350))]);
    let track = &world.observer.nodes[&2];
    assert_eq!([track.failover, track.takeover], [210, 350].map(|ms| Some(Time::from_ms(ms))));
    let changes = world.sent(760, Bus::Redundant, 4, (0x384, &[1, 0]));
    assert_eq!(changes, [Change::Recovered(4, Since::Loss, Time::from_ms(360))]);
    assert_eq!(world.observer.nodes[&4].failover, None, "it did not work on the other bus before the loss");
}

#[test]
fn second_sender_of_701h_is_a_rival() {
    let mut world = two_masters();
    world.sent(20, Bus::Nominal, MASTER, MASTER_BEATS);
    world.sent(120, Bus::Redundant, SECOND_MASTER, MASTER_BEATS);
    let rival = world.observer.rivalry().map(|rival| (rival.to, rival.first));
    assert_eq!(rival, Some((SECOND_MASTER, Time::from_ms(120))));
}

#[test]
fn telemetry_on_the_cut_bus_is_no_recovery() {
    let mut world = World::started(usual);
    world.cut(100);
    assert_eq!(world.sees(101, Bus::Nominal, (0x382, &[1, 0]), &[4]), []);
    let changes = world.sees(350, Bus::Redundant, (0x382, &[1, 0]), &[1]);
    assert_eq!(changes, [Change::Recovered(2, Since::Cut, Time::from_ms(250))]);
}
