//! Any sequence of frames: never a panic, never a wrong write, never stuck.
//!
//! Verifies: ECSS 6.1a

use async_canopen::sdo::Mode;
use async_canopen::sdo::machine::{Client, Payload};
use async_canopen::types::{Address, Duration, Instant};
use ecss_can_worlds::judge::sdo::{Transfer, checksum, is_written};
use proptest::prelude::*;

use super::fixture::{Bench, DOMAIN, PAUSE, TEXT, TIMEOUT, U8, U32, frame};
use crate::random::cases;

const COMMANDS: [u8; 16] =
    [0x20, 0x21, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x40, 0x60, 0x70, 0x80, 0xA0, 0xA1, 0xA2, 0xA3, 0xA4];
const BLOCK_DOWNLOADS: [u8; 4] = [0xC0, 0xC2, 0xC4, 0xC6];
const ANSWERS: [u8; 9] = [0x41, 0x40, 0x43, 0x60, 0xA4, 0xA0, 0xC4, 0xC6, 0x80];

/// What a client may do.
#[derive(Clone, Debug)]
enum Act {
    /// Any frame.
    Any(Payload),
    /// A frame with this first byte, to an object that there is.
    Known(u8, Address, [u8; 4]),
    /// The next segment of a segmented download.
    Segment {
        unused: u8,
        last: bool,
    },
    /// Segments of a sub-block, from the one that is due on; so many before it are left out.
    SubBlock {
        count: u8,
        skipped: u8,
        last: bool,
    },
    /// The end of a block download, with the right checksum or another.
    End {
        unused: u8,
        wrong: u16,
    },
    /// Time passes.
    Wait(Duration),
    /// Frames leave the bus.
    Left(usize),
    Reset,
}

fn act() -> impl Strategy<Value = Act> {
    let address = prop_oneof![
        Just(DOMAIN),
        Just(TEXT),
        Just(U32),
        Just(U8),
        (0x2000_u16..0x200F, 0..2_u8).prop_map(|(index, sub)| Address::new(index, sub)),
    ];
    let size = prop_oneof![(0..100_u32).prop_map(u32::to_le_bytes), any::<[u8; 4]>()];
    let any_address = address.clone();
    prop_oneof![
        2 => any::<Payload>().prop_map(Act::Any),
        6 => (prop::sample::select(&COMMANDS[..]), any_address, size.clone()).prop_map(|(c, a, s)| Act::Known(c, a, s)),
        6 => (prop::sample::select(&BLOCK_DOWNLOADS[..]), address, size).prop_map(|(c, a, s)| Act::Known(c, a, s)),
        8 => (0..3_u8, prop::bool::weighted(0.3)).prop_map(|(unused, last)| Act::Segment { unused, last }),
        8 => (1..130_u8, prop_oneof![9 => Just(0), 1 => 1..5_u8], any::<bool>())
            .prop_map(|(count, skipped, last)| Act::SubBlock { count, skipped, last }),
        8 => (0..8_u8, prop_oneof![4 => Just(0), 1 => any::<u16>()])
            .prop_map(|(unused, wrong)| Act::End { unused, wrong }),
        1 => prop_oneof![Just(PAUSE), Just(TIMEOUT)].prop_map(Act::Wait),
        1 => (0..9_usize).prop_map(Act::Left),
        1 => Just(Act::Reset),
    ]
}

/// A transfer, or an act alone; something may come in between.
fn acts() -> impl Strategy<Value = Vec<Act>> {
    let address = || prop::sample::select(&[DOMAIN, DOMAIN, TEXT, U32][..]);
    let segment = |unused, last| Act::Segment { unused, last };
    let sub_block = |count, last| Act::SubBlock { count, skipped: 0, last };
    let segments = (address(), 0..12_usize, 0..8_u8).prop_map(move |(at, count, unused)| {
        let mut acts = vec![Act::Known(0x20, at, [0; 4])];
        acts.extend(vec![segment(0, false); count]);
        acts.push(segment(unused, true));
        acts
    });
    let blocks = (address(), any::<bool>(), 0..3_usize, 1..12_u8, 0..8_u8);
    let blocks = blocks.prop_map(move |(at, checked, full, count, unused)| {
        let mut acts = vec![Act::Known(if checked { 0xC4 } else { 0xC0 }, at, [0; 4])];
        acts.extend(vec![sub_block(127, false); if at == DOMAIN { full } else { 0 }]);
        acts.extend([sub_block(count, true), Act::End { unused, wrong: 0 }]);
        acts
    });
    let script = prop_oneof![act().prop_map(|act| vec![act]), segments, blocks];
    (script, any::<prop::sample::Index>(), prop::option::weighted(0.3, act())).prop_map(
        |(mut acts, at, between)| {
            if let Some(between) = between {
                acts.insert(at.index(acts.len()), between);
            }
            acts
        },
    )
}

