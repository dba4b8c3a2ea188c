//! The images, their recordings and their data sheets, checked with third-party tools.
//!
//! It is one program, so that tests that wait for their spacecraft run in parallel.

mod data_sheets;
mod qemu;
mod recordings;
mod report;
mod scripts;
mod sdo_client;
mod shards;
mod your_own;
