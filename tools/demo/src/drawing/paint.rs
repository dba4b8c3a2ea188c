//! Colours, lines and letters of the pictures, by class.
//!
//! A [`Sheet`] is a file with a class per line, `name { attribute: value; ... }`, with the names and values of SVG. A colour on
//! light ground has that on dark ground behind it, `light / dark`, where that is another one. Drawing panics
//! at a line of another shape.
//!
//! Each element carries its paint as attributes, on light ground: that is what every renderer of SVG understands. Style
//! sheets with variables or media queries are for browsers alone, so the only one ([`dark`]) repeats colours for dark
//! ground, and a renderer that skips it still draws the picture as it should be.

use std::fmt::Write;

/// Classes and their looks.
pub type Sheet = &'static str;

/// Classes that pictures of any subject use. Colours of lines have their names.
pub const BASE: Sheet = include_str!("base.sheet");

/// An attribute: name, value on light ground, value on dark ground where that is another one.
type Look = (&'static str, &'static str, Option<&'static str>);

/// The classes of sheets, and their looks.
fn classes(sheets: &[Sheet]) -> impl Iterator<Item = (&'static str, Vec<Look>)> {
    let lines = sheets.iter().flat_map(|sheet| sheet.lines()).filter(|line| !line.is_empty());
    lines.map(|line| {
        class(line).unwrap_or_else(|| panic!("`{line}`: expected `class {{ attribute: value }}`"))
    })
}

fn class(line: &'static str) -> Option<(&'static str, Vec<Look>)> {
    let (class, looks) = line.strip_suffix(" }")?.split_once(" { ")?;
    let look = |look: &'static str| {
        let (name, value) = look.split_once(": ")?;
        Some(value.split_once(" / ").map_or((name, value, None), |(light, dark)| (name, light, Some(dark))))
    };
    Some((class, looks.split("; ").map(look).collect::<Option<_>>()?))
}

/// Attributes of an element with these classes, `class` among them; of two classes the later wins.
pub(crate) fn attributes(sheets: &[Sheet], names: &str) -> Vec<(&'static str, String)> {
    let mut found = vec![("class", names.to_owned())];
    for class in names.split_whitespace() {
        let looks = classes(sheets).find(|(name, _)| *name == class).map(|(_, looks)| looks);
        for (name, light, _) in looks.unwrap_or_default() {
            found.retain(|(before, _)| *before != name);
            found.push((name, light.to_owned()));
        }
    }
    found
}

/// A style sheet for browsers that want dark ground; empty where no class has another colour on it.
pub fn dark(sheets: &[Sheet]) -> String {
    let mut rules = String::new();
    for (class, looks) in classes(sheets) {
        let dark = looks.into_iter().filter_map(|(name, _, dark)| Some(format!(" {name}: {};", dark?)));
        let colours: String = dark.collect();
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

    #[test]
    #[should_panic(expected = "`paper fill: red`: expected `class { attribute: value }`")]
    fn line_of_another_shape_panics() {
        attributes(&["paper fill: red"], "paper");
    }
}
