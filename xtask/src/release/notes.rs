//! Release notes: a section of the changelog.

use std::fs;
use std::path::Path;

use anyhow::Context;
use ecss_can_cli::images::support::{output, project};

const CHANGELOG: &str = "CHANGELOG.md";
const FILE: &str = "release-notes.md";

/// Returns the section of the changelog about a version, without its heading.
///
/// # Errors
/// When the changelog cannot be read, or has no text about this version.
pub fn section(version: &str) -> anyhow::Result<String> {
    let text =
        fs::read_to_string(project::path(CHANGELOG)).with_context(|| format!("cannot read {CHANGELOG}"))?;
    find(&text, version).with_context(|| {
        format!("{CHANGELOG} has no text below a heading \"## [{version}] - DATE\"; move there what is below \"Unreleased\"")
    })
}

/// Writes the release notes of a version into a folder.
///
/// # Errors
/// As [`section`]; when the file cannot be written.
pub fn write(version: &str, folder: &Path) -> anyhow::Result<()> {
    let file = folder.join(FILE);
    let text = format!("# ecss-can {version}\n\n{}\n", section(version)?);
    fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
    output::line(file.display())
}

fn find(changelog: &str, version: &str) -> Option<String> {
    let heading = format!("## [{version}] - ");
    let lines = changelog.lines().skip_while(|line| !line.starts_with(&heading)).skip(1);
    let section: Vec<&str> =
        lines.take_while(|line| !line.starts_with("## ") && !is_reference(line)).collect();
    Some(section.join("\n").trim().to_owned()).filter(|text| !text.is_empty())
}

/// Returns whether a line is the address of a version: `[0.2.0]: https://..`.
fn is_reference(line: &str) -> bool {
    line.starts_with('[') && line.contains("]: ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Changelog\n\n## [Unreleased]\n\n## [0.2.0] - 2026-11-30\n\n### Added\n\n- One.\n\n## [0.1.0] - 2026-11-25\n\nFirst.\n\n[0.1.0]: https://a\n";

    #[test]
    fn notes_are_the_text_below_the_heading_of_the_version() {
        assert_eq!(find(TEXT, "0.2.0").as_deref(), Some("### Added\n\n- One."));
        assert_eq!(find(TEXT, "0.1.0").as_deref(), Some("First."));
    }

    #[test]
    fn version_without_text_has_no_notes() {
        assert_eq!(find(TEXT, "0.3.0"), None);
        assert_eq!(find(TEXT, "Unreleased"), None);
    }
}
