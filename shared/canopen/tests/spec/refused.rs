//! What a constant refuses, with the text that the compiler shows: the same functions at run time. Which programs do not compile,
//! `tests/declarations/tests/refused` holds.

use std::panic::{UnwindSafe, catch_unwind};

use async_canopen::od::{
    Access, DataType, Declared, Entry, Field, Fields, Limits, NotWritable, Object, Objects, PdoUse, Readable,
    SubIndex, TimeOfDay, U24, assert_entries, sub_indices,
};
use async_canopen::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};

use crate::pdo::device::Device;

/// The text with which this is refused.
fn refusal<T>(constant: impl FnOnce() -> T + UnwindSafe) -> String {
    let panic = catch_unwind(constant).map(drop).expect_err("it is refused");
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
}

fn object(index: u16) -> Object {
    *Device::object(index).unwrap().0
}

/// The value of an object, or of the first of several in a row.
fn field(index: u16, sub: u8) -> Field<u16> {
    Fields::<()>::of(&object(index)).nth(0).field(SubIndex::new(sub, 1))
}

const ID: CobIdOf = CobIdOf::node(0x180);

fn tpdo(number: u16) -> Tpdo {
    Pdo::<()>::new(ID).map(field(0x6020, 0)).transmit(number)
}

fn rpdo(number: u16) -> Rpdo {
    Pdo::<()>::new(CobIdOf::node(0x200)).map(field(0x6021, 0)).receive(number)
}

fn set(rpdos: Vec<Rpdo>, tpdos: Vec<Tpdo>) -> PdoSet {
    PdoSet::new(rpdos.leak(), tpdos.leak())
}

/// Verifies: ECSS 6.2a, 6.10a
#[test]
fn a_set_of_pdos_needs_values_numbers_and_cob_ids() {
    let empty = "TPDO 1 carries nothing: add `.map(..)`";
    assert_eq!(refusal(|| set(vec![], vec![Pdo::<()>::new(ID).transmit(1)])), empty);
    let empty = "RPDO 3 carries nothing: add `.map(..)`";
    assert_eq!(refusal(|| set(vec![rpdo(1), Pdo::<()>::new(ID).receive(3)], vec![])), empty);
    assert_eq!(refusal(|| set(vec![rpdo(2), rpdo(1), rpdo(2)], vec![])), "RPDO 2 is declared twice");
    assert_eq!(refusal(|| set(vec![], vec![tpdo(7), tpdo(7)])), "TPDO 7 is declared twice");
    let same = "TPDO 1 and TPDO 2 may have the same COB-ID: each needs its own";
    assert_eq!(refusal(|| set(vec![], vec![tpdo(1), tpdo(2)])), same);
    // 183h is that of node 3.
    let fixed = || Pdo::<()>::new(CobIdOf::fixed(0x183)).map(field(0x6020, 0)).transmit(2);
    assert_eq!(refusal(|| set(vec![], vec![tpdo(1), fixed()])), same);
    // No node has 200h of 200h + node.
    let of_node = || Pdo::<()>::new(CobIdOf::node(0x200)).map(field(0x6020, 0)).transmit(1);
    let fixed = || Pdo::<()>::new(CobIdOf::fixed(0x200)).map(field(0x6020, 0)).transmit(2);
    set(vec![], vec![of_node(), fixed()]);
    set(vec![], vec![fixed(), of_node()]);
}

/// Verifies: ECSS 6.2a
#[test]
fn a_pdo_is_one_of_its_device_and_carries_what_that_has() {
    type Slots = PdoObjects<2, 1>;
    let refused = |rpdos, tpdos| refusal(move || set(rpdos, tpdos).assert_within::<Slots>(Device::DECLARED));
    set(vec![rpdo(1), rpdo(2)], vec![tpdo(1)]).assert_within::<Slots>(Device::DECLARED);
    let skips = Pdo::<()>::new(ID).skip::<u16>().map(field(0x6021, 0)).receive(1);
    set(vec![skips], vec![]).assert_within::<Slots>(Device::DECLARED);
    assert_eq!(refused(vec![rpdo(3)], vec![]), "RPDO 3: `Pdos` of the device has room for 2 RPDOs");
    assert_eq!(refused(vec![], vec![tpdo(2)]), "TPDO 2: `Pdos` of the device has room for 1 TPDOs");
    let entries: &'static [Entry] = vec![Entry::of::<u16>(0, 1, Access::Ro).for_pdo(PdoUse::Required)].leak();
    let foreign = |index| {
        Pdo::<()>::new(ID)
            .map(Field::<u16, Readable, NotWritable>::of(&Object { index, count: 1, entries }))
            .transmit(1)
    };
    let none = "TPDO 1 carries object 2FFFh sub-index 0, which the device does not have: add its declaration with `#[objects]`";
    assert_eq!(refused(vec![], vec![foreign(0x2FFF)]), none);
    let another = "TPDO 1 carries object 6020h sub-index 0, which the device declares in another way";
    assert_eq!(refused(vec![], vec![foreign(0x6020)]), another);
}

