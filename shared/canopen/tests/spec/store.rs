//! Store and restore of parameters (CiA 301 7.5.2.13, 7.5.2.14), over a store in memory.
//!
//! Verifies: ECSS 6.8a

use std::collections::BTreeMap;

use async_canopen::store::machine::{MAX_VALUE, NoNotes, Save, load};
use async_canopen::store::{
    Content, Group, LOAD, Loaded, ParameterStore, Parameters, Row, SAVE, StoreError, StoreRequest,
};
use async_canopen::types::{AbortCode, Address, NodeId};

const NODE: NodeId = NodeId::of::<5>();

/// A set in RAM; it refuses what a test asks it to.
#[derive(Clone, Debug, Default, PartialEq)]
struct Memory {
    stored: Vec<u8>,
    begun: Option<(usize, Vec<u8>)>,
    fails_after: Option<usize>,
}

impl ParameterStore for Memory {
    fn stored_len(&self) -> usize {
        self.stored.len()
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        let bytes = self.stored.get(offset..offset + into.len()).ok_or(StoreError::Size)?;
        into.copy_from_slice(bytes);
        Ok(())
    }

    fn begin(&mut self, len: usize) -> Result<(), StoreError> {
        self.begun = Some((len, Vec::new()));
        if self.fails_after == Some(0) { Err(StoreError::Full) } else { Ok(()) }
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        let (len, written) = self.begun.as_mut().expect("begun");
        written.extend(bytes);
        assert!(written.len() <= *len, "as long as announced");
        if self.fails_after.is_some_and(|n| written.len() >= n) { Err(StoreError::Hardware) } else { Ok(()) }
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        let (len, written) = self.begun.take().expect("begun");
        if written.len() != len {
            return Err(StoreError::Size);
        }
        self.stored = written;
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        None
    }

    fn write_note(&mut self, _: u16) -> Result<(), StoreError> {
        Err(StoreError::Full)
    }
}

type Dictionary = BTreeMap<(u16, u8), Vec<u8>>;

/// Heartbeat time, a PDO's COB-ID, a redundancy parameter, a name, an output of the device profile.
fn dictionary() -> Dictionary {
    BTreeMap::from([
        ((0x1017, 0), vec![0xE8, 0x03]),
        ((0x1800, 1), vec![0x85, 0x01, 0, 0]),
        ((0x2000, 2), vec![7]),
        ((0x5FFF, 0), b"a name".to_vec()),
        ((0x6000, 1), vec![1, 2, 3, 4, 5, 6, 7]),
    ])
}

/// The values of a dictionary, for a save.
struct Values<'a>(&'a Dictionary);

impl Parameters for Values<'_> {
    fn find(&mut self, from: Address) -> Option<Row> {
        let mut values = self.0.range((from.index, from.sub)..);
        let (&(index, sub), value) = values.next()?;
        let is_next = |(nth, (at, next)): &(u8, (&(u16, u8), &Vec<u8>))| {
            **at == (index, sub + nth) && next.len() == value.len()
        };
        let more = (1..).zip(values).take_while(is_next).count();
        Some(Row { at: Address::new(index, sub), count: 1 + more as u8, len: value.len() })
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize {
        let Some(value) = self.0.get(&(at.index, at.sub)) else { return 0 };
        into.iter_mut().zip(&value[offset..]).map(|(to, from)| *to = *from).count()
    }
}

fn run(
    store: &mut Memory,
    node: NodeId,
    group: Group,
    request: StoreRequest,
    values: &Dictionary,
) -> Result<(), StoreError> {
    let mut save = Save::<NoNotes>::begin(store, node, group, request)?;
    while !save.advance(store, &mut Values(values))? {}
    Ok(())
}

fn saved(store: &mut Memory, node: NodeId, group: Group, values: &Dictionary) -> Result<(), StoreError> {
    run(store, node, group, StoreRequest::Save, values)
}

fn restore_defaults(store: &mut Memory, node: NodeId, group: Group) -> Result<(), StoreError> {
    run(store, node, group, StoreRequest::Restore, &dictionary())
}

/// A dictionary that knows the objects of [`dictionary`] at their lengths.
fn loaded(store: &mut Memory, node: NodeId) -> (Dictionary, Loaded) {
    let mut values = Dictionary::new();
    let outcome = load::<NoNotes>(store, node, &mut |at, content| {
        let Content::Whole(value) = content else { panic!("{content:?}") };
        let known = dictionary();
        let known = known.get(&(at.index, at.sub)).ok_or(AbortCode::NoObject)?;
        if known.len() != value.len() {
            return Err(AbortCode::Length);
        }
        assert_eq!(values.insert((at.index, at.sub), value.to_vec()), None, "once");
        Ok(())
    });
    (values, outcome.unwrap())
}

