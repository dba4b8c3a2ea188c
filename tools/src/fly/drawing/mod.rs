//! Pictures as SVG files, and as parts of a page.
//!
//! A [`Picture`] is a list of elements, each painted by its classes ([`paint`]). A [`Scale`] maps values to positions,
//! and [`labels`] keeps labels apart. [`chart`] and [`histogram`] draw measurements of any origin, and [`waveform`]
//! draws what a simulated bus recorded.

pub mod chart;
pub mod histogram;
pub mod key;
pub mod labels;
mod layout;
pub mod paint;
mod picture;
mod scale;
pub mod waveform;

pub use layout::{LETTERS, Layout, text_width};
pub use picture::Picture;
pub use scale::{Range, Scale};
