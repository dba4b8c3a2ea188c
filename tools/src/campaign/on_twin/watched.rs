//! Commands executed by a board, and its failures.

use can_twin::board::{EmulatedBoard, State};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::types::NodeId;
use ecss_can_worlds::NodeKey;

use crate::images::support::counters::Counters;

/// Lifetime of a command. After it equal bytes are a new command.
const LIFETIME: Time = Time::from_ms(100);

/// State of a board for the campaign.
pub struct Watched {
    pub key: NodeKey,
    pub is_powered: bool,
    /// Number of panics and lock-ups.
    failures: u64,
    has_stopped: bool,
    /// Number of commands executed since its reset.
    executed: u32,
    /// Number of received commands that may still be executed.
    pending: u32,
    /// The last command and its instant.
    last: Option<(WireFrame, Time)>,
}

impl Watched {
    /// Makes the state of a board with power.
    pub fn new(key: NodeKey) -> Watched {
        Watched {
            key,
            is_powered: true,
            failures: 0,
            has_stopped: false,
            executed: 0,
            pending: 0,
            last: None,
        }
    }

    /// Handles a start of the board: it has no last command.
    pub fn on_start(&mut self) {
        self.last = None;
    }

    /// Handles a received command. A repeat of the last one must not be executed.
    pub fn on_command(&mut self, frame: &WireFrame, at: Time) {
        let is_repeat = self.last.is_some_and(|(last, then)| last == *frame && at <= then + LIFETIME);
        self.pending += u32::from(!is_repeat);
        self.last = Some((*frame, at));
    }

    /// Returns violations since the last call: panics, a stop, commands executed more often than received.
    pub fn look(&mut self, board: &EmulatedBoard, at: Time) -> Vec<String> {
        let at = at.as_us();
        let name = &board.config().name;
        let mut wrongs = Vec::new();
        let counters = board.counters();
        let failures = counters.panics + counters.lockups;
        if failures > self.failures {
            wrongs.push(format!("{name} panicked, {at} us"));
            self.failures = failures;
        }
        let stops = !matches!(board.state(), State::Running | State::Off);
        if stops && !self.has_stopped {
            wrongs.push(format!("{name} stopped: {:?}, {at} us", board.state()));
            self.has_stopped = true;
        }
        if self.key.node() != NodeId::MASTER {
            let executed = executed(board);
            let new = executed.checked_sub(self.executed).unwrap_or(executed);
            self.executed = executed;
            if new > self.pending {
                wrongs.push(format!("{name} executed {new} of {} commands, {at} us", self.pending));
            }
            // One command may be between the wire and the application.
            self.pending = self.pending.saturating_sub(new).min(1);
        }
        wrongs
    }
}

fn executed(board: &EmulatedBoard) -> u32 {
    Counters::read(board).ok().flatten().map_or(0, |counters| counters.commands)
}
