//! Origin of a flight: its date, the commit of the working tree, and the hash of each image.

use std::collections::BTreeMap;
use std::process::Command;

use serde::Serialize;
use sha2::{Digest, Sha256};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::plan::{BoardPlan, Plan};
use crate::images::support::fleet::Images;
use crate::images::support::node::{Node, is_master};
use crate::images::support::project;

/// Value of a commit that is not known: the project is not under git.
pub const UNKNOWN: &str = "unknown";

/// Origin of a flight, as in `summary.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Origin {
    /// Date of the flight, in UTC: `2026-11-26T07:30:00Z`.
    pub date: String,
    /// Commit of the working tree, 40 hexadecimal digits, or [`UNKNOWN`].
    pub commit: String,
    /// The working tree has changes that are not in the commit; `null` when that is not known.
    pub modified: Option<bool>,
    /// Image of each board.
    pub images: BTreeMap<Node, ImageFile>,
}

/// An image of the flight.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct ImageFile {
    /// Name of its file.
    pub file: String,
    /// SHA-256 of this ELF file, 64 hexadecimal digits.
    pub sha256: String,
}

impl Origin {
    /// The present date, the working tree of this project, and the images of a plan.
    pub fn of(plan: &Plan, images: &Images) -> Origin {
        let mut hashes = BTreeMap::new();
        let mut hash = |node: Node| {
            let image = images.get(&node)?;
            let elf = image.elf();
            // Boards share images: each is hashed once.
            Some(hashes.entry(elf.as_ptr()).or_insert_with(|| hexadecimal(&Sha256::digest(elf))).clone())
        };
        let file = |board: &BoardPlan| {
            let sha256 = hash(board.node)?;
            Some((board.node, ImageFile { file: file_name(board), sha256 }))
        };
        Origin {
            date: now(),
            commit: git(&["rev-parse", "HEAD"]).unwrap_or(UNKNOWN.into()),
            modified: git(&["status", "--porcelain"]).map(|changes| !changes.is_empty()),
            images: plan.boards.iter().filter_map(file).collect(),
        }
    }
}

fn file_name(board: &BoardPlan) -> String {
    match &board.own_image {
        Some(name) => name.clone(),
        None if is_master(board.node) => "master".into(),
        None if board.is_minimal => "minimal".into(),
        None => "slave".into(),
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The present time to the second.
fn now() -> String {
    let now = OffsetDateTime::now_utc();
    now.replace_nanosecond(0).unwrap_or(now).format(&Rfc3339).unwrap_or_default()
}

/// Output of git in this project, without the end of the line; `None` outside git, and without git.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(project::path("")).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    /// The vector is that of FIPS 180-4 for the empty message.
    #[test]
    fn each_board_has_the_hash_of_its_image() {
        use std::sync::Arc;

        use can_twin::image::Image;
        let mut plan = sample::plan();
        plan.boards[2].own_image = Some("heater".into());
        let image = Arc::new(Image::from_flash(vec![0; 8]));
        let images = plan.boards.iter().map(|board| (board.node, image.clone())).collect();
        let origin = Origin::of(&plan, &images);
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        let files: Vec<(&str, &str)> =
            origin.images.values().map(|image| (&*image.file, &*image.sha256)).collect();
        assert_eq!(files, [("master", empty), ("slave", empty), ("heater", empty)]);
        assert!(origin.date.ends_with('Z') && origin.date.len() == 20, "{}", origin.date);
    }
}
