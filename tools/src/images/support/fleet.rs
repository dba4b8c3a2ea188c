//! The boards of a spacecraft and their images: shared by `cargo demo` and `cargo twin`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use can_twin::description;
use can_twin::image::Image;
use can_twin::model::{Oscillator, Part};
use clap::Args;

use crate::images::support::board::{Board, Profile, Target};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{FIRST, LAST, MASTER, Node, SECOND_MASTER, is_master};
use crate::images::support::output;

/// An image for each node.
pub type Images = BTreeMap<Node, Arc<Image>>;

/// Options that choose boards and images.
#[derive(Args, Clone, Debug)]
pub struct Fleet {
    /// Number of shipped slave boards: nodes 2, 3, 4, ... (in profile librecube nodes 4 and 6 use selective bus access) [0..14]
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(0..=14))]
    pub slaves: u8,

    /// ELF file of a master of your own, flown as node 1
    #[arg(long, value_name = "FILE")]
    pub master: Option<PathBuf>,

    /// ELF file of a slave of your own, flown with the straps of Node-ID N [2..15]: in place of the shipped slave N, or
    /// beside the others; may be given several times
    #[arg(long = "slave", value_name = "N=FILE", value_parser = own_slave)]
    pub own_slaves: Vec<NodeFile>,

    /// What the shipped images are built for.
    #[command(flatten)]
    pub target: Target,

    /// Part of the boards that fly images of your own, such as STM32F407VG, in the place of that of --board; their pins stay those of
    /// --board: of the pyboard, unless a file says otherwise
    #[arg(long, value_name = "CHIP", value_parser = Part::named)]
    pub chip: Option<Part>,

    /// Oscillator of the boards that fly images of your own, in the place of that of --board: 8MHz is a crystal, "8MHz external" a
    /// clock from outside
    #[arg(long, value_name = "FREQUENCY", value_parser = description::oscillator)]
    pub oscillator: Option<Oscillator>,

    /// Fly the shipped images as they were built last
    #[arg(long)]
    pub no_build: bool,
}

/// A file of a node, as `--slave` and `--eds` have it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeFile {
    /// Node-ID.
    pub node: Node,
    /// The file.
    pub file: PathBuf,
}

fn own_slave(text: &str) -> Result<NodeFile, String> {
    node_and_file(text, FIRST, "3=target/slave.elf")
}

/// Parses a Node-ID, `first` to 15, and a file with `=` between them.
///
/// # Errors
/// A text with what was wrong and what is allowed. `example`: a right value.
pub fn node_and_file(text: &str, first: Node, example: &str) -> Result<NodeFile, String> {
    let (node, file) =
        text.split_once('=').ok_or_else(|| format!("give a Node-ID and a file, for example {example}"))?;
    match node.parse() {
        Ok(node) if (first..=LAST).contains(&node) && !file.is_empty() => {
            Ok(NodeFile { node, file: file.into() })
        }
        Ok(node) if (first..=LAST).contains(&node) => Err("the file is missing behind '='".into()),
        _ => Err(format!("allowed are Node-IDs {first} to {LAST}")),
    }
}

impl Fleet {
    /// Checks conditions between options; `command` is the subcommand with these options, `nodes` are all boards.
    ///
    /// # Errors
    /// When two images are given for one node, a part or oscillator is given and no image, or shipped images are
    /// requested for a board without a crate.
    pub fn check(&self, command: &'static str, nodes: &BTreeSet<Node>) -> Result<(), Misuse> {
        self.own_board(command)?;
        let has_own = nodes.iter().any(|node| self.own_image(*node).is_some());
        let given = [self.chip.map(|_| "--chip"), self.oscillator.map(|_| "--oscillator")];
        if let Some(option) = given.into_iter().flatten().next().filter(|_| !has_own) {
            let text =
                format!("{option} is for images of your own: give --master FILE or --slave N=FILE, too");
            return Err(Misuse::of(command, text));
        }
        if nodes.iter().any(|node| self.own_image(*node).is_none()) {
            self.target.board.check_images(command)?;
        }
        let mut seen = BTreeSet::new();
        match self.own_slaves.iter().find(|slave| !seen.insert(slave.node)) {
            Some(NodeFile { node, .. }) => {
                Err(Misuse::of(command, format!("two images for node {node}: give --slave {node}=FILE once")))
            }
            None => Ok(()),
        }
    }

    /// The board of images of the user's.
    ///
    /// # Errors
    /// When the part of `--chip` lacks pins of `--board`.
    pub fn own_board(&self, command: &'static str) -> Result<Board, Misuse> {
        let board = self.target.board.with(self.chip, self.oscillator);
        board.map_err(|error| Misuse::of(command, format!("invalid value for '--chip <CHIP>': {error}")))
    }

    /// The master boards: two in the profile standby, unless the master is an image of the user's.
    pub fn masters(&self) -> BTreeSet<Node> {
        let second =
            (self.target.profile == Profile::Standby && self.master.is_none()).then_some(SECOND_MASTER);
        std::iter::once(MASTER).chain(second).collect()
    }

