//! Guards the parameters of the services, apart from their COB-IDs, against a flipped bit in memory.
//!
//! | copy of a parameter | corrected by |
//! | --- | --- |
//! | the object | a code of its words ([`Ecc`]), which is computed when the object is written |
//! | that of the service | the object |
//!
//! Both are compared together with the COB-ID of the PDO, those of 1016h with that of emergencies, and all others with that of
//! SYNC.

#[cfg(test)]
mod tests;

use super::{EMCY, FIRST_RPDO, SYNC};
use crate::heartbeat::ConsumerSlots;
use crate::node::Device;
use crate::node::index::{
    CONSUMER_HEARTBEAT, CYCLE_PERIOD, EMCY_INHIBIT, ERROR_BEHAVIOUR, LAST_RPDO_MAPPING, LAST_TPDO_MAPPING,
    PRODUCER_HEARTBEAT, RPDO, STARTUP, SYNC_OVERFLOW, SYNC_WINDOW, TPDO,
};
use crate::node::services::Services;
use crate::node::services::extension::Extension;
use crate::pdo::{Direction, MAPPED, Mapping, PdoParameters, PdoSlots};
use crate::types::{Address, Ecc, Instant, NmtState};

/// Words of the parameters of a PDO.
const PDO_WORDS: usize = 2 + MAPPED;

/// Codes of the parameters of a node.
#[derive(Debug)]
pub(super) struct Codes<S: PdoSlots> {
    common: Ecc,
    consumers: Ecc,
    rpdos: S::Receive<Ecc>,
    tpdos: S::Transmit<Ecc>,
}

impl<S: PdoSlots> Codes<S> {
    pub fn new() -> Self {
        let code = Ecc::default();
        Codes { common: code, consumers: code, rpdos: S::receive(code), tpdos: S::transmit(code) }
    }
}

