//! Slaves that send too much: stopped, then reset, then left behind on their bus (ECSS 5.3.3.1b).

use heapless::Vec;

use crate::link::budget::{Bucket, Rate};
use crate::nmt::Target;
use crate::types::{Duration, Instant, NodeId};

/// Node-IDs 0..=127.
const PLACES: usize = 128;
/// Slaves that are silenced at the same time.
const CASES: usize = 4;
/// What was commanded has effect by then, and what was queued before has left.
const PATIENCE: Duration = Duration::from_millis(500);
/// A slave that was silenced may run again when it was quiet for so long.
const HOLD: Duration = Duration::from_millis(10_000);

/// What the master did about a babbling slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BabblingStep {
    /// Commanded it to stop. It is not started unasked until it was quiet for 10 s.
    Stopped = 1,
    /// Reset it: it babbled on for 500 ms.
    Reset = 2,
    /// Left the bus: it babbled on for 500 ms more.
    BusLeft = 3,
    /// It was quiet for 10 s and may be started again, or the application has commanded it.
    Quiet = 4,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Case {
    node: NodeId,
    step: BabblingStep,
    since: Instant,
    /// It was above its rate then.
    last: Instant,
    was_held: bool,
}

/// The slaves that the master hears, and those among them that babble.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Babblers {
    rate: Rate,
    /// Between two changes of the bus.
    dwell: Duration,
    not_before: Instant,
    cases: Vec<Case, CASES>,
    buckets: [Bucket; PLACES],
}

impl Babblers {
    /// Nobody babbles. The bus is left again after `dwell` at the earliest.
    pub const fn new(rate: Rate, dwell: Duration) -> Self {
        let buckets = [Bucket::FULL; PLACES];
        Babblers { rate, dwell, not_before: Instant::ZERO, cases: Vec::new(), buckets }
    }

    /// A frame of a slave on the active bus. Returns what is to be done about it. `is_held`: the application keeps it from
    /// running.
    pub fn on_frame(&mut self, node: NodeId, is_held: bool, at: Instant) -> Option<BabblingStep> {
        let bucket = self.buckets.get_mut(usize::from(node.get()))?;
        if bucket.take(self.rate, at.as_micros() as u32) {
            return None;
        }
        let Some(case) = self.cases.iter_mut().find(|case| case.node == node) else {
            let step = BabblingStep::Stopped;
            let case = Case { node, step, since: at, last: at, was_held: is_held };
            // When others have all places it is silenced after them.
            return self.cases.push(case).ok().map(|()| step);
        };
        case.last = at;
        let next = match case.step {
            BabblingStep::Stopped => BabblingStep::Reset,
            BabblingStep::Reset if at >= self.not_before => BabblingStep::BusLeft,
            BabblingStep::Reset | BabblingStep::BusLeft | BabblingStep::Quiet => return None,
        };
        if at < case.since + PATIENCE {
            return None;
        }
        if next == BabblingStep::BusLeft {
            self.not_before = at + self.dwell;
        }
        (case.step, case.since) = (next, at);
        Some(next)
    }

    /// The application commands these slaves: it knows what it does. The next one that was silenced, call until `None`.
    pub fn on_commanded(&mut self, target: Target) -> Option<NodeId> {
        let place = self.cases.iter().position(|case| target.includes(case.node))?;
        Some(self.cases.swap_remove(place).node)
    }

    /// The next slave that was quiet long enough, and whether the application keeps it from running; call until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<(NodeId, bool)> {
        let place = self.cases.iter().position(|case| case.last + HOLD <= now)?;
        let Case { node, was_held, .. } = self.cases.swap_remove(place);
        Some((node, was_held))
    }

    /// When to poll next.
    pub fn deadline(&self) -> Option<Instant> {
        self.cases.iter().map(|case| case.last + HOLD).min()
    }
}
