//! The command line of the twin.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use clap::Args;
use twin::spacecraft::Bus;

use support::board::Board;
use support::board::Profile;
use support::misuse::Misuse;

/// A wire runs for 58 hours at most.
const SECONDS: std::ops::RangeInclusive<f64> = 0.1..=172_800.0;

/// Run the spacecraft in real time and offer both buses as SLCAN over TCP, until Ctrl-C.
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

    /// Number of slave boards: nodes 2, 3, 4, ... (in profile librecube node 4 uses selective bus access) [1..14]
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=14))]
    pub slaves: u8,

    /// Slaves only: node 1 is played by a client
    #[arg(long)]
    pub no_master: bool,

    /// End by itself after so many seconds [0.1..172800, which is also the longest run without it]
    #[arg(long, value_name = "S", default_value_t = *SECONDS.end(), hide_default_value = true, allow_negative_numbers = true, value_parser = seconds)]
    pub seconds: f64,

    /// Board whose images are built and run
    #[arg(long, value_name = "BOARD", value_enum, default_value_t = Board::PyboardV11)]
    pub board: Board,

    /// Mission profile to build with
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    pub profile: Profile,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if SECONDS.contains(&seconds) => Ok(seconds),
        _ => Err(format!("allowed are seconds from {} to {}", SECONDS.start(), SECONDS.end())),
    }
}

impl Options {
    /// What the parser cannot see.
    ///
    /// # Errors
    /// When both buses are to be offered at one port.
    pub fn check(&self) -> Result<(), Misuse> {
        if self.slcan_nominal == self.slcan_redundant && self.slcan_nominal != 0 {
            let port = self.slcan_nominal;
            return Err(Misuse::of(
                "twin",
                format!(
                    "--slcan-nominal and --slcan-redundant are both {port}: each bus needs a port of its own, or 0"
                ),
            ));
        }
        Ok(())
    }

    /// Where a bus is offered.
    pub fn address(&self, bus: Bus) -> SocketAddr {
        let port = match bus {
            Bus::Nominal => self.slcan_nominal,
            Bus::Redundant => self.slcan_redundant,
        };
        SocketAddr::new(self.listen, port)
    }
}
