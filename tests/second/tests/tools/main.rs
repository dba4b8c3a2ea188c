//! The flown images, their recordings and their data sheets, against tools of others.
//!
//! One program, so that tests that wait for their spacecraft run side by side.

mod data_sheets;
mod qemu;
mod recordings;
mod report;
mod scripts;
mod sdo_client;
mod shards;
mod your_own;
