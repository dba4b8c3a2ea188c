//! Transmit PDOs: from the dictionary into frames (CiA 301 7.2.2).

use super::{Layout, PdoSet, PdoSlots, rules};
use crate::od::{Objects, Place};
use crate::pdo::PdoParameters;
use crate::types::{AbortCode, CobId, Duration, Frame, Instant, Sealed};

/// All TPDOs of a node: they move values from the dictionary into frames.
///
/// | type | sent |
/// | --- | --- |
/// | 0 | at the next SYNC after an event |
/// | 1 to 240 | at every n-th SYNC. The first time is after n of them, or at the SYNC whose counter is the SYNC start value |
/// | 254, 255 | at an event, and when the event timer has expired since the last transmission |
///
/// Entering Operational is an event for PDOs that are declared as a [state](super::Tpdo::state), and for no others. Event
/// timers start then. An application that wants more triggers its PDOs. An event within the inhibit time is sent at the
/// end of that time, with the values of that instant.
///
/// A node has to sample before it acts at a SYNC. Therefore pass the SYNC to the TPDOs first and to the RPDOs after
/// them. So the node reports its values at the SYNC. Effects of a receive PDO are sent with the next SYNC.
#[doc(alias("TPDO", "transmit PDO"))]
#[derive(Debug)]
pub struct Tpdos<S: PdoSlots> {
    pdos: S::Transmit<Configured>,
    /// Behind the last valid one that a SYNC may send.
    synchronous: usize,
    /// `true`: at least one is sent on events.
    has_events: bool,
    operational: bool,
    /// Nothing is due before it.
    next: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Configured {
    id: Sealed,
    layout: Layout,
    transmission: u8,
    sync_start: u8,
    /// SYNCs to go until it is sent, that one included; or [`IDLE`], or [`START`].
    syncs: u8,
    /// Units of 100 us.
    inhibit: u16,
    /// Milliseconds.
    event_timer: u16,
    inhibit_end: Instant,
    /// Instant at which it is sent without a SYNC: at an event, or when the event timer expires.
    due: Instant,
    /// Content before the application changed its objects.
    before: u64,
    /// Its values are declared as a state.
    is_state: bool,
}

/// From one PDO to the next when all states are sent: other frames find the bus free in between.
const PACE: Duration = Duration::from_millis(10);

/// Longest time until the last of all states is sent.
const LONGEST_PACE: Duration = Duration::from_millis(10 * 512);

/// Time from a frame that was not sent to the next one.
const RETRY: Duration = Duration::from_millis(50);

/// Most PDOs sent in one call without a SYNC. The receiver of the frames has room for them.
pub const AT_ONCE: usize = 8;

/// No SYNC sends it.
const IDLE: u8 = 0;
/// It waits for the SYNC that has the SYNC start value.
const START: u8 = u8::MAX;

impl Configured {
    const INVALID: Configured = Configured {
        id: Sealed::NONE,
        layout: Layout::EMPTY,
        transmission: 0,
        sync_start: 0,
        syncs: IDLE,
        inhibit: 0,
        event_timer: 0,
        inhibit_end: Instant::ZERO,
        due: Instant::NEVER,
        before: 0,
        is_state: false,
    };

    /// Not valid any more.
    #[inline(never)] // row `size.canopen_only`: it has two callers, both of them rare
    fn invalidate(&mut self) {
        *self = Configured { is_state: self.is_state, ..Configured::INVALID };
    }

    /// Not valid.
    fn is_none(&self) -> bool {
        self.id == Sealed::NONE
    }

    /// Takes the parameters of a valid TPDO.
    fn take(&mut self, parameters: &PdoParameters, layout: Layout) {
        self.layout = layout;
        (self.transmission, self.sync_start) = (parameters.transmission, parameters.sync_start);
        (self.inhibit, self.event_timer) = (parameters.inhibit, parameters.event_timer);
    }

    /// Brings instants that are further away than the times of the PDO back to `now`: a bit of them flipped.
    fn confine(&mut self, now: Instant) {
        let inhibit = self.inhibit_time();
        self.inhibit_end.confine(now + inhibit);
        let longest = Duration::from_millis(self.event_timer.into()) + inhibit + LONGEST_PACE;
        if self.due < Instant::NEVER {
            self.due.confine(now + longest);
        }
    }

