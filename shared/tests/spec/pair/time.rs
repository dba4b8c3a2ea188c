//! The spacecraft time of two master boards.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceTime, Master, MasterEvent, MasterRequest, Node};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::redundancy::Strap;
use ecss_can::time::{LocalUtc, UtcGet};
use ecss_can::types::{Bus, NodeId, Scet, Utc, UtcRelation};

use super::{
    Board, PROFILE, fly_until, heartbeat, powered, stand_by, standing_by, standing_by_with, taken_over,
};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms};
use crate::console::Console;
use crate::device::fixture::Memory;

/// Verifies: ECSS 7.1.2f, 7.2.2b, 7.2.1a
/// Notices: ECSS 7.1.2f: a standby takes the fine time for 32 bits.
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

/// Given a standby with a clock that follows the active master, when that one is set anew, then the standby follows at the third time.
///
/// Verifies: ECSS 7.2.3f, 7.2.1a
/// Notices: ECSS 7.2.3f: a standby takes the first spacecraft time alone.
#[test]
fn a_standby_follows_a_spacecraft_time_that_is_set_anew() {
    let mut board = standing_by();
    // 1000 s at the SYNC at 1000 ms. That at 1100 ms was 2000.125 s, that at 1225 ms 2000.25 s, that at 1350 ms 2000.375 s.
    let times = [(1_000, 0x00, 1_000), (1_100, 0x20, 2_000), (1_225, 0x40, 2_000), (1_350, 0x60, 2_000)];
    for (at, fine, coarse) in times {
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x080, &[]);
        let [low, high] = u16::to_le_bytes(coarse);
        board.receive(REDUNDANT, 0x181, &[0, 0, fine, low, high, 0, 0]);
    }
    assert_eq!(board.node.status(board.now).scet, Scet::new(2_000, 0x60_0000).unwrap());
}

/// A master whose spacecraft time is in UTC: SCET 0 was day 100, 0:00.
#[derive(Debug, Objects)]
#[objects(device, time)]
pub struct Calendar {
    /// Time
    #[objects]
    pub utc: LocalUtc,
}

impl Device for Calendar {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<2>;
    const PDOS: PdoSet = PdoSet::new(
        &[],
        &[Pdo::<()>::new(CobIdOf::fixed(0x181))
            .map(LocalUtc::UTC_GET.field(UtcGet::SUBMILLISECONDS))
            .map(LocalUtc::UTC_GET.field(UtcGet::MS))
            .map(LocalUtc::UTC_GET.field(UtcGet::DAY))
            .transmit(1)
            .transmission(1)],
    );

    fn consumers(_: NodeId) -> Self::Consumers {
        HeartbeatConsumers { consumer_heartbeat: [2 << 16, 3 << 16] }
    }
}

impl DeviceTime for Calendar {
    const UTC: Option<UtcRelation> =
        Some(UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: Utc::new(100, 0, 0).unwrap() });

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }
}

/// Verifies: ECSS 7.1.1b, 7.1.1d, 7.1.3a, 7.1.3e, 7.2.1a
/// Notices: ECSS 7.1.3a: a master has no UTC objects.
/// Notices: ECSS 7.1.1b: UTC is for slaves alone.
/// Notices: ECSS 7.1.1d: a standby follows SCET alone.
/// Notices: ECSS 7.2.1a: a standby does not follow UTC of the active master.
/// Notices: ECSS 7.1.3e: a standby takes day, milliseconds and submilliseconds in this order.
#[test]
fn a_standby_follows_a_spacecraft_time_in_utc() {
    let mut board = standing_by_with(Calendar::default());
    board.receive(REDUNDANT, 0x080, &[]);
    // Day 100, 1,000,500 ms at that SYNC.
    board.receive(REDUNDANT, 0x181, &[0, 0, 0x34, 0x44, 0x0F, 0, 100, 0]);
    assert_eq!(board.node.status(board.now).scet, Scet::new(1_000, 0x80_0000).unwrap());
}

