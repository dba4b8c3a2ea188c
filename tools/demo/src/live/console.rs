//! Commands that are typed, and lines that do not disturb the typing.
//!
//! On a terminal the line that is being typed stays below all output. From a pipe lines come as they are. A command in the
//! background of a shell reads nothing: the shell would stop it.

use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use firmware_images::support::output;
use firmware_images::support::stop::Stop;
use futures_executor::block_on;
use rustix::process::getpgrp;
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};
use rustyline_async::{Readline, ReadlineEvent, SharedWriter};

/// Where people type and read.
pub struct Console {
    lines: Receiver<String>,
    /// Prints above the line that is being typed.
    printer: Option<SharedWriter>,
    /// Reads what is typed until the printer is gone.
    editor: Option<JoinHandle<()>>,
    /// How the terminal was before somebody typed.
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

    /// The next line that was typed.
    pub fn next(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// Nobody types any more: the terminal is as it was before.
    pub fn end_typing(&mut self) {
        self.printer = None;
        // It has printed what there was.
        let _ = self.editor.take().map(JoinHandle::join);
        if let Some(before) = self.before.take() {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        }
    }

    /// A line for people. Nobody has to read it: a closed pipe does not end the spacecraft.
    pub fn say(&mut self, line: impl std::fmt::Display) {
        match &mut self.printer {
            Some(printer) => _ = writeln!(printer, "{line}"),
            None => _ = writeln!(io::stdout(), "{line}"),
        }
    }

    /// Something is not as it should be.
    pub fn warn(&mut self, line: impl std::fmt::Display) {
        if self.printer.is_some() { self.say(format_args!("warning: {line}")) } else { output::warn(line) }
    }

    /// Something failed.
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
