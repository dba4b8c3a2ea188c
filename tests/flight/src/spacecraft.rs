//! A spacecraft of real images, and the record of its wires and logs.

use std::collections::BTreeMap;
use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex};

use can_twin::board::{BoardConfig, EmulatedBoard, Fittings, State};
use can_twin::crystal::Crystal;
use can_twin::image::Image;
use can_twin::model::Model;
use can_twin::pin::Pin;
use can_twin::spacecraft::{BoardId, Bus, GuestId, LogRecord, Spacecraft, SpacecraftConfig, WireRecord};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::counters::Counters;
use ecss_can_cli::images::support::diagnostics::Diagnostics;

pub const MASTER: u8 = 1;

/// Boards of the project.
pub const PYBOARD_V11: &str = "pyboard-v11";
pub const NUCLEO_F446RE: &str = "nucleo-f446re";
pub const STM32F4DISCOVERY: &str = "stm32f4discovery";

/// States in heartbeats (CiA 301 7.2.8.3.2.2).
pub const BOOT_UP: u8 = 0x00;
pub const STOPPED: u8 = 0x04;
pub const OPERATIONAL: u8 = 0x05;
pub const PRE_OPERATIONAL: u8 = 0x7F;

/// The master and slave images of a board.
pub type Images = [Arc<Image>; 2];

/// Built once for all tests.
static PYBOARD: LazyLock<Images> = LazyLock::new(|| build(PYBOARD_V11, "librecube"));
static NUCLEO: LazyLock<Images> = LazyLock::new(|| build(NUCLEO_F446RE, "librecube"));
static DISCOVERY: LazyLock<Images> = LazyLock::new(|| build(STM32F4DISCOVERY, "librecube"));
/// Profile `standard`, for pyboards: heartbeat 100 ms, consumer time 250 ms, Ttoggle 2; all slaves have parallel access.
pub static STANDARD: LazyLock<Images> = LazyLock::new(|| build(PYBOARD_V11, "standard"));

pub fn build(board: &str, profile: &str) -> Images {
    let images = ecss_can_cli::images::build(board, profile).unwrap();
    [images.master, images.slave].map(|path| parsed(&path))
}

/// An ELF file, parsed once however many tests fly it.
pub fn parsed(path: &Path) -> Arc<Image> {
    static PARSED: Mutex<BTreeMap<PathBuf, Arc<Image>>> = Mutex::new(BTreeMap::new());
    let parse = || Arc::new(Image::parse(&std::fs::read(path).unwrap()).unwrap());
    PARSED.lock().unwrap().entry(path.to_owned()).or_insert_with(parse).clone()
}

