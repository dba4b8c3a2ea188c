//! SDO block transfers with a slave, compared with the capacity of the bus.
//!
//! 20 kB of seeded random data go to a slave with its image on the twin and come back from it. A guest on the nominal
//! bus is the client: it answers at once and always has the next segments ready, so that all time in addition to the
//! frames is caused by the slave. Another guest is the master, with heartbeat and SYNC. The slave sends its heartbeat
//! and its PDOs.
//!
//! The limit is the time of the frames of a faultless transfer of the same payload, back to back: initiation,
//! sub-blocks of 127 segments with an acknowledgement each, and end, every stuff bit and every intermission included.

use anyhow::{Context as _, bail, ensure};
use can_twin::guest::GuestEvent;
use can_twin::spacecraft::Bus;
use can_twin::wire::encode::encode;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::{Client, Payload};
use ecss_can::types::{Address, Duration, Instant};
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::{MASTER_BEATS, Rig};
use crate::bench::row::Row;

/// Node-ID of the slave.
const SLAVE: u8 = 2;
const REQUESTS: u16 = 0x600 + SLAVE as u16;
const RESPONSES: u16 = 0x580 + SLAVE as u16;

/// The slave's data store, a DOMAIN.
const STORE: Address = Address::new(0x6300, 0);
const BYTES: usize = 20_000;

/// Timeout of the client.
const TIMEOUT: Duration = Duration::from_millis(500);
/// Time limit of a transfer.
const PATIENCE: Time = Time::from_ms(2_000);
/// Longest delay until the client handles a frame, shorter than the intermission.
const STEP: Time = Time::from_us(1);

/// Period of the master's heartbeat and SYNC, profile `standard`.
const PERIOD: Time = Time::from_ms(100);
const SYNC: (u16, &[u8]) = (0x080, &[]);

/// Smallest share of the limit that each transfer must reach, percent.
const TARGET: f64 = 95.0;

/// Bytes of a segment, segments of a sub-block.
const SEGMENT: usize = 7;
const SUB_BLOCK: usize = 127;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut random = fastrand::Rng::with_seed(1);
    let data: Vec<u8> = std::iter::repeat_with(|| random.u8(..)).take(BYTES).collect();
    let mut rig = Rig::new(context, Profile::Standard, SLAVE)?;

    let mut client = Client::new(TIMEOUT);
    client.start_download(STORE, BYTES, Mode::Block);
    let download = transfer(&mut rig, &mut client, &data, &mut Vec::new())?;

    let (mut client, mut read) = (Client::new(TIMEOUT), Vec::new());
    client.start_upload(STORE, BYTES, Mode::Block);
    let upload = transfer(&mut rig, &mut client, &[], &mut read)?;
    ensure!(read == data, "other data came back than were sent");

    let share = |frames: &[WireFrame], took: Time| 100.0 * limit(frames).as_secs_f64() / took.as_secs_f64();
    Ok(vec![
        Row::higher("block_download", share(&download_frames(&data), download), "percent").within(TARGET),
        Row::higher("block_upload", share(&upload_frames(&data), upload), "percent").within(TARGET),
        Row::lower("block_download_time", download.as_secs_f64() * 1e3, "ms"),
        Row::lower("block_upload_time", upload.as_secs_f64() * 1e3, "ms"),
    ])
}

/// Runs a transfer to its end, and returns the time from the start of its first frame to the end of its last one.
fn transfer(rig: &mut Rig, client: &mut Client, mut data: &[u8], read: &mut Vec<u8>) -> anyhow::Result<Time> {
    let start = rig.spacecraft.now();
    let mut beat = start;
    rig.spacecraft.take_frames();
    loop {
        let now = rig.spacecraft.now();
        ensure!(now.since(start) < PATIENCE, "a transfer does not end");
        if beat <= now {
            rig.send(Bus::Nominal, now, MASTER_BEATS);
            rig.send(Bus::Nominal, now, SYNC);
            beat += PERIOD;
        }
        data = &data[client.push(data)..];
        client.poll(instant(now), &mut |payload| send(rig, &payload));
        if let Some(outcome) = client.outcome() {
            let bytes = outcome.map_err(|error| anyhow::anyhow!("the transfer failed: {error:?}"))?;
            pull(client, read);
            ensure!(bytes == BYTES, "{bytes} bytes were moved");
            break;
        }
        run(rig, STEP)?;
        for (at, heard) in rig.spacecraft.take_heard(rig.client) {
            match heard {
                GuestEvent::Sent(_) => client.on_sent(),
                GuestEvent::Received(frame) if frame.id == WireId::Standard(RESPONSES) => {
                    client.on_response(&frame.data, instant(at), &mut |payload| send(rig, &payload));
                    pull(client, read);
                }
                GuestEvent::Received(_) => {}
            }
        }
    }
    // Pending frames are sent.
    run(rig, Time::from_ms(1))?;
    let traces = rig.spacecraft.take_frames().into_iter().filter_map(|record| match record.record {
        Observation::Completed { trace, .. } if record.bus == Bus::Nominal => Some(trace),
        _ => None,
    });
    let of_transfer = [REQUESTS, RESPONSES].map(WireId::Standard);
    let traces: Vec<_> = traces.filter(|trace| of_transfer.contains(&trace.frame.id)).collect();
    let ([first, ..], [.., last]) = (traces.as_slice(), traces.as_slice()) else { bail!("no transfer") };
    Ok(last.end.since(first.start))
}

