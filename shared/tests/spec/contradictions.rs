//! A slave with parallel access that hears the master on both buses: what a forged or faulty message may cost.
//!
//! Parameters throughout: consumer time 100 ms, heartbeat 40 ms, Ttoggle 3, Bdefault nominal.
//!
//! Verifies: ECSS 8.3.3k, 8.3.3l

use ecss_can::redundancy::Parameters;
use ecss_can::redundancy::machine::{MasterMessage, Selection, Selector};
use ecss_can::types::{Bus, Instant, PerBus};

use crate::bench::{NOMINAL, REDUNDANT, ms};
use MasterMessage::{Command, Heartbeat};

const PARAMETERS: Parameters = Parameters {
    consumer: ecss_can::types::Duration::from_millis(100),
    producer: ecss_can::types::Duration::from_millis(40),
    bdefault: Bus::Nominal,
    ttoggle: 3,
    ntoggle: 4,
    ctoggle: 0,
};

/// Half a consumer time, in which nothing else happens.
const UNKNOWN: u64 = 50;

/// Follows the master on the nominal bus, heard every 40 ms from 1000 ms to 1120 ms.
fn following() -> Selector {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(900));
    for at in [1_000, 1_040, 1_080, 1_120] {
        selector.on_master(NOMINAL, Heartbeat, ms(at));
    }
    selector
}

/// Every decision up to `until`, with its time in milliseconds.
fn decisions(selector: &mut Selector, until: u64) -> Vec<(u64, Selection)> {
    let mut made = vec![];
    while let Some(at) = selector.deadline().filter(|at| *at <= ms(until)) {
        made.push((at.as_micros() / 1_000, selector.poll(at).expect("a deadline has a decision")));
    }
    made
}

fn us(micros: u64) -> Instant {
    Instant::from_micros(micros)
}

const fn followed(to: Bus) -> Option<Selection> {
    Some(Selection::Followed { to })
}

const fn taken_back(bus: Bus) -> Option<Selection> {
    Some(Selection::Contradicted { bus, moved: true })
}

const fn stays(bus: Bus) -> Option<Selection> {
    Some(Selection::Contradicted { bus, moved: false })
}

/// Verifies: ECSS 8.3.3g
#[test]
fn command_on_the_other_bus_moves_no_follower() {
    let mut selector = following();
    assert_eq!(selector.on_master(REDUNDANT, Command, ms(1_130)), None);
    assert_eq!((selector.selected(), selector.parameters().bdefault), (NOMINAL, NOMINAL));
    assert_eq!(selector.deadline(), Some(ms(1_220)));
}

/// Verifies: ECSS 8.3.3g
#[test]
fn heartbeat_on_the_old_bus_takes_a_move_back() {
    let mut selector = following();
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_130)), followed(REDUNDANT));
    assert_eq!(selector.parameters().bdefault, REDUNDANT);
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_160)), taken_back(NOMINAL));
    assert_eq!((selector.selected(), selector.parameters().bdefault), (NOMINAL, NOMINAL));
}

/// A heartbeat that was on the wire when the master left ends up to 5 ms later.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn heartbeat_under_way_at_the_move_is_no_contradiction() {
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_135)), None);
    assert_eq!(selector.selected(), REDUNDANT);
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, us(1_135_001)), taken_back(NOMINAL));
}

/// Given heartbeats of an intruder every 10 ms for 20 s, then the slave leaves its bus once.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn intruder_on_the_idle_bus_moves_a_slave_once() {
    let mut selector = following();
    let mut moves = 0;
    for at in (1_130..21_000).step_by(10) {
        // The master goes on every 40 ms.
        let (bus, name) = if at % 40 == 0 { (NOMINAL, "master") } else { (REDUNDANT, "intruder") };
        let decided = selector.on_master(bus, Heartbeat, ms(at));
        moves += u32::from(decided == followed(REDUNDANT));
        assert!(at < 1_160 || selector.selected() == NOMINAL, "{name} at {at} ms");
        assert_eq!(decisions(&mut selector, at), []);
    }
    assert_eq!(moves, 1);
    // When it ends, so does the hold-off: Ttoggle consumer times after the last contradiction, at 20 990 ms.
    for at in (21_000..21_280).step_by(40) {
        assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(at)), None);
    }
    assert_eq!(decisions(&mut selector, 21_290), [(21_290, Selection::Undisputed)]);
}

