//! Colours, lines and letters of the pictures, by class.
//!
//! Each element carries its paint as attributes, on light ground: that is what every renderer of SVG understands. Style
//! sheets with variables or media queries are for browsers alone, so the only one ([`dark`]) repeats colours for dark
//! ground, and a renderer that skips it still draws the picture as it should be.

use std::fmt::Write;

use Look::{Fill, Is, Stroke};

/// Letters of all pictures: attributes of the whole.
pub const FONT: [(&str, &str); 2] =
    [("font-family", "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif"), ("font-size", "13")];

/// A colour on light and on dark ground.
#[derive(Clone, Copy, Debug)]
pub struct Ink(pub &'static str, pub &'static str);

/// The ground of a picture.
const PAPER: Ink = Ink("#ffffff", "#161b22");
/// Letters.
pub const BLACK: Ink = Ink("#1b2330", "#e6eaf0");
/// Letters of secondary importance.
pub const GREY: Ink = Ink("#667085", "#98a3b3");
/// Bars.
pub const BLUE: Ink = Ink("#2563b0", "#6aa9f0");

/// A property of a class.
#[derive(Clone, Copy, Debug)]
pub enum Look {
    /// Colour of an area or of letters.
    Fill(Ink),
    /// Colour of a line.
    Stroke(Ink),
    /// An attribute of SVG and its value, the same on each ground.
    Is(&'static str, &'static str),
}

/// Nothing is filled.
const LINE: Look = Is("fill", "none");
/// Width of thin lines.
const THIN: Look = Is("stroke-width", "1");

/// A class and its properties.
pub type Class = (&'static str, &'static [Look]);

/// Classes that pictures of any subject use. Colours of lines have their names.
pub const BASE: &[Class] = &[
    ("paper", &[Fill(PAPER)]),
    ("lane", &[Fill(Ink("#f5f7fa", "#1b212a"))]),
    ("grid", &[Stroke(Ink("#e4e7ec", "#2b323c")), THIN]),
    ("label", &[Fill(BLACK)]),
    ("soft", &[Fill(GREY), Is("font-size", "12")]),
    ("end", &[Is("text-anchor", "end")]),
    ("middle", &[Is("text-anchor", "middle")]),
    ("bar", &[Fill(BLUE)]),
    ("black", &[LINE, Stroke(Ink("#1b2330", "#f0f3f7")), THIN]),
    ("cyan", &[LINE, Stroke(Ink("#0b7fab", "#4cc3f0")), THIN]),
    ("orange", &[LINE, Stroke(Ink("#d9480f", "#ff8f4d")), THIN]),
    ("pink", &[LINE, Stroke(Ink("#a8326e", "#e884b4")), THIN]),
    ("blue", &[LINE, Stroke(Ink("#1d6fd8", "#5ea6ff")), THIN]),
    ("sky", &[LINE, Stroke(Ink("#6aa5e8", "#3a6ea8")), THIN]),
    ("amber", &[LINE, Stroke(Ink("#b9770e", "#e5a83b")), THIN]),
    ("teal", &[LINE, Stroke(Ink("#0f8577", "#35b8a6")), THIN]),
    ("violet", &[LINE, Stroke(Ink("#9a5fc9", "#b98be0")), THIN]),
    ("green", &[LINE, Stroke(Ink("#4c9a2a", "#79c257")), THIN]),
    ("grey", &[LINE, Stroke(Ink("#98a2b3", "#667085")), THIN]),
    ("thick", &[Is("stroke-width", "2")]),
    ("dashed", &[Is("stroke-dasharray", "5 3")]),
];

impl Look {
    /// Name and value of its attribute.
    fn attribute(self) -> (&'static str, &'static str) {
        match self {
            Fill(Ink(light, _)) => ("fill", light),
            Stroke(Ink(light, _)) => ("stroke", light),
            Is(name, value) => (name, value),
        }
    }

    /// Its property on dark ground, where that is another one.
    fn dark(self) -> Option<(&'static str, &'static str)> {
        match self {
            Fill(Ink(_, dark)) => Some(("fill", dark)),
            Stroke(Ink(_, dark)) => Some(("stroke", dark)),
            Is(..) => None,
        }
    }
}

/// The classes of a picture, in lists.
pub type Palette = &'static [&'static [Class]];

/// Attributes of an element with these classes, `class` among them; of two classes the later wins.
pub fn attributes(palette: Palette, classes: &str) -> Vec<(&'static str, String)> {
    let mut found = vec![("class", classes.to_owned())];
    for class in classes.split_whitespace() {
        let looks = palette.iter().copied().flatten().find(|(name, _)| *name == class);
        for (name, value) in looks.into_iter().flat_map(|(_, looks)| *looks).map(|look| look.attribute()) {
            found.retain(|(before, _)| *before != name);
            found.push((name, value.to_owned()));
        }
    }
    found
}

/// A style sheet for browsers that want dark ground; empty where no class has another colour on it.
pub fn dark(palette: Palette) -> String {
    let mut rules = String::new();
    for (class, looks) in palette.iter().copied().flatten() {
        let colours: String = looks
            .iter()
            .filter_map(|look| look.dark())
            .map(|(name, value)| format!(" {name}: {value};"))
            .collect();
        if !colours.is_empty() {
            let _ = writeln!(rules, "  svg.chart .{class} {{{colours} }}");
        }
    }
    if rules.is_empty() { rules } else { format!("@media (prefers-color-scheme: dark) {{\n{rules}}}\n") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_class_wins() {
        let expected =
            [("class", "blue thick"), ("fill", "none"), ("stroke", "#1d6fd8"), ("stroke-width", "2")];
        assert_eq!(attributes(&[BASE], "blue thick"), expected.map(|(name, value)| (name, value.to_owned())));
    }

    #[test]
    fn dark_sheet_has_colours_only() {
        let sheet = dark(&[BASE]);
        assert!(sheet.contains("  svg.chart .blue { stroke: #5ea6ff; }\n"), "{sheet}");
        assert!(!sheet.contains("thick") && !sheet.contains("var("), "{sheet}");
    }
}
