//! Upsets that stop time, move it or change its rate, and upsets of the supervisor, which finds them.

use can_twin::spacecraft::BoardId;
use can_twin::wire::time::Time;
use ecss_can_cli::campaign::upsets::fly::Flown;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::world::{Flight, World};

use super::{AT_US, SLAVE, differs, fly_at};

const RAM: u32 = 0x2000_0000;
const RAM_BYTES: usize = 128 << 10;

/// Upsets of counters of time and of masks of interrupts, in the slave with parallel access: name, place, outcome.
const COUNTERS: [(&str, &str, Outcome); 20] = [
    // Time stops, jumps or has another rate: a counter differs from the others.
    ("TIM2.CR1 bit 0", "peripherals board=1 address=40000000 bit=0", Outcome::Reset),
    ("TIM2.CR1 bit 1", "peripherals board=1 address=40000000 bit=1", Outcome::Reset),
    ("TIM2.PSC bit 0", "peripherals board=1 address=40000028 bit=0", Outcome::Reset),
    ("TIM2.PSC bit 5", "peripherals board=1 address=40000028 bit=5", Outcome::Reset),
    ("TIM2.ARR bit 15", "peripherals board=1 address=4000002C bit=15", Outcome::Reset),
    ("TIM2.CNT bit 9", "peripherals board=1 address=40000024 bit=9", Outcome::Reset),
    ("TIM2.CNT bit 16", "peripherals board=1 address=40000024 bit=16", Outcome::Reset),
    ("NVIC.ISER0 bit 28", "peripherals board=1 address=E000E100 bit=28", Outcome::Reset),
    ("TIM5.CR1 bit 0", "peripherals board=1 address=40000C00 bit=0", Outcome::Reset),
    // Before it is in force, when TIM5 overflows after 51 s.
    ("TIM5.PSC bit 0", "peripherals board=1 address=40000C28 bit=0", Outcome::Reset),
    ("TIM5.CNT bit 31", "peripherals board=1 address=40000C24 bit=31", Outcome::Reset),
    ("SysTick.LOAD bit 23", "peripherals board=1 address=E000E014 bit=23", Outcome::Reset),
    ("SysTick.VAL bit 22", "peripherals board=1 address=E000E018 bit=22", Outcome::Reset),
    ("SysTick.CTRL bit 2", "peripherals board=1 address=E000E010 bit=2", Outcome::Reset),
    // The supervisor does not run: the watchdog expires.
    ("SysTick.CTRL bit 0", "peripherals board=1 address=E000E010 bit=0", Outcome::Reset),
    ("SysTick.CTRL bit 1", "peripherals board=1 address=E000E010 bit=1", Outcome::Reset),
    ("SCB.VTOR bit 20", "peripherals board=1 address=E000ED08 bit=20", Outcome::Reset),
    ("PRIMASK bit 0", "masks board=1 register=PRIMASK bit=0", Outcome::Reset),
    ("FAULTMASK bit 0", "masks board=1 register=FAULTMASK bit=0", Outcome::Reset),
    // The supervisor clears it.
    ("BASEPRI bit 4", "masks board=1 register=BASEPRI bit=4", Outcome::None),
];

/// Upsets of variables of the supervisor in the slave with parallel access: symbol, bit, outcome.
const IN_RAM: [(&str, u32, Outcome); 7] = [
    ("UPTIME", 31, Outcome::None),
    ("UPTIME", 0, Outcome::Reset),
    // No task has the number of the one that was asked.
    ("ASKED", 31, Outcome::Reset),
    ("TURN", 31, Outcome::None),
    ("WAITED", 31, Outcome::None),
    ("counters::OFFSET", 31, Outcome::Reset),
    ("counters::IS_CAPTURING", 0, Outcome::None),
];

/// Given a spacecraft in flight, when time stops, moves or has another rate, then the board is reset, or nothing differs.
#[test]
fn lost_time_resets_the_board() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong = COUNTERS.iter().filter_map(|(name, place, expected)| differs(&world, name, place, *expected));
    assert_eq!(wrong.collect::<Vec<_>>(), [""; 0]);
}

/// Given a spacecraft in flight, when a variable of the supervisor flips, then the board is reset, or nothing differs.
#[test]
fn flipped_variable_of_the_supervisor_resets_the_board_at_most() {
    let world = World::prepare(1, 1, false).expect("images");
    let flight = world.flight_at(AT_US);
    let slave = flight.craft.board(BoardId(SLAVE));
    let wrong = IN_RAM.iter().filter_map(|(name, bit, expected)| {
        let symbol = format!("ecss_can_stm32f4::supervisor::{name}");
        // The compiler may keep its only field, with a name of its own.
        let found = slave.symbol(&symbol).or_else(|| slave.symbol(&(symbol + ".0")));
        let address = found.expect(name).address + bit / 8;
        let flown = fly_at(&world, &format!("ram board={SLAVE} address={address:08X} bit={}", bit % 8));
        (flown.outcome != *expected).then(|| format!("{name} bit {bit}: {flown:?}"))
    });
    assert_eq!(wrong.collect::<Vec<_>>(), [""; 0]);
}

/// Returns the addresses of all instants in RAM of the slave that advance with its heartbeats: by 750 ms in three periods of 250 ms, or
/// by the delay of a late heartbeat, at most a tenth of the period, more or less.
fn instants_of_heartbeats(world: &World) -> Vec<u32> {
    let mut flight = world.flight_at(AT_US);
    let words = |flight: &Flight| {
        let ram = flight.craft.board(BoardId(SLAVE)).read_memory(RAM, RAM_BYTES).unwrap();
        let pairs = ram.as_chunks::<4>().0.windows(2);
        pairs.map(|pair| u64::from_le_bytes(*pair.as_flattened().first_chunk().unwrap())).collect::<Vec<_>>()
    };
    let before = words(&flight);
    flight.fly(Time::from_us(AT_US + 750_000)).unwrap();
    let both = before.into_iter().zip(words(&flight)).zip((RAM..).step_by(4));
    let advanced = both.filter(|((before, after), _)| {
        (1..AT_US + 500_000).contains(before) && after.wrapping_sub(*before).abs_diff(750_000) <= 25_000
    });
    advanced.map(|(_, address)| address).collect()
}

/// Given a slave in flight, when an instant at which its next heartbeat is due moves by twelve days, then its heartbeats come again: it
/// repairs the instant, or the supervisor resets it.
#[test]
fn heartbeats_that_are_due_in_twelve_days_come_again() {
    let world = World::prepare(1, 1, false).expect("images");
    let addresses = instants_of_heartbeats(&world);
    assert!(!addresses.is_empty());
    let flown: Vec<Flown> = addresses
        .iter()
        .map(|at| fly_at(&world, &format!("ram board={SLAVE} address={:08X} bit=0", at + 5)))
        .collect();
    assert!(flown.iter().all(|flown| !flown.outcome.is_bad()), "{flown:?}");
}
