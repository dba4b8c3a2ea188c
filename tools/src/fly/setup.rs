//! Place, crystal and power-on time of a board, where they are given. The seed chooses the others.

use crate::images::support::node::{LAST, MASTER, Node};

/// Allowed places on a bus, metres from the master's end.
pub const PLACES_M: std::ops::RangeInclusive<f64> = 0.0..=1_000.0;

/// Allowed errors of a crystal, parts per million.
pub const CRYSTALS_PPM: std::ops::RangeInclusive<f64> = -200.0..=200.0;

/// What is given for a board.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setup {
    /// Position on both buses, metres from the master's end.
    pub place_m: Option<f64>,
    /// Error of the crystal at time zero, parts per million.
    pub crystal_ppm: Option<f64>,
    /// Constant drift of the crystal, parts per million per second, in the place of the change while the board warms up.
    pub drift_ppm_per_s: Option<f64>,
    /// Time of the first power-on, virtual seconds.
    pub power_on: Option<f64>,
}

/// A number of a node, as `--place` and `--crystal` have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeNumber {
    /// Node-ID.
    pub node: Node,
    /// The number.
    pub number: f64,
}

/// Reads the value of `--place`.
///
/// # Errors
/// A text with what is allowed.
pub fn place_m(text: &str) -> Result<NodeNumber, String> {
    node_number(text, &PLACES_M, "metres", "5=12.5")
}

/// Reads the value of `--crystal`.
///
/// # Errors
/// A text with what is allowed.
pub fn crystal_ppm(text: &str) -> Result<NodeNumber, String> {
    node_number(text, &CRYSTALS_PPM, "parts per million", "5=-20")
}

fn node_number(
    text: &str,
    range: &std::ops::RangeInclusive<f64>,
    unit: &str,
    example: &str,
) -> Result<NodeNumber, String> {
    let read = || {
        let (node, number) = text.split_once('=')?;
        let node = node.parse().ok().filter(|node| (MASTER..=LAST).contains(node))?;
        let number = number.parse().ok().filter(|number| range.contains(number))?;
        Some(NodeNumber { node, number })
    };
    read().ok_or_else(|| {
        format!(
            "allowed are a Node-ID of {MASTER} to {LAST}, '=', and {} to {} {unit}, for example {example}",
            range.start(),
            range.end()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_is_a_node_and_metres() {
        assert_eq!(place_m("5=12.5"), Ok(NodeNumber { node: 5, number: 12.5 }));
        assert_eq!(crystal_ppm("1=-20"), Ok(NodeNumber { node: 1, number: -20.0 }));
        for wrong in ["5", "0=1", "16=1", "5=-1", "5=1001", "5=NaN", "x=1"] {
            assert!(place_m(wrong).is_err_and(|error| error.contains("0 to 1000 metres")), "{wrong}");
        }
    }
}
