//! The counters that every image exports, read from a board's memory.

use anyhow::{Context, ensure};
use twin::board::Board;

/// The variable's name in the image.
const SYMBOL: &str = "TELLTALE";

/// Its first word.
const MAGIC: u32 = u32::from_le_bytes(*b"ECAN");

/// 32-bit words, little-endian: magic, then the fields below in their order.
const WORDS: usize = 8;

/// What the firmware itself counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Telltale {
    /// Frames the node dealt with, nominal and redundant bus.
    pub handled: [u32; 2],
    /// Received frames lost in the port.
    pub overruns: u32,
    /// Events the application was too slow to take.
    pub app_overflows: u32,
    /// Commands sent (master) or executed (slave).
    pub commands: u32,
    /// Telemetry asked for (master) or answered (slave).
    pub telemetry_requests: u32,
    /// Telemetry replies received (master).
    pub telemetry_replies: u32,
}

impl Telltale {
    /// Of a board; all zero while it has not come so far as to initialise its memory.
    ///
    /// # Errors
    /// When the image does not export the counters.
    pub fn read(board: &Board) -> anyhow::Result<Telltale> {
        let symbol = board.symbol(SYMBOL).with_context(|| format!("the image has no symbol {SYMBOL}"))?;
        let bytes = board
            .read_memory(symbol.address, 4 * WORDS)
            .map_err(|_| anyhow::anyhow!("{SYMBOL} at {:08X}h is not in memory", symbol.address))?;
        decode(&bytes)
    }
}

fn decode(bytes: &[u8]) -> anyhow::Result<Telltale> {
    let word = |n: usize| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * n + byte]));
    if bytes.iter().all(|byte| *byte == 0) {
        return Ok(Telltale::default());
    }
    ensure!(word(0) == MAGIC, "{SYMBOL} begins with {:08X}h, not with \"ECAN\"", word(0));
    Ok(Telltale {
        handled: [word(1), word(2)],
        overruns: word(3),
        app_overflows: word(4),
        commands: word(5),
        telemetry_requests: word(6),
        telemetry_replies: word(7),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_in_their_order() {
        let words = [MAGIC, 1, 2, 3, 4, 5, 6, 7];
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let expected = Telltale {
            handled: [1, 2],
            overruns: 3,
            app_overflows: 4,
            commands: 5,
            telemetry_requests: 6,
            telemetry_replies: 7,
        };
        assert_eq!(decode(&bytes).unwrap(), expected);
    }

    #[test]
    fn something_else_in_its_place_is_an_error() {
        assert!(decode(&[0xFF; 32]).unwrap_err().to_string().contains("ECAN"));
        assert_eq!(decode(&[0; 32]).unwrap(), Telltale::default());
    }
}
