//! Receive PDOs: frames into the dictionary (CiA 301 7.2.2, ECSS 6.2, 6.9).
//!
//! * Types 0 to 240 take effect at the next SYNC, the newest frame of each PDO; 254 and 255 at once.
//! * A frame with fewer bytes than are mapped is not processed. One with more is, as far as it is mapped. A value outside
//!   of its limits is not written, the others of its frame are. All three are errors of their PDO, told when they appear
//!   and when they are gone.
//! * The event timer is a deadline. It runs from each good frame to the next, the first time from the first one in
//!   Operational, or after it was configured.
//! * Two PDOs may have one COB-ID: both take the frame, in the order of their numbers.

use super::{Direction, Layout, rules};
use crate::emcy::ErrorCode;
use crate::link::{CobId, CobIdEntry, Frame};
use crate::od::communication::RpdoParameters;
use crate::od::{AbortCode, Objects};
use crate::time::{Duration, Instant};

/// What is wrong with an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RpdoError {
    /// The last frame had fewer bytes than are mapped; it was not processed.
    TooShort,
    /// The last frame had more bytes than are mapped.
    TooLong,
    /// No frame came in time.
    Overdue,
    /// A value was outside of its limits; it was not written.
    OutOfRange,
}

impl RpdoError {
    const ALL: [RpdoError; 4] =
        [RpdoError::TooShort, RpdoError::TooLong, RpdoError::Overdue, RpdoError::OutOfRange];

    const fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The emergency that tells of it.
    pub const fn code(self) -> ErrorCode {
        match self {
            RpdoError::TooShort => ErrorCode::PDO_LENGTH,
            RpdoError::TooLong => ErrorCode::PDO_LENGTH_EXCEEDED,
            RpdoError::Overdue => ErrorCode::RPDO_TIMEOUT,
            RpdoError::OutOfRange => ErrorCode::PROTOCOL,
        }
    }
}

/// What became of an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RpdoEvent {
    /// Its values are in the dictionary, those that keep their limits.
    Applied,
    /// A frame with fewer bytes than are mapped was not processed; told for each.
    Rejected,
    /// A synchronous one came after the synchronous window (1007h) and was discarded.
    OutsideWindow,
    /// An error appeared.
    Error(RpdoError),
    /// An error is gone.
    Resolved(RpdoError),
}

/// The COB-ID of an RPDO that is not valid: that of no frame.
const NONE: u16 = u16::MAX;
/// Function codes: the upper four bits of a COB-ID.
const FUNCTIONS: usize = 16;
/// No RPDO has this function code.
const NOBODY: u8 = u8::MAX;
/// More than one has, or one whose number is too high.
const SEVERAL: u8 = u8::MAX - 1;

/// Of a COB-ID; none of [`NONE`].
const fn function(id: u16) -> usize {
    id as usize >> 7
}

/// All RPDOs of a node.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Rpdos<const R: usize> {
    ids: [u16; R],
    /// Which one has a COB-ID with this function code, so that a frame is not compared with all: the pre-defined
    /// connection set has at most one. Or [`NOBODY`], or [`SEVERAL`].
    candidates: [u8; FUNCTIONS],
    pdos: [Rpdo; R],
    /// Whether any frame waits for SYNC.
    waiting: bool,
    window_end: Instant,
    /// No deadline is before it.
    next: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Rpdo {
    layout: Layout,
    /// The newest frame, if `waiting`.
    held: u64,
    deadline: Instant,
    /// Milliseconds.
    timeout: u16,
    synchronous: bool,
    waiting: bool,
    /// A bit for each that is there.
    errors: u8,
}

impl Rpdo {
    const INVALID: Rpdo = Rpdo {
        layout: Layout::EMPTY,
        held: 0,
        deadline: Instant::NEVER,
        timeout: 0,
        synchronous: false,
        waiting: false,
        errors: 0,
    };
}

