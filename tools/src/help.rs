//! Examples of command lines, in the help of each command and in its man page.

use clap::Command;

/// Words of a command after the program, and its examples.
pub const EXAMPLES: &[(&str, &[&str])] = &[
    (
        "new",
        &[
            "ecss-can new slave heater",
            "ecss-can new master ground --slave heater",
            "ecss-can new board h405",
        ],
    ),
    ("new slave", &["ecss-can new slave heater", "ecss-can new slave heater --board nucleo-f446re --node 7"]),
    ("new master", &["ecss-can new master ground", "ecss-can new master ground --slave heater"]),
    ("new board", &["ecss-can new board h405"]),
    ("build", &["ecss-can build", "ecss-can build slave --board nucleo-f446re --profile standard"]),
    ("flash", &["ecss-can flash slave --board nucleo-f446re", "ecss-can flash slave -- --probe 0483:374b"]),
    (
        "fly",
        &["ecss-can fly", "ecss-can fly --slaves 14 --cut-at 10 --seed 7", "ecss-can fly --profile standby"],
    ),
    ("twin", &["ecss-can twin", "ecss-can twin --no-master --seconds 60"]),
    ("eds", &["ecss-can eds --package heater", "ecss-can eds --slave 7 --out sheets"]),
    ("campaign", &["ecss-can campaign", "ecss-can campaign --seed 7"]),
    ("schedule", &["ecss-can schedule", "ecss-can schedule --profile standard"]),
    ("doctor", &["ecss-can doctor"]),
    ("completions", &["ecss-can completions bash"]),
    ("man", &["ecss-can man ~/.local/share/man/man1"]),
];

/// Adds the examples to the help of each command, before its other remarks.
///
/// # Panics
/// When [`EXAMPLES`] names a command that does not exist.
pub fn with_examples(cli: Command) -> Command {
    EXAMPLES.iter().fold(cli, |cli, (words, examples)| {
        let words: Vec<&str> = words.split(' ').collect();
        add(cli, &words, &format!("Examples:\n    {}", examples.join("\n    ")))
    })
}

fn add(command: Command, words: &[&str], text: &str) -> Command {
    if let Some((first, rest)) = words.split_first() {
        return command.mut_subcommand(*first, |command| add(command, rest, text));
    }
    let remarks = command.get_after_help().map(|remarks| format!("\n\n{remarks}")).unwrap_or_default();
    command.after_help(format!("{text}{remarks}"))
}
