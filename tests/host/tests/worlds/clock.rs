//! Waits for spacecraft times while the time is set, cut off and reset.

use ecss_can::node::MasterRequest;
use ecss_can::prelude::*;
use ecss_can_worlds::task::Task;
use ecss_can_worlds::{NEXT_TO_MASTER_M, Time, World, idle};
use mission::{MissionObjects, STANDARD};
use proptest::prelude::*;

const TWO: NodeId = NodeId::of::<2>();

/// SYNC and spacecraft time every 20 ms.
const PROFILE: Profile =
    Profile { sync: Duration::from_millis(20), time: Duration::from_millis(20), autostart: true, ..STANDARD };

/// Period of the test's checks.
const LOOK: Time = Time::from_ms(5);
/// Number of waiters that a step of the clock wakes at once.
const AT_ONCE: usize = 4;
const END: Time = Time::from_ms(2_500);

/// An event of the spacecraft.
#[derive(Clone, Copy, Debug)]
enum NodeEvent {
    /// The master's time is changed by this many milliseconds.
    MasterSet(i64),
    /// The slave's time is set by its own application.
    SlaveSet(i64),
    /// The active bus is cut.
    Cut,
    /// The slave is reset.
    Reset,
    /// A waiter waits for a time this many milliseconds from now.
    Wait(i64),
}

fn node_event() -> impl Strategy<Value = NodeEvent> {
    prop_oneof![
        2 => (-3_000..3_000_i64).prop_map(NodeEvent::MasterSet),
        2 => (-3_000..3_000_i64).prop_map(NodeEvent::SlaveSet),
        1 => Just(NodeEvent::Cut),
        1 => Just(NodeEvent::Reset),
        6 => (-500..3_000_i64).prop_map(NodeEvent::Wait),
    ]
}

fn moved(scet: Scet, ms: i64) -> Scet {
    let span = Duration::from_millis(ms.unsigned_abs());
    if ms < 0 { scet.minus(span) } else { scet.plus(span) }
}

fn world() -> World {
    let mut world = World::builder()
        .master(|board| mission::master(&PROFILE).hardware(board.hardware).build(), idle)
        .slave(TWO, |board| mission::slave(board.node_id, &PROFILE, vec![]).build(), idle)
        .drift(TWO, 60)
        .build();
    world.run_until(Time::from_ms(200));
    world
}

/// A waiter on the slave.
struct Waiter {
    target: Scet,
    task: Task<Scet>,
    /// Whether the test has found that its time is reached.
    is_due: bool,
    /// Instant and spacecraft time of its wake-up.
    fired: Option<(Time, Scet)>,
}

struct Trial {
    world: World,
    waiters: Vec<Waiter>,
}

impl Trial {
    fn scet(&self) -> Option<Scet> {
        self.world.is_powered(TWO).then(|| self.world.slave::<MissionObjects<Vec<u8>>>(TWO).clock().now())
    }

    fn happens(&mut self, node_event: NodeEvent) {
        match node_event {
            NodeEvent::MasterSet(ms) => {
                let scet = moved(self.world.status(NodeId::MASTER).scet, ms);
                self.world.request(MasterRequest::SetTime(scet));
            }
            NodeEvent::SlaveSet(ms) => {
                let Some(now) = self.scet() else { return };
                let [f0, f1, f2, coarse @ ..] = moved(now, ms).encode();
                self.world.write(TWO, Address::new(0x2010, 1), &coarse);
                self.world.write(TWO, Address::new(0x2010, 2), &[f0, f1, f2]);
            }
            NodeEvent::Cut => {
                let bus = self.world.master_bus();
                self.world.heal(bus.other());
                self.world.cut(bus, NEXT_TO_MASTER_M);
            }
            NodeEvent::Reset => {
                self.world.reset(TWO);
                // The waiters on the slave are gone.
                self.waiters.clear();
            }
            NodeEvent::Wait(ms) => {
                let waiting = self.waiters.iter().filter(|waiter| waiter.fired.is_none()).count();
                let Some(now) = self.scet().filter(|_| waiting < AT_ONCE) else { return };
                let target = moved(now, ms);
                let clock = self.world.slave::<MissionObjects<Vec<u8>>>(TWO).clock();
                let task = self.world.spawn(TWO, async move {
                    clock.at(target).await;
                    clock.now()
                });
                self.waiters.push(Waiter { target, task, is_due: false, fired: None });
            }
        }
    }

    /// Lets time pass, and checks all waiters.
    fn run_until(&mut self, until: Time) {
        while self.world.now() < until {
            self.world.run_for(LOOK);
            let scet = self.scet();
            for waiter in &mut self.waiters {
                if let Some((at, scet)) = waiter.task.take() {
                    assert_eq!(waiter.fired, None, "once for each call");
                    assert!(!scet.is_before(waiter.target), "at {scet:?}, before {:?}", waiter.target);
                    waiter.fired = Some((at, scet));
                }
                // Timers count whole microseconds on a separate clock.
                let target = waiter.target.plus(Duration::from_micros(2));
                waiter.is_due |= scet.is_some_and(|scet| !scet.is_before(target));
                assert!(!waiter.is_due || waiter.fired.is_some(), "{:?} is past at {scet:?}", waiter.target);
            }
        }
    }
}

proptest! {
    #![proptest_config(crate::random::cases(60))]

    /// Given any events of the clock, then a waiter is woken once, when the clock has reached its time or was set
    /// beyond it, and not before.
    #[test]
    fn who_waits_for_a_time_is_told_once(
        schedule in prop::collection::vec((node_event(), 0..200_u64), 1..20),
    ) {
        let mut trial = Trial { world: world(), waiters: vec![] };
        for (node_event, ms) in schedule {
            trial.happens(node_event);
            let until = trial.world.now() + Time::from_ms(ms);
            trial.run_until(until);
        }
        trial.run_until(END);
    }
}

/// Given a second of the slave's time, then a waiter is woken at its microsecond.
#[test]
fn a_time_is_told_at_its_microsecond() {
    let mut trial = Trial { world: world(), waiters: vec![] };
    trial.happens(NodeEvent::Wait(1_000));
    trial.run_until(Time::from_ms(1_300));
    let [Waiter { target, fired: Some((_, scet)), .. }] = &trial.waiters[..] else { panic!("told") };
    assert!((0..=2).contains(&scet.micros_since(*target)), "{scet:?} for {target:?}");
}
