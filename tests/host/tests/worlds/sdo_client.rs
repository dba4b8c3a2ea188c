//! The SDO client of the master's application, with real slaves.
//!
//! Verifies: ECSS 6.1a

use std::cell::RefCell;
use std::pin::pin;
use std::rc::Rc;

use can_twin::wire::time::Time;
use ecss_can::node::{Communication, Identity, MasterRequest};
use ecss_can::od::{Field, NotWritable, Readable};
use ecss_can::runner::extend::WholeNode;
use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::types::{AbortCode, Address, Bus, Duration};
use futures_util::future::select;
use mission::{LIBRECUBE, MissionObjects, STANDARD};

use crate::support::*;

const PRODUCT: Field<u32, Readable, NotWritable> = Communication::IDENTITY.field(Identity::PRODUCT);
const VALUE: Field<u32> = MissionObjects::VALUE;
const NAME: Field = Field::raw(Address::new(0x1008, 0));

fn raw(index: u16, sub: u8) -> Field {
    Field::raw(Address::new(index, sub))
}

/// Returns random contents for the domain of a slave.
fn seeded(seed: u64) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(seed);
    (0..20_000).map(|_| random.u8(..)).collect()
}

fn stored(world: &MissionWorld) -> Vec<u8> {
    world.slave(TWO, |slave| slave.objects().application.store.as_bytes().to_vec())
}

#[test]
fn values_are_read_and_written() {
    let mut world = running(STANDARD, 2);
    let task = world.on_master(|master| async move {
        let client = master.sdo(TWO);
        client.write(VALUE, 0xDEAD_BEEF).await?;
        let product = master.sdo(THREE).read(PRODUCT).await?;
        let mut name = [0; 64];
        let name_len = client.read_bytes(NAME, &mut name).await?;
        Ok::<_, Error>((product, name[..name_len].to_vec()))
    });
    world.run_for(ms(50));
    let (_, read) = task.take().expect("it ended");
    assert_eq!(read, Ok((0x5015, b"ECSS-E-ST-50-15C slave".to_vec())));
    assert_eq!(world.slave(TWO, |slave| slave.objects().application.value), 0xDEAD_BEEF);
}

#[test]
fn abort_absent_node_and_too_small_buffer_are_typed_errors() {
    let mut world = running(STANDARD, 2);
    let from = world.now();
    let task = world.on_master(|master| async move {
        let client = master.sdo(TWO);
        let (mut four, mut eight) = ([0; 4], [0; 8]);
        [
            client.read_bytes(raw(0x5FFF, 0), &mut four).await.map(drop),
            client.write_bytes(raw(0x1018, 1), &[0; 4]).await,
            client.write_bytes(VALUE, &[0; 5]).await,
            client.read_bytes(NAME, &mut eight).await.map(drop),
            master.sdo(FOUR).read(PRODUCT).await.map(drop),
        ]
    });
    world.run_for(ms(700));
    let (at, outcome) = task.take().expect("it ended");
    let abort = |code| Err(Error::Abort(code));
    assert_eq!(
        outcome,
        [
            abort(AbortCode::NoObject),
            abort(AbortCode::ReadOnly),
            abort(AbortCode::TooLong),
            Err(Error::TooLarge),
            Err(Error::Timeout)
        ]
    );
    let waited = at.since(from);
    assert!(waited >= ms(500) && waited < ms(520), "{} us", waited.as_us());
    // The abort was sent to the absent slave.
    let last = since(&world, Bus::Nominal, 0x604, from).pop().expect("requests");
    assert_eq!(last.frame.payload(), [0x80, 0x18, 0x10, 2, 0, 0, 0x04, 0x05]);
}

