//! What is needed for building images and flashing boards, and the commands that install it.

use super::machine::Machine;
use crate::images::{TARGET, Toolchain};

/// Oldest compiler that can be used: that of the manifests of this project.
const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

/// Installs rustup.
const RUSTUP: &str = "curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh";

/// A part that is there or missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Finding {
    /// Its name.
    pub(super) part: String,
    /// Images cannot be built without it. Otherwise it is needed for flashing only.
    is_for_images: bool,
    /// Version or place, or the command that installs it.
    pub(super) state: Result<String, String>,
}

impl Finding {
    /// Returns whether images cannot be built because it is missing.
    pub(super) fn prevents_images(&self) -> bool {
        self.is_for_images && self.state.is_err()
    }

    /// Returns what it is needed for.
    pub(super) fn purpose(&self) -> &'static str {
        if self.is_for_images { "needed to build images" } else { "needed to flash boards" }
    }
}

/// Returns all parts, first those for images.
pub(super) fn findings(machine: &Machine) -> Vec<Finding> {
    let path = |path: &Option<std::path::PathBuf>| path.as_ref().map(|path| path.display().to_string());
    let images = [
        (format!("Rust {OLDEST} or later"), compiler(machine)),
        (format!("toolchain for {TARGET}"), toolchain(machine)),
        ("linker of images".to_owned(), linker(machine)),
        (
            "linker of this computer".to_owned(),
            path(&machine.cc).ok_or("sudo apt-get install -y gcc libc6-dev".into()),
        ),
    ];
    let rules = "curl -sSf https://probe.rs/files/69-probe-rs.rules | sudo tee /etc/udev/rules.d/69-probe-rs.rules && \
                 sudo udevadm control --reload && sudo udevadm trigger";
    let flashing = [
        (
            "probe-rs".to_owned(),
            machine.probe_rs.clone().ok_or("cargo install --locked probe-rs-tools".into()),
        ),
        ("permission for debug probes".to_owned(), machine.may_use_probes.clone().ok_or(rules.into())),
    ];
    let finding = |is_for_images| move |(part, state)| Finding { part, is_for_images, state };
    images.into_iter().map(finding(true)).chain(flashing.into_iter().map(finding(false))).collect()
}

fn compiler(machine: &Machine) -> Result<String, String> {
    let version = machine.compiler.clone().ok_or(RUSTUP)?;
    let update = if machine.has_rustup { "rustup update stable" } else { RUSTUP };
    if numbers(&version) < numbers(OLDEST) { Err(update.into()) } else { Ok(version) }
}

fn toolchain(machine: &Machine) -> Result<String, String> {
    match &machine.toolchain {
        Ok(toolchain) => Ok(toolchain.name().to_owned()),
        Err(_) if machine.has_rustup && machine.may_add_target => Err(format!("rustup target add {TARGET}")),
        Err(debian) => Err(format!("sudo sh -c '{debian}'")),
    }
}

/// The linker comes with its toolchain.
fn linker(machine: &Machine) -> Result<String, String> {
    match (&machine.toolchain, &machine.rust_lld) {
        (Ok(Toolchain::Debian), _) => Ok("/usr/bin/ld.lld".into()),
        (_, Some(path)) => Ok(path.display().to_string()),
        (Ok(Toolchain::Rustup), None) => Err(RUSTUP.into()),
        (Err(_), None) => toolchain(machine),
    }
}

/// Returns the numbers of a version, `(1, 95)` for "rustc 1.95.0".
fn numbers(text: &str) -> Option<(u32, u32)> {
    let version = text.split(' ').find(|word| word.starts_with(|letter: char| letter.is_ascii_digit()))?;
    let mut parts = version.split('.');
    Some((parts.next()?.parse().ok()?, parts.next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
        Machine {
            compiler: Some("rustc 1.99.0 (0123 2026-01-01)".into()),
            toolchain: Ok(Toolchain::Rustup),
            has_rustup: true,
            may_add_target: true,
            rust_lld: Some("/lld".into()),
            cc: Some("/usr/bin/cc".into()),
            probe_rs: Some("probe-rs 0.30.0".into()),
            may_use_probes: Some("root".into()),
        }
    }

    /// Commands of what is missing; `true`: images cannot be built without it.
    fn missing(machine: &Machine) -> Vec<(bool, String)> {
        let missing = findings(machine).into_iter();
        missing.filter_map(|part| Some((part.prevents_images(), part.state.err()?))).collect()
    }

    #[test]
    fn nothing_is_missing_on_a_computer_that_has_all() {
        assert_eq!(missing(&machine()), []);
        assert_eq!(missing(&Machine { toolchain: Ok(Toolchain::Debian), rust_lld: None, ..machine() }), []);
    }

    #[test]
    fn target_is_installed_by_rustup_or_debian() {
        let debian = || Err("apt-get install -y lld".to_owned());
        let by_rustup = Machine { toolchain: debian(), ..machine() };
        assert_eq!(missing(&by_rustup), [(true, format!("rustup target add {TARGET}"))]);
        for (has_rustup, may_add_target) in [(false, true), (true, false)] {
            let by_debian = Machine { toolchain: debian(), has_rustup, may_add_target, ..machine() };
            assert_eq!(missing(&by_debian), [(true, "sudo sh -c 'apt-get install -y lld'".to_owned())]);
        }
    }

    #[test]
    fn old_compiler_is_updated_and_a_missing_one_installed() {
        let old = Machine { compiler: Some("rustc 1.75.0".into()), ..machine() };
        assert_eq!(missing(&old), [(true, "rustup update stable".to_owned())]);
        let none = Machine { compiler: None, has_rustup: false, ..machine() };
        assert!(missing(&none)[0].1.contains("sh.rustup.rs"));
    }

    #[test]
    fn images_are_built_without_probe_and_permission() {
        let missing = missing(&Machine { probe_rs: None, may_use_probes: None, ..machine() });
        let of_images: Vec<bool> = missing.iter().map(|(is_for_images, _)| *is_for_images).collect();
        assert_eq!(of_images, [false, false]);
        assert!(missing[0].1.contains("probe-rs-tools") && missing[1].1.contains("69-probe-rs.rules"));
    }
}
