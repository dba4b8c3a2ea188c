//! Figures in sentences of the pages that new readers read first, made from stored values.
//!
//! A figure is between two invisible markers, and `cargo xtask bench --store` writes it:
//!
//! ```text
//! <!--=size.pyboard-v11.slave.flash:KiB.1-->84.6<!--.-->
//! ```
//!
//! The first marker has the name of the figure, and after a colon the unit and the number of decimals, if these are not
//! the stored ones. The name is that of
//!
//! * a row of `stored.json`,
//! * a number of the tables of requirements: `requirements.software`,
//! * a search of `tests/search/states.txt`: `states.2.3`, with two masters and three faults,
//! * or an entry of `results.json`: the result of a longer run, or a value in a test. These are written manually after
//!   the run.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, bail};
use ecss_can_cli::images::support::project;
use serde::Deserialize;

use super::page::rewrite;
use super::stored::Stored;
use super::table::grouped;
use crate::compliance;

/// The pages with such figures. No other number on them may have a unit.
const PAGES: [&str; 6] = [
    "README.md",
    "SECURITY.md",
    "docs/budget.md",
    "docs/comparison.md",
    "docs/limits.md",
    "shared/canopen/README.md",
];

const START: &str = "<!--=";
const START_ENDS: &str = "-->";
const END: &str = "<!--.-->";

/// Clock of the boards, MHz, which converts cycles to microseconds.
const CLOCK_MHZ: f64 = 168.0;

/// An entry of `results.json`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    value: f64,
    unit: String,
    /// The command of the run, or the file whose test or constant holds the value.
    source: String,
    /// The commit of the run.
    commit: Option<String>,
}

/// A value with its unit.
type Figure = (f64, String);

/// All figures by name.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    all: BTreeMap<String, Figure>,
}

impl Figures {
    /// Reads the stored values in addition to the rows.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn with(stored: &Stored) -> anyhow::Result<Figures> {
        let mut all = BTreeMap::new();
        all.extend(stored.rows().filter_map(|(name, row)| {
            Some((name.to_owned(), (row["value"].as_f64()?, row["unit"].as_str()?.to_owned())))
        }));
        let read = |path: &str| {
            fs::read_to_string(project::path(path)).with_context(|| format!("cannot read {path}"))
        };
        let results = results(&read("xtask/bench/results.json")?)?;
        all.extend(results.into_iter().map(|(name, entry)| (name, (entry.value, entry.unit))));
        all.extend(compliance::numbers().map(|(name, number)| {
            (format!("requirements.{name}"), (number as f64, "requirements".to_owned()))
        }));
        all.extend(searches(&read("tests/search/states.txt")?)?);
        Ok(Figures { all })
    }

    /// Returns the text of a figure: `size.pyboard-v11.slave.flash:KiB.1` is `84.6`.
    fn text(&self, marker: &str) -> anyhow::Result<String> {
        let (name, form) = marker.split_once(':').map_or((marker, None), |(name, form)| (name, Some(form)));
        let (value, unit) = self.all.get(name).with_context(|| format!("there is no figure '{name}'"))?;
        let Some(form) = form else { return Ok(grouped(&value.to_string(), ',')) };
        let (wanted, decimals) = form
            .split_once('.')
            .with_context(|| format!("'{form}' is not unit and decimals, as in 'KiB.1'"))?;
        let decimals: usize =
            decimals.parse().with_context(|| format!("'{decimals}' is no number of decimals"))?;
        let scale =
            scale(unit, wanted).with_context(|| format!("'{name}' has the unit '{unit}', not '{wanted}'"))?;
        Ok(grouped(&format!("{:.decimals$}", value / scale), ','))
    }
}

/// Returns the factor from one unit to another.
fn scale(of: &str, wanted: &str) -> Option<f64> {
    Some(match (of, wanted) {
        _ if of == wanted => 1.0,
        ("bytes", "KiB") => 1_024.0,
        ("ns", "us") | ("ms", "s") => 1e3,
        ("ns", "ms") => 1e6,
        ("model_cycles", "us") => CLOCK_MHZ,
        _ => return None,
    })
}

fn results(text: &str) -> anyhow::Result<BTreeMap<String, Entry>> {
    let all: BTreeMap<String, Entry> = serde_json::from_str(text).context("cannot read results.json")?;
    for (name, Entry { source, commit, .. }) in &all {
        let is_run = source.starts_with("cargo ") && commit.is_some();
        if !is_run && !project::path(source).is_file() {
            bail!("the source of '{name}' is neither a command with its commit nor a file: {source}");
        }
    }
    Ok(all)
}

/// Returns the lines of a file of searches: masters, faults, states.
fn searches(text: &str) -> anyhow::Result<Vec<(String, Figure)>> {
    let search = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        [masters, faults, states] => {
            Ok((format!("states.{masters}.{faults}"), (states.parse()?, "states".to_owned())))
        }
        _ => bail!("'{line}' is not masters, faults and states"),
    };
    text.lines().map(search).collect()
}

/// Returns the page with the stored values of all its figures.
fn with_figures(page: &str, figures: &Figures) -> anyhow::Result<String> {
    let (mut text, mut rest) = (String::new(), page);
    while let Some((before, marked)) = rest.split_once(START) {
        let marker = marked.lines().next().unwrap_or_default();
        let (marker, _) = marker
            .split_once(START_ENDS)
            .with_context(|| format!("no '{START_ENDS}' follows '{START}{marker}'"))?;
        (_, rest) =
            marked.split_once(END).with_context(|| format!("no '{END}' follows '{START}{marker}'"))?;
        text.extend([before, START, marker, START_ENDS, &figures.text(marker)?, END]);
    }
    Ok(text + rest)
}