/// A mapping has 9 bits for the number of an object, one of which means none, and 9 for how many come before it in its row.
#[test]
fn pdos_reach_511_objects_and_512_in_a_row() {
    let entries: &'static [Entry] = vec![Entry::of::<u16>(0, 1, Access::Ro).for_pdo(PdoUse::Optional)].leak();
    let object = |index, count| Object { index, count, entries };
    let beyond = |index: u16| {
        format!(
            "TPDO 1 carries object {index:04X}h sub-index 0: PDOs reach the first 511 objects, and 512 in a row"
        )
    };
    let carries = |objects: Vec<Object>, index| {
        let all = Declared { objects: objects.leak(), groups: &[] };
        let pdos = set(
            vec![],
            vec![
                Pdo::<()>::new(ID)
                    .map(Field::<u16, Readable, NotWritable>::of(&object(index, 1)))
                    .transmit(1),
            ],
        );
        move || pdos.assert_within::<PdoObjects<2, 1>>(&all)
    };
    let row = || vec![object(0x3000, 513)];
    carries(row(), 0x3000 + 511)();
    assert_eq!(refusal(carries(row(), 0x3000 + 512)), beyond(0x3200));
    let many = || (0..512).map(|nth| object(0x3000 + nth, 1)).collect::<Vec<_>>();
    carries(many(), 0x3000 + 510)();
    assert_eq!(refusal(carries(many(), 0x3000 + 511)), beyond(0x31FF));
}

