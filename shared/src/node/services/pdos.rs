//! PDOs as the dictionary has them: what a client writes, what defaults and the application want, and what of it can be.

use super::{Dictionary, rules};
use crate::emcy;
use crate::emcy::{EmcyObjects, ErrorCode};
use crate::node::index::{LAST_RPDO, LAST_RPDO_MAPPING, LAST_TPDO, RPDO, TPDO};
use crate::node::{Device, Extension, NodeObjects};
use crate::od::INVALID;
use crate::pdo::{Direction, Mapping, PdoSlots, RpdoEvent, RpdoParameters, TpdoParameters, rules as pdo};
use crate::types::{AbortCode, Address, Frame, Instant, NmtState};

impl<D: Device, E: Extension> Dictionary<D, E> {
    /// The PDOs of this number are not valid.
    pub fn unset_pdos(&mut self, number: usize, now: Instant) {
        let Dictionary { emcy, rpdos, tpdos, .. } = self;
        let mut report_event = |number, event| note(emcy, number, event);
        let none = &RpdoParameters::default();
        let _ = rpdos.configure::<NodeObjects<D, E>>(number, none, &[], &mut report_event);
        let _ = tpdos.configure::<NodeObjects<D, E>>(number, &TpdoParameters::default(), &[], now);
    }

    /// The PDOs of this number, which are not valid, as the objects have them. What cannot be reads so (bit 31 of its COB-ID)
    /// and is an error until it can, or is not to be.
    pub fn set_pdos(&mut self, number: usize, now: Instant) {
        let Dictionary { objects, emcy, rpdos, tpdos, .. } = self;
        let NodeObjects { communication, pdos, .. } = objects;
        let mut report_event = |number, event| note(emcy, number, event);
        let (sync, emergency) = (communication.sync.cob_id, communication.emcy.cob_id);
        let (parameters, mappings) = pdos.rpdos();
        let receives = parameters.get(number).zip(mappings.get(number));
        let received = receives.map(|(pdo, mapping)| {
            rules::check_pdo(Direction::Receive, sync, emergency, pdo.cob_id)?;
            rpdos.configure::<NodeObjects<D, E>>(number, pdo, mapping.objects(), &mut report_event)
        });
        let (parameters, mappings) = pdos.tpdos();
        let sends = parameters.get(number).zip(mappings.get(number));
        let sent = sends.map(|(pdo, mapping)| {
            rules::check_pdo(Direction::Transmit, sync, emergency, pdo.cob_id)?;
            tpdos.configure::<NodeObjects<D, E>>(number, pdo, mapping.objects(), now)
        });
        if let Some((outcome, pdo)) = received.zip(pdos.rpdos_mut().0.get_mut(number)) {
            report(emcy, Direction::Receive, number, outcome, &mut pdo.cob_id);
        }
        if let Some((outcome, pdo)) = sent.zip(pdos.tpdos_mut().0.get_mut(number)) {
            report(emcy, Direction::Transmit, number, outcome, &mut pdo.cob_id);
        }
    }

    /// A client configured a PDO: what its defaults or its application had wrong is past.
    fn pdo_is_possible(&mut self, direction: Direction, number: usize) {
        self.emcy.clear(ErrorCode::DATA_SET, source_of(direction, number));
        self.objects.communication.emcy.show(&self.emcy);
    }