    /// Node-IDs of all slaves, from the lowest.
    pub fn slaves(&self) -> BTreeSet<Node> {
        (FIRST..FIRST + self.slaves).chain(self.own_slaves.iter().map(|slave| slave.node)).collect()
    }

    /// The image given for a node; `None`: the shipped one.
    pub fn own_image(&self, node: Node) -> Option<&Path> {
        match node {
            MASTER => self.master.as_deref(),
            _ => Some(&self.own_slaves.iter().find(|slave| slave.node == node)?.file),
        }
    }

    /// Reads the images of the user for these nodes; `command` is the subcommand with these options.
    ///
    /// # Errors
    /// When one cannot be read, is no image, or was linked for another chip than that of the board.
    pub fn own_images(&self, command: &'static str, nodes: &BTreeSet<Node>) -> Result<Images, Misuse> {
        let part = self.own_board(command)?.model().part;
        let read = |path: &Path| {
            let fitting = image(path).and_then(|image| {
                image.check_part(part).with_context(|| path.display().to_string())?;
                Ok(image)
            });
            fitting.map_err(|error| Misuse::of(command, format!("{error:#}")))
        };
        let own = nodes.iter().filter_map(|&node| Some((node, self.own_image(node)?)));
        own.map(|(node, path)| Ok((node, read(path)?))).collect()
    }

    /// Builds the image of the minimal slave for these nodes, if there are any; `fitting`: its features in addition to
    /// board and profile, each after a plus sign.
    ///
    /// # Errors
    /// When it cannot be built or read, or with `--no-build` was not built before.
    pub fn add_minimal(
        &self,
        nodes: &BTreeSet<Node>,
        fitting: &str,
        images: &mut Images,
    ) -> anyhow::Result<()> {
        if nodes.is_empty() {
            return Ok(());
        }
        let (board, profile) = (&self.target.board, &format!("{}{fitting}", self.target.profile.name()));
        let path = if self.no_build {
            crate::images::built_minimal(board.board_crate(), profile)
                .with_context(|| unbuilt(board, profile))?
        } else {
            crate::images::build_minimal(board.board_crate(), profile, crate::images::LOG)?
        };
        let minimal = image(&path)?;
        images.extend(nodes.iter().map(|node| (*node, minimal.clone())));
        Ok(())
    }

    /// Builds the images that the user has not given, if a board needs them.
    ///
    /// # Errors
    /// When an image cannot be built or read, or with `--no-build` was not built before.
    pub fn add_shipped(&self, nodes: &BTreeSet<Node>, images: &mut Images) -> anyhow::Result<()> {
        let missing: BTreeSet<Node> =
            nodes.iter().copied().filter(|node| !images.contains_key(node)).collect();
        if !missing.is_empty() {
            let built = built(&self.target.board, self.target.profile, self.no_build)?;
            images.extend(shipped(&built, missing)?);
        }
        Ok(())
    }
}

/// Builds the shipped images, or with `no_build` finds those that were built last.
///
/// # Errors
/// When they cannot be built, or with `no_build` were not built before.
pub fn built(board: &Board, profile: Profile, no_build: bool) -> anyhow::Result<crate::images::Images> {
    let (crate_of_board, profile) = (board.board_crate(), profile.name());
    if no_build {
        crate::images::built(crate_of_board, profile).with_context(|| unbuilt(board, profile))
    } else {
        Ok(crate::images::build(crate_of_board, profile)?)
    }
}

fn unbuilt(board: &Board, profile: &str) -> String {
    format!("nothing was built for {}, profile {profile}, yet: leave out --no-build", board.name())
}

/// The shipped images for these nodes.
///
/// # Errors
/// When one cannot be read.
pub fn shipped(
    built: &crate::images::Images,
    nodes: impl IntoIterator<Item = Node>,
) -> anyhow::Result<Images> {
    let (master, slave) = (image(&built.master)?, image(&built.slave)?);
    let of = |node| if is_master(node) { &master } else { &slave }.clone();
    Ok(nodes.into_iter().map(|node| (node, of(node))).collect())
}

/// Reads the image at `path` for boards of the twin.
///
/// # Errors
/// When it cannot be read or is no image.
pub fn image(path: &Path) -> anyhow::Result<Arc<Image>> {
    let elf = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let image = Image::parse(&elf).with_context(|| format!("{} is no image", path.display()))?;
    if let Err(reason) = image.log_table() {
        output::warn(format_args!("{}: its log is not shown: {reason}", path.display()));
    }
    Ok(Arc::new(image))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_slave_is_a_node_and_a_file() {
        assert_eq!(own_slave("3=a=b.elf"), Ok(NodeFile { node: 3, file: "a=b.elf".into() }));
        let of_node = ["1=x", "16=x", "x=y"].map(|wrong| (wrong, "2 to 15"));
        for (wrong, said) in of_node.into_iter().chain([("3", "for example"), ("3=", "file")]) {
            assert!(own_slave(wrong).is_err_and(|error| error.contains(said)), "{wrong}");
        }
    }
}