/// Verifies: ECSS 6.8a
#[test]
fn objects_of_a_device_have_indices_of_their_own() {
    fn at(index: u16, count: u16) -> Object {
        Object { index, count, entries: &[] }
    }
    fn declared(objects: &[Object], groups: &[&'static Declared]) -> Declared {
        Declared { objects: objects.to_vec().leak(), groups: groups.to_vec().leak() }
    }
    let twice = |index: &str| format!("index {index} is declared twice: an index belongs to one field");
    declared(&[at(0x2000, 2), at(0x2002, 0), at(0x2002, 1)], &[]).assert_distinct();
    Device::DECLARED.assert_distinct();
    let refused = |all: Declared| refusal(move || all.assert_distinct());
    assert_eq!(refused(declared(&[at(0x2000, 3), at(0x2002, 1)], &[])), twice("2002h"));
    let beyond = "objects in a row from FFFEh on: the last index is FFFFh";
    assert_eq!(refused(declared(&[at(0xFFFE, 3)], &[])), beyond);
    let group: &'static Declared = Box::leak(Box::new(declared(&[at(0x3000, 4), at(0x4000, 0)], &[])));
    let outer: &'static Declared = Box::leak(Box::new(declared(&[at(0x5000, 1)], &[group])));
    declared(&[at(0x2FFF, 1), at(0x3004, 1), at(0x4000, 1)], &[outer]).assert_distinct();
    assert_eq!(refused(declared(&[at(0x3003, 1)], &[outer])), twice("3003h"));
    assert_eq!(refused(declared(&[at(0x2FFF, 2)], &[group])), twice("3000h"));
    // Two groups beside each other, one of them within another one.
    let other: &'static Declared = Box::leak(Box::new(declared(&[at(0x3002, 1)], &[])));
    assert_eq!(refused(declared(&[], &[outer, other])), twice("3002h"));
    let nested: &'static Declared = Box::leak(Box::new(declared(&[], &[other])));
    assert_eq!(refused(declared(&[], &[group, nested])), twice("3002h"));
}

/// Verifies: ECSS 6.8a
#[test]
fn entries_of_an_object_have_sub_indices_of_their_own() {
    let at = |sub, count| Entry::of::<u8>(sub, count, Access::Ro);
    assert_entries(&[at(0, 1), at(1, 4), at(5, 250)]);
    let twice = "sub-index 3 is declared twice: a sub-index belongs to one field";
    assert_eq!(refusal(|| assert_entries(&[at(0, 1), at(1, 3), at(3, 1)])), twice);
    let beyond = "values in a row from sub-index 250 on: the last sub-index is 254";
    assert_eq!(refusal(|| assert_entries(&[at(250, 6)])), beyond);
    assert_eq!(sub_indices(254), 254);
    assert_eq!(refusal(|| sub_indices(255)), "an object has at most 254 sub-indices");
}

#[test]
fn constants_of_fields_name_one_value_of_one_object() {
    let words = || Fields::<()>::of(&object(0x6000));
    let channels = || Fields::<()>::of(&object(0x6010));
    assert_eq!((words().index(), words().sub(5).index()), (0x6000, 0x6000));
    assert_eq!(refusal(|| words().sub(6)), "object 6000h has no sub-index 6: its last one is 5");
    let row = "object 6010h is the first of 3 in a row, counted from 0: there is no 3";
    assert_eq!(refusal(|| channels().nth(3)), row);
    let several = "object 6010h: there are several objects in a row, choose one with `nth`";
    assert_eq!(refusal(|| channels().sub(1)), several);
    assert_eq!(refusal(|| channels().index()), several);
    let trims = || SubIndex::<()>::new(1, 3);
    assert_eq!(trims().nth(2).get(), 3);
    let sub = "sub-index 1 is the first of 3 in a row, counted from 0: there is no 3";
    assert_eq!(refusal(|| trims().nth(3)), sub);
    let choose = "object 6028h, sub-index 1: there are several in a row, choose one with `nth`";
    assert_eq!(refusal(|| Fields::<()>::of(&object(0x6028)).field(trims())), choose);
    let one = Fields::<()>::of(&object(0x6028)).field(trims().nth(1));
    assert_eq!((one.address().sub, one.data_type()), (2, DataType::Integer8));
}

#[test]
fn marks_of_an_entry_fit_its_type_and_its_access() {
    let entry = |access| Entry::of::<u8>(0, 1, access);
    let keep = "`keep` is for a DOMAIN with `rw`: every other value with `rw` or `rwr` is kept without it";
    assert_eq!(refusal(|| entry(Access::Rw).keep()), keep);
    let volatile = "`volatile` is for `rw` and `rwr`: other values, and a DOMAIN, are not kept without it";
    assert_eq!(refusal(|| entry(Access::Rww).volatile()), volatile);
    assert!(entry(Access::Rwr).is_kept() && !entry(Access::Rwr).volatile().is_kept());
    static LIMITS: Limits = Limits::new(Some(1), None);
    let within = |entry: Entry| entry.within(Some(&LIMITS));
    assert_eq!(within(entry(Access::Rw)).limits.and_then(|limits| limits.low()), Some(1));
    assert_eq!(LIMITS.high(), None);
    assert_eq!(refusal(|| within(Entry::of::<f32>(0, 1, Access::Rw))), "only integers have limits");
}

/// Verifies: ECSS 6.2a
#[test]
fn only_types_that_stand_for_dummies_are_skipped() {
    let id = || Pdo::<()>::new(ID);
    let dummies = "only BOOLEAN and integers of 8, 16 and 32 bits can be skipped";
    assert_eq!(refusal(|| id().skip::<U24>()), dummies);
    assert_eq!(refusal(|| id().skip::<f32>()), dummies);
    assert_eq!(refusal(|| id().skip::<TimeOfDay>()), dummies);
    let skipped =
        [id().skip::<bool>().receive(1), id().skip::<i8>().receive(1), id().skip::<u16>().receive(1)];
    assert!(skipped.iter().all(|pdo| *pdo != id().receive(1)));
    let gap = "object 0005h sub-index 0 is a gap, for receive PDOs alone";
    assert_eq!(refusal(|| id().skip::<u8>().transmit(1)), gap);
}
