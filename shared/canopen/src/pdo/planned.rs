//! A PDO of a set: number, COB-ID, transmission type and mapped values, checked when the constant is built.

use super::cob_id_of::{CobIdOf, OWN_EMCY};
use super::{Direction, MAPPED, rules};
use crate::od::{DataType, Entry, Field, Reason};
use crate::types::Address;

/// Receive PDO of a [`PdoSet`](super::PdoSet).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rpdo(Pdo);

/// Transmit PDO of a [`PdoSet`](super::PdoSet).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tpdo(Pdo);

/// PDO of either direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pdo {
    number: u16,
    pub cob_id: CobIdOf,
    pub transmission: u8,
    pub sync_start: u8,
    pub inhibit: u16,
    pub event_timer: u16,
    is_state: bool,
    bits: u8,
    count: u8,
    mapping: [u32; MAPPED],
}

impl Rpdo {
    /// Makes receive PDO 1 to 512 with this COB-ID and transmission type 254: values take effect when they arrive.
    ///
    /// # Panics
    /// For another number, and for the COB-ID of SYNC. In a constant all panics of this module are compile errors.
    #[track_caller]
    pub const fn new(number: u16, cob_id: CobIdOf) -> Rpdo {
        Rpdo(Pdo::new(number, cob_id))
    }

    /// Sets the transmission type. 0 to 240: values take effect at the next SYNC. 254 and 255: when they arrive.
    ///
    /// # Panics
    /// For 241 to 253.
    #[track_caller]
    pub const fn transmission(self, transmission: u8) -> Rpdo {
        Rpdo(self.0.transmission(transmission))
    }

    /// Sets the event timer: the longest time between two frames, in milliseconds. Zero: no limit.
    pub const fn event_timer(self, ms: u16) -> Rpdo {
        Rpdo(Pdo { event_timer: ms, ..self.0 })
    }

    /// Maps this value behind those that are mapped already.
    ///
    /// # Panics
    /// If no receive PDO may carry the value, after 8 values, or beyond 64 bits.
    #[track_caller]
    pub const fn map<T, R, W>(self, field: Field<T, R, W>) -> Rpdo {
        Rpdo(self.0.map(Direction::Receive, field))
    }

    /// Skips the bits of a value of this type (CiA 301 7.4.8.2, dummy mapping).
    ///
    /// # Panics
    /// For a type without a dummy entry, after 8 values, or beyond 64 bits.
    #[track_caller]
    pub const fn skip(self, data_type: DataType) -> Rpdo {
        match (DataType::of_dummy(data_type.index()), data_type.bits()) {
            (Some(_), Some(bits)) => Rpdo(self.0.entry("R", Address::new(data_type.index(), 0), bits)),
            _ => panic!("only BOOLEAN and integers of 8, 16 and 32 bits can be skipped"),
        }
    }

    /// Returns the number of the PDO in the device, from zero, as events report it.
    pub const fn slot(&self) -> usize {
        self.0.slot()
    }

    pub(crate) const fn pdo(&self) -> &Pdo {
        &self.0
    }
}

/// Longest time between two frames of a state, milliseconds.
const STATE_TIMER: u16 = 10_000;

impl Tpdo {
    /// Makes transmit PDO 1 to 512 with this COB-ID and transmission type 254: sent on an event of the
    /// application.
    ///
    /// # Panics
    /// For another number, and for the COB-ID of SYNC or of the node's own EMCY.
    #[track_caller]
    pub const fn new(number: u16, cob_id: CobIdOf) -> Tpdo {
        if cob_id.may_equal(OWN_EMCY) {
            let id = cob_id.tell().text(" is that of the node's own EMCY: allowed are ");
            id.text("181h to 580h, 600h, 680h to 6DFh and 700h").refuse();
        }
        Tpdo(Pdo::new(number, cob_id))
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
        Tpdo(Pdo { inhibit, ..self.0 })
    }

    /// Sets the event timer: the longest time between two frames, in milliseconds. Zero: no limit.
    pub const fn event_timer(self, ms: u16) -> Tpdo {
        Tpdo(Pdo { event_timer: ms, ..self.0 })
    }

