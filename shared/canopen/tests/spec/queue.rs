//! The transmit queue of a bus.

use async_canopen::link::machine::{Depth, Places};
use async_canopen::link::machine::{Full, Outgoing, TxQueue};
use async_canopen::types::Instant;

use crate::bench::{frame, ms};

fn outgoing(id: u16, tag: u8, expires: Option<u64>) -> Outgoing {
    Outgoing { frame: frame(id, &[tag]), expires: expires.map_or(Instant::NEVER, ms) }
}

fn drain<D: Depth>(queue: &mut TxQueue<D>) -> Vec<(u16, u8)> {
    std::iter::from_fn(|| queue.pop()).map(|out| (out.frame.id().raw(), out.frame.data()[0])).collect()
}

#[test]
fn lowest_cob_id_first_and_in_order_within_one() {
    let mut queue = TxQueue::<Places<8>>::new();
    for (id, tag) in [(0x701, 1), (0x302, 2), (0x701, 3), (0x080, 4), (0x302, 5), (0x302, 6)] {
        queue.push(outgoing(id, tag, None)).unwrap();
    }
    let order = drain(&mut queue);
    assert_eq!(order, [(0x080, 4), (0x302, 2), (0x302, 5), (0x302, 6), (0x701, 1), (0x701, 3)]);
}

#[test]
fn a_full_queue_takes_nothing_ordinary_and_keeps_what_it_has() {
    let mut queue = TxQueue::<Places<2>>::new();
    queue.push(outgoing(0x302, 1, None)).unwrap();
    queue.push(outgoing(0x303, 2, None)).unwrap();
    assert_eq!(queue.push(outgoing(0x182, 3, None)), Err(Full));
    assert_eq!(drain(&mut queue), [(0x302, 1), (0x303, 2)]);
}

#[test]
fn in_full_queue_vital_frame_displaces_what_would_go_last() {
    // NMT, SYNC, Spacecraft Time, heartbeats.
    for vital in [0x000, 0x080, 0x181, 0x701, 0x77F] {
        let mut queue = TxQueue::<Places<4>>::new();
        for (id, tag) in [(0x702, 1), (0x382, 2), (0x382, 3), (0x302, 4)] {
            assert_eq!(queue.push(outgoing(id, tag, None)), Ok(None));
        }
        assert_eq!(queue.push(outgoing(vital, 9, None)), Ok(Some(outgoing(0x382, 3, None))), "{vital:03X}");
        let left = drain(&mut queue);
        assert!(left.contains(&(vital, 9)) && left.contains(&(0x382, 2)), "{left:?}");
    }
}

#[test]
fn a_queue_full_of_what_the_network_lives_on_takes_nothing() {
    let mut queue = TxQueue::<Places<2>>::new();
    queue.push(outgoing(0x701, 1, None)).unwrap();
    queue.push(outgoing(0x080, 2, None)).unwrap();
    assert_eq!(queue.push(outgoing(0x000, 3, None)), Err(Full));
    assert_eq!(drain(&mut queue), [(0x080, 2), (0x701, 1)]);
}

#[test]
fn frames_expire_at_end_of_lifetime_wherever_they_are_queued() {
    let mut queue = TxQueue::<Places<4>>::new();
    queue.push(outgoing(0x080, 1, Some(30))).unwrap();
    queue.push(outgoing(0x302, 2, Some(20))).unwrap();
    queue.push(outgoing(0x303, 3, None)).unwrap();
    assert_eq!(queue.next_expiry(), Some(ms(20)));
    assert_eq!(queue.pop_expired(ms(19)), None);
    assert_eq!(queue.pop_expired(ms(20)).unwrap().frame, frame(0x302, &[2]));
    assert_eq!(queue.pop_expired(ms(20)), None);
    assert_eq!(queue.next_expiry(), Some(ms(30)));
    assert_eq!(drain(&mut queue), [(0x080, 1), (0x303, 3)]);
}
