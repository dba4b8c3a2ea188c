//! Keys of a mission file. A value keeps its place in the file, so that an error can name its line.

use serde::Deserialize;
use toml::{Spanned, Value};

/// A mission file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct File {
    /// Board of all images, by name or folder.
    pub board: Option<Spanned<String>>,
    /// Part of the boards with own images.
    pub chip: Option<Spanned<String>>,
    /// Oscillator of the boards with own images.
    pub oscillator: Option<Spanned<String>>,
    /// Mission profile of the shipped images.
    pub profile: Option<Spanned<String>>,
    /// Length of the flight, virtual seconds.
    pub seconds: Option<Spanned<f64>>,
    /// Seed of what is not given.
    pub seed: Option<Spanned<i64>>,
    /// Number of shipped slaves.
    pub slaves: Option<Spanned<i64>>,
    /// Number of shipped minimal slaves.
    pub minimal: Option<Spanned<i64>>,
    /// Number of those with one controller.
    pub one_controller: Option<Spanned<i64>>,
    /// Time of the demonstration's cut, or "never".
    pub cut_at: Option<Spanned<Value>>,
    /// Boards, in the order of the cable.
    #[serde(default)]
    pub node: Vec<Node>,
    /// Faults and their ends.
    #[serde(default)]
    pub fault: Vec<Fault>,
    /// What must hold.
    #[serde(default)]
    pub criterion: Vec<Criterion>,
}

/// A board.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Node {
    /// Node-ID.
    pub id: Spanned<i64>,
    /// ELF file.
    pub image: Option<Spanned<String>>,
    /// Package that is built.
    pub package: Option<Spanned<String>>,
    /// Cargo.toml of that package or of its workspace.
    pub manifest: Option<Spanned<String>>,
    /// Program of that package.
    pub program: Option<Spanned<String>>,
    /// Data sheet.
    pub eds: Option<Spanned<String>>,
    /// Metres from the master's end.
    pub place: Option<Spanned<f64>>,
    /// Metres from the board before in the file.
    pub cable: Option<Spanned<f64>>,
    /// Error of the crystal, parts per million.
    pub crystal: Option<Spanned<f64>>,
    /// Drift of the crystal, parts per million per second.
    pub drift: Option<Spanned<f64>>,
    /// Time of the power-on, virtual seconds.
    pub power_on: Option<Spanned<f64>>,
}

/// A fault, or the end of one.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Fault {
    /// Virtual seconds.
    pub at: Spanned<f64>,
    /// Command of `ecss-can twin`.
    pub command: Spanned<String>,
}

/// What must hold for nodes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Criterion {
    /// The nodes; all slaves without it.
    pub nodes: Option<Spanned<Vec<i64>>>,
    /// Virtual second at which they are operational.
    pub operational_at: Option<Spanned<f64>>,
    /// Whether they are operational at the end.
    pub operational_at_end: Option<Spanned<bool>>,
    /// Longest fail-over, seconds.
    pub fail_over_within: Option<Spanned<f64>>,
    /// Largest error of a clock, microseconds.
    pub clock_within_us: Option<Spanned<f64>>,
    /// Longest time to an answer, seconds.
    pub answer_within: Option<Spanned<f64>>,
}
