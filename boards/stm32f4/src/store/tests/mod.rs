//! The log on a flash that fails at every possible operation.

mod damage;
mod mock;
mod node_id;
mod notes;
mod power;
mod room;

use ecss_can::store::{Group, ParameterStore, Parameters, Row, Save, StoreError, StoreRequest};
use ecss_can::types::{Address, NodeId};
use mock::{Flash, PAGE, Remains};

use super::log::{MAX_SET, Opened, ParameterLog};

type Log = ParameterLog<Flash>;

/// Returns a set that differs from every other one in each byte.
fn set(number: u8, len: usize) -> Vec<u8> {
    (0..len).map(|k| number.wrapping_mul(31).wrapping_add(k as u8)).collect()
}

fn open(flash: Flash) -> (Log, Opened) {
    Log::open(flash, 0).unwrap()
}

/// Writes a set in uneven pieces.
fn save(log: &mut Log, set: &[u8]) -> Result<(), StoreError> {
    log.begin(set.len())?;
    for piece in set.chunks(7) {
        log.append(piece)?;
    }
    log.commit()
}

fn stored(log: &mut Log) -> Vec<u8> {
    let mut set = vec![0; log.stored_len()];
    if !set.is_empty() {
        log.read(0, &mut set).unwrap();
    }
    set
}

/// Values of a dictionary: address and bytes, in rising order.
struct Values<'a>(&'a [(Address, &'a [u8])]);

impl Parameters for Values<'_> {
    fn find(&mut self, from: Address) -> Option<Row> {
        let is_behind = |(at, _): &&(Address, &[u8])| (at.index, at.sub) >= (from.index, from.sub);
        let (at, value) = self.0.iter().find(is_behind)?;
        Some(Row { at: *at, count: 1, len: value.len() })
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize {
        let Some((_, value)) = self.0.iter().find(|(found, _)| *found == at) else { return 0 };
        into.iter_mut().zip(&value[offset..]).map(|(to, from)| *to = *from).count()
    }
}

/// Saves values of node 3, or restores the defaults of a group.
fn store_values(log: &mut Log, group: Group, request: StoreRequest, values: &[(Address, &[u8])]) {
    let mut save = Save::begin(log, NodeId::of::<3>(), group, request).unwrap();
    while !save.advance(log, &mut Values(values)).unwrap() {}
}

/// Returns the set that the next start finds.
fn after_restart(flash: Flash) -> (Vec<u8>, Opened) {
    let (mut log, opened) = open(flash);
    (stored(&mut log), opened)
}

/// Saves numbered sets of `len` bytes until there is no more room; returns how many.
fn fill(log: &mut Log, len: usize) -> u8 {
    (0..).find(|&number| save(log, &set(number, len)) == Err(StoreError::Full)).unwrap()
}