/// A board with this program, without straps, at the left end of both wires, powered from the start.
pub fn bare(board: &str, image: Arc<Image>) -> BoardConfig {
    BoardConfig {
        name: "bare".to_owned(),
        model: Model::shipped(board),
        image,
        straps: Vec::new(),
        crystal: Crystal::ppm(0.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings: Fittings::default(),
    }
}

/// Words of a variable of the image that a board runs.
pub fn words<const N: usize>(board: &EmulatedBoard, variable: &str) -> [u32; N] {
    let bytes = board.read_memory(board.symbol(variable).unwrap().address, 4 * N).unwrap();
    std::array::from_fn(|n| u32::from_le_bytes(bytes[4 * n..4 * n + 4].try_into().unwrap()))
}

/// One board of a test.
#[derive(Clone, Copy, Debug)]
pub struct BoardSetup {
    /// Node-ID, 1 is the master.
    pub node: u8,
    /// Name of its board.
    pub board: &'static str,
    /// Error of the crystal, parts per million.
    pub ppm: f64,
    /// Metres from the left end of both wires.
    pub position_m: f64,
    /// Time of its power-on, ms.
    pub power_on_ms: u64,
    /// Whether the parity strap is correct.
    pub parity: bool,
}

impl BoardSetup {
    /// Returns the configuration with the shipped images, profile `librecube`.
    pub fn config(self) -> BoardConfig {
        self.with(match self.board {
            PYBOARD_V11 => &PYBOARD,
            NUCLEO_F446RE => &NUCLEO,
            _ => &DISCOVERY,
        })
    }

    /// Returns the configuration with these images.
    pub fn with(self, [master, slave]: &Images) -> BoardConfig {
        let image = if self.node == MASTER { master } else { slave };
        BoardConfig {
            name: format!("node {}", self.node),
            straps: self.straps(),
            crystal: Crystal::ppm(self.ppm),
            position_m: self.position_m,
            power_on_at: ms(self.power_on_ms),
            ..bare(self.board, image.clone())
        }
    }

    /// Returns the straps: bits 0 to 3, then odd parity, on the pins of `docs/wiring.md`. A closed strap is tied to
    /// ground. The master's image reads none.
    fn straps(self) -> Vec<(Pin, bool)> {
        if self.node == MASTER {
            return Vec::new();
        }
        let pins = match self.board {
            PYBOARD_V11 => [('A', 2), ('A', 3), ('A', 4), ('A', 5), ('A', 6)],
            NUCLEO_F446RE => [('C', 0), ('C', 1), ('C', 2), ('C', 3), ('B', 0)],
            _ => [('E', 7), ('E', 8), ('E', 9), ('E', 10), ('E', 11)],
        };
        let even = self.node.count_ones().is_multiple_of(2);
        let parity = (even == self.parity).then_some(4);
        let closed = (0..4).filter(|bit| self.node >> bit & 1 == 1).chain(parity);
        closed.map(|strap| pins[strap]).map(|(port, number)| (Pin::new(port, number), false)).collect()
    }
}

/// The master at the left end and its slaves 2, 3 and 4 (selective access).
pub const MASTER_AND_THREE: [BoardSetup; 4] = [
    BoardSetup { node: 1, board: PYBOARD_V11, ppm: 12.0, position_m: 0.0, power_on_ms: 20, parity: true },
    BoardSetup { node: 2, board: PYBOARD_V11, ppm: -31.0, position_m: 4.0, power_on_ms: 110, parity: true },
    BoardSetup { node: 3, board: PYBOARD_V11, ppm: 48.0, position_m: 11.5, power_on_ms: 60, parity: true },
    BoardSetup { node: 4, board: PYBOARD_V11, ppm: -50.0, position_m: 23.0, power_on_ms: 230, parity: true },
];

/// Position between the master and all slaves.
pub const NEXT_TO_MASTER_M: f64 = 0.5;

/// A frame that completed.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    pub bus: Bus,
    /// Start of SOF at the sender. `end` is the end of EOF there.
    pub start: Time,
    pub end: Time,
    /// Index of its sender, a board or a guest, on the wire.
    pub sender: usize,
    pub frame: WireFrame,
    /// Nodes that received it, ascending; guests are left out.
    pub reached: Vec<u8>,
}

impl Seen {
    /// The identifier of an 11-bit data frame, `None` for any other.
    pub fn id(&self) -> Option<u16> {
        match self.frame.id {
            WireId::Standard(id) if !self.frame.remote => Some(id),
            _ => None,
        }
    }

    pub fn data(&self) -> &[u8] {
        self.frame.payload()
    }
}

/// Record of a flight.
#[derive(Clone)]
pub struct Recording {
    setups: Vec<BoardSetup>,
    /// Frames that completed, in the order of their ends.
    pub frames: Vec<Seen>,
    /// Everything on the wires, as recorded.
    pub records: Vec<WireRecord>,
    pub logs: Vec<LogRecord>,
    /// End of the record.
    pub end: Time,
}

/// The spacecraft and its record so far.
#[derive(Clone)]
pub struct Flight {
    pub twin: Spacecraft,
    pub seen: Recording,
}

impl Deref for Flight {
    type Target = Recording;
    fn deref(&self) -> &Recording {
        &self.seen
    }
}

impl Recording {
    pub fn board(&self, node: u8) -> BoardId {
        BoardId(self.setups.iter().position(|setup| setup.node == node).unwrap())
    }

    /// Returns the data frames with an identifier that `node` sent on `bus`.
    pub fn sent(&self, node: u8, bus: Bus, id: u16) -> impl Iterator<Item = &Seen> {
        self.of(node).filter(move |seen| seen.bus == bus && seen.id() == Some(id))
    }

    /// Returns the frames that `node` sent on either bus.
    pub fn of(&self, node: u8) -> impl DoubleEndedIterator<Item = &Seen> {
        let sender = self.board(node).0;
        self.frames.iter().filter(move |seen| seen.sender == sender)
    }

    /// Returns the data frames with an identifier on either bus, from any sender.
    pub fn with_id(&self, id: u16) -> impl DoubleEndedIterator<Item = &Seen> {
        self.frames.iter().filter(move |seen| seen.id() == Some(id))
    }

