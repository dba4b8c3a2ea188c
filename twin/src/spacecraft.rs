//! Any number of boards and their wires in one virtual time.
//!
//! Boards run one quantum after the other, then the wires follow and deliver frames. A quantum ends at the next event
//! of any wire, so a frame reaches its boards at its exact instant. Requests of a board inside a quantum carry their
//! instants. When every core sleeps, time jumps to the next event.
//!
//! A controller's mode handshakes and aborts settle at the end of a quantum, so a flight is reproducible for one length
//! of the quantum; another length shifts events after a handshake by some microseconds.

use crate::board::{AccessError, BoardConfig, EmulatedBoard, Uses};
use crate::bxcan::Side;
use crate::guest::{Guest, GuestEvent, Presence};
use crate::pin::Pin;
use crate::port::{BoardPort, LivePort};
use crate::rtt::Level;
use crate::wire::bus::{Wire, WireConfig};
use crate::wire::controller::Controllers;
use crate::wire::controller::{Controller, NodeIndex};
use crate::wire::frame::WireFrame;
use crate::wire::record::Observation;
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;
pub use crate::wiring::{Bus, Wiring};

/// A board of a spacecraft, in the order of [`Spacecraft::add_board`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BoardId(pub usize);

/// A foreign controller on one wire, [`Spacecraft::add_guest`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GuestId {
    /// The wire.
    pub bus: Bus,
    /// Its index there.
    pub node: NodeIndex,
}

/// Configuration that all boards share.
#[derive(Clone, Debug)]
pub struct SpacecraftConfig {
    /// Longest time that boards run ahead of the wires, 1 to 20 µs: shorter than any frame.
    pub quantum: Time,
    /// The cable of each bus.
    pub wires: [WireConfig; Bus::COUNT],
}

impl Default for SpacecraftConfig {
    fn default() -> Self {
        SpacecraftConfig { quantum: Time::from_us(20), wires: [WireConfig::default(); Bus::COUNT] }
    }
}

/// External event of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Power is switched on or off.
    Power(bool),
    /// The reset pin is pulled.
    Reset,
    /// The supply falls below the threshold of the brown-out reset for a moment.
    BrownOut,
    /// The harness ties a pin to a level, or lets it float.
    Drive(Pin, Option<bool>),
}

/// A log line of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogRecord {
    /// Instant at which the probe read it, at most a quantum after the program wrote it.
    pub at: Time,
    /// Board that logged it.
    pub board: BoardId,
    /// `None` for `defmt::println!`.
    pub level: Option<Level>,
    /// The message.
    pub text: String,
}

/// Event on a wire.
#[derive(Clone, Debug, PartialEq)]
pub struct WireRecord {
    /// End of the event.
    pub at: Time,
    /// Bus on which it occurred.
    pub bus: Bus,
    /// The event.
    pub record: Observation,
}

/// Boards on their wires.
#[derive(Clone, Debug)]
pub struct Spacecraft {
    now: Time,
    quantum: Time,
    boards: Vec<EmulatedBoard>,
    wires: [Wire; Bus::COUNT],
    ports: [Vec<BoardPort>; Bus::COUNT],
    /// Guests of each bus; their indices follow those of the ports.
    guests: [Vec<Guest>; Bus::COUNT],
    /// Bus and index of the transceivers of CAN1 and CAN2 of each board.
    places: Vec<[Option<(Bus, NodeIndex)>; 2]>,
    /// Scheduled events, the earliest last.
    events: Vec<(Time, BoardId, Event)>,
    logs: Vec<LogRecord>,
}

struct OnWire<'a> {
    boards: &'a mut [EmulatedBoard],
    ports: &'a mut [BoardPort],
    guests: &'a mut [Guest],
}

impl Controllers for OnWire<'_> {
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller)) {
        match self.ports.get_mut(node) {
            Some(port) => {
                let peripherals = self.boards[port.board].peripherals_mut();
                visit(&mut LivePort { port, peripherals });
            }
            None => visit(&mut self.guests[node - self.ports.len()]),
        }
    }
}

impl Spacecraft {
    /// Wires without boards at time zero.
    ///
    /// # Panics
    /// When the quantum is not 1 to 20 µs: a mistake in a test, not an input.
    pub fn new(config: SpacecraftConfig) -> Self {
        let us = Time::from_us(1)..=Time::from_us(20);
        assert!(us.contains(&config.quantum), "the quantum is 1 to 20 us, not {:?}", config.quantum);
        Spacecraft {
            now: Time::ZERO,
            quantum: config.quantum,
            boards: Vec::new(),
            wires: config.wires.map(Wire::new),
            ports: Default::default(),
            guests: Default::default(),
            places: Vec::new(),
            events: Vec::new(),
            logs: Vec::new(),
        }
    }

