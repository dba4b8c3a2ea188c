//! Colours of a waveform's picture. It brings its own paper, so that it looks the same on light and on dark ground.

use crate::paint::Look::{self, Is};
use crate::paint::{Class, Palette};

const BLACK: Look = Is("fill", "#1b2330");
const WHITE: &str = "#ffffff";
const BLUE: &str = "#2563b0";
const SLATE: &str = "#3b4454";
const RED: &str = "#c4232f";
const VIOLET: &str = "#9333ea";
const LIGHT: &str = "#98a2b3";

const SEMIBOLD: Look = Is("font-weight", "600");
const ROUND: Look = Is("stroke-linejoin", "round");
const MIDDLE: Look = Is("text-anchor", "middle");
const END: Look = Is("text-anchor", "end");
const LINE: Look = Is("fill", "none");

/// Classes of the picture.
pub(super) const PALETTE: Palette = &[CLASSES, FIELDS];

const CLASSES: &[Class] = &[
    ("paper", &[Is("fill", WHITE), Is("stroke", "#d0d5dd"), Is("rx", "8")]),
    ("title", &[BLACK, Is("font-size", "15"), SEMIBOLD]),
    ("node", &[BLACK, Is("font-size", "13"), SEMIBOLD]),
    ("soft", &[Is("fill", "#667085"), Is("font-size", "11")]),
    ("middle", &[MIDDLE]),
    ("end", &[END]),
    ("grid", &[Is("stroke", "#e9ecf1")]),
    ("zero", &[Is("stroke", LIGHT)]),
    ("name", &[BLACK, Is("font-size", "10.5"), MIDDLE]),
    ("narrow", &[BLACK, Is("font-size", "8.5"), MIDDLE]),
    ("stuff", &[Is("fill", "#f59e0b"), Is("fill-opacity", "0.3")]),
    ("digit", &[Is("fill", "#475467"), Is("font-size", "9"), MIDDLE]),
    ("stuffed", &[Is("fill", "#b45309"), Is("font-weight", "bold")]),
    ("tx", &[LINE, Is("stroke", BLUE), Is("stroke-width", "1.8"), ROUND]),
    ("rx", &[LINE, Is("stroke", SLATE), Is("stroke-width", "1.5"), ROUND]),
    ("sends", &[Is("fill", BLUE), Is("font-size", "10"), END]),
    ("sees", &[Is("fill", SLATE), Is("font-size", "10"), END]),
    ("drives", &[Is("fill", BLUE), Is("fill-opacity", "0.13")]),
    ("sample", &[Is("fill", "#0f8577")]),
    ("flip", &[LINE, Is("stroke", RED), Is("stroke-width", "1.8")]),
    ("resync", &[Is("fill", VIOLET), Is("fill-opacity", "0.55")]),
    ("leader", &[Is("stroke", LIGHT), Is("stroke-dasharray", "2 2")]),
    ("leader-error", &[Is("stroke", RED)]),
    ("leader-shift", &[Is("stroke", VIOLET)]),
    (
        "note",
        &[
            Is("fill", "#344054"),
            Is("font-size", "11"),
            Is("stroke", WHITE),
            Is("stroke-width", "3"),
            ROUND,
            Is("paint-order", "stroke"),
        ],
    ),
    ("note-error", &[Is("fill", "#b01c28"), SEMIBOLD]),
    ("note-shift", &[Is("fill", "#7e22ce")]),
];

/// Fields of a frame, and what is between frames.
const FIELDS: &[Class] = &[
    ("band", &[Is("stroke", WHITE), Is("stroke-width", "1")]),
    ("sof", &[Is("fill", "#c9ced8")]),
    ("id", &[Is("fill", "#c7dcfa")]),
    ("control", &[Is("fill", "#ddd7f6")]),
    ("dlc", &[Is("fill", "#c6e8e2")]),
    ("data", &[Is("fill", "#fdecb8")]),
    ("crc", &[Is("fill", "#d7e8bd")]),
    ("fixed", &[Is("fill", "#e6e9ee")]),
    ("ack", &[Is("fill", "#a9dfb8")]),
    ("between", &[Is("fill", "#f2f4f7")]),
    ("flag", &[Is("fill", "#f2918a")]),
    ("passive", &[Is("fill", "#fbd3cf")]),
    ("overload", &[Is("fill", "#eeb2dd")]),
    ("superposition", &[Is("fill", "#f9c29b")]),
    ("delimiter", &[Is("fill", "#f6e0da")]),
];
