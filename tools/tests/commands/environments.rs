//! Settings of users for their own firmware: variables, configuration files, folders. Images are the same with each of them,
//! or an error says what to do.

use std::fs;
use std::path::Path;
use std::process::Output;

use object::{Object, ObjectSegment};

use crate::TOOLS;
use crate::own_package::{BUILD, text, tiny};

/// An environment of a user.
struct Environment {
    name: &'static str,
    variables: &'static [(&'static str, &'static str)],
    /// `.cargo/config.toml` in a folder above the package.
    configuration: &'static str,
    /// Folder above the package.
    folder: &'static str,
}

const USUAL: Environment = Environment { name: "usual", variables: &[], configuration: "", folder: "usual" };

/// Environments in which the image is that of [`USUAL`].
const SAME: [Environment; 11] = [
    Environment {
        name: "flags for the target",
        variables: &[("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS", "-C link-arg=-Tlink.x -C opt-level=0")],
        folder: "flags-of-target",
        ..USUAL
    },
    Environment {
        name: "flags for everything",
        variables: &[
            ("RUSTFLAGS", "-C link-arg=-Tlink.x"),
            ("CARGO_BUILD_RUSTFLAGS", "-C opt-level=0"),
            ("CARGO_ENCODED_RUSTFLAGS", "-Copt-level=0"),
        ],
        folder: "flags",
        ..USUAL
    },
    Environment {
        name: "flags in a folder above",
        configuration: "[build]\nrustflags = [\"-C\", \"opt-level=0\"]\n[target.'cfg(target_arch = \"arm\")']\n\
                        rustflags = [\"-C\", \"link-arg=-Tlink.x\"]\n",
        folder: "flags-above",
        ..USUAL
    },
    Environment {
        name: "target as a variable",
        variables: &[("CARGO_BUILD_TARGET", "thumbv6m-none-eabi")],
        folder: "target",
        ..USUAL
    },
    Environment {
        name: "target in a folder above",
        configuration: "[build]\ntarget = \"thumbv6m-none-eabi\"\n",
        folder: "target-above",
        ..USUAL
    },
    Environment {
        name: "profile as variables",
        variables: &[
            ("CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "true"),
            ("CARGO_PROFILE_FIRMWARE_OPT_LEVEL", "0"),
            ("CARGO_INCREMENTAL", "1"),
        ],
        folder: "profile",
        ..USUAL
    },
    Environment {
        name: "profile in a folder above",
        configuration: "[profile.release]\noverflow-checks = true\nopt-level = 0\nstrip = true\n",
        folder: "profile-above",
        ..USUAL
    },
    Environment {
        name: "linker",
        variables: &[("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "no-such-linker")],
        configuration: "[target.thumbv7em-none-eabihf]\nlinker = \"no-such-linker\"\n",
        folder: "linker",
    },
    Environment {
        name: "wrapper of the compiler",
        variables: &[("RUSTC_WRAPPER", "/no/such/wrapper"), ("RUSTC_WORKSPACE_WRAPPER", "/no/such/wrapper")],
        configuration: "[build]\nrustc-wrapper = \"/no/such/wrapper\"\n",
        folder: "wrapper",
    },
    Environment {
        name: "toolchain as a variable",
        variables: &[("RUSTUP_TOOLCHAIN", "no-such-toolchain")],
        folder: "toolchain",
        ..USUAL
    },
    Environment { name: "blanks and umlauts", folder: "Meine Geräte/Prüfstand 1", ..USUAL },
];

impl Environment {
    /// Builds the package `tiny` in this environment, below a folder of its own.
    fn build(&self, temporary: &Path) -> Output {
        let above = temporary.join(self.folder);
        tiny(&above, self.configuration, Some(BUILD));
        let mut program = TOOLS.command(&["build"]);
        program.env_remove("CARGO_TARGET_DIR").envs(self.variables.iter().copied());
        program.current_dir(above.join("tiny"));
        program.output().expect("the program starts")
    }

    /// Returns the loadable segments of the image.
    fn segments(&self, temporary: &Path) -> Vec<(u64, Vec<u8>)> {
        let output = self.build(temporary);
        assert!(output.status.success(), "{}: {}", self.name, text(&output));
        segments(&temporary.join(self.folder))
    }
}

/// Returns the loadable segments of the image `tiny` that was built below the folder `above`: address and content.
pub fn segments(above: &Path) -> Vec<(u64, Vec<u8>)> {
    let image = above.join("tiny/target/firmware/tiny");
    let elf = fs::read(&image).unwrap_or_else(|error| panic!("{}: {error}", image.display()));
    let file = object::File::parse(&*elf).expect("an ELF file");
    file.segments().map(|segment| (segment.address(), segment.data().expect("data").to_vec())).collect()
}

/// Given each of these environments, then the image has the same loadable segments as without settings. None of the folders is
/// in a repository of git.
#[test]
fn images_are_the_same_in_each_environment() {
    let temporary = tempfile::tempdir().expect("a temporary directory");
    let usual = USUAL.segments(temporary.path());
    assert!(usual.iter().any(|(_, data)| !data.is_empty()), "{usual:?}");
    for environment in SAME {
        assert_eq!(environment.segments(temporary.path()), usual, "{}", environment.name);
    }
}

/// Given a `rust-toolchain.toml` above the package that names a toolchain that is not installed, then rustup's error names it.
/// Without rustup the file has no effect.
#[test]
fn toolchain_that_is_not_installed_is_named() {
    let temporary = tempfile::tempdir().expect("a temporary directory");
    let pin = "[toolchain]\nchannel = \"no-such-toolchain\"\n";
    fs::write(temporary.path().join("rust-toolchain.toml"), pin).expect("a file");
    let output = USUAL.build(temporary.path());
    if !output.status.success() {
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        assert!(text(&output).contains("no-such-toolchain"), "{}", text(&output));
    }
}
