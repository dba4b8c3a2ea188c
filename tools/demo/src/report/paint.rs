//! Colours, lines and letters of the pictures, by class.
//!
//! Each element carries its paint as attributes, on light ground: that is what every renderer of SVG understands. Style
//! sheets with variables or media queries are for browsers alone, so the only one ([`DARK`]) repeats colours for dark
//! ground, and a renderer that skips it still draws the picture as it should be.

use std::fmt::Write;

use Look::{Anchor, Bold, Dash, Fill, NoFill, Size, Stroke, Width};

/// Letters of all pictures: attributes of the whole.
pub const FONT: [(&str, &str); 2] =
    [("font-family", "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif"), ("font-size", "13")];

/// A colour on light and on dark ground.
#[derive(Clone, Copy, Debug)]
struct Ink(&'static str, &'static str);

const PAPER: Ink = Ink("#ffffff", "#161b22");
const INK: Ink = Ink("#1b2330", "#e6eaf0");
const SOFT: Ink = Ink("#667085", "#98a3b3");
const CUT: Ink = Ink("#c4232f", "#ff6b6b");
const NOMINAL: Ink = Ink("#2563b0", "#6aa9f0");
const REDUNDANT: Ink = Ink("#8b3fa8", "#cf8fe8");

/// A property of a class.
#[derive(Clone, Copy, Debug)]
enum Look {
    Fill(Ink),
    NoFill,
    Stroke(Ink),
    /// Of a stroke, in SVG units.
    Width(&'static str),
    Dash(&'static str),
    /// Height of letters, in SVG units.
    Size(&'static str),
    Bold,
    /// Where the place of a text is in it.
    Anchor(&'static str),
}

/// What each class looks like; of two classes of one element the later wins.
const CLASSES: &[(&str, &[Look])] = &[
    ("paper", &[Fill(PAPER)]),
    ("lane", &[Fill(Ink("#f5f7fa", "#1b212a"))]),
    ("active", &[Fill(Ink("#e3edf9", "#1d2f47"))]),
    ("grid", &[Stroke(Ink("#e4e7ec", "#2b323c")), Width("1")]),
    ("label", &[Fill(INK)]),
    ("soft", &[Fill(SOFT), Size("12")]),
    ("bus-nominal", &[Fill(NOMINAL), Size("15"), Bold]),
    ("bus-redundant", &[Fill(REDUNDANT), Size("15"), Bold]),
    ("cut-label", &[Fill(CUT), Bold]),
    ("switch-label", &[Fill(REDUNDANT), Bold]),
    ("in-bar", &[Fill(Ink("#13251b", "#07130c")), Size("12")]),
    ("end", &[Anchor("end")]),
    ("middle", &[Anchor("middle")]),
    ("cut", &[Stroke(CUT), Width("2"), Dash("5 3")]),
    ("switch", &[Stroke(REDUNDANT), Width("2")]),
    ("network", &[NoFill, Stroke(Ink("#1b2330", "#f0f3f7")), Width("2")]),
    ("boot-up", &[NoFill, Stroke(Ink("#0b7fab", "#4cc3f0")), Width("2")]),
    ("emergency", &[NoFill, Stroke(Ink("#d9480f", "#ff8f4d")), Width("2")]),
    ("sdo", &[NoFill, Stroke(Ink("#a8326e", "#e884b4")), Width("1")]),
    ("master", &[NoFill, Stroke(Ink("#1d6fd8", "#5ea6ff")), Width("1")]),
    ("slave", &[NoFill, Stroke(Ink("#6aa5e8", "#3a6ea8")), Width("1")]),
    ("time", &[NoFill, Stroke(Ink("#b9770e", "#e5a83b")), Width("1")]),
    ("command", &[NoFill, Stroke(Ink("#0f8577", "#35b8a6")), Width("1")]),
    ("request", &[NoFill, Stroke(Ink("#9a5fc9", "#b98be0")), Width("1")]),
    ("reply", &[NoFill, Stroke(Ink("#4c9a2a", "#79c257")), Width("1")]),
    ("other", &[NoFill, Stroke(Ink("#98a2b3", "#667085")), Width("1")]),
    ("close-up", &[Width("2")]),
    ("thin", &[Width("1")]),
    ("dashed", &[Dash("5 3")]),
    ("phase-off", &[Fill(Ink("#eaecf0", "#242b35"))]),
    ("phase-starting", &[Fill(Ink("#c3c9d3", "#475264"))]),
    ("phase-standby", &[Fill(Ink("#9db8e6", "#3f5f96"))]),
    ("phase-pre-operational", &[Fill(Ink("#f2b84b", "#d99c2b"))]),
    ("phase-operational", &[Fill(Ink("#5bb381", "#3f9c69"))]),
    ("phase-stopped", &[Fill(Ink("#e0705f", "#c95a4b"))]),
    ("phase-silent", &[Fill(Ink("#a03b5c", "#8a3350"))]),
    ("bar", &[Fill(NOMINAL)]),
    ("on-nominal", &[Fill(NOMINAL)]),
    ("on-redundant", &[Fill(REDUNDANT)]),
];

impl Look {
    /// Name and value of its attribute.
    fn attribute(self) -> (&'static str, &'static str) {
        match self {
            Fill(Ink(light, _)) => ("fill", light),
            NoFill => ("fill", "none"),
            Stroke(Ink(light, _)) => ("stroke", light),
            Width(width) => ("stroke-width", width),
            Dash(dash) => ("stroke-dasharray", dash),
            Size(size) => ("font-size", size),
            Bold => ("font-weight", "bold"),
            Anchor(anchor) => ("text-anchor", anchor),
        }
    }

    /// Its property on dark ground, if that is another one.
    fn dark(self) -> Option<(&'static str, &'static str)> {
        match self {
            Fill(Ink(_, dark)) => Some(("fill", dark)),
            Stroke(Ink(_, dark)) => Some(("stroke", dark)),
            _ => None,
        }
    }
}

/// Attributes of an element with these classes, `class` among them.
pub fn attributes(classes: &str) -> Vec<(&'static str, String)> {
    let mut found = vec![("class", classes.to_owned())];
    for class in classes.split_whitespace() {
        let looks = CLASSES.iter().find(|(name, _)| *name == class).map_or(&[][..], |(_, looks)| looks);
        for (name, value) in looks.iter().map(|look| look.attribute()) {
            found.retain(|(before, _)| *before != name);
            found.push((name, value.to_owned()));
        }
    }
    found
}

/// A style sheet for browsers that want dark ground.
pub fn dark() -> String {
    let mut sheet = String::from("@media (prefers-color-scheme: dark) {\n");
    for (class, looks) in CLASSES {
        let colours: String = looks
            .iter()
            .filter_map(|look| look.dark())
            .map(|(name, value)| format!(" {name}: {value};"))
            .collect();
        if !colours.is_empty() {
            let _ = writeln!(sheet, "  svg.chart .{class} {{{colours} }}");
        }
    }
    sheet + "}\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_class_wins() {
        let expected =
            [("class", "master close-up"), ("fill", "none"), ("stroke", "#1d6fd8"), ("stroke-width", "2")];
        assert_eq!(attributes("master close-up"), expected.map(|(name, value)| (name, value.to_owned())));
    }

    #[test]
    fn dark_sheet_has_colours_only() {
        let sheet = dark();
        assert!(sheet.contains("  svg.chart .master { stroke: #5ea6ff; }\n"), "{sheet}");
        assert!(!sheet.contains("close-up") && !sheet.contains("var("), "{sheet}");
    }
}
