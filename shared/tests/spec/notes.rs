//! Notes beside the parameter set (ECSS 8.3.3k, l), and the values that RAM retains over a reset.
//!
//! Verifies: ECSS 8.3.2a

use std::collections::BTreeMap;

use ecss_can::redundancy::machine::Retained;
use ecss_can::store::{
    Content, Group, Loaded, ParameterStore, Parameters, Row, Save, StoreError, StoreRequest, load,
    note_bdefault, noted_bdefault,
};
use ecss_can::types::{Address, Bus, NodeId};

const NODE: NodeId = NodeId::of::<5>();

/// A set and a note in RAM.
#[derive(Default)]
struct Memory {
    stored: Vec<u8>,
    begun: Vec<u8>,
    note: Option<u16>,
}

impl ParameterStore for Memory {
    fn stored_len(&self) -> usize {
        self.stored.len()
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        into.copy_from_slice(self.stored.get(offset..offset + into.len()).ok_or(StoreError::Size)?);
        Ok(())
    }

    fn begin(&mut self, _: usize) -> Result<(), StoreError> {
        self.begun.clear();
        Ok(())
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.begun.extend(bytes);
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        self.stored = std::mem::take(&mut self.begun);
        self.note = None;
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        self.note
    }

    fn write_note(&mut self, note: u16) -> Result<(), StoreError> {
        self.note = Some(note);
        Ok(())
    }
}

type Dictionary = BTreeMap<(u16, u8), Vec<u8>>;

/// The values of a dictionary, each a row of its own.
struct Values<'a>(&'a Dictionary);

impl Parameters for Values<'_> {
    fn find(&mut self, from: Address) -> Option<Row> {
        let (&(index, sub), value) = self.0.range((from.index, from.sub)..).next()?;
        Some(Row { at: Address::new(index, sub), count: 1, len: value.len() })
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize {
        let value = &self.0[&(at.index, at.sub)];
        into.copy_from_slice(&value[offset..][..into.len()]);
        into.len()
    }
}

fn run(store: &mut Memory, group: Group, request: StoreRequest, values: &Dictionary) {
    let mut save = Save::begin(store, NODE, group, request).unwrap();
    while !save.advance(store, &mut Values(values)).unwrap() {}
}

/// Node 5 and Bdefault 1: Bh.
///
/// Verifies: ECSS 8.3.3l
/// Notices: ECSS 8.3.2a: a node takes the noted Bdefault of another node.
#[test]
fn a_note_holds_node_and_bdefault_and_is_of_its_node_alone() {
    let mut store = Memory::default();
    for bus in Bus::ALL {
        note_bdefault(&mut store, NODE, bus).unwrap();
        assert_eq!(noted_bdefault(&store, NODE), Some(bus));
        assert_eq!(noted_bdefault(&store, NodeId::of::<6>()), None);
    }
    assert_eq!(store.note, Some(0x00B));
    // Node 5, with a bit that no note has.
    store.note = Some(0x10B);
    assert_eq!(noted_bdefault(&store, NODE), None);
}

/// Every 2000h sub 1 that is applied, in order.
fn bdefaults(store: &mut Memory, node: NodeId) -> (Vec<u8>, Loaded) {
    let mut found = Vec::new();
    let outcome = load(store, node, &mut |at, content| {
        if let (0x2000, 1, Content::Whole(&[bdefault])) = (at.index, at.sub, content) {
            found.push(bdefault);
        }
        Ok(())
    });
    (found, outcome.unwrap())
}

fn with_bdefault(bdefault: u8) -> Dictionary {
    BTreeMap::from([((0x1017, 0), vec![1, 0]), ((0x2000, 1), vec![bdefault])])
}

