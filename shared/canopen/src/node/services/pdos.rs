//! Applies the PDO configuration from SDO, from defaults and from the application.

use super::{Dictionary, Services, rules};
use crate::emcy;
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::device::has_states;
use crate::node::index::{LAST_RPDO, LAST_RPDO_MAPPING, LAST_TPDO, RPDO, TPDO};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::turn::Wakes;
use crate::od::{CobIdEntry, INVALID};
use crate::pdo::{Direction, Mapping, PdoParameters, PdoSlots, RpdoEvent, rules as pdo};
use crate::types::{AbortCode, Address, CobId, Frame, Instant, NmtState};

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Sends all states of the application from `at` on.
    pub(crate) fn send_states(&mut self, at: Instant) {
        if const { has_states::<D>() } {
            self.dictionary.tpdos.change(&mut self.wakes).send_states(at);
        }
    }

    /// Returns whether the node sends this COB-ID: in its emergencies or in a valid transmit PDO.
    pub fn sends(&self, id: CobId) -> bool {
        let objects = &self.dictionary.objects;
        let pdos = objects.pdos.tpdos().0.iter().map(|pdo| pdo.cob_id);
        let mut all = pdos.chain([objects.communication.emcy.cob_id]);
        all.any(|entry| CobIdEntry::from_raw(entry).cob_id() == Some(id))
    }
}

impl<D: Device, E: Extension<D>> Dictionary<D, E> {
    /// Takes all PDOs from the objects. A PDO that is impossible becomes invalid (bit 31 of its COB-ID). That is
    /// an error until a possible one is written, or the PDO is switched off.
    pub(crate) fn set_pdos(&mut self, now: Instant, wakes: &mut Wakes) {
        // First of all none is valid: an old one must not be in the way of a new one.
        self.rpdos.no_sooner().clear();
        self.tpdos.no_sooner().clear();
        self.report_rpdos(wakes);
        self.set_pdos_of(Direction::Receive, now, wakes);
        self.set_pdos_of(Direction::Transmit, now, wakes);
    }

    #[inline(never)] // once for both directions
    fn set_pdos_of(&mut self, direction: Direction, now: Instant, wakes: &mut Wakes) {
        let mut number = 0;
        while let Some((pdo, _)) = self.objects.pdos.pdo(direction, number) {
            let outcome = self.take_pdo(direction, number, &{ *pdo }, now, wakes);
            let pdo = self.objects.pdos.pdo_mut(direction, number);
            report(self.emcy.change(wakes), direction, number, outcome, pdo.map(|(pdo, _)| &mut pdo.cob_id));
            number += 1;
        }
    }

    /// A PDO has these parameters from now on; what is mapped is as the objects have it.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`
    fn take_pdo(
        &mut self,
        direction: Direction,
        number: usize,
        pdo: &PdoParameters,
        now: Instant,
        wakes: &mut Wakes,
    ) -> Result<(), AbortCode> {
        rules::check_pdo(direction, &self.objects.communication, pdo.cob_id)?;
        rules::check_pdo_of_server(&self.objects.sdo, pdo.cob_id)?;
        let (_, mapping) = self.objects.pdos.pdo(direction, number).ok_or(AbortCode::NoObject)?;
        let resolved = pdo::resolve::<NodeObjects<D, E>>(direction, pdo, mapping.objects())?;
        match direction {
            Direction::Receive => {
                let is_special = E::is_special(mapping);
                self.rpdos.change(wakes).configure(number, pdo, resolved, is_special)
            }
            Direction::Transmit => self.tpdos.change(wakes).configure(number, pdo, resolved, now),
        }
    }

