//! The operations, and whether their outcome is right.

use std::hint::black_box;

use anyhow::ensure;
use ecss_can::heartbeat;
use ecss_can::pdo::{CobIdOf, Mapping, PdoMapping};
use ecss_can::time::TimeSource;
use ecss_can::time::machine::LocalClock;
use ecss_can::types::{Bus, CobId, FineInstant, FineScet, Frame, NmtState, NodeId};

use crate::harness::Harness;
use crate::objects::{Application, NODE, PEER, receive_id, transmit_id};

/// Nobody knows it.
const FOREIGN: CobId = CobIdOf::node(0x380).of(PEER);

/// Segments of a block download.
const SEGMENTS: u32 = 4_000;
/// Segments of a sub-block: the most there are, which the server asks for.
const SUB_BLOCK: u32 = 127;

/// RPDO of 4 x 16 bit: frame in, values in the dictionary.
pub fn rpdo<M: Mapping>(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<M>::new(FOREIGN)?;
    for n in 0..repetitions {
        let [low, high, ..] = n.to_le_bytes();
        harness.receive(Frame::of(receive_id(), [low, high, 2, 2, low, high, 4, 4]));
    }
    let (received, last) = (harness.slave.objects().application.received, repetitions.wrapping_sub(1) as u16);
    ensure!(repetitions == 0 || received == [last, 0x0202, last, 0x0404], "received {received:?}");
    Ok(())
}

/// The same where each value is an object of its own.
pub fn rpdo_scattered(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping, true>::new(FOREIGN)?;
    for n in 0..repetitions {
        let [low, high, ..] = n.to_le_bytes();
        harness.receive(Frame::of(receive_id(), [low, high, 2, 2, low, high, 4, 4]));
    }
    let application = &harness.slave.objects().application;
    let received = [application.one, application.three, application.two, application.four];
    let last = repetitions.wrapping_sub(1) as u16;
    ensure!(repetitions == 0 || received == [last, 0x0202, last, 0x0404], "received {received:?}");
    Ok(())
}

/// SYNC in, TPDO of 4 x 16 bit that are objects of their own out.
pub fn sync_scattered(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping, true>::new(transmit_id())?;
    for n in 0..repetitions {
        harness.change(|objects| objects.two = n as u16);
        harness.receive(Frame::of(CobId::SYNC, []));
    }
    check_sent(&harness, repetitions)
}

/// SYNC in, TPDO of 4 x 16 bit out.
pub fn sync<M: Mapping>(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<M>::new(transmit_id())?;
    for n in 0..repetitions {
        harness.change(|objects| objects.sent[2] = n as u16);
        harness.receive(Frame::of(CobId::SYNC, []));
    }
    check_sent(&harness, repetitions)
}

/// Whether so many TPDOs came, the last one with the number of the last repetition as its third value.
fn check_sent<M: Mapping, const S: bool>(harness: &Harness<M, S>, repetitions: u32) -> anyhow::Result<()> {
    ensure!(harness.answers == repetitions, "{} TPDOs", harness.answers);
    let [_, _, _, _, low, high, ..] = harness.answer.padded();
    let last = repetitions.wrapping_sub(1) as u16;
    ensure!(repetitions == 0 || u16::from_le_bytes([low, high]) == last, "sent {:?}", harness.answer);
    Ok(())
}

/// SDO upload of a u32: request in, response out.
pub fn upload(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping>::new(CobId::sdo_response(NODE))?;
    harness.change(|objects| objects.number = 0x1234_5678);
    let [low, high] = Application::NUMBER.address().index.to_le_bytes();
    for _ in 0..repetitions {
        harness.receive(Frame::of(CobId::sdo_request(NODE), [0x40, low, high, 0, 0, 0, 0, 0]));
    }
    ensure!(harness.answers == repetitions, "{} responses", harness.answers);
    let expected = [0x43, low, high, 0, 0x78, 0x56, 0x34, 0x12];
    ensure!(repetitions == 0 || harness.answer.padded() == expected, "sent {:?}", harness.answer);
    Ok(())
}

/// SDO download of a u32: request in, value in the dictionary and response out.
pub fn write(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping>::new(CobId::sdo_response(NODE))?;
    let [low, high] = Application::NUMBER.address().index.to_le_bytes();
    for n in 0..repetitions {
        let [a, b, c, d] = (n + 1).to_le_bytes();
        harness.receive(Frame::of(CobId::sdo_request(NODE), [0x23, low, high, 0, a, b, c, d]));
    }
    ensure!(harness.answers == repetitions, "{} responses", harness.answers);
    let expected = [0x60, low, high, 0, 0, 0, 0, 0];
    ensure!(repetitions == 0 || harness.answer.padded() == expected, "sent {:?}", harness.answer);
    let number = harness.slave.objects().application.number;
    ensure!(number == repetitions, "wrote {number}");
    Ok(())
}

