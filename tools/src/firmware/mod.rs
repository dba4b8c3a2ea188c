//! Images for boards: `ecss-can build` and `ecss-can flash`.
//!
//! An image is one of this project ([`Role`]), or belongs to a package of the user.

pub mod build;
pub mod flash;
mod own;
mod role;

pub use role::Role;
