//! `cargo eds`: EDS and DCF (CiA 306) of the devices, from the dictionaries declared in Rust (ECSS 6.6a).

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::Context;
use clap::{Args, ValueEnum};
use ecss_can::node::{MasterObjects, NodeObjects};
use ecss_can::profile;
use ecss_can::types::NodeId;
use ecss_can_eds::network::{self, Sender};
use ecss_can_eds::{Commissioning, Description, Device, Timestamp};
use mission::minimal::MinimalObjects;
use mission::minimal::prototype::PrototypeObjects;
use mission::{CommanderObjects, MissionObjects};

use crate::images::support::board::{BitRate, Profile};
use crate::images::support::misuse::Misuse;
use crate::images::support::output;
use crate::images::support::project::{self, manifest};
use crate::numbers;

/// Names of the data sheets of minimal slaves.
const MINIMAL_EDS: &str = "minimal.eds";
const PROTOTYPE_EDS: &str = "minimal-librecube.eds";
/// Node-IDs of slaves.
const SLAVES: RangeInclusive<u8> = 2..=127;
/// Date of creation of the files, and of the last change of their content.
const CREATED: Timestamp = Timestamp { year: 2026, month: 11, day: 21, hour: 12, minute: 0 };
const MODIFIED: Timestamp = CREATED;

/// Command line of `eds`.
#[derive(Args, Debug)]
pub struct Options {
    /// A device of your own: the package whose program on the host calls `ecss_can_eds::slave_program`, `canopen_program` or
    /// `master_program`
    #[arg(long, value_name = "NAME", conflicts_with = "profile")]
    package: Option<String>,

    /// Cargo.toml of that package or of its workspace [default: the one of the current directory]
    #[arg(long, value_name = "FILE", requires = "package")]
    manifest_path: Option<PathBuf>,

    /// Where the files go [default: docs/eds; the current directory with --package]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Write nothing; exit with 1 and name the files that are not what would be written
    #[arg(long)]
    check: bool,

    /// Leave the entry LastEDS out of the DCF: dcf-tools of 2021 and older reject it
    #[arg(long)]
    no_last_eds: bool,

    /// Read device configuration files of one network instead, and report Node-IDs and COB-IDs that two of them send
    #[arg(long, value_name = "DCF", num_args = 1.., conflicts_with_all = ["package", "out", "check", "slaves", "profile"])]
    check_network: Vec<PathBuf>,

    /// Slaves that get a DCF, 2..127; may be repeated [default: 3 and the minimal slaves of the profile; none with
    /// --package]
    #[arg(long = "slave", value_name = "NODE", value_parser = clap::value_parser!(u8).range(i64::from(*SLAVES.start())..=i64::from(*SLAVES.end())))]
    slaves: Vec<u8>,

    /// Mission profile whose numbers are the defaults
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    profile: Profile,
}

/// Writes the files, or checks whether they are current.
///
/// # Errors
/// When a file cannot be written, or is not current.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if !options.check_network.is_empty() {
        return check_network(&options.check_network);
    }
    let (usual, mut files) = match &options.package {
        Some(package) => (PathBuf::from("."), files_of(package, options)?),
        None => (of_repository(), files(options)?),
    };
    if options.no_last_eds {
        files.iter_mut().for_each(|(_, text)| *text = without_last_eds(text));
    }
    let out = options.out.as_ref().unwrap_or(&usual);
    if options.check {
        return check(out, &files);
    }
    std::fs::create_dir_all(out).with_context(|| format!("making {}", out.display()))?;
    for (name, text) in &files {
        let path = out.join(name);
        std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
    }
    files.iter().try_for_each(|(name, _)| output::line(out.join(name).display()))
}

/// Returns the usual folder of the shipped data sheets: that of the repository, and for an installed program the current one.
fn of_repository() -> PathBuf {
    project::repository().map_or_else(|| PathBuf::from("."), |root| root.join("docs/eds"))
}

/// Removes the entry that names the data sheet from a file.
fn without_last_eds(text: &str) -> String {
    text.split_inclusive('\n').filter(|line| !line.starts_with("LastEDS=")).collect()
}

