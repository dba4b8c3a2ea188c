//! Users with few permissions: without root, with a read-only registry, without a toolchain for the target.
//!
//! Root has all permissions, so a test that root runs gives them up in a user namespace. There the files of root still belong to the
//! user, and their modes hold. Each other user runs the tests as it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ecss_can_cli::images::TARGET;
use ecss_can_cli::images::support::needs::is_root;

use crate::TOOLS;
use crate::environments::segments;
use crate::own_package::{BUILD, text, tiny};

/// Part of Debian's toolchain: `rust-web-src`.
const DEBIAN: &str = "/usr/lib/rustlib/src";

/// Prepares a program for a user who is not root.
fn without_root(program: &str) -> Command {
    if !is_root() {
        return Command::new(program);
    }
    let mut command = Command::new("unshare");
    command.args(["--user", program]);
    command
}

/// Checks that [`without_root`] gives up all permissions of root, and prints the user.
fn check_user() {
    let output = without_root("id").arg("-u").output().expect("id starts");
    let user = text(&output);
    let advice =
        "root cannot give up its permissions here: permit user namespaces, or run the test as another user";
    assert!(output.status.success() && user.trim() != "0", "{advice}\n{user}");
    let how = if is_root() { "root in a user namespace" } else { "the user of the test" };
    eprintln!("commands run as user {}: {how}", user.trim());
}

/// Builds the package `tiny` in the folder `above`. `program`: starts `ecss-can`.
fn build(mut program: Command, above: &Path, home: Option<&Path>) -> Output {
    program.arg("build").current_dir(above.join("tiny")).env_remove("CARGO_TARGET_DIR");
    program.envs(home.map(|home| ("CARGO_HOME", home))).env("CARGO_NET_OFFLINE", "true");
    program.output().expect("the program starts")
}

/// Given a user who is not root, then the image is that of root.
#[test]
fn image_is_the_same_without_root() {
    check_user();
    let temporary = tempfile::tempdir().expect("a temporary directory");
    let images = [("usual", TOOLS.command(&[])), ("without-root", without_root(TOOLS.0))];
    let [usual, other] = images.map(|(folder, program)| {
        let above = temporary.path().join(folder);
        tiny(&above, "", Some(BUILD));
        let output = build(program, &above, None);
        assert!(output.status.success(), "{folder}: {}", text(&output));
        segments(&above)
    });
    assert_eq!(other, usual);
}

/// Given a folder of cargo that an earlier build has filled and that is read-only now, when a package with a dependency is built
/// again, then the image is the same.
#[test]
fn image_is_the_same_with_a_read_only_registry() {
    check_user();
    // In the same place in each run, and with a build of its own: images are built for the path of the registry.
    let above = Path::new(env!("CARGO_TARGET_TMPDIR")).join("read-only");
    let home = cargo_home(&above);
    let [usual, other] = ["writable", "read-only"].map(|registry| {
        tiny(&above, "", Some(BUILD));
        let manifest = above.join("tiny/Cargo.toml");
        let dependency = "[dependencies]\npin-project-lite = \"0.2\"\n";
        fs::write(&manifest, fs::read_to_string(&manifest).expect("a manifest") + dependency)
            .expect("a file");
        let mut program = without_root(TOOLS.0);
        program.env("ECSS_CAN_SOURCES", "shipped");
        let output = build(program, &above, Some(&home));
        assert!(output.status.success(), "{registry}: {}", text(&output));
        let image = segments(&above);
        fs::remove_file(above.join("tiny/target/firmware/tiny")).expect("an image");
        mode("a-w", &home);
        image
    });
    let written = without_root("touch").arg(home.join("registry/new")).output().expect("touch starts");
    mode("u+w", &home);
    assert!(!written.status.success(), "the registry is not read-only");
    assert_eq!(other, usual);
}

/// Given a user who is not root and a computer without a toolchain for the target, then the error has the command that root runs,
/// and nothing is installed.
#[test]
fn missing_toolchain_is_an_error_with_the_command_for_root() {
    check_user();
    let above = tempfile::tempdir().expect("a temporary directory");
    tiny(above.path(), "", Some(BUILD));
    // The one toolchain that is allowed is hidden where it is installed.
    let mut program = if Path::new(DEBIAN).is_dir() {
        let mut hidden = Command::new("unshare");
        let script = format!("mount -t tmpfs none {DEBIAN} && exec unshare --user \"$@\"");
        hidden.args(["--user", "--map-root-user", "--mount", "sh", "-c", &script, "sh", TOOLS.0]);
        hidden
    } else {
        without_root(TOOLS.0)
    };
    program.env("FIRMWARE_TOOLCHAIN", "debian");
    let output = build(program, above.path(), None);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    for part in [&*format!("no toolchain for {TARGET}"), "run as root", "apt-get install -y", "rust-web-src"]
    {
        assert!(text(&output).contains(part), "no {part:?} in\n{}", text(&output));
    }
    assert!(!text(&output).contains("installing"), "{}", text(&output));
}

/// Makes a folder of cargo below `above`, with the packages that the user's own one has, all of them packed.
fn cargo_home(above: &Path) -> PathBuf {
    let home = above.join("home");
    if home.is_dir() {
        mode("u+w", &home);
        fs::remove_dir_all(&home).expect("a folder that can be removed");
    }
    let registry = home.join("registry");
    fs::create_dir_all(&registry).expect("a folder");
    let own = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let own = own.or_else(|| Some(std::env::home_dir()?.join(".cargo"))).expect("a home directory");
    for part in ["index", "cache"] {
        let mut copy = Command::new("cp");
        copy.args(["--recursive", "--symbolic-link"]).arg(own.join("registry").join(part)).arg(&registry);
        assert!(copy.status().expect("cp starts").success(), "cannot copy {part} of the registry");
    }
    for source in fs::read_dir(registry.join("cache")).expect("a folder") {
        let name = source.expect("an entry").file_name();
        fs::create_dir_all(registry.join("src").join(name)).expect("a folder");
    }
    home
}

/// Changes the mode of all folders below one.
fn mode(change: &str, folder: &Path) {
    let mut find = Command::new("find");
    find.arg(folder).args(["-type", "d", "-exec", "chmod", change, "{}", "+"]);
    assert!(find.status().expect("find starts").success(), "cannot change modes below {}", folder.display());
}
