//! The memory map of the chip.

fn main() {
    ecss_can_memory::place();
}
