//! What a board executes, and whether it runs at all.

use can_wire::frame::WireFrame;
use can_wire::time::Time;
use ecss_can::types::NodeId;
use firmware_images::support::counters::Counters;
use host_worlds::NodeKey;
use twin::board::{EmulatedBoard, State};

/// A command with the bytes of the last one is another one after so long: its lifetime.
const LIFETIME: Time = Time::from_ms(100);

/// A board as the campaign follows it.
pub struct Watched {
    pub key: NodeKey,
    pub is_powered: bool,
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

impl Watched {
    /// A board with power.
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

    /// A board that starts has forgotten the last command.
    pub fn on_start(&mut self) {
        self.last = None;
    }

    /// A command reached it. A repeat of the last one is not to be executed.
    pub fn on_command(&mut self, frame: &WireFrame, at: Time) {
        let is_repeat = self.last.is_some_and(|(last, then)| last == *frame && at <= then + LIFETIME);
        self.pending += u32::from(!is_repeat);
        self.last = Some((*frame, at));
    }

    /// Violations since the last look: panics, a stop, commands that were executed more often than they came.
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
            // One may be between the wire and the application.
            self.pending = self.pending.saturating_sub(new).min(1);
        }
        wrongs
    }
}

fn executed(board: &EmulatedBoard) -> u32 {
    Counters::read(board).ok().flatten().map_or(0, |counters| counters.commands)
}
