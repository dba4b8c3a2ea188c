//! The files as a strict reader takes them, against the dictionaries they describe.

mod content;
mod dcf;
mod fixture;
mod imported;
mod ini;
mod notes;
mod product;
mod readers;
mod reading;
mod refused;
mod values;