/// Reports Node-IDs and COB-IDs that two devices of a network have in common (ECSS 6.10l, m).
fn check_network(files: &[PathBuf]) -> anyhow::Result<()> {
    let mut senders = Vec::new();
    for path in files {
        let refuse =
            |text: String| Misuse::of("eds", format!("invalid value for '--check-network <DCF>...': {text}"));
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| refuse(format!("{name}: {error}")))?;
        senders.push(Sender::of_dcf(&name, &bytes).map_err(|error| refuse(error.to_string()))?);
    }
    let conflicts = network::conflicts(&senders);
    let list: Vec<String> = conflicts.iter().map(|conflict| format!("\n  {conflict}")).collect();
    anyhow::ensure!(conflicts.is_empty(), "these devices cannot be on one network:{}", list.concat());
    let sent: usize = senders.iter().map(|sender| sender.sent.len()).sum();
    output::line(format!("{} devices send {sent} COB-IDs, each from one device", senders.len()))
}

fn check(out: &Path, files: &[(String, String)]) -> anyhow::Result<()> {
    let is_stale = |(name, text): &&(String, String)| {
        let there = std::fs::read_to_string(out.join(name)).unwrap_or_default();
        there.replace("\r\n", "\n") != *text
    };
    let stale: Vec<&str> = files.iter().filter(is_stale).map(|(name, _)| name.as_str()).collect();
    anyhow::ensure!(
        stale.is_empty(),
        "not current in {}: {}; run `ecss-can eds` without `--check`",
        out.display(),
        stale.join(", ")
    );
    Ok(())
}

/// Returns names and texts of the files that a package prints.
fn files_of(package: &str, options: &Options) -> anyhow::Result<Vec<(String, String)>> {
    let manifest = manifest(options.manifest_path.as_deref())?;
    let mut files = vec![printed(package, &manifest, None)?];
    for &node in &options.slaves {
        files.push(printed(package, &manifest, Some(node))?);
    }
    Ok(files)
}

/// Runs a package on the host. Returns the name of the data sheet that it prints, and its text.
///
/// # Errors
/// When the package does not build, fails, or prints no data sheet.
pub(crate) fn printed(package: &str, manifest: &Path, node: Option<u8>) -> anyhow::Result<(String, String)> {
    let mut cargo = crate::images::host_cargo();
    cargo.current_dir(manifest.parent().unwrap_or(Path::new(".")));
    cargo.args(["run", "--quiet", "--package", package, "--manifest-path"]).arg(manifest).arg("--");
    if let Some(node) = node {
        cargo.args(["--node", &node.to_string()]);
    }
    let output = cargo.stderr(Stdio::inherit()).output().context("cannot run cargo")?;
    anyhow::ensure!(output.status.success(), "the program of {package} failed ({})", output.status);
    let text = String::from_utf8(output.stdout).context("what it printed is no text")?;
    let name = text.lines().find_map(|line| line.strip_prefix("FileName="));
    let name = name.filter(|name| Path::new(name).file_name().is_some_and(|file| file == *name));
    let remedy = "call ecss_can_eds::slave_program or ecss_can_eds::canopen_program in its main, where it is built for the host";
    let name = name.with_context(|| format!("{package} printed no data sheet: {remedy}"))?;
    Ok((name.to_owned(), text))
}

/// Returns names and texts of the files.
fn files(options: &Options) -> anyhow::Result<Vec<(String, String)>> {
    let profile = numbers(options.profile);
    let description = Description::new(&slave_device(options.profile), |node| slave(node, profile))?;
    let mut files = vec![("slave.eds".into(), description.eds("slave.eds"))];
    let (minimal, prototype) = minimal_descriptions()?;
    let slaves = if options.slaves.is_empty() { usual_slaves(profile) } else { options.slaves.clone() };
    for node in slaves {
        let node = NodeId::new(node).context("a Node-ID is 1..127")?;
        if is_minimal(profile, node) {
            files.push(minimal_dcf(node, options.profile, [&minimal, &prototype])?);
            continue;
        }
        let name = format!("slave-{}.dcf", node.get());
        let commissioning = commissioning(node, format!("slave {}", node.get()), profile);
        let text = description.dcf(&name, "slave.eds", &commissioning, &mut slave(node, profile))?;
        files.push((name, text));
    }
    let description = Description::new(&master_device(options.profile), |_| master(profile))?;
    files.push(("master.eds".into(), description.eds("master.eds")));
    let commissioning = commissioning(NodeId::MASTER, "master".into(), profile);
    let text = description.dcf("master.dcf", "master.eds", &commissioning, &mut master(profile))?;
    files.push(("master.dcf".into(), text));
    files.push((MINIMAL_EDS.into(), minimal.eds(MINIMAL_EDS)));
    files.push((PROTOTYPE_EDS.into(), prototype.eds(PROTOTYPE_EDS)));
    Ok(files)
}

