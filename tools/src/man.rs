//! `ecss-can man`: a man page for each command.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command};

use crate::images::support::output;

/// Command line of `man`.
#[derive(Args, Debug)]
pub struct Options {
    /// Folder for the pages, such as ~/.local/share/man/man1; created when missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Writes a page for `cli` and each of its commands.
///
/// # Errors
/// When a file cannot be written.
pub fn run(options: &Options, cli: Command) -> anyhow::Result<()> {
    let folder = &options.folder;
    let write = || fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(cli, folder));
    write().with_context(|| format!("cannot write man pages to {}", folder.display()))?;
    output::line(format_args!("Written to {}", folder.display()))
}
