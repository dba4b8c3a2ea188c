//! Aimed upsets of a spacecraft with one master, and their outcomes.

use ecss_can_cli::campaign::upsets::fly::fly;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::place::Upset;
use ecss_can_cli::campaign::upsets::world::World;

/// Upsets of the slave with parallel access: name, place, outcome.
const AIMED: [(&str, &str, Outcome); 12] = [
    // Without time base nothing happens any more, and the watchdog is fed.
    ("TIM2.CR1 bit 0", "peripherals board=1 address=40000000 bit=0", Outcome::NotRecovered),
    ("TIM2.PSC bit 5", "peripherals board=1 address=40000028 bit=5", Outcome::NotRecovered),
    ("TIM2.CNT bit 16", "peripherals board=1 address=40000024 bit=16", Outcome::NotRecovered),
    ("NVIC.ISER0 bit 28", "peripherals board=1 address=E000E100 bit=28", Outcome::NotRecovered),
    ("BASEPRI bit 4", "masks board=1 register=BASEPRI bit=4", Outcome::NotRecovered),
    // The watchdog resets the board late: the master changes the bus, and the slave with selective access has to search.
    ("PRIMASK bit 0", "masks board=1 register=PRIMASK bit=0", Outcome::OthersLose),
    // Interrupt of the first FIFO.
    ("CAN1.IER bit 1", "peripherals board=1 address=40006414 bit=1", Outcome::NotRecovered),
    // The driver mends what all filter banks share.
    ("CAN1.FMR bit 0", "peripherals board=1 address=40006600 bit=0", Outcome::None),
    ("S31 bit 3", "core board=1 register=S31 bit=3", Outcome::None),
    ("PC bit 20", "core board=1 register=PC bit=20", Outcome::Reset),
    // CAN_RX of the bus that is not in use.
    ("GPIOB.AFRH bit 17", "peripherals board=1 address=40020424 bit=17", Outcome::Latent),
    ("RCC.PLLCFGR bit 7", "peripherals board=1 address=40023804 bit=7", Outcome::Unjudged),
];

/// Given a spacecraft in flight, when one bit flips, then the outcome is the known one.
#[test]
fn aimed_upsets_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong: Vec<String> = AIMED
        .iter()
        .filter_map(|(name, place, expected)| {
            let text = format!("upset masters=1 at=5499455 place={place}");
            let upset: Upset = text.parse().expect(name);
            let flown = fly(&world, &upset);
            let is_named = flown.name.contains(name);
            (flown.outcome != *expected || !is_named).then(|| format!("{name}: {flown:?}"))
        })
        .collect();
    assert_eq!(wrong, [""; 0]);
}
