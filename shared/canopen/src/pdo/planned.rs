//! PDO of a set: its number, its transmission type and what it carries.

use super::carried::Carried;
use super::cob_id_of::{CobIdOf, OWN_EMCY};
use super::{Direction, rules};
use crate::od::{Access, Entry, Reason};

/// Receive PDO of a [`PdoSet`](super::PdoSet), made by [`Pdo::receive`](super::Pdo::receive).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rpdo(Planned);

/// Transmit PDO of a [`PdoSet`](super::PdoSet), made by [`Pdo::transmit`](super::Pdo::transmit).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tpdo(Planned);

/// PDO of either direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Planned {
    number: u16,
    pub cob_id: CobIdOf,
    pub transmission: u8,
    pub sync_start: u8,
    pub inhibit: u16,
    pub event_timer: u16,
    is_state: bool,
    carried: Carried,
}

impl Rpdo {
    /// Transmission type 254: values take effect when they arrive.
    #[track_caller]
    pub(super) const fn new(number: u16, cob_id: CobIdOf, carried: Carried) -> Rpdo {
        Rpdo(Planned::new(number, cob_id, carried))
    }

    /// Sets the transmission type. 0 to 240: values take effect at the next SYNC. 254 and 255: when they arrive.
    ///
    /// # Panics
    /// For 241 to 253. In a constant all panics of this module are compile errors.
    #[track_caller]
    pub const fn transmission(self, transmission: u8) -> Rpdo {
        Rpdo(self.0.transmission(transmission))
    }

    /// Sets the event timer: the longest time between two frames, in milliseconds. Zero: no limit.
    pub const fn event_timer(self, ms: u16) -> Rpdo {
        Rpdo(Planned { event_timer: ms, ..self.0 })
    }

    pub(crate) const fn pdo(&self) -> &Planned {
        &self.0
    }
}

/// Longest time between two frames of a state, milliseconds.
const STATE_TIMER: u16 = 10_000;

impl Tpdo {
    /// Transmission type 254: sent on an event of the application.
    #[track_caller]
    pub(super) const fn new(number: u16, cob_id: CobIdOf, carried: Carried) -> Tpdo {
        if cob_id.may_equal(OWN_EMCY) {
            let id = cob_id.tell().text(" is that of the node's own EMCY: allowed are ");
            id.text("181h to 580h, 600h, 680h to 6DFh and 700h").refuse();
        }
        Tpdo(Planned::new(number, cob_id, carried))
    }

    /// Sets the transmission type. 0: at the SYNC after an event. 1 to 240: at every n-th SYNC. 254 and 255: on
    /// an event.
    ///
    /// # Panics
    /// For 241 to 253: remote requests (252, 253) are not supported.
    #[track_caller]
    pub const fn transmission(self, transmission: u8) -> Tpdo {
        Tpdo(self.0.transmission(transmission))
    }

    /// Sets the inhibit time: the least time between two events, in multiples of 100 us.
    pub const fn inhibit(self, inhibit: u16) -> Tpdo {
        Tpdo(Planned { inhibit, ..self.0 })
    }

    /// Sets the event timer: the longest time between two frames, in milliseconds. Zero: no limit.
    pub const fn event_timer(self, ms: u16) -> Tpdo {
        Tpdo(Planned { event_timer: ms, ..self.0 })
    }

    /// Declares that the values are a state: the latest ones are worth sending, whenever they changed. A PDO that is sent
    /// on events then sends its present values when Operational is entered, after a change of the bus, and after a frame
    /// of it was not sent. It also gets an event timer of 10 s, if it has none: a contact that opens for the time of one frame
    /// may lose the last change. Do not declare a command, or an answer to a request: one that comes late does harm.
    pub const fn state(self) -> Tpdo {
        let event_timer = if self.0.event_timer == 0 { STATE_TIMER } else { self.0.event_timer };
        Tpdo(Planned { is_state: true, event_timer, ..self.0 })
    }

    /// Sets the counter of the first SYNC that counts. Zero: any.
    ///
    /// # Panics
    /// Above 240.
    #[track_caller]
    pub const fn sync_start(self, counter: u8) -> Tpdo {
        if counter > 240 {
            let value = Reason::new("SYNC start value ").number(counter as u32);
            value.text(": allowed are 0 to 240").refuse();
        }
        Tpdo(Planned { sync_start: counter, ..self.0 })
    }

    pub(crate) const fn pdo(&self) -> &Planned {
        &self.0
    }
}

impl Planned {
    #[track_caller]
    const fn new(number: u16, cob_id: CobIdOf, carried: Carried) -> Planned {
        if !matches!(number, 1..=512) {
            Reason::new("PDO number ").number(number as u32).text(": allowed are 1 to 512").refuse();
        }
        Planned {
            number,
            cob_id,
            transmission: 254,
            sync_start: 0,
            inhibit: 0,
            event_timer: 0,
            is_state: false,
            carried,
        }
    }

    #[track_caller]
    const fn transmission(self, transmission: u8) -> Planned {
        if !rules::is_transmission_type(transmission) {
            let value = Reason::new("transmission type ").number(transmission as u32);
            value.text(": allowed are 0 to 240, 254 and 255").refuse();
        }
        Planned { transmission, ..self }
    }

    /// Begins a text: `kind` is R or T.
    pub(super) const fn tell(&self, kind: &str) -> Reason {
        Reason::new(kind).text("PDO ").number(self.number as u32)
    }

    pub const fn slot(&self) -> usize {
        self.number as usize - 1
    }

    /// Returns whether its values are declared as a state.
    pub const fn is_state(&self) -> bool {
        self.is_state
    }

    pub(super) const fn carried(&self) -> &Carried {
        &self.carried
    }

    /// Returns the mapped values in the form of objects 1600h and 1A00h.
    pub fn mapping(&self) -> &[u32] {
        self.carried.mapping()
    }
}

impl Direction {
    /// Returns the first letter of the names of its PDOs.
    pub(super) const fn letter(self) -> &'static str {
        match self {
            Direction::Receive => "R",
            Direction::Transmit => "T",
        }
    }

    /// Returns whether PDOs of this direction may carry a value.
    pub(super) const fn carries(self, entry: &Entry) -> bool {
        entry.is_mappable() && self.allows(entry.access)
    }

    /// Returns whether PDOs of this direction may carry a value with this access right.
    pub(super) const fn allows(self, access: Access) -> bool {
        match self {
            Direction::Receive => access.is_for_rpdo(),
            Direction::Transmit => access.is_for_tpdo(),
        }
    }
}
