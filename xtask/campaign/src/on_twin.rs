//! The twin: the images that are flashed, on emulated boards.
//!
//! What happens on a board is read from its log and its memory. Two things of the host's world cannot be seen: when a command was
//! made, and Bdefault of a slave.

use std::sync::{Arc, OnceLock};

use anyhow::Context;
use can_wire::fault::Fault;
use can_wire::frame::{WireFrame, WireId};
use can_wire::record::Observation;
use can_wire::time::Time;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId, PerBus, Scet};
use host_worlds::Seat;
use support::board::BoardName;
use support::counters::Counters;
use support::craft::image;
use twin::board::{BoardConfig, EmulatedBoard, Fittings, State};
use twin::crystal::Crystal;
use twin::guest::Presence;
use twin::image::Image;
use twin::spacecraft::{BoardId, Event, GuestId, LogRecord, Spacecraft, SpacecraftConfig};

use crate::flight::BABBLED;
use crate::scene::{News, Noted, Reading, Scene, Sent};
use crate::script::Script;

const BOARD: BoardName = BoardName::PyboardV11;
const PROFILE: &str = "standard";
/// Crystals are at most so many parts per million off.
const CRYSTAL_PPM: f64 = 50.0;
/// Boards get power within the first 50 ms.
const POWER_ON_WITHIN_US: u64 = 50_000;
/// Node n sits at n times this.
const SPACING_M: f64 = 2.0;
/// A command with the bytes of the last one is another one after so long: its lifetime.
const LIFETIME: Time = Time::from_ms(100);

/// Images of master and slave.
static IMAGES: OnceLock<[Arc<Image>; 2]> = OnceLock::new();

/// Builds the images, or takes those that were built last.
///
/// # Errors
/// When they cannot be built or read, or were not built before and are not to be.
pub fn prepare(build: bool) -> anyhow::Result<()> {
    let board = BOARD.name();
    let built = if build {
        firmware_images::build(board, PROFILE)?
    } else {
        firmware_images::built(board, PROFILE).with_context(|| {
            format!("nothing was built for {board}, profile {PROFILE}, yet: leave out --no-build")
        })?
    };
    let images = [image(&built.master)?, image(&built.slave)?];
    IMAGES.get_or_init(|| images);
    Ok(())
}

/// Boards on both buses.
pub struct Twin {
    craft: Spacecraft,
    guests: PerBus<GuestId>,
    news: Vec<Noted>,
    frames: PerBus<Vec<Sent>>,
    clocks: Vec<Reading>,
    wrongs: Vec<String>,
    /// Of each board.
    boards: Vec<Watched>,
}

/// What a board did so far.
#[derive(Default)]
struct Watched {
    is_powered: bool,
    /// Panics and lock-ups.
    failures: u64,
    has_stopped: bool,
    /// Commands that it executed since its reset.
    executed: u32,
    /// Commands that reached it and may be executed yet.
    pending: u32,
    /// The last one, and when.
    last: Option<(WireFrame, Time)>,
}

impl Twin {
    /// The spacecraft of a script.
    ///
    /// # Panics
    /// Without [`prepare`] before.
    pub fn new(script: &Script) -> Twin {
        let [master, slave] = IMAGES.get().expect("images of master and slave");
        let mut random = fastrand::Rng::with_seed(script.seed);
        let mut craft = Spacecraft::new(SpacecraftConfig::default());
        for node in 1..=script.slaves + 1 {
            craft.add_board(BoardConfig {
                name: format!("node {node}"),
                model: BOARD.model(),
                image: if node == 1 { master.clone() } else { slave.clone() },
                straps: BOARD.straps(node),
                crystal: Crystal::ppm((2.0 * random.f64() - 1.0) * CRYSTAL_PPM),
                position_m: f64::from(node) * SPACING_M,
                power_on_at: Time::from_us(random.u64(0..POWER_ON_WITHIN_US)),
                fittings: Fittings::default(),
            });
        }
        let end_m = f64::from(script.slaves + 2) * SPACING_M;
        let guests = PerBus::from_fn(|bus| craft.add_guest(there(bus), end_m));
        Bus::ALL.into_iter().for_each(|bus| craft.set_presence(guests[bus], Presence::Away));
        let on = || Watched { is_powered: true, ..Watched::default() };
        let boards = (0..=script.slaves).map(|_| on()).collect();
        Twin {
            craft,
            guests,
            news: Vec::new(),
            frames: PerBus::default(),
            clocks: Vec::new(),
            wrongs: Vec::new(),
            boards,
        }
    }

    fn node(&self, index: usize) -> Option<NodeId> {
        if index < self.boards.len() { NodeId::new(index as u8 + 1) } else { None }
    }

    fn note(&mut self, node: NodeId, news: News) {
        self.news.push(Noted { at: self.craft.now(), seat: node.into(), news });
    }

