//! The local clock against emulated crystals.

mod accuracy;
mod bounds;
mod forged;
mod holdover;
mod schedules;
