//! PDOs of a device at power-on, as constants: an impossible set does not compile.

use super::carried::tell_object;
use super::mapping::{MOST_IN_A_ROW, MOST_OBJECTS};
use super::planned::Planned;
use super::{Direction, Mapping, Pdo, PdoParameters, PdoSlots, Rpdo, Tpdo};
use crate::od::{DataType, Declared, INVALID, NO_REMOTE};
use crate::types::NodeId;

/// PDOs of a device at power-on. PDOs that are not in the set are invalid until a client configures them.
///
/// [`PdoSet::assert_within`] in a constant checks it against all objects of the node, so that `cargo check` shows the
/// error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PdoSet {
    rpdos: &'static [Rpdo],
    tpdos: &'static [Tpdo],
}

impl PdoSet {
    /// Set without PDOs.
    pub const NONE: Self = PdoSet { rpdos: &[], tpdos: &[] };

    /// Makes the set of the PDOs of a device, in any order.
    ///
    /// # Panics
    /// If a PDO carries nothing, if two have one number, or if two transmit PDOs may have one COB-ID. In a
    /// constant all panics of a set are compile errors.
    #[track_caller]
    pub const fn new(rpdos: &'static [Rpdo], tpdos: &'static [Tpdo]) -> Self {
        let mut nth = 0;
        while nth < rpdos.len() {
            assert_carries(rpdos[nth].pdo(), "R");
            let mut other = 0;
            while other < nth {
                assert_numbers_differ(rpdos[nth].pdo(), rpdos[other].pdo(), "R");
                other += 1;
            }
            nth += 1;
        }
        let mut nth = 0;
        while nth < tpdos.len() {
            let pdo = tpdos[nth].pdo();
            assert_carries(pdo, "T");
            let mut other = 0;
            while other < nth {
                let against = tpdos[other].pdo();
                assert_numbers_differ(pdo, against, "T");
                if pdo.cob_id.may_equal(against.cob_id) {
                    let both = against.tell("T").text(" and ").with(pdo.tell("T"));
                    both.text(" may have the same COB-ID: each needs its own").refuse();
                }
                other += 1;
            }
            nth += 1;
        }
        PdoSet { rpdos, tpdos }
    }

    /// Stops the build if a PDO is beyond the slots `S` of the device, or if the dictionary has another declaration
    /// of a mapped value, or none.
    ///
    /// # Panics
    /// When called at run time, for the same reasons.
    #[track_caller]
    pub const fn assert_within<S: PdoSlots>(&self, declared: &Declared) {
        let mut nth = 0;
        while nth < self.rpdos.len() {
            assert_one_of(S::RECEIVE, self.rpdos[nth].pdo(), "R");
            assert_declared(self.rpdos[nth].pdo(), Direction::Receive, declared);
            nth += 1;
        }
        let mut nth = 0;
        while nth < self.tpdos.len() {
            assert_one_of(S::TRANSMIT, self.tpdos[nth].pdo(), "T");
            assert_declared(self.tpdos[nth].pdo(), Direction::Transmit, declared);
            nth += 1;
        }
    }

    /// Returns the PDOs of `node` at power-on. PDOs that are not in the set are invalid and empty. The first four
    /// of each kind then have the COB-IDs of the generic pre-defined connection set (CiA 301 7.3.3).
    pub fn at_power_on<S: PdoSlots>(&self, node: NodeId) -> S {
        let mut all = S::default();
        for direction in [Direction::Receive, Direction::Transmit] {
            let first = if direction == Direction::Receive { 0x200 } else { 0x180 };
            let mut cob_id = INVALID | NO_REMOTE | (first + u32::from(node.get()));
            for number in 0..4 {
                if let Some((to, _)) = all.pdo_mut(direction, number) {
                    to.cob_id = cob_id;
                }
                cob_id = cob_id.wrapping_add(0x100);
            }
            let mut nth = 0;
            while let Some(pdo) = self.nth(direction, nth) {
                nth = nth.wrapping_add(1);
                if let Some((to, mapping)) = all.pdo_mut(direction, pdo.slot()) {
                    *to = PdoParameters {
                        cob_id: NO_REMOTE | u32::from(pdo.cob_id.of(node).raw()),
                        transmission: pdo.transmission,
                        inhibit: pdo.inhibit,
                        event_timer: pdo.event_timer,
                        sync_start: pdo.sync_start,
                    };
                    mapping.map(pdo.mapping());
                }
            }
        }
        all
    }

