//! Each third-party package is compiled once for `cargo demo`, `cargo test` and `cargo xtask`, with one set of
//! features.

use std::collections::BTreeSet;
use std::process::Command;

/// Package with different features, on which only `tempfile` and the tests that use it depend.
const EXCEPTIONS: [&str; 1] = ["getrandom"];

/// Returns third-party packages and their features, as cargo compiles them for these packages of the workspace.
fn compiled(selection: &[&str]) -> BTreeSet<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["tree", "--locked", "--no-dedupe", "--prefix", "none", "--format", "{p} [{f}]"]);
    let output = cargo.args(selection).current_dir(crate::workspace()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let others = text.lines().filter(|line| !line.contains("(/"));
    others.map(|line| line.replace(" (proc-macro)", "")).collect()
}

#[test]
fn packages_of_others_have_one_set_of_features() {
    let all = compiled(&["--workspace"]);
    for selection in
        [&[][..], &["--package", "ecss-can-cli"], &["--package", "xtask"], &["--package", "second"]]
    {
        let compiled = compiled(selection);
        assert!(compiled.len() > 50, "{selection:?}: {compiled:?}");
        let differ = compiled.difference(&all);
        let differ: Vec<_> =
            differ.filter(|package| !EXCEPTIONS.contains(&package.split(' ').next().unwrap())).collect();
        assert!(differ.is_empty(), "{selection:?} and the workspace compile these differently: {differ:?}");
    }
}
