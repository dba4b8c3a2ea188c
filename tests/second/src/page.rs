//! A page of documentation with steps, which are executed as written.
//!
//! The info string of a block of code says what the block is: `sh` is run, `sh background` keeps running, `LANGUAGE
//! PATH` is a file, and `text output` is the end of the output of the command before it. [`your_own`] are the steps of
//! `docs/your-own.md`, [`your_own_master`] those of `docs/your-own-master.md`. The test `flights::page` follows the
//! first ones up to the one that needs Python, and then the others. `tools::your_own` follows those with Python.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::ErrorKind;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::{Context, bail, ensure};
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

use crate::program;

/// A block of code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A file, by its path in the folder of the page.
    File(PathBuf, String),
    /// Commands, in the working folder of the previous ones.
    Run(String),
    /// A command that keeps running.
    Background(String),
    /// The last lines that the command before it prints.
    Output(String),
}

/// Returns the steps of `docs/your-own.md`.
///
/// # Errors
/// When the page cannot be read, or has a block without a meaning.
pub fn your_own() -> anyhow::Result<Vec<Step>> {
    steps_of("docs/your-own.md")
}

/// Returns the steps of `docs/your-own-master.md`, with the actual path of this repository. They continue in the folder
/// of [`your_own`].
///
/// # Errors
/// As [`your_own`].
pub fn your_own_master() -> anyhow::Result<Vec<Step>> {
    steps_of("docs/your-own-master.md")
}

fn steps_of(page: &str) -> anyhow::Result<Vec<Step>> {
    steps(&fs::read_to_string(root()?.join(page))?)
}

fn root() -> anyhow::Result<&'static Path> {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).context("a workspace")
}

/// Returns the steps of a page.
///
/// # Errors
/// When a block has an unknown meaning.
pub fn steps(markdown: &str) -> anyhow::Result<Vec<Step>> {
    let (mut steps, mut block) = (Vec::new(), None);
    for event in Parser::new(markdown) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                block = Some((info.into_string(), String::new()));
            }
            Event::Text(part) => block.iter_mut().for_each(|(_, text)| text.push_str(&part)),
            Event::End(TagEnd::CodeBlock) => {
                let (info, text) = block.take().context("a block of code with a language")?;
                steps.push(match info.split_once(' ') {
                    None if info == "sh" => Step::Run(text),
                    Some(("sh", "background")) => Step::Background(text),
                    Some(("text", "output")) => Step::Output(text),
                    Some((_, path)) => Step::File(path.into(), text),
                    None => bail!("a block of code that is neither a command nor a file: `{info}`"),
                });
            }
            _ => {}
        }
    }
    Ok(steps)
}

/// One test at a time builds into `target/page`: packages and images of several tests have the same name.
static BUILDS: Mutex<()> = Mutex::new(());

/// An empty folder outside this repository, whose packages are built into `target/page`.
#[derive(Debug)]
pub struct FreshFolder {
    path: PathBuf,
    _builds: MutexGuard<'static, ()>,
}

impl Deref for FreshFolder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

/// Makes an empty folder, the same for each run of the test `name`, after other tests of this process released theirs.
/// Images are built for the path of a board, and the build stays in `target`.
///
/// # Errors
/// When it cannot be made.
pub fn fresh_folder(name: &str) -> anyhow::Result<FreshFolder> {
    let builds = BUILDS.lock().unwrap_or_else(PoisonError::into_inner);
    let mut hasher = DefaultHasher::new();
    root()?.hash(&mut hasher);
    let folder = std::env::temp_dir().join(format!("{name}-{:016x}", hasher.finish()));
    match fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => fs::create_dir(&folder),
    }
    .with_context(|| format!("cannot make {} anew", folder.display()))?;
    Ok(FreshFolder { path: folder, _builds: builds })
}

/// A folder in which a page is followed.
#[derive(Debug)]
pub struct Folder {
    top: PathBuf,
    /// Working folder at the end of the last command.
    here: PathBuf,
    /// Folders that are searched for programs before PATH: that of `ecss-can` is the first.
    tools: Vec<PathBuf>,
    /// Output of the last commands.
    printed: String,
}

