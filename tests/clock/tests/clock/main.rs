//! The local clock against emulated crystals.

mod accuracy;
mod holdover;
mod schedules;
