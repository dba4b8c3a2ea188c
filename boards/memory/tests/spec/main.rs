//! Memory maps of boards: chips, maps, and the files that name the chip.

mod chips;
mod manifests;
mod maps;
mod packages;