/// CiA 301 7.5.2.13 and 7.5.2.14: the signatures as they stand there.
#[test]
fn the_signatures_are_those_of_the_standard() {
    assert_eq!((SAVE, LOAD), (0x6576_6173, 0x6461_6F6C));
}

#[test]
fn every_object_belongs_to_all_and_to_one_other_group() {
    let groups = [Group::Communication, Group::Application, Group::Manufacturer];
    for index in 0..=u16::MAX {
        assert!(Group::All.contains(index));
        assert_eq!(groups.iter().filter(|group| group.contains(index)).count(), 1, "{index:04X}h");
    }
    for (index, group) in [
        (0x1000, Group::Communication),
        (0x1FFF, Group::Communication),
        (0x2000, Group::Manufacturer),
        (0x5FFF, Group::Manufacturer),
        (0x6000, Group::Application),
        (0x9FFF, Group::Application),
    ] {
        assert!(group.contains(index), "{index:04X}h");
    }
    assert_eq!(
        [1, 2, 3, 4].map(Group::from_sub),
        [Some(Group::All), Some(Group::Communication), Some(Group::Application), Some(Group::Manufacturer),]
    );
    assert_eq!([0, 5].map(Group::from_sub), [None, None]);
}

#[test]
fn what_was_saved_is_loaded() {
    let mut store = Memory::default();
    assert_eq!(loaded(&mut store, NODE), (Dictionary::new(), Loaded::Nothing));
    saved(&mut store, NODE, Group::All, &dictionary()).unwrap();
    assert_eq!(loaded(&mut store, NODE), (dictionary(), Loaded::Set { applied: 5, skipped: 0 }));
}

#[test]
fn a_set_has_the_documented_format() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::Communication, &dictionary()).unwrap();
    let expected = [
        &b"EP\x02\x05"[..],
        &[0x17, 0x10, 0, 1, 2, 0, 0xE8, 0x03],
        &[0x00, 0x18, 1, 1, 4, 0, 0x85, 0x01, 0, 0],
    ];
    assert_eq!(store.stored, expected.concat());
}

/// Five values in a row: the third is of another length.
#[test]
fn values_of_sub_indices_in_a_row_share_a_header() {
    let mut store = Memory::default();
    let values: Dictionary =
        (0..5).map(|nth| ((0x1600, 1 + nth), if nth == 2 { vec![9] } else { vec![nth, 0x80] })).collect();
    saved(&mut store, NODE, Group::All, &values).unwrap();
    let rows = [
        &[0x00, 0x16, 1, 2, 2, 0, 0, 0x80, 1, 0x80][..],
        &[0x00, 0x16, 3, 1, 1, 0, 9],
        &[0x00, 0x16, 4, 2, 2, 0, 3, 0x80, 4, 0x80],
    ];
    assert_eq!(store.stored, [&b"EP\x02\x05"[..], &rows.concat()].concat());
    let mut found = Dictionary::new();
    let outcome = load::<NoNotes>(&mut store, NODE, &mut |at, content| {
        let Content::Whole(value) = content else { panic!("{content:?}") };
        found.insert((at.index, at.sub), value.to_vec());
        Ok(())
    });
    assert_eq!((found, outcome), (values, Ok(Loaded::Set { applied: 5, skipped: 0 })));
}

/// At most eight bytes of values and a header in each step.
#[test]
fn a_save_advances_a_few_words_at_a_time() {
    let mut store = Memory::default();
    let mut values = dictionary();
    values.insert((0x5FFF, 0), vec![7; 300]);
    for group in [Group::All, Group::Communication] {
        let mut save = Save::<NoNotes>::begin(&mut store, NODE, group, StoreRequest::Save).unwrap();
        let written = |store: &Memory| store.begun.as_ref().map_or(0, |(_, written)| written.len());
        let mut before = 0;
        while !save.advance(&mut store, &mut Values(&values)).unwrap() {
            assert!(written(&store) - before <= 8, "{group:?}");
            before = written(&store);
        }
        assert_eq!(loaded_in_parts(&mut store).len(), 5);
    }
}

#[test]
fn a_string_that_gets_shorter_during_a_save_fails_it() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::All, &dictionary()).unwrap();
    let before = store.stored.clone();
    let mut values = dictionary();
    let mut save = Save::<NoNotes>::begin(&mut store, NODE, Group::All, StoreRequest::Save).unwrap();
    while store.begun.is_none() {
        assert!(!save.advance(&mut store, &mut Values(&values)).unwrap());
    }
    values.insert((0x5FFF, 0), b"a".to_vec());
    let outcome = loop {
        match save.advance(&mut store, &mut Values(&values)) {
            Ok(false) => {}
            outcome => break outcome,
        }
    };
    assert_eq!((outcome, store.stored), (Err(StoreError::Size), before));
}

