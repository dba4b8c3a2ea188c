//! Rules by which a search for faults judges the redundancy of a spacecraft.
//!
//! A *search* brings a spacecraft into many situations: random faults (`tools/src/campaign`), all states of a small
//! spacecraft (`tests/model`), random sequences of frames (`tests/search/src/fuzz`). A *judge* decides whether the
//! observed behaviour is correct. This module contains the rules that several searches apply, independent of a world or
//! a wire.
//!
//! A search fills a [`View`]: the nodes at one instant, and which of them a bus joins. Then it applies the rules:
//!
//! ```
//! use ecss_can::types::{Bus, NmtState, PerBus};
//! use ecss_can_worlds::judge::{Command, Master, Slave, View};
//!
//! let master = Master { is_powered: true, bus: Some(Bus::Nominal), ..Master::default() };
//! let both = PerBus { nominal: true, redundant: true };
//! let slave = Slave { state: NmtState::Operational, bus: Some(Bus::Nominal), wired: [both; 2], ..Slave::default() };
//! let lost = Slave { wired: [PerBus::default(); 2], ..slave };
//! let view = View { masters: &[master], slaves: &[slave, lost], joins_masters: PerBus::default() };
//! assert_eq!(view.command(), Command::One(0));
//! assert!(view.serves(0, 0) && !view.is_in_reach(0, 1)); // nobody can serve the lost one
//! assert!(view.serves_all(0, Bus::Redundant)); // the other bus is as good
//! ```
//!
//! | rule | here | used by |
//! | --- | --- | --- |
//! | who manages the network (ECSS 8.1a) | [`View::command`], [`View::managers_expected`] | campaign, model |
//! | which slaves a master has to serve | [`View::is_in_reach`], [`View::is_contested`] | campaign, model |
//! | a slave is served (ECSS 8.3.3) | [`View::serves`] | campaign, model |
//! | nodes agree on the bus (ECSS 8.3.3) | [`View::is_agreed`] | model; the campaign requires more of each slave to serve |
//! | one bus serves all, or the network is split | [`View::serves_all`], [`View::is_split`] | campaign, model |
//! | active masters that hear each other | [`View::are_rivals_on`] | campaign, model |
//! | changes of the bus without an unserved node | [`View::has_moved`] | campaign, model |
//! | Ctoggle is at most Ntoggle (ECSS 8.3.3h) | [`selector::is_toggled_too_often`] | model, fuzz |
//! | Bdefault follows (ECSS 8.3.3k, l) | [`selector::is_bdefault_right`], [`View::wrong_bdefault`] | model, campaign |
//! | SDO transfers (CiA 301 7.2.4.3) | [`sdo`] | fuzz, tests of `shared` |
//! | bounds in time | [`Bounds`] | campaign, model |
//! | duration of violations, changes of role | [`Watch`] | model |
//!
//! # Limits
//!
//! - A view has at most [`MASTERS`] masters.
//! - Rules that only one search can check are in that search: executed commands, clocks and frames of a left bus
//!   (campaign), states of a single slave, an SDO client and PDO mappings (fuzz).

mod bounds;
mod command;
mod reach;
pub mod sdo;
pub mod selector;
mod service;
mod view;
mod watch;

pub use bounds::Bounds;
pub use command::Command;
pub use view::{MASTERS, Master, Slave, View};
pub use watch::Watch;
