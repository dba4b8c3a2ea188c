//! The memory map of the chip.

fn main() {
    boards_memory::place();
}
