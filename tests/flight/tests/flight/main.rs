//! Firmware in the loop: the real master and slave images fly a two-bus spacecraft.
//!
//! Profile `librecube`: heartbeat 250 ms, consumer time 2.5 s, Ttoggle 5, SYNC 5 s, time 10 s, a command and a telemetry
//! request to each slave every 100 ms; slave 4 has selective access.

mod acknowledged;
mod babble;
mod bare;
mod boot;
mod bus_off;
mod claims;
mod clocks;
mod cuts;
mod data_sheet;
mod division;
mod driver;
mod equal_boards;
mod filters;
mod flipped;
mod foreign;
mod foreign_nodes;
mod fork;
mod identity;
mod intruders;
mod leds;
mod minimal;
mod minority;
mod mixed;
mod nominal;
mod one_controller;
mod peripherals;
mod post_mortem;
mod pulse;
mod rates;
mod repeats;
mod resets;
mod retained;
mod rivals;
mod saves;
mod segments;
mod selftest;
mod silicon;
mod stamps;
mod standby;
mod start;
mod store;
mod thermometer;
mod too_much;
mod unconfigured;
mod unheard;
