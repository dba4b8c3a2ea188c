//! The analysis behind `cargo schedule`; the other commands are packages of their own.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod schedule;

use ecss_can::profile;
use firmware_images::support::board::Profile;

/// The numbers of a mission profile.
pub fn numbers(profile: Profile) -> &'static profile::Profile {
    match profile {
        Profile::Librecube => &mission::LIBRECUBE,
        Profile::Standard => &mission::STANDARD,
        Profile::Standby => &mission::TWO_MASTERS,
    }
}
