//! Redundancy of a slave: which bus it uses, which NMT state it has, and which resets it obeys (ECSS 8.3).
//!
//! [`SlaveRedundancy`] joins the rules of a slave. The node passes what happens: frames of network management, ends of
//! its own heartbeats, the application's choice of a bus, and the time. The machine returns its decisions, [`SlaveAction`]s,
//! in a [`SlaveStep`]. The node carries them out in their order.
//!
//! | decision | by |
//! | --- | --- |
//! | active bus, search, Bdefault | [`Selector`] |
//! | whether a reset is obeyed | [`ResetGuard`] |
//! | whether the node yields to another one with its Node-ID | [`ClashWatch`] |
//! | NMT state, boot-up message, heartbeat | [`NodeControl`](crate::heartbeat::machine::NodeControl) of the node, by actions |
//!
//! After it missed the master, a slave sends an EMCY (ECSS 8.3.3e, note 2). The first change of the bus waits until
//! this *warning* was sent, or for a short time.

mod action;
mod clash;
mod frames;
mod resets;
mod retained;
mod selection;
#[cfg(test)]
mod tests;

use super::{Parameters, Selector};
use crate::link::access::BusAccess;
use crate::nmt::machine::{ClashWatch, ResetGuard};
use crate::types::{Bus, Canonical, Duration, Instant, PerBus, earliest};
pub use action::{BusCause, SlaveAction, SlaveActions, SlaveStep, SlaveVerdict};
pub use retained::Retained;

/// Redundancy of a slave.
///
/// Call [`SlaveRedundancy::boot`] at power-on, and [`SlaveRedundancy::poll`] at [`SlaveRedundancy::deadline`]. An input
/// that makes the deadline earlier always causes an action.
#[doc(alias("redundancy slave"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = PerBus<u32>)] // `received` of a step; the node counts from zero again
pub struct SlaveRedundancy {
    access: BusAccess,
    #[canonical(within = self.work(*context))]
    selector: Selector,
    #[canonical(within = self.pause())]
    guard: ResetGuard,
    #[canonical(within = self.clash_times())]
    clashes: ClashWatch,
    retained: Retained,
    /// Module control and heartbeats received; wraps.
    #[canonical(value = PerBus::default())]
    control_frames: PerBus<u32>,
    /// Bus that the application chose.
    wanted: Option<Bus>,
    /// Latest end of the warning that goes before a change of the bus.
    #[canonical(due)]
    warning: Option<Instant>,
    /// Longest duration of a warning.
    warning_time: Duration,
    /// The node sent too many frames. It stays in Pre-operational or Stopped until [`SlaveRedundancy::resume`].
    is_silenced: bool,
}

impl SlaveRedundancy {
    /// Makes the redundancy of a slave before power-on or after a reset of its chip. `stored`: parameters with
    /// Bdefault as it is kept beyond power-off. The slave starts on the Bdefault that is `retained`, else on that one
    /// (ECSS 8.3.2a). `warning_time`: longest time for which a warning delays a change of the bus.
    pub fn new(access: BusAccess, stored: Parameters, retained: Retained, warning_time: Duration) -> Self {
        let bdefault = retained.bdefault.unwrap_or(stored.bdefault);
        let mut selector = Selector::new(Parameters { bdefault, ..stored });
        selector.set_kept(stored.bdefault);
        SlaveRedundancy {
            access,
            selector,
            guard: ResetGuard::new(retained.resets),
            clashes: ClashWatch::new(),
            retained,
            control_frames: PerBus::default(),
            wanted: None,
            warning: None,
            warning_time,
            is_silenced: false,
        }
    }

    /// Starts again before power-on, with parameters that were loaded.
    pub fn restart(&mut self, access: BusAccess, stored: Parameters, retained: Retained) {
        *self = Self::new(access, stored, retained, self.warning_time);
    }

    /// Returns the bus that the slave considers active, or on which it searches.
    #[inline]
    pub const fn selected(&self) -> Bus {
        self.selector.selected()
    }

    /// Returns the parameters with the present Bdefault and Ctoggle.
    pub const fn parameters(&self) -> &Parameters {
        self.selector.parameters()
    }

    /// Returns the values that outlive a reset of the chip.
    pub(crate) const fn retained(&self) -> Retained {
        self.retained
    }

    /// Returns whether the slave takes part in `bus`.
    pub fn is_joined(&self, bus: Bus) -> bool {
        self.access.joins(bus, self.selected())
    }

    /// Begins the search on the selected bus (ECSS 8.3.2), at power-on and at "reset communication". `parameters`: those
    /// of the restored communication profile. Returns the bus of the boot-up message.
    pub fn boot(&mut self, parameters: Parameters, now: Instant) -> Bus {
        self.selector.configure(parameters);
        self.selector.start(now);
        self.clashes.boot(now);
        self.guard.on_boot(now);
        self.selected()
    }

    /// Takes parameters that were written.
    pub fn configure(&mut self, parameters: Parameters) {
        self.selector.configure(parameters);
    }

    /// Takes parameters that differ from those in use, and bounds stored instants. Call it periodically with the `written`
    /// parameters. Returns whether a bit was wrong.
    pub fn refresh(&mut self, written: Parameters, now: Instant) -> bool {
        self.warning.iter_mut().for_each(|end| end.confine(now + self.warning_time));
        self.selector.refresh(written, now)
    }

    /// Takes the bus that the application of a slave with selective access chose (ECSS 8.2.3a). It applies with the next
    /// [`SlaveRedundancy::poll`]. Returns `false` with parallel access: there the master chooses.
    #[must_use]
    pub fn choose(&mut self, bus: Bus) -> bool {
        let is_free = self.access == BusAccess::Selective;
        if is_free {
            self.wanted = Some(bus);
        }
        is_free
    }

    /// Silences the node, which sent too many frames (ECSS 5.3.3.1b). It enters Pre-operational, and no command starts
    /// it. So it sends no PDO, while the master hears it and may read its objects.
    pub fn silence(&mut self, step: &mut SlaveStep) {
        self.is_silenced = true;
        self.enter_pre_operational(step);
    }

    /// Ends the silence. Call [`SlaveRedundancy::boot`] then, with the communication profile of power-on, whatever a
    /// client had written.
    pub const fn resume(&mut self) {
        self.is_silenced = false;
    }

    /// Returns whether the node is silenced.
    pub(crate) const fn is_silenced(&self) -> bool {
        self.is_silenced
    }

    /// Does the first of what was due at `until`, which may be before the present: a frame is judged by its end. Returns
    /// whether there may be more: then call it again after the actions were carried out. Not while the node waits for
    /// its reset.
    pub fn poll(&mut self, until: Instant, step: &mut SlaveStep) -> bool {
        self.warning.take_if(|end| *end <= until);
        if let Some(bus) = self.wanted.take() {
            self.change_bus(bus, step);
        } else if self.warning.is_none()
            && let Some(selection) = self.selector.poll(until)
        {
            self.apply(selection, step);
        } else if !(self.clashes.is_known() && self.follow_clash(until, step)) {
            if self.guard.is_counting() {
                self.open_guard(until, step);
            }
            return false;
        }
        true
    }

    /// Returns when to call [`SlaveRedundancy::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        // Multiplications, seldom needed.
        let hold_off = || self.parameters().hold_off_time();
        earliest(&[
            (self.wanted.is_some() || self.clashes.must_fall_silent()).then_some(Instant::ZERO),
            self.warning.or_else(|| self.selector.deadline()),
            if self.clashes.is_known() { self.clashes.deadline(hold_off()) } else { None },
            self.guard.deadline(self.pause()),
        ])
    }
}
