//! `cargo xtask test-tools`: the second tier of the tests, which needs tools of others, or images that take long to build.

use std::num::NonZero;
use std::process::Command;

use anyhow::{Context, ensure};
use clap::Args;

use firmware_images::support::needs::{
    CHROMIUM, LLD, LLVM, LOG2ASC, Need, PARALLEL, PYTHON, QEMU, TSHARK, provide,
};
use firmware_images::support::project;

/// What the tests of `tests/interop` use.
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

/// Command line of `test-tools`.
#[derive(Args, Debug)]
pub struct Options {
    /// Install what is missing: programs by apt-get, as root on Debian; Python packages by pip into target/interop/venv
    #[arg(long)]
    install: bool,

    /// Number of tests that run at the same time [default: two for each core]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,

    /// Run the tests whose names contain this
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

/// Runs the tests after it made sure that the tools are there.
///
/// # Errors
/// When a tool is missing and must not or cannot be installed, or a test fails.
pub fn run(options: &Options) -> anyhow::Result<()> {
    provide(&NEEDS, options.install, "cargo xtask test-tools --install")?;
    // A test waits most of its time: its spacecraft flies in real time, which takes less than half a core.
    let jobs = options.jobs.map_or_else(
        || std::thread::available_parallelism().map_or(2, |cores| 2 * cores.get()),
        NonZero::get,
    );
    let mut cargo = Command::new("cargo");
    // The whole workspace: with its features nothing is compiled that `cargo test` has compiled before.
    firmware_images::clean(&mut cargo)
        .args([
            "test",
            "--workspace",
            "--test",
            "images",
            "--test",
            "tools",
            "--",
            "--test-threads",
            &jobs.to_string(),
        ])
        .args(&options.names)
        .current_dir(project::path(""));
    let status = cargo.status().context("cannot run cargo")?;
    ensure!(status.success(), "a test with tools of others failed, see above");
    Ok(())
}
