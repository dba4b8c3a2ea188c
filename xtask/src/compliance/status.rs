//! Status of a requirement: what this repository claims about it.

use super::check::Tests;
use super::requirements::{Applies, Interpretation, Kind, Requirement, Who};
use super::tags::Tag;

/// Status of a requirement that applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Compliant: tests verify it.
    C,
    /// Partly compliant: tests verify it, except for a deviation.
    P,
    /// Not compliant: it is on software, and no test verifies it.
    N,
    /// Open: it is on hardware or on the integrator, who shows compliance.
    Open,
}

impl Status {
    /// Returns the status of a requirement; `None` if it does not apply or is a permission.
    pub fn of(row: &Requirement, interpretations: &[Interpretation], tags: &[Tag]) -> Option<Status> {
        let deviates = || interpretations.iter().any(|one| one.id == row.id && one.kind == Kind::Deviation);
        if row.applies != Applies::Yes {
            None
        } else if row.who != Who::Software {
            Some(Status::Open)
        } else if Tests::of(row, tags).number == 0 {
            Some(Status::N)
        } else if deviates() {
            Some(Status::P)
        } else {
            Some(Status::C)
        }
    }

    /// Word in the matrix.
    pub fn word(self) -> &'static str {
        match self {
            Status::C => "C",
            Status::P => "P",
            Status::N => "N",
            Status::Open => "open",
        }
    }
}
