//! A slave on the bench and its SDO client on the wire; a parameter store in RAM.

use std::sync::{Arc, Mutex};

use crate::instrument::{self, STANDARD};
use ecss_can::node::{Slave, SpacecraftDevice};
use ecss_can::od::{INVALID, NO_REMOTE};
use ecss_can::profile::Profile;
use ecss_can::store::{Loss, ParameterStore, StoreError};
use ecss_can::types::{Bus, Instant, NodeId};

use crate::bench::{Bench, NOMINAL, node, span};
use crate::slave::TestSlave;

/// A store in RAM that outlives the nodes.
#[derive(Clone, Default)]
pub(crate) struct Memory {
    stored: Arc<Mutex<Vec<u8>>>,
    note: Arc<Mutex<Option<u16>>>,
    node_id: Arc<Mutex<Option<NodeId>>>,
    begun: Vec<u8>,
    is_full: bool,
    /// Bytes of a set, if that is limited.
    room: Option<usize>,
    /// The last word of a set does not take.
    is_broken: bool,
    /// Loss since the last save.
    pub(crate) loss: Arc<Mutex<Option<Loss>>>,
}

impl Memory {
    /// One without room.
    pub(crate) fn full() -> Memory {
        Memory { is_full: true, ..Memory::default() }
    }

    /// One without room that holds a Node-ID.
    pub(crate) fn full_with(id: NodeId) -> Memory {
        Memory { node_id: Arc::new(Mutex::new(Some(id))), ..Memory::full() }
    }

    /// One that does not take the last word of a set.
    pub(crate) fn broken() -> Memory {
        Memory { is_broken: true, ..Memory::default() }
    }

    /// One for sets of at most `room` bytes.
    pub(crate) fn with_room(room: usize) -> Memory {
        Memory { room: Some(room), ..Memory::default() }
    }
}

impl ParameterStore for Memory {
    fn stored_len(&self) -> usize {
        self.stored.lock().unwrap().len()
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        let stored = self.stored.lock().unwrap();
        into.copy_from_slice(stored.get(offset..offset + into.len()).ok_or(StoreError::Size)?);
        Ok(())
    }

    fn check(&mut self) -> Option<Loss> {
        *self.loss.lock().unwrap()
    }

    fn begin(&mut self, len: usize) -> Result<(), StoreError> {
        self.begun.clear();
        match self.room {
            _ if self.is_full => Err(StoreError::Full),
            Some(room) if len > room => Err(StoreError::Size),
            _ => Ok(()),
        }
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.begun.extend(bytes);
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        if self.is_broken {
            return Err(StoreError::Hardware);
        }
        *self.stored.lock().unwrap() = std::mem::take(&mut self.begun);
        *self.note.lock().unwrap() = None;
        *self.loss.lock().unwrap() = None;
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        *self.note.lock().unwrap()
    }

    fn write_note(&mut self, note: u16) -> Result<(), StoreError> {
        if self.is_full {
            return Err(StoreError::Full);
        }
        *self.note.lock().unwrap() = Some(note);
        Ok(())
    }

    fn node_id(&mut self) -> Option<NodeId> {
        *self.node_id.lock().unwrap()
    }

    fn store_node_id(&mut self, id: Option<NodeId>) -> Result<(), StoreError> {
        if self.is_full {
            return Err(StoreError::Full);
        }
        *self.node_id.lock().unwrap() = id;
        Ok(())
    }
}

pub(crate) fn powered() -> Bench<TestSlave> {
    Bench::new(instrument::slave(node(5), &STANDARD, vec![0; 1024]))
}

pub(crate) fn powered_with(memory: &Memory) -> Bench<TestSlave> {
    let slave = instrument::builder(node(5), &STANDARD, vec![]);
    Bench::new(slave.store(Box::leak(Box::new(memory.clone()))).build())
}

/// Answer to an SDO request on the nominal bus.
pub(crate) fn ask<A: SpacecraftDevice>(slave: &mut Bench<Slave<A>>, request: [u8; 8]) -> [u8; 8] {
    ask_on(slave, NOMINAL, request)
}

pub(crate) fn ask_on<A: SpacecraftDevice>(
    slave: &mut Bench<Slave<A>>,
    bus: Bus,
    request: [u8; 8],
) -> [u8; 8] {
    slave.sent.clear();
    slave.receive(bus, 0x605, &request);
    if slave.sent.iter().all(|sent| sent.frame.id().raw() != 0x585) {
        // A save is answered when it has ended.
        slave.finish_save();
    }
    let answers: Vec<_> = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x585).collect();
    assert_eq!((answers.len(), answers[0].bus), (1, bus), "one answer to {request:02X?}");
    answers[0].frame.padded()
}

pub(crate) fn write<A: SpacecraftDevice>(
    slave: &mut Bench<Slave<A>>,
    index: u16,
    sub: u8,
    value: &[u8],
) -> [u8; 8] {
    write_on(slave, NOMINAL, index, sub, value)
}

