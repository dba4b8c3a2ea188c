//! The deepest stack of a board on the twin, from what its program left in RAM.

use anyhow::Context;
use twin::board::EmulatedBoard;
/// Every byte of RAM that the program has not written since power-on.
use twin::model::RAM_AT_POWER_ON as UNTOUCHED;

/// No board has more.
const MOST: u32 = 64 * 1024;
/// So much untouched memory is no hole in a stack frame, but the end of the stack.
const HOLE: usize = 1024;
/// Where the stack begins and grows down, and where its memory ends.
const START: &str = "_stack_start";
const END: &str = "_stack_end";

/// Most bytes of stack that the program has had in use since power-on. 64 KiB, all there is for it, may have been more.
///
/// # Errors
/// When the image does not say where its stack is.
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
