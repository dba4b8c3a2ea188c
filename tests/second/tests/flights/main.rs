//! Firmware in the loop: flights of images of every configuration. `tests/flight` has those that `cargo test` flies.
//!
//! Unless a test says otherwise, boards are pyboards. Profile `librecube`: heartbeat 250 ms, consumer time 2.5 s, Ttoggle 5, SYNC 5 s, time
//! 10 s, a command and a telemetry request to each slave every 100 ms; slave 4 has selective access.

mod acknowledged;
mod babble;
mod bare;
mod bench;
mod claims;
mod data_sheet;
mod division;
mod dominant;
mod drivers_of_others;
mod embassy_ports;
mod equal_boards;
mod filters;
mod flipped;
mod foreign_nodes;
mod fork;
mod identity;
mod intruders;
mod leds;
mod minimal;
mod minority;
mod mixed;
mod one_controller;
mod page;
mod pulse;
mod rates;
mod repeats;
mod rivals;
mod saves;
mod selftest;
mod silicon;
mod stamps;
mod store;
mod templates;
mod thermometer;
mod too_much;
mod two_folders;
mod unheard;
mod upsets;