/// Given a standby with a clock that follows the UTC of the active master, when that is set ten days ahead, then the standby follows at the
/// third time.
///
/// Verifies: ECSS 7.1.3b, 7.2.3f
/// Notices: ECSS 7.1.3b: the UTC of the active master sets no clock of a standby.
/// Notices: ECSS 7.2.3f: a standby takes the first UTC alone.
#[test]
fn a_standby_follows_utc_that_is_set_anew() {
    let mut board = standing_by_with(Calendar::default());
    for (at, day) in [(1_000, 100), (1_100, 110), (1_200, 110), (1_300, 110)] {
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x080, &[]);
        board.receive(REDUNDANT, 0x181, &Utc::new(day, at as u32, 0).unwrap().encode());
    }
    // Ten days and 1.3 s: 0.3 x 2^24 = 5,033,164.8.
    assert_eq!(board.node.status(board.now).scet, Scet::new(864_001, 5_033_165).unwrap());
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
/// Verifies: ECSS 7.2.2b, 7.2.3b, 7.2.3d, 7.2.3f, 6.9d
/// Notices: ECSS 7.2.3d: a master sends no SYNC while it withholds the time.
/// Notices: ECSS 7.2.3b: the time stays withheld after it was set.
/// Notices: ECSS 7.2.3b: synchronous PDOs of a master go out on the nominal bus alone.
/// Notices: ECSS 7.2.3f: a master that took over sends no time of a clock that a command has set.
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
///
/// Verifies: ECSS 7.2.3b, 7.2.2b
/// Notices: ECSS 7.2.3b: the first one of two boards withholds its time until it is set.
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

