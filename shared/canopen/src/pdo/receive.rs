//! Receive PDOs: from frames into the dictionary (CiA 301 7.2.2).

use super::{Layout, PdoSlots, RpdoError, RpdoEvent, rules};
use crate::od::Objects;
use crate::pdo::PdoParameters;
use crate::types::{AbortCode, CobId, Duration, Frame, Instant, Sealed};

/// Outcome of a frame of an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Taken {
    /// All values are in the dictionary.
    Applied,
    /// Some values are outside their limits, or none of their enumeration, and were not written. The others are in the dictionary.
    Refused,
    /// The frame waits for SYNC.
    Held,
    /// The PDO is synchronous, and the frame came after the synchronous window (1007h). It was discarded: neither
    /// the deadline nor an error of the PDO changed.
    OutsideWindow,
    /// The frame has fewer bytes than are mapped. It was not processed.
    Rejected,
}

/// Function codes: the upper four bits of a COB-ID.
const FUNCTIONS: usize = 16;
/// No RPDO has this function code.
const NOBODY: u16 = u16::MAX;

/// Returns the function code of a COB-ID; out of range for [`Sealed::NONE`].
const fn function(id: u16) -> usize {
    id as usize >> 7
}

/// All RPDOs of a node: they move values from frames into the dictionary.
///
/// - With transmission type 0 to 240 the newest frame of a PDO takes effect at the next SYNC, with 254 and 255 at
///   once. A PDO that carries the time takes effect at once with every type. With types 0 to 240 it is the time of
///   the last SYNC.
/// - A frame with fewer bytes than are mapped is not processed. Of a longer frame the mapped bytes are used. A
///   value outside its limits, or none of its enumeration, is not written. The other values of its frame are, but the frame does not
///   count as applied. All three are errors of their PDO: [`Rpdos::take_event`] returns each when it appears and when it is
///   gone.
/// - A frame may end before a value that the device declares optional. Such a value is zero.
/// - The event timer is a deadline from each good frame to the next. It starts with the first good frame in
///   Operational, or after the PDO was configured. A frame that the synchronous window discards does not restart it.
/// - Two PDOs may have the same COB-ID. Both take the frame, in the order of their numbers.
#[doc(alias("RPDO", "receive PDO"))]
#[derive(Debug)]
pub struct Rpdos<S: PdoSlots> {
    ids: S::Receive<Sealed>,
    /// The first that has a COB-ID with this function code, so that a frame is not compared with all: the pre-defined
    /// connection set has at most one. Or [`NOBODY`].
    first: [u16; FUNCTIONS],
    /// `true`: several share a function code.
    is_shared: bool,
    pdos: S::Receive<Configured>,
    /// `true`: a frame waits for SYNC.
    waiting: bool,
    /// `true`: an error appeared or is gone, and was not taken yet.
    has_events: bool,
    /// No deadline is before it.
    next: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Configured {
    layout: Layout,
    /// The newest frame, if `waiting`.
    held: u64,
    deadline: Instant,
    /// Milliseconds.
    timeout: u16,
    /// Only taken within the synchronous window.
    synchronous: bool,
    /// Takes effect at the next SYNC.
    waits: bool,
    waiting: bool,
    /// A bit for each that is there.
    errors: u8,
    /// As they were taken last.
    taken: u8,
    /// Bytes of a frame that need only be unpacked; [`NOT_PLAIN`] if there is more to do.
    plain: u8,
}

/// No frame is as long.
const NOT_PLAIN: u8 = u8::MAX;

impl Configured {
    const INVALID: Configured = Configured {
        layout: Layout::EMPTY,
        held: 0,
        deadline: Instant::NEVER,
        timeout: 0,
        synchronous: false,
        waits: false,
        waiting: false,
        errors: 0,
        taken: 0,
        plain: NOT_PLAIN,
    };
}

impl Configured {
    /// Not valid any more. Its errors are gone, and the node has yet to report that.
    #[inline(never)] // smaller: it has two callers, all of them rare
    fn invalidate(&mut self) {
        *self = Configured { taken: self.taken, ..Configured::INVALID };
    }
}

impl<S: PdoSlots> Default for Rpdos<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: PdoSlots> Rpdos<S> {
    /// Makes the RPDOs of a node. None is valid.
    pub fn new() -> Self {
        Rpdos {
            ids: S::receive(Sealed::NONE),
            first: [NOBODY; FUNCTIONS],
            is_shared: false,
            pdos: S::receive(Configured::INVALID),
            waiting: false,
            has_events: false,
            next: Instant::NEVER,
        }
    }

