//! Kinds of frames in the pictures and tables of a report.

use crate::fly::flight::Flight;
use crate::fly::meaning::{Meaning, Scope};
use crate::fly::record::{MASTER, Seen, is_master};

/// Kinds of frames, in the order of their rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Nmt,
    BootUp,
    Emergency,
    Master,
    Claim,
    Slave,
    Time,
    Command,
    Request,
    Reply,
    Sdo,
    MasterPdo,
    SlavePdo,
    Other,
}

impl Kind {
    /// Returns the kinds with a separate row in the pictures of a flight; the others share the first row. Claims have
    /// one if there are two masters.
    pub fn rows(flight: &Flight) -> Vec<Kind> {
        let traffic = match flight.plan.scope() {
            Scope::Mission => &[Kind::Command, Kind::Request, Kind::Reply][..],
            Scope::Protocol => &[Kind::MasterPdo, Kind::SlavePdo],
        };
        let has_claims = flight.masters() > 1 && flight.plan.scope() == Scope::Mission;
        let claims = has_claims.then_some(Kind::Claim);
        let services = [Kind::Nmt, Kind::BootUp, Kind::Emergency, Kind::Sdo, Kind::Master];
        let common = services.into_iter().chain(claims).chain([Kind::Slave, Kind::Time]);
        common.chain(traffic.iter().copied()).collect()
    }

    /// Kinds without a row of their own.
    pub const OTHERS: [Kind; 1] = [Kind::Other];

    /// The kind of a frame.
    pub fn of(seen: &Seen) -> Kind {
        match seen.meaning {
            Some(Meaning::Nmt { .. }) => Kind::Nmt,
            Some(Meaning::BootUp { .. }) => Kind::BootUp,
            Some(Meaning::Emergency { .. }) => Kind::Emergency,
            Some(Meaning::Sdo { .. }) => Kind::Sdo,
            Some(Meaning::Claim { .. }) => Kind::Claim,
            Some(Meaning::Pdo) if is_master(seen.from) => Kind::MasterPdo,
            Some(Meaning::Pdo) => Kind::SlavePdo,
            Some(Meaning::Heartbeat { node: MASTER, .. }) => Kind::Master,
            Some(Meaning::Heartbeat { .. }) => Kind::Slave,
            Some(Meaning::Sync | Meaning::SpacecraftTime(_) | Meaning::LocalTime { .. }) => Kind::Time,
            Some(Meaning::Telecommand { .. }) => Kind::Command,
            Some(Meaning::TelemetryRequest { .. }) => Kind::Request,
            Some(Meaning::Telemetry { .. } | Meaning::CyclicState { .. }) => Kind::Reply,
            None => Kind::Other,
        }
    }

    /// Returns its long name, its short name, and its classes in the pictures.
    pub fn look(self) -> [&'static str; 3] {
        match self {
            Kind::Nmt => ["NMT", "NMT", "black thick"],
            Kind::BootUp => ["boot-up", "boot-up", "cyan thick"],
            Kind::Emergency => ["EMCY", "EMCY", "orange thick"],
            Kind::Master => ["heartbeat, master", "HB master", "blue"],
            Kind::Claim => ["claims, master", "claims", "grey"],
            Kind::Slave => ["heartbeats, slaves", "HB slaves", "sky"],
            Kind::Time => ["SYNC and time", "SYNC, time", "amber"],
            Kind::Command => ["TC", "TC", "teal"],
            Kind::Request => ["TM request", "TM request", "violet"],
            Kind::Reply => ["TM reply", "TM reply", "green"],
            Kind::Sdo => ["SDO", "SDO", "pink"],
            Kind::MasterPdo => ["PDOs, master", "PDO master", "teal"],
            Kind::SlavePdo => ["PDOs, slaves", "PDO slaves", "green"],
            Kind::Other => ["other", "other", "grey"],
        }
    }
}