    fn inhibit_time(&self) -> Duration {
        Duration::from_micros(u64::from(self.inhibit).wrapping_mul(100))
    }

    /// In Operational from now on.
    fn start(&mut self, now: Instant) {
        match self.transmission {
            _ if self.is_none() => {}
            0 => {}
            cycle if rules::is_synchronous(cycle) => {
                self.syncs = if self.sync_start == 0 { cycle } else { START };
            }
            _ => self.due = self.timer(now),
        }
    }

    fn stop(&mut self) {
        self.syncs = IDLE;
        self.due = Instant::NEVER;
        self.inhibit_end = Instant::ZERO;
    }

    /// Returns when the event timer expires that started at `from`.
    fn timer(&self, from: Instant) -> Instant {
        match self.event_timer {
            0 => Instant::NEVER,
            ms => from + Duration::from_millis(u64::from(ms)),
        }
    }

    /// Returns whether an event makes it go out, now or later.
    fn trigger(&mut self, now: Instant) -> bool {
        match self.transmission {
            _ if self.is_none() => return false,
            0 => self.syncs = 1,
            cycle if rules::is_synchronous(cycle) => return false,
            _ => self.due = self.due.min(self.inhibit_end.max(now)),
        }
        true
    }

    /// It was due and is sent `now`.
    fn rearm(&mut self, now: Instant) {
        self.inhibit_end = now + self.inhibit_time();
        // On the grid of when it was due, unless that is past.
        let next = Some(self.timer(self.due)).filter(|next| *next > now).unwrap_or_else(|| self.timer(now));
        self.due = next.max(self.inhibit_end);
        if self.event_timer == 0 {
            self.due = Instant::NEVER;
        }
    }

    /// Makes a state go out at `at`, or before it if it is due already. Returns whether it is a state.
    fn send_state(&mut self, at: Instant) -> bool {
        let is_sent = self.is_state && self.is_by_event();
        if is_sent {
            self.trigger(at);
        }
        is_sent
    }

    fn is_by_event(&self) -> bool {
        !self.is_none() && (self.transmission == 0 || !rules::is_synchronous(self.transmission))
    }

    /// Nothing is sent if a bit of the COB-ID has flipped. Returns `false` if there was no room.
    #[inline(always)]
    fn send<D: Objects>(&self, objects: &D, send: impl FnOnce(Frame) -> bool) -> bool {
        let bits = self.layout.pack(objects);
        self.id.id().is_none_or(|id| send(Frame::of_bits(id, self.layout.bytes(), bits)))
    }
}

impl<S: PdoSlots> Tpdos<S> {
    /// Makes the TPDOs of a node. None is valid. `declared` says which of them are states.
    pub fn new(declared: &PdoSet) -> Self {
        let mut pdos = S::transmit(Configured::INVALID);
        for (number, pdo) in pdos.as_mut().iter_mut().enumerate() {
            pdo.is_state = declared.is_state(number);
        }
        Tpdos { pdos, synchronous: 0, has_events: false, operational: false, next: Instant::NEVER }
    }

    /// Makes all TPDOs invalid.
    pub fn clear(&mut self) {
        for pdo in self.pdos.as_mut() {
            pdo.invalidate();
        }
        self.index();
    }

