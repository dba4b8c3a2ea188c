//! The state machine of a slave (CiA 301 7.3.2, ECSS 8.3.3), with any module control commands and any heartbeats.

use ecss_can::node::SlaveEvent;
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};
use ecss_can::types::{Duration, Instant, NmtState};
use ecss_can_worlds::judge::selector::is_toggled_too_often;

use super::node::{Bench, ID, bus, frame, profile};
use crate::fuzz::{Input, Signature};

const CONSUMER: Duration = Duration::from_millis(250);
/// Ttoggle consumer times.
const TOGGLING: Duration = Duration::from_millis(500);
const HEARTBEAT: Duration = Duration::from_millis(100);
/// Two consumer times. A reset within this time after a boot counts, unless the master was heard since.
const PAUSE: Duration = Duration::from_millis(500);
/// Resets that are obeyed in a row.
const ROW: u8 = 3;

const COMMANDS: [u8; 8] = [0x01, 0x02, 0x80, 0x81, 0x82, 0x01, 0x00, 0x83];
const TARGETS: [u8; 6] = [0, 5, 5, 6, 1, 0x85];

/// Model of the expected state.
struct Model {
    state: NmtState,
    autostart: bool,
    /// Last heartbeat of the master on the active bus since it was found.
    master: Option<Instant>,
    /// Instant until which a heartbeat must confirm an active bus that was found by a command only.
    unconfirmed: Option<Instant>,
    /// Start of the search.
    search: Instant,
    /// Instant of the last sent heartbeat.
    heartbeat: Instant,
    /// Resets in a row.
    row: u8,
    /// The last boot or ignored reset; `None` after a heartbeat of the master or the pause.
    reset: Option<Instant>,
}

impl Model {
    fn boot(&mut self, now: Instant) {
        self.state = if self.autostart { Operational } else { PreOperational };
        (self.master, self.unconfirmed, self.search, self.heartbeat) = (None, None, now, now);
        self.reset = Some(now);
    }

    /// Handles a valid heartbeat of the master on either bus.
    fn trust(&mut self) {
        (self.row, self.reset) = (0, None);
    }

    /// Returns whether a reset of this node is ignored, and counts it otherwise.
    fn ignores_reset(&mut self, now: Instant) -> bool {
        let is_shut = self.reset.is_some() && self.row == ROW;
        if is_shut {
            self.reset = Some(now);
        }
        is_shut
    }

    /// Advances time.
    fn run(&mut self, now: Instant) {
        if self.state == Initialising {
            return;
        }
        if self.reset.is_some_and(|since| now >= since + PAUSE) {
            self.trust();
        }
        if self.unconfirmed.is_some_and(|until| now >= until) {
            (self.state, self.unconfirmed) = (PreOperational, None);
        }
        match self.master {
            Some(last) if now >= last + CONSUMER => {
                (self.state, self.master, self.search) = (PreOperational, None, last);
            }
            None if self.unconfirmed.is_none() && now >= self.search + TOGGLING => {
                self.state = PreOperational
            }
            _ => {}
        }
    }

    /// Handles a message of the master that makes or keeps its bus active.
    fn hear_master(&mut self, is_heartbeat: bool, now: Instant) {
        if is_heartbeat {
            (self.master, self.unconfirmed) = (Some(now), None);
        } else if self.master.is_none() && self.unconfirmed.is_none() {
            self.unconfirmed = Some(now + CONSUMER);
        }
    }

    /// CiA 301 table 38: a command leads to its state from every other.
    fn command(&mut self, command: u8, now: Instant) {
        if command > 0x80 && self.reset.is_some() {
            self.row += 1;
        }
        match command {
            0x01 => self.state = Operational,
            0x02 => self.state = Stopped,
            0x80 => self.state = PreOperational,
            0x81 => self.state = Initialising,
            _ => self.boot(now),
        }
    }

