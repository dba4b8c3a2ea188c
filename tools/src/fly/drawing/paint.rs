//! Colours, lines and letters of the pictures, by class.
//!
//! A [`Sheet`] is a file with a class per line, `name { attribute: value; ... }`, with the names and values of SVG. A
//! colour for a light background may be followed by that for a dark one, `light / dark`. Drawing panics at a malformed
//! line.
//!
//! Each element has its colours for a light background as attributes, which every renderer of SVG supports. Style
//! sheets with variables or media queries are supported only by browsers. So the only one ([`dark`]) repeats colours
//! for a dark background, and a renderer that ignores it still draws the picture correctly.

use std::fmt::Write;

/// Classes and their attributes, as text.
pub type Sheet = &'static str;

/// Classes that pictures of any subject use. Colours of lines have their names.
pub const BASE: Sheet = include_str!("base.sheet");

/// An attribute: name, value on a light background, value on a dark background if different.
type Look = (&'static str, &'static str, Option<&'static str>);

/// Returns the classes of sheets with their attributes.
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

/// Returns the attributes of an element with these classes, including `class`. Later classes override earlier ones.
pub(in crate::fly) fn attributes(sheets: &[Sheet], names: &str) -> Vec<(&'static str, String)> {
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

/// Returns a style sheet for browsers in dark mode; empty if no class has another colour there.
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
