//! Colours and letters of a flight's pictures, by class.

use drawing::paint::Look::{Fill, Is, Stroke};
use drawing::paint::{BASE, BLUE, Class, Ink, Look, Palette};

/// Classes of the pictures of a flight.
pub const PALETTE: Palette = &[BASE, CLASSES];

const RED: Ink = Ink("#c4232f", "#ff6b6b");
const PURPLE: Ink = Ink("#8b3fa8", "#cf8fe8");

const BOLD: Look = Is("font-weight", "bold");
const THICK: Look = Is("stroke-width", "2");

const CLASSES: &[Class] = &[
    ("active", &[Fill(Ink("#e3edf9", "#1d2f47"))]),
    ("bus-nominal", &[Fill(BLUE), Is("font-size", "15"), BOLD]),
    ("bus-redundant", &[Fill(PURPLE), Is("font-size", "15"), BOLD]),
    ("cut-label", &[Fill(RED), BOLD]),
    ("switch-label", &[Fill(PURPLE), BOLD]),
    ("in-bar", &[Fill(Ink("#13251b", "#07130c")), Is("font-size", "12")]),
    ("cut", &[Stroke(RED), THICK, Is("stroke-dasharray", "5 3")]),
    ("switch", &[Stroke(PURPLE), THICK]),
    ("phase-off", &[Fill(Ink("#eaecf0", "#242b35"))]),
    ("phase-starting", &[Fill(Ink("#c3c9d3", "#475264"))]),
    ("phase-standby", &[Fill(Ink("#9db8e6", "#3f5f96"))]),
    ("phase-pre-operational", &[Fill(Ink("#f2b84b", "#d99c2b"))]),
    ("phase-operational", &[Fill(Ink("#5bb381", "#3f9c69"))]),
    ("phase-stopped", &[Fill(Ink("#e0705f", "#c95a4b"))]),
    ("phase-silent", &[Fill(Ink("#a03b5c", "#8a3350"))]),
    ("on-nominal", &[Fill(BLUE)]),
    ("on-redundant", &[Fill(PURPLE)]),
];
