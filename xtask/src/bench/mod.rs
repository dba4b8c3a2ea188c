//! `cargo xtask bench` and `cargo xtask sizes`: figures whose degradation by a change must be noticed.
//!
//! Figures are counts and virtual times of the twin, sizes, and instructions: the same code and compilers give the same
//! figures on every computer of a kind. Rows made of wall-clock times say so (`noisy`); only a ratio of two that ran in turns has a target.

mod areas;
mod callgrind;
mod clocks;
mod context;
mod figures;
mod page;
mod rig;
mod row;
mod share;
mod stored;
mod sweep;
mod table;
mod update;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use console::style;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::elf::Facts;
use ecss_can_cli::images::support::misuse::Misuse;
use ecss_can_cli::images::support::needs::{Need, provide};
use ecss_can_cli::images::support::output::{line, note, text, warn};
use ecss_can_cli::images::support::project;

pub use self::areas::clock_errors;
use self::areas::{ALL, Area};
use self::context::{Context, FLOWN};
use self::row::Row;
use self::stored::Stored;

/// Name of the command.
const COMMAND: &str = "bench";

/// Command line of `bench`.
#[derive(Args, Debug)]
#[command(after_help = areas_help())]
pub struct Options {
    /// Measure these areas only [default: all]
    #[arg(long, value_name = "AREA", value_delimiter = ',', value_parser = area_names())]
    only: Vec<String>,

    /// Install valgrind where the area "instructions" needs it: by apt-get, as root on Debian
    #[arg(long)]
    install: bool,

    #[command(flatten)]
    output: Output,
}

/// Command line of `sizes`.
#[derive(Args, Debug)]
pub struct SizesOptions {
    /// How many of the biggest symbols of each image to print
    #[arg(long, value_name = "N", default_value_t = 15, allow_negative_numbers = true)]
    symbols: usize,

    #[command(flatten)]
    output: Output,
}

/// Destination of the figures, and their comparison.
#[derive(Args, Debug)]
struct Output {
    /// Exit with 1 when a row is more than 3 % off its stored value, one of size, instructions or rx is more than 3 % worse than its
    /// best value and than the value accepted with a reason, a target does not hold that held before, or one does not hold
    /// without a reason; figures of images by another compiler only warn
    #[arg(long, conflicts_with = "store")]
    check: bool,

    /// Store the rows of this run in xtask/bench/stored.json, with which --check compares, and in the pages that show them
    #[arg(long)]
    store: bool,

    /// Where the rows of this run go [default: target/bench/summary.json of the project]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Output {
    /// Returns the file of the rows.
    fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| project::target("bench/summary.json"))
    }
}

fn area_names() -> PossibleValuesParser {
    PossibleValuesParser::new(ALL.iter().map(|area| area.name))
}

fn areas_help() -> String {
    let lines = ALL.iter().map(|area| format!("  {:<12} {}\n", area.name, area.about));
    format!("Areas:\n{}", lines.collect::<String>())
}

/// Measures, prints, and writes the summary.
///
/// # Errors
/// When something cannot be measured or written, or, asked to check, when a target does not hold.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let wanted = |area: &&Area| options.only.is_empty() || options.only.iter().any(|name| name == area.name);
    let areas: Vec<_> = ALL.iter().filter(wanted).collect();
    // Checked before the first measurement, so that a long run does not fail at a missing program.
    let needs: Vec<Need> = areas.iter().flat_map(|area| area.needs).copied().collect();
    provide(&needs, options.install, "cargo xtask bench --install")?;
    let context = Context::default();
    let measured = measure(COMMAND, &context, &areas, &options.output)?;
    judge(&measured, &options.output)
}

/// Measures only the area `size`, then lists the largest symbols.
///
/// # Errors
/// As [`run`].
pub fn sizes(options: &SizesOptions) -> anyhow::Result<()> {
    let context = Context::default();
    let areas: Vec<_> = ALL.iter().filter(|area| area.name == "size").collect();
    let measured = measure("sizes", &context, &areas, &options.output)?;
    if options.symbols > 0 {
        text(areas::biggest_symbols(&context, options.symbols)?)?;
    }
    judge(&measured, &options.output)
}