impl<const R: usize> Default for Rpdos<R> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const R: usize> Rpdos<R> {
    /// None is valid.
    pub const fn new() -> Self {
        Rpdos {
            ids: [NONE; R],
            candidates: [NOBODY; FUNCTIONS],
            pdos: [Rpdo::INVALID; R],
            waiting: false,
            window_end: Instant::NEVER,
            next: Instant::NEVER,
        }
    }

    /// New values of objects 1400h + `number` and 1600h + `number`. What was held is gone, its errors are resolved, the
    /// deadline waits for the next frame.
    ///
    /// # Errors
    /// As [`rules::activate`], [`AbortCode::NoObject`] for a `number` of `R` and above. Nothing was changed.
    pub fn configure<D: Objects>(
        &mut self,
        number: usize,
        parameters: &RpdoParameters,
        mapping: &[u32],
        tell: &mut impl FnMut(usize, RpdoEvent),
    ) -> Result<(), AbortCode> {
        let (Some(id), Some(pdo)) = (self.ids.get_mut(number), self.pdos.get_mut(number)) else {
            return Err(AbortCode::NoObject);
        };
        let (new_id, new) = match CobIdEntry::from_raw(parameters.cob_id).cob_id() {
            None => (NONE, Rpdo::INVALID),
            Some(id) => {
                let layout = rules::activate::<D>(Direction::Receive, parameters.transmission, mapping)?;
                let synchronous = rules::is_synchronous(parameters.transmission);
                (id.raw(), Rpdo { layout, timeout: parameters.event_timer, synchronous, ..Rpdo::INVALID })
            }
        };
        for error in RpdoError::ALL {
            pdo.set(error, false, |event| tell(number, event));
        }
        (*id, *pdo) = (new_id, new);
        self.index();
        Ok(())
    }

    /// The index, after `number` became valid or invalid.
    fn index(&mut self) {
        self.candidates = [NOBODY; FUNCTIONS];
        for (number, id) in (0_u16..).zip(&self.ids) {
            if let Some(candidate) = self.candidates.get_mut(function(*id)) {
                let number = u8::try_from(number).unwrap_or(SEVERAL).min(SEVERAL);
                *candidate = if *candidate == NOBODY { number } else { SEVERAL };
            }
        }
    }