    /// Returns the frames that completed on `bus`.
    pub fn on(&self, bus: Bus) -> impl Iterator<Item = &Seen> {
        self.frames.iter().filter(move |seen| seen.bus == bus)
    }

    /// Returns the heartbeats and boot-up messages of `node` on `bus`: their ends and their states.
    pub fn heartbeats(&self, node: u8, bus: Bus) -> Vec<(Time, u8)> {
        self.sent(node, bus, 0x700 + u16::from(node)).map(|seen| (seen.end, seen.data()[0])).collect()
    }

    /// Returns the ends of failed attempts of `node` on `bus`.
    pub fn attempts(&self, node: u8, bus: Bus) -> impl Iterator<Item = Time> {
        let sender = self.board(node).0;
        self.records.iter().filter(move |record| record.bus == bus).filter_map(move |record| {
            match record.record {
                Observation::Destroyed { transmitter, at, .. } if transmitter == sender => Some(at),
                _ => None,
            }
        })
    }

    /// Returns whether the last heartbeat of `node` is recent, was sent on `bus`, and has the state Operational.
    pub fn is_operational(&self, node: u8, bus: Bus) -> bool {
        let id = 0x700 + u16::from(node);
        self.of(node).rfind(|seen| seen.id() == Some(id)).is_some_and(|seen| {
            seen.bus == bus && seen.data() == [OPERATIONAL] && self.end.since(seen.end) < ms(300)
        })
    }

    /// Asserts that these nodes are operational on `bus`.
    #[track_caller]
    pub fn assert_operational(&self, nodes: impl IntoIterator<Item = u8>, bus: Bus) {
        for node in nodes {
            assert!(
                self.is_operational(node, bus),
                "node {node} at {:?} on {bus:?}\n{}",
                self.end,
                self.log(node)
            );
        }
    }

    /// Asserts that these nodes sent no heartbeat with the state Pre-operational after `from`.
    #[track_caller]
    pub fn assert_kept_running(&self, nodes: impl IntoIterator<Item = u8>, from: Time) {
        for node in nodes {
            assert!(!self.fell_back(node, from), "node {node} after {from:?}\n{}", self.log(node));
        }
    }

    /// Asserts that `node` neither sent, nor tried to send, nor acknowledged a frame after `from`.
    #[track_caller]
    pub fn assert_absent(&self, node: u8, from: Time) {
        let took_part = |seen: &&Seen| seen.end > from && seen.reached.contains(&node);
        assert_eq!(self.frames.iter().find(took_part), None, "node {node} acknowledges");
        assert_eq!(self.driven(node, from), 0, "node {node} sends\n{}", self.log(node));
    }

    /// Returns how often `node` started to send after `from`: frames and attempts on both buses.
    pub fn driven(&self, node: u8, from: Time) -> usize {
        let attempts = Bus::ALL.into_iter().flat_map(|bus| self.attempts(node, bus));
        self.of(node).filter(|seen| seen.start > from).count() + attempts.filter(|at| *at > from).count()
    }

    /// Returns the data of the emergencies of `node` after `from`, on either bus. A node repeats its emergencies when
    /// it finds a master.
    pub fn emergencies(&self, node: u8, from: Time) -> impl Iterator<Item = &[u8]> {
        let id = Some(0x080 + u16::from(node));
        self.of(node).filter(move |seen| seen.id() == id && seen.end > from).map(Seen::data)
    }

    /// Returns whether `node` sent a heartbeat with the state Pre-operational after `from`, on either bus.
    pub fn fell_back(&self, node: u8, from: Time) -> bool {
        let all = Bus::ALL.into_iter().flat_map(|bus| self.heartbeats(node, bus));
        all.into_iter().any(|(at, state)| at > from && state == PRE_OPERATIONAL)
    }

    /// Returns the first frame after `from` for which `what` holds.
    pub fn first_after(&self, from: Time, what: impl Fn(&Seen) -> bool) -> Option<&Seen> {
        self.frames.iter().find(|seen| seen.end > from && what(seen))
    }

    /// Returns the time of the first log line of `node` after `from` that contains `text`.
    pub fn said(&self, node: u8, text: &str, from: Time) -> Option<Time> {
        let board = self.board(node);
        let line =
            self.logs.iter().find(|log| log.board == board && log.at > from && log.text.contains(text));
        line.map(|log| log.at)
    }