/// Work on words and their code. Returns whether it changed a word.
type Work<'a> = &'a mut dyn FnMut(&mut Ecc, &mut [u32]) -> bool;

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Computes the code of parameters that were written.
    pub(super) fn copy_parameters(&mut self, number: usize) {
        self.with_words(number, &mut |code, words| {
            *code = Ecc::of(words);
            false
        });
    }

    /// Computes the code of the parameters of an object that was written.
    pub(super) fn copy_written_parameters(&mut self, at: Address) {
        let nth = usize::from(at.index & 0x1FF);
        match at.index {
            CYCLE_PERIOD | SYNC_WINDOW | SYNC_OVERFLOW | EMCY_INHIBIT | PRODUCER_HEARTBEAT
            | ERROR_BEHAVIOUR | STARTUP => self.copy_parameters(SYNC),
            index if index == E::PARAMETERS => self.copy_parameters(SYNC),
            CONSUMER_HEARTBEAT => self.copy_parameters(EMCY),
            RPDO..=LAST_RPDO_MAPPING => self.copy_parameters(FIRST_RPDO + nth),
            TPDO..=LAST_TPDO_MAPPING => self.copy_parameters(FIRST_RPDO + D::Pdos::RECEIVE + nth),
            _ => {}
        }
    }

    /// Corrects the parameters with this number, in the objects and in their service. Returns whether a bit of the objects was
    /// wrong.
    pub(super) fn compare_parameters(&mut self, number: usize, now: Instant) -> bool {
        let is_wrong = self.with_words(number, &mut |code, words| {
            code.correct(words).unwrap_or_else(|_| {
                *code = Ecc::of(words);
                true
            })
        });
        self.refresh(number, now);
        is_wrong
    }

    /// Lets the work see the parameters with this number as words.
    fn with_words(&mut self, number: usize, work: Work<'_>) -> bool {
        let (objects, codes) = (self.dictionary.objects_mut(), &mut self.guarded.codes);
        match number {
            SYNC => {
                let all = &mut objects.communication;
                let [behaviour] = all.nmt.error_behaviour;
                let mut words = [
                    all.sync.cycle_period,
                    all.sync.window,
                    all.nmt.startup,
                    pair(all.emcy.inhibit, all.heartbeat.time),
                    pair(all.sync.overflow.into(), behaviour.into()),
                    objects.extension.parameters(),
                ];
                let is_changed = work(&mut codes.common, &mut words);
                if is_changed {
                    let [period, window, startup, times, bytes, extension] = words;
                    (all.sync.cycle_period, all.sync.window, all.nmt.startup) = (period, window, startup);
                    (all.emcy.inhibit, all.heartbeat.time) = halves(times);
                    let (overflow, behaviour) = halves(bytes);
                    (all.sync.overflow, all.nmt.error_behaviour) = (overflow as u8, [behaviour as u8]);
                    objects.extension.restore_parameters(extension);
                }
                is_changed
            }
            EMCY => work(&mut codes.consumers, objects.consumers.entries_mut()),
            _ => {
                let Some((direction, nth)) = pdo::<D>(number) else { return false };
                let code = match direction {
                    Direction::Receive => codes.rpdos.as_mut().get_mut(nth),
                    Direction::Transmit => codes.tpdos.as_mut().get_mut(nth),
                };
                let Some((code, (pdo, mapping))) = code.zip(objects.pdos.pdo_mut(direction, nth)) else {
                    return false;
                };
                with_pdo(pdo, mapping, &mut |words| work(code, words))
            }
        }
    }

    /// Gives a service the parameters of the objects again.
    fn refresh(&mut self, number: usize, now: Instant) {
        match number {
            SYNC => {
                let sync = &self.dictionary.objects().communication.sync;
                self.sync.configure(sync.overflow, sync.window);
                self.note_mappings();
            }
            EMCY => {
                self.dictionary.configure_emcy();
                self.dictionary.emcy_mut().confine(now);
                self.monitor.no_sooner().refresh(&self.dictionary.objects().consumers);
            }
            _ => {
                if let Some((direction, nth)) = pdo::<D>(number) {
                    self.dictionary.refresh_pdo(direction, nth);
                }
            }
        }
    }

    /// Computes again what the services derive from their parameters and from the NMT state: earliest deadlines and indices.
    pub fn refresh_derived(&mut self, state: NmtState, now: Instant) {
        self.monitor.no_sooner().recheck();
        self.dictionary.refresh_derived(state, now);
    }
}

/// Returns the PDO with this number among the COB-IDs.
fn pdo<D: Device>(number: usize) -> Option<(Direction, usize)> {
    let nth = number.checked_sub(FIRST_RPDO)?;
    match nth.checked_sub(D::Pdos::RECEIVE) {
        None => Some((Direction::Receive, nth)),
        Some(nth) => (nth < D::Pdos::TRANSMIT).then_some((Direction::Transmit, nth)),
    }
}

fn with_pdo<M: Mapping>(
    pdo: &mut PdoParameters,
    mapping: &mut M,
    work: &mut dyn FnMut(&mut [u32]) -> bool,
) -> bool {
    let (count, objects) = mapping.parts_mut();
    let mut words = [0; PDO_WORDS];
    let [bytes, times, rest @ ..] = &mut words;
    *bytes = u32::from_le_bytes([pdo.transmission, pdo.sync_start, *count, 0]);
    *times = pair(pdo.inhibit, pdo.event_timer);
    *rest = *objects;
    let is_changed = work(&mut words);
    if is_changed {
        let [bytes, times, rest @ ..] = words;
        [pdo.transmission, pdo.sync_start, *count, _] = bytes.to_le_bytes();
        (pdo.inhibit, pdo.event_timer) = halves(times);
        *objects = rest;
    }
    is_changed
}

fn pair(low: u16, high: u16) -> u32 {
    u32::from(low) | u32::from(high) << 16
}

fn halves(word: u32) -> (u16, u16) {
    (word as u16, (word >> 16) as u16)
}