/// Returns a full slave, and the minimal ones of the profile.
fn usual_slaves(profile: &profile::Profile) -> Vec<u8> {
    std::iter::once(3).chain(profile.minimal.iter().map(|slave| slave.node.get())).collect()
}

fn is_minimal(profile: &profile::Profile, node: NodeId) -> bool {
    profile.minimal.iter().any(|slave| slave.node == node)
}

/// Minimal slaves have other PDOs in profile `librecube`: a description for each, independent of the profile of the
/// others.
fn minimal_descriptions() -> anyhow::Result<(Description, Description)> {
    let (standard, librecube) = (numbers(Profile::Standard), numbers(Profile::Librecube));
    let minimal = |node| MinimalObjects::new(node, standard);
    let prototype = |node| PrototypeObjects::new(node, librecube);
    Ok((
        Description::new(&minimal_device(Profile::Standard), minimal)?,
        Description::new(&minimal_device(Profile::Librecube), prototype)?,
    ))
}

/// Name and text of the DCF of a minimal slave.
fn minimal_dcf(
    node: NodeId,
    of: Profile,
    [minimal, prototype]: [&Description; 2],
) -> anyhow::Result<(String, String)> {
    let profile = numbers(of);
    let name = format!("minimal-{}.dcf", node.get());
    let commissioning = commissioning(node, format!("minimal slave {}", node.get()), profile);
    let text = match of {
        Profile::Librecube => {
            let mut objects = PrototypeObjects::new(node, profile);
            prototype.dcf(&name, PROTOTYPE_EDS, &commissioning, &mut objects)
        }
        Profile::Standard | Profile::Standby => {
            let mut objects = MinimalObjects::new(node, profile);
            minimal.dcf(&name, MINIMAL_EDS, &commissioning, &mut objects)
        }
    };
    Ok((name, text?))
}

fn commissioning(node: NodeId, name: String, profile: &profile::Profile) -> Commissioning {
    Commissioning {
        name,
        bit_rate: (profile.network.bit_rate.get() / 1000) as u16,
        network_name: "ecss-can".into(),
        ..Commissioning::new(node)
    }
}

fn slave_device(profile: Profile) -> Device {
    let device = device("Slave", "slave", "Slave of ECSS-E-ST-50-15C on two CAN buses", profile);
    Device { boot_up_slave: true, ..device }
}

/// The slave of clause 9 (ECSS 9.2a).
fn minimal_device(profile: Profile) -> Device {
    let description = "Minimal slave of ECSS-E-ST-50-15C, clause 9";
    let mut device = device("Minimal slave", "minimal", description, profile);
    let comment = "Objects are hard-coded: no SDO reaches them, and no NMT command changes a state.";
    device.comments.push(comment.into());
    device
}

fn master_device(profile: Profile) -> Device {
    let device = device("Master", "master", "Master of ECSS-E-ST-50-15C on two CAN buses", profile);
    Device { nodes: NodeId::MASTER.get()..=NodeId::MASTER.get(), boot_up_master: true, ..device }
}

/// A device of this project: what all have in common.
fn device(product: &str, order_code: &str, description: &str, profile: Profile) -> Device {
    Device {
        product: product.into(),
        order_code: order_code.into(),
        description: format!("{description}, profile {}", profile.name()),
        nodes: SLAVES,
        vendor: "The ecss-can authors".into(),
        author: "cargo eds".into(),
        modified: MODIFIED,
        bit_rates: BitRate::value_variants().iter().rev().map(|rate| rate.kbit()).collect(),
        comments: vec![
            "Both buses, nominal and redundant, lead to this one dictionary.".into(),
            "The bit rate is chosen when the image is built.".into(),
        ],
        ..Device::new(CREATED)
    }
}

/// The objects of the master at power-on.
fn master(profile: &profile::Profile) -> NodeObjects<MasterObjects<CommanderObjects>> {
    let mut objects = mission::master(profile).build().objects().clone();
    // Boards have a parameter store.
    (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
    objects
}

/// The objects of a slave at power-on.
fn slave(node: NodeId, profile: &profile::Profile) -> NodeObjects<MissionObjects<Vec<u8>>> {
    let mut objects = mission::slave(node, profile, Vec::new()).build().objects().clone();
    // Boards have a parameter store.
    (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
    objects
}