impl Folder {
    /// Uses the folder `top`, with the programs of PATH and `ecss-can` of this repository.
    ///
    /// # Errors
    /// When `ecss-can` cannot be built.
    pub fn new(top: &Path) -> anyhow::Result<Folder> {
        let program = program::executable()?.parent().context("a program is in a folder")?;
        Ok(Folder { top: top.into(), here: top.into(), tools: vec![program.into()], printed: String::new() })
    }

    /// Searches the folder `tools` for programs, too.
    #[must_use]
    pub fn with_tools(mut self, tools: &Path) -> Folder {
        self.tools.push(tools.into());
        self
    }

    /// Keeps the build of the new package `name` in `target/page` of this repository for the next run.
    ///
    /// # Errors
    /// When the link cannot be made.
    #[cfg(unix)]
    fn keep_target(&self, name: &str) -> anyhow::Result<()> {
        let target = root()?.join("target/page");
        fs::create_dir_all(&target)?;
        std::os::unix::fs::symlink(target, self.top.join(name).join("target"))?;
        Ok(())
    }

    /// Executes a step except [`Step::Background`]: writes a file, runs commands, or compares the output of the
    /// previous ones. Keeps the build of a project that `ecss-can new` makes.
    ///
    /// # Errors
    /// When a file cannot be written, a command fails, or prints something else.
    #[cfg(unix)]
    pub fn follow(&mut self, step: &Step) -> anyhow::Result<()> {
        match step {
            Step::File(path, text) => self.write(path, text)?,
            Step::Run(commands) => {
                self.printed = self.run(commands)?;
                let made =
                    commands.strip_prefix("ecss-can new ").and_then(|rest| rest.split_whitespace().nth(1));
                made.map_or(Ok(()), |package| self.keep_target(package))?;
            }
            Step::Output(expected) => ensure!(self.printed.ends_with(expected), "{}", self.printed),
            Step::Background(command) => bail!("the command goes on running: {command}"),
        }
        Ok(())
    }

    /// Writes a file.
    ///
    /// # Errors
    /// When that fails.
    pub fn write(&self, path: &Path, text: &str) -> anyhow::Result<()> {
        let path = self.top.join(path);
        let parent = path.parent().context("a file has a folder")?;
        fs::create_dir_all(parent)?;
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    }

    /// Runs commands, and returns their output.
    ///
    /// # Errors
    /// When one of them fails.
    fn run(&mut self, commands: &str) -> anyhow::Result<String> {
        let note = self.top.join(".here");
        let script = format!("set -e\n{commands}\npwd > '{}'\n", note.display());
        let output = self.shell(&script).output().context("cannot run sh")?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        ensure!(output.status.success(), "failed ({}):\n{commands}\nIt said\n{said}", output.status);
        self.here = fs::read_to_string(&note)?.trim_end().into();
        Ok(said)
    }

    /// Returns a command that keeps running, with piped standard output.
    pub fn background(&self, command: &str) -> Command {
        let mut shell = self.shell(&format!("exec {command}"));
        shell.stdout(Stdio::piped());
        shell
    }

    fn shell(&self, script: &str) -> Command {
        let mut shell = Command::new("sh");
        ecss_can_cli::images::clean(&mut shell);
        shell.args(["-c", script]).current_dir(&self.here).stdin(Stdio::null()).stderr(Stdio::inherit());
        let tools = self.tools.iter().map(|folder| folder.display().to_string());
        let path = std::env::var("PATH").unwrap_or_default();
        shell.env("PATH", tools.chain([path]).collect::<Vec<_>>().join(":"));
        shell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_block_is_a_step() {
        let page = "# A\n\n```sh\nls\n```\n\n```toml a/b.toml\nx = 1\n```\n\n```sh background\nyes\n```\n\n```text output\ny\n```\n";
        let expected = [
            Step::Run("ls\n".into()),
            Step::File("a/b.toml".into(), "x = 1\n".into()),
            Step::Background("yes\n".into()),
            Step::Output("y\n".into()),
        ];
        assert_eq!(steps(page).unwrap(), expected);
    }

    #[test]
    fn a_block_without_meaning_is_an_error() {
        assert!(steps("```rust\nfn main() {}\n```\n").unwrap_err().to_string().contains("`rust`"));
    }
}
