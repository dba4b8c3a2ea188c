//! The commands of the program `ecss-can`, as a library for the tests and programs of the repository that it comes from.
//!
//! [`images`] builds firmware with any available toolchain; the other modules are one command each. The interface changes
//! without notice.
//!
//! Related crates: [`ecss-can`](https://docs.rs/ecss-can), [`can-twin`](https://docs.rs/can-twin),
//! [`ecss-can-worlds`](https://docs.rs/ecss-can-worlds), [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "program")]
pub mod campaign;
#[cfg(feature = "program")]
pub mod completions;
#[cfg(feature = "program")]
pub mod doctor;
#[cfg(feature = "program")]
pub mod eds;
#[cfg(feature = "program")]
pub mod firmware;
#[cfg(feature = "program")]
#[expect(missing_docs, reason = "for tests and benchmarks of the repository")]
pub mod fly;
#[cfg(feature = "program")]
pub mod help;
pub mod images;
#[cfg(feature = "program")]
pub mod man;
#[cfg(feature = "program")]
pub mod new;
#[cfg(feature = "program")]
pub mod schedule;

/// The numbers of a mission profile.
#[cfg(feature = "program")]
fn numbers(profile: images::support::board::Profile) -> &'static ecss_can::profile::Profile {
    use images::support::board::Profile;
    match profile {
        Profile::Librecube => &mission::LIBRECUBE,
        Profile::Standard => &mission::STANDARD,
        Profile::Standby => &mission::TWO_MASTERS,
    }
}