/// Given an intruder that is heard more seldom than a hold-off lasts at first, 300 ms, then the second one is long enough.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn seldom_intruder_moves_a_slave_twice() {
    let mut selector = following();
    let mut moves = 0;
    for at in (1_160..61_000).step_by(10) {
        if at % 40 == 0 {
            selector.on_master(NOMINAL, Heartbeat, ms(at));
        }
        if at % 410 == 0 {
            moves += u32::from(selector.on_master(REDUNDANT, Heartbeat, ms(at)) == followed(REDUNDANT));
        }
        decisions(&mut selector, at);
    }
    assert_eq!((moves, selector.selected()), (2, NOMINAL));
}

/// Given a hold-off, then heartbeats on the other bus do not count for the bus that is followed: the master is missed there 100 ms
/// after its last one.
///
/// Verifies: ECSS 8.3.3e
/// Notices: ECSS 8.3.3e: in a hold-off a heartbeat on the other bus postpones the miss.
#[test]
fn heartbeats_on_the_other_bus_do_not_postpone_the_miss() {
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_160)), taken_back(NOMINAL));
    for at in [1_180, 1_200] {
        assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(at)), stays(NOMINAL));
    }
    assert_eq!(decisions(&mut selector, 1_260), [(1_260, Selection::Missed { bus: NOMINAL })]);
}

/// In a hold-off the master is followed after one and a half of the longest gap, here 60 ms.
///
/// Verifies: ECSS 8.3.3g
/// Notices: ECSS 8.3.3g: in a hold-off the master is not followed to the other bus at all.
#[test]
fn real_change_in_a_hold_off_needs_silence_on_the_old_bus() {
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_160)), taken_back(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_180)), stays(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, us(1_219_999)), stays(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_220)), followed(REDUNDANT));
}

/// Without two heartbeats in a row no gap is known: half a consumer time.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn unknown_rhythm_counts_as_half_a_consumer_time() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(900));
    selector.on_master(NOMINAL, Heartbeat, ms(1_000));
    selector.on_master(REDUNDANT, Heartbeat, ms(1_010));
    // The bus that was left has been silent long enough: this is a new change, no contradiction.
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_010 + UNKNOWN)), followed(NOMINAL));
}

/// Given 300 heartbeats of the master 80 ms apart, when four follow 40 ms apart, then these four alone make the silence that counts,
/// 60 ms.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn only_the_last_four_gaps_make_the_rhythm() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    for at in (80..=24_000).step_by(80) {
        selector.on_master(NOMINAL, Heartbeat, ms(at));
    }
    for at in [24_040, 24_080, 24_120, 24_160] {
        selector.on_master(NOMINAL, Heartbeat, ms(at));
    }
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(24_170)), followed(REDUNDANT));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(24_200)), taken_back(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, us(24_259_999)), stays(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(24_260)), followed(REDUNDANT));
}

/// Heartbeats of an intruder on the same bus make the gaps short; the own heartbeat period (40 ms) is the least.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn rhythm_is_no_shorter_than_the_own_heartbeat() {
    let mut selector = following();
    for at in 1_121..1_130 {
        selector.on_master(NOMINAL, Heartbeat, ms(at));
    }
    selector.on_master(REDUNDANT, Heartbeat, ms(1_131));
    selector.on_master(NOMINAL, Heartbeat, ms(1_140));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, us(1_199_999)), stays(NOMINAL));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_200)), followed(REDUNDANT));
}

/// Given an intruder that goes on where the master was, then the bus counts on which the master works.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn slave_stays_where_the_master_works() {
    let mut selector = following();
    selector.on_work(PerBus { nominal: 7, redundant: 0 });
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_130)), followed(REDUNDANT));
    selector.on_work(PerBus { nominal: 7, redundant: 1 });
    for at in (1_136..2_000).step_by(10) {
        assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(at)), stays(REDUNDANT), "at {at} ms");
        if at % 40 == 16 {
            assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(at)), None);
        }
        // A command now and then.
        selector.on_work(PerBus { nominal: 7, redundant: (at / 100) as u32 });
    }
}