/// The frames of an act, as they continue a transfer.
fn frames(transfer: &Transfer, act: &Act) -> Vec<Payload> {
    match *act {
        Act::Any(payload) => vec![payload],
        Act::Known(command, at, [four, five, six, seven]) => {
            let [low, high] = at.index.to_le_bytes();
            vec![[command, low, high, at.sub, four, five, six, seven]]
        }
        Act::Segment { unused, last } => {
            vec![[
                transfer.toggle() | unused << 1 | u8::from(last),
                1,
                2,
                3,
                4,
                5,
                6,
                transfer.bytes().len() as u8,
            ]]
        }
        Act::SubBlock { count, skipped, last } => {
            let first = transfer.next() + skipped;
            let seqnos = (first..=127).take(usize::from(count));
            let mut frames: Vec<_> = seqnos.map(|seqno| [seqno, seqno, 2, 3, 4, 5, 6, 7]).collect();
            if let (true, Some(frame)) = (last, frames.last_mut()) {
                frame[0] |= 0x80;
            }
            frames
        }
        Act::End { unused, wrong } => {
            let bytes = transfer.bytes();
            let len = bytes.len().saturating_sub(usize::from(unused));
            let [low, high] = (checksum(&bytes[..len]) ^ wrong).to_le_bytes();
            vec![[0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]]
        }
        Act::Wait(_) | Act::Left(_) | Act::Reset => vec![],
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// An object changes to what was sent completely and rightly, and to nothing else.
    #[test]
    fn a_server_writes_what_was_downloaded_and_nothing_else(acts in prop::collection::vec(acts(), 1..12)) {
        let mut bench = Bench::new();
        let mut transfer = Transfer::default();
        for act in acts.iter().flatten() {
            match act {
                Act::Wait(span) => bench.wait(*span).chunks(1).for_each(|sent| transfer.see_unasked(sent)),
                Act::Left(frames) => transfer.see_unasked(&bench.left(*frames)),
                Act::Reset => {
                    bench.server.reset(&mut bench.objects);
                    transfer = Transfer::default();
                }
                _ => {}
            }
            for request in frames(&transfer, act) {
                let before = bench.objects.changes.len();
                let (used, answers) = bench.request(request);
                prop_assert!(answers.len() <= 10);
                let arrived = transfer.see(&request, used, &answers, &|at| bench.objects.readable(at));
                let change = bench.objects.changes.get(before);
                prop_assert!(is_written(&request, arrived.as_ref(), change), "{:02X?}", request);
                prop_assert_eq!(bench.objects.is_open() && !bench.server.is_busy(), false, "a stream is left");
            }
        }
        // Whatever was, silence frees it, and it serves again.
        bench.wait(PAUSE);
        bench.wait(TIMEOUT);
        bench.wait(PAUSE);
        prop_assert!(!bench.server.is_busy());
        prop_assert!(!bench.objects.is_open());
        bench.objects.set(U32, &[1, 2, 3, 4]);
        prop_assert_eq!(bench.ask(frame("40 00 20 00")), vec![frame("43 00 20 00 01 02 03 04")]);
    }

    /// A client comes to an end whatever it is answered.
    #[test]
    fn a_client_comes_to_an_end(
        up in any::<bool>(), size in 0..2_000_usize,
        mode in prop::sample::select(&[Mode::Auto, Mode::Segmented, Mode::Block][..]),
        answers in prop::collection::vec((answer(), 0..2_000_usize), 0..300)
    ) {
        let mut client = Client::new(TIMEOUT);
        let mut now = Instant::from_micros(1_000_000);
        let at = Address::new(0x2008, 0);
        if up { client.start_upload(at, size, mode) } else { client.start_download(at, size, mode) }
        let (mut pushed, mut pulled, mut outcome) = (0, 0, None);
        for (answer, chunk) in answers {
            let mut sent = 0;
            pushed += client.push(&vec![0; chunk.min(size - pushed)]);
            pulled += client.pull(&mut vec![0; chunk]);
            client.poll(now, &mut |_| sent += 1);
            client.on_response(&answer, now, &mut |_| sent += 1);
            client.on_sent();
            prop_assert!(sent <= 20);
            prop_assert!(pulled <= size);
            now += Duration::from_millis(1);
            outcome = outcome.or(client.outcome());
        }
        for _ in 0..20 {
            pushed += client.push(&vec![0; size - pushed]);
            client.poll(now, &mut |_| {});
            let due = client.deadline();
            prop_assert!(due.is_none_or(|due| due > now), "a busy loop");
            now = due.unwrap_or(now);
        }
        prop_assert_eq!(client.deadline(), None);
        outcome = outcome.or(client.outcome());
        pulled += client.pull(&mut [0; 2_000]);
        match outcome {
            Some(Ok(moved)) => {
                prop_assert_eq!(moved, if up { pulled } else { size });
                prop_assert!(moved <= size);
            }
            Some(Err(_)) => {}
            None => prop_assert!(false, "no outcome"),
        }
    }
}

/// Frames of a server that is not quite right.
fn answer() -> impl Strategy<Value = Payload> {
    prop_oneof![
        1 => any::<Payload>(),
        4 => (prop::sample::select(&ANSWERS[..]), 0..200_u8).prop_map(|(command, four)| {
            [command, 0x08, 0x20, 0, four, 0, 0, 0]
        }),
        4 => (0..0x20_u8).prop_map(|command| [command & 0x11, 1, 2, 3, 4, 5, 6, 7]),
        4 => (0..2_u8).prop_map(|toggle| [0x20 | toggle << 4, 0, 0, 0, 0, 0, 0, 0]),
        8 => (1..9_u8, prop::bool::weighted(0.1)).prop_map(|(seqno, last)| [seqno | u8::from(last) << 7, 1, 2, 3, 4, 5, 6, 7]),
        2 => (0..9_u8, 0..130_u8).prop_map(|(ackseq, size)| [0xA2, ackseq, size, 0, 0, 0, 0, 0]),
        1 => Just([0xA1, 0, 0, 0, 0, 0, 0, 0]),
        2 => (0..8_u8, any::<[u8; 2]>()).prop_map(|(unused, [low, high])| [0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]),
    ]
}