    /// Makes all RPDOs invalid.
    pub fn clear(&mut self) {
        for (id, pdo) in self.ids.as_mut().iter_mut().zip(self.pdos.as_mut()) {
            *id = Sealed::NONE;
            pdo.invalidate();
            self.has_events |= pdo.taken != 0;
        }
        self.index();
    }

    /// Takes new values of objects 1400h + `number` and 1600h + `number`, resolved by [`rules::resolve`]. Drops a
    /// frame that waits for SYNC, resolves its errors, and starts the deadline with the next frame. `brings_time`:
    /// the PDO sets the time.
    ///
    /// # Errors
    /// [`AbortCode::NoObject`] for a `number` without a slot. Then nothing was changed.
    pub fn configure(
        &mut self,
        number: usize,
        parameters: &PdoParameters,
        resolved: Option<(CobId, Layout)>,
        brings_time: bool,
    ) -> Result<(), AbortCode> {
        let (Some(id), Some(pdo)) = (self.ids.as_mut().get_mut(number), self.pdos.as_mut().get_mut(number))
        else {
            return Err(AbortCode::NoObject);
        };
        pdo.invalidate();
        *id = Sealed::NONE;
        if let Some((new_id, layout)) = resolved {
            *id = Sealed::of(new_id);
            pdo.take(parameters, layout, brings_time);
            pdo.note_plain();
        }
        self.has_events |= pdo.taken != 0;
        self.index();
        Ok(())
    }

    /// Gives a valid RPDO the parameters again that it has. Nothing else changes.
    pub fn renew(&mut self, number: usize, parameters: &PdoParameters, layout: Layout, brings_time: bool) {
        if let Some(pdo) = self.pdos.as_mut().get_mut(number) {
            pdo.take(parameters, layout, brings_time);
            pdo.note_plain();
        }
    }

    /// Computes again what decides about each frame and each poll.
    pub fn refresh(&mut self) {
        self.index();
        self.pdos.as_mut().iter_mut().for_each(Configured::note_plain);
        self.next = Instant::ZERO;
    }

    /// The index, after one became valid or invalid.
    fn index(&mut self) {
        (self.first, self.is_shared) = ([NOBODY; FUNCTIONS], false);
        for (number, id) in (0..).zip(self.ids.as_ref()) {
            match self.first.get_mut(function(id.raw())) {
                Some(first) if *first == NOBODY => *first = number,
                Some(_) => self.is_shared = true,
                None => {}
            }
        }
    }

    /// Notes that Operational is left: drops frames that wait for SYNC and stops all deadlines. Errors last until
    /// a good frame.
    pub fn stop(&mut self) {
        for pdo in self.pdos.as_mut() {
            pdo.waiting = false;
            pdo.deadline = Instant::NEVER;
        }
        self.waiting = false;
        self.next = Instant::NEVER;
    }

    /// Returns the COB-ID of an RPDO, if it is valid and no bit of it has flipped.
    pub fn id(&self, number: usize) -> Option<CobId> {
        self.sealed(number).id()
    }

    /// Returns the COB-ID of an RPDO with its complement.
    pub(crate) fn sealed(&self, number: usize) -> Sealed {
        self.ids.as_ref().get(number).copied().unwrap_or(Sealed::NONE)
    }

    /// Returns the number of the first RPDO with this COB-ID.
    #[inline]
    pub fn first(&self, id: CobId) -> Option<usize> {
        let number = usize::from(*self.first.get(function(id.raw()))?);
        if self.ids.as_ref().get(number).is_some_and(|sealed| sealed.is(id)) {
            Some(number)
        } else {
            self.next(id, number)
        }
    }

    /// Returns the number of the next RPDO after `number` with this COB-ID.
    #[inline(always)]
    pub fn next(&self, id: CobId, number: usize) -> Option<usize> {
        if self.is_shared { self.search(id, number) } else { None }
    }

    #[cold]
    #[inline(never)]
    fn search(&self, id: CobId, number: usize) -> Option<usize> {
        let behind = self.ids.as_ref().iter().enumerate().skip(number.saturating_add(1));
        behind.into_iter().find(|(_, other)| other.is(id)).map(|(number, _)| number)
    }