#[test]
fn saving_a_group_keeps_what_is_stored_of_the_others() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::All, &dictionary()).unwrap();
    let changed: Dictionary =
        dictionary().into_iter().map(|(at, value)| (at, value.iter().map(|byte| !byte).collect())).collect();
    for (group, indices) in [
        (Group::Manufacturer, &[0x2000, 0x5FFF][..]),
        (Group::Application, &[0x2000, 0x5FFF, 0x6000]),
        (Group::Communication, &[0x1017, 0x1800, 0x2000, 0x5FFF, 0x6000]),
    ] {
        saved(&mut store, NODE, group, &changed).unwrap();
        let (values, _) = loaded(&mut store, NODE);
        assert_eq!(values.len(), 5);
        for (at, value) in values {
            let source = if indices.contains(&at.0) { &changed } else { &dictionary() };
            assert_eq!(value, source[&at], "{group:?} {at:X?}");
        }
    }
}

#[test]
fn defaults_hold_again_for_the_group_that_is_restored() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::All, &dictionary()).unwrap();
    restore_defaults(&mut store, NODE, Group::Manufacturer).unwrap();
    let (values, _) = loaded(&mut store, NODE);
    assert_eq!(values.keys().map(|at| at.0).collect::<Vec<_>>(), [0x1017, 0x1800, 0x6000]);
    restore_defaults(&mut store, NODE, Group::All).unwrap();
    assert_eq!(loaded(&mut store, NODE), (Dictionary::new(), Loaded::Set { applied: 0, skipped: 0 }));
}

#[test]
fn new_firmware_skips_and_counts_what_it_does_not_take() {
    let mut store = Memory::default();
    let mut old = dictionary();
    old.insert((0x2005, 0), vec![1]);
    old.insert((0x1017, 0), vec![1, 2, 3, 4]);
    saved(&mut store, NODE, Group::All, &old).unwrap();
    let (values, outcome) = loaded(&mut store, NODE);
    assert_eq!(outcome, Loaded::Set { applied: 4, skipped: 2 });
    assert_eq!(values.get(&(0x1800, 1)), old.get(&(0x1800, 1)));
    assert!(!values.contains_key(&(0x1017, 0)));
}

#[test]
fn set_of_another_node_or_format_is_not_applied_nor_taken_over() {
    let other = NodeId::of::<6>();
    let mut store = Memory::default();
    saved(&mut store, other, Group::All, &dictionary()).unwrap();
    let before = store.clone();
    assert_eq!(loaded(&mut store, NODE), (Dictionary::new(), Loaded::Foreign { version: 2, node: 6 }));
    assert_eq!(store, before, "back at its old place the board finds it again");
    saved(&mut store, NODE, Group::Communication, &dictionary()).unwrap();
    let (values, _) = loaded(&mut store, NODE);
    assert_eq!(values.keys().map(|at| at.0).collect::<Vec<_>>(), [0x1017, 0x1800]);

    store.stored[2] = 1;
    assert_eq!(loaded(&mut store, NODE).1, Loaded::Foreign { version: 1, node: 5 });
    store.stored[0] = 0;
    assert_eq!(loaded(&mut store, NODE).1, Loaded::Nothing);
}

#[test]
fn set_that_ends_early_gives_whole_values_and_counts_the_rest() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::Communication, &dictionary()).unwrap();
    let whole = store.stored.clone();
    for len in 0..whole.len() {
        store.stored = whole[..len].to_vec();
        let (applied, skipped) = match len {
            0..4 => {
                assert_eq!(loaded(&mut store, NODE).1, Loaded::Nothing);
                continue;
            }
            4 => (0, 0),
            5..12 => (0, 1),
            12 => (1, 0),
            _ => (1, 1),
        };
        assert_eq!(loaded(&mut store, NODE).1, Loaded::Set { applied, skipped }, "{len} bytes");
    }
    // A length that nothing of this format has.
    store.stored = [&whole[..8], &[71, 0], &[0; 70]].concat();
    assert_eq!(loaded(&mut store, NODE).1, Loaded::Set { applied: 0, skipped: 1 });
}

#[test]
fn value_too_long_is_refused_before_anything_is_written() {
    let mut store = Memory::default();
    let mut values = dictionary();
    values.insert((0x5FFF, 0), vec![0; MAX_VALUE + 1]);
    assert_eq!(saved(&mut store, NODE, Group::All, &values), Err(StoreError::Size));
    assert_eq!(store, Memory::default());
    saved(&mut store, NODE, Group::Communication, &values).unwrap();
    values.insert((0x5FFF, 0), vec![0; MAX_VALUE]);
    saved(&mut store, NODE, Group::All, &values).unwrap();
}

