//! Firmware in the loop: the real master and slave images fly a two-bus spacecraft.
//!
//! Profile `librecube`: heartbeat 250 ms, consumer time 2.5 s, Ttoggle 5, SYNC 5 s, time 10 s, a command and a telemetry
//! request to each slave every 100 ms; slave 4 has selective access.

mod boot;
mod bus_off;
mod clocks;
mod cuts;
mod driver;
mod foreign;
mod minimal;
mod nominal;
mod post_mortem;
mod program;
mod repeats;
mod resets;
mod retained;
mod segments;
mod standby;
mod start;
mod unconfigured;