    /// A write to the parameters of a PDO: the service takes them over, or refuses them.
    pub(super) fn configure_pdo(&mut self, at: Address, value: u32) -> Result<(), AbortCode> {
        let number = usize::from(at.index & 0x1FF);
        let NodeObjects { communication, pdos, .. } = &mut self.objects;
        let (sync, emergency) = (communication.sync.cob_id, communication.emcy.cob_id);
        if at.index <= LAST_RPDO_MAPPING {
            let direction = Direction::Receive;
            let (parameters, mappings) = pdos.rpdos_mut();
            let pdo = parameters.get(number).zip(mappings.get_mut(number));
            let (present, mapping) = pdo.ok_or(AbortCode::NoObject)?;
            if at.index > LAST_RPDO {
                return pdo::mapping::<NodeObjects<D, E>>(direction, present.cob_id, mapping, at.sub, value);
            }
            let new = pdo::rpdo(present, at.sub, value)?;
            rules::check_pdo(direction, sync, emergency, new.cob_id)?;
            let (emcy, mapping) = (&mut self.emcy, mapping.objects());
            let mut report_event = |number, event| note(emcy, number, event);
            self.rpdos.configure::<NodeObjects<D, E>>(number, &new, mapping, &mut report_event)?;
            self.pdo_is_possible(direction, number);
        } else {
            let direction = Direction::Transmit;
            let (parameters, mappings) = pdos.tpdos_mut();
            let pdo = parameters.get(number).zip(mappings.get_mut(number));
            let (present, mapping) = pdo.ok_or(AbortCode::NoObject)?;
            if at.index > LAST_TPDO {
                return pdo::mapping::<NodeObjects<D, E>>(direction, present.cob_id, mapping, at.sub, value);
            }
            let new = pdo::tpdo(present, at.sub, value)?;
            rules::check_pdo(direction, sync, emergency, new.cob_id)?;
            self.tpdos.configure::<NodeObjects<D, E>>(number, &new, mapping.objects(), self.now)?;
            self.pdo_is_possible(direction, number);
        }
        Ok(())
    }

    /// Synchronous RPDOs at a SYNC: the number of each, and whether all its values were taken. Returns whether emergencies
    /// report any.
    #[inline(always)] // called from one place
    pub(super) fn actuate(&mut self, ended: &mut impl FnMut(usize, bool)) -> bool {
        let Dictionary { objects, emcy, rpdos, .. } = self;
        let mut is_told = false;
        rpdos.on_sync(objects, ended, &mut |objects, number, event| {
            is_told = true;
            report_rpdo(emcy, &mut objects.communication.emcy, number, event);
        });
        is_told
    }

    /// Receive PDOs that are overdue, and emergencies.
    pub(super) fn poll(&mut self, now: Instant, state: NmtState, send: &mut impl FnMut(Frame)) {
        let Dictionary { objects, emcy, rpdos, .. } = self;
        rpdos.poll(now, &mut |number, event| {
            report_rpdo(emcy, &mut objects.communication.emcy, number, event)
        });
        while let Some(frame) = emcy.poll(now, state) {
            send(frame);
        }
    }
}

/// Source of the error that a PDO cannot be: 1 to 127 the first RPDOs, 129 to 255 the first TPDOs. Those beyond share the
/// last one; the index follows in the message.
fn source_of(direction: Direction, number: usize) -> u8 {
    match direction {
        Direction::Receive => number.saturating_add(1).min(127) as u8,
        Direction::Transmit => number.saturating_add(129).min(255) as u8,
    }
}

/// Whether a PDO of the objects could be: if not, its COB-ID reads "not valid", and an emergency names the PDO, the index of
/// its parameters, and the low half of the abort code that a client would get.
fn report(
    emcy: &mut emcy::Producer,
    direction: Direction,
    number: usize,
    outcome: Result<(), AbortCode>,
    cob_id: &mut u32,
) {
    let source = source_of(direction, number);
    let first = if direction == Direction::Receive { RPDO } else { TPDO };
    let [low, high] = first.wrapping_add(number as u16).to_le_bytes();
    match outcome {
        Ok(()) => _ = emcy.clear(ErrorCode::DATA_SET, source),
        Err(code) => {
            *cob_id |= INVALID;
            let [code_low, code_high, ..] = code.code().to_le_bytes();
            emcy.raise(ErrorCode::DATA_SET, [source, low, high, code_low, code_high]);
        }
    }
}

/// Raises or clears the error of an RPDO, and shows it in the dictionary. Its source is the number of the PDO.
pub fn report_rpdo(emcy: &mut emcy::Producer, objects: &mut EmcyObjects, number: usize, event: RpdoEvent) {
    note(emcy, number, event);
    objects.show(emcy);
}

/// Raises or clears the error of an RPDO; the dictionary does not show it yet.
fn note(emcy: &mut emcy::Producer, number: usize, event: RpdoEvent) {
    // One byte; those that are too many share the last one.
    let source = number.min(usize::from(u8::MAX)) as u8;
    match event {
        RpdoEvent::Error(error) => _ = emcy.raise(error.code(), [source, 0, 0, 0, 0]),
        RpdoEvent::Resolved(error) => _ = emcy.clear(error.code(), source),
    }
}
