//! What the slaves must be doing, judged from the wires alone.
//!
//! A model per slave follows the frames that reached its controllers and the heartbeats it sent. In a flight of the shipped
//! images it decides which commands were due (`tc_due`) without asking the firmware; the firmware's own count must then agree.
//!
//! - NMT start received on a bus: operational on it. Other NMT commands: not operational.
//! - Its own heartbeat shows state and bus. Within `SETTLING` of a message from the master that changed either, it does not
//!   count: it may have waited in a mailbox since before.
//! - Parallel access: any message of the master (NMT, heartbeat, boot-up) on the other bus moves it there
//!   (ECSS 8.3.3g). Selective access: it hears one bus and says itself when it has changed.
//! - The master silent for the consumer time, a boot-up, no power: not operational.
//! - A minimal slave (ECSS 9): operational from its first heartbeat on. Of the master it hears heartbeats, and no NMT.
//! - An image of the user's: neither its access nor its consumer time is known. Its own heartbeats alone show its bus, and that it is
//!   alive ([`super::liveness`]). At the end of a flight the latter holds for every slave.

use std::collections::BTreeMap;

use can_wire::time::Time;

use super::meaning::{Meaning, NmtState, Scope};
use super::plan::Plan;
use super::record::{Bus, Happening, MASTER, Node, Occurrence, Seen, is_master};
use super::track::{BusAccess, Phase, SETTLING, Span, Track};

/// A change the observer noticed, for the narrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A node changed phase or bus.
    Now(Node, Span),
    /// The first proof after the cut that a slave works on the other bus, and the time since the cut; or, where the active
    /// master lost its power, that it works for the other one. In a flight of the shipped images a command due or telemetry,
    /// else a heartbeat as operational.
    Recovered(Node, Time),
    /// A master board sends what another one sent before.
    TookOver(Takeover),
}

/// A standby became the active master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Takeover {
    /// The board that was active.
    pub from: Node,
    /// The one that is now.
    pub to: Node,
    /// End of the last heartbeat of the one, of the first message of the other.
    pub last: Time,
    /// The latter.
    pub first: Time,
}

impl Takeover {
    /// How long no master was heard.
    pub fn took(&self) -> Time {
        self.first.since(self.last)
    }
}

/// Follows all nodes of a flight.
#[derive(Clone, Debug)]
pub struct Observer {
    nodes: BTreeMap<Node, Track>,
    cut: Option<(Bus, Time)>,
    /// When the active one of two masters lost its power.
    lost: Option<Time>,
    /// The board that sent the last message of a master, and when.
    active: Option<(Node, Time)>,
    takeover: Option<Takeover>,
    consumer_time: Time,
    scope: Scope,
}

impl Observer {
    /// For the boards of a plan, all without power.
    pub fn new(plan: &Plan) -> Self {
        let of = |node| plan.boards.iter().find(|board| board.node == node);
        let slave = |(node, access)| {
            let is_minimal = of(node).is_some_and(|board| board.is_minimal);
            let has_one_controller = of(node).is_some_and(|board| board.has_one_controller);
            (node, Track { is_minimal, has_one_controller, ..Track::new(Some(access)) })
        };
        let mut nodes: BTreeMap<_, _> = plan.slaves().map(slave).collect();
        let masters = plan.boards.iter().map(|board| board.node).filter(|node| is_master(*node));
        nodes.extend(masters.chain([MASTER]).map(|node| (node, Track::new(None))));
        let (cut, lost, active, takeover) = Default::default();
        let (consumer_time, scope) = (plan.consumer_time(), plan.scope());
        Observer { nodes, cut, lost, active, takeover, consumer_time, scope }
    }

    /// The master board that was heard last.
    pub fn active_master(&self) -> Option<Node> {
        self.active.map(|(node, _)| node)
    }

    /// The takeover by the standby, when there was one.
    pub fn takeover(&self) -> Option<Takeover> {
        self.takeover
    }

    /// All boards, the master first.
    pub fn nodes(&self) -> &BTreeMap<Node, Track> {
        &self.nodes
    }

    /// The slaves.
    pub fn slaves(&self) -> impl Iterator<Item = (Node, &Track)> {
        self.nodes.iter().filter(|(node, _)| !is_master(**node)).map(|(node, track)| (*node, track))
    }