fn send(rig: &mut Rig, payload: &Payload) {
    let now = rig.spacecraft.now();
    rig.spacecraft.inject(rig.client, now, WireFrame::standard(REQUESTS, payload));
}

/// Lets time pass, and keeps the frames.
fn run(rig: &mut Rig, span: Time) -> anyhow::Result<()> {
    let until = rig.spacecraft.now() + span;
    rig.spacecraft.run_until(until).context("the twin stopped the board")
}

fn pull(client: &mut Client, into: &mut Vec<u8>) {
    let mut bytes = [0; SEGMENT * SUB_BLOCK];
    let count = client.pull(&mut bytes);
    into.extend(&bytes[..count]);
}

fn instant(time: Time) -> Instant {
    Instant::from_micros(time.as_us())
}

/// Returns the time of frames back to back at 1 Mbit/s, with the intermissions between them.
fn limit(frames: &[WireFrame]) -> Time {
    const INTERMISSION: usize = 3;
    let bits: usize = frames.iter().map(|frame| encode(frame).bits().len() + INTERMISSION).sum();
    Time::from_us((bits - INTERMISSION) as u64)
}

/// Returns the frames of a faultless download (CiA 301 7.2.4.3.9 to 7.2.4.3.11).
fn download_frames(data: &[u8]) -> Vec<WireFrame> {
    let (request, response) = (frame(REQUESTS), frame(RESPONSES));
    let mut frames =
        vec![request(initiate(0xC6, data.len() as u32)), response(initiate(0xA4, SUB_BLOCK as u32))];
    frames.extend(sub_blocks(data, &request, &response));
    frames.extend([request(end(data)), response([0xA1, 0, 0, 0, 0, 0, 0, 0])]);
    frames
}

/// Returns the frames of a faultless upload (CiA 301 7.2.4.3.12 to 7.2.4.3.14).
fn upload_frames(data: &[u8]) -> Vec<WireFrame> {
    let (request, response) = (frame(REQUESTS), frame(RESPONSES));
    let mut frames = vec![
        request(initiate(0xA4, SUB_BLOCK as u32)),
        response(initiate(0xC6, data.len() as u32)),
        request([0xA3, 0, 0, 0, 0, 0, 0, 0]),
    ];
    frames.extend(sub_blocks(data, &response, &request));
    frames.extend([response(end(data)), request([0xA1, 0, 0, 0, 0, 0, 0, 0])]);
    frames
}

fn frame(id: u16) -> impl Fn(Payload) -> WireFrame {
    move |payload| WireFrame::standard(id, &payload)
}

fn initiate(command: u8, value: u32) -> Payload {
    let ([low, high], [a, b, c, d]) = (STORE.index.to_le_bytes(), value.to_le_bytes());
    [command, low, high, STORE.sub, a, b, c, d]
}

/// Adds segments and acknowledgements.
fn sub_blocks(
    data: &[u8],
    segment: &impl Fn(Payload) -> WireFrame,
    acknowledge: &impl Fn(Payload) -> WireFrame,
) -> Vec<WireFrame> {
    let segments = data.len().div_ceil(SEGMENT);
    let mut frames = Vec::new();
    for (number, bytes) in (1..).zip(data.chunks(SEGMENT)) {
        let seqno = (number - 1) % SUB_BLOCK + 1;
        let last = number == segments;
        let mut payload = [0; 8];
        payload[0] = seqno as u8 | if last { 0x80 } else { 0 };
        payload[1..=bytes.len()].copy_from_slice(bytes);
        frames.push(segment(payload));
        if last || seqno == SUB_BLOCK {
            frames.push(acknowledge([0xA2, seqno as u8, SUB_BLOCK as u8, 0, 0, 0, 0, 0]));
        }
    }
    frames
}

fn end(data: &[u8]) -> Payload {
    let unused = (SEGMENT - data.len() % SEGMENT) % SEGMENT;
    let [low, high] = crc(data).to_le_bytes();
    [0xC1 | (unused as u8) << 2, low, high, 0, 0, 0, 0, 0]
}

/// Computes the CRC-CCITT bit by bit (CiA 301 7.2.4.3.16).
fn crc(data: &[u8]) -> u16 {
    data.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            let shifted = crc << 1;
            if crc & 0x8000 == 0 { shifted } else { shifted ^ 0x1021 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_counts_every_bit_of_a_faultless_transfer() {
        // 08 bytes: two segments in one sub-block.
        let frames = download_frames(&[0x55; 8]);
        assert_eq!(frames.len(), 7);
        // Frames of 8 bytes without stuff bits have 108 bits and 3 of intermission.
        let stuffed: usize = frames.iter().map(|frame| encode(frame).bits().len() - 108).sum();
        assert_eq!(limit(&frames), Time::from_us((7 * 111 - 3 + stuffed) as u64));
        assert_eq!(upload_frames(&[0x55; 8]).len(), 8);
    }

    #[test]
    fn the_checksum_is_that_of_cia_301() {
        assert_eq!(crc(b"123456789"), 0x31C3);
    }
}