/// Writes the figures of all pages anew.
///
/// # Errors
/// When a page cannot be read or written, or names a figure that is not stored.
pub fn update(stored: &Stored) -> anyhow::Result<()> {
    let figures = Figures::with(stored)?;
    PAGES.iter().try_for_each(|page| rewrite(page, |text| with_figures(text, &figures)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::stored;

    /// Units of measured values. A number with one of them is a figure.
    const UNITS: [&str; 21] = [
        "B",
        "bytes",
        "KiB",
        "MiB",
        "kB",
        "MB",
        "ns",
        "us",
        "µs",
        "ms",
        "s",
        "min",
        "cycles",
        "%",
        "ppm",
        "states",
        "runs",
        "cases",
        "mutants",
        "instructions",
        "requirements",
    ];

    fn page(name: &str) -> String {
        fs::read_to_string(project::path(name)).unwrap()
    }

    fn repository() -> Figures {
        Figures::with(&Stored::read(&stored::path()).unwrap()).unwrap()
    }

    fn some() -> Figures {
        let figure = |value: f64, unit: &str| (value, unit.to_owned());
        let all = [
            ("flash", figure(86_584.0, "bytes")),
            ("cycles", figure(8_618.0, "model_cycles")),
            ("bound", figure(426_312.0, "ns")),
            ("states", figure(46_793_908.0, "states")),
        ];
        Figures { all: all.map(|(name, figure)| (name.to_owned(), figure)).into() }
    }

    /// Returns numbers with a unit outside figures and code. The words of a figure start with its marker.
    fn loose(page: &str) -> Vec<String> {
        let is_number = |word: &str| {
            word.starts_with(|letter: char| letter.is_ascii_digit())
                && !word.contains(|letter: char| letter.is_alphabetic())
        };
        let mut found = Vec::new();
        for line in page.lines().filter(|line| !line.starts_with("    ")) {
            let plain: String = line.split('`').step_by(2).collect();
            let words: Vec<&str> = plain
                .split_whitespace()
                .map(|word| word.trim_matches(|letter: char| !letter.is_alphanumeric() && letter != '%'))
                .collect();
            let pairs = words.windows(2).filter(|pair| is_number(pair[0]) && UNITS.contains(&pair[1]));
            found.extend(pairs.map(|pair| pair.join(" ")));
        }
        found
    }

    #[test]
    fn figures_are_shown_in_the_unit_of_their_marker() {
        for (marker, expected) in [
            ("flash", "86,584"),
            ("flash:KiB.1", "84.6"),
            ("flash:bytes.0", "86,584"),
            ("cycles", "8,618"),
            ("cycles:us.1", "51.3"),
            ("bound:ms.2", "0.43"),
            ("states", "46,793,908"),
        ] {
            assert_eq!(some().text(marker).unwrap(), expected, "{marker}");
        }
        for (marker, expected) in [
            ("ram", "there is no figure 'ram'"),
            ("flash:ms.1", "'flash' has the unit 'bytes', not 'ms'"),
            ("flash:KiB", "'KiB' is not unit and decimals, as in 'KiB.1'"),
        ] {
            assert_eq!(some().text(marker).unwrap_err().to_string(), expected);
        }
    }

    #[test]
    fn a_changed_digit_is_written_anew() {
        let right = "Flash: <!--=flash:KiB.1-->84.6<!--.--> KiB of <!--=flash-->86,584<!--.--> bytes.\n";
        assert_eq!(with_figures(right, &some()).unwrap(), right);
        let wrong = right.replace("84.6", "84.7");
        assert_eq!(with_figures(&wrong, &some()).unwrap(), right);
    }

    #[test]
    fn a_figure_without_its_end_is_refused() {
        for (page, expected) in [
            ("<!--=flash-->84.6 KiB\n", "no '<!--.-->' follows '<!--=flash'"),
            ("<!--=flash 84.6<!--.-->\n", "there is no figure 'flash 84.6<!--.'"),
        ] {
            assert_eq!(with_figures(page, &some()).unwrap_err().to_string(), expected);
        }
    }

    #[test]
    fn a_number_with_a_unit_outside_of_figures_is_found() {
        let page = "Slaves take <!--=flash:KiB.1-->84.6<!--.--> KiB, and 15.0 KiB of RAM (at most 20 ms).\n\n    wait 5 ms\n\nClause 8, `9 ms`.\n";
        assert_eq!(loose(page), ["15.0 KiB", "20 ms"]);
    }

    /// Given the pages and the stored values of the repository, then each figure is the stored one, and no other number
    /// has a unit.
    #[test]
    fn pages_have_the_stored_figures() {
        let figures = repository();
        for name in PAGES {
            let page = page(name);
            let expected = with_figures(&page, &figures).unwrap();
            let differs = page.lines().zip(expected.lines()).find(|(page, expected)| page != expected);
            assert_eq!(differs, None, "{name}: `cargo xtask bench --store` writes the figures");
            assert_eq!(loose(&page), [""; 0], "{name}: these are no figures of results.json or stored.json");
        }
    }

    #[test]
    fn an_entry_without_a_source_is_refused() {
        let entry = |source: &str| format!(r#"{{"a": {{"value": 1, "unit": "s", "source": "{source}"}}}}"#);
        assert!(results(&entry("README.md")).is_ok());
        for source in ["cargo test", "no/such/file"] {
            let error = results(&entry(source)).unwrap_err().to_string();
            assert!(error.contains("neither a command with its commit nor a file"), "{error}");
        }
    }

    #[test]
    fn each_entry_is_shown_on_a_page() {
        let pages: String = PAGES.map(page).concat();
        for name in results(&page("xtask/bench/results.json")).unwrap().keys() {
            assert!(pages.contains(&format!("{START}{name}")), "no page shows {name}");
        }
    }
}
