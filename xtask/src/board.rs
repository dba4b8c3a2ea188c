//! The boards that images are built for and flown on.

use clap::ValueEnum;
use twin::peripherals::Pin;

/// A supported board; its name on the command line is that of the firmware's cargo feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// pyboard v1.1: STM32F405RG at 168 MHz, two bxCAN controllers
    #[value(name = "pyboard-v11")]
    PyboardV11,
}

impl Board {
    /// Its name: cargo feature, command line, summary.
    pub fn name(self) -> &'static str {
        match self {
            Board::PyboardV11 => "pyboard-v11",
        }
    }

    /// How the harness closes the Node-ID straps for `node`, `2..=15`: four bits from the lowest, then odd parity; a
    /// closed strap is tied to ground, an open one has a pull-up. The master has none.
    pub fn straps(self, node: u8) -> Vec<(Pin, bool)> {
        let Board::PyboardV11 = self;
        if node == 1 {
            return Vec::new();
        }
        let parity = node.count_ones().is_multiple_of(2).then_some(4);
        let closed = (0..4).filter(|bit| node >> bit & 1 == 1).chain(parity);
        closed.map(|strap| (Pin::new('A', 2 + strap), false)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tied(node: u8) -> Vec<(Pin, bool)> {
        Board::PyboardV11.straps(node)
    }

    #[test]
    fn an_odd_number_of_straps_is_tied_to_ground() {
        assert_eq!(tied(2), [(Pin::new('A', 3), false)]);
        assert_eq!(tied(3), [2, 3, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(15), [2, 3, 4, 5, 6].map(|pin| (Pin::new('A', pin), false)));
        assert_eq!(tied(1), []);
    }
}
