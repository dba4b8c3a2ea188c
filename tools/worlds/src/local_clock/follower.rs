//! Clocks that follow a master: the clock of the product, alone or in the time service of a slave.

use ecss_can::link::Stamp;
use ecss_can::profile::Profile;
use ecss_can::time::machine::{LocalClock, Places, TimeService};
use ecss_can::time::{TimeCorrection, TimeSource};
use ecss_can::types::{Bus, FineInstant, FineScet};

/// A clock that is disciplined by pairs.
pub trait Follower {
    /// Adds a pair: at the instant `at` the time was `scet`; this is known since `now`.
    fn pair(&mut self, at: FineInstant, scet: FineScet, source: TimeSource, now: FineInstant);

    /// Spacecraft time at an instant.
    fn at(&self, at: FineInstant) -> FineScet;

    /// Reported bound of the error, nanoseconds.
    fn bound(&self, now: FineInstant) -> f64;
}

impl Follower for LocalClock {
    fn pair(&mut self, at: FineInstant, scet: FineScet, source: TimeSource, now: FineInstant) {
        self.discipline(at, scet, source, now);
    }

    fn at(&self, at: FineInstant) -> FineScet {
        LocalClock::at(self, at)
    }

    fn bound(&self, now: FineInstant) -> f64 {
        self.quality(now).bound_ns.into()
    }
}

/// The time service of a slave: it knows the stamp source of the master, and optionally the delay.
#[derive(Clone, Debug)]
pub struct Slave {
    service: TimeService,
    correction: TimeCorrection,
}

impl Slave {
    /// Makes a slave with the numbers of a mission. `delay` as in 2014h.
    pub fn new(profile: &Profile, delay: i32) -> Self {
        let correction = TimeCorrection { nominal: delay, redundant: delay, fine_bits: 24 };
        let service = TimeService::new(&profile.clocks, profile.network.longest_delay());
        Slave { service, correction }
    }
}

impl Follower for Slave {
    fn pair(&mut self, at: FineInstant, scet: FineScet, source: TimeSource, now: FineInstant) {
        let stamp =
            if source == TimeSource::Capture { Stamp::captured(at) } else { Stamp::interrupt(at.instant()) };
        self.service.on_sync(Bus::Nominal, &stamp);
        self.service.on_places(Places { bits: 24, is_short: (scet.units() >> 8).is_multiple_of(8) });
        self.service.at_last_sync(scet, &self.correction, now.instant());
    }

    fn at(&self, at: FineInstant) -> FineScet {
        self.service.clock().at(at)
    }

    fn bound(&self, now: FineInstant) -> f64 {
        self.service.quality(&self.correction, now.instant()).bound.into()
    }
}