/// Verifies: ECSS 7.2.3f
/// Notices: ECSS 7.2.3f: a standby takes the local time of a slave for the spacecraft time.
#[test]
fn a_time_on_the_bus_that_is_not_active_is_not_taken() {
    let mut board = standing_by();
    board.receive(REDUNDANT, 0x080, &[]);
    board.receive(NOMINAL, 0x181, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    board.receive(REDUNDANT, 0x182, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    assert_eq!(board.node.status(board.now).scet, Scet::new(1, 0).unwrap());
}

/// A COB-ID whose function code no filter of the board admits by default.
const MOVED: u16 = 0x2C5;

/// The client, or the application, moves SYNC to [`MOVED`]: the COB-ID changes while the board does not produce SYNC.
fn move_sync(board: &mut Board) {
    let [low, high] = MOVED.to_le_bytes();
    assert_eq!(board.write((0x1005, 0), &[0x80, 0, 0, 0]), Ok(()));
    assert_eq!(board.write((0x1005, 0), &[low, high, 0, 0x40]), Ok(()));
}

/// Asserts that a standby takes SYNC by [`MOVED`] and no longer by 080h.
fn assert_follows_moved_sync(board: &mut Board) {
    for bus in Bus::ALL {
        assert!(board.admits(bus, MOVED));
        assert!(board.admits(bus, 0x082), "emergencies of slave 2");
    }
    let stamped = [(MOVED, &[][..]), (MOVED, &[1]), (MOVED, &[1, 2]), (0x080, &[]), (0x181, &[0; 7])];
    let is_stamped = |bus| stamped.map(|(id, data)| board.node.is_stamped(bus, &frame(id, data)));
    assert_eq!(is_stamped(REDUNDANT), [true, true, false, false, false]);
    assert_eq!(is_stamped(NOMINAL), [false; 5]);
    // 1000.5 s at that SYNC, and no time at 080h.
    board.receive(REDUNDANT, 0x080, &[]);
    assert_eq!(board.node.scet_at_sync(), None);
    board.receive(REDUNDANT, MOVED, &[]);
    board.receive(REDUNDANT, 0x181, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]);
    assert_eq!(board.node.status(board.now).scet, Scet::new(1_000, 0x80_0000).unwrap());
    // It is a sign of life in place of the heartbeat, which would be missed at 1400 ms.
    board.run_until(ms(1_300));
    board.receive(REDUNDANT, MOVED, &[]);
    board.run_until(ms(1_500));
    assert_eq!(board.frames(), []);
}

/// Given a standby, when 1005h is written, then its filters, stamps and clock follow SYNC to the new COB-ID.
///
/// Verifies: ECSS 6.3b, 7.2.3c, 6.10a, 6.10c, 8.1a
/// Notices: ECSS 6.10c: a standby takes SYNC by 080h after another COB-ID was written.
#[test]
fn standby_follows_sync_to_a_written_cob_id() {
    let mut board = standing_by();
    assert!(!board.admits(REDUNDANT, MOVED));
    move_sync(&mut board);
    board.settle();
    assert_follows_moved_sync(&mut board);
}

/// Given a board with another COB-ID of SYNC in its store, when it becomes the standby, then it takes SYNC by that one.
///
/// Verifies: ECSS 6.3b, 7.2.3c, 6.10a, 6.10c, 8.1a
/// Notices: ECSS 6.10c: a standby does not take the stored COB-ID of SYNC.
#[test]
fn standby_follows_sync_by_its_stored_cob_id() {
    let memory = Memory::default();
    let board = || {
        let store: &'static mut Memory = Box::leak(Box::new(memory.clone()));
        let master = Master::builder(&PROFILE, Console::default()).one_of_two(Strap::Prime);
        Bench::new(master.store(store).build())
    };
    let mut writer = board();
    move_sync(&mut writer);
    assert_eq!(writer.write((0x1010, 2), b"save"), Ok(()));
    writer.finish_save();
    let mut board = board();
    stand_by(&mut board);
    assert_follows_moved_sync(&mut board);
}

/// Given a standby, when the TPDO of the spacecraft time gets another COB-ID, then its filters admit that one.
///
/// Verifies: ECSS 6.10a, 6.10c, 7.2.2c
/// Notices: ECSS 6.10c: the filters of a standby stay when the Spacecraft Time PDO gets another COB-ID.
#[test]
fn standby_admits_the_time_by_another_cob_id() {
    let mut board = standing_by();
    for value in [0xC000_0181_u32, 0x4000_0000 | u32::from(MOVED)] {
        assert_eq!(board.write((0x1800, 1), &value.to_le_bytes()), Ok(()));
    }
    board.settle();
    assert!(Bus::ALL.into_iter().all(|bus| board.admits(bus, MOVED)));
}

/// Given a standby, when two nodes send the spacecraft time after each SYNC, then it stays silent, and reports the collision when it has
/// taken over.
///
/// Verifies: ECSS 7.2.2d, 6.4a.2
/// Notices: ECSS 7.2.2d: a standby takes two spacecraft times after each SYNC as they come.
#[test]
fn standby_reports_two_producers_of_the_time_after_takeover() {
    let mut board = standing_by();
    board.clear();
    for nth in 10..=14 {
        board.run_until(ms(100 * nth));
        board.receive(REDUNDANT, 0x701, &[0x05]);
        board.receive(REDUNDANT, 0x080, &[]);
        // 1000 s and 1000.5 s.
        for half in [0x00, 0x80] {
            board.receive(REDUNDANT, 0x181, &[0, 0, half, 0xE8, 3, 0, 0]);
        }
    }
    assert_eq!(board.frames(), []);
    fly_until(&mut board, 1_800);
    board.transmitted(REDUNDANT, heartbeat());
    board.run_until(ms(1_900));
    let mut emergencies = board.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x081);
    assert_eq!(emergencies.next(), Some((REDUNDANT, frame(0x081, &[0x50, 0x81, 0x11, 0x81, 0, 0, 0, 0]))));
}