#[test]
fn a_domain_goes_both_ways_in_every_mode() {
    // Nodes of these worlds answer without delay, so segments leave no gap for heartbeats.
    for (seed, mode, len) in [(1, Mode::Auto, 20_000), (2, Mode::Block, 20_000), (3, Mode::Segmented, 2_000)]
    {
        let mut world = running(STANDARD, 2);
        let data = seeded(seed)[..len].to_vec();
        let given = data.clone();
        let task = world.on_master(move |master| async move {
            let client = master.sdo(TWO).with_mode(mode);
            client.write_bytes(MissionObjects::STORE, &given).await?;
            let mut back = vec![0; 24 * 1024];
            let len = client.read_bytes(MissionObjects::STORE, &mut back).await?;
            back.truncate(len);
            Ok::<_, Error>(back)
        });
        world.run_for(ms(1_500));
        let (_, back) = task.take().expect("it ended");
        assert!(stored(&world) == data, "{mode:?}");
        assert!(back.as_ref() == Ok(&data), "{mode:?}: {:?}", back.map(|back| back.len()));
    }
}

#[test]
fn a_domain_streams_in_parts() {
    let mut world = running(STANDARD, 2);
    let data = seeded(7);
    let source = data.clone();
    let task = world.on_master(move |master| async move {
        let client = master.sdo(TWO);
        let mut at = 0;
        let fill = |part: &mut [u8]| {
            part.copy_from_slice(&source[at..at + part.len()]);
            at += part.len();
        };
        client.download_from(MissionObjects::STORE, source.len(), fill).await?;
        let mut back = vec![];
        let sink = |part: &[u8]| back.extend_from_slice(part);
        let len = client.upload_to(MissionObjects::STORE, 24 * 1024, sink).await?;
        Ok::<_, Error>((len, back))
    });
    world.run_for(ms(1_500));
    let (_, back) = task.take().expect("it ended");
    assert!(stored(&world) == data);
    assert!(back == Ok((20_000, data)));
}

/// Given a block transfer, then its frames fill the bus except for a gap between sub-blocks of 127 segments.
///
/// Verifies: ECSS 8.3.3a, 8.3.3d
#[test]
fn a_block_transfer_keeps_the_bus_busy_and_heartbeats_in_time() {
    let mut world = running(STANDARD, 2);
    let data = seeded(9);
    let from = world.now();
    let task = world.on_master(move |master| async move {
        let client = master.sdo(TWO);
        client.write_bytes(MissionObjects::STORE, &data).await?;
        let mut back = vec![0; 24 * 1024];
        client.read_bytes(MissionObjects::STORE, &mut back).await
    });
    world.run_for(ms(1_500));
    let (end, outcome) = task.take().expect("it ended");
    assert_eq!((outcome, switches(&world, from)), (Ok(20_000), 0));
    let frames = world.frames(Bus::Nominal).iter().filter(|sent| sent.end > from && sent.end <= end);
    let busy: u64 = frames.map(|sent| sent.end.since(sent.start).as_us() + 3).sum();
    let share = busy as f64 / end.since(from).as_us() as f64;
    assert!(share > 0.95, "{share}");
    for id in 0x701..=0x703 {
        let late = periods_us(&since(&world, Bus::Nominal, id, from))
            .into_iter()
            .find(|us| us.abs_diff(100_000) > 20_000);
        assert_eq!(late, None, "{id:03X}");
    }
}

#[test]
fn a_dropped_future_aborts_its_transfer_and_frees_the_client() {
    let mut world = running(STANDARD, 2);
    let data = seeded(3);
    let task = world.on_master(move |master| async move {
        let _ = master.sdo(TWO).write_bytes(MissionObjects::STORE, &data).await;
    });
    world.run_for(ms(50));
    let from = world.now();
    task.cancel();
    let read = world.on_master(|master| async move { master.sdo(TWO).read(PRODUCT).await });
    world.run_for(ms(50));
    assert!(task.take().is_none());
    assert_eq!(read.take().map(|(_, product)| product), Some(Ok(0x5015)));
    let aborts: Vec<Vec<u8>> = since(&world, Bus::Nominal, 0x602, from)
        .iter()
        .map(|sent| sent.frame.payload().to_vec())
        .filter(|payload| payload[..4] == [0x80, 0x00, 0x63, 0x00])
        .collect();
    assert_eq!(aborts, [[0x80, 0, 0x63, 0, 0x21, 0, 0, 8]]);
}