    /// Asserts that `node` logged a line with `text` after `from`, and returns the time of the first one.
    #[track_caller]
    pub fn assert_said(&self, node: u8, text: &str, from: Time) -> Time {
        self.said(node, text, from)
            .unwrap_or_else(|| panic!("node {node} has not said {text:?}, but\n{}", self.log(node)))
    }

    /// Returns the log of `node`, for messages of failed tests.
    pub fn log(&self, node: u8) -> String {
        let board = self.board(node);
        let lines = self.logs.iter().filter(|log| log.board == board);
        lines.map(|log| format!("{:>12} us  {}\n", log.at.as_us(), log.text)).collect()
    }
}

impl Flight {
    /// Makes boards with the images of profile `librecube`.
    pub fn new(setups: &[BoardSetup]) -> Flight {
        Flight::of(setups, |setup| setup.config())
    }

    /// Makes boards with these images.
    pub fn with(setups: &[BoardSetup], images: &Images) -> Flight {
        Flight::of(setups, |setup| setup.with(images))
    }

    /// Makes boards with the images of profile `librecube`, and a foreign controller at the end of `bus`.
    pub fn with_guest(setups: &[BoardSetup], bus: Bus) -> (Flight, GuestId) {
        let mut flight = Flight::new(setups);
        let guest = flight.twin.add_guest(bus, 30.0);
        (flight, guest)
    }

    /// Makes boards with the `fittings` of each node.
    pub fn fitted(setups: &[BoardSetup], fittings: impl Fn(u8) -> Fittings) -> Flight {
        Flight::of(setups, |setup| BoardConfig { fittings: fittings(setup.node), ..setup.config() })
    }

    /// Makes boards with the configurations that `config` makes from their setups.
    pub fn of(setups: &[BoardSetup], config: impl Fn(BoardSetup) -> BoardConfig) -> Flight {
        let mut twin = Spacecraft::new(SpacecraftConfig::default());
        for setup in setups {
            twin.add_board(config(*setup));
        }
        let seen = Recording {
            setups: setups.to_vec(),
            frames: Vec::new(),
            records: Vec::new(),
            logs: Vec::new(),
            end: Time::ZERO,
        };
        Flight { twin, seen }
    }

    /// Flies to `until` milliseconds. No board may access missing hardware.
    pub fn fly_to(&mut self, until_ms: u64) {
        self.fly(ms(until_ms));
    }

    /// Flies to `until`.
    pub fn fly(&mut self, until: Time) {
        self.twin.run_until(until).unwrap();
        self.seen.end = until;
        self.seen.logs.extend(self.twin.take_logs());
        for wire in self.twin.take_frames() {
            if let Observation::Completed { trace, receivers, .. } = &wire.record {
                let boards = receivers.iter().filter_map(|(index, _)| self.setups.get(*index));
                let mut reached: Vec<u8> = boards.map(|setup| setup.node).collect();
                reached.sort_unstable();
                self.seen.frames.push(Seen {
                    bus: wire.bus,
                    start: trace.start,
                    end: trace.end,
                    sender: trace.transmitter,
                    frame: trace.frame,
                    reached,
                });
            }
            self.seen.records.push(wire);
        }
    }

    /// Flies until the nominal bus breaks next to the master at `cut`, and on to `end_ms`. Nothing may be lost.
    pub fn cut_next_to_master(mut self, cut: Time, end_ms: u64) -> Recording {
        self.fly(cut);
        self.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        self.fly_to(end_ms);
        self.assert_nothing_lost();
        self.seen
    }

    /// Flies in small steps until a frame completes for which `what` holds, which it returns.
    ///
    /// # Panics
    /// When none does within a second.
    pub fn fly_until(&mut self, what: impl Fn(&Seen) -> bool) -> Seen {
        let patience = self.end + ms(1000);
        while self.end < patience {
            let known = self.frames.len();
            self.fly(self.end + Time::from_us(10));
            if let Some(seen) = self.frames[known..].iter().find(|seen| what(seen)) {
                return seen.clone();
            }
        }
        panic!("nothing like that happened until {} us", self.end.as_us())
    }

    /// Sends an SDO request from a guest, and returns the answer of `node`.
    pub fn ask(&mut self, guest: GuestId, node: u8, request: [u8; 8]) -> [u8; 8] {
        self.twin.inject(guest, self.end, WireFrame::standard(0x600 + u16::from(node), &request));
        let id = Some(0x580 + u16::from(node));
        let answer = self.fly_until(|seen| seen.bus == guest.bus && seen.id() == id);
        answer.data().try_into().unwrap()
    }

