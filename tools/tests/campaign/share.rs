//! A small fixed share of the campaign.

use ecss_can_cli::campaign::kind::Kind;
use ecss_can_cli::campaign::results::Asked;
use ecss_can_cli::campaign::script::Script;
use ecss_can_cli::campaign::{World, fly, fly_run};

/// Runs of seed 1: each kind of fault alone; 10 pairs, and 9 related ones.
const RUNS: u64 = 38;

fn asked(masters: u8) -> Asked {
    Asked { seed: 1, runs: RUNS, world: World::Host.name().into(), masters, kinds: vec![] }
}

/// Executes the runs on all cores. Returns the violations with their scripts.
fn violations(masters: u8, runs: &[u64]) -> Vec<String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let share = |core| {
            let numbers = runs.iter().copied().skip(core).step_by(cores);
            scope.spawn(move || {
                let flown = numbers.map(|number| {
                    let (script, outcome) = fly_run(World::Host, &asked(masters), number);
                    (number, outcome.violations, script)
                });
                let bad = flown.filter(|(_, violations, _)| !violations.is_empty());
                bad.map(|(number, violations, script)| format!("run {number}: {violations:#?}\n{script}"))
                    .collect::<Vec<_>>()
            })
        };
        let threads: Vec<_> = (0..cores).map(share).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a run catches its panics")).collect()
    })
}

#[test]
fn share_of_the_campaign_violates_nothing() {
    let bad = violations(1, &(0..RUNS).collect::<Vec<_>>());
    assert!(bad.is_empty(), "{} of {RUNS}:\n{}", bad.len(), bad.join("\n"));
}

/// Two masters, of which one is the standby, and two faults in each run.
///
/// Verifies: ECSS 8.1a
#[test]
fn share_of_the_campaign_with_two_masters_violates_nothing() {
    let bad = violations(2, &(1..RUNS).step_by(2).collect::<Vec<_>>());
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// Given prime without power for ever, then the second master takes over once, on the bus of the slaves.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_lost_master_is_replaced_in_a_campaign() {
    let script = "run masters=2 slaves=3 length=60000000\npower-master at=12000000 node=1\n";
    let outcome = fly(World::Host, &script.parse().unwrap());
    assert_eq!((outcome.violations, outcome.effective), (vec![], vec![true]));
    // The judge reports a run that ends before the takeover.
    let early = "run masters=2 slaves=3 length=12100000\npower-master at=12000000 node=1\n";
    let violations = fly(World::Host, &early.parse().unwrap()).violations;
    assert_eq!(violations, ["0 of 1 masters are active, expected 1"]);
}

#[test]
fn equal_scripts_give_equal_outcomes() {
    let script = Script::random(3, 17, 0);
    assert_eq!(fly(World::Host, &script), fly(World::Host, &script));
}

/// Given the master cut off on the nominal bus, when the images run on the twin, then the judge sees the change of the
/// bus and both slaves on the redundant one. When the run ends before the change, it reports a violation.
#[test]
fn twin_is_judged_like_the_host() {
    ecss_can_cli::campaign::prepare_twin(1, true).unwrap();
    let cut = |length: u32| -> Script {
        format!("run seed=5 slaves=2 length={length}\ncut at=4000000 place=3\n").parse().unwrap()
    };
    let flown = fly(World::Twin, &cut(7_500_000));
    assert_eq!((flown.violations, flown.effective), (vec![], vec![true]));
    let [detection] = flown.detections[..] else { panic!("{:?}", flown.detections) };
    assert!((1..250_000).contains(&detection), "{detection} us");
    let early = fly(World::Twin, &cut(4_001_000)).violations;
    assert_eq!(early.last().unwrap(), "the master is on Nominal, slaves are reached on the other bus only");
}

/// Given two master boards on the twin, when prime loses its power, then the judge sees the other one take over on the
/// bus of the slaves. When the run ends before that, it reports a violation.
///
/// Verifies: ECSS 8.1a
#[test]
fn takeover_on_the_twin_is_judged_like_one_on_the_host() {
    ecss_can_cli::campaign::prepare_twin(2, true).unwrap();
    let lost = |length: u32| -> Script {
        let text = format!("run seed=5 masters=2 slaves=2 length={length}\npower-master at=4000000 node=1\n");
        text.parse().unwrap()
    };
    let flown = fly(World::Twin, &lost(8_000_000));
    assert_eq!((flown.violations, flown.effective), (vec![], vec![true]));
    let early = fly(World::Twin, &lost(4_100_000)).violations;
    assert_eq!(early, ["0 of 1 masters are active, expected 1"]);
}

/// Given a foreign node that resets slave 2, when the slave sends its time just before a reset and soon after it, then
/// its clock counts as restarted and not as gone back.
#[test]
fn a_clock_that_began_anew_did_not_go_back() {
    ecss_can_cli::campaign::prepare_twin(2, true).unwrap();
    let text = "run seed=58665334515748677 masters=2 slaves=2 length=15500000\n\
        foreign-nmt at=9931081 bus=nominal node=2 value=129 times=30 every=165408\n";
    let flown = fly(World::Twin, &text.parse().unwrap());
    let clocks: Vec<_> = flown.violations.iter().filter(|text| text.contains("clock")).collect();
    assert!(clocks.is_empty(), "{clocks:?}");
}

/// Given two faults of which the shorter one ends the other as well on the wire, then the other one continues. Babbling
/// of a master's controller is not a violation of the master.
#[test]
fn faults_that_overlap_end_one_by_one() {
    let shorts =
        "run slaves=2 length=60000000\nshort at=13800000 place=4\nshort at=13900000 lasts=10000 place=6\n";
    let babble =
        "run slaves=2 length=20000000\nbabble at=11000000 lasts=1000000 bus=redundant node=1 value=385\n";
    for script in [shorts, babble] {
        assert_eq!(fly(World::Host, &script.parse().unwrap()).violations, <Vec<String>>::new(), "{script}");
    }
}

/// A run without effect is repeated with another script, so that each run counts.
#[test]
fn every_run_has_a_fault_that_took_effect() {
    for number in [0, 17, 24] {
        assert!(fly_run(World::Host, &asked(1), number).1.effective.contains(&true), "run {number}");
    }
}

/// Given a campaign of two kinds, then each run has one fault of each.
#[test]
fn a_campaign_of_kinds_flies_these_alone() {
    let asked = Asked { kinds: vec![Kind::Cut, Kind::ResetSlave], ..asked(1) };
    for number in 0..3 {
        let (script, _) = fly_run(World::Host, &asked, number);
        let mut kinds: Vec<Kind> = script.faults.iter().map(|fault| fault.kind).collect();
        kinds.sort();
        assert_eq!(kinds, asked.kinds, "run {number}");
    }
}
