//! One upset: it is put into a copy of the flight, and the rest is judged.

use std::panic::{AssertUnwindSafe, catch_unwind};

use can_twin::spacecraft::BoardId;
use can_twin::wire::time::Time;

use super::outcome::{Case, Outcome, PROBED_US, View, unhealthy};
use super::place::{Place, Target, Upset};
use super::places;
use super::record::Record;
use super::world::{Flight, JUDGED_US, RESET_US, Reference, World};

/// Result of an upset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flown {
    /// Board and place: `slave 4: TIM2.PSC bit 3`.
    pub name: String,
    /// The outcome.
    pub outcome: Outcome,
    /// Reasons for a bad outcome, or the refusal of the emulator.
    pub reasons: Vec<String>,
}

/// Flies an upset. A panic of the emulator makes it unjudged.
pub fn fly(world: &World, upset: &Upset) -> Flown {
    let flight = world.flight_at(upset.at_us);
    let board = flight.craft.board(BoardId(upset.board));
    let registers = board.state_registers();
    let Upset { place, target, bit, .. } = *upset;
    let named = places::name(&world.places[upset.board], board, &registers, place, target, bit);
    let name = format!("{}: {named}", world.board_name(upset.board));
    let (outcome, reasons) =
        catch_unwind(AssertUnwindSafe(|| attempt(world, upset, flight))).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            (Outcome::Unjudged, vec![format!("panic of the emulator: {text}")])
        });
    Flown { name, outcome, reasons }
}

fn attempt(world: &World, upset: &Upset, mut flight: Flight) -> (Outcome, Vec<String>) {
    match fly_and_judge(world, upset, &mut flight) {
        Ok(judged) => judged,
        Err(refused) => (Outcome::Unjudged, vec![refused]),
    }
}

/// Puts the upset into its board.
fn strike(upset: &Upset, flight: &mut Flight) -> Result<(), String> {
    let board = flight.craft.board_mut(BoardId(upset.board));
    match upset.target {
        Target::Core(register) => board.flip_core(register, upset.bit),
        Target::Address(address) if upset.place == Place::Peripherals => {
            board.flip_register(address, upset.bit).map_err(|refusal| refusal.to_string())?;
        }
        Target::Address(address) => {
            let flipped = board.flip_memory(address, upset.bit);
            flipped.map_err(|_| format!("there is no memory at {address:08X}h"))?;
        }
    }
    if upset.place == Place::Store {
        board.reset();
    }
    Ok(())
}

fn fly_and_judge(
    world: &World,
    upset: &Upset,
    flight: &mut Flight,
) -> Result<(Outcome, Vec<String>), String> {
    strike(upset, flight)?;
    let reference = reference(world, upset);
    // The parameter store is compared with a flight with a reset.
    let ended = if upset.place == Place::Store { None } else { world.fly_judged(flight)? };
    if let Some(record) = ended {
        let (outcome, reasons) = judge(world, upset, &record, JUDGED_US);
        if !outcome.is_bad() {
            // The probe is that of the reference.
            return Ok((outcome, reasons));
        }
    }
    flight.fly(Time::from_us(JUDGED_US))?;
    let (mut outcome, mut reasons) = judge(world, upset, &flight.record, JUDGED_US);
    if outcome.is_bad() && world.late_us() > JUDGED_US {
        flight.fly(Time::from_us(world.late_us()))?;
        (outcome, reasons) = judge(world, upset, &flight.record, world.late_us());
    }
    if outcome.is_bad() {
        return Ok((outcome, reasons));
    }
    world.probe(flight)?;
    let run = View { record: &flight.record, end: flight.craft.now().as_us(), length: PROBED_US };
    let expected = View { record: &reference.probed, end: world.probed_us(), length: PROBED_US };
    let wrong = unhealthy(run, expected);
    Ok(if wrong.is_empty() { (outcome, reasons) } else { (Outcome::Latent, wrong) })
}

/// Returns the flights that an upset is compared with.
fn reference<'a>(world: &'a World, upset: &Upset) -> &'a Reference {
    if upset.place == Place::Store { world.reset(upset.board) } else { &world.reference }
}

fn judge(world: &World, upset: &Upset, record: &Record, end_us: u64) -> (Outcome, Vec<String>) {
    let case = Case {
        run: record,
        reference: &reference(world, upset).calm,
        reset: (&world.reset(upset.board).calm, RESET_US),
        node: world.node(upset.board),
        judged: upset.at_us..end_us,
    };
    case.judge()
}
