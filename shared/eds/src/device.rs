//! What is told of a device beside its dictionary.

use std::fmt;
use std::ops::RangeInclusive;

use ecss_can::types::NodeId;

use crate::Error;
use crate::file::checked;

/// Bit rates that an EDS knows, kbit/s.
pub const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];
/// Bit rates of the standard beside 1000 kbit/s (ECSS 5.4.2a).
const STANDARD_RATES: [u16; 3] = [125, 250, 500];

/// When a file was made. Given, not taken from a clock: the same dictionary makes the same file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timestamp {
    /// Year.
    pub year: u16,
    /// Month, `1..=12`.
    pub month: u8,
    /// Day, `1..=31`.
    pub day: u8,
    /// Hour, `0..=23`.
    pub hour: u8,
    /// Minute, `0..=59`.
    pub minute: u8,
}

impl Timestamp {
    /// A day, at noon.
    pub const fn noon(year: u16, month: u8, day: u8) -> Timestamp {
        Timestamp { year, month, day, hour: 12, minute: 0 }
    }

    /// `mm-dd-yyyy`.
    pub(crate) fn date(self) -> impl fmt::Display {
        format!("{:02}-{:02}-{:04}", self.month, self.day, self.year)
    }

    /// `hh:mm` and AM or PM.
    pub(crate) fn time(self) -> impl fmt::Display {
        let half = if self.hour < 12 { "AM" } else { "PM" };
        format!("{:02}:{:02}{half}", (self.hour + 11) % 12 + 1, self.minute)
    }
}

/// A type of device. Its numbers come from the dictionary: vendor, product and revision from 1018h, PDOs counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// Who makes it.
    pub vendor: String,
    /// What it is called.
    pub product: String,
    /// How it is ordered.
    pub order_code: String,
    /// What the file is about, in a line.
    pub description: String,
    /// Who made the file.
    pub author: String,
    /// Version of the file.
    pub version: u8,
    /// Revision within the version.
    pub revision: u8,
    /// When the file was first made.
    pub created: Timestamp,
    /// When the file was changed last.
    pub modified: Timestamp,
    /// Node-IDs it can have; values that follow them are told as formulas.
    pub nodes: RangeInclusive<u8>,
    /// Bit rates it can be made for, kbit/s, of [`BIT_RATES`]. A rate beside 125, 250, 500 and 1000 needs the first three
    /// of these (ECSS 5.4.2b).
    pub bit_rates: Vec<u16>,
    /// It can be the NMT master.
    pub boot_up_master: bool,
    /// It can be an NMT slave.
    pub boot_up_slave: bool,
    /// Bits that every mapped object is a multiple of: 1 where PDOs carry BOOLEANs, else 8.
    pub granularity: u8,
    /// Lines of comment.
    pub comments: Vec<String>,
}

impl Device {
    /// A device of nobody with any Node-ID, which PDOs reach bit by bit; version 1.0 of the file.
    pub fn new(made: Timestamp) -> Device {
        Device {
            vendor: String::new(),
            product: String::new(),
            order_code: String::new(),
            description: String::new(),
            author: String::new(),
            version: 1,
            revision: 0,
            created: made,
            modified: made,
            nodes: 1..=127,
            bit_rates: Vec::new(),
            boot_up_master: false,
            boot_up_slave: false,
            granularity: 1,
            comments: Vec::new(),
        }
    }

    pub(crate) fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.nodes.clone().filter_map(NodeId::new)
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let texts = [&self.vendor, &self.product, &self.order_code, &self.description, &self.author];
        texts.into_iter().chain(&self.comments).try_for_each(|text| checked(text))?;
        // ECSS 5.4.2b
        let further = self.bit_rates.iter().find(|rate| **rate != 1000 && !STANDARD_RATES.contains(rate));
        match further {
            Some(&rate) if !STANDARD_RATES.iter().all(|standard| self.bit_rates.contains(standard)) => {
                Err(Error::BitRate { rate })
            }
            _ => Ok(()),
        }
    }
}

/// One device in its network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Commissioning {
    /// Its Node-ID.
    pub node: NodeId,
    /// Its name.
    pub name: String,
    /// kbit/s.
    pub bit_rate: u16,
    /// Number of the network.
    pub network: u32,
    /// Name of the network.
    pub network_name: String,
    /// It manages the network (CiA 302).
    pub manager: bool,
}

impl Commissioning {
    /// A node at 1 Mbit/s in network 1.
    pub fn new(node: NodeId) -> Commissioning {
        Commissioning {
            node,
            name: format!("node {}", node.get()),
            bit_rate: 1000,
            network: 1,
            network_name: String::new(),
            manager: false,
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        [&self.name, &self.network_name].into_iter().try_for_each(|text| checked(text))
    }
}