    /// Checks the behaviour of a node in a step that began in the state `before`.
    fn check(&mut self, before: NmtState, bench: &Bench, signature: &mut Signature) {
        let now = bench.slave.status(bench.now);
        assert_eq!(now.state, self.state, "the state at {:?}", bench.now);
        assert!(!is_toggled_too_often(&now.redundancy), "{:?}", now.redundancy);
        signature.note(u32::from(before.byte()) << 8 | u32::from(now.state.byte()));
        signature
            .note(now.active as u32 | (bench.sent.len() as u32) << 8 | (bench.events.len() as u32) << 16);
        let heartbeats =
            bench.sent.iter().filter(|(_, frame)| frame.id().raw() == 0x700 + u16::from(ID.get()));
        for (bus, frame) in heartbeats {
            assert_eq!(*bus, now.active);
            let &[told] = frame.data() else { panic!("{frame:?}") };
            assert!(told == self.state.byte() || told == before.byte() || told == 0, "{told:02X} was told");
            self.heartbeat = bench.now;
        }
        let mut told = bench.events.iter().filter_map(|event| match event {
            SlaveEvent::State(state) => Some(*state),
            _ => None,
        });
        match told.next_back() {
            Some(state) => assert_eq!(state, self.state, "the last one told"),
            None => assert!(before == self.state || self.state == Initialising, "not told"),
        }
        if self.state == Initialising {
            assert!(bench.sent.is_empty(), "sent in Initialising: {:?}", bench.sent);
        } else {
            assert!(bench.now <= self.heartbeat + HEARTBEAT, "no heartbeat in time");
        }
    }
}

/// Runs an input. The first byte chooses the profile. An operation is a byte for its kind, and its arguments.
pub fn run(mut input: Input, signature: &mut Signature) {
    let profile = profile(input.byte());
    let mut bench = Bench::new(&profile);
    let mut model = Model {
        state: Initialising,
        autostart: profile.autostart,
        master: None,
        unconfirmed: None,
        search: bench.now,
        heartbeat: bench.now,
        row: 0,
        reset: None,
    };
    model.boot(bench.now);
    model.check(PreOperational, &bench, signature);
    while !input.is_empty() {
        let operation = input.byte() % 8;
        let before = model.state;
        match operation {
            0..=2 => {
                let on = bus(input.byte());
                let (command, target) = (input.pick(&COMMANDS), input.pick(&TARGETS));
                let dlc = match input.byte() {
                    odd @ 0xF0.. => odd % 9,
                    _ => 2,
                };
                let is_heard = profile.selective.is_empty() || on == bench.slave.status(bench.now).active;
                bench.receive(on, frame(0, dlc, [command, target, 0, 0, 0, 0, 0, 0]));
                let is_good = dlc == 2 && target <= 127 && ![0x00, 0x83].contains(&command);
                // Other tests check which bus is active when two masters are heard. A message on the other bus does not
                // count.
                let is_active = bench.slave.status(bench.now).active == on;
                let is_own = [0, ID.get()].contains(&target);
                let is_ignored = is_heard
                    && is_good
                    && is_own
                    && command > 0x80
                    && before != Initialising
                    && model.ignores_reset(bench.now);
                if is_heard && is_active && is_good && !is_ignored && before != Initialising {
                    model.hear_master(false, bench.now);
                    if is_own {
                        model.command(command, bench.now);
                    }
                }
            }
            3 | 4 => {
                let on = bus(input.byte());
                let (state, dlc) = (input.pick(&[5, 0, 4, 0x7F, 0x85, 6]), input.pick(&[1, 1, 1, 0, 2, 1]));
                let is_heard = profile.selective.is_empty() || on == bench.slave.status(bench.now).active;
                bench.receive(on, frame(0x701, dlc, [state; 8]));
                let is_active = bench.slave.status(bench.now).active == on;
                if is_heard && dlc == 1 && state != 6 && before != Initialising {
                    model.trust();
                    if is_active {
                        model.hear_master(true, bench.now);
                    }
                }
            }
            5 | 6 => {
                let span = Duration::from_micros(u64::from(input.byte()) * 2_000);
                bench.wait(span, |bench| {
                    let before = model.state;
                    model.run(bench.now);
                    model.check(before, bench, signature);
                });
                continue;
            }
            _ => {
                if before == Initialising {
                    // The chip is reset.
                    let now = bench.now;
                    bench = Bench::new(&profile);
                    // This board has no memory that survives a reset.
                    model.row = 0;
                    model.boot(bench.now);
                    model.check(Initialising, &bench, signature);
                    bench.wait(now.since(bench.now), |bench| {
                        let before = model.state;
                        model.run(bench.now);
                        model.check(before, bench, signature);
                    });
                } else {
                    let id = 0x080 | input.word() & 0x701;
                    bench.receive(
                        bus(input.byte()),
                        frame(if id == 0x701 { 0x700 } else { id }, input.byte() % 9, input.bytes()),
                    );
                    model.check(before, &bench, signature);
                }
                continue;
            }
        }
        model.check(before, &bench, signature);
    }
}
