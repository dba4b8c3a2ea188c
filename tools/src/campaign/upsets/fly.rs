//! One upset: it is put into a copy of the flight, and the rest is judged.

use std::panic::{AssertUnwindSafe, catch_unwind};

use can_twin::spacecraft::BoardId;

use super::outcome::{Case, Outcome, PROBED_US, unhealthy};
use super::place::{Place, Target, Upset};
use super::places;
use super::world::{Flight, JUDGED_US, RESET_US, World};

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
    if world.fly_judged(flight)? {
        // The probe is that of the reference.
        let (outcome, reasons) = judge(world, upset, flight);
        return Ok((outcome, reasons));
    }
    let (outcome, reasons) = judge(world, upset, flight);
    if outcome.is_bad() {
        return Ok((outcome, reasons));
    }
    world.probe(flight)?;
    let span = world.end_us() - PROBED_US..world.end_us();
    let wrong = unhealthy(&flight.record, reference(world, upset), &span, &span);
    Ok(if wrong.is_empty() { (outcome, reasons) } else { (Outcome::Latent, wrong) })
}

/// Returns the flight that an upset is compared with.
fn reference<'a>(world: &'a World, upset: &Upset) -> &'a super::record::Record {
    if upset.place == Place::Store { world.reset(upset.board) } else { &world.reference }
}

fn judge(world: &World, upset: &Upset, flight: &Flight) -> (Outcome, Vec<String>) {
    let case = Case {
        run: &flight.record,
        reference: reference(world, upset),
        reset: (world.reset(upset.board), RESET_US),
        node: world.node(upset.board),
        judged: upset.at_us..JUDGED_US,
    };
    case.judge()
}