    /// Connects a board to the wires of its wiring, both by default. It is powered on at its configured instant. While
    /// every board has the default wiring, its index on both wires is its [`BoardId`].
    ///
    /// # Panics
    /// When its crystal is more than 1000 ppm off, or a guest is on one of its wires already.
    pub fn add_board(&mut self, config: BoardConfig) -> BoardId {
        let id = BoardId(self.boards.len());
        let BoardConfig { power_on_at, position_m, fittings, .. } = config;
        let board = EmulatedBoard::new(config, id.0 as u32 + 1);
        let mut places = [None; 2];
        for plug in fittings.plugs() {
            let bus = plug.bus;
            assert!(self.guests[bus as usize].is_empty(), "boards come before guests");
            self.ports[bus as usize].push(BoardPort::new(id.0, plug));
            let wire = &mut self.wires[bus as usize];
            let node = match fittings.transceiver {
                Some(transceiver) => wire.attach_through(position_m, transceiver),
                None => wire.attach(position_m),
            };
            places[plug.transceiver as usize] = Some((bus, node));
        }
        self.places.push(places);
        self.boards.push(board);
        self.schedule(power_on_at, id, Event::Power(true));
        id
    }

    /// Returns the present bus of a board's controller, and its index there.
    pub fn place(&self, board: BoardId, side: Side) -> Option<(Bus, NodeIndex)> {
        self.places[board.0][self.boards[board.0].transceiver(side)? as usize]
    }

    /// Returns the bit timing of a board's controller on a bus, by the board's crystal; `None` while it does not take
    /// part there.
    pub fn bit_timing(&self, board: BoardId, bus: Bus) -> Option<BitTiming> {
        let sides = [Side::Can1, Side::Can2].into_iter();
        let mut here = sides.filter(|side| self.place(board, *side).is_some_and(|(wire, _)| wire == bus));
        here.find_map(|side| self.boards[board.0].bit_timing(side))
    }

    /// Connects a foreign controller to one wire: 1 Mbit/s, no filters, acknowledges everything. All boards come first.
    pub fn add_guest(&mut self, bus: Bus, position_m: f64) -> GuestId {
        self.add_guest_at(bus, position_m, BitTiming::MEGABIT)
    }

    /// As [`Spacecraft::add_guest`], with another bit timing.
    pub fn add_guest_at(&mut self, bus: Bus, position_m: f64, timing: BitTiming) -> GuestId {
        self.guests[bus as usize].push(Guest::new(timing));
        GuestId { bus, node: self.wires[bus as usize].attach(position_m) }
    }

    /// Makes a guest send `frame` at `at`, after all frames requested before.
    ///
    /// # Panics
    /// When there is no such guest.
    pub fn inject(&mut self, guest: GuestId, at: Time, frame: WireFrame) {
        let at = at.max(self.now + Time(1));
        self.guest_mut(guest).waiting.push_back((at, frame));
    }

    /// Changes how a guest takes part from now on. Frames that it has not sent yet are dropped unless it is
    /// [`Presence::Present`].
    ///
    /// # Panics
    /// When there is no such guest.
    pub fn set_presence(&mut self, guest: GuestId, presence: Presence) {
        self.guest_mut(guest).become_present(presence);
    }

    /// Takes the frames that a guest received and sent since the last call, in chronological order. They accumulate
    /// without calls.
    ///
    /// # Panics
    /// When there is no such guest.
    pub fn take_heard(&mut self, guest: GuestId) -> Vec<(Time, GuestEvent)> {
        std::mem::take(&mut self.guest_mut(guest).heard)
    }

    fn guest_mut(&mut self, guest: GuestId) -> &mut Guest {
        let ports = self.ports[guest.bus as usize].len();
        &mut self.guests[guest.bus as usize][guest.node - ports]
    }

    /// Returns the present.
    pub fn now(&self) -> Time {
        self.now
    }

    /// All boards, in the order of their ids.
    pub fn boards(&self) -> impl Iterator<Item = (BoardId, &EmulatedBoard)> {
        self.boards.iter().enumerate().map(|(n, board)| (BoardId(n), board))
    }

    /// A board.
    pub fn board(&self, id: BoardId) -> &EmulatedBoard {
        &self.boards[id.0]
    }

    /// A board, to take its pin changes.
    pub fn board_mut(&mut self, id: BoardId) -> &mut EmulatedBoard {
        &mut self.boards[id.0]
    }

    /// A wire.
    pub fn wire(&self, bus: Bus) -> &Wire {
        &self.wires[bus as usize]
    }

    /// A wire, to cut or to schedule a cut.
    pub fn wire_mut(&mut self, bus: Bus) -> &mut Wire {
        &mut self.wires[bus as usize]
    }

    /// Schedules `event` of a board at `at`, or at once if that is past. Events at the same instant occur in the order
    /// of the calls.
    pub fn schedule(&mut self, at: Time, board: BoardId, event: Event) {
        let place = self.events.partition_point(|&(other, ..)| other > at);
        self.events.insert(place, (at, board, event));
    }

    /// Pulls the reset pin of a board now.
    pub fn reset(&mut self, board: BoardId) {
        self.schedule(self.now, board, Event::Reset);
    }

