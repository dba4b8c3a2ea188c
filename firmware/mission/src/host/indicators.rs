//! Indicators of a board as lines.

use ecss_can::types::{Duration, Instant};

use super::Console;
use crate::Indicators;

/// Least time between two lines of an LED that toggles.
const PERIOD: Duration = Duration::from_millis(1_000);

/// The LEDs and the reset of a board, as lines of a [`Console`].
#[derive(Debug)]
pub struct PrintedIndicators {
    console: Console,
    sync: Blinking,
    heartbeat: Blinking,
    time: Blinking,
    state: bool,
}

/// An LED that toggles with every message of one kind.
#[derive(Debug, Default)]
struct Blinking {
    toggles: u32,
    /// Instant of the next line.
    next: Instant,
}

impl PrintedIndicators {
    /// Makes the indicators of a board. All LEDs are dark.
    pub fn new(console: &Console) -> PrintedIndicators {
        PrintedIndicators {
            console: console.clone(),
            sync: Blinking::default(),
            heartbeat: Blinking::default(),
            time: Blinking::default(),
            state: false,
        }
    }
}

impl Blinking {
    fn toggle(&mut self, name: &str, console: &Console) {
        self.toggles += 1;
        if self.next <= console.time() {
            console.line("indicators", format_args!("{name} LED, toggles: {}", self.toggles));
            *self = Blinking { toggles: 0, next: console.time() + PERIOD };
        }
    }
}

impl Indicators for PrintedIndicators {
    fn sync(&mut self) {
        self.sync.toggle("SYNC", &self.console);
    }

    fn heartbeat(&mut self) {
        self.heartbeat.toggle("heartbeat", &self.console);
    }

    fn time(&mut self) {
        self.time.toggle("spacecraft time", &self.console);
    }

    fn state(&mut self, on: bool) {
        if core::mem::replace(&mut self.state, on) != on {
            self.console.line("indicators", if on { "state LED on" } else { "state LED off" });
        }
    }

    fn reset(&mut self) {
        self.console.line("indicators", "reset of the chip");
    }
}
