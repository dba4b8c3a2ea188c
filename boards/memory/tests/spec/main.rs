//! Memory maps of boards: chips, maps, and where both come from.

mod chips;
mod manifests;
mod maps;
mod packages;
