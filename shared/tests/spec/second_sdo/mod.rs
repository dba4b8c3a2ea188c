//! A slave with two SDO servers (1200h and 1201h), and a client of each.

mod rules;
mod slave;
mod transfers;

use std::collections::VecDeque;

use async_canopen::node::{CanopenSlave, Settings};
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceNode, Node, Slave};
use ecss_can::od::{Domain, Objects, VisibleString};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::Client;
use ecss_can::types::Address;

use crate::bench::{Bench, NOMINAL, node, span};
use crate::device::fixture::{Memory, done};
use crate::instrument::STANDARD;

/// Index of the second channel.
const SECOND_SDO: u16 = 0x1201;
/// Index of a block of bytes that "save" stores.
const BLOCK: u16 = 0x6300;
/// Index of a block of bytes that "save" does not store.
const SPARE: u16 = 0x6301;
/// "The present state of the device does not allow it."
const DEVICE_STATE: u32 = 0x0800_0022;

/// A number, two blocks of bytes and a text.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device, sdo_servers = 2)]
struct Recorder {
    /// Number
    #[object(0x6000, rw, pdo)]
    number: u32,
    /// Block
    #[object(0x6300, rw, keep, default = Domain::unwritten())]
    block: Domain<[u8; 2048]>,
    /// Spare block
    #[object(0x6301, rw, default = Domain::unwritten())]
    spare: Domain<[u8; 2048]>,
    /// Text
    #[object(0x6302, rw)]
    text: VisibleString<40>,
}

impl Device for Recorder {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<2>;

    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::node(0x200)).map(Recorder::NUMBER).receive(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Recorder::NUMBER).transmit(1)],
    );
}

/// COB-IDs of a client: of its requests, and of the answers to it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Channel {
    request: u16,
    answer: u16,
}

const FIRST: Channel = Channel { request: 0x605, answer: 0x585 };
const SECOND: Channel = Channel { request: 0x6C5, answer: 0x6B5 };
const BOTH: [Channel; 2] = [FIRST, SECOND];

type TestSlave = Bench<Slave<Recorder>>;

/// Slave of a spacecraft that heard its master, in Operational.
fn spacecraft_slave() -> TestSlave {
    stored_slave(None)
}

fn stored_slave(memory: Option<&Memory>) -> TestSlave {
    let slave = Slave::builder(node(5), &STANDARD, Recorder::default());
    let mut slave = Bench::new(match memory {
        Some(memory) => slave.store(Box::leak(Box::new(memory.clone()))).build(),
        None => slave.build(),
    });
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave
}

/// Slave by CiA 301 alone, in Operational.
fn plain_slave() -> Bench<CanopenSlave<Recorder>> {
    let mut slave = Bench::new(CanopenSlave::new(node(5), &Settings::DEFAULT, Recorder::default()));
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave
}

/// The client of the first server makes the second channel valid.
fn open<N: Node>(slave: &mut Bench<N>) {
    for (sub, id) in [(1, SECOND.request), (2, SECOND.answer)] {
        assert_eq!(write(slave, FIRST, SECOND_SDO, sub, &u32::from(id).to_le_bytes()), done(SECOND_SDO, sub));
    }
    // Changed filters.
    let until = slave.now + span(2);
    slave.run_until(until);
    slave.clear();
}

/// Payloads on a channel to its client so far.
fn answers<N: Node>(slave: &Bench<N>, channel: Channel) -> Vec<[u8; 8]> {
    let own = slave.sent.iter().filter(|sent| sent.frame.id().raw() == channel.answer);
    own.map(|sent| sent.frame.padded()).collect()
}

/// The one answer to a request. It is the only SDO frame on both channels.
fn ask<N: Node>(slave: &mut Bench<N>, channel: Channel, request: [u8; 8]) -> [u8; 8] {
    slave.clear();
    slave.receive(NOMINAL, channel.request, &request);
    if BOTH.iter().all(|channel| answers(slave, *channel).is_empty()) {
        slave.finish_save();
    }
    let other = BOTH.into_iter().find(|other| *other != channel).unwrap();
    assert_eq!(answers(slave, other), [[0; 8]; 0], "to the other client: {request:02X?}");
    let [answer] = answers(slave, channel)[..] else {
        panic!("one answer to {request:02X?}: {:?}", slave.sent)
    };
    answer
}