/// Verifies: ECSS 8.3.3l
/// Notices: ECSS 8.3.2a: the stored Bdefault is applied after the one that was noted later.
#[test]
fn a_noted_bdefault_is_applied_after_the_stored_one() {
    let mut store = Memory::default();
    note_bdefault(&mut store, NODE, Bus::Redundant).unwrap();
    assert_eq!(bdefaults(&mut store, NODE), (vec![1], Loaded::Set { applied: 1, skipped: 0 }));
    assert_eq!(bdefaults(&mut store, NodeId::of::<6>()), (vec![], Loaded::Nothing));
    run(&mut store, Group::All, StoreRequest::Save, &with_bdefault(0));
    assert_eq!(bdefaults(&mut store, NODE), (vec![0], Loaded::Set { applied: 2, skipped: 0 }), "the save");
    note_bdefault(&mut store, NODE, Bus::Redundant).unwrap();
    assert_eq!(bdefaults(&mut store, NODE), (vec![0, 1], Loaded::Set { applied: 3, skipped: 0 }));
    // On top of the set of another node.
    store.stored[3] = 6;
    assert_eq!(bdefaults(&mut store, NODE), (vec![1], Loaded::Foreign { version: 2, node: 6 }));
}

/// Given a noted Bdefault, when another group is saved or restored, then the stored set has the noted value.
///
/// Verifies: ECSS 11.1b, 8.3.3l
/// Notices: ECSS 11.1b: a save of another group loses the noted Bdefault.
/// Notices: ECSS 8.3.3l: a save of the communication parameters sets Bdefault back.
#[test]
fn a_save_of_other_groups_takes_the_note_into_the_set() {
    for first in [None, Some(0)] {
        let mut store = Memory::default();
        if let Some(bdefault) = first {
            run(&mut store, Group::All, StoreRequest::Save, &with_bdefault(bdefault));
        }
        note_bdefault(&mut store, NODE, Bus::Redundant).unwrap();
        run(&mut store, Group::Communication, StoreRequest::Save, &with_bdefault(0));
        assert_eq!(store.note, None);
        assert_eq!(bdefaults(&mut store, NODE), (vec![1], Loaded::Set { applied: 2, skipped: 0 }));
        note_bdefault(&mut store, NODE, Bus::Nominal).unwrap();
        run(&mut store, Group::Communication, StoreRequest::Restore, &with_bdefault(0));
        assert_eq!(bdefaults(&mut store, NODE), (vec![0], Loaded::Set { applied: 1, skipped: 0 }));
    }
}

#[test]
fn a_save_or_restore_of_its_group_ends_the_note() {
    for group in [Group::All, Group::Manufacturer] {
        let mut store = Memory::default();
        note_bdefault(&mut store, NODE, Bus::Redundant).unwrap();
        run(&mut store, group, StoreRequest::Save, &with_bdefault(0));
        assert_eq!(bdefaults(&mut store, NODE).0, [0]);
        note_bdefault(&mut store, NODE, Bus::Redundant).unwrap();
        run(&mut store, group, StoreRequest::Restore, &with_bdefault(0));
        assert_eq!(bdefaults(&mut store, NODE).0, []);
    }
}

/// Verifies: ECSS 8.3.3l
#[test]
fn retained_values_come_back_from_their_words() {
    for bdefault in [None, Some(Bus::Nominal), Some(Bus::Redundant)] {
        for (resets, notes) in [(0, 0), (3, 8), (255, 255)] {
            let retained = Retained { bdefault, resets, notes };
            assert_eq!(Retained::decode(retained.encode()), Some(retained));
        }
    }
    let retained = Retained { bdefault: Some(Bus::Redundant), resets: 3, notes: 4 };
    assert_eq!(retained.encode(), [0xEC04_0301, 0x13FB_FCFE]);
}

/// RAM after power-on holds anything.
///
/// Notices: ECSS 8.3.2a: what stands in RAM after power-on is taken for a retained Bdefault.
#[test]
fn words_that_do_not_fit_together_retain_nothing() {
    let [word, check] = Retained { bdefault: Some(Bus::Redundant), resets: 2, notes: 1 }.encode();
    for bit in 0..32 {
        assert_eq!(Retained::decode([word ^ 1 << bit, check]), None, "bit {bit}");
        assert_eq!(Retained::decode([word, check ^ 1 << bit]), None, "bit {bit}");
    }
    for pattern in [0, u32::MAX, 0xAAAA_AAAA, 0x5555_5555, 0xEC00_0003] {
        assert_eq!(Retained::decode([pattern, pattern]), None);
        assert_eq!(Retained::decode([pattern, !pattern]), None);
    }
}