/// The same when the intruder is faster than the master's first command on the new bus.
///
/// Verifies: ECSS 8.3.3g
#[test]
fn slave_returns_to_where_the_master_works() {
    let mut selector = following();
    selector.on_work(PerBus { nominal: 7, redundant: 0 });
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_136)), taken_back(NOMINAL));
    selector.on_work(PerBus { nominal: 7, redundant: 2 });
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_146)), None);
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(1_170)), followed(REDUNDANT));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_180)), stays(REDUNDANT));
}

/// Given a bus found by a command, when no heartbeat follows, then the search goes on as if it had not ended.
///
/// Verifies: ECSS 8.3.3g, 8.3.3h, 8.3.3i, 8.3.1a
/// Notices: ECSS 8.3.3i: the return from a bus found by a command alone counts as a switch.
#[test]
fn bus_found_by_a_command_alone_is_given_up_again() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    // It toggled at 300 ms; the command comes 10 ms before the next time, and again and again.
    assert_eq!(decisions(&mut selector, 300).len(), 1);
    let found = selector.on_master(NOMINAL, Command, ms(590));
    assert_eq!(found, Some(Selection::Found { bus: NOMINAL, moved: true }));
    assert!(!selector.is_confirmed());
    assert_eq!((selector.selected(), selector.parameters().bdefault), (NOMINAL, NOMINAL));
    for at in [600, 640, 680] {
        assert_eq!(selector.on_master(NOMINAL, Command, ms(at)), None, "the first one counts");
    }
    assert_eq!(
        decisions(&mut selector, 690),
        [
            (690, Selection::Unconfirmed { bus: REDUNDANT, moved: true }),
            // Due since 600 ms.
            (600, Selection::Toggled { to: NOMINAL }),
        ]
    );
    assert_eq!(selector.deadline(), Some(ms(900)), "a toggling time after 600 ms");
    assert_eq!(selector.parameters().ctoggle, 2);
}

/// Verifies: ECSS 8.3.3e, 8.3.3g
/// Notices: ECSS 8.3.3l: a heartbeat that confirms a bus restores the old Bdefault.
/// Notices: ECSS 8.3.3e: a master that was confirmed is not missed when it falls silent.
#[test]
fn heartbeat_confirms_a_bus_found_by_a_command() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    selector.on_master(REDUNDANT, Command, ms(50));
    assert_eq!(selector.on_master(REDUNDANT, Heartbeat, ms(149)), Some(Selection::Confirmed));
    assert!(selector.is_confirmed());
    assert_eq!((selector.selected(), selector.parameters().bdefault), (REDUNDANT, REDUNDANT));
    assert_eq!(
        decisions(&mut selector, 249),
        [(249, Selection::Missed { bus: REDUNDANT })],
        "monitored from then on"
    );
}

/// Given a bus found by a command alone, when a heartbeat comes on the other bus, then that one is active, and no search goes on.
///
/// Verifies: ECSS 8.3.3g, 8.3.3e
/// Notices: ECSS 8.3.3k: after a command, a heartbeat on the other bus does not end the search.
/// Notices: ECSS 8.3.3g: after a command, a heartbeat on the other bus does not make that one active.
#[test]
fn heartbeat_on_the_other_bus_counts_more_than_a_command() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    selector.on_master(NOMINAL, Command, ms(50));
    let found = selector.on_master(REDUNDANT, Heartbeat, ms(80));
    assert_eq!(found, Some(Selection::Found { bus: REDUNDANT, moved: true }));
    assert!(selector.is_confirmed());
    assert_eq!((selector.selected(), selector.parameters().bdefault), (REDUNDANT, REDUNDANT));
    assert_eq!(decisions(&mut selector, 179), []);
    assert_eq!(selector.poll(ms(180)), Some(Selection::Missed { bus: REDUNDANT }), "followed from 80 ms on");
}

#[test]
fn bdefault_is_restored_when_a_command_is_not_confirmed() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    selector.on_master(REDUNDANT, Command, ms(50));
    assert_eq!(selector.parameters().bdefault, REDUNDANT);
    assert_eq!(decisions(&mut selector, 150), [(150, Selection::Unconfirmed { bus: NOMINAL, moved: true })]);
    assert_eq!((selector.selected(), selector.parameters().bdefault), (NOMINAL, NOMINAL));
}

