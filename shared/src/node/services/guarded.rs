//! COB-IDs that a flipped bit in memory does not change for long (ECSS 6.10d).
//!
//! | copy of a COB-ID | where | used for |
//! | --- | --- | --- |
//! | first | the object | what clients read and write |
//! | second, with its complement | [`Guarded`] | nothing else |
//! | third | the service | the frames |
//!
//! They are compared with each heartbeat, so that this costs no wake-up of its own. The second copy is right while it fits its
//! complement, else the object is.

#[cfg(test)]
mod tests;

use super::Services;
use crate::emcy::ErrorCode;
use crate::node::services::rules::SYNC_IS_USED;
use crate::node::{Communication, Device, Extension, NodeObjects};
use crate::od::CobIdEntry;
use crate::pdo::PdoSlots;
use crate::types::{CobId, Instant, NodeId};

/// Source of the emergency that reports a flipped bit; the number of those that were mended follows.
const FLIPPED: u8 = 1;

/// A COB-ID and its complement.
#[derive(Clone, Copy, Debug)]
struct Copied([u32; 2]);

impl Copied {
    const fn of(cob_id: u32) -> Copied {
        Copied([cob_id, !cob_id])
    }

    /// What was copied, unless a bit has flipped.
    fn whole(self) -> Option<u32> {
        let Copied([cob_id, complement]) = self;
        (cob_id == !complement).then_some(cob_id)
    }

    /// Corrects the copy and the object. Returns whether one of them was wrong, or the COB-ID that the service has `in_use`.
    /// `flags` are the bits of which the service takes notice. What was just written `is_new`: then the object is right.
    #[inline(never)] // of several callers, with heartbeats
    fn correct(&mut self, object: &mut u32, is_new: bool, flags: u32, in_use: Option<CobId>) -> bool {
        let whole = if is_new { Some(*object) } else { self.whole() };
        let right = whole.unwrap_or(*object);
        let is_right = whole == Some(*object) && CobIdEntry::from_raw(right & flags).cob_id() == in_use;
        (*object, *self) = (right, Copied::of(right));
        !is_right
    }
}

/// Corrects the one of three copies of a Node-ID that differs from the others (ECSS 6.10k). Returns whether there was one.
pub fn correct(copies: [&mut NodeId; 3]) -> bool {
    let [first, second, third] = copies;
    let wrong = match (first == second, second == third) {
        (true, true) => return false,
        (true, false) => (third, *first),
        (false, true) => (first, *second),
        (false, false) => (second, *first),
    };
    *wrong.0 = wrong.1;
    true
}

/// Second copies of the COB-IDs of a node.
#[derive(Debug)]
pub struct Guarded<S: PdoSlots> {
    sync: Copied,
    emcy: Copied,
    rpdos: S::Receive<Copied>,
    tpdos: S::Transmit<Copied>,
}

impl<S: PdoSlots> Guarded<S> {
    pub fn new() -> Self {
        // They are copied before they are compared.
        let none = Copied([0; 2]);
        Guarded { sync: none, emcy: none, rpdos: S::receive(none), tpdos: S::transmit(none) }
    }
}

impl<D: Device, E: Extension> Services<D, E> {
    /// Compares the Node-ID of the node with those of its services, which follow it (ECSS 6.10k). Where one of three is wrong, all
    /// are right again, and an emergency reports it.
    #[inline(never)] // with heartbeats
    pub fn compare_node_ids(&mut self, own: &mut NodeId) {
        if correct([own, &mut self.id, &mut self.dictionary.id]) {
            self.sdo_id = CobId::sdo_request(*own);
            self.report_flipped();
        }
    }

    /// Compares the copies of each COB-ID. Where one is wrong, all are right again, the services included, and an emergency
    /// reports it. Where they `are_new`, taken over or written by a client, they are copied first. Returns whether one was
    /// wrong.
    #[inline(never)] // of several callers, neither in a hurry
    pub fn compare_cob_ids(&mut self, are_new: bool, now: Instant) -> bool {
        let Self { dictionary, guarded, .. } = self;
        let NodeObjects { communication, pdos, .. } = &mut dictionary.objects;
        let Communication { sync, emcy, .. } = communication;
        let mut are_wrong = guarded.sync.correct(&mut sync.cob_id, are_new, SYNC_IS_USED, Some(self.sync_id));
        are_wrong |= guarded.emcy.correct(&mut emcy.cob_id, are_new, u32::MAX, dictionary.emcy.id());
        let copies = guarded.rpdos.as_mut().iter_mut().enumerate();
        for ((number, copied), pdo) in copies.zip(pdos.rpdos_mut().0) {
            are_wrong |= copied.correct(&mut pdo.cob_id, are_new, u32::MAX, dictionary.rpdos.id(number));
        }
        let copies = guarded.tpdos.as_mut().iter_mut().enumerate();
        for ((number, copied), pdo) in copies.zip(pdos.tpdos_mut().0) {
            are_wrong |= copied.correct(&mut pdo.cob_id, are_new, u32::MAX, dictionary.tpdos.id(number));
        }
        if are_wrong && !are_new {
            self.sync_id = sync.id();
            dictionary.emcy.configure(emcy.config());
            dictionary.set_pdos(now);
            self.report_flipped();
        }
        are_wrong
    }

    /// A flipped bit was mended.
    #[inline(never)] // of two callers, neither in a hurry
    fn report_flipped(&mut self) {
        let Some(objects) = self.dictionary.objects.spacecraft.spacecraft() else { return };
        objects.identity.mended = objects.identity.mended.saturating_add(1);
        let [low, high] = objects.identity.mended.to_le_bytes();
        self.report_past(ErrorCode::HARDWARE, [FLIPPED, low, high, 0, 0]);
    }
}