pub(crate) fn write_on<A: SpacecraftDevice>(
    slave: &mut Bench<Slave<A>>,
    bus: Bus,
    index: u16,
    sub: u8,
    value: &[u8],
) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let mut data = [0; 4];
    data[..value.len()].copy_from_slice(value);
    let command = 0x23 | ((4 - value.len() as u8) << 2);
    ask_on(slave, bus, [command, low, high, sub, data[0], data[1], data[2], data[3]])
}

pub(crate) fn done(index: u16, sub: u8) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [0x60, low, high, sub, 0, 0, 0, 0]
}

pub(crate) fn refused(index: u16, sub: u8, code: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), code.to_le_bytes());
    [0x80, low, high, sub, a, b, c, d]
}

pub(crate) fn read<A: SpacecraftDevice>(slave: &mut Bench<Slave<A>>, index: u16, sub: u8) -> [u8; 4] {
    let [low, high] = index.to_le_bytes();
    let answer = ask(slave, [0x40, low, high, sub, 0, 0, 0, 0]);
    assert_eq!(answer[0] & 0xE3, 0x43, "an expedited answer: {answer:02X?}");
    answer[4..].try_into().unwrap()
}

/// To be written: emergencies follow each other as they come.
pub(crate) const NO_INHIBIT: (u16, u8, &[u8]) = (0x1015, 0, &[0, 0]);

/// In Operational at zero, the master heard.
pub(crate) fn operational() -> Bench<TestSlave> {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave
}

/// One that goes to Operational by itself.
pub(crate) fn autostarted() -> Bench<TestSlave> {
    Bench::new(instrument::slave(node(5), &Profile { autostart: true, ..STANDARD }, vec![]))
}

/// Several writes, all of which are taken.
pub(crate) fn write_all<A: SpacecraftDevice>(slave: &mut Bench<Slave<A>>, steps: &[(u16, u8, &[u8])]) {
    for (index, sub, value) in steps {
        assert_eq!(write(slave, *index, *sub, value), done(*index, *sub), "{index:04X}h:{sub} {value:02X?}");
    }
}

/// TPDO `number`, with its COB-ID of the pre-defined connection set, carries these objects from now on.
pub(crate) fn map_tpdo<A: SpacecraftDevice>(
    slave: &mut Bench<Slave<A>>,
    number: u16,
    transmission: u8,
    objects: &[u32],
) {
    let (parameters, mapping) = (0x17FF + number, 0x19FF + number);
    let id = NO_REMOTE | u32::from(0x85 + 0x100 * number);
    write_all(slave, &[(parameters, 1, &(INVALID | id).to_le_bytes()), (mapping, 0, &[0])]);
    for (sub, object) in (1..).zip(objects) {
        write_all(slave, &[(mapping, sub, &object.to_le_bytes())]);
    }
    write_all(slave, &[(mapping, 0, &[objects.len() as u8]), (parameters, 2, &[transmission])]);
    write_all(slave, &[(parameters, 1, &id.to_le_bytes())]);
}

/// Time passes with the master heard on the nominal bus, ten times a second.
pub(crate) fn run_with_master<A: SpacecraftDevice>(slave: &mut Bench<Slave<A>>, until: Instant) {
    while slave.now < until {
        slave.run_until((slave.now + span(100)).min(until));
        slave.receive(NOMINAL, 0x701, &[5]);
    }
}

/// Payloads of this COB-ID that were sent so far.
pub(crate) fn payloads<A: SpacecraftDevice>(slave: &Bench<Slave<A>>, id: u16) -> Vec<Vec<u8>> {
    let of_id = slave.sent.iter().filter(|sent| sent.frame.id().raw() == id);
    of_id.map(|sent| sent.frame.data().to_vec()).collect()
}

/// The request that begins a segmented download.
pub(crate) fn initiate(index: u16, sub: u8, size: usize) -> [u8; 8] {
    let ([low, high], [a, b, ..]) = (index.to_le_bytes(), size.to_le_bytes());
    [0x21, low, high, sub, a, b, 0, 0]
}

/// The answer to the last segment of a download.
pub(crate) fn download<A: SpacecraftDevice>(
    slave: &mut Bench<Slave<A>>,
    index: u16,
    sub: u8,
    value: &[u8],
) -> [u8; 8] {
    assert_eq!(ask(slave, initiate(index, sub, value.len())), done(index, sub));
    let (mut answer, mut toggle, mut rest) = ([0; 8], 0, value);
    while !rest.is_empty() {
        let (part, behind) = rest.split_at(rest.len().min(7));
        let mut segment = [0; 8];
        segment[0] = toggle << 4 | (7 - part.len() as u8) << 1 | u8::from(behind.is_empty());
        segment[1..][..part.len()].copy_from_slice(part);
        answer = ask(slave, segment);
        assert!(behind.is_empty() || answer[0] == 0x20 | toggle << 4, "{answer:02X?}");
        (toggle, rest) = (toggle ^ 1, behind);
    }
    answer
}

/// The register 1001h and how many errors 1003h remembers.
pub(crate) fn errors<A: SpacecraftDevice>(slave: &mut Bench<Slave<A>>) -> (u8, u8) {
    (read(slave, 0x1001, 0)[0], read(slave, 0x1003, 0)[0])
}