    /// Handles a plain frame of this RPDO in Operational. A frame is plain if it takes effect at once, has no
    /// deadline, and neither it nor the frame before has an error. Returns whether it was plain. If not, call
    /// [`Rpdos::on_frame`]; the values may be in the dictionary already.
    #[inline(always)] // called from one place
    pub fn on_plain_frame<D: Objects>(&mut self, number: usize, frame: &Frame, objects: &mut D) -> bool {
        let pdo = self.pdos.as_ref().get(number).filter(|pdo| pdo.plain == frame.dlc());
        pdo.is_some_and(|pdo| pdo.layout.unpack(objects, frame.bits()))
    }

    /// Handles a frame of this RPDO that ended at `at`, in Operational. Frames of synchronous RPDOs are accepted
    /// until `window_end`, which is [`Instant::NEVER`] without a window.
    #[inline(always)] // called from one place
    pub fn on_frame<D: Objects>(
        &mut self,
        number: usize,
        frame: &Frame,
        at: Instant,
        window_end: Instant,
        objects: &mut D,
    ) -> Taken {
        let Some(pdo) = self.pdos.as_mut().get_mut(number) else { return Taken::Rejected };
        if pdo.synchronous && at > window_end {
            return Taken::OutsideWindow;
        }
        if frame.dlc() != pdo.layout.bytes() || pdo.errors != 0 {
            let is_accepted = pdo.accepts(frame.dlc());
            self.has_events |= pdo.has_events();
            if !is_accepted {
                return Taken::Rejected;
            }
        }
        if pdo.timeout != 0 {
            pdo.deadline = at + Duration::from_millis(u64::from(pdo.timeout));
            self.next = self.next.min(pdo.deadline);
        }
        if pdo.waits {
            (pdo.held, pdo.waiting, self.waiting) = (frame.bits(), true, true);
            Taken::Held
        } else {
            let all = pdo.apply(frame.bits(), objects);
            self.has_events |= pdo.has_events();
            if all { Taken::Applied } else { Taken::Refused }
        }
    }

    /// Returns whether a frame waits for SYNC.
    pub(crate) fn is_waiting(&self) -> bool {
        self.waiting
    }

    /// Handles a SYNC: frames that wait take effect. Calls `ended` with the number of each PDO and a
    /// flag: all its values were within their limits.
    pub fn on_sync<D: Objects>(&mut self, objects: &mut D, ended: &mut impl FnMut(usize, bool)) {
        self.waiting = false;
        for (number, pdo) in self.pdos.as_mut().iter_mut().enumerate() {
            if core::mem::take(&mut pdo.waiting) {
                let all = pdo.apply(pdo.held, objects);
                self.has_events |= pdo.has_events();
                ended(number, all);
            }
        }
    }

    /// Finds RPDOs that are overdue at `now`, each once until its next frame.
    pub fn poll(&mut self, now: Instant) {
        if now < self.next {
            return;
        }
        self.next = Instant::NEVER;
        for pdo in self.pdos.as_mut() {
            if pdo.deadline <= now {
                pdo.deadline = Instant::NEVER;
                pdo.set(RpdoError::Overdue, true);
                self.has_events |= pdo.has_events();
            }
            self.next = self.next.min(pdo.deadline);
        }
    }

    /// Returns whether an error appeared or is gone and was not taken yet.
    #[inline]
    pub fn has_events(&self) -> bool {
        self.has_events
    }

    /// Returns the next error that appeared or is gone, with the number of its PDO.
    pub fn take_event(&mut self) -> Option<(usize, RpdoEvent)> {
        for (number, pdo) in self.pdos.as_mut().iter_mut().enumerate() {
            let changed = pdo.errors ^ pdo.taken;
            if let Some(error) = RpdoError::ALL.into_iter().find(|error| changed & error.bit() != 0) {
                pdo.taken ^= error.bit();
                let is_there = pdo.errors & error.bit() != 0;
                return Some((
                    number,
                    if is_there { RpdoEvent::Error(error) } else { RpdoEvent::Resolved(error) },
                ));
            }
        }
        self.has_events = false;
        None
    }

    /// Returns when to poll next.
    pub fn deadline(&self) -> Option<Instant> {
        (self.next < Instant::NEVER).then_some(self.next)
    }
}

impl Configured {
    /// Takes the parameters of a valid RPDO.
    fn take(&mut self, parameters: &PdoParameters, layout: Layout, brings_time: bool) {
        self.layout = layout;
        self.timeout = parameters.event_timer;
        self.synchronous = rules::is_synchronous(parameters.transmission);
        self.waits = self.synchronous && !brings_time;
    }