/// Block downloads with checksum, `repetitions` segments in all: beginnings, acknowledgements and ends among them.
pub fn block_download(repetitions: u32) -> anyhow::Result<()> {
    ensure!(repetitions.is_multiple_of(SEGMENTS), "a block download has {SEGMENTS} segments here");
    let mut harness = Harness::<PdoMapping>::new(CobId::sdo_response(NODE))?;
    let data: Vec<u8> = (0..SEGMENTS * 7).map(|n| (n ^ n >> 8 ^ n >> 13) as u8).collect();
    let request = |payload| Frame::of(CobId::sdo_request(NODE), payload);
    let [low, high] = Application::BLOCK.address().index.to_le_bytes();
    let size = (data.len() as u32).to_le_bytes();
    let begin = request([0xC6, low, high, 0, size[0], size[1], size[2], size[3]]);
    let segment = |(number, data): (u32, &[u8])| {
        let last = if number == SEGMENTS - 1 { 0x80 } else { 0 };
        let mut payload = [0; 8];
        payload[0] = last | (number % SUB_BLOCK + 1) as u8;
        payload[1..].copy_from_slice(data);
        request(payload)
    };
    let segments: Vec<Frame> = (0..).zip(data.chunks_exact(7)).map(segment).collect();
    let [crc_low, crc_high] = crc(&data).to_le_bytes();
    let end = request([0xC1, crc_low, crc_high, 0, 0, 0, 0, 0]);
    let transfers = repetitions / SEGMENTS;
    for _ in 0..transfers {
        harness.receive(begin);
        segments.iter().for_each(|segment| harness.receive(*segment));
        harness.receive(end);
    }
    let per_transfer = 2 + SEGMENTS.div_ceil(SUB_BLOCK);
    ensure!(harness.answers == transfers * per_transfer, "{} responses", harness.answers);
    let written = harness.slave.objects().application.block.as_bytes();
    ensure!(transfers == 0 || written == data, "other data were written");
    Ok(())
}

/// Heartbeat of the master: the redundancy slave and its application hear of it.
pub fn heartbeat(repetitions: u32) -> anyhow::Result<()> {
    consume(heartbeat::encode(NodeId::MASTER, NmtState::Operational), repetitions)
}

/// Heartbeat of another slave that 1016h names.
pub fn peer_heartbeat(repetitions: u32) -> anyhow::Result<()> {
    consume(heartbeat::encode(PEER, NmtState::Operational), repetitions)
}

fn consume(beat: Frame, repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping>::new(FOREIGN)?;
    let before = ignored(&harness);
    (0..repetitions).for_each(|_| harness.receive(beat));
    ensure!(ignored(&harness) == before, "heartbeats were ignored");
    Ok(())
}

/// A frame that is for others.
pub fn irrelevant(repetitions: u32) -> anyhow::Result<()> {
    let mut harness = Harness::<PdoMapping>::new(FOREIGN)?;
    (0..repetitions).for_each(|_| harness.receive(Frame::of(FOREIGN, [1, 2, 3, 4, 5, 6, 7, 8])));
    let expected = repetitions.min(u32::from(u16::MAX)) as u16;
    ensure!(ignored(&harness) == expected, "{} ignored", ignored(&harness));
    Ok(())
}

fn ignored<M: Mapping, const S: bool>(harness: &Harness<M, S>) -> u16 {
    harness.status().counters[Bus::Nominal].ignored
}

/// CRC-CCITT as CiA 301 7.2.4.3.16 has it, bit by bit.
fn crc(data: &[u8]) -> u16 {
    data.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            let shifted = crc << 1;
            if crc & 0x8000 == 0 { shifted } else { shifted ^ 0x1021 }
        })
    })
}

/// The local clock takes the spacecraft time of a SYNC, each second.
pub fn discipline(repetitions: u32) -> anyhow::Result<()> {
    const SECOND: u64 = 256_000_000;
    const LATE: u64 = 512_000;
    let mut clock = LocalClock::default();
    let mut at = 0;
    for n in 0..u64::from(repetitions) {
        at = n * SECOND;
        // 10 ppm, and a quantum of 2^-24 s.
        let scet = (n << 32) + n * 42_950 + (n * 37) % 256;
        let [at, scet, now] = black_box([at, scet, at + LATE]);
        let now = FineInstant::from_units(now);
        clock.discipline(FineInstant::from_units(at), FineScet::from_units(scet), TimeSource::Capture, now);
    }
    let rate = clock.quality(FineInstant::from_units(at)).rate_ppb;
    ensure!(repetitions == 0 || (9_900..10_100).contains(&rate), "rate {rate}");
    ensure!(clock.refused() == 0, "{} pairs refused", clock.refused());
    Ok(())
}
