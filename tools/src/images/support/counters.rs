//! Counters of the application of a mission image, read from a board's memory.

use anyhow::anyhow;
use can_twin::board::EmulatedBoard;
use can_twin::model::RAM_AT_POWER_ON;

/// The variable's path in the image.
const SYMBOL: &str = "mission::counters::COUNTERS";

/// 32-bit words, little-endian: the fields below in their order.
const WORDS: usize = 5;

/// Counters of the application.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Commands sent (master) or executed (slave).
    pub commands: u32,
    /// Telemetry requests sent (master) or answered (slave).
    pub requests: u32,
    /// Telemetry replies received (master).
    pub replies: u32,
    /// Turns of slaves that were skipped because the application was late (master).
    pub skipped_turns: u32,
    /// Commands dropped as repeats of the last one (slave).
    pub repeats: u32,
}

impl Counters {
    /// Reads the counters of a board; all zero until its program has initialised its memory. `None` for an image that
    /// is not of the mission.
    ///
    /// # Errors
    /// When the counters are not in memory.
    pub fn read(board: &EmulatedBoard) -> anyhow::Result<Option<Counters>> {
        let Some(symbol) = board.symbol(SYMBOL) else { return Ok(None) };
        let bytes = board
            .read_memory(symbol.address, 4 * WORDS)
            .map_err(|_| anyhow!("{SYMBOL} at {:08X}h is not in memory", symbol.address))?;
        Ok(Some(decode(&bytes)))
    }
}

fn decode(bytes: &[u8]) -> Counters {
    let word = |n: usize| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * n + byte]));
    // The program has not initialised its memory yet, or is just doing so.
    if bytes.ends_with(&[RAM_AT_POWER_ON; 4]) {
        return Counters::default();
    }
    let [commands, requests, replies, skipped_turns, repeats] = std::array::from_fn(word);
    Counters { commands, requests, replies, skipped_turns, repeats }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_in_their_order() {
        let bytes: Vec<u8> = (1_u32..=5).flat_map(u32::to_le_bytes).collect();
        let expected = Counters { commands: 1, requests: 2, replies: 3, skipped_turns: 4, repeats: 5 };
        assert_eq!(decode(&bytes), expected);
    }

    #[test]
    fn memory_before_its_initialisation_counts_nothing() {
        let mut bytes = [RAM_AT_POWER_ON; 4 * WORDS];
        bytes[..8].fill(0);
        assert_eq!(decode(&bytes), Counters::default());
    }
}