/// Measurements of a run.
struct Measured {
    /// Rows of each area.
    areas: Vec<(String, Vec<Row>)>,
    /// Compiler of the images.
    compiler: String,
}

/// Measures, prints and writes.
fn measure(
    command: &'static str,
    context: &Context,
    areas: &[&Area],
    output: &Output,
) -> anyhow::Result<Measured> {
    let out = output.out();
    // A long run must not fail at a file that cannot be written.
    check_writable(command, &out)?;
    let mut measured = Measured { areas: Vec::new(), compiler: compiler(context)? };
    for area in areas {
        note(format_args!("{} {}: {}", style("measuring").dim().for_stderr(), area.name, area.about));
        let rows = (area.measure)(context)?;
        table::lines(area.name, &rows).iter().try_for_each(line)?;
        measured.areas.push((area.name.to_owned(), rows));
    }
    let json = serde_json::to_string_pretty(&stored::as_json(&measured)?)?;
    fs::write(&out, format!("{json}\n")).with_context(|| format!("cannot write {}", out.display()))?;
    let compiler = &measured.compiler;
    line(format_args!("\nimages by {compiler}; rows written to {}", project::shown(&out)))?;
    Ok(measured)
}

/// Makes the folder of the summary, and checks that the summary can be written.
fn check_writable(command: &'static str, path: &Path) -> anyhow::Result<()> {
    let refuse = |cause: &dyn std::fmt::Display| {
        let value = path.display();
        let text =
            format!("invalid value '{value}' for '--out <FILE>': {cause}; give a file that can be written");
        Misuse::of(command, text)
    };
    if path.is_dir() {
        return Err(refuse(&"it is a directory").into());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    project::make_writable(folder).map_err(|cause| refuse(&cause).into())
}

/// Compares the rows with the stored ones, or stores them.
fn judge(Measured { areas, compiler }: &Measured, output: &Output) -> anyhow::Result<()> {
    let path = stored::path();
    if output.store {
        let mut stored = if path.exists() { Stored::read(&path)? } else { Stored::default() };
        let commit = commit();
        areas.iter().try_for_each(|(area, rows)| stored.replace(area, rows, compiler, &commit))?;
        stored.write(&path)?;
        page::update(&stored)?;
        return figures::update(&stored);
    }
    if output.check {
        let stored = Stored::read(&path)?;
        let findings: Vec<String> =
            areas.iter().flat_map(|(area, rows)| stored.findings(area, rows)).collect();
        return match stored.compiler() {
            _ if findings.is_empty() => Ok(()),
            Some(before) if before != compiler => {
                findings.iter().for_each(warn);
                warn(format_args!("stored rows are of images by {before}, these are by {compiler}"));
                Ok(())
            }
            _ => bail!("{} (cargo xtask bench --store stores the rows of a run)", findings.join("; ")),
        };
    }
    let broken = areas.iter().flat_map(|(area, rows)| {
        let broken = rows.iter().filter(|row| row.holds == Some(false));
        broken.map(move |row| format!("{area}.{}", row.name))
    });
    let broken: Vec<String> = broken.collect();
    if !broken.is_empty() {
        warn(format_args!("targets that do not hold: {}", broken.join(", ")));
    }
    Ok(())
}

/// Returns the checked-out commit, or a word if git does not know it.
fn commit() -> String {
    let arguments = ["rev-parse", "--short=8", "HEAD"];
    let output = Command::new("git").args(arguments).current_dir(project::path("")).output();
    match output {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).trim().to_owned(),
        _ => "unknown".to_owned(),
    }
}

fn compiler(context: &Context) -> anyhow::Result<String> {
    let images = context.images(&FLOWN, Profile::Standard)?;
    Ok(Facts::read(&images.slave)?.compiler.unwrap_or_else(|| "unknown".into()))
}
