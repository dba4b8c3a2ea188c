//! The command line of the twin.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use can_twin::spacecraft::Bus;
use clap::Args;

use crate::images::support::fleet::Fleet;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::Node;

/// A wire runs for 58 hours at most.
const SECONDS: std::ops::RangeInclusive<f64> = 0.1..=172_800.0;

/// Run the spacecraft in real time and offer both buses as SLCAN over TCP, until Ctrl-C. Type commands while it runs: help
/// lists them.
#[derive(Args, Debug)]
#[command(
    after_help = "With python-can: can.Bus(interface=\"slcan\", channel=\"socket://127.0.0.1:29501\")\n\
    Without the master its slaves look for it on both buses in turn; be the master with a heartbeat of node 1 (701h 05).\n\
    Exit code 0: it ran until it was told to end; 1: a board panicked, locked up or had to be stopped, or the spacecraft\n\
    could not begin; 2: wrong command line."
)]
pub struct Options {
    /// TCP port of the nominal bus; 0: any free one
    #[arg(long, value_name = "PORT", default_value_t = 29501)]
    pub slcan_nominal: u16,

    /// TCP port of the redundant bus; 0: any free one
    #[arg(long, value_name = "PORT", default_value_t = 29502)]
    pub slcan_redundant: u16,

    /// Address to listen on; whoever reaches it commands the boards
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub listen: IpAddr,

    /// Boards and images.
    #[command(flatten)]
    pub fleet: Fleet,

    /// TCP port that takes commands, a line each; 0: any free one [none without it]
    #[arg(long, value_name = "PORT")]
    pub control: Option<u16>,

    /// Write frames and log lines into this directory: bus-nominal.log, bus-redundant.log, spacecraft.pcapng, boards.log
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,

    /// Slaves only: node 1 is played by a client
    #[arg(long, conflicts_with = "master")]
    pub no_master: bool,

    /// End by itself after so many seconds [0.1..172800, which is also the longest run without it]
    #[arg(long, value_name = "S", default_value_t = *SECONDS.end(), hide_default_value = true, allow_negative_numbers = true, value_parser = seconds)]
    pub seconds: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    crate::fly::options::seconds_within(text, &SECONDS)
}

impl Options {
    /// Checks conditions between options.
    ///
    /// # Errors
    /// When both buses are to be offered at one port, two images are given for one node, or no board is left.
    pub fn check(&self) -> Result<(), Misuse> {
        if self.slcan_nominal == self.slcan_redundant && self.slcan_nominal != 0 {
            let both = format!("--slcan-nominal and --slcan-redundant are both {}", self.slcan_nominal);
            return Err(Misuse::of("twin", both + ": each bus needs a port of its own, or 0"));
        }
        self.fleet.check("twin", &self.nodes())?;
        if self.nodes().is_empty() {
            let text = "no board is left: give a master, --slaves 1 to 14, or --slave N=FILE";
            return Err(Misuse::of("twin", text));
        }
        Ok(())
    }

    /// Node-IDs of all boards, from the lowest.
    pub fn nodes(&self) -> BTreeSet<Node> {
        let masters = if self.no_master { BTreeSet::new() } else { self.fleet.masters() };
        masters.into_iter().chain(self.fleet.slaves()).collect()
    }

    /// Returns the address at which a bus is offered.
    pub fn address(&self, bus: Bus) -> SocketAddr {
        let port = match bus {
            Bus::Nominal => self.slcan_nominal,
            _ => self.slcan_redundant,
        };
        SocketAddr::new(self.listen, port)
    }
}
