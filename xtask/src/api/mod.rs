//! `cargo xtask api`: the public items of both protocol crates by module, for `docs/api.md`.
//!
//! rustdoc writes the public items of a crate as JSON. Its format has versions and belongs to a toolchain, so the package
//! `rustdoc-types` is pinned with the toolchain.

mod items;
mod page;
#[cfg(test)]
mod tests;

use std::fs::{self, File};
use std::io::BufReader;

use anyhow::{Context, bail, ensure};
use clap::Args;
use ecss_can_cli::images::support::{output, project};
use items::modules;
use rustdoc_types::{Crate, FORMAT_VERSION};
use serde::Deserialize;

/// Path of the generated page from the root of the repository.
const PAGE: &str = "docs/api.md";
/// Packages on the page, in its order.
const PACKAGES: [&str; 2] = ["async-canopen", "ecss-can"];

/// Command line of `api`.
#[derive(Args, Debug)]
pub struct Options {
    /// Write nothing; exit with 1 if the page is not up to date
    #[arg(long)]
    check: bool,
}

/// Writes the page, or compares it. Prints the numbers of items.
///
/// # Errors
/// When rustdoc fails or writes another format than the pinned one, when the page cannot be written, or with `--check`
/// when it is not up to date.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let mut crates = Vec::new();
    for package in PACKAGES {
        crates.push((package, modules(&document(package)?)));
    }
    let text = page::write(&crates);
    output::line(page::summary(&crates))?;
    let page = project::path(PAGE);
    if !options.check {
        return fs::write(&page, text).with_context(|| format!("cannot write {}", page.display()));
    }
    let found = fs::read_to_string(&page).unwrap_or_default();
    if let Some((found, now)) = first_difference(&found, &text) {
        bail!(
            "{PAGE} does not list what is public now: run `cargo xtask api`, and check that each new item is meant to be \
             public\nin the page: {found}\nnow:         {now}"
        );
    }
    Ok(())
}

/// Returns the first pair of lines that differ. A missing line is empty.
fn first_difference<'a>(found: &'a str, now: &'a str) -> Option<(&'a str, &'a str)> {
    let (mut found, mut now) = (found.split('\n'), now.split('\n'));
    loop {
        match (found.next(), now.next()) {
            (None, None) => return None,
            (found, now) if found == now => {}
            (found, now) => return Some((found.unwrap_or_default(), now.unwrap_or_default())),
        }
    }
}

/// The version of a document, which is read before the rest.
#[derive(Deserialize)]
struct Version {
    format_version: u32,
}

/// Returns the output of rustdoc for the library of a package, with all features. It uses a separate target directory,
/// because build scripts depend on `RUSTC_BOOTSTRAP`, and other builds would be repeated.
fn document(package: &str) -> anyhow::Result<Crate> {
    let target = project::target("api");
    let mut cargo = ecss_can_cli::images::host_cargo();
    cargo.args(["rustdoc", "--quiet", "--lib", "--all-features", "--package", package]);
    cargo.arg("--target-dir").arg(&target);
    cargo.args(["--", "-Z", "unstable-options", "--output-format", "json"]);
    // The option has no stable form.
    cargo.env("RUSTC_BOOTSTRAP", "1").current_dir(project::path(""));
    ensure!(cargo.status().context("cannot run cargo")?.success(), "rustdoc failed for {package}, see above");

    let path = target.join("doc").join(package.replace('-', "_")).with_extension("json");
    let open =
        || File::open(&path).map(BufReader::new).with_context(|| format!("cannot read {}", path.display()));
    let Version { format_version } = serde_json::from_reader(open()?)?;
    ensure!(
        format_version == FORMAT_VERSION,
        "rustdoc writes format {format_version}, and xtask reads {FORMAT_VERSION}: use the toolchain of rust-toolchain.toml, or \
         change `rustdoc-types` in Cargo.toml with it"
    );
    serde_json::from_reader(open()?).with_context(|| format!("cannot understand {}", path.display()))
}