    /// The COB-IDs of valid ones.
    pub fn ids(&self) -> impl Iterator<Item = CobId> + '_ {
        self.ids.iter().filter_map(|id| CobId::new(*id))
    }

    /// The mapping of a valid one.
    pub fn layout(&self, number: usize) -> Option<&Layout> {
        self.ids.get(number).filter(|id| **id != NONE)?;
        Some(&self.pdos.get(number)?.layout)
    }

    /// Operational is left: what is held is gone, no deadline runs. Errors stay until a good frame comes.
    pub fn stop(&mut self) {
        for pdo in &mut self.pdos {
            pdo.waiting = false;
            pdo.deadline = Instant::NEVER;
        }
        self.waiting = false;
        self.window_end = Instant::NEVER;
        self.next = Instant::NEVER;
    }

    /// A frame that ended `at`, in Operational. Returns whether it is an RPDO.
    #[inline(always)] // called from one place
    pub fn on_frame<D: Objects>(
        &mut self,
        frame: &Frame,
        at: Instant,
        objects: &mut D,
        tell: &mut impl FnMut(&mut D, usize, RpdoEvent),
    ) -> bool {
        let id = frame.id().raw();
        let candidate = *self.candidates.get(function(id)).unwrap_or(&NOBODY);
        let numbers = match usize::from(candidate) {
            _ if candidate == SEVERAL => 0..R,
            number => number..number.saturating_add(1),
        };
        let mut is_mine = false;
        for number in numbers {
            if self.ids.get(number) == Some(&id) {
                self.take(number, frame, at, objects, tell);
                is_mine = true;
            }
        }
        is_mine
    }

    #[inline(always)] // called from one place
    fn take<D: Objects>(
        &mut self,
        number: usize,
        frame: &Frame,
        at: Instant,
        objects: &mut D,
        tell: &mut impl FnMut(&mut D, usize, RpdoEvent),
    ) {
        let Some(pdo) = self.pdos.get_mut(number) else { return };
        if (frame.dlc() != pdo.layout.bytes() || pdo.errors != 0)
            && !pdo.accepts(frame.dlc(), |event| tell(objects, number, event))
        {
            return tell(objects, number, RpdoEvent::Rejected);
        }
        if pdo.timeout != 0 {
            pdo.deadline = at + Duration::from_millis(u64::from(pdo.timeout));
            self.next = self.next.min(pdo.deadline);
        }
        let data = u64::from_le_bytes(frame.padded());
        if !pdo.synchronous {
            pdo.apply(data, number, objects, tell);
        } else if at <= self.window_end {
            pdo.held = data;
            pdo.waiting = true;
            self.waiting = true;
        } else {
            tell(objects, number, RpdoEvent::OutsideWindow);
        }
    }

    /// SYNC: what is held takes effect (ECSS 6.9e). Synchronous ones are taken up to `window_end`, or
    /// [`Instant::NEVER`] without a window.
    pub fn on_sync<D: Objects>(
        &mut self,
        window_end: Instant,
        objects: &mut D,
        tell: &mut impl FnMut(&mut D, usize, RpdoEvent),
    ) {
        self.window_end = window_end;
        if !core::mem::take(&mut self.waiting) {
            return;
        }
        for (number, pdo) in self.pdos.iter_mut().enumerate() {
            if core::mem::take(&mut pdo.waiting) {
                pdo.apply(pdo.held, number, objects, tell);
            }
        }
    }

    /// Tells of those that are overdue at `now`, once until their next frame.
    pub fn poll(&mut self, now: Instant, tell: &mut impl FnMut(usize, RpdoEvent)) {
        if now < self.next {
            return;
        }
        self.next = Instant::NEVER;
        for (number, pdo) in self.pdos.iter_mut().enumerate() {
            if pdo.deadline <= now {
                pdo.deadline = Instant::NEVER;
                pdo.set(RpdoError::Overdue, true, |event| tell(number, event));
            }
            self.next = self.next.min(pdo.deadline);
        }
    }

    /// When to poll next.
    pub fn deadline(&self) -> Option<Instant> {
        (self.next < Instant::NEVER).then_some(self.next)
    }
}

impl Rpdo {
    /// Whether a frame of this length is processed. Errors appear and go with it.
    #[cold]
    #[inline(never)]
    fn accepts(&mut self, dlc: u8, mut tell: impl FnMut(RpdoEvent)) -> bool {
        let bytes = self.layout.bytes();
        self.set(RpdoError::TooShort, dlc < bytes, &mut tell);
        self.set(RpdoError::TooLong, dlc > bytes, &mut tell);
        if dlc >= bytes {
            self.set(RpdoError::Overdue, false, tell);
        }
        dlc >= bytes
    }

    /// The values of a frame take effect.
    fn apply<D: Objects>(
        &mut self,
        data: u64,
        number: usize,
        objects: &mut D,
        tell: &mut impl FnMut(&mut D, usize, RpdoEvent),
    ) {
        let all = self.layout.unpack(objects, data);
        if !all || self.errors != 0 {
            self.set(RpdoError::OutOfRange, !all, |event| tell(objects, number, event));
        }
        tell(objects, number, RpdoEvent::Applied);
    }

    /// Tells of an error that appears or goes.
    fn set(&mut self, error: RpdoError, is_there: bool, mut tell: impl FnMut(RpdoEvent)) {
        if is_there != (self.errors & error.bit() != 0) {
            self.errors ^= error.bit();
            tell(if is_there { RpdoEvent::Error(error) } else { RpdoEvent::Resolved(error) });
        }
    }
}
