//! Result of a run.

use can_twin::wire::time::Time;
use ecss_can::types::Bus;

use crate::campaign::kind::Kind;
use crate::campaign::scene::{News, Scene, Seen, Sent};
use crate::campaign::script::Script;

/// Time after a fault in which a change of state counts as its effect.
const REACTION: Time = Time::from_ms(1_000);

/// Result of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Violated conditions.
    pub violations: Vec<String>,
    /// Whether each fault of the script changed a frame or a state.
    pub effective: Vec<bool>,
    /// Times from a fault to the change of the bus by the master, microseconds.
    pub detections: Vec<u64>,
}

/// Determines which faults have an effect.
///
/// A fault of a wire has an effect if frames are destroyed or not acknowledged there, or if fewer nodes receive them
/// than before. A foreign node and a babbling node have an effect by their own frames. A loss of power or a reset is
/// itself an effect. Any other change of state within a second counts, if no other fault may have caused it.
pub struct Effects {
    faults: Vec<Watched>,
}

struct Watched {
    kind: Kind,
    bus: Bus,
    /// COB-ID that its node babbles.
    babbled: Option<u16>,
    at: Time,
    /// Frames destroyed or not acknowledged, and frames completed, at its begin.
    before: (u64, usize),
    /// End of the fault.
    end: Option<Time>,
    has_effect: bool,
}

impl Effects {
    /// Makes the state for the faults of a script.
    pub fn new(script: &Script) -> Effects {
        let watched = |fault: &crate::campaign::script::Fault| Watched {
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

    /// Records the begin of a fault.
    pub fn begin(&mut self, index: usize, scene: &impl Scene, seen: &Seen) {
        let watched = &mut self.faults[index];
        watched.at = scene.now();
        watched.before = (scene.disturbance(watched.bus), seen.frames[watched.bus].len());
        watched.has_effect = watched.kind.is_of_node();
    }

    /// Records the end of a fault.
    pub fn end(&mut self, index: usize, scene: &impl Scene, seen: &Seen) {
        let watched = &mut self.faults[index];
        watched.end = Some(scene.now());
        if !watched.lingers() {
            watched.settle(scene, seen);
        }
    }

    /// Returns at the end of the run which faults had an effect.
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
    /// Returns whether the effect may be delayed: a flip waits for its bit, and frames of a foreign node wait for the
    /// bus.
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
