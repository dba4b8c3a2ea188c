//! Bounds of the time for which a rule may be violated after the last fault.

use ecss_can::redundancy::{Pair, Parameters};
use ecss_can::types::Duration;

/// Bounds in time and number, from the last fault on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Time until every slave in reach is served: that of [`agreement`](Bounds::agreement), two dwells if the master
    /// hears no slave, and the time for which the second board listens if no master is active.
    pub service: Duration,
    /// Time until slaves that hear the master are on its bus: (Ttoggle + 2) consumer times and a hold time.
    pub agreement: Duration,
    /// Time until one of two active masters that hear each other yields: two heartbeat periods
    /// (docs/decisions/standby-master.md).
    pub rivalry: Duration,
}

impl Bounds {
    /// Greatest number of changes of the bus without an unserved slave. If each bus serves one slave: a try from each
    /// bus, and at most one return from each (docs/decisions/master-bus-choice.md).
    pub const NEEDLESS: u8 = 4;

    /// Greatest number of changes of role: both become active if they do not hear each other, and one yields when they
    /// do; again if no node acknowledges the heartbeat of the remaining one.
    pub const HANDED_OVER: u8 = 6;

    /// Makes the bounds of nodes with these parameters, the `shortest` dwell of the master, and the listening time of
    /// `pair`.
    pub fn new(parameters: &Parameters, shortest: Duration, pair: &Pair) -> Bounds {
        let agreement = parameters.toggling_time() + parameters.consumer.times(2) + parameters.hold_time();
        let service = agreement + parameters.dwell(shortest).times(2) + pair.second_listens;
        Bounds { service, agreement, rivalry: parameters.producer.times(2) }
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;
    use ecss_can::types::Bus;

    use super::*;

    const PARAMETERS: Parameters = Parameters {
        consumer: Duration::from_millis(250),
        producer: Duration::from_millis(100),
        bdefault: Bus::Nominal,
        ttoggle: 2,
        ntoggle: 4,
        ctoggle: 0,
    };

    /// By hand: 4 x 250 ms and a hold of 500 - 100 ms; two dwells of 2 x 500 + 2 x 100 ms or of 10 s; 1 s of listening.
    #[test]
    fn bounds_are_those_of_the_pages() {
        for (shortest, service) in [(0, 1_400 + 2_400 + 1_000), (10_000, 1_400 + 20_000 + 1_000)] {
            let bounds = Bounds::new(&PARAMETERS, Duration::from_millis(shortest), &Profile::PAIR);
            let found = [bounds.agreement, bounds.service, bounds.rivalry].map(|span| span.as_millis());
            assert_eq!(found, [1_400, service, 200], "dwell of at least {shortest} ms");
        }
    }
}