    /// Returns the emulated board of `node`.
    pub fn emulated(&self, node: u8) -> &EmulatedBoard {
        self.twin.board(self.board(node))
    }

    /// Returns the emulated board of `node` for changes.
    pub fn emulated_mut(&mut self, node: u8) -> &mut EmulatedBoard {
        let board = self.board(node);
        self.twin.board_mut(board)
    }

    /// Resets `node` by its pin.
    pub fn reset(&mut self, node: u8) {
        let board = self.board(node);
        self.twin.reset(board);
    }

    /// Returns the number of frames since the last reset that passed the filters of `node` and were never handled.
    pub fn lost_frames(&self, node: u8) -> u64 {
        self.emulated(node).admitted() - self.diagnostics(node).frames()
    }

    /// Returns the counters of the image of `node` since its last reset.
    pub fn diagnostics(&self, node: u8) -> Diagnostics {
        Diagnostics::read(self.emulated(node)).unwrap()
    }

    /// Returns the number of commands since the last reset that `node` executed, or that the application of the master
    /// sent.
    pub fn executed(&self, node: u8) -> u32 {
        self.counters(node).commands
    }

    /// Returns the number of commands that slave `node` dropped as repeats since its last reset.
    pub fn repeats(&self, node: u8) -> u32 {
        self.counters(node).repeats
    }

    fn counters(&self, node: u8) -> Counters {
        Counters::read(self.emulated(node)).unwrap().unwrap()
    }

    /// Asserts that no board panicked, locked up, stopped, or was reset by its program.
    pub fn assert_sound(&self) {
        for (id, board) in self.twin.boards() {
            let (name, log) = (&board.config().name, self.log(self.setups[id.0].node));
            let counters = board.counters();
            let faults = (counters.panics, counters.lockups, counters.malformed_logs);
            assert_eq!((board.state(), faults), (&State::Running, (0, 0, 0)), "{name}\n{log}");
        }
    }

    /// Asserts that the boards are sound, and that no frame that passed a filter was lost before the node. It is for
    /// flights without resets.
    ///
    /// A frame takes time from the wire to the node. The flight therefore continues until the buses were quiet for a
    /// millisecond.
    pub fn assert_nothing_lost(&mut self) {
        self.assert_sound();
        let quiet = |flight: &Flight| {
            let last = flight.frames.last().map_or(Time::ZERO, |seen| seen.end);
            flight.twin.now() > last + ms(1)
        };
        while !quiet(self) {
            self.fly(self.twin.now() + Time::from_us(500));
        }
        for setup in &self.seen.setups {
            assert_eq!(self.lost_frames(setup.node), 0, "node {}", setup.node);
        }
    }
}

/// Returns the data of the last telemetry of `node` on the nominal bus with this code.
pub fn telemetry(flight: &Flight, node: u8, code: u16) -> Vec<u8> {
    let replies = flight.sent(node, Bus::Nominal, 0x380 + u16::from(node));
    let last = replies.filter(|seen| seen.data()[..2] == code.to_le_bytes()).last();
    last.unwrap().data()[2..].to_vec()
}

/// Asserts that the next telemetry request after `from` for which `is_asked` holds reaches `node` on `bus`, and is
/// answered there within 2 ms.
pub fn assert_replies(flight: &Recording, node: u8, bus: Bus, from: Time, is_asked: impl Fn(&[u8]) -> bool) {
    let [request, reply] = [0x400, 0x380].map(|function| Some(function + u16::from(node)));
    let request = flight.first_after(from, |seen| seen.id() == request && is_asked(seen.data())).unwrap();
    let reply = flight.first_after(request.end, |seen| seen.id() == reply).unwrap();
    assert_eq!((request.bus, reply.bus), (bus, bus), "node {node}");
    assert!(reply.end < request.end + ms(2), "node {node} at {} us", request.end.as_us());
    assert_eq!(reply.data()[..2], request.data()[..2], "node {node}");
}

/// Converts milliseconds to a time.
pub const fn ms(milliseconds: u64) -> Time {
    Time::from_ms(milliseconds)
}

/// Returns the differences between consecutive times.
pub fn gaps(times: &[Time]) -> impl Iterator<Item = Time> + '_ {
    times.windows(2).map(|pair| pair[1].since(pair[0]))
}

/// Returns the range of `span` ± `tolerance`.
pub fn about(span: Time, tolerance: Time) -> Range<Time> {
    span.since(tolerance)..span + tolerance
}