    /// Takes the next record; records come in order of time.
    pub fn on(&mut self, record: &Occurrence) -> Vec<Change> {
        let mut changes = Vec::new();
        self.expire(record.at, &mut changes);
        match &record.what {
            Happening::PowerOn(node) => {
                self.enter(*node, record.at, Phase::Starting, Bus::Nominal, &mut changes)
            }
            Happening::PowerOff(node) => {
                self.lost = Some(record.at);
                self.nodes.entry(*node).and_modify(|track| track.liveness.on_power_off());
                let bus = self.nodes.get(node).map_or(Bus::Nominal, |track| track.now().bus);
                self.enter(*node, record.at, Phase::Off, bus, &mut changes);
            }
            Happening::Cut(bus) => self.cut = Some((*bus, record.at)),
            Happening::Frame(seen) => self.on_frame(record.at, seen, &mut changes),
            Happening::Log { .. } => {}
        }
        changes
    }

    /// The flight ended at `end`.
    pub fn conclude(&mut self, end: Time) -> Vec<Change> {
        let mut changes = Vec::new();
        self.expire(end, &mut changes);
        for (&node, track) in self.nodes.iter_mut().filter(|(node, _)| !is_master(**node)) {
            track.fall_silent(node, end, &mut changes);
        }
        changes
    }

    fn expire(&mut self, now: Time, changes: &mut Vec<Change>) {
        for (&node, track) in &mut self.nodes {
            if track.access == Some(BusAccess::Unknown) {
                track.fall_silent(node, now, changes);
            }
            let Some(heard) = track.master_heard else { continue };
            let deadline = heard + self.consumer_time;
            let current = track.now();
            if deadline < now && current.phase == Phase::Nmt(NmtState::Operational) {
                let phase = Phase::Nmt(NmtState::PreOperational);
                track.enter(node, Span { from: deadline, phase, bus: current.bus }, changes);
            }
        }
    }

    fn on_frame(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let Some(message) = seen.meaning else { return };
        match message {
            Meaning::Nmt { command, node } => {
                self.on_master(at, seen, changes);
                for (&slave, track) in &mut self.nodes {
                    let obeys = track.access.is_some() && !track.is_minimal;
                    if obeys && (node == 0 || node == slave) && seen.reached.contains(slave) {
                        track.obey(slave, at, command, changes);
                    }
                }
            }
            Meaning::BootUp { node } => {
                if node == MASTER {
                    self.on_master(at, seen, changes);
                    self.on_master_board(at, seen, changes);
                }
                let node = seen.board(node);
                let initial = Phase::Nmt(NmtState::PreOperational);
                self.enter(node, at, initial, seen.bus, changes);
                if let Some(track) = self.nodes.get_mut(&node) {
                    track.liveness.on_boot_up(at);
                    track.master_heard = None;
                    track.settled = at;
                }
            }
            Meaning::Heartbeat { node, state } => {
                if node == MASTER {
                    self.on_master(at, seen, changes);
                    self.on_master_board(at, seen, changes);
                }
                let node = seen.board(node);
                self.nodes.entry(node).and_modify(|track| track.liveness.on_heartbeat(at));
                if self.nodes.get(&node).is_some_and(|track| at >= track.settled) {
                    self.enter(node, at, Phase::Nmt(state), seen.bus, changes);
                }
                let is_slave = !is_master(node) && state == NmtState::Operational;
                if self.scope == Scope::Protocol && is_slave {
                    self.recovered(node, at, seen.bus, changes);
                }
            }
            Meaning::Telecommand { node, .. } => {
                let Some(track) = self.nodes.get_mut(&node) else { return };
                if seen.reached.contains(node) && track.operational_on() == Some(seen.bus) {
                    track.tc_due += 1;
                    self.recovered(node, at, seen.bus, changes);
                }
            }
            Meaning::Telemetry { node, .. } => self.recovered(node, at, seen.bus, changes),
            Meaning::Sync
            | Meaning::Emergency { .. }
            | Meaning::SpacecraftTime(_)
            | Meaning::LocalTime { .. }
            | Meaning::CyclicState { .. }
            | Meaning::Pdo
            | Meaning::Sdo { .. }
            | Meaning::TelemetryRequest { .. } => {}
        }
    }

