//! Writes the memory map of the chip for the linker. Fails when `board.toml` has another chip than `Cargo.toml`.

fn main() {
    ecss_can_memory::place();
}
