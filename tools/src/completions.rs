//! `ecss-can completions`: completions of commands and options for a shell.

use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;

use crate::images::support::output;

/// Command line of `completions`.
#[derive(Args, Debug)]
#[command(
    after_help = "Load them in a shell that runs:\n    source <(ecss-can completions bash)\n    source <(ecss-can \
    completions zsh)\n    ecss-can completions fish | source\nor write them to a file that the shell reads at its start, such as\n\
    ~/.local/share/bash-completion/completions/ecss-can or ~/.config/fish/completions/ecss-can.fish."
)]
pub struct Options {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Prints the completions of `cli`.
///
/// # Errors
/// When stdout cannot be written.
pub fn run(options: &Options, mut cli: Command) -> anyhow::Result<()> {
    let name = cli.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut cli, name, &mut script);
    output::text(String::from_utf8(script).context("completions that are text")?)
}
