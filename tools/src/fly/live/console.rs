//! Typed commands, and output that does not disturb the typing.
//!
//! On a terminal the line that is being typed stays below all output. From a pipe, lines are read unchanged. A process
//! in the background of a shell reads nothing, because the shell would stop it.

use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use futures_executor::block_on;
use rustix::process::getpgrp;
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};
use rustyline_async::{Readline, ReadlineEvent, SharedWriter};

use crate::images::support::output;
use crate::images::support::stop::Stop;

/// Terminal or pipe of the user.
pub struct Console {
    lines: Receiver<String>,
    /// Prints above the line that is being typed.
    printer: Option<SharedWriter>,
    /// Reads typed lines until the printer is dropped.
    editor: Option<JoinHandle<()>>,
    /// Settings of the terminal before the editor changed them.
    before: Option<Termios>,
}

impl Console {
    /// Reads stdin from now on. Ctrl-C while typing raises `stop`.
    pub fn open(stop: &Stop) -> Console {
        let (sender, lines) = channel();
        if !io::stdin().is_terminal() || !io::stdout().is_terminal() {
            thread::spawn(move || pass_on(&sender));
            return Console { lines, printer: None, editor: None, before: None };
        }
        let is_ours = tcgetpgrp(io::stdin()).is_ok_and(|group| group == getpgrp());
        let before = tcgetattr(io::stdin()).ok().filter(|_| is_ours);
        let editor = before.is_some().then(|| Readline::new(String::new())).and_then(Result::ok);
        let Some((mut editor, printer)) = editor else {
            return Console { lines, printer: None, editor: None, before };
        };
        let stop = stop.clone();
        let editor = thread::spawn(move || block_on(edit(&mut editor, &sender, &stop)));
        Console { lines, printer: Some(printer), editor: Some(editor), before }
    }

    /// Returns the next typed line.
    pub fn next(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// Ends typing and restores the settings of the terminal.
    pub fn end_typing(&mut self) {
        self.printer = None;
        // The editor has printed all pending output.
        let _ = self.editor.take().map(JoinHandle::join);
        if let Some(before) = self.before.take() {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        }
    }

    /// Prints a line. A closed pipe does not end the spacecraft.
    pub fn say(&mut self, line: impl std::fmt::Display) {
        match &mut self.printer {
            Some(printer) => _ = writeln!(printer, "{line}"),
            None => _ = writeln!(io::stdout(), "{line}"),
        }
    }

    /// Prints a warning.
    pub fn warn(&mut self, line: impl std::fmt::Display) {
        if self.printer.is_some() { self.say(format_args!("warning: {line}")) } else { output::warn(line) }
    }

    /// Prints an error.
    pub fn complain(&mut self, line: impl std::fmt::Display) {
        if self.printer.is_some() { self.say(format_args!("error: {line}")) } else { output::complain(line) }
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.end_typing();
    }
}

fn pass_on(sender: &Sender<String>) {
    let lines = io::stdin().lock().lines().map_while(Result::ok);
    // Ends with the run.
    let _ = lines.into_iter().try_for_each(|line| sender.send(line));
}

async fn edit(editor: &mut Readline, sender: &Sender<String>, stop: &Stop) {
    while let Ok(event) = editor.readline().await {
        match event {
            ReadlineEvent::Line(line) => {
                editor.add_history_entry(line.clone());
                if sender.send(line).is_err() {
                    return;
                }
            }
            ReadlineEvent::Interrupted => stop.ask(),
            ReadlineEvent::Eof => {}
        }
    }
}