    /// Takes new values of objects 1800h + `number` and 1A00h + `number`, resolved by [`rules::resolve`]. The TPDO
    /// starts as if Operational had just been entered. An event that waits for the inhibit time is still sent.
    ///
    /// # Errors
    /// [`AbortCode::NoObject`] for a `number` without a slot. [`AbortCode::ParameterIncompatible`] for the COB-ID
    /// of another valid TPDO. Then nothing was changed.
    pub fn configure(
        &mut self,
        number: usize,
        parameters: &PdoParameters,
        resolved: Option<(CobId, Layout)>,
        now: Instant,
    ) -> Result<(), AbortCode> {
        let id = resolved.map(|(id, _)| id);
        let mut others = self.pdos.as_ref().iter().enumerate().filter(|(other, _)| *other != number);
        if id.is_some_and(|id| others.any(|(_, other)| other.id.is(id))) {
            return Err(AbortCode::ParameterIncompatible);
        }
        let pdo = self.pdos.as_mut().get_mut(number).ok_or(AbortCode::NoObject)?;
        let old = *pdo;
        pdo.invalidate();
        if let Some((id, layout)) = resolved {
            pdo.id = Sealed::of(id);
            pdo.take(parameters, layout);
            pdo.inhibit_end = old.inhibit_end;
        }
        if id.is_some() && self.operational {
            pdo.start(now);
            let waits_for_sync = old.transmission == 0 && old.syncs != IDLE;
            if waits_for_sync || old.due <= old.inhibit_end.max(now) {
                pdo.trigger(now);
            }
            self.next = self.next.min(pdo.due);
        }
        self.index();
        Ok(())
    }

    /// Gives a valid TPDO the parameters again that it has. Nothing else changes.
    pub fn renew(&mut self, number: usize, parameters: &PdoParameters, layout: Layout) {
        if let Some(pdo) = self.pdos.as_mut().get_mut(number) {
            pdo.take(parameters, layout);
            self.index();
        }
    }

    /// Computes again what decides about each SYNC and each poll. `operational`: the NMT state allows PDOs.
    pub fn refresh(&mut self, operational: bool, now: Instant) {
        self.index();
        if operational && !self.operational {
            self.start_timers(now);
        }
        self.operational = operational;
        for pdo in self.pdos.as_mut() {
            pdo.confine(now);
        }
        self.next = Instant::ZERO;
    }

    /// After one became valid or invalid, or has another transmission type.
    fn index(&mut self) {
        let is_synchronous = |pdo: &Configured| !pdo.is_none() && rules::is_synchronous(pdo.transmission);
        self.synchronous = self.pdos.as_ref().iter().rposition(is_synchronous).map_or(0, |last| last + 1);
        self.has_events = self.pdos.as_ref().iter().any(Configured::is_by_event);
    }

    /// Returns the COB-ID of a TPDO, if it is valid and no bit of it has flipped.
    pub fn id(&self, number: usize) -> Option<CobId> {
        self.sealed(number).id()
    }

    /// Returns the COB-ID of a TPDO with its complement.
    pub(crate) fn sealed(&self, number: usize) -> Sealed {
        self.pdos.as_ref().get(number).map_or(Sealed::NONE, |pdo| pdo.id)
    }

    /// Returns whether a TPDO is valid.
    pub fn is_valid(&self, number: usize) -> bool {
        self.pdos.as_ref().get(number).is_some_and(|pdo| !pdo.is_none())
    }

    /// Returns whether any TPDO is sent on events.
    pub(crate) fn has_events(&self) -> bool {
        self.has_events
    }

    /// Notes that Operational is entered.
    pub fn start(&mut self, now: Instant) {
        self.start_timers(now);
        self.send_states(now);
    }

    /// Notes that Operational is entered, and sends no state.
    pub(crate) fn start_timers(&mut self, now: Instant) {
        self.operational = true;
        for pdo in self.pdos.as_mut() {
            pdo.start(now);
            self.next = self.next.min(pdo.due);
        }
    }

    /// Sends all states from `at` on, one every 10 ms: the receivers may not have heard the last ones.
    pub fn send_states(&mut self, mut at: Instant) {
        if !self.operational {
            return;
        }
        for pdo in self.pdos.as_mut() {
            if pdo.send_state(at) {
                at += PACE;
                self.next = self.next.min(pdo.due);
            }
        }
    }

    /// Takes a frame that was not sent. A state is due again after 50 ms.
    pub fn on_failed(&mut self, id: CobId, now: Instant) {
        if self.operational
            && let Some(pdo) = self.pdos.as_mut().iter_mut().find(|pdo| pdo.id.is(id))
            && pdo.send_state(now + RETRY)
        {
            self.next = self.next.min(pdo.due);
        }
    }

    /// Returns whether this is the COB-ID of a valid PDO.
    pub fn has(&self, id: CobId) -> bool {
        self.pdos.as_ref().iter().any(|pdo| pdo.id.is(id))
    }