fn write<N: Node>(slave: &mut Bench<N>, channel: Channel, index: u16, sub: u8, value: &[u8]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let mut request = [0x23 | (4 - value.len() as u8) << 2, low, high, sub, 0, 0, 0, 0];
    request[4..][..value.len()].copy_from_slice(value);
    ask(slave, channel, request)
}

fn read<N: Node>(slave: &mut Bench<N>, channel: Channel, index: u16, sub: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    let [command, _, _, _, value @ ..] = ask(slave, channel, [0x40, low, high, sub, 0, 0, 0, 0]);
    assert_eq!(command & 0xE3, 0x43, "an expedited answer");
    u32::from_le_bytes(value)
}

/// Bytes of a file.
fn pattern(len: usize, seed: u8) -> Vec<u8> {
    (0..len).map(|nth| (nth * 7) as u8 ^ seed).collect()
}

/// A client on a channel, with one transfer.
struct Transfer {
    channel: Channel,
    client: Client,
    /// Bytes to write.
    value: Vec<u8>,
    pushed: usize,
    /// Bytes that were read.
    read: Vec<u8>,
    requests: VecDeque<[u8; 8]>,
    outcome: Option<Result<usize, Error>>,
}

impl Transfer {
    fn new(channel: Channel) -> Transfer {
        Transfer {
            channel,
            client: Client::new(span(500)),
            value: vec![],
            pushed: 0,
            read: vec![],
            requests: VecDeque::new(),
            outcome: None,
        }
    }

    fn upload(channel: Channel, index: u16, mode: Mode) -> Transfer {
        let mut transfer = Transfer::new(channel);
        transfer.client.start_upload(Address::new(index, 0), 4_096, mode);
        transfer
    }

    fn download(channel: Channel, index: u16, value: Vec<u8>, mode: Mode) -> Transfer {
        let mut transfer = Transfer { value, ..Transfer::new(channel) };
        transfer.client.start_download(Address::new(index, 0), transfer.value.len(), mode);
        transfer
    }

    /// The application moves bytes, the client sends what is due, and one of its frames reaches the slave.
    fn step<N: Node>(&mut self, slave: &mut Bench<N>) {
        self.pushed += self.client.push(&self.value[self.pushed..]);
        self.pull();
        let requests = &mut self.requests;
        self.client.poll(slave.now, &mut |payload| requests.push_back(payload));
        if let Some(request) = self.requests.pop_front() {
            slave.receive(NOMINAL, self.channel.request, &request);
            self.client.on_sent();
        }
        self.outcome = self.outcome.or(self.client.outcome());
    }

    fn pull(&mut self) {
        let mut bytes = [0; 64];
        loop {
            let count = self.client.pull(&mut bytes);
            self.read.extend(&bytes[..count]);
            if count == 0 {
                return;
            }
        }
    }
}

/// Runs transfers to their ends, one frame of each client after the other.
fn run<N: Node>(slave: &mut Bench<N>, transfers: &mut [Transfer]) {
    slave.clear();
    for _ in 0..10_000 {
        for nth in 0..transfers.len() {
            transfers[nth].step(slave);
            deliver(slave, transfers);
        }
        if transfers.iter().all(|transfer| transfer.outcome.is_some()) {
            return;
        }
    }
    panic!("a transfer has no end");
}

/// All that the slave has sent reaches the clients.
fn deliver<N: Node>(slave: &mut Bench<N>, transfers: &mut [Transfer]) {
    while !slave.sent.is_empty() {
        for sent in std::mem::take(&mut slave.sent) {
            let id = sent.frame.id().raw();
            if let Some(transfer) = transfers.iter_mut().find(|transfer| transfer.channel.answer == id) {
                let requests = &mut transfer.requests;
                let response = sent.frame.padded();
                transfer.client.on_response(&response, slave.now, &mut |payload| requests.push_back(payload));
                transfer.pull();
            }
            slave.transmitted(sent.bus, sent.frame);
        }
    }
}

/// Content of both blocks.
fn blocks<N: DeviceNode<Device = Recorder>>(slave: &mut Bench<N>) -> [Vec<u8>; 2] {
    slave.touch(|slave, now| {
        slave.change(now, |recorder| [recorder.block.as_bytes().to_vec(), recorder.spare.as_bytes().to_vec()])
    })
}

/// Writes a block by the first server.
fn fill<N: Node>(slave: &mut Bench<N>, index: u16, value: &[u8]) {
    let mut transfers = [Transfer::download(FIRST, index, value.to_vec(), Mode::Block)];
    run(slave, &mut transfers);
    assert_eq!(transfers[0].outcome, Some(Ok(value.len())));
}