    /// A write to the parameters of a PDO: the service takes them over, or refuses them.
    pub(super) fn configure_pdo(&mut self, at: Address, value: u32) -> Result<(), AbortCode> {
        let number = usize::from(at.index & 0x1FF);
        let is_received = at.index <= LAST_RPDO_MAPPING;
        let direction = if is_received { Direction::Receive } else { Direction::Transmit };
        let pdo = self.objects.pdos.pdo_mut(direction, number);
        let (present, mapping) = pdo.ok_or(AbortCode::NoObject)?;
        if at.index > if is_received { LAST_RPDO } else { LAST_TPDO } {
            return pdo::mapping::<NodeObjects<D, E>>(direction, present.cob_id, mapping, at.sub, value);
        }
        let new = pdo::parameters(direction, present, at.sub, value)?;
        if !is_received {
            rules::check_sender(self.id, &self.objects.consumers, new.cob_id)?;
        }
        let mut wakes = Wakes::at_once();
        self.take_pdo(direction, number, &new, self.now, &mut wakes)?;
        self.report_rpdos(&mut wakes);
        // What its defaults or its application had wrong is past.
        self.clear(ErrorCode::DATA_SET, source_of(direction, number), &mut wakes);
        self.wakes = wakes;
        Ok(())
    }

    /// Raises and clears the errors of receive PDOs, and shows them in the dictionary.
    #[cold]
    #[inline(never)]
    pub(super) fn report_rpdos(&mut self, wakes: &mut Wakes) {
        while let Some((number, event)) = self.rpdos.no_sooner().take_event() {
            note(self.emcy.change(wakes), number, event);
            self.show_errors();
        }
    }

    /// Receive PDOs that are overdue, and emergencies.
    pub(super) fn poll(
        &mut self,
        now: Instant,
        wakes: &mut Wakes,
        state: NmtState,
        send: &mut impl FnMut(Frame) -> bool,
    ) {
        self.rpdos.no_sooner().poll(now);
        if self.rpdos.has_events() {
            self.report_rpdos(wakes);
        }
        let emcy = self.emcy.no_sooner();
        while let Some(frame) = emcy.poll(now, state) {
            if !send(frame) {
                emcy.recall(now + emcy::Producer::RETRY);
            }
        }
    }
}

/// Source of the error that a PDO cannot be: 1 to 127 the first RPDOs, 129 to 255 the first TPDOs. Those beyond
/// share the last one; the index follows in the message.
fn source_of(direction: Direction, number: usize) -> u8 {
    let nth = number.min(126) as u8;
    if direction == Direction::Receive { nth + 1 } else { nth + 129 }
}

/// Returns whether a PDO of the objects could be: if not, its COB-ID reads "not valid", and an emergency names the
/// PDO, the index of its parameters, and the low half of the abort code that a client would get.
fn report(
    emcy: &mut emcy::Producer,
    direction: Direction,
    number: usize,
    outcome: Result<(), AbortCode>,
    cob_id: Option<&mut u32>,
) {
    let source = source_of(direction, number);
    let first = if direction == Direction::Receive { RPDO } else { TPDO };
    let [low, high] = first.wrapping_add(number as u16).to_le_bytes();
    match outcome {
        Ok(()) => _ = emcy.clear(ErrorCode::DATA_SET, source),
        Err(code) => {
            if let Some(cob_id) = cob_id {
                *cob_id |= INVALID;
            }
            let [code_low, code_high, ..] = code.code().to_le_bytes();
            emcy.raise(ErrorCode::DATA_SET, [source, low, high, code_low, code_high]);
        }
    }
}

/// Raises or clears the error of an RPDO; its source is the number of the PDO. The dictionary does not show it yet.
fn note(emcy: &mut emcy::Producer, number: usize, event: RpdoEvent) {
    // One byte; those that are too many share the last one.
    let source = number.min(usize::from(u8::MAX)) as u8;
    match event {
        RpdoEvent::Error(error) => _ = emcy.raise(error.code(), [source, 0, 0, 0, 0]),
        RpdoEvent::Resolved(error) => _ = emcy.clear(error.code(), source),
    }
}