    /// Returns whether this is the COB-ID of a PDO that is sent on events alone, and is no state: no later frame replaces
    /// one that was not sent.
    pub fn is_event(&self, id: CobId) -> bool {
        let is_event = |pdo: &Configured| pdo.is_by_event() && pdo.event_timer == 0 && !pdo.is_state;
        self.pdos.as_ref().iter().any(|pdo| pdo.id.is(id) && is_event(pdo))
    }

    /// Notes that Operational is left: nothing is sent any more, and events are dropped.
    pub fn stop(&mut self) {
        self.operational = false;
        self.next = Instant::NEVER;
        self.pdos.as_mut().iter_mut().for_each(Configured::stop);
    }

    /// Takes an event for one TPDO. Returns whether the event makes it go out, at the next SYNC or at the next
    /// poll. Does nothing for a cyclic TPDO, and outside of Operational.
    pub fn trigger(&mut self, number: usize, now: Instant) -> bool {
        let Some(pdo) = self.pdos.as_mut().get_mut(number).filter(|_| self.operational) else { return false };
        let goes = pdo.trigger(now);
        self.next = self.next.min(pdo.due);
        goes
    }

    /// Notes that a value changed: an event for all TPDOs that carry it.
    pub fn on_changed(&mut self, place: Place, now: Instant) {
        if !self.operational {
            return;
        }
        for pdo in self.pdos.as_mut() {
            if pdo.is_by_event() && pdo.layout.carries(place) {
                pdo.trigger(now);
                self.next = self.next.min(pdo.due);
            }
        }
    }

    /// Remembers the contents of the TPDOs that are sent on events. Call it before the application changes its
    /// objects.
    #[inline(never)] // an application need not have it twice
    pub(crate) fn remember<D: Objects>(&mut self, objects: &D) {
        for pdo in self.pdos.as_mut().iter_mut().filter(|pdo| pdo.is_by_event()) {
            pdo.before = pdo.layout.pack(objects);
        }
    }

    /// Compares with the contents remembered before: an event for each TPDO with another content.
    #[inline(never)] // an application need not have it twice
    pub(crate) fn trigger_changed<D: Objects>(&mut self, objects: &D, now: Instant) {
        if !self.operational {
            return;
        }
        for pdo in self.pdos.as_mut().iter_mut().filter(|pdo| pdo.is_by_event()) {
            if pdo.layout.pack(objects) != pdo.before {
                pdo.trigger(now);
                self.next = self.next.min(pdo.due);
            }
        }
    }

    /// Handles a SYNC with its counter, zero if it has none. Sends the synchronous TPDOs that are
    /// due. `send` gets the number of a TPDO, its frame, and whether an event made it due. Such a frame may wait: `send`
    /// returns `false` if there is no room for it, and it is due again at the next SYNC.
    #[inline(always)] // called from one place
    pub fn on_sync<D: Objects>(
        &mut self,
        counter: u8,
        objects: &D,
        send: &mut impl FnMut(usize, Frame, bool) -> bool,
    ) {
        for (number, pdo) in self.pdos.as_mut().iter_mut().take(self.synchronous).enumerate() {
            let syncs = match pdo.syncs {
                IDLE => continue,
                // No counter: the start value does not matter.
                START if counter == 0 => pdo.transmission,
                START if counter == pdo.sync_start => 1,
                START => continue,
                syncs => syncs,
            };
            if syncs > 1 {
                pdo.syncs = syncs.wrapping_sub(1);
                continue;
            }
            // Type 0 is idle until the next event.
            pdo.syncs = pdo.transmission;
            let may_wait = pdo.transmission == 0;
            if !pdo.send(objects, |frame| send(number, frame, may_wait)) && may_wait {
                pdo.syncs = 1;
            }
        }
    }

