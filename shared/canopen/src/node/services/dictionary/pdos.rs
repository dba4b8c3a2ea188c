//! PDOs of the dictionary: their configuration from SDO, from defaults and from the application, and their values.

use super::Dictionary;
use crate::emcy;
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::device::has_states;
use crate::node::index::{LAST_RPDO, LAST_RPDO_MAPPING, LAST_TPDO, RPDO, TPDO};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::services::rules;
use crate::od::INVALID;
use crate::pdo::{Direction, Mapping, PdoParameters, PdoSlots, RpdoEvent, Rpdos, Taken, Tpdos, rules as pdo};
use crate::types::{AbortCode, Address, Frame, Instant, NmtState};

impl<D: Device, E: Extension<D>> Dictionary<D, E> {
    pub fn rpdos(&self) -> &Rpdos<D::Pdos> {
        &self.rpdos
    }

    /// Lends the receive PDOs for a change. The node runs at the end of its step.
    pub fn rpdos_mut(&mut self) -> &mut Rpdos<D::Pdos> {
        self.rpdos.change(&mut self.wakes)
    }

    pub fn tpdos(&self) -> &Tpdos<D::Pdos> {
        &self.tpdos
    }

    /// Lends the transmit PDOs for a change. The node runs at the end of its step.
    pub fn tpdos_mut(&mut self) -> &mut Tpdos<D::Pdos> {
        self.tpdos.change(&mut self.wakes)
    }

    /// Ends timers and events of the PDOs: the NMT state does not allow them.
    pub fn stop_pdos(&mut self) {
        self.tpdos.no_sooner().stop();
        self.rpdos.no_sooner().stop();
    }

    /// Sends all states of the application from `at` on.
    pub fn send_states(&mut self, at: Instant) {
        if const { has_states::<D>() } {
            self.tpdos_mut().send_states(at);
        }
    }

