//! Causes for which the clock of a slave is not judged.

use std::fmt;

use can_twin::wire::time::Time;

use super::narrator::name;
use super::record::Node;

/// Cause for which a clock is not judged. `since`: last reset of the slave or of a master, zero without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unjudged {
    /// No master sent the spacecraft time.
    NotSent {
        /// Last reset.
        since: Time,
    },
    /// The slave received none of the spacecraft times.
    NotReceived {
        /// Last reset.
        since: Time,
    },
    /// The slave received the spacecraft time, but never as operational.
    NotOperational {
        /// Last reset.
        since: Time,
    },
    /// A board has no pin for a pulse at the seconds of the spacecraft time.
    NoPin {
        /// The slave, or the master.
        board: Node,
    },
    /// A board made no pulse after the clock was set.
    NoPulse {
        /// The slave, or the master.
        board: Node,
        /// Time at which the clock was set.
        set: Time,
    },
    /// No pulse of the slave has a pulse of the master within half a second, or there is more than one.
    NoPair {
        /// Time at which the clock was set.
        set: Time,
    },
    /// The flight ended before the clock had settled.
    TooShort {
        /// Time at which the clock was set.
        set: Time,
        /// End of the flight.
        end: Time,
    },
}

impl Unjudged {
    /// Returns whether the slave may have no object for the spacecraft time: the time arrived, and the pulses do not follow it.
    pub fn may_lack_object(self) -> bool {
        matches!(self, Unjudged::NoPulse { .. } | Unjudged::NoPair { .. })
    }
}

/// Time after which a clock counts as settled.
pub const SETTLING: Time = Time::from_ms(20_000);

impl fmt::Display for Unjudged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let after = |since: &Time| {
            let since = since.as_secs_f64();
            if since > 0.0 { format!(" after the reset at {since:.1} s") } else { String::new() }
        };
        match self {
            Unjudged::NotSent { since } => {
                write!(f, "no master sent the spacecraft time (181h){}", after(since))
            }
            Unjudged::NotReceived { since } => {
                write!(f, "it received no spacecraft time (181h){}", after(since))
            }
            Unjudged::NotOperational { since } => write!(
                f,
                "it was not operational at any time at which it received the spacecraft time (181h){}",
                after(since)
            ),
            Unjudged::NoPin { board } => {
                write!(f, "the board of {} has no pin for a pulse at each second", name(*board))
            }
            Unjudged::NoPulse { board, set } => write!(
                f,
                "{} raised its pulse pin at no second of the spacecraft time after {:.1} s, when the clock was set",
                name(*board),
                set.as_secs_f64()
            ),
            Unjudged::NoPair { set } => write!(
                f,
                "none of its pulses after {:.1} s, when the clock was set, is the only one within 0.5 s of a pulse of the master",
                set.as_secs_f64()
            ),
            Unjudged::TooShort { set, end } => write!(
                f,
                "it was set at {:.1} s and the run ended at {:.1} s; it is judged from {} s after it was set",
                set.as_secs_f64(),
                end.as_secs_f64(),
                SETTLING.as_secs_f64()
            ),
        }
    }
}
