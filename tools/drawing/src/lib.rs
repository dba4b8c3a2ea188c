//! Pictures as SVG files, and as parts of a page.
//!
//! A [`Picture`](picture::Picture) is a list of elements, each painted by its classes ([`paint`]). [`scale`] maps
//! values to places, and [`labels`] keeps labels apart. [`chart`] and [`histogram`] draw measurements of any origin,
//! and [`waveform`] draws what a simulated bus recorded.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod chart;
pub mod histogram;
pub mod key;
pub mod labels;
pub mod layout;
pub mod paint;
pub mod picture;
pub mod scale;
pub mod waveform;
