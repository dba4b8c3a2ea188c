//! The spacecraft time of two master boards.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, MasterEvent, MasterRequest};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, PdoObjects, PdoSet, Tpdo};
use ecss_can::redundancy::Strap;
use ecss_can::time::{LocalUtc, UtcGet};
use ecss_can::types::{NodeId, Scet, Utc, UtcRelation};

use super::{Board, fly_until, heartbeat, powered, standing_by, standing_by_with, taken_over};
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

/// A master whose spacecraft time is in UTC: SCET 0 was day 100, 0:00.
#[derive(Debug, Objects)]
#[objects(device)]
struct Calendar {
    /// Time
    #[objects]
    utc: LocalUtc,
}

impl Device for Calendar {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<2>;
    const PDOS: PdoSet = PdoSet::new(
        &[],
        &[Tpdo::new(1, CobIdOf::fixed(0x181))
            .transmission(1)
            .map(LocalUtc::UTC_GET.field(UtcGet::SUBMILLISECONDS))
            .map(LocalUtc::UTC_GET.field(UtcGet::MS))
            .map(LocalUtc::UTC_GET.field(UtcGet::DAY))],
    );
    const UTC: Option<UtcRelation> =
        Some(UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: Utc::new(100, 0, 0).unwrap() });

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }

    fn consumers(_: NodeId) -> Self::Consumers {
        HeartbeatConsumers { consumer_heartbeat: [2 << 16, 3 << 16] }
    }
}

/// Verifies: ECSS 7.2.2b
#[test]
fn a_standby_follows_a_spacecraft_time_in_utc() {
    let mut board = standing_by_with(Calendar::default());
    board.receive(REDUNDANT, 0x080, &[]);
    // Day 100, 1,000,500 ms at that SYNC.
    board.receive(REDUNDANT, 0x181, &[0, 0, 0x34, 0x44, 0x0F, 0, 100, 0]);
    assert_eq!(board.node.status(board.now).scet, Scet::new(1_000, 0x80_0000).unwrap());
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