    /// Lets the application change objects. PDOs that are sent on events go out if their content is another one
    /// afterwards.
    pub fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut NodeObjects<D, E>) -> R) -> R {
        let Self { objects, tpdos, wakes, .. } = self;
        let has_events = tpdos.has_events();
        if has_events {
            tpdos.no_sooner().remember(objects);
        }
        let result = change(objects);
        if has_events {
            tpdos.step(wakes, |tpdos| tpdos.trigger_changed(objects, now));
        }
        result
    }

    /// Notes that a client changed a value: an event for all TPDOs that carry it.
    pub fn on_changed(&mut self, at: Address, now: Instant) {
        if self.tpdos.has_events()
            && let Ok((place, _)) = self.place(at)
        {
            self.tpdos.step(&mut self.wakes, |tpdos| tpdos.on_changed(place, now));
        }
    }

    /// Takes a SYNC: samples the synchronous TPDOs. `send` gets a frame, and whether an event made it due.
    pub fn sample(&mut self, counter: u8, send: &mut impl FnMut(Frame, bool) -> bool) {
        let send = &mut |_, frame, may_wait| send(frame, may_wait);
        self.tpdos.no_sooner().on_sync(counter, &self.objects, send);
    }

    /// Takes a SYNC: the RPDOs that waited for it take effect. `ended` gets the number of each, and whether it has all its
    /// values.
    pub fn apply_waiting(&mut self, ended: &mut impl FnMut(usize, bool)) {
        self.rpdos.no_sooner().on_sync(&mut self.objects, ended);
        self.report_rpdo_events();
    }

    /// Takes a frame of an RPDO as nearly all are, in Operational: it takes effect at once and has the right length.
    /// Returns `false` for another one, which [`Dictionary::on_rpdo`] takes.
    #[inline(always)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    pub fn on_plain_rpdo(&mut self, number: usize, frame: &Frame) -> bool {
        self.rpdos.no_sooner().on_plain_frame(number, frame, &mut self.objects)
    }

    /// Takes a frame of an RPDO, in Operational. `end`: end of the synchronous window.
    #[inline(always)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    pub fn on_rpdo(&mut self, number: usize, frame: &Frame, at: Instant, end: Instant) -> Taken {
        let Self { objects, rpdos, wakes, .. } = self;
        let taken = rpdos.step(wakes, |rpdos| rpdos.on_frame(number, frame, at, end, objects));
        self.report_rpdo_events();
        taken
    }

    /// Takes all PDOs from the objects. A PDO that is impossible becomes invalid (bit 31 of its COB-ID). That is
    /// an error until a possible one is written, or the PDO is switched off.
    pub fn set_pdos(&mut self, now: Instant) {
        // First of all none is valid: an old one must not be in the way of a new one.
        self.rpdos.no_sooner().clear();
        self.tpdos.no_sooner().clear();
        self.report_rpdos();
        self.set_pdos_of(Direction::Receive, now);
        self.set_pdos_of(Direction::Transmit, now);
    }

    fn set_pdos_of(&mut self, direction: Direction, now: Instant) {
        let mut number = 0;
        while let Some((pdo, _)) = self.objects.pdos.pdo(direction, number) {
            let outcome = self.take_pdo(direction, number, &{ *pdo }, now);
            let pdo = self.objects.pdos.pdo_mut(direction, number);
            report(
                self.emcy.change(&mut self.wakes),
                direction,
                number,
                outcome,
                pdo.map(|(pdo, _)| &mut pdo.cob_id),
            );
            number += 1;
        }
    }

    /// Gives a PDO new parameters, with the mapping that the objects have.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`
    fn take_pdo(
        &mut self,
        direction: Direction,
        number: usize,
        pdo: &PdoParameters,
        now: Instant,
    ) -> Result<(), AbortCode> {
        rules::check_pdo(direction, &self.objects.communication, pdo.cob_id)?;
        rules::check_pdo_of_server(&self.objects.sdo, pdo.cob_id)?;
        let (_, mapping) = self.objects.pdos.pdo(direction, number).ok_or(AbortCode::NoObject)?;
        let resolved = pdo::resolve::<NodeObjects<D, E>>(direction, pdo, mapping.objects())?;
        match direction {
            Direction::Receive => {
                let is_special = E::is_special(mapping);
                self.rpdos_mut().configure(number, pdo, resolved, is_special)
            }
            Direction::Transmit => self.tpdos_mut().configure(number, pdo, resolved, now),
        }
    }

    /// Gives a valid PDO the parameters of the objects again. One that cannot be was reported when it was written.
    pub fn refresh_pdo(&mut self, direction: Direction, number: usize) {
        let Some((pdo, mapping)) = self.objects.pdos.pdo(direction, number) else { return };
        let resolved = pdo::resolve::<NodeObjects<D, E>>(direction, pdo, mapping.objects());
        let Ok(Some((_, layout))) = resolved else { return };
        match direction {
            Direction::Receive => {
                self.rpdos.no_sooner().renew(number, pdo, layout, E::is_special(mapping));
            }
            Direction::Transmit => self.tpdos.no_sooner().renew(number, pdo, layout),
        }
    }

    /// Computes again what the PDOs derive from their parameters and from the NMT state.
    pub fn refresh_derived(&mut self, state: NmtState, now: Instant) {
        self.rpdos.no_sooner().refresh();
        self.tpdos.no_sooner().refresh(state.allows_pdo(), now);
    }

    /// Follows a write to the parameters of a PDO: the service takes them, or refuses them.
    pub fn configure_pdo(&mut self, at: Address, value: u32) -> Result<(), AbortCode> {
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
        self.take_pdo(direction, number, &new, self.now)?;
        self.report_rpdos();
        // What its defaults or its application had wrong is past.
        self.clear(ErrorCode::DATA_SET, source_of(direction, number));
        Ok(())
    }

    /// Raises and clears the errors of receive PDOs, if there are new ones.
    fn report_rpdo_events(&mut self) {
        if self.rpdos.has_events() {
            self.report_rpdos();
        }
    }

    /// Raises and clears the errors of receive PDOs, and shows them in the dictionary.
    #[cold]
    fn report_rpdos(&mut self) {
        while let Some((number, event)) = self.rpdos.no_sooner().take_event() {
            note(self.emcy.change(&mut self.wakes), number, event);
            self.show_errors();
        }
    }

    /// Looks for receive PDOs that are overdue, and sends emergencies. `send` returns `false` if there is no room.
    pub fn poll(&mut self, until: Instant, state: NmtState, send: &mut impl FnMut(Frame) -> bool) {
        self.rpdos.no_sooner().poll(until);
        self.report_rpdo_events();
        let emcy = self.emcy.no_sooner();
        while let Some(frame) = emcy.poll(until, state) {
            if !send(frame) {
                emcy.recall(until + emcy::Producer::RETRY);
            }
        }
    }

    /// Sends the transmit PDOs that are due by an event or a timer. `send` gets the number of a PDO and its frame, and returns
    /// `false` if there is no room.
    pub fn poll_tpdos(&mut self, until: Instant, send: &mut impl FnMut(usize, Frame) -> bool) {
        self.tpdos.no_sooner().poll(until, &self.objects, send);
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