    fn read_wires(&mut self) {
        for wire in self.craft.take_frames() {
            let Some(bus) = here(wire.bus) else { continue };
            match wire.record {
                Observation::Completed { trace, receivers, .. } => {
                    let id = standard(&trace.frame);
                    let seat = self.node(trace.transmitter).map(Seat::from);
                    let sent =
                        Sent { start: trace.start, end: trace.end, seat, id, receivers: receivers.len() };
                    self.frames[bus].push(sent);
                    self.read_clock(&sent, &trace.frame);
                    self.read_command(&trace.frame, &receivers);
                }
                Observation::Destroyed { frame, receivers, .. } => self.read_command(&frame, &receivers),
                _ => {}
            }
        }
    }

    /// The time of a slave at the last SYNC.
    fn read_clock(&mut self, sent: &Sent, frame: &WireFrame) {
        let Some(node) = sent.seat.map(Seat::node) else { return };
        if let Some(scet) = clock(node, sent.id, frame.payload()) {
            self.clocks.push(Reading { at: sent.start, node, scet });
        }
    }

    fn read_command(&mut self, frame: &WireFrame, receivers: &[(usize, Time)]) {
        for &(index, at) in receivers {
            let node = self.node(index).map_or(0, |node| u16::from(node.get()));
            if node > 1 && standard(frame) == Some(0x300 + node) {
                let board = &mut self.boards[index];
                let is_repeat =
                    board.last.is_some_and(|(last, then)| last == *frame && at <= then + LIFETIME);
                board.pending += u32::from(!is_repeat);
                board.last = Some((*frame, at));
            }
        }
    }

    fn read_logs(&mut self) {
        for LogRecord { at, board, text, .. } in self.craft.take_logs() {
            let Some(node) = self.node(board.0) else { continue };
            if let Some(news) = news(node, &text) {
                if news == News::PowerOn {
                    self.boards[board.0].last = None;
                }
                self.news.push(Noted { at, seat: node.into(), news });
            }
        }
    }

    /// Panics, and commands that were executed more often than they came.
    fn read_boards(&mut self) {
        let at = self.craft.now().as_us();
        for (id, board) in self.craft.boards() {
            let watched = &mut self.boards[id.0];
            let node = id.0 + 1;
            let counters = board.counters();
            let failures = counters.panics + counters.lockups;
            if failures > watched.failures {
                self.wrongs.push(format!("node {node} panicked, {at} us"));
                watched.failures = failures;
            }
            let stops = !matches!(board.state(), State::Running | State::Off);
            if stops && !watched.has_stopped {
                self.wrongs.push(format!("node {node} stopped: {:?}, {at} us", board.state()));
                watched.has_stopped = true;
            }
            if node > 1 {
                let executed = executed(board);
                let new = executed.checked_sub(watched.executed).unwrap_or(executed);
                watched.executed = executed;
                if new > watched.pending {
                    let came = watched.pending;
                    self.wrongs.push(format!("slave {node} executed {new} of {came} commands, {at} us"));
                }
                // One may be between the wire and the application.
                watched.pending = watched.pending.saturating_sub(new).min(1);
            }
        }
    }
}

impl Scene for Twin {
    fn now(&self) -> Time {
        self.craft.now()
    }

    fn run_until(&mut self, end: Time) {
        // A board that reached for what is not there stays stopped, which is a violation.
        while self.craft.run_until(end).is_err() {}
    }

    fn take_news(&mut self) -> Vec<Noted> {
        self.read_logs();
        let mut news = std::mem::take(&mut self.news);
        news.sort_by_key(|noted| noted.at);
        news
    }

    fn take_frames(&mut self) -> PerBus<Vec<Sent>> {
        self.read_wires();
        std::mem::take(&mut self.frames)
    }

    fn take_clocks(&mut self) -> Vec<Reading> {
        std::mem::take(&mut self.clocks)
    }

    fn take_wrongs(&mut self) -> Vec<String> {
        self.read_boards();
        std::mem::take(&mut self.wrongs)
    }

    fn unconfigured(&self) -> Vec<NodeId> {
        Vec::new()
    }

    fn bdefault(&self, _: NodeId) -> Option<Bus> {
        None
    }

    fn disturbance(&self, bus: Bus) -> u64 {
        let counters = self.craft.wire(there(bus)).counters();
        counters.destroyed + counters.ack_errors
    }

    fn is_busy(&self, bus: Bus) -> bool {
        !self.craft.wire(there(bus)).is_idle(0)
    }

    fn is_powered(&self, seat: Seat) -> bool {
        self.boards[self.index(seat)].is_powered
    }

    fn power(&mut self, seat: Seat, on: bool) {
        let index = self.index(seat);
        self.boards[index].is_powered = on;
        self.craft.schedule(self.craft.now(), BoardId(index), Event::Power(on));
        if !on {
            self.note(seat.node(), News::PowerOff);
        }
    }

    fn reset(&mut self, seat: Seat) {
        self.craft.reset(BoardId(self.index(seat)));
        self.note(seat.node(), News::PowerOff);
    }

    fn nodes(&self) -> usize {
        self.boards.len()
    }

    fn index(&self, seat: Seat) -> usize {
        usize::from(seat.node().get()) - 1
    }

    fn strike(&mut self, bus: Bus, fault: Fault) {
        let now = self.craft.now();
        self.craft.wire_mut(there(bus)).schedule(now, fault).expect("a fault of this wire");
    }