    fn note_plain(&mut self) {
        let is_plain = !self.synchronous && self.timeout == 0 && self.errors == 0;
        self.plain = if is_plain { self.layout.bytes() } else { NOT_PLAIN };
    }

    /// Returns whether a frame of this length is processed. Updates the errors of the length.
    #[cold]
    #[inline(never)]
    fn accepts(&mut self, dlc: u8) -> bool {
        let is_enough = dlc >= self.layout.least();
        self.set(RpdoError::TooShort, !is_enough);
        self.set(RpdoError::TooLong, dlc > self.layout.bytes());
        if is_enough {
            self.set(RpdoError::Overdue, false);
        }
        is_enough
    }

    /// The values of a frame take effect. Returns whether all were within their limits.
    fn apply<D: Objects>(&mut self, data: u64, objects: &mut D) -> bool {
        let all = self.layout.unpack(objects, data);
        if !all || self.errors != 0 {
            self.set(RpdoError::OutOfRange, !all);
        }
        all
    }

    fn has_events(&self) -> bool {
        self.errors != self.taken
    }

    /// Notes an error that appears or goes.
    #[cold]
    #[inline(never)]
    fn set(&mut self, error: RpdoError, is_there: bool) {
        self.errors = if is_there { self.errors | error.bit() } else { self.errors & !error.bit() };
        self.note_plain();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdo::PdoObjects;
    use crate::sync::SyncObjects;

    const ID: CobId = CobId::new(0x205).unwrap();

    /// Given an RPDO with a deadline, when any bit of what is derived of its parameters flips, then it takes its frames after the
    /// next refresh, and is overdue in time.
    #[test]
    fn a_refreshed_rpdo_takes_its_frames_whatever_bit_has_flipped() {
        let parameters = PdoParameters { event_timer: 100, ..PdoParameters::default() };
        let at = Instant::from_micros(1_000_000);
        // Bits of the index of its function code, and of the earliest deadline.
        for bit in 0..16 + 64 {
            let mut rpdos = Rpdos::<PdoObjects<2, 1>>::new();
            rpdos.configure(0, &parameters, Some((ID, Layout::EMPTY)), false).unwrap();
            let frame = Frame::of(ID, []);
            rpdos.on_frame(0, &frame, at, Instant::NEVER, &mut SyncObjects::default());
            match bit {
                0..16 => rpdos.first[function(ID.raw())] ^= 1 << bit,
                _ => rpdos.next = Instant::from_micros(rpdos.next.as_micros() ^ 1 << (bit - 16)),
            }
            rpdos.refresh();
            assert_eq!(rpdos.first(ID), Some(0), "bit {bit}");
            rpdos.poll(at + Duration::from_millis(99));
            assert_eq!(rpdos.take_event(), None, "bit {bit}");
            rpdos.poll(at + Duration::from_millis(100));
            assert_eq!(rpdos.take_event(), Some((0, RpdoEvent::Error(RpdoError::Overdue))), "bit {bit}");
        }
    }

    /// Given two RPDOs, when one bit of the COB-ID of one of them or of its complement flips, then no frame is taken for
    /// it: neither the one that it had nor the one that it seems to have.
    ///
    /// Verifies: ECSS 6.10d
    #[test]
    fn no_frame_is_taken_while_a_bit_of_the_cob_id_is_wrong() {
        for (wrong, other) in [(0, 0x305), (0, 0x205), (1, 0x205)] {
            let mut rpdos = Rpdos::<PdoObjects<2, 1>>::new();
            for (number, id) in [(wrong, ID), (1 - wrong, CobId::new(other).unwrap())] {
                let parameters = PdoParameters::default();
                rpdos.configure(number, &parameters, Some((id, Layout::EMPTY)), false).unwrap();
            }
            let takes = |rpdos: &Rpdos<_>, id| {
                let first = rpdos.first(id);
                first == Some(wrong) || first.and_then(|first| rpdos.next(id, first)) == Some(wrong)
            };
            assert!(takes(&rpdos, ID));
            for flipped in Sealed::of(ID).flipped() {
                rpdos.ids.as_mut()[wrong] = flipped;
                for id in (0..=0x7FF).filter_map(CobId::new) {
                    assert!(!takes(&rpdos, id), "{id:?} as {flipped:?}");
                }
            }
        }
    }
}
