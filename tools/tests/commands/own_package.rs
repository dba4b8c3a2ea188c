//! Firmware of a user with own cargo settings, on which the build does not depend.

use std::fs;
use std::path::Path;
use std::process::Output;

use second::programs::root;
use tempfile::TempDir;

use crate::TOOLS;

/// Variables of users who build their firmware with cargo only.
const VARIABLES: [(&str, &str); 6] = [
    ("CARGO_BUILD_TARGET", "thumbv7em-none-eabihf"),
    ("CARGO_INCREMENTAL", "1"),
    ("CARGO_PROFILE_RELEASE_STRIP", "true"),
    ("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "no-such-linker"),
    ("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS", "-C link-arg=-Tlink.x"),
    ("RUSTFLAGS", "-C link-arg=-Tlink.x"),
];

/// These settings in a configuration file.
const CONFIGURATION: &str = r#"
[build]
target = "thumbv7em-none-eabihf"
incremental = true
[profile.release]
strip = true
[target.thumbv7em-none-eabihf]
linker = "no-such-linker"
rustflags = ["-C", "link-arg=-Tlink.x"]
[target.'cfg(target_arch = "arm")']
rustflags = ["-C", "link-arg=-Tlink.x"]
"#;

const PROGRAM: &str = r#"
#![no_std]
#![no_main]
#[unsafe(link_section = ".vector_table")]
#[unsafe(no_mangle)]
pub static TABLE: (u32, extern "C" fn() -> !) = (0x2002_0000, reset);
#[unsafe(no_mangle)]
extern "C" fn reset() -> ! {
    let mut count = 0u32;
    loop {
        count += 1;
        core::hint::black_box(count);
    }
}
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
"#;

const SCRIPT: &str = "MEMORY { FLASH : ORIGIN = 0x08000000, LENGTH = 1M }
ENTRY(reset)
SECTIONS { .text : { KEEP(*(.vector_table)) *(.text*) } > FLASH }
";

pub const BUILD: &str = r#"fn main() {
    println!("cargo:rustc-link-search={}", std::env::var("CARGO_MANIFEST_DIR").unwrap());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
}
"#;

/// Writes a package `tiny` below a folder with this configuration of cargo. It has this build script.
pub fn tiny(folder: &Path, configuration: &str, build: Option<&str>) {
    let write = |path: &str, text: &str| {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    };
    write(".cargo/config.toml", configuration);
    write("tiny/Cargo.toml", "[package]\nname = \"tiny\"\nedition = \"2024\"\n[workspace]\n");
    write("tiny/src/main.rs", PROGRAM);
    write("tiny/link.x", SCRIPT);
    if let Some(build) = build {
        write("tiny/build.rs", build);
    }
}

/// The package `tiny` in a temporary folder with [`CONFIGURATION`].
fn configured(build: Option<&str>) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary directory");
    tiny(folder.path(), CONFIGURATION, build);
    folder
}

/// Runs `ecss-can build` for the package, with the variables and these.
fn build(folder: &Path, variables: &[(&str, &Path)]) -> Output {
    let manifest = folder.join("tiny/Cargo.toml");
    let mut program = TOOLS.command(&["build", "--manifest-path", manifest.to_str().expect("UTF-8")]);
    program.envs(VARIABLES).envs(variables.iter().copied()).current_dir(folder);
    program.output().expect("the program starts")
}

/// Returns all that a program printed.
pub fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// Given variables and a configuration file with flags, linker, profile and target of others, then the image is built as without them.
#[test]
fn settings_of_the_user_do_not_reach_images() {
    let folder = configured(Some(BUILD));
    let output = build(folder.path(), &[]);
    assert!(output.status.success(), "{}", text(&output));
    let image = folder.path().join("tiny/target/firmware/tiny");
    assert!(text(&output).contains(&image.display().to_string()), "{}", text(&output));
    let elf = fs::read(image).expect("an image");
    assert!(elf.windows(5).any(|name| name == b"TABLE"), "it keeps its symbols");
}