/// After giving up a command is confirmed or not, too.
///
/// Verifies: ECSS 8.3.3g, 8.3.3j
/// Notices: ECSS 8.3.3j: a slave that gave up takes heartbeats alone, and no commands.
/// Notices: ECSS 8.3.3g: a command after giving up makes no bus active.
#[test]
fn listening_slave_goes_back_to_listening() {
    let mut selector = Selector::new(Parameters { ntoggle: 0, ..PARAMETERS });
    selector.start(ms(0));
    let found = selector.on_master(NOMINAL, Command, ms(50));
    assert_eq!(found, Some(Selection::Found { bus: NOMINAL, moved: false }));
    assert_eq!(decisions(&mut selector, 150), [(150, Selection::Unconfirmed { bus: NOMINAL, moved: false })]);
    assert_eq!(selector.deadline(), None);
}

/// Given a slave that gave up on the redundant bus after one switch, when a command comes on the nominal bus, then that one is active.
/// A heartbeat there confirms it.
///
/// Verifies: ECSS 8.3.3g
/// Notices: ECSS 8.3.3g: a command on the other bus after giving up makes no bus active.
#[test]
fn command_on_the_other_bus_is_found_after_giving_up() {
    let mut selector = Selector::new(Parameters { ntoggle: 1, ..PARAMETERS });
    selector.start(ms(0));
    assert_eq!(
        decisions(&mut selector, 600),
        [(300, Selection::Toggled { to: REDUNDANT }), (600, Selection::GaveUp { bus: REDUNDANT })]
    );
    let found = selector.on_master(NOMINAL, Command, ms(5_000));
    assert_eq!(found, Some(Selection::Found { bus: NOMINAL, moved: true }));
    assert_eq!((selector.selected(), selector.parameters().bdefault), (NOMINAL, NOMINAL));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(5_050)), Some(Selection::Confirmed));
    assert!(selector.is_confirmed());
}

/// Bdefault may be kept beyond power-off a consumer time after it changed, without contradiction, and once.
#[test]
fn bdefault_is_kept_when_nothing_contradicts_it() {
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    for at in [1_170, 1_210] {
        selector.on_master(REDUNDANT, Heartbeat, ms(at));
    }
    assert_eq!(decisions(&mut selector, 1_230), [(1_230, Selection::KeepBdefault { bus: REDUNDANT })]);
    selector.on_master(REDUNDANT, Heartbeat, ms(1_250));
    assert_eq!(decisions(&mut selector, 1_349), []);
    // Taken back at once: what was kept is as it was.
    let mut selector = following();
    selector.on_master(REDUNDANT, Heartbeat, ms(1_130));
    selector.on_master(NOMINAL, Heartbeat, ms(1_160));
    assert_eq!(decisions(&mut selector, 1_259), []);
}

/// Verifies: ECSS 8.2.3a, 8.3.3h
/// Notices: ECSS 8.3.3h: the toggling time of before the choice goes on.
#[test]
fn chosen_bus_begins_a_search_there() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    decisions(&mut selector, 600);
    assert_eq!(selector.parameters().ctoggle, 2);
    assert!(selector.select(REDUNDANT, ms(650)));
    assert_eq!((selector.selected(), selector.parameters().ctoggle), (REDUNDANT, 0));
    assert_eq!(decisions(&mut selector, 950), [(950, Selection::Toggled { to: NOMINAL })]);
    assert!(!selector.select(NOMINAL, ms(960)), "it is there");
    assert_eq!(selector.deadline(), Some(ms(1_260)));
}

/// The master can read how many toggles it took until the next search begins.
///
/// Verifies: ECSS 8.3.1a, 8.3.3i
/// Notices: ECSS 8.3.1a: Ctoggle also counts the toggles of an earlier search.
/// Notices: ECSS 8.3.3i: the switches of an earlier search count in the next one.
#[test]
fn ctoggle_stays_until_the_next_search() {
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(0));
    decisions(&mut selector, 600);
    selector.on_master(NOMINAL, Heartbeat, ms(610));
    assert_eq!(selector.parameters().ctoggle, 2);
    assert_eq!(decisions(&mut selector, 710), [(710, Selection::Missed { bus: NOMINAL })]);
    assert_eq!(selector.parameters().ctoggle, 0);
}
