//! The log on a flash that fails wherever it can.

mod damage;
mod mock;
mod node_id;
mod notes;
mod power;
mod room;

use ecss_can::store::{ParameterStore, StoreError};
use mock::{Flash, PAGE, Remains};

use super::log::{MAX_SET, Opened, ParameterLog};

type Log = ParameterLog<Flash>;

/// A set that is told from every other by each of its bytes.
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

/// What is stored when the chip starts next time.
fn after_restart(flash: Flash) -> (Vec<u8>, Opened) {
    let (mut log, opened) = open(flash);
    (stored(&mut log), opened)
}

/// Saves numbered sets of `len` bytes until there is no more room; returns how many.
fn fill(log: &mut Log, len: usize) -> u8 {
    (0..).find(|&number| save(log, &set(number, len)) == Err(StoreError::Full)).unwrap()
}
