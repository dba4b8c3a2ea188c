//! Packages that derive a dictionary and a canonical form: each depends on `async-canopen` or on `ecss-can`, or on both, by their own or by other
//! names.
//!
//! A workspace of such packages is made and checked by cargo. The derive macros find the name in the manifest of the package.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A dependency: name in the manifest, package.
type Dependency = (&'static str, &'static str);

const CANOPEN: &str = "async-canopen";
const ECSS: &str = "ecss-can";

/// Each package: its name and its dependencies.
const PACKAGES: [(&str, &[Dependency]); 6] = [
    ("canopen-alone", &[(CANOPEN, CANOPEN)]),
    ("canopen-renamed", &[("can", CANOPEN)]),
    ("ecss-alone", &[(ECSS, ECSS)]),
    ("ecss-renamed", &[("spacecraft", ECSS)]),
    ("both", &[(CANOPEN, CANOPEN), (ECSS, ECSS)]),
    ("both-renamed", &[("can", CANOPEN), ("spacecraft", ECSS)]),
];

/// Folder of a package of this repository.
fn folder(package: &str) -> PathBuf {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    if package == CANOPEN { shared.join("canopen") } else { shared }
}

fn manifest(name: &str, dependencies: &[Dependency]) -> String {
    let mut text = format!("[package]\nname = \"{name}\"\nedition = \"2024\"\n\n[dependencies]\n");
    for (key, package) in dependencies {
        text += &format!("{key} = {{ package = \"{package}\", path = {:?} }}\n", folder(package));
    }
    text
}

/// A device with a record and with limits, and a state machine, by the names of the last dependency.
fn source(dependencies: &[Dependency], mark: &str) -> String {
    let name = dependencies.last().expect("there is one").0.replace('-', "_");
    SOURCE.replace("NAME", &name).replace("MARK", mark)
}

const SOURCE: &str = "
/// A heater.
#[derive(NAME::od::Objects)]
MARK
pub struct Heater {
    /// Set point
    #[object(0x6000, rw, low = -400, high = 850, default = 200)]
    pub setpoint: i16,
    /// Channel
    #[object(0x6001.., record)]
    pub channels: [Channel; 2],
}

/// A channel.
#[derive(NAME::od::Record)]
pub struct Channel {
    /// Power
    #[sub(1, ro, pdo)]
    pub power: u8,
}

const _: NAME::od::Field<i16> = Heater::SETPOINT;

/// A thermostat.
#[derive(NAME::types::Canonical)]
#[canonical(context = NAME::types::Duration)]
pub struct Thermostat {
    #[canonical(age = *context)]
    pub read: NAME::types::Instant,
    #[canonical(within = *context)]
    pub phase: Phase,
    pub setpoint: u8,
}

/// A phase.
#[derive(NAME::types::Canonical)]
#[canonical(context = NAME::types::Duration)]
pub enum Phase {
    /// Heats.
    Heating(#[canonical(grid = *context)] Option<NAME::types::Instant>),
    /// Waits.
    Waiting,
}

const _: fn(&mut Thermostat, NAME::types::Instant, &NAME::types::Duration) = NAME::types::Canonical::canonical;

impl NAME::node::Device for Heater {
    type Pdos = NAME::pdo::PdoObjects<4, 4>;
    type Consumers = NAME::heartbeat::HeartbeatConsumers<1>;
    const PDOS: NAME::pdo::PdoSet = NAME::pdo::PdoSet::NONE;
}
";

/// A workspace of packages: name, dependencies, source of the library. Returns whether they compile, and what the compiler says.
fn check(workspace: &str, packages: &[(&str, &[Dependency], String)]) -> (bool, String) {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(workspace);
    let members: Vec<&str> = packages.iter().map(|(name, ..)| *name).collect();
    for (name, dependencies, source) in packages {
        fs::create_dir_all(root.join(name).join("src")).unwrap();
        fs::write(root.join(name).join("Cargo.toml"), manifest(name, dependencies)).unwrap();
        fs::write(root.join(name).join("src/lib.rs"), source).unwrap();
    }
    fs::write(root.join("Cargo.toml"), format!("[workspace]\nresolver = \"3\"\nmembers = {members:?}\n"))
        .unwrap();
    // The versions of this repository: nothing is downloaded.
    fs::copy(folder(ECSS).join("../Cargo.lock"), root.join("Cargo.lock")).unwrap();
    let checked = Command::new(env!("CARGO"))
        .args(["check", "--workspace", "--offline"])
        .current_dir(&root)
        // One target folder: what both workspaces depend on is compiled once.
        .env("CARGO_TARGET_DIR", root.with_file_name("names-target"))
        .output()
        .unwrap();
    (checked.status.success(), String::from_utf8_lossy(&checked.stderr).into_owned())
}

#[test]
fn declarations_compile_by_each_name_of_their_crate() {
    let packages =
        PACKAGES.map(|(name, dependencies)| (name, dependencies, source(dependencies, "#[objects(device)]")));
    let (compiles, said) = check("names", &packages);
    assert!(compiles, "{said}");
}

/// How a device keeps the spacecraft time is a matter of `ecss-can`. The rest of the declaration is usable: there is one error.
#[test]
fn time_of_a_device_without_ecss_can_is_refused_with_a_reason() {
    let dependencies: &[Dependency] = &[(CANOPEN, CANOPEN)];
    let source = source(dependencies, "#[objects(device, time)]");
    let (compiles, said) = check("no-time", &[("heater", dependencies, source)]);
    assert!(!compiles);
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error")).collect();
    assert_eq!(
        errors[0], "error: `time` is for a device of `ecss-can`, on which this package does not depend",
        "{said}"
    );
    assert!(
        errors[1].starts_with("error: could not compile `heater` (lib) due to 1 previous error"),
        "{said}"
    );
    assert_eq!(errors.len(), 2, "{said}");
}