/// Given a transfer, when its future is dropped within a call that holds the node, then it is aborted as otherwise.
#[test]
fn a_future_dropped_within_a_step_aborts_its_transfer() {
    let mut world = running(STANDARD, 2);
    let data = seeded(3);
    let from = world.now();
    let task = world.on_master(|master| async move {
        let mut transfer = Box::pin(async move {
            let _ = master.sdo(TWO).write_bytes(MissionObjects::STORE, &data).await;
        });
        let end = pin!(master.wait_until(master.now() + Duration::from_millis(50)));
        select(transfer.as_mut(), end).await;
        master.with(move |_, _| drop(transfer));
        master.sdo(TWO).read(PRODUCT).await
    });
    world.run_for(ms(100));
    assert_eq!(task.take().map(|(_, product)| product), Some(Ok(0x5015)));
    let requests = since(&world, Bus::Nominal, 0x602, from);
    let aborts = requests.iter().filter(|sent| sent.frame.payload()[..4] == [0x80, 0x00, 0x63, 0x00]);
    assert_eq!(aborts.count(), 1);
}

/// Verifies: ECSS 8.3.3b.2
#[test]
fn bus_switch_ends_a_transfer_and_the_next_one_works_there() {
    let mut world = running(STANDARD, 2);
    let data = seeded(4);
    let task = world.on_master(move |master| async move {
        let client = master.sdo(TWO);
        let first = client.write_bytes(MissionObjects::STORE, &data).await;
        (first, client.write_bytes(MissionObjects::STORE, &data).await)
    });
    world.run_for(ms(50));
    let from = world.now();
    world.request(MasterRequest::SwitchBus(Bus::Redundant));
    world.run_for(ms(1_000));
    let (_, outcome) = task.take().expect("it ended");
    assert_eq!(outcome, (Err(Error::BusChanged), Ok(())));
    // The abort is sent to the server on the new bus, after that bus was announced.
    let first: Vec<Option<u16>> = world.frames(Bus::Redundant)[..3].iter().map(|sent| sent.id()).collect();
    assert_eq!(first[0], Some(0x701));
    let abort = since(&world, Bus::Redundant, 0x602, from).remove(0);
    assert_eq!(abort.frame.payload(), [0x80, 0, 0x63, 0, 0x22, 0, 0, 8]);
    assert!(stored(&world) == seeded(4));
}

#[test]
fn two_tasks_take_turns() {
    let mut world = running(STANDARD, 2);
    let done = Rc::new(RefCell::new(vec![]));
    let tasks = [(TWO, 5), (THREE, 6)].map(|(node, seed)| {
        let done = done.clone();
        world.on_master(move |master| async move {
            let outcome = master.sdo(node).write_bytes(MissionObjects::STORE, &seeded(seed)).await;
            done.borrow_mut().push(node);
            outcome
        })
    });
    world.run_for(ms(1_500));
    assert!(tasks.iter().all(|task| task.take().is_some_and(|(_, outcome)| outcome == Ok(()))));
    assert_eq!(*done.borrow(), [TWO, THREE]);
    assert!(stored(&world) == seeded(5));
}

#[test]
fn the_boot_up_process_goes_before_the_application() {
    let mut world = MissionWorld::new(LIBRECUBE, 3);
    world.run_until(Time::from_us(300));
    let task = world.on_master(|master| async move {
        let mut stamp = [0; 4];
        master.sdo(TWO).read_bytes(raw(0x1020, 2), &mut stamp).await.map(|_| stamp)
    });
    world.run_for(ms(100));
    // Read after the configuration was written.
    assert_eq!(task.take().map(|(_, stamp)| stamp), Some(Ok(43_200_000_u32.to_le_bytes())));
}
