//! Reports of a slave's application, and the one that is possible now.

use ecss_can::types::Instant;

use super::{Reporter, World};
use crate::master::Master;
use crate::what::What;

/// A report between two ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Report {
    /// The error starts.
    Wrong,
    /// The error ends.
    Right,
    /// The value changes.
    Changed,
}

impl World {
    /// Returns the report that is possible now.
    pub fn possible_report(&self) -> Option<Report> {
        let powered = self.reporter.filter(|reporter| self.is_powered(reporter.place));
        let reporter = powered.filter(|_| self.reports > 0)?;
        let reports = self.slaves[reporter.place - 1].reports()?;
        Some(match reporter.what {
            What::Error if reports.is_wrong => Report::Right,
            What::Error => Report::Wrong,
            What::Value => Report::Changed,
        })
    }

    /// Applies a report of the slave and its immediate consequences. `on_loss`: called when a frame is lost.
    pub fn report_at(&mut self, report: Report, now: Instant, on_loss: &mut dyn FnMut(&World)) {
        let Some(reporter) = self.reporter else { return };
        let slave = &mut self.slaves[reporter.place - 1];
        match report {
            Report::Wrong => slave.turn_wrong(true, now),
            Report::Right => slave.turn_wrong(false, now),
            Report::Changed => slave.change(now),
        }
        self.settle(now, on_loss);
        self.reports -= 1;
    }

    /// Returns whether there are rounds.
    pub fn has_rounds(&self) -> bool {
        self.has_rounds
    }

    /// Starts a round: each master asks the slave for its errors at its next heartbeat, and the slave sends its value.
    pub fn begin_round(&mut self, now: Instant) {
        let Some(Reporter { place, .. }) = self.reporter else { return };
        self.slaves[place - 1].repeat_value(now);
        self.masters.iter_mut().for_each(Master::ask_anew);
    }

    /// Returns whether this master knows the reports of the slave.
    pub fn is_known_by(&self, master: usize) -> bool {
        let reports = self.reporter.and_then(|reporter| self.slaves[reporter.place - 1].reports());
        let known = self.masters[master].known();
        reports.zip(known).is_none_or(|(reports, known)| known.knows(reports.is_wrong, reports.has_changed))
    }
}
