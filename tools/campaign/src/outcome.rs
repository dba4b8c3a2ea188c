//! What became of a run.

use can_wire::time::Time;
use ecss_can::types::Bus;

use crate::kind::Kind;
use crate::scene::{News, Scene, Seen, Sent};
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
/// A fault of a wire changes frames when more of them are destroyed or go unacknowledged there, or when fewer nodes receive
/// them than the frame before it. A foreign node and a node that babbles change them by their own. A node that loses power or is
/// reset has changed its state. Any other change of state counts within a second, as long as no other fault may have
/// caused it.
pub struct Effects {
    faults: Vec<Watched>,
}

struct Watched {
    kind: Kind,
    bus: Bus,
    /// COB-ID that its node babbles.
    babbled: Option<u16>,
    at: Time,
    /// Frames destroyed or not acknowledged, and frames completed, when it began.
    before: (u64, usize),
    /// When it ended.
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
    pub fn begin(&mut self, index: usize, scene: &impl Scene, seen: &Seen) {
        let watched = &mut self.faults[index];
        watched.at = scene.now();
        watched.before = (scene.disturbance(watched.bus), seen.frames[watched.bus].len());
        watched.has_effect = watched.kind.is_of_node();
    }

    /// A fault ends now.
    pub fn end(&mut self, index: usize, scene: &impl Scene, seen: &Seen) {
        let watched = &mut self.faults[index];
        watched.end = Some(scene.now());
        if !watched.lingers() {
            watched.settle(scene, seen);
        }
    }

    /// At the end of the run.
    pub fn finish(mut self, scene: &impl Scene, seen: &Seen) -> Vec<bool> {
        let spans: Vec<(Time, Time)> = self
            .faults
            .iter()
            .map(|watched| (watched.at, watched.end.unwrap_or(watched.at) + REACTION))
            .collect();
        for index in 0..self.faults.len() {
            let watched = &mut self.faults[index];
            if watched.end.is_none() || watched.lingers() {
                watched.settle(scene, seen);
            }
            let (from, to) = spans[index];
            let others = spans.iter().enumerate().filter(|(other, _)| *other != index);
            let is_alone = |at: Time| !others.clone().any(|(_, (from, to))| (*from..=*to).contains(&at));
            let mut changes = seen.news.iter().filter(|noted| noted.news != News::ClockSet);
            watched.has_effect |= changes.any(|noted| (from..=to).contains(&noted.at) && is_alone(noted.at));
        }
        self.faults.into_iter().map(|watched| watched.has_effect).collect()
    }
}

impl Watched {
    /// A flip waits for its bit, and frames of a foreign node wait for the bus.
    fn lingers(&self) -> bool {
        self.kind.is_foreign() || self.kind == Kind::Flip
    }

    fn settle(&mut self, scene: &impl Scene, seen: &Seen) {
        let (errors, count) = self.before;
        let (earlier, since) = seen.frames[self.bus].split_at(count);
        let is_strange =
            |sent: &Sent| sent.key.is_none() || self.babbled.is_some() && sent.id == self.babbled;
        let all = earlier.last().map_or(0, |sent| sent.receivers);
        self.has_effect |= if self.kind.is_foreign() || self.kind == Kind::Babble {
            since.iter().any(is_strange)
        } else {
            scene.disturbance(self.bus) > errors || since.iter().any(|sent| sent.receivers < all)
        };
    }
}
