//! `cargo xtask test-all`: all tests, by tiers.

use std::num::NonZero;
use std::process::Command;

use anyhow::{Context, ensure};
use cargo_metadata::MetadataCommand;
use clap::{Args, ValueEnum};
use ecss_can_cli::images::support::needs::{
    CHROMIUM, LLD, LLVM, LOG2ASC, Need, PARALLEL, PYTHON, QEMU, TSHARK, provide,
};
use ecss_can_cli::images::support::project;

/// Tools of the tests of the third tier.
const NEEDS: [Need; 10] = [
    TSHARK,
    LOG2ASC,
    QEMU,
    LLVM,
    LLD,
    CHROMIUM,
    PARALLEL,
    PYTHON,
    Need::VirtualEnvironments,
    Need::PythonPackages,
];

/// The package of tests with third-party tools.
const SECOND: &str = "second";

/// Tests, by their needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tier {
    /// What `cargo test` runs: protocol, host worlds, wire, emulated boards, flights of two configurations of the images
    First,
    /// All else that needs cargo and the firmware toolchain alone
    Second,
    /// What needs tools of others: python-can, canopen, tshark, chromium ...
    Tools,
}

/// Command line of `test-all`.
#[derive(Args, Debug)]
pub struct Options {
    /// Run this tier; all tiers unless given
    #[arg(long, value_enum)]
    tier: Vec<Tier>,

    /// Install what is missing: programs by apt-get, as root on Debian; Python packages by pip into target/second/venv
    #[arg(long)]
    install: bool,

    /// Number of tests with tools of others that run at the same time [default: two for each core]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,

    /// Run the tests whose names contain this
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

/// Checks that the tools are installed, and runs the tests.
///
/// # Errors
/// When a tool is missing and must not or cannot be installed, or a test fails.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let has = |tier| options.tier.is_empty() || options.tier.contains(&tier);
    if has(Tier::Tools) {
        provide(&NEEDS, options.install, "cargo xtask test-all --install")?;
    }
    if has(Tier::First) {
        test(&[], &options.names)?;
    }
    if has(Tier::Second) {
        // All targets of the second package except that of the tools. The library has its own tests.
        let package =
            ["--package", SECOND, "--lib", "--test", "flights", "--test", "host", "--test", "layers"];
        test(&package, &options.names)?;
        let first = first_tier()?;
        let excluded = first.iter().map(String::as_str).chain([SECOND]);
        let others: Vec<&str> =
            ["--workspace"].into_iter().chain(excluded.flat_map(|name| ["--exclude", name])).collect();
        test(&others, &options.names)?;
    }
    if has(Tier::Tools) {
        // A test mostly waits, because its spacecraft runs in real time and uses less than half a core.
        let jobs = options.jobs.map_or_else(
            || std::thread::available_parallelism().map_or(2, |cores| 2 * cores.get()),
            NonZero::get,
        );
        let jobs = jobs.to_string();
        let threads = ["--test-threads", &jobs].map(str::to_owned);
        let behind: Vec<String> = threads.into_iter().chain(options.names.iter().cloned()).collect();
        test(&["--package", SECOND, "--test", "tools"], &behind)?;
    }
    Ok(())
}

/// Returns the names of the packages that `cargo test` tests.
fn first_tier() -> anyhow::Result<Vec<String>> {
    let metadata = MetadataCommand::new()
        .manifest_path(project::path("Cargo.toml"))
        .no_deps()
        .exec()
        .context("cargo metadata failed")?;
    let packages = metadata.workspace_default_packages();
    Ok(packages.into_iter().map(|package| package.name.to_string()).collect())
}

/// Runs `cargo test` with these arguments, and after `--` with those for the tests.
fn test(arguments: &[&str], behind: &[String]) -> anyhow::Result<()> {
    let mut cargo = Command::new("cargo");
    ecss_can_cli::images::clean(&mut cargo).arg("test").args(arguments);
    let status = cargo.arg("--").args(behind).current_dir(project::path("")).status();
    ensure!(status.context("cannot run cargo")?.success(), "a test failed, see above");
    Ok(())
}
