//! `ecss-can new`: a new slave, master or board that is built, tested and flown at once.

mod checkout;
mod name;
mod template;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use template::{File, Places};
use time::OffsetDateTime;
use toml::Table;

use crate::images::support::board::Board;
use crate::images::support::misuse::Misuse;
use crate::images::support::output;
use crate::images::{BoardCrate, package_of};

/// Folder and package of the slave that a new master commands.
const SLAVE: &str = "heater";

/// Command line of `new`.
#[derive(Args, Debug)]
pub struct Options {
    #[command(subcommand)]
    project: Project,
}

#[derive(Subcommand, Debug)]
enum Project {
    /// A slave: device, application, image, tests, flight with the shipped master
    Slave {
        /// Folder and package, for example heater
        #[arg(value_name = "NAME", value_parser = name::check)]
        name: String,
        #[command(flatten)]
        image: Image,
    },
    /// A master, and a slave that it commands
    Master {
        /// Folder and package, for example ground
        #[arg(value_name = "NAME", value_parser = name::check)]
        name: String,
        #[command(flatten)]
        image: Image,
        /// Folder of the slave that the master commands, made by `ecss-can new slave` [default: a new one in the folder of the master]
        #[arg(long, value_name = "DIR")]
        slave: Option<PathBuf>,
    },
    /// The crate of a board, and a flight of the shipped images on it
    Board {
        /// Folder and package, for example h405
        #[arg(value_name = "NAME", value_parser = name::check)]
        name: String,
    },
}

/// Options of projects with an image.
#[derive(Args, Debug)]
struct Image {
    /// Board of the image: a shipped one, or the folder of a board of your own
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, default_value = Board::DEFAULT)]
    board: Board,
    /// Node-ID of the slave in tests and flight [2..15]
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u8).range(2..=15))]
    node: u8,
}

/// Writes the project into a new folder of its name.
///
/// # Errors
/// [`Misuse`] when the folder exists, or NAME, `--board` or `--slave` cannot be used; otherwise when a file cannot be written.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let (name, parts) = match &options.project {
        Project::Slave { name, image } => (name, slave(name, image)?),
        Project::Master { name, image, slave } => (name, master(name, image, slave.as_deref())?),
        Project::Board { name } => (name, vec![Part::new("", places(name), template::BOARD)]),
    };
    let folder = here()?.join(name);
    check(name, &folder, &parts)?;
    for part in &parts {
        part.places.write(part.files, &folder.join(part.folder))?;
    }
    Places::default().write(template::PROJECT, &folder)?;
    if let Some(configuration) = checkout::configuration(&manifests(&parts))? {
        template::write(&folder.join(".cargo/config.toml"), &configuration)?;
    }
    output::line(format_args!("Written to {name}. Next:\n    cd {name}\n    cargo test\n    ecss-can fly"))
}

/// Files of a project that have the same values of places.
struct Part {
    /// Folder in the project.
    folder: &'static str,
    places: Places,
    files: &'static [File],
}

impl Part {
    fn new(folder: &'static str, places: Places, files: &'static [File]) -> Part {
        Part { folder, places, files }
    }
}

fn slave(name: &str, image: &Image) -> anyhow::Result<Vec<Part>> {
    let places = image.places(name, &here()?.join(name))?;
    Ok([template::SLAVE, template::SLAVE_MISSION].map(|files| Part::new("", places.clone(), files)).into())
}

fn master(name: &str, image: &Image, slave: Option<&Path>) -> anyhow::Result<Vec<Part>> {
    let folder = here()?.join(name);
    let own = image.places(SLAVE, &folder.join(SLAVE))?;
    let (path, package) = match slave {
        None => (PathBuf::from(SLAVE), SLAVE.to_owned()),
        Some(given) => {
            let refuse = |error| {
                Misuse::value(
                    "new",
                    "--slave <DIR>",
                    given.display(),
                    format!("{error}; allowed is the folder of a package"),
                )
            };
            let (slave, package) = package_of(given).map_err(refuse)?;
            (checkout::relative(&slave, &folder), package)
        }
    };
    let workspace =
        if slave.is_some() { String::new() } else { format!("\n[workspace]\nmembers = [\"{SLAVE}\"]\n") };
    let places = image.places(name, &folder)?;
    let places = places.with("workspace", workspace).with("slave_crate", name::of_crate(&package));
    let places = places.with("slave", package).with("slave_path", path.display().to_string());
    let mut parts = vec![Part::new("", places, template::MASTER)];
    parts.extend(slave.is_none().then(|| Part::new(SLAVE, own, template::SLAVE)));
    Ok(parts)
}

/// Places of all templates.
fn places(name: &str) -> Places {
    let today = OffsetDateTime::now_utc().date();
    let date = format!("{}, {}, {}", today.year(), u8::from(today.month()), today.day());
    Places::default()
        .with("name", name)
        .with("crate", name::of_crate(name))
        .with("version", version())
        .with("date", date)
}

/// Version of the crates in the manifest of a project: without the patch level.
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION").rsplit_once('.').map_or("", |(version, _)| version)
}

impl Image {
    /// Places of a project with an image in `folder`.
    fn places(&self, name: &str, folder: &Path) -> anyhow::Result<Places> {
        self.board.check_images("new")?;
        let dependency = match self.board.board_crate() {
            BoardCrate::Shipped(board) => {
                format!("{{ package = \"ecss-can-{board}\", version = \"{}\" }}", version())
            }
            BoardCrate::Elsewhere(board) => {
                let (board, package) = package_of(board)?;
                let path = checkout::relative(&board, folder).display().to_string();
                format!("{{ package = {package:?}, path = {path:?} }}")
            }
        };
        Ok(places(name).with("board", dependency).with("node", self.node.to_string()))
    }
}

fn here() -> anyhow::Result<PathBuf> {
    env::current_dir().context("the current folder")
}

/// Manifests of a project.
fn manifests(parts: &[Part]) -> Vec<String> {
    let files = parts.iter().flat_map(|part| part.files.iter().map(move |file| (part, file)));
    files.filter(|(_, file)| file.path == "Cargo.toml").map(|(part, file)| part.places.fill(*file)).collect()
}

/// Checks that the folder does not exist, and that no dependency has the name of the package.
fn check(name: &str, folder: &Path, parts: &[Part]) -> anyhow::Result<()> {
    let refuse = |cause: &str| Err(Misuse::value("new", "<NAME>", name, cause).into());
    if fs::symlink_metadata(folder).is_ok() {
        return refuse("the folder exists; allowed is the name of a new one");
    }
    for manifest in manifests(parts) {
        let manifest: Table = manifest.parse().context("a manifest of the new project")?;
        if manifest["package"]["name"].as_str() == Some(name)
            && checkout::dependencies(&manifest).contains(name)
        {
            return refuse("the new package depends on one of this name; allowed are others");
        }
    }
    Ok(())
}
