//! Process data of a node: received frames, SYNC, events and timers, and values that are sampled for
//! transmission.

use super::Services;
use crate::link::Stamp;
use crate::node::Device;
use crate::node::events::NodeEvent;
use crate::node::services::extension::Extension;
use crate::node::turn::Turn;
use crate::pdo::{ReceivedPdo, SetRpdo, Taken};
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant, NmtState};

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Follows the mappings of the PDOs, and how long those of a SYNC live. Call after each change of a PDO or of 1006h.
    pub(super) fn note_mappings(&mut self) {
        E::note_mappings(self);
        self.lifetimes.synchronous_pdo = E::synchronous_lifetime(self, self.sync_lifetime());
    }

    /// Returns the lifetime of a SYNC, at most the communication cycle period (1006h).
    pub fn sync_lifetime(&self) -> Duration {
        let period = Duration::from_micros(self.objects().communication.sync.cycle_period.into());
        let most = self.lifetimes.synchronous;
        if period > Duration::ZERO { most.min(period) } else { most }
    }

    /// Lets the SYNC consumer pass on each SYNC, or only those that are not plain.
    pub fn watch_syncs(&mut self, all: bool) {
        self.sync.watch(all);
    }

    /// Handles a SYNC with this counter in Operational. Synchronous TPDOs are sampled before RPDOs take effect.
    /// `withheld`: COB-ID of a PDO that is not sent.
    #[inline(always)] // row `instructions.sync_tpdo_static`: 23 more without it
    pub fn exchange<V: NodeEvent<Extension = E::Event>>(
        &mut self,
        bus: Bus,
        counter: u8,
        withheld: Option<CobId>,
        turn: &mut Turn<V>,
    ) {
        // CiA 301 7.5.2.7: what has not left at the end of the window is discarded.
        let expires = (turn.now + self.lifetimes.synchronous_pdo).min(self.sync.window_end());
        self.dictionary.sample(counter, &mut |frame, may_wait| {
            if may_wait {
                return turn.out.offer(bus, frame, expires);
            }
            if withheld != Some(frame.id()) {
                turn.out.send_until(bus, frame, expires);
            }
            true
        });
        if self.dictionary.rpdos().is_waiting() {
            self.end_sync(bus, turn);
        }
    }

    /// Lets the receive PDOs that waited for the SYNC take effect.
    fn end_sync<V: NodeEvent<Extension = E::Event>>(&mut self, bus: Bus, turn: &mut Turn<V>) {
        let Self { dictionary, buses, .. } = self;
        dictionary.apply_waiting(&mut |number, all| {
            let pdo = SetRpdo::new(const { &D::PDOS }, number as u16);
            if all { turn.out.event(V::synchronised(pdo)) } else { buses.no_sooner().count_malformed(bus) }
        });
    }

    /// Handles a frame on the active bus in Operational. Returns whether its COB-ID is that of an RPDO.
    #[inline(always)] // row `instructions.rpdo_static`: 25 more without it
    pub fn on_pdo<V: NodeEvent<Extension = E::Event>>(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<V>,
    ) -> bool {
        let Some(mut number) = self.dictionary.rpdos().first(frame.id()) else { return false };
        loop {
            if self.dictionary.on_plain_rpdo(number, frame) && !E::is_special_rpdo(&self.state, number) {
                turn.out.event(V::pdo(received::<D>(number, bus, frame, stamp)));
            } else {
                self.on_special_pdo(number, bus, frame, stamp, turn);
            }
            match self.dictionary.rpdos().next(frame.id(), number) {
                Some(next) => number = next,
                None => return true,
            }
        }
    }

    /// Takes a frame of an RPDO that is synchronous, has a deadline, carries the time, or is not as it should be.
    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    fn on_special_pdo<V: NodeEvent<Extension = E::Event>>(
        &mut self,
        number: usize,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<V>,
    ) {
        match self.dictionary.on_rpdo(number, frame, stamp.at, self.sync.window_end()) {
            Taken::Applied if E::is_special_rpdo(&self.state, number) => {
                E::on_rpdo(self, number, bus, stamp, turn);
            }
            Taken::Applied => turn.out.event(V::pdo(received::<D>(number, bus, frame, stamp))),
            Taken::Held => {}
            Taken::OutsideWindow => self.buses_mut().count_ignored(bus),
            Taken::Rejected | Taken::Refused => self.buses_mut().count_malformed(bus),
        }
    }

    /// Sends all states of the application from `at` on.
    pub(crate) fn send_states(&mut self, at: Instant) {
        self.dictionary.send_states(at);
    }

    /// Triggers a transmit PDO (0 is the first): it goes out by its transmission type.
    pub fn trigger(&mut self, number: usize, now: Instant) {
        self.dictionary.tpdos_mut().trigger(number, now);
    }

    /// Notes that an object changed: an event for all TPDOs that carry it.
    pub fn on_changed(&mut self, at: Address, now: Instant) {
        self.dictionary.on_changed(at, now);
    }

    /// Sends what is due, except SDO responses. Each frame has the end of its lifetime and a flag: it is
    /// [short-lived](Extension::is_short_lived). `send` returns `false` if there is no room: the frame then waits.
    /// Emergencies go first because their COB-IDs have the higher priority.
    pub fn poll(
        &mut self,
        until: Instant,
        now: Instant,
        state: NmtState,
        send: &mut impl FnMut(Frame, Instant, bool) -> bool,
    ) {
        E::sample_events(self, until);
        let expires = now + self.lifetimes.event;
        self.dictionary.poll(until, state, &mut |frame| send(frame, expires, false));
        let Self { dictionary, state, .. } = self;
        dictionary.poll_tpdos(until, &mut |number, frame| {
            let is_short_lived = E::is_short_lived(state, number);
            let expires = if is_short_lived { expires.min(now + E::SHORT_LIFETIME) } else { expires };
            send(frame, expires, is_short_lived)
        });
    }
}

/// Returns the content of an event.
fn received<D: Device>(number: usize, bus: Bus, frame: &Frame, stamp: &Stamp) -> ReceivedPdo {
    ReceivedPdo::new(const { &D::PDOS }, number as u16, bus, frame.padded(), stamp.at)
}