/// Given `CARGO_TARGET_DIR`, as a path from the root or from the current folder, then the image is there.
#[test]
fn image_is_in_the_target_directory_of_the_user() {
    let folder = configured(Some(BUILD));
    for directory in [&*folder.path().join("mine"), Path::new("other")] {
        let output = build(folder.path(), &[("CARGO_TARGET_DIR", directory)]);
        let image = folder.path().join(directory).join("firmware/tiny");
        assert!(text(&output).contains(&image.display().to_string()), "{}", text(&output));
        assert!(image.is_file(), "{}", image.display());
    }
    assert!(!folder.path().join("tiny/target").exists());
}

/// Given a package whose link arguments are in a configuration file alone, or nowhere, then its image is refused.
#[test]
fn image_without_linker_script_is_an_error() {
    let folder = configured(None);
    let output = build(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    for part in ["tiny is no image", "add a build.rs", "-Tlink.x"] {
        assert!(text(&output).contains(part), "{}", text(&output));
    }
}

/// Given a board whose manifest names no chip, then no build begins, and the board is named: the HAL would panic in its build script.
#[test]
fn board_without_chip_is_refused_before_the_build() {
    let folder = configured(Some(BUILD));
    let board = folder.path().join("board");
    fs::create_dir_all(board.join("src")).expect("a folder");
    let write = |path: &Path, text: String| fs::write(path, text).expect("a file");
    let memory = root().join("boards/memory");
    let manifest = format!(
        "[package]\nname = \"bare-board\"\nedition = \"2024\"\n[workspace]\n[dependencies]\n\
         embassy-stm32 = {{ version = \"=0.6.0\", default-features = false }}\n\
         [build-dependencies]\necss-can-memory = {{ path = \"{}\" }}\n",
        memory.display()
    );
    write(&board.join("Cargo.toml"), manifest);
    write(&board.join("src/lib.rs"), String::new());
    fs::copy(root().join("boards/pyboard-v11/board.toml"), board.join("board.toml")).expect("a file");
    let tiny = folder.path().join("tiny/Cargo.toml");
    let dependency = "[dependencies]\nboard = { package = \"bare-board\", path = \"../board\" }\n";
    write(&tiny, fs::read_to_string(&tiny).expect("a manifest") + dependency);
    let of_board = TOOLS.command(&["build", "--board", board.to_str().expect("UTF-8")]).output();
    for output in [build(folder.path(), &[]), of_board.expect("the program starts")] {
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        for part in ["/board: Cargo.toml: embassy-stm32 has no feature that names a chip", "stm32f405rg"] {
            assert!(text(&output).contains(part), "{}", text(&output));
        }
        assert!(!text(&output).contains("Compiling"), "{}", text(&output));
    }
}

/// Given a package that names its board in its manifest, then it is built for that board alone. Given a workspace without images,
/// or a feature that the package does not have, then the error names what is allowed.
#[test]
fn wrong_boards_packages_and_features_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    fs::create_dir(folder.path().join("src")).expect("a folder");
    let manifest = folder.path().join("Cargo.toml");
    let dependency = format!(
        "[package]\nname = \"heater\"\nedition = \"2024\"\n[features]\nfast = []\n[dependencies]\n\
         board = {{ package = \"ecss-can-pyboard-v11\", path = \"{}/boards/pyboard-v11\" }}\n",
        root().display()
    );
    fs::write(&manifest, dependency).expect("a file");
    fs::write(folder.path().join("src/lib.rs"), "").expect("a file");
    let path = manifest.to_str().expect("UTF-8");
    for (arguments, said) in [
        (
            &["--board", "nucleo-f446re"][..],
            &["the package heater has no dependency nucleo-f446re", "it chooses its board in Cargo.toml"][..],
        ),
        (&["--package", "cooler"], &["'cooler'", "allowed are heater", "Usage: ecss-can build"]),
        (&["--features", "fast,slow"], &["'slow'", "heater has no such feature", "allowed are fast"]),
        (&["--profile", "standard"], &["--profile", "cannot be used with"]),
        (&["slave"], &["IMAGE", "cannot be used with"]),
    ] {
        TOOLS.refuses(&[&["build", "--manifest-path", path], arguments].concat(), said);
    }
    fs::remove_file(folder.path().join("src/lib.rs")).expect("a file");
    fs::write(&manifest, "[workspace]\n").expect("a file");
    TOOLS.refuses(&["build", "--manifest-path", path], &["no package with an image", "--package NAME"]);
}
