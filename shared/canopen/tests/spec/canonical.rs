//! Canonical form of a state: what each attribute does, and what the machines of CANopen forget.

use async_canopen::heartbeat::machine::{Consumer, ConsumerTimes, NodeControl};
use async_canopen::link::machine::Outgoing;
use async_canopen::nmt::machine::{Clash, ClashTimes, ClashWatch, ResetGuard};
use async_canopen::types::NmtState::Operational;
use async_canopen::types::{Bus, Canonical, Duration, Instant, Instants, PerBus, Periodic};

use crate::bench::{frame, ms, node, span};

/// Returns the instant this many milliseconds after the origin of canonical states.
fn after(ms: u64) -> Instant {
    Instant::ORIGIN + span(ms)
}

/// Returns the instant this many milliseconds before that origin.
fn before(ms: u64) -> Instant {
    Instant::ORIGIN - span(ms)
}

/// The canonical form at `now`, milliseconds.
fn canonical<M: Canonical + Clone>(machine: &M, now: u64, context: &M::Context) -> M {
    let mut machine = machine.clone();
    machine.canonical(ms(now), context);
    machine
}

#[test]
fn a_due_instant_keeps_its_distance_to_now() {
    for (at, shifted) in [(1_005, after(5)), (1_000, after(0)), (999, after(0)), (0, after(0))] {
        let mut at = ms(at);
        at.due(ms(1_000));
        assert_eq!(at, shifted);
    }
}

#[test]
fn an_age_beyond_its_horizon_is_the_horizon() {
    for (at, shifted) in [(1_005, after(5)), (990, before(10)), (980, before(20)), (979, before(20))] {
        let mut at = ms(at);
        at.age(ms(1_000), span(20));
        assert_eq!(at, shifted);
    }
}

#[test]
fn a_missed_point_of_a_grid_is_the_last_one_before_now() {
    for (at, shifted) in [(1_005, after(5)), (995, before(5)), (975, before(5)), (970, after(0))] {
        let mut at = ms(at);
        at.grid(ms(1_000), span(10));
        assert_eq!(at, shifted);
    }
    // A period of zero has one point.
    let mut at = ms(970);
    at.grid(ms(1_000), Duration::ZERO);
    assert_eq!(at, before(30));
}

#[test]
fn never_stays_never() {
    let mut at = Instant::NEVER;
    at.due(ms(1_000));
    at.age(ms(1_000), span(20));
    at.grid(ms(1_000), span(10));
    assert_eq!(at, Instant::NEVER);
}

#[test]
fn each_instant_of_a_field_is_shifted() {
    let mut at = [PerBus { nominal: Some(ms(1_003)), redundant: None }, PerBus::from_fn(|_| Some(ms(900)))];
    at.age(ms(1_000), span(50));
    let second = PerBus::from_fn(|_| Some(before(50)));
    assert_eq!(at, [PerBus { nominal: Some(after(3)), redundant: None }, second]);
    let mut at = (ms(1_003), Bus::Redundant);
    at.due(ms(1_000));
    assert_eq!(at, (after(3), Bus::Redundant));
}

/// Machine with a context that it notes, so that tests see what its owner passed.
#[derive(Clone, Debug, PartialEq, Canonical)]
#[canonical(context = u16)]
struct Noting {
    #[canonical(value = *context)]
    context: u16,
}

const UNNOTED: Noting = Noting { context: 0 };

fn noting(context: u16) -> Noting {
    Noting { context }
}

#[derive(Clone, Debug, PartialEq, Canonical)]
struct Owner {
    #[canonical(value = 7)]
    count: u16,
    #[canonical(within = self.count)]
    one: Noting,
    #[canonical(within = self.count + 1)]
    maybe: Option<Noting>,
    #[canonical(within = self.count + 2)]
    both: PerBus<Noting>,
    #[canonical(each = |nth| self.count + 10 * nth as u16)]
    each: [Noting; 3],
    #[canonical(within = self.count + 3)]
    row: [Noting; 2],
    is_untouched: bool,
}

/// Given a field that changes, when fields behind it depend on it, then they see its value of before.
#[test]
fn expressions_read_the_state_before_any_change() {
    let owner = Owner {
        count: 100,
        one: UNNOTED,
        maybe: Some(UNNOTED),
        both: PerBus::from_fn(|_| UNNOTED),
        each: [UNNOTED; 3],
        row: [UNNOTED; 2],
        is_untouched: true,
    };
    let expected = Owner {
        count: 7,
        one: noting(100),
        maybe: Some(noting(101)),
        both: PerBus::from_fn(|_| noting(102)),
        each: [noting(100), noting(110), noting(120)],
        row: [noting(103), noting(103)],
        is_untouched: true,
    };
    assert_eq!(canonical(&owner, 1_000, &()), expected);
}