/// Every value of a set, put together of its parts.
fn loaded_in_parts(store: &mut Memory) -> Vec<(u16, Vec<u8>)> {
    let (mut values, mut value) = (Vec::new(), Vec::new());
    let outcome = load::<NoNotes>(store, NODE, &mut |at, content| {
        match content {
            Content::Whole(whole) => values.push((at.index, whole.to_vec())),
            Content::Begin(len) => value = Vec::with_capacity(len),
            Content::Part(offset, bytes) => {
                assert_eq!(offset, value.len(), "in order");
                value.extend(bytes);
            }
            Content::End(len) => {
                assert_eq!(len, value.len());
                values.push((at.index, value.clone()));
            }
        }
        Ok(())
    });
    assert_eq!(outcome, Ok(Loaded::Set { applied: values.len() as u32, skipped: 0 }));
    values
}

#[test]
fn values_of_any_length_are_saved_kept_and_loaded() {
    for len in [0, 1, 63, 64, 65, 128, 254, 255, 256, 1000] {
        let value: Vec<u8> = (0..len).map(|byte| byte as u8).collect();
        let mut store = Memory::default();
        let values = Dictionary::from([((0x1017, 0), vec![7]), ((0x2001, 0), value.clone())]);
        saved(&mut store, NODE, Group::All, &values).unwrap();
        let expected = [(0x1017, vec![7]), (0x2001, value)];
        assert_eq!(loaded_in_parts(&mut store), expected, "{len} bytes");
        // Another group is saved: the long value moves from set to set.
        saved(&mut store, NODE, Group::Communication, &values).unwrap();
        assert_eq!(loaded_in_parts(&mut store), [expected[1].clone(), expected[0].clone()], "{len} bytes");
    }
}

#[test]
fn a_long_value_has_the_documented_format() {
    let mut store = Memory::default();
    for (len, header) in [(254, [254, 0]), (255, [255, 0]), (300, [44, 1])] {
        let values = Dictionary::from([((0x2001, 3), vec![9; len])]);
        saved(&mut store, NODE, Group::All, &values).unwrap();
        assert_eq!(store.stored, [&b"EP\x02\x05\x01\x20\x03\x01"[..], &header, &vec![9; len]].concat());
    }
}

#[test]
fn a_long_value_that_is_refused_is_skipped_where_it_is_refused() {
    let mut store = Memory::default();
    let values = Dictionary::from([((0x2001, 0), vec![1; 800]), ((0x2002, 0), vec![2])]);
    saved(&mut store, NODE, Group::All, &values).unwrap();
    for (refused_at, expected) in [(0, 1), (1, 2), (3, 4), (5, 6)] {
        let mut calls = 0;
        let outcome = load::<NoNotes>(&mut store, NODE, &mut |at, _| {
            calls += usize::from(at.index == 0x2001);
            if at.index == 0x2001 && calls > refused_at { Err(AbortCode::TooLong) } else { Ok(()) }
        });
        assert_eq!(outcome, Ok(Loaded::Set { applied: 1, skipped: 1 }));
        assert_eq!(calls, expected, "begin, four parts, end");
    }
}

#[test]
fn a_long_value_that_ends_early_is_not_applied() {
    let mut store = Memory::default();
    let values = Dictionary::from([((0x2001, 0), vec![1; 300])]);
    saved(&mut store, NODE, Group::All, &values).unwrap();
    let whole = store.stored.clone();
    for len in 5..whole.len() {
        store.stored = whole[..len].to_vec();
        let outcome = load::<NoNotes>(&mut store, NODE, &mut |_, _| panic!("{len} bytes"));
        assert_eq!(outcome, Ok(Loaded::Set { applied: 0, skipped: 1 }));
    }
}

#[test]
fn an_error_of_the_store_is_passed_on_and_the_old_set_stays() {
    let mut store = Memory::default();
    saved(&mut store, NODE, Group::All, &dictionary()).unwrap();
    let before = store.stored.clone();
    for n in 0..before.len() {
        store.fails_after = Some(n);
        let error = if n == 0 { StoreError::Full } else { StoreError::Hardware };
        assert_eq!(saved(&mut store, NODE, Group::Communication, &dictionary()), Err(error), "{n} bytes");
        assert_eq!(store.stored, before);
    }
}

/// CiA 301 7.2.4.3.17; a full area answers 08000022h.
#[test]
fn every_error_has_its_abort_code() {
    let codes = [StoreError::Full, StoreError::Size, StoreError::Hardware].map(|e| e.abort_code().code());
    assert_eq!(codes, [0x0800_0022, 0x0800_0020, 0x0606_0000]);
}
