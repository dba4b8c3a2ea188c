//! The counters that every image exports, read from a board's memory.

use anyhow::{Context, ensure};
use can_twin::board::EmulatedBoard;
use can_twin::image::Image;
use can_twin::model::RAM_AT_POWER_ON;

/// The variable's name in the image.
const SYMBOL: &str = "DIAGNOSTICS";

/// Its first word.
const MAGIC: u32 = u32::from_le_bytes(*b"ECAN");

/// 32-bit words, little-endian: magic, then the fields below in their order.
const WORDS: usize = 14;

/// Counters of the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    /// Frames that the node handled, on the nominal and redundant bus.
    pub handled: [u32; 2],
    /// Received frames lost in the port.
    pub overruns: u32,
    /// Events that were lost because the application was too slow.
    pub app_overflows: u32,
    /// Interrupts of both controllers: results of transmissions, received frames, changes of the error state.
    pub interrupts: [u32; 3],
    /// Stamps that were to be measured in hardware.
    pub stamps: Stamps,
}

/// Stamps of a board, both buses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamps {
    /// Number of measured stamps.
    pub captured: u32,
    /// Numbers of stamps not measured, by reason: no edges; edges of another frame; interrupt too late; more than one
    /// equal frame.
    pub missed: [u32; 4],
    /// Low word of the last measured stamp, ticks of 1/84 µs.
    pub last: u32,
}

impl Diagnostics {
    /// Returns whether an image exports the counters.
    pub fn is_in(image: &Image) -> bool {
        image.symbol(SYMBOL).is_some()
    }

    /// Reads the counters of a board; all zero until its program has initialised its memory.
    ///
    /// # Errors
    /// When the image does not export the counters.
    pub fn read(board: &EmulatedBoard) -> anyhow::Result<Diagnostics> {
        let symbol = board.symbol(SYMBOL).with_context(|| format!("the image has no symbol {SYMBOL}"))?;
        let bytes = board
            .read_memory(symbol.address, 4 * WORDS)
            .map_err(|_| anyhow::anyhow!("{SYMBOL} at {:08X}h is not in memory", symbol.address))?;
        decode(&bytes)
    }

    /// Frames that passed the filters of `board` since its last reset and that its node never handled.
    pub fn lost_frames(&self, board: &EmulatedBoard) -> u64 {
        board.admitted().saturating_sub(self.frames())
    }

    /// Returns the number of frames that the node handled on both buses.
    pub fn frames(&self) -> u64 {
        self.handled.iter().map(|count| u64::from(*count)).sum()
    }
}

fn decode(bytes: &[u8]) -> anyhow::Result<Diagnostics> {
    let word = |n: usize| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * n + byte]));
    // The program has not initialised its memory yet, or is just doing so.
    if bytes.iter().all(|byte| [0, RAM_AT_POWER_ON].contains(byte)) {
        return Ok(Diagnostics::default());
    }
    ensure!(word(0) == MAGIC, "{SYMBOL} begins with {:08X}h, not with \"ECAN\"", word(0));
    Ok(Diagnostics {
        handled: [word(1), word(2)],
        overruns: word(3),
        app_overflows: word(4),
        interrupts: [word(5), word(6), word(7)],
        stamps: Stamps { captured: word(8), missed: [word(9), word(10), word(11), word(12)], last: word(13) },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_in_their_order() {
        let words = [MAGIC, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13];
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let expected = Diagnostics {
            handled: [1, 2],
            overruns: 3,
            app_overflows: 4,
            interrupts: [5, 6, 7],
            stamps: Stamps { captured: 8, missed: [9, 10, 11, 12], last: 13 },
        };
        assert_eq!(decode(&bytes).unwrap(), expected);
    }

    #[test]
    fn something_else_in_its_place_is_an_error() {
        assert!(decode(&[0xFF; 4 * WORDS]).unwrap_err().to_string().contains("ECAN"));
        assert_eq!(decode(&[0; 4 * WORDS]).unwrap(), Diagnostics::default());
    }

    #[test]
    fn memory_before_its_initialisation_counts_nothing() {
        let mut bytes = [RAM_AT_POWER_ON; 4 * WORDS];
        assert_eq!(decode(&bytes).unwrap(), Diagnostics::default());
        bytes[..40].fill(0);
        assert_eq!(decode(&bytes).unwrap(), Diagnostics::default());
    }
}
