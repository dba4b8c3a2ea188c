//! Packages of the user's whose image and data sheet are made before a flight.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::eds;
use crate::images::Package;
use crate::images::support::fleet::{Fleet, NodeFile};
use crate::images::support::node::{MASTER, Node};
use crate::images::support::output;

/// Entry of a data sheet of a master (CiA 306).
const OF_MASTER: &str = "SimpleBootUpMaster=1";

/// A package that is built for a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Build {
    /// Its node.
    pub node: Node,
    /// The package.
    pub package: Package,
    /// Program of the package; `None`: its only one, or the one that has its name.
    pub program: Option<String>,
    /// Board for which it is built, if its boards are features.
    pub board: Option<String>,
    /// Its data sheet.
    pub sheet: SheetOf,
}

/// Origin of the data sheet of a package.
#[derive(Clone, Debug, PartialEq)]
pub enum SheetOf {
    /// A file that is given.
    File,
    /// Its program on the host prints it.
    Program,
    /// Its program on the host has printed it.
    Printed(Printed),
}

/// A data sheet as a program printed it.
#[derive(Clone, Debug, PartialEq)]
pub struct Printed {
    name: String,
    text: String,
}

impl Printed {
    /// Runs the program of a package on the host.
    ///
    /// # Errors
    /// When it does not build, fails, or prints no data sheet.
    pub fn by(package: &Package) -> anyhow::Result<Printed> {
        let (name, text) = eds::printed(&package.name, &package.manifest, None)?;
        Ok(Printed { name, text })
    }

    /// Returns whether it describes a master.
    pub fn is_of_master(&self) -> bool {
        self.text.lines().any(|line| line.trim_end() == OF_MASTER)
    }

    /// Writes it into a folder, and returns its path.
    fn store(&self, folder: &Path) -> anyhow::Result<PathBuf> {
        let path = folder.join(&self.name);
        std::fs::write(&path, &self.text).with_context(|| format!("writing {}", path.display()))?;
        Ok(path)
    }
}

/// Adds an image of the user's for a node.
pub fn add_image(fleet: &mut Fleet, node: Node, file: PathBuf) {
    if node == MASTER {
        fleet.master = Some(file);
    } else {
        fleet.own_slaves.retain(|slave| slave.node != node);
        fleet.own_slaves.push(NodeFile { node, file });
    }
}

/// Builds packages for their nodes. Their data sheets are written beside their images.
///
/// # Errors
/// When one does not build, or has no program that is meant. A package without a data sheet is only warned of.
pub fn build(fleet: &mut Fleet, sheets: &mut Vec<NodeFile>, builds: &[Build]) -> anyhow::Result<()> {
    for Build { node, package, program, board, sheet } in builds {
        let images = package.build(board.as_deref())?;
        let image = of_program(&images, program.as_deref(), &package.name)?;
        let folder = image.parent().unwrap_or(Path::new("."));
        let printed = match sheet {
            SheetOf::File => None,
            SheetOf::Printed(printed) => Some(printed.clone()),
            SheetOf::Program => match Printed::by(package) {
                Ok(printed) => Some(printed),
                Err(error) => {
                    output::warn(format_args!("node {node} runs without a data sheet: {error:#}"));
                    None
                }
            },
        };
        if let Some(printed) = printed {
            sheets.push(NodeFile { node: *node, file: printed.store(folder)? });
        }
        add_image(fleet, *node, image.clone());
    }
    Ok(())
}

/// Returns the image of a program among those of a package.
fn of_program<'a>(
    images: &'a [PathBuf],
    program: Option<&str>,
    package: &str,
) -> anyhow::Result<&'a PathBuf> {
    let is = |name: &str, image: &&PathBuf| image.file_name().is_some_and(|file| file == name);
    let found = match (images, program) {
        ([only], None) => Some(only),
        _ => images.iter().find(|image| is(program.unwrap_or(package), image)),
    };
    let names = images.iter().filter_map(|image| Some(image.file_name()?.to_string_lossy()));
    let names: Vec<_> = names.collect();
    match found {
        Some(image) => Ok(image),
        None if names.is_empty() => bail!("{package} has no program for a board: give it a main.rs"),
        None => bail!(
            "{package} has no program {}: its programs are {}; name one by `program` in a mission file",
            program.unwrap_or(package),
            names.join(", ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_is_the_only_one_or_that_of_the_name() {
        let two = ["a/heater", "a/cooler"].map(PathBuf::from);
        assert_eq!(of_program(&two, None, "heater").unwrap(), &two[0]);
        assert_eq!(of_program(&two, Some("cooler"), "heater").unwrap(), &two[1]);
        assert_eq!(of_program(&two[1..], None, "heater").unwrap(), &two[1]);
        let error = of_program(&two, None, "fan").unwrap_err().to_string();
        assert!(error.contains("no program fan: its programs are heater, cooler"), "{error}");
        assert!(of_program(&[], None, "fan").unwrap_err().to_string().contains("no program for a board"));
    }
}
