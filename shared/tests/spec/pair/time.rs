//! The spacecraft time of two master boards.

use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::redundancy::Strap;
use ecss_can::types::Scet;

use super::{Board, fly_until, heartbeat, powered, standing_by, taken_over};
use crate::bench::{NOMINAL, REDUNDANT, frame, ms};

/// Verifies: ECSS 7.2.2b
#[test]
fn a_standby_follows_the_spacecraft_time_and_goes_on_from_there() {
    let mut board = standing_by();
    board.receive(REDUNDANT, 0x080, &[]);
    // 1000.5 s at that SYNC, at 1000 ms.
    board.receive(REDUNDANT, 0x181, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    let scet = Scet::new(1_000, 0x80_0000).unwrap();
    assert_eq!(board.node.status(board.now).scet, scet);
    assert!(board.events.contains(&MasterEvent::Time(scet)), "{:?}", board.events);
    board.clear();
    fly_until(&mut board, 1_400);
    board.transmitted(REDUNDANT, heartbeat());
    fly_until(&mut board, 2_400);
    let time = board.sent.iter().find(|sent| sent.frame.id().raw() == 0x181).unwrap();
    assert_eq!((time.at, &time.frame.data()[3..]), (ms(2_400), &[0xE9, 0x03, 0, 0][..]));
}

/// As [`taken_over`], and SYNCs that go out until 3 s; `by_sync`: the time follows SYNCs, else the clock. When the time was sent.
fn times_after_takeover(by_sync: bool, prepare: impl FnOnce(&mut Board)) -> Vec<u64> {
    let mut board = taken_over();
    if by_sync {
        // The Spacecraft Time PDO goes out after each SYNC (ECSS 7.2.3).
        assert_eq!(board.write((0x1800, 1), &[0x81, 1, 0, 0xC0]), Ok(()));
        assert_eq!(board.write((0x1800, 5), &[0, 0]), Ok(()));
        assert_eq!(board.write((0x1800, 2), &[1]), Ok(()));
        assert_eq!(board.write((0x1800, 1), &[0x81, 1, 0, 0x40]), Ok(()));
    }
    prepare(&mut board);
    board.clear();
    for at in (1_500..=3_000).step_by(100) {
        fly_until(&mut board, at);
        board.transmitted(REDUNDANT, frame(0x080, &[]));
    }
    assert!(board.times(REDUNDANT, 0x080).len() >= 15);
    board.times(REDUNDANT, 0x181)
}

/// Given a standby that heard no spacecraft time, when it has taken over, then it sends none: slaves keep the time that they have,
/// until this one is set by command.
///
/// Verifies: ECSS 7.2.2b
#[test]
fn a_new_master_without_a_time_sends_none_until_it_is_set() {
    for by_sync in [false, true] {
        assert_eq!(times_after_takeover(by_sync, |_| ()), [], "by SYNC: {by_sync}");
        let scet = Scet::new(5_000, 0).unwrap();
        let times = times_after_takeover(by_sync, |board| board.request(MasterRequest::SetTime(scet)));
        assert!(times.len() >= if by_sync { 15 } else { 1 }, "{times:?}");
    }
}

/// Given a board that was active first, when it becomes the standby and active again, then the time is still its own.
#[test]
fn the_board_that_began_the_network_is_its_clock_after_a_pause() {
    let mut board = powered(Strap::Prime);
    board.run_until(ms(700));
    board.transmitted(NOMINAL, heartbeat());
    board.request(MasterRequest::StandBy);
    board.run_until(ms(1_100));
    board.transmitted(NOMINAL, heartbeat());
    board.clear();
    board.run_until(ms(3_000));
    assert!(!board.times(NOMINAL, 0x181).is_empty());
}

#[test]
fn a_time_on_the_bus_that_is_not_active_is_not_taken() {
    let mut board = standing_by();
    board.receive(REDUNDANT, 0x080, &[]);
    board.receive(NOMINAL, 0x181, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    board.receive(REDUNDANT, 0x182, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    assert_eq!(board.node.status(board.now).scet, Scet::new(1, 0).unwrap());
}