    /// A message that makes its bus the active one (ECSS 8.3.3g) for every slave whose controller received it.
    fn on_master(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let is_nmt = matches!(seen.meaning, Some(Meaning::Nmt { .. }));
        for (&slave, track) in &mut self.nodes {
            let Some(access) = track.access.filter(|access| *access != BusAccess::Unknown) else { continue };
            if !seen.reached.contains(slave) || track.is_minimal && is_nmt {
                continue;
            }
            let current = track.now();
            if current.bus != seen.bus {
                if access == BusAccess::Selective && track.operational_on().is_some() {
                    continue;
                }
                track.settled = at + SETTLING;
                track.enter(slave, Span { from: at, phase: current.phase, bus: seen.bus }, changes);
            }
            // Without it a minimal slave stays operational.
            track.master_heard = (!track.is_minimal).then_some(at);
        }
    }

    /// 701h: who sends it is the active master, another one with power its standby.
    fn on_master_board(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let before = self.active.replace((seen.from, at));
        if let Some((from, last)) = before.filter(|(from, _)| *from != seen.from) {
            let takeover = Takeover { from, to: seen.from, last, first: at };
            self.takeover = Some(takeover);
            changes.push(Change::TookOver(takeover));
        }
        for (&node, track) in &mut self.nodes {
            let is_silent = matches!(track.now().phase, Phase::Starting | Phase::Standby);
            if is_master(node) && node != seen.from && is_silent {
                track.enter(node, Span { from: at, phase: Phase::Standby, bus: seen.bus }, changes);
            }
        }
    }

    fn enter(&mut self, node: Node, at: Time, phase: Phase, bus: Bus, changes: &mut Vec<Change>) {
        if let Some(track) = self.nodes.get_mut(&node) {
            track.enter(node, Span { from: at, phase, bus }, changes);
        }
    }

    fn recovered(&mut self, node: Node, at: Time, bus: Bus, changes: &mut Vec<Change>) {
        let since = match (self.cut, self.lost) {
            (Some((cut_bus, cut)), _) if bus != cut_bus => cut,
            (None, Some(lost)) if self.takeover.is_some() => lost,
            _ => return,
        };
        let Some(track) = self.nodes.get_mut(&node) else { return };
        if track.failover.is_none() {
            let took = at.since(since);
            track.failover = Some(took);
            changes.push(Change::Recovered(node, took));
        }
    }
}

#[cfg(test)]
mod tests {
    use can_wire::frame::WireFrame;

    use super::*;
    use crate::record::{Nodes, SECOND_MASTER};
    use crate::sample;

    const START_ALL: (u16, &[u8]) = (0x000, &[0x01, 0]);
    const COMMAND_2: (u16, &[u8]) = (0x302, &[1, 0]);
    const COMMAND_4: (u16, &[u8]) = (0x304, &[1, 0]);
    const MASTER_BEATS: (u16, &[u8]) = (0x701, &[0x05]);
    const OPERATIONAL: Phase = Phase::Nmt(NmtState::Operational);

    /// Slave 2 with parallel, slave 4 with selective access, both booted on the nominal bus at 0.
    struct World {
        observer: Observer,
    }

    impl World {
        fn new() -> Self {
            World::of(&sample::plan())
        }

        fn of(plan: &Plan) -> Self {
            let mut world = World { observer: Observer::new(plan) };
            for node in [2, 4] {
                world.observer.on(&Occurrence { at: Time::ZERO, what: Happening::PowerOn(node) });
                world.sees(0, Bus::Nominal, (0x700 + u16::from(node), &[0x00]), &[1]);
            }
            world
        }

        fn sees(&mut self, ms: u64, bus: Bus, (id, data): (u16, &[u8]), reached: &[Node]) -> Vec<Change> {
            let frame = WireFrame::standard(id, data);
            let reached: Nodes = reached.iter().copied().collect();
            let what = Happening::Frame(Seen::new(bus, frame, self.observer.scope, 0, reached));
            self.observer.on(&Occurrence { at: Time::from_ms(ms), what })
        }