#[derive(Clone, Debug, PartialEq, Canonical)]
#[canonical(context = Duration)]
enum Phase {
    Idle,
    Waiting {
        #[canonical(due)]
        until: Instant,
        number: u8,
    },
    Heard(u8, #[canonical(age = *context)] Instant),
    Since(#[canonical(value = now, age = self.memory())] Instant),
}

impl Phase {
    fn memory(&self) -> Duration {
        if let Phase::Since(since) = self { since.since(Instant::ZERO) } else { Duration::ZERO }
    }
}

#[test]
fn a_variant_has_the_horizons_of_its_fields() {
    let cases = [
        (Phase::Idle, Phase::Idle),
        (Phase::Waiting { until: ms(900), number: 3 }, Phase::Waiting { until: after(0), number: 3 }),
        (Phase::Heard(5, ms(960)), Phase::Heard(5, before(40))),
        (Phase::Heard(5, ms(900)), Phase::Heard(5, before(50))),
        (Phase::Since(ms(900)), Phase::Since(after(0))),
    ];
    for (phase, expected) in cases {
        assert_eq!(canonical(&phase, 1_000, &span(50)), expected);
    }
}

#[derive(Clone, Debug, PartialEq, Canonical)]
struct Generic<I, M, const N: usize> {
    #[canonical(due)]
    instants: [Option<I>; N],
    machine: M,
}

#[test]
fn a_generic_type_is_canonical_with_its_parameters() {
    let outgoing = |expires| Outgoing { frame: frame(0x703, &[5]), expires };
    let state = Generic { instants: [None, Some(ms(1_200))], machine: Some(outgoing(ms(1_100))) };
    let expected = Generic { instants: [None, Some(after(200))], machine: Some(outgoing(after(100))) };
    assert_eq!(canonical(&state, 1_000, &()), expected);
}

#[test]
fn a_timer_keeps_its_grid() {
    let started = |at| {
        let mut timer = Periodic::new(span(100));
        timer.start(ms(at));
        timer
    };
    let form = canonical(&started(730), 1_000, &());
    assert_eq!(form.deadline(), Some(before(70)));
    assert_eq!(form, canonical(&started(930), 1_000, &()));
    assert_ne!(form, canonical(&started(940), 1_000, &()));
    assert_eq!(canonical(&started(1_040), 1_000, &()).deadline(), Some(after(40)));
}

#[test]
fn node_control_keeps_the_time_to_its_heartbeat() {
    let booted = |at| {
        let mut control = NodeControl::new(node(3), span(100), span(5), false);
        control.boot(ms(at));
        control
    };
    assert_eq!(canonical(&booted(0), 60, &()), canonical(&booted(5_000), 5_060, &()));
    assert_ne!(canonical(&booted(0), 60, &()), canonical(&booted(5_000), 5_061, &()));
}

#[test]
fn a_consumer_forgets_the_age_of_a_miss_after_its_memory() {
    let times = ConsumerTimes { consumer: span(100), memory: span(300) };
    let armed = |last| canonical(&Consumer::Armed { last: ms(last) }, 1_000, &times);
    assert_ne!(armed(950), armed(951));
    // A miss that is reported late still has its age.
    assert_eq!(armed(100), armed(700));
    assert_ne!(armed(700), armed(701));
    let missed = |last| canonical(&Consumer::Missed { last: ms(last) }, 1_000, &times);
    assert_eq!(missed(100), missed(700));
    assert_ne!(missed(700), missed(701));
    let without = ConsumerTimes { memory: Duration::ZERO, ..times };
    let forgotten = |last| canonical(&Consumer::Missed { last: ms(last) }, 1_000, &without);
    assert_eq!(forgotten(701), forgotten(700));
}

#[test]
fn a_reset_guard_keeps_the_age_of_the_boot_for_the_pause() {
    let booted = |at| {
        let mut guard = ResetGuard::new(2);
        guard.on_boot(ms(at));
        canonical(&guard, 1_000, &span(500))
    };
    assert_eq!(booted(400), booted(500));
    assert_ne!(booted(500), booted(501));
}

/// Given a boot-up, when its probation is over, then it is as if the node had not booted: it is the elder.
#[test]
fn a_clash_watch_forgets_a_boot_after_the_probation() {
    let times = ClashTimes { probation: span(200), quiet: span(600) };
    let booted = |at| {
        let mut watch = ClashWatch::new();
        watch.boot(ms(at));
        canonical(&watch, 1_000, &times)
    };
    assert_eq!(booted(800), ClashWatch::new());
    assert_ne!(booted(801), ClashWatch::new());
    assert_ne!(booted(801), booted(802));
}

#[test]
fn a_clash_watch_keeps_ages_of_heartbeats() {
    let times = ClashTimes { probation: span(200), quiet: span(600) };
    let heard = |at| {
        let mut watch = ClashWatch::new();
        watch.on_heartbeat(Operational, ms(at), times.probation, false);
        canonical(&watch, 1_000, &times)
    };
    assert_eq!(heard(300), heard(400));
    assert_ne!(heard(400), heard(401));
    // A heartbeat of its own for 1 ms.
    let sent = |at| {
        let mut watch = ClashWatch::new();
        watch.on_sent(at);
        canonical(&watch, 1_000, &times)
    };
    assert_eq!(sent(ms(998)), sent(ms(999)));
    assert_ne!(sent(ms(999)), sent(ms(999) + Duration::from_micros(1)));
}

/// Given two states with equal canonical forms, when the same heartbeat comes, then they decide alike.
#[test]
fn equal_canonical_forms_decide_alike() {
    let times = ClashTimes { probation: span(200), quiet: span(600) };
    for (age, clash) in [(100, Clash::Newcomer), (200, Clash::Elder), (900, Clash::Elder)] {
        let mut watch = ClashWatch::new();
        watch.boot(ms(1_000 - age));
        watch.on_sent(ms(1_000 - age));
        let mut form = canonical(&watch, 1_000, &times);
        assert_eq!(watch.on_heartbeat(Operational, ms(1_050), times.probation, false), clash);
        assert_eq!(form.on_heartbeat(Operational, after(50), times.probation, false), clash);
        assert_eq!(canonical(&watch, 1_050, &times), {
            form.canonical(after(50), &times);
            form
        });
    }
}
