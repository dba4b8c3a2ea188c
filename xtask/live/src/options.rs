//! The command line of the twin.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use demo::record::MASTER;
use twin::spacecraft::Bus;

use support::board::Board;
use support::board::Profile;
use support::misuse::Misuse;

/// Node-IDs that the straps of a slave can say.
const NODE_FIRST: u8 = 2;
const NODE_LAST: u8 = 15;

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

    /// Number of slave boards: nodes 2, 3, 4, ... (in profile librecube node 4 uses selective bus access) [0..14]
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(0..=14))]
    pub slaves: u8,

    /// Slaves only: node 1 is played by a client
    #[arg(long, conflicts_with = "master")]
    pub no_master: bool,

    /// ELF file of a master of your own, flown as node 1
    #[arg(long, value_name = "FILE")]
    pub master: Option<PathBuf>,

    /// ELF file of a slave of your own, flown with the straps of Node-ID N [2..15]: in place of the shipped slave N, or
    /// beside the others; may be given several times
    #[arg(long = "slave", value_name = "N=FILE")]
    pub own_slaves: Vec<OwnSlave>,

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

/// The value of `--slave`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnSlave {
    /// Node-ID, 2 to 15.
    pub node: u8,
    /// The ELF file.
    pub image: PathBuf,
}

impl FromStr for OwnSlave {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (node, image) =
            text.split_once('=').ok_or("give a Node-ID and a file, for example 3=target/slave.elf")?;
        match node.parse() {
            Ok(node @ NODE_FIRST..=NODE_LAST) if !image.is_empty() => {
                Ok(OwnSlave { node, image: image.into() })
            }
            Ok(NODE_FIRST..=NODE_LAST) => Err("the file is missing behind '='".into()),
            _ => Err(format!("allowed are Node-IDs {NODE_FIRST} to {NODE_LAST}")),
        }
    }
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
    /// When both buses are to be offered at one port, two images are given for one node, or no board is left.
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
        for (index, slave) in self.own_slaves.iter().enumerate() {
            if self.own_slaves[..index].iter().any(|before| before.node == slave.node) {
                let node = slave.node;
                return Err(Misuse::of(
                    "twin",
                    format!("two images for node {node}: give --slave {node}=FILE once"),
                ));
            }
        }
        if self.no_master && self.slaves == 0 && self.own_slaves.is_empty() {
            return Err(Misuse::of(
                "twin",
                "no board is left: give a master, --slaves 1 to 14, or --slave N=FILE",
            ));
        }
        Ok(())
    }

    /// Node-IDs of all boards, from the lowest.
    pub fn nodes(&self) -> BTreeSet<u8> {
        let master = (!self.no_master).then_some(MASTER);
        let shipped = NODE_FIRST..NODE_FIRST + self.slaves;
        master.into_iter().chain(shipped).chain(self.own_slaves.iter().map(|slave| slave.node)).collect()
    }

    /// The image given for a node; `None`: the shipped one.
    pub fn own_image(&self, node: u8) -> Option<&Path> {
        match node {
            MASTER => self.master.as_deref(),
            _ => Some(&self.own_slaves.iter().find(|slave| slave.node == node)?.image),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<OwnSlave, String> {
        text.parse()
    }

    #[test]
    fn own_slave_is_a_node_and_a_file() {
        assert_eq!(parsed("3=a=b.elf"), Ok(OwnSlave { node: 3, image: "a=b.elf".into() }));
        for (wrong, said) in [
            ("3", "for example"),
            ("1=x", "2 to 15"),
            ("16=x", "2 to 15"),
            ("x=y", "2 to 15"),
            ("3=", "file"),
        ] {
            assert!(parsed(wrong).is_err_and(|error| error.contains(said)), "{wrong}");
        }
    }
}