    /// Declares that the values are a state: the latest ones are worth sending, whenever they changed. A PDO that is sent
    /// on events then sends its present values when Operational is entered, after a change of the bus, and after a frame
    /// of it was not sent. It also gets an event timer of 10 s, if it has none: a contact that opens for the time of one frame
    /// may lose the last change. Do not declare a command, or an answer to a request: one that comes late does harm.
    pub const fn state(self) -> Tpdo {
        let event_timer = if self.0.event_timer == 0 { STATE_TIMER } else { self.0.event_timer };
        Tpdo(Pdo { is_state: true, event_timer, ..self.0 })
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
        Tpdo(Pdo { sync_start: counter, ..self.0 })
    }

    /// Maps this value behind those that are mapped already.
    ///
    /// # Panics
    /// If no transmit PDO may carry the value, after 8 values, or beyond 64 bits.
    #[track_caller]
    pub const fn map<T, R, W>(self, field: Field<T, R, W>) -> Tpdo {
        Tpdo(self.0.map(Direction::Transmit, field))
    }

    /// Returns the number of the PDO in the device, from zero, as events and requests use it.
    pub const fn slot(&self) -> usize {
        self.0.slot()
    }

    pub(crate) const fn pdo(&self) -> &Pdo {
        &self.0
    }
}

impl Pdo {
    #[track_caller]
    const fn new(number: u16, cob_id: CobIdOf) -> Pdo {
        if !matches!(number, 1..=512) {
            Reason::new("PDO number ").number(number as u32).text(": allowed are 1 to 512").refuse();
        }
        Pdo {
            number,
            cob_id,
            transmission: 254,
            sync_start: 0,
            inhibit: 0,
            event_timer: 0,
            is_state: false,
            bits: 0,
            count: 0,
            mapping: [0; MAPPED],
        }
    }

    #[track_caller]
    const fn transmission(self, transmission: u8) -> Pdo {
        if !rules::is_transmission_type(transmission) {
            let value = Reason::new("transmission type ").number(transmission as u32);
            value.text(": allowed are 0 to 240, 254 and 255").refuse();
        }
        Pdo { transmission, ..self }
    }

    #[track_caller]
    const fn map<T, R, W>(self, direction: Direction, field: Field<T, R, W>) -> Pdo {
        let (at, entry) = (field.address(), field.entry());
        let object = tell_object(Reason::new(""), at);
        let Some(bits) = entry.data_type.bits() else {
            object.text(" has a type without fixed size: no PDO carries it").refuse()
        };
        if !entry.is_mappable() {
            object.text(" is not for PDOs: add `pdo` to its declaration").refuse();
        }
        if !direction.carries(entry) {
            let allowed = match direction {
                Direction::Receive => "`: a receive PDO carries `wo`, `rw` and `rww`",
                Direction::Transmit => "`: a transmit PDO carries `ro`, `rw`, `rwr` and `constant`",
            };
            object.text(" is `").text(entry.access.word()).text(allowed).refuse();
        }
        self.entry(direction.letter(), at, bits)
    }

    #[track_caller]
    const fn entry(mut self, kind: &str, at: Address, bits: u8) -> Pdo {
        let all = self.bits as u32 + bits as u32;
        if self.count as usize >= MAPPED {
            let with = tell_object(self.tell(kind).text(" has 8 values before "), at);
            with.text(": at most 8 are allowed").refuse();
        }
        if all > u64::BITS {
            let with = tell_object(self.tell(kind).text(" with "), at).text(" has ").number(all);
            with.text(" bits: at most 64 are allowed").refuse();
        }
        self.mapping[self.count as usize] = (at.index as u32) << 16 | (at.sub as u32) << 8 | bits as u32;
        (self.count, self.bits) = (self.count + 1, all as u8);
        self
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

    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Address and bits of a value that it carries; `None` behind the last.
    pub(super) const fn nth(&self, nth: usize) -> Option<(Address, u8)> {
        if nth >= self.count as usize {
            return None;
        }
        let [index_high, index_low, sub, bits] = self.mapping[nth].to_be_bytes();
        Some((Address::new(u16::from_be_bytes([index_high, index_low]), sub), bits))
    }

    /// Returns the mapped values in the form of objects 1600h and 1A00h.
    pub fn mapping(&self) -> &[u32] {
        self.mapping.get(..usize::from(self.count)).unwrap_or(&self.mapping)
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
        let is_allowed = match self {
            Direction::Receive => entry.access.is_for_rpdo(),
            Direction::Transmit => entry.access.is_for_tpdo(),
        };
        entry.is_mappable() && is_allowed
    }
}

/// Adds an object to a text.
pub(super) const fn tell_object(before: Reason, at: Address) -> Reason {
    before.text("object ").hex(at.index, 4).text(" sub-index ").number(at.sub as u32)
}