    /// Lets the supply of a board fall below the threshold of the brown-out reset now, for a moment.
    pub fn brown_out(&mut self, board: BoardId) {
        self.schedule(self.now, board, Event::BrownOut);
    }

    /// Switches the power of a board now.
    pub fn power(&mut self, board: BoardId, on: bool) {
        self.schedule(self.now, board, Event::Power(on));
    }

    /// Takes the log lines since the last call, in chronological order.
    pub fn take_logs(&mut self) -> Vec<LogRecord> {
        let mut logs = std::mem::take(&mut self.logs);
        logs.sort_by_key(|log| log.at);
        logs
    }

    /// Takes the events of all wires since the last call, in chronological order.
    pub fn take_frames(&mut self) -> Vec<WireRecord> {
        let mut records: Vec<_> = Bus::NETWORKS
            .into_iter()
            .flat_map(|bus| {
                let records = self.wires[bus as usize].take_records();
                records.into_iter().map(move |record| WireRecord { at: record.at(), bus, record })
            })
            .collect();
        records.sort_by_key(|record| record.at);
        records
    }

    /// Runs everything until `until`.
    ///
    /// # Errors
    /// [`AccessError`] when a program made an access that the model refuses. Its board stays stopped, the others have
    /// run up to the same instant. A further call continues without it.
    pub fn run_until(&mut self, until: Time) -> Result<(), AccessError> {
        self.apply_events();
        while self.now < until {
            let next = self.next_stop().min(until);
            let mut failure = None;
            for board in &mut self.boards {
                failure = failure.or(board.run_until(next).err());
            }
            Bus::NETWORKS.into_iter().for_each(|bus| self.advance_wire(bus, next));
            self.now = next;
            self.settle();
            self.apply_events();
            failure.map_or(Ok(()), Err)?;
        }
        Ok(())
    }

    /// Returns the instant until which boards and wires may run independently.
    fn next_stop(&self) -> Time {
        let boards = self.boards.iter().map(|board| match board.next_event() {
            at if at <= self.now => self.now + self.quantum,
            at => at,
        });
        let wires = self.wires.iter().filter_map(Wire::next_event);
        let events = self.events.last().map(|&(at, ..)| at);
        // A wire handles a request when it is advanced.
        let guests = self.guests.iter().flatten().filter_map(Guest::request_at).filter(|at| *at > self.now);
        let next = boards.chain(wires).chain(events).chain(guests).min().unwrap_or(Time::NEVER);
        next.max(self.now + Time(1))
    }

    /// Advances a wire to `until`.
    fn advance_wire(&mut self, bus: Bus, until: Time) {
        let (ports, guests) = (&mut self.ports[bus as usize], &mut self.guests[bus as usize]);
        let boards = &mut self.boards;
        self.wires[bus as usize].advance(until, &mut OnWire { boards, ports, guests });
        for port in ports {
            let board = &mut self.boards[port.board];
            board.can_rx_edges(port.plug.controller, port.changes.drain(..));
        }
    }

    /// Updates the boards after the wires have reached their time.
    fn settle(&mut self) {
        for (node, board) in self.boards.iter_mut().enumerate() {
            let is_idle = |(bus, node): (Bus, NodeIndex)| self.wires[bus as usize].is_idle(node);
            let place = |side| self.places[node][board.transceiver(side)? as usize];
            let idle = [Side::Can1, Side::Can2].map(|side| place(side).map(is_idle));
            board.settle(self.now, idle);
            let id = BoardId(node);
            self.logs.extend(board.take_log().into_iter().map(|line| LogRecord {
                // A core completes its instruction, beyond the end of the quantum.
                at: line.at.min(self.now),
                board: id,
                level: line.level,
                text: line.text,
            }));
        }
    }

    /// Returns whether this copy of a spacecraft continues exactly as another one. `later`: uses of the boards of the other copy from now
    /// to the end of the time in question; boards without uses are compared as a whole ([`EmulatedBoard::continues_as`]). Records and
    /// logs have to be taken before.
    pub fn continues_as(&self, other: &Spacecraft, later: &[Uses]) -> bool {
        let surroundings = |craft: &Spacecraft| {
            let wires = craft.wires.each_ref().map(Wire::without_totals);
            format!("{:?}", (wires, &craft.ports, &craft.guests, &craft.events))
        };
        let mut boards = self.boards.iter().zip(&other.boards).enumerate();
        self.now == other.now
            && self.boards.len() == other.boards.len()
            && boards.all(|(n, (board, other))| board.continues_as(other, later.get(n)))
            && surroundings(self) == surroundings(other)
    }

    fn apply_events(&mut self) {
        while let Some((_, id, event)) = self.events.pop_if(|&mut (at, ..)| at <= self.now) {
            let board = &mut self.boards[id.0];
            match event {
                Event::Power(on) => board.power(on),
                Event::Reset => board.reset(),
                Event::BrownOut => board.brown_out(),
                Event::Drive(pin, level) => board.drive(pin, level),
            }
        }
    }
}
