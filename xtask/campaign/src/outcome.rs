//! What became of a run.

use ecss_can::types::Bus;
use host_worlds::{Time, World};

use crate::host::{disturbance, strange};
use crate::kind::Kind;
use crate::script::Script;

/// How long after a fault a change of state is counted as its effect.
const REACTION: Time = Time::from_ms(1_000);

/// What became of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// What must not happen and did.
    pub violations: Vec<String>,
    /// For each fault of the script: whether it changed a frame or a state.
    pub effective: Vec<bool>,
    /// From a fault to the change of the bus by the master, microseconds.
    pub detections: Vec<u64>,
}

/// Watches which faults change something.
///
/// A fault of a wire changes frames when more of them are destroyed or go unacknowledged there. A stranger and a
/// node that babbles change them by their own. A node that loses power or is reset has changed its state. Any other change of state counts within a second, as
/// long as no other fault may have caused it.
pub struct Effects {
    faults: Vec<Watched>,
}

struct Watched {
    kind: Kind,
    bus: Bus,
    /// COB-ID that its node babbles.
    babbled: Option<u16>,
    at: Time,
    before: (u64, usize),
    /// When it ended and what was counted by then.
    end: Option<Time>,
    has_effect: bool,
}

impl Effects {
    /// Of the faults of a script.
    pub fn new(script: &Script) -> Effects {
        let watched = |fault: &crate::script::Fault| Watched {
            kind: fault.kind,
            bus: fault.bus,
            babbled: (fault.kind == Kind::Babble).then_some(fault.value as u16),
            at: Time::from_us(fault.at),
            before: (0, 0),
            end: None,
            has_effect: false,
        };
        Effects { faults: script.faults.iter().map(watched).collect() }
    }

    /// A fault begins now.
    pub fn begin(&mut self, index: usize, world: &World) {
        let watched = &mut self.faults[index];
        watched.before = (disturbance(world, watched.bus), strange(world, watched.bus, watched.babbled));
        watched.has_effect = watched.kind.is_of_node();
    }

    /// A fault ends now.
    pub fn end(&mut self, index: usize, world: &World) {
        let watched = &mut self.faults[index];
        watched.end = Some(world.now());
        // A flip waits for its bit, and frames of a stranger for the bus.
        if !watched.kind.is_foreign() && watched.kind != Kind::Flip {
            watched.settle(world);
        }
    }

    /// At the end of the run; `events`: when states changed.
    pub fn finish(mut self, world: &World, events: &[Time]) -> Vec<bool> {
        let spans: Vec<(Time, Time)> = self
            .faults
            .iter()
            .map(|watched| (watched.at, watched.end.unwrap_or(watched.at) + REACTION))
            .collect();
        for index in 0..self.faults.len() {
            let watched = &mut self.faults[index];
            if watched.end.is_none() || watched.kind.is_foreign() || watched.kind == Kind::Flip {
                watched.settle(world);
            }
            let (from, to) = spans[index];
            let others = spans.iter().enumerate().filter(|(other, _)| *other != index);
            let is_alone = |at: Time| !others.clone().any(|(_, (from, to))| (*from..=*to).contains(&at));
            watched.has_effect |= events.iter().any(|&at| (from..=to).contains(&at) && is_alone(at));
        }
        self.faults.into_iter().map(|watched| watched.has_effect).collect()
    }
}

impl Watched {
    fn settle(&mut self, world: &World) {
        let (errors, frames) = (disturbance(world, self.bus), strange(world, self.bus, self.babbled));
        self.has_effect |=
            if self.kind.is_foreign() { frames > self.before.1 } else { errors > self.before.0 };
    }
}
