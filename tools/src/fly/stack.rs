//! The deepest stack of a board on the twin, determined from the bytes of RAM that its program has written.

use anyhow::Context;
use can_twin::board::EmulatedBoard;
/// Every byte of RAM that the program has not written since power-on.
use can_twin::model::RAM_AT_POWER_ON as UNTOUCHED;

/// Greatest size of a stack, in bytes.
const MOST: u32 = 64 * 1024;
/// Bytes of untouched memory that mark the end of the stack; less may be a hole in a stack frame.
const HOLE: usize = 1024;
/// Symbols of the highest and of the lowest address of the stack.
const START: &str = "_stack_start";
const END: &str = "_stack_end";

/// Returns the greatest number of stack bytes that the program has used since power-on. A result of 64 KiB, the whole
/// stack, may mean an overflow.
///
/// # Errors
/// When the image lacks the symbols of its stack.
pub fn deepest(board: &EmulatedBoard) -> anyhow::Result<u32> {
    let symbol = |name| board.symbol(name).with_context(|| format!("the image has no symbol {name}"));
    let start = symbol(START)?.address;
    let end = symbol(END)?.address.max(start.saturating_sub(MOST));
    let memory = board
        .read_memory(end, start.saturating_sub(end) as usize)
        .map_err(|_| anyhow::anyhow!("{END} to {START}, {end:08X}h to {start:08X}h, is not in memory"))?;
    Ok(used(&memory) as u32)
}

/// Bytes at the end of `memory` up to the first hole.
fn used(memory: &[u8]) -> usize {
    let (mut used, mut hole) = (0, 0);
    for (depth, byte) in (1..).zip(memory.iter().rev()) {
        if *byte != UNTOUCHED {
            (used, hole) = (depth, 0);
        } else {
            hole += 1;
            if hole == HOLE {
                break;
            }
        }
    }
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stack_ends_at_the_first_hole() {
        let mut memory = [UNTOUCHED; 3 * HOLE];
        assert_eq!(used(&memory), 0);
        // Someone else's.
        memory[0] = 0;
        let top = memory.len();
        memory[top - 100] = 1;
        assert_eq!(used(&memory), 100);
        memory[top - HOLE] = 1;
        assert_eq!(used(&memory), HOLE);
        memory[top - 2 * HOLE - 1] = 1;
        assert_eq!(used(&memory), HOLE);
    }
}