    fn nth(&self, direction: Direction, nth: usize) -> Option<&'static Planned> {
        match direction {
            Direction::Receive => self.rpdos.get(nth).map(Rpdo::pdo),
            Direction::Transmit => self.tpdos.get(nth).map(Tpdo::pdo),
        }
    }

    /// Returns whether the values of a transmit PDO (0 is the first) are declared as a [state](Tpdo::state).
    pub(crate) fn is_state(&self, number: usize) -> bool {
        self.tpdos.iter().any(|tpdo| tpdo.pdo().slot() == number && tpdo.pdo().is_state())
    }

    /// Returns the declaration of a receive PDO (0 is the first).
    pub(super) fn rpdo(&self, number: usize) -> Option<&'static Rpdo> {
        self.rpdos.iter().find(|rpdo| rpdo.pdo().slot() == number)
    }

    /// Returns the number of a transmit PDO of the set, 0 is the first. That of a PDO that is not in the set is one that no
    /// device has.
    pub fn number_of<D, T>(&self, pdo: Pdo<D, T>) -> usize {
        let found = self.tpdos.iter().find(|tpdo| tpdo.pdo().cob_id == pdo.cob_id());
        found.map_or(usize::MAX, |tpdo| tpdo.pdo().slot())
    }

    /// Returns the receive PDOs.
    pub const fn rpdos(&self) -> &'static [Rpdo] {
        self.rpdos
    }

    /// Returns the transmit PDOs.
    pub const fn tpdos(&self) -> &'static [Tpdo] {
        self.tpdos
    }
}

#[track_caller]
const fn assert_one_of(most: usize, pdo: &Planned, kind: &str) {
    if pdo.slot() >= most {
        let number = pdo.tell(kind).text(": `Pdos` of the device has room for ").number(most as u32);
        number.text(" ").text(kind).text("PDOs").refuse();
    }
}

#[track_caller]
const fn assert_carries(pdo: &Planned, kind: &str) {
    if pdo.carried().is_empty() {
        pdo.tell(kind).text(" carries nothing: add `.map(..)`").refuse();
    }
}

#[track_caller]
const fn assert_numbers_differ(one: &Planned, other: &Planned, kind: &str) {
    if one.slot() == other.slot() {
        one.tell(kind).text(" is declared twice").refuse();
    }
}

#[track_caller]
const fn assert_declared(pdo: &Planned, direction: Direction, declared: &Declared) {
    let mut nth = 0;
    while let Some((at, bits)) = pdo.carried().nth(nth) {
        nth += 1;
        if DataType::of_dummy(at.index).is_some() {
            continue;
        }
        let object = tell_object(pdo.tell(direction.letter()).text(" carries "), at);
        match declared.find(at) {
            None => object
                .text(", which the device does not have: add its declaration with `#[objects]`")
                .refuse(),
            Some((number, instance, _)) if number >= MOST_OBJECTS || instance >= MOST_IN_A_ROW => {
                object.text(": PDOs reach the first 511 objects, and 512 in a row").refuse()
            }
            Some((_, _, entry)) => {
                let is_same = matches!(entry.data_type.bits(), Some(own) if own == bits);
                if !is_same || !direction.carries(entry) {
                    object.text(", which the device declares in another way").refuse();
                }
            }
        }
    }
}
