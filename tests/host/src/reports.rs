//! Reports at random moments, under random faults: afterwards the active master knows the error and the value.

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::emcy::ActiveError;
use ecss_can::prelude::*;
use ecss_can_worlds::{NodeKey, World};
use fastrand::Rng;

use crate::events::{Break, Flight, SOURCE, STAYS, STRIKE, WHEEL, known, report, strike, world};

/// Largest number of faults.
const FAULTS: usize = 3;
/// Time before which the faults occur.
const LAST_FAULT: Time = Time::from_ms(3_900);
/// Shortest duration of a fault, long enough for a node to notice it. Shorter ones are [jolts](crate::events::jolts).
const SHORTEST: Time = Time::from_ms(1_000);
/// Time at which all faults are repaired.
const CALM: Time = Time::from_ms(5_000);
/// Time at which the master knows the reports, after a search by a slave, the choice of the bus and the boot-up
/// process.
const END: Time = Time::from_ms(9_000);
/// Time at which the master knows them after two separated masters were active, each with slaves. The master that stays
/// asks every 10 s, and the value has an event timer.
const END_OF_TWO: Time = Time::from_ms(20_000);

/// Last report of the wheel.
#[derive(Default)]
struct Reported {
    is_wrong: bool,
    temperature: u16,
}

/// Flies a script that follows from the seed.
///
/// # Errors
/// When the master does not know the last report.
pub fn fly_random(seed: u64) -> Result<(), String> {
    let mut rng = Rng::with_seed(seed);
    let (has_standby, is_selective) = (rng.bool(), rng.bool());
    let has_other = has_standby || rng.bool();
    let flight = Flight { what: Break::Near, after_ms: 0, is_selective, has_other, has_standby };
    let mut world = world(flight);
    let (mut last, mut faults, mut were_two) = (Reported::default(), Vec::new(), false);
    let (mut struck, mut last_report) = (STRIKE, CALM);
    world.run_until(STRIKE);
    while world.now() < CALM {
        let (now, may_report) = (world.now(), world.now() < last_report);
        let may_fail = faults.len() < FAULTS && now < LAST_FAULT && !world.active_masters().is_empty();
        match rng.u8(..10) {
            0..3 if may_report => {
                last.is_wrong = !last.is_wrong;
                report(&world, last.temperature, &[(STAYS, last.is_wrong)]);
            }
            3..6 if may_report => {
                last.temperature += 1;
                report(&world, last.temperature, &[]);
            }
            6..9 if may_fail => {
                faults.push((now.as_us() / 1_000, fail(&mut world, &mut rng, has_standby, &mut last)));
                struck = now;
                // No later report hides a lost one.
                last_report = now + Time::from_ms(rng.u64(0..200));
            }
            9 if now.since(struck) >= SHORTEST => heal(&mut world),
            _ => {}
        }
        world.run_for(Time::from_us(rng.u64(500..60_000)));
        were_two |= world.active_masters().len() > 1;
    }
    heal(&mut world);
    for master in [NodeKey::MASTER, NodeKey::SECOND_MASTER].into_iter().take(1 + usize::from(has_standby)) {
        if !world.is_powered(master) {
            world.power_on(master);
        }
    }
    world.run_until(if were_two { END_OF_TWO } else { END });
    let [active] = world.active_masters()[..] else { return Err(format!("seed {seed}: no master, or two")) };
    let (errors, temperature) = known(&world, active);
    let error = ActiveError { node: WHEEL, code: STAYS, source: SOURCE };
    // Its other errors are those of its controllers.
    let is_known = errors.contains(&error) == last.is_wrong && temperature == last.temperature;
    if world.all_operational() && is_known {
        return Ok(());
    }
    Err(format!(
        "seed {seed}, standby: {has_standby}, second slave: {has_other}, selective: {is_selective}, {faults:?}: \
         the master knows {errors:?} and {temperature}; the error is there: {}, the value is {}, all are Operational: {}",
        last.is_wrong,
        last.temperature,
        world.all_operational()
    ))
}

/// Breaks a random part, and returns its name.
fn fail(world: &mut World, rng: &mut Rng, has_standby: bool, last: &mut Reported) -> &'static str {
    let (what, name) = match rng.u8(..7) {
        0 | 1 => (Break::Near, "a cut next to the master"),
        2 => (Break::Far, "a cut next to the wheel"),
        3 => (Break::Recessive, "recessive"),
        4 => (Break::Dominant, "dominant"),
        5 => {
            // It restarts without an error.
            world.reset(WHEEL);
            *last = Reported::default();
            return "reset of the wheel";
        }
        _ if has_standby => (Break::Master, "loss of the master"),
        _ => {
            world.reset(NodeKey::MASTER);
            return "reset of the master";
        }
    };
    strike(world, what);
    name
}

fn heal(world: &mut World) {
    for bus in Bus::ALL {
        world.heal(bus);
        world.strike(bus, Fault::ClearShorts);
    }
}
