//! Bit rate of each bus, as the images set it.
//!
//! The twin learns it before the flight. It runs the same boards for a moment on separate wires, and reads the bit
//! timing of each controller that takes part in a bus. The crystals are exact there, so that a rate is a round number.

use std::collections::BTreeMap;

use can_twin::board::BoardConfig;
use can_twin::crystal::Crystal;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;

/// Longest time from the power-on of a board to its first part in a bus.
const LONGEST_START: Time = Time::from_ms(2_000);

/// Interval at which the controllers are checked.
const STEP: Time = Time::from_ms(10);

/// Time that a board gets for its second controller when the first one takes part.
const BETWEEN_CONTROLLERS: Time = Time::from_ms(50);

/// Bit timing of each board on each bus.
#[derive(Debug, Default)]
pub struct Network {
    /// Bus, name of the board, bit timing; in the order of the boards.
    found: Vec<(Bus, String, BitTiming)>,
}

impl Network {
    /// Runs these boards until each has taken part in a bus, at most 2 s.
    pub fn learn(boards: impl IntoIterator<Item = BoardConfig>) -> Network {
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        for board in boards {
            let crystal = Crystal::ppm(0.0);
            spacecraft.add_board(BoardConfig { crystal, power_on_at: Time::ZERO, ..board });
        }
        let boards: Vec<BoardId> = spacecraft.boards().map(|(board, _)| board).collect();
        let mut found: BTreeMap<(BoardId, Bus), BitTiming> = BTreeMap::new();
        let mut end = LONGEST_START;
        while spacecraft.now() < end {
            let next = spacecraft.now() + STEP;
            // A board stopped by the twin is reported in the flight.
            while spacecraft.run_until(next).is_err() {}
            for (&board, bus) in boards.iter().flat_map(|board| Bus::ALL.map(|bus| (board, bus))) {
                if let Some(timing) = spacecraft.bit_timing(board, bus) {
                    found.entry((board, bus)).or_insert(timing);
                }
            }
            if boards.iter().all(|board| found.keys().any(|(of, _)| of == board)) {
                end = end.min(next + BETWEEN_CONTROLLERS);
            }
        }
        let name = |board: BoardId| spacecraft.board(board).config().name.clone();
        let found = found.into_iter().map(|((board, bus), timing)| (bus, name(board), timing));
        Network { found: found.collect() }
    }

    /// Bit timing of a bus: that of most of its boards, and of the first one of equally many. `None`: no board takes part in it.
    pub fn timing(&self, bus: Bus) -> Option<BitTiming> {
        let here = || self.found.iter().filter(|(on, ..)| *on == bus).map(|(.., timing)| *timing);
        let count = |timing: BitTiming| here().filter(|other| other.bit_rate() == timing.bit_rate()).count();
        // The last one of equal maxima is the first board.
        here().collect::<Vec<_>>().into_iter().rev().max_by_key(|timing| count(*timing))
    }

    /// Returns the bit rates with their boards, if the boards of a bus have different ones.
    pub fn disagreement(&self) -> Option<String> {
        let of = |bus: Bus| {
            let mut rates: BTreeMap<u32, Vec<&str>> = BTreeMap::new();
            for (_, name, timing) in self.found.iter().filter(|(on, ..)| *on == bus) {
                rates.entry(timing.bit_rate()).or_default().push(name);
            }
            rates
        };
        let rates = Bus::ALL.map(of).into_iter().max_by_key(BTreeMap::len).filter(|rates| rates.len() > 1)?;
        let all: Vec<String> = rates.keys().map(|rate| kbit(*rate)).collect();
        let names =
            rates.iter().map(|(rate, names)| format!("{} at {} kbit/s", names.join(", "), kbit(*rate)));
        let names: Vec<String> = names.collect();
        Some(format!("boards disagree: {} kbit/s; {}", all.join(", "), names.join("; ")))
    }
}

/// Formats a bit rate in kbit/s.
pub fn kbit(bit_rate: u32) -> String {
    (f64::from(bit_rate) / 1e3).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(boards: &[(Bus, &str, u32)]) -> Network {
        let found = boards.iter().map(|&(bus, name, kbit)| (bus, name.to_owned(), BitTiming::kbit(kbit)));
        Network { found: found.collect() }
    }

    fn rate(network: &Network, bus: Bus) -> Option<u32> {
        network.timing(bus).map(|timing| timing.bit_rate())
    }

    #[test]
    fn boards_with_one_bit_rate_agree() {
        let network = network(&[(Bus::Nominal, "master", 125), (Bus::Nominal, "slave 2", 125)]);
        assert_eq!((rate(&network, Bus::Nominal), network.disagreement()), (Some(125_000), None));
        assert_eq!(rate(&network, Bus::Redundant), None, "no board takes part in it");
    }

    /// Given two boards with 1 Mbit/s and one with 250 kbit/s, then the bus has 1 Mbit/s, and all boards are named.
    #[test]
    fn a_board_with_another_bit_rate_is_named() {
        let network = network(&[
            (Bus::Nominal, "master", 1_000),
            (Bus::Nominal, "slave 2", 1_000),
            (Bus::Nominal, "slave 3", 250),
        ]);
        assert_eq!(rate(&network, Bus::Nominal), Some(1_000_000));
        let both = "boards disagree: 250, 1000 kbit/s; slave 3 at 250 kbit/s; master, slave 2 at 1000 kbit/s";
        assert_eq!(network.disagreement().as_deref(), Some(both));
    }

    #[test]
    fn one_board_of_two_decides_by_its_place() {
        let network = network(&[(Bus::Redundant, "master", 250), (Bus::Redundant, "slave 2", 1_000)]);
        assert_eq!(rate(&network, Bus::Redundant), Some(250_000));
        assert!(network.disagreement().is_some());
    }

    #[test]
    fn a_bus_may_be_slower_than_the_other_one() {
        let network = network(&[(Bus::Nominal, "master", 250), (Bus::Redundant, "master", 1_000)]);
        assert_eq!(network.disagreement(), None);
    }

    #[test]
    fn bit_rates_are_written_in_kbit() {
        assert_eq!([10_000, 83_333, 1_000_000].map(kbit), ["10", "83.333", "1000"]);
    }
}
