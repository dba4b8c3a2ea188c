//! How long a rule may not hold after the last fault.

use ecss_can::redundancy::{Pair, Parameters};
use ecss_can::types::Duration;

/// Bounds in time and number, from the last fault on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Until every slave in reach is served: that of [`agreement`](Bounds::agreement), two dwells where the master hears no slave,
    /// and the time for which the second board listens where no master is active.
    pub service: Duration,
    /// Until slaves that hear the master are on its bus: (Ttoggle + 2) consumer times and a hold time.
    pub agreement: Duration,
    /// Until one of two active masters that hear each other yields: two heartbeat periods (docs/decisions/standby-master.md).
    pub rivalry: Duration,
}

impl Bounds {
    /// Changes of the bus that no unserved slave asks for: where each bus serves one slave, a try from each bus, and at most one
    /// return from each (docs/decisions/master-bus-choice.md).
    pub const NEEDLESS: u8 = 4;

    /// Changes of role: both become active where they do not hear each other, and one yields where they do; once more where
    /// no node acknowledges the heartbeat of the one that stays.
    pub const HANDED_OVER: u8 = 6;

    /// Of nodes with these parameters, `shortest` dwell of the master, and boards that listen as `pair` says.
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
