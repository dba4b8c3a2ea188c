//! The text of a description, before its values are checked.

use std::collections::BTreeMap;

use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Board {
    pub name: String,
    pub chip: String,
    pub oscillator: Oscillator,
    pub can1: Can,
    pub can2: Can,
    pub capture: Option<Capture>,
    pub pulse: Option<String>,
    pub straps: Option<Straps>,
    #[serde(default)]
    pub leds: BTreeMap<String, String>,
    pub transceiver_switch: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Oscillator {
    pub frequency: String,
    pub kind: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Can {
    pub rx: String,
    pub tx: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Capture {
    pub can1: String,
    pub can2: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Straps {
    pub bits: [String; 4],
    pub parity: String,
    pub maintenance: Option<String>,
}
