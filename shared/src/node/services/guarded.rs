//! COB-IDs that a flipped bit in memory does not change for long (ECSS 6.10d).
//!
//! | copy of a COB-ID | where | used for |
//! | --- | --- | --- |
//! | first | the object | what clients read and write |
//! | second, with its complement | [`Guarded`] | nothing else |
//! | third | the service | the frames |
//!
//! The node compares [`EACH_HEARTBEAT`] of them with each heartbeat, in turn, so that this costs no wake-up of its own and no long
//! step (row `rx.inside_look`). The second copy is right while it fits its complement, else the object is.

#[cfg(test)]
mod tests;

use super::{Dictionary, Services};
use crate::emcy::ErrorCode;
use crate::node::index::{EMCY_COB_ID, LAST_RPDO, LAST_TPDO, RPDO, SYNC_COB_ID, TPDO};
use crate::node::services::rules::SYNC_IS_USED;
use crate::node::{Communication, Device, Extension, NodeObjects};
use crate::od::CobIdEntry;
use crate::pdo::{Direction, PdoSlots};
use crate::types::{Address, CobId, Instant, NodeId};

/// Source of the emergency that reports a flipped bit; the number of those that were mended follows.
const FLIPPED: u8 = 1;

/// COB-IDs that are compared with each heartbeat: the 59 of the mission's master in 7.5 s, at a heartbeat every 250 ms.
const EACH_HEARTBEAT: usize = 2;

/// Numbers of SYNC and emergencies among the COB-IDs. Receive PDOs follow, then transmit PDOs.
const SYNC: usize = 0;
const EMCY: usize = 1;
const FIRST_RPDO: usize = 2;

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
    /// `flags` are the bits of which the service takes notice.
    fn correct(&mut self, object: &mut u32, flags: u32, in_use: Option<CobId>) -> bool {
        let whole = self.whole();
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
    /// Number of the COB-ID that is compared next.
    next: usize,
}

impl<S: PdoSlots> Guarded<S> {
    /// COB-IDs of a node.
    const COB_IDS: usize = FIRST_RPDO + S::RECEIVE + S::TRANSMIT;

    pub fn new() -> Self {
        // They are copied before they are compared.
        let none = Copied([0; 2]);
        Guarded { sync: none, emcy: none, rpdos: S::receive(none), tpdos: S::transmit(none), next: 0 }
    }

    /// The second copy of a COB-ID.
    fn copy(&mut self, number: usize) -> Option<&mut Copied> {
        match number {
            SYNC => Some(&mut self.sync),
            EMCY => Some(&mut self.emcy),
            _ => {
                let pdos = self.rpdos.as_mut().iter_mut().chain(self.tpdos.as_mut());
                pdos.skip(number.saturating_sub(FIRST_RPDO)).next()
            }
        }
    }
}

/// Number of the COB-ID that an object has.
fn number_of<S: PdoSlots>(index: u16) -> Option<usize> {
    match index {
        SYNC_COB_ID => Some(SYNC),
        EMCY_COB_ID => Some(EMCY),
        RPDO..=LAST_RPDO => Some(FIRST_RPDO + usize::from(index - RPDO)),
        TPDO..=LAST_TPDO => Some(FIRST_RPDO + S::RECEIVE + usize::from(index - TPDO)),
        _ => None,
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

    /// Copies all COB-IDs: the services have taken them over.
    pub fn copy_cob_ids(&mut self) {
        (0..Guarded::<D::Pdos>::COB_IDS).for_each(|number| self.copy_cob_id(number));
    }

    /// Copies the COB-ID of an object that was written, if it has one. The others stay as they are: a bit that has flipped in one of
    /// them is still found.
    pub fn copy_written_cob_id(&mut self, at: Address) {
        if let Some(number) = number_of::<D::Pdos>(at.index) {
            self.copy_cob_id(number);
        }
    }

    #[inline(never)] // once for both callers
    fn copy_cob_id(&mut self, number: usize) {
        let Self { dictionary, guarded, .. } = self;
        if let Some((object, copy)) = object(&mut dictionary.objects, number).zip(guarded.copy(number)) {
            *copy = Copied::of(*object);
        }
    }

    /// Compares the copies of the next COB-IDs in turn. Where one is wrong, all three are right again, the services included, and
    /// an emergency reports it. Returns whether one was wrong.
    pub fn compare_cob_ids(&mut self, now: Instant) -> bool {
        let mut is_wrong = false;
        for _ in 0..EACH_HEARTBEAT {
            let number = self.guarded.next;
            self.guarded.next = (number + 1) % Guarded::<D::Pdos>::COB_IDS;
            is_wrong |= self.correct_cob_id(number);
        }
        if is_wrong {
            let Dictionary {
                objects: NodeObjects { communication: Communication { sync, emcy, .. }, .. },
                ..
            } = &mut self.dictionary;
            self.sync_id = sync.id();
            let emcy = emcy.config();
            self.dictionary.emcy.configure(emcy);
            self.dictionary.set_pdos(now);
            self.report_flipped();
        }
        is_wrong
    }

    /// Corrects object and second copy of a COB-ID. Returns whether one of the three was wrong.
    fn correct_cob_id(&mut self, number: usize) -> bool {
        let Self { dictionary, guarded, .. } = self;
        let (flags, in_use) = match number {
            SYNC => (SYNC_IS_USED, Some(self.sync_id)),
            EMCY => (u32::MAX, dictionary.emcy.id()),
            _ => {
                let pdo = number.saturating_sub(FIRST_RPDO);
                let sent = pdo.checked_sub(D::Pdos::RECEIVE);
                (u32::MAX, sent.map_or_else(|| dictionary.rpdos.id(pdo), |sent| dictionary.tpdos.id(sent)))
            }
        };
        let copies = object(&mut dictionary.objects, number).zip(guarded.copy(number));
        copies.is_some_and(|(object, copy)| copy.correct(object, flags, in_use))
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

/// The COB-ID that clients read and write.
fn object<D: Device, E: Extension>(objects: &mut NodeObjects<D, E>, number: usize) -> Option<&mut u32> {
    match number {
        SYNC => Some(&mut objects.communication.sync.cob_id),
        EMCY => Some(&mut objects.communication.emcy.cob_id),
        _ => {
            let pdo = number.saturating_sub(FIRST_RPDO);
            let (direction, nth) = match pdo.checked_sub(D::Pdos::RECEIVE) {
                None => (Direction::Receive, pdo),
                Some(nth) => (Direction::Transmit, nth),
            };
            objects.pdos.pdo_mut(direction, nth).map(|(pdo, _)| &mut pdo.cob_id)
        }
    }
}
