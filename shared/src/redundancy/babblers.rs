//! Babbling slaves: the master stops them, then resets them, then leaves their bus (ECSS 5.3.3.1b).

use heapless::Vec;

use crate::link::budget::{Bucket, Rate};
use crate::nmt::Target;
use crate::types::{Duration, Instant, NodeId};

/// Node-IDs 0..=127.
const PLACES: usize = 128;
/// Slaves that are silenced at the same time.
const CASES: usize = 4;
/// Time after which a command has its effect, and frames that were queued before have left.
const PATIENCE: Duration = Duration::from_millis(500);
/// Quiet time after which a slave that was silenced may run again.
const HOLD: Duration = Duration::from_millis(10_000);

/// Step that the master took against a babbling slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BabblingStep {
    /// The master stopped the slave. It does not start it again before it was quiet for 10 s, unless the
    /// application does.
    Stopped = 1,
    /// The master reset the slave, which went on babbling for 500 ms.
    Reset = 2,
    /// The master left the bus, because the slave went on babbling for another 500 ms.
    BusLeft = 3,
    /// The slave was quiet for 10 s and may be started again, or the application commanded it.
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

/// Watches the slaves that the master hears for babbling ones.
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
    /// Makes a watch without babbling slaves. `dwell`: least time before the bus is left again.
    pub const fn new(rate: Rate, dwell: Duration) -> Self {
        let buckets = [Bucket::FULL; PLACES];
        Babblers { rate, dwell, not_before: Instant::ZERO, cases: Vec::new(), buckets }
    }

    /// Takes a frame of a slave on the active bus. Returns the step to take. `is_held`: the application keeps the
    /// slave from running.
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

    /// Takes a command of the application to these slaves, which ends their babbling. Returns the next slave that
    /// was silenced. Call it until `None`.
    pub fn on_commanded(&mut self, target: Target) -> Option<NodeId> {
        let place = self.cases.iter().position(|case| target.includes(case.node))?;
        Some(self.cases.swap_remove(place).node)
    }

    /// Returns the next slave that was quiet for long enough, and a flag: the application keeps it from running.
    /// Call it until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<(NodeId, bool)> {
        let place = self.cases.iter().position(|case| case.last + HOLD <= now)?;
        let Case { node, was_held, .. } = self.cases.swap_remove(place);
        Some((node, was_held))
    }

    /// Returns when to poll next.
    pub fn deadline(&self) -> Option<Instant> {
        self.cases.iter().map(|case| case.last + HOLD).min()
    }
}