    /// Sends what is due at `now`, at most [`AT_ONCE`] frames. The others stay due. `send` returns `false` if there is no
    /// room for a frame. Then the rest waits for 10 ms.
    pub fn poll<D: Objects>(
        &mut self,
        now: Instant,
        objects: &D,
        send: &mut impl FnMut(usize, Frame) -> bool,
    ) {
        if now < self.next {
            return;
        }
        self.next = Instant::NEVER;
        let mut left = AT_ONCE;
        for (number, pdo) in self.pdos.as_mut().iter_mut().enumerate() {
            if pdo.due <= now && left > 0 {
                left -= 1;
                if !pdo.send(objects, |frame| send(number, frame)) {
                    self.next = now + PACE;
                    return;
                }
                pdo.rearm(now);
            }
            self.next = self.next.min(pdo.due);
        }
    }

    /// Returns when to poll next.
    pub fn deadline(&self) -> Option<Instant> {
        (self.next < Instant::NEVER).then_some(self.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdo::PdoObjects;
    use crate::sync::SyncObjects;

    const ID: CobId = CobId::new(0x185).unwrap();
    const NOW: Instant = Instant::from_micros(1_000);

    /// Frames that an event and a SYNC send.
    fn sent(transmission: u8, id: Sealed) -> usize {
        let mut tpdos = Tpdos::<PdoObjects<1, 1>>::new(&PdoSet::NONE);
        let parameters = PdoParameters { transmission, ..PdoParameters::default() };
        tpdos.configure(0, &parameters, Some((ID, Layout::EMPTY)), NOW).unwrap();
        tpdos.start(NOW);
        tpdos.pdos.as_mut()[0].id = id;
        let mut sent = 0;
        tpdos.trigger(0, NOW);
        let objects = SyncObjects::default();
        tpdos.poll(NOW, &objects, &mut |_, _| {
            sent += 1;
            true
        });
        tpdos.on_sync(0, &objects, &mut |_, _, _| {
            sent += 1;
            true
        });
        sent
    }

    /// Given a TPDO of which one bit of the COB-ID or of its complement has flipped, then neither an event nor a SYNC
    /// sends it.
    ///
    /// Verifies: ECSS 6.10d
    /// Given a TPDO with an event timer of 250 ms and an inhibit time of 100 ms, when any bit of its instants or of whether the
    /// node is Operational flips, then after the next refresh it is sent within 250 ms, 100 ms and the time of all states.
    #[test]
    fn a_refreshed_tpdo_is_sent_whatever_bit_has_flipped() {
        let parameters = PdoParameters { event_timer: 250, inhibit: 1_000, ..PdoParameters::default() };
        let at = Instant::from_micros(46_912_496_118);
        for bit in 0..3 * 64 + 1 {
            let mut tpdos = Tpdos::<PdoObjects<1, 2>>::new(&PdoSet::NONE);
            tpdos.configure(0, &parameters, Some((ID, Layout::EMPTY)), at).unwrap();
            tpdos.start(at);
            let mut sent = 0;
            let mut poll = |tpdos: &mut Tpdos<_>, now| {
                tpdos.poll(now, &SyncObjects::default(), &mut |_, _| {
                    sent += 1;
                    true
                });
                sent
            };
            let mut now = at + Duration::from_millis(250);
            assert_eq!(poll(&mut tpdos, now), 1);
            let [pdo, _] = &mut tpdos.pdos;
            let flipped = |at: Instant| Instant::from_micros(at.as_micros() ^ 1 << (bit % 64));
            match bit / 64 {
                0 => pdo.due = flipped(pdo.due),
                1 => pdo.inhibit_end = flipped(pdo.inhibit_end),
                2 => tpdos.next = flipped(tpdos.next),
                _ => tpdos.operational = false,
            }
            tpdos.refresh(true, now);
            let last = now + Duration::from_millis(250 + 100) + LONGEST_PACE;
            while poll(&mut tpdos, now) < 2 {
                now += Duration::from_millis(10);
                assert!(now <= last, "bit {bit}");
            }
        }
    }

    #[test]
    fn nothing_is_sent_while_a_bit_of_the_cob_id_is_wrong() {
        for transmission in [254, 1, 0] {
            assert_eq!(sent(transmission, Sealed::of(ID)), 1, "type {transmission}");
            let flipped = Sealed::of(ID).flipped().map(|id| sent(transmission, id));
            assert_eq!(flipped.sum::<usize>(), 0, "type {transmission}");
        }
    }
}