        fn due(&self, node: Node) -> u64 {
            self.observer.nodes()[&node].tc_due
        }

        fn cut(&mut self, ms: u64) {
            self.observer.on(&Occurrence { at: Time::from_ms(ms), what: Happening::Cut(Bus::Nominal) });
        }
    }

    #[test]
    fn a_command_is_due_only_after_start() {
        let mut world = World::new();
        world.sees(10, Bus::Nominal, COMMAND_2, &[2, 4]);
        assert_eq!(world.due(2), 0);
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.sees(21, Bus::Nominal, COMMAND_2, &[2, 4]);
        assert_eq!((world.due(2), world.due(4)), (1, 0));
    }

    #[test]
    fn a_command_that_did_not_reach_the_slave_is_not_due() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.sees(21, Bus::Nominal, COMMAND_2, &[4]);
        world.sees(22, Bus::Redundant, COMMAND_2, &[2]);
        assert_eq!(world.due(2), 0);
    }

    #[test]
    fn start_for_one_node_starts_no_other() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, (0x000, &[0x01, 4]), &[2, 4]);
        world.sees(21, Bus::Nominal, COMMAND_2, &[2, 4]);
        world.sees(21, Bus::Nominal, COMMAND_4, &[2, 4]);
        assert_eq!((world.due(2), world.due(4)), (0, 1));
    }

    #[test]
    fn stop_boot_up_and_silence_end_operation() {
        for ending in [(0x000, &[0x02, 2][..]), (0x702, &[0x00])] {
            let mut world = World::new();
            world.sees(20, Bus::Nominal, START_ALL, &[2]);
            world.sees(30, Bus::Nominal, ending, &[1, 2]);
            world.sees(31, Bus::Nominal, COMMAND_2, &[2]);
            assert_eq!(world.due(2), 0);
        }
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2]);
        world.sees(2519, Bus::Nominal, COMMAND_2, &[2]);
        assert_eq!(world.due(2), 1);
        world.sees(2521, Bus::Nominal, COMMAND_2, &[2]);
        assert_eq!(world.due(2), 1, "2500 ms after the last message of the master it has left operational");
    }

    #[test]
    fn a_parallel_slave_follows_the_master_and_stays_operational() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.cut(100);
        world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
        let changes = world.sees(201, Bus::Redundant, COMMAND_2, &[2]);
        assert_eq!(world.due(2), 1);
        assert_eq!(changes, [Change::Recovered(2, Time::from_ms(101))]);
    }

    #[test]
    fn a_selective_slave_follows_when_it_says_so() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.cut(100);
        world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
        world.sees(201, Bus::Redundant, COMMAND_4, &[2]);
        assert_eq!(world.due(4), 0);
        world.sees(12_520, Bus::Redundant, (0x704, &[0x7F]), &[1, 2]);
        world.sees(12_521, Bus::Redundant, (0x000, &[0x01, 4]), &[2, 4]);
        world.sees(12_522, Bus::Redundant, COMMAND_4, &[2, 4]);
        assert_eq!(world.due(4), 1);
        let track = &world.observer.nodes()[&4];
        assert_eq!(track.failover, Some(Time::from_ms(12_422)));
        let phases: Vec<_> = track.spans.iter().map(|span| (span.phase.name(), span.bus)).collect();
        assert_eq!(
            phases,
            [
                ("off", Bus::Nominal),
                ("starting", Bus::Nominal),
                ("pre-operational", Bus::Nominal),
                ("operational", Bus::Nominal),
                ("pre-operational", Bus::Nominal),
                ("pre-operational", Bus::Redundant),
                ("operational", Bus::Redundant),
            ]
        );
    }

    /// Given slave 4 as a minimal one, then its heartbeat makes it operational, and neither NMT nor a silent master changes that.
    #[test]
    fn a_minimal_slave_is_operational_from_its_first_heartbeat_on() {
        let mut plan = sample::plan();
        plan.boards[2].is_minimal = true;
        let mut world = World { observer: Observer::new(&plan) };
        world.observer.on(&Occurrence { at: Time::ZERO, what: Happening::PowerOn(4) });
        world.sees(10, Bus::Nominal, COMMAND_4, &[4]);
        assert_eq!(world.due(4), 0);
        world.sees(20, Bus::Nominal, (0x704, &[0x05]), &[1]);
        world.sees(21, Bus::Nominal, MASTER_BEATS, &[4]);
        for command in [0x02, 0x80, 0x81, 0x82] {
            world.sees(30, Bus::Nominal, (0x000, &[command, 0]), &[4]);
        }
        world.sees(9_000, Bus::Nominal, COMMAND_4, &[4]);
        assert_eq!(world.due(4), 1);
        let track = &world.observer.nodes()[&4];
        assert_eq!((track.now().phase, track.resets_due), (OPERATIONAL, 0));
        assert_eq!(track.kind(), "selective, minimal");
    }

    /// Given slave 2 as a minimal one, then a heartbeat of the master moves it to the other bus, and an NMT command does not.
    #[test]
    fn a_minimal_slave_follows_heartbeats_alone() {
        let mut plan = sample::plan();
        plan.boards[1].is_minimal = true;
        let mut world = World { observer: Observer::new(&plan) };
        world.observer.on(&Occurrence { at: Time::ZERO, what: Happening::PowerOn(2) });
        world.sees(20, Bus::Nominal, (0x702, &[0x05]), &[1]);
        world.sees(100, Bus::Redundant, START_ALL, &[2]);
        assert_eq!(world.observer.nodes()[&2].now().bus, Bus::Nominal);
        world.sees(110, Bus::Redundant, MASTER_BEATS, &[2]);
        assert_eq!(world.observer.nodes()[&2].now().bus, Bus::Redundant);
    }

    #[test]
    fn a_heartbeat_that_waited_while_the_command_came_is_old_news() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
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
        let mut plan = sample::plan();
        plan.boards[1].own_image = Some("own".into());
        let mut world = World::of(&plan);
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.cut(100);
        let changes = world.sees(200, Bus::Redundant, MASTER_BEATS, &[2]);
        assert!(changes.iter().all(|change| matches!(change, Change::Now(MASTER, _))), "{changes:?}");
        assert_eq!(world.sees(201, Bus::Redundant, COMMAND_2, &[2]), []);
        let moved = Span { from: Time::from_ms(260), phase: OPERATIONAL, bus: Bus::Redundant };
        let expected = [Change::Now(2, moved), Change::Recovered(2, Time::from_ms(160))];
        assert_eq!(world.sees(260, Bus::Redundant, (0x702, &[0x05]), &[1]), expected);
        assert_eq!(world.due(2), 0);
        for beat in 2..36 {
            world.sees(260 * beat, Bus::Redundant, (0x702, &[0x05]), &[1]);
        }
        world.sees(9_200, Bus::Redundant, (0x080, &[]), &[2]);
        assert_eq!(world.observer.nodes()[&2].now(), moved);
    }

    /// Given slave 2 with an image of the user's and a heartbeat every 100 ms, when its heartbeats stop, then it is silent three periods
    /// after the last one, and no command of the master makes it operational again. Its next heartbeat does.
    #[test]
    fn unknown_image_without_heartbeats_is_silent() {
        let mut plan = sample::plan();
        plan.boards[1].own_image = Some("own".into());
        let mut world = World::of(&plan);
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        for ms in [100, 200, 300] {
            world.sees(ms, Bus::Nominal, (0x702, &[0x05]), &[1]);
        }
        let silent = Span { from: Time::from_ms(600), phase: Phase::Silent, bus: Bus::Nominal };
        let changes = world.sees(700, Bus::Nominal, MASTER_BEATS, &[2, 4]);
        assert!(changes.contains(&Change::Now(2, silent)), "{changes:?}");
        world.sees(710, Bus::Nominal, START_ALL, &[2, 4]);
        assert_eq!(world.observer.nodes()[&2].now(), silent);
        world.sees(800, Bus::Nominal, (0x702, &[0x05]), &[1]);
        assert_eq!(world.observer.nodes()[&2].now().phase, OPERATIONAL);
    }

    /// Given a shipped slave whose heartbeats stop while the master goes on, then it is silent at the end of the flight.
    #[test]
    fn shipped_image_without_heartbeats_is_silent_at_the_end() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        for ms in [250, 500, 750] {
            world.sees(ms, Bus::Nominal, (0x702, &[0x05]), &[1]);
            world.sees(ms + 1, Bus::Nominal, MASTER_BEATS, &[2, 4]);
        }
        world.sees(3_000, Bus::Nominal, MASTER_BEATS, &[2, 4]);
        world.observer.conclude(Time::from_ms(3_100));
        let silent = Span { from: Time::from_ms(1_500), phase: Phase::Silent, bus: Bus::Nominal };
        assert_eq!(world.observer.nodes()[&2].now(), silent);
    }

    #[test]
    fn commanded_resets_are_counted_where_they_arrive() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, (0x000, &[0x81, 2]), &[2, 4]);
        world.sees(30, Bus::Nominal, (0x000, &[0x81, 0]), &[4]);
        world.sees(40, Bus::Nominal, (0x000, &[0x82, 4]), &[4]);
        let resets = [2, 4].map(|node| world.observer.nodes()[&node].resets_due);
        assert_eq!(resets, [1, 1]);
    }

    /// Given two masters, when the active one loses its power, then the other one is its standby up to its first message, and a
    /// slave works for it from the first command on.
    #[test]
    fn a_standby_takes_over_from_a_lost_master() {
        let mut plan = sample::plan();
        plan.boards.push(crate::plan::BoardPlan { node: SECOND_MASTER, ..plan.boards[0].clone() });
        let mut world = World::of(&plan);
        let mut on = |ms, what| world.observer.on(&Occurrence { at: Time::from_ms(ms), what });
        on(10, Happening::PowerOn(MASTER));
        on(11, Happening::PowerOn(SECOND_MASTER));
        let mut sent = |ms, from, (id, data): (u16, &[u8])| {
            let frame = WireFrame::standard(id, data);
            let reached = Nodes::from_iter([2, 4]);
            on(ms, Happening::Frame(Seen::new(Bus::Nominal, frame, Scope::Mission, from, reached)))
        };
        let standby = Span { from: Time::from_ms(20), phase: Phase::Standby, bus: Bus::Nominal };
        assert!(sent(20, MASTER, MASTER_BEATS).contains(&Change::Now(SECOND_MASTER, standby)));
        sent(30, MASTER, START_ALL);
        world.observer.on(&Occurrence { at: Time::from_ms(50), what: Happening::PowerOff(MASTER) });
        let mut sent = |ms, from, (id, data): (u16, &[u8])| {
            let frame = WireFrame::standard(id, data);
            let seen = Seen::new(Bus::Nominal, frame, Scope::Mission, from, Nodes::from_iter([2, 4]));
            world.observer.on(&Occurrence { at: Time::from_ms(ms), what: Happening::Frame(seen) })
        };
        let (last, first) = (Time::from_ms(20), Time::from_ms(420));
        let takeover = Takeover { from: MASTER, to: SECOND_MASTER, last, first };
        assert!(sent(420, SECOND_MASTER, (0x701, &[0])).contains(&Change::TookOver(takeover)));
        assert_eq!(takeover.took(), Time::from_ms(400));
        let changes = sent(450, SECOND_MASTER, COMMAND_2);
        assert_eq!(changes, [Change::Recovered(2, Time::from_ms(400))]);
        sent(520, SECOND_MASTER, MASTER_BEATS);
        let phases = |node: Node| {
            world.observer.nodes()[&node].spans.iter().map(|span| span.phase.name()).collect::<Vec<_>>()
        };
        assert_eq!(phases(MASTER), ["off", "starting", "operational", "off"]);
        assert_eq!(phases(SECOND_MASTER), ["off", "starting", "standby", "pre-operational", "operational"]);
        assert_eq!(world.observer.slaves().count(), 2);
    }

    #[test]
    fn telemetry_on_the_cut_bus_is_no_recovery() {
        let mut world = World::new();
        world.sees(20, Bus::Nominal, START_ALL, &[2, 4]);
        world.cut(100);
        assert_eq!(world.sees(101, Bus::Nominal, (0x382, &[1, 0]), &[4]), []);
        assert_eq!(
            world.sees(350, Bus::Redundant, (0x382, &[1, 0]), &[1]),
            [Change::Recovered(2, Time::from_ms(250))]
        );
    }
}