    fn inject(&mut self, bus: Bus, frame: WireFrame) {
        let (guest, now) = (self.guests[bus], self.craft.now());
        self.craft.set_presence(guest, Presence::Present);
        self.craft.inject(guest, now, frame);
    }
}

fn there(bus: Bus) -> twin::spacecraft::Bus {
    match bus {
        Bus::Nominal => twin::spacecraft::Bus::Nominal,
        Bus::Redundant => twin::spacecraft::Bus::Redundant,
    }
}

fn here(bus: twin::spacecraft::Bus) -> Option<Bus> {
    Bus::ALL.into_iter().find(|other| there(*other) == bus)
}

fn standard(frame: &WireFrame) -> Option<u16> {
    match frame.id {
        WireId::Standard(id) => Some(id),
        WireId::Extended(_) => None,
    }
}

fn executed(board: &EmulatedBoard) -> u32 {
    Counters::read(board).ok().flatten().map_or(0, |counters| counters.commands)
}

/// The meaning of a line of the log; `None` for what is no change of state.
fn news(node: NodeId, text: &str) -> Option<News> {
    let is_master = node == NodeId::MASTER;
    if text.contains(" starts, profile") {
        return Some(News::PowerOn);
    }
    if text.ends_with(" written") {
        return None;
    }
    Some(match text.split_once(": ") {
        Some(("active bus", rest)) if is_master => return switched(rest),
        Some(("active bus", rest)) => News::ActiveBus(named(&Bus::ALL, rest.split(' ').next()?)?),
        Some(("clock set", _)) => News::ClockSet,
        _ if text.contains("another master") || text.contains("another node") => News::Collision,
        _ if is_master => News::Other,
        _ => named(&STATES, text).map_or(News::Other, News::State),
    })
}

/// The time in the first TPDO of a slave. What a controller sends while it babbles is not what the slave sent.
fn clock(node: NodeId, id: Option<u16>, payload: &[u8]) -> Option<Scet> {
    let is_telemetry = node != NodeId::MASTER && id == Some(0x180 + u16::from(node.get()));
    if is_telemetry && payload != BABBLED { Scet::decode(payload) } else { None }
}

/// "redundant, no longer nominal (Isolated)".
fn switched(text: &str) -> Option<News> {
    let (to, rest) = text.split_once(", no longer ")?;
    let (from, cause) = rest.trim_end_matches(')').split_once(" (")?;
    let (from, to) = (named(&Bus::ALL, from)?, named(&Bus::ALL, to)?);
    Some(News::Switched { from, to, cause: named(&CAUSES, cause)? })
}

/// The value that is called like that, in capitals or not, with hyphens or not.
fn named<T: Copy + std::fmt::Debug>(all: &[T], name: &str) -> Option<T> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "");
    all.iter().copied().find(|value| plain(&format!("{value:?}")) == plain(name))
}

const STATES: [NmtState; 4] =
    [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational];

const CAUSES: [SwitchCause; 7] = [
    SwitchCause::BusOff,
    SwitchCause::Isolated,
    SwitchCause::SlavesSilent,
    SwitchCause::Unheard,
    SwitchCause::Tried,
    SwitchCause::TriedInVain,
    SwitchCause::Commanded,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_log_are_understood() {
        let [master, slave] = [NodeId::MASTER, NodeId::of::<3>()];
        let left =
            News::Switched { from: Bus::Nominal, to: Bus::Redundant, cause: SwitchCause::SlavesSilent };
        for (node, text, expected) in [
            (master, "master starts, profile standard", Some(News::PowerOn)),
            (slave, "slave 3 starts, profile standard", Some(News::PowerOn)),
            (master, "active bus: Redundant, no longer Nominal (SlavesSilent)", Some(left)),
            (slave, "active bus: Redundant (Followed)", Some(News::ActiveBus(Bus::Redundant))),
            (slave, "PreOperational", Some(News::State(NmtState::PreOperational))),
            (master, "Operational", Some(News::Other)),
            (slave, "clock set: 7 s, was 8 s", Some(News::ClockSet)),
            (slave, "another node with this Node-ID on Nominal, yields: false", Some(News::Collision)),
            (master, "another master sends 701h on Nominal: EMCY 8150h", Some(News::Collision)),
            (slave, "1029h:1 written", None),
            (slave, "master missed on Nominal", Some(News::Other)),
        ] {
            assert_eq!(news(node, text), expected, "{text}");
        }
    }
    #[test]
    fn what_a_node_babbles_is_not_the_time_of_a_slave() {
        let time = [0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0, 1];
        let slave = NodeId::of::<3>();
        assert_eq!(clock(slave, Some(0x183), &time), Scet::decode(&time));
        assert!(clock(slave, Some(0x183), &time).is_some());
        assert_eq!(clock(slave, Some(0x183), &BABBLED), None);
        assert_eq!(clock(slave, Some(0x283), &time), None);
        assert_eq!(clock(slave, Some(0x182), &time), None);
        assert_eq!(clock(NodeId::MASTER, Some(0x181), &time), None);
        assert_eq!(clock(slave, Some(0x183), &time[..3]), None);
    }
}
