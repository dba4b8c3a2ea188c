//! Boards of a mission file: images, data sheets, places, crystals and power-on times.

use std::path::PathBuf;

use toml::Spanned;

use super::Reader;
use super::schema::{File, Node};
use crate::fly::own::{Build, SheetOf, add_image};
use crate::fly::setup::{CRYSTALS_PPM, PLACES_M, Setup};
use crate::images::Package;
use crate::images::support::fleet::NodeFile;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{LAST, MASTER};

/// Allowed drifts of a crystal, parts per million per second.
const DRIFTS: std::ops::RangeInclusive<f64> = -1.0..=1.0;

/// Allowed times of the first power-on, virtual seconds.
const POWER_ON: std::ops::RangeInclusive<f64> = 0.0..=3_600.0;

/// Transfers the boards of a file to options.
///
/// # Errors
/// When one has a mistake: file, line and key, and what is allowed.
pub fn apply(reader: &mut Reader, file: &File) -> Result<(), Misuse> {
    let mut end_m = 0.0;
    let mut seen = Vec::new();
    for node in &file.node {
        let id = reader.source.within(&node.id, &(i64::from(MASTER)..=i64::from(LAST)), "")? as u8;
        if seen.contains(&id) {
            let cause = format!("node {id} is there twice; give each Node-ID once");
            return Err(reader.source.wrong(&node.id.span(), cause));
        }
        seen.push(id);
        let setup = setup(reader, node, &mut end_m)?;
        reader.options.setups.insert(id, setup);
        images(reader, node, id)?;
        if !reader.options.nodes().contains(&id) {
            let slaves = reader.options.fleet.slaves;
            let cause = format!(
                "node {id} has no image; give it `image` or `package`, or a larger number of shipped `slaves` than {slaves}"
            );
            return Err(reader.source.wrong(&node.id.span(), cause));
        }
    }
    Ok(())
}

/// Returns place, crystal and power-on. `end_m`: place of the board before, and then of this one.
fn setup(reader: &Reader, node: &Node, end_m: &mut f64) -> Result<Setup, Misuse> {
    let source = &reader.source;
    let optional = |value: &Option<Spanned<f64>>, range, unit| {
        value.as_ref().map(|value| source.within(value, range, unit)).transpose()
    };
    let place = optional(&node.place, &PLACES_M, " m")?;
    let cable = optional(&node.cable, &PLACES_M, " m")?;
    let place_m = match (place, cable, &node.cable) {
        (Some(_), Some(_), Some(cable)) => {
            let cause = "a board has a `place` or a `cable` to the one before it, not both";
            return Err(source.wrong(&cable.span(), cause));
        }
        (None, Some(metres), Some(cable)) => {
            let place_m = *end_m + metres;
            if !PLACES_M.contains(&place_m) {
                let cause =
                    format!("the board would be at {place_m} m; allowed are 0 to {} m", PLACES_M.end());
                return Err(source.wrong(&cable.span(), cause));
            }
            Some(place_m)
        }
        (place, ..) => place,
    };
    *end_m = place_m.unwrap_or(*end_m);
    Ok(Setup {
        place_m,
        crystal_ppm: optional(&node.crystal, &CRYSTALS_PPM, " ppm")?,
        drift_ppm_per_s: optional(&node.drift, &DRIFTS, " ppm/s")?,
        power_on: optional(&node.power_on, &POWER_ON, " s")?,
    })
}

/// Transfers image and data sheet of a board, unless options give others.
fn images(reader: &mut Reader, node: &Node, id: u8) -> Result<(), Misuse> {
    if let (Some(_), Some(package)) = (&node.image, &node.package) {
        let cause = "a board has an `image` or a `package` that is built, not both";
        return Err(reader.source.wrong(&package.span(), cause));
    }
    let of_package = [(&node.manifest, "manifest"), (&node.program, "program")];
    if let Some((Some(value), key)) =
        of_package.into_iter().find(|(value, _)| value.is_some() && node.package.is_none())
    {
        let cause = format!("`{key}` is for a `package`: give its name, too");
        return Err(reader.source.wrong(&value.span(), cause));
    }
    let file = |value: &Spanned<String>| {
        let path = reader.path(value);
        let missing = || reader.source.wrong(&value.span(), format!("there is no file {}", path.display()));
        path.is_file().then_some(path.clone()).ok_or_else(missing)
    };
    let has_own = reader.options.fleet.own_image(id).is_some();
    let image = node.image.as_ref().map(file).transpose()?;
    let sheet = node.eds.as_ref().map(file).transpose()?;
    let manifest = node.manifest.as_ref().map(file).transpose()?;
    let has_sheet = reader.options.sheets.iter().any(|sheet| sheet.node == id);
    if let Some(sheet) = sheet.clone().filter(|_| !has_sheet) {
        reader.options.sheets.push(NodeFile { node: id, file: sheet });
    }
    if has_own {
        return Ok(());
    }
    if let Some(image) = image {
        add_image(&mut reader.options.fleet, id, image);
    }
    if let Some(package) = &node.package {
        let manifest = match manifest {
            Some(manifest) => manifest,
            None => own_manifest(reader, package)?,
        };
        // Named by its package until it is built.
        add_image(&mut reader.options.fleet, id, PathBuf::from(package.get_ref()));
        reader.options.builds.push(Build {
            node: id,
            package: Package { name: package.get_ref().clone(), manifest },
            program: node.program.as_ref().map(|program| program.get_ref().clone()),
            board: None,
            sheet: if sheet.is_some() || has_sheet { SheetOf::File } else { SheetOf::Program },
        });
    }
    Ok(())
}

/// Returns the next Cargo.toml from the folder of the mission file upwards.
fn own_manifest(reader: &Reader, package: &Spanned<String>) -> Result<PathBuf, Misuse> {
    let path = std::path::absolute(reader.source.path).unwrap_or_else(|_| reader.source.path.to_owned());
    let manifests = path.ancestors().skip(1).map(|folder| folder.join("Cargo.toml"));
    let found = manifests.into_iter().find(|manifest| manifest.is_file());
    let cause = "no Cargo.toml beside the mission file or above; give its path by `manifest`";
    found.ok_or_else(|| reader.source.wrong(&package.span(), cause))
}
