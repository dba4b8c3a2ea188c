//! The licences of everything that is linked or run are among those that `deny.toml` allows.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use spdx::{Expression, Licensee, ParseMode};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace").to_owned()
}

/// What `deny.toml` allows.
fn allowed() -> Vec<Licensee> {
    let text = std::fs::read_to_string(root().join("deny.toml")).expect("deny.toml is there");
    let table: toml::Table = text.parse().expect("deny.toml is TOML");
    let names = table["licenses"]["allow"].as_array().expect("a list");
    names.iter().map(|name| Licensee::parse(name.as_str().expect("a name")).expect("an SPDX name")).collect()
}

/// Whether a choice that the expression leaves is allowed. Older packages write "/" for OR.
fn is_covered(expression: &str, allowed: &[Licensee]) -> bool {
    let Ok(expression) = Expression::parse_mode(expression, ParseMode::LAX) else { return false };
    expression.evaluate(|asked| allowed.iter().any(|licensee| licensee.satisfies(asked)))
}

/// Name, version and licence of each package, for every target, whether it is built here or not.
fn packages() -> Vec<(String, Option<String>)> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
        .current_dir(root())
        .output()
        .expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let of = |package: &Value, key: &str| package[key].as_str().map(str::to_owned);
    let packages = metadata["packages"].as_array().expect("a list").iter();
    packages
        .map(|package| {
            let [name, version] = ["name", "version"].map(|key| of(package, key).expect("a text"));
            (format!("{name} {version}"), of(package, "license"))
        })
        .collect()
}

#[test]
fn the_licence_of_every_package_is_allowed() {
    let (allowed, packages) = (allowed(), packages());
    assert!(packages.iter().any(|(name, _)| name.starts_with("ecss-can ")), "the workspace is among them");
    let refused: Vec<_> = packages
        .iter()
        .filter(|(_, licence)| !licence.as_deref().is_some_and(|licence| is_covered(licence, &allowed)))
        .collect();
    assert!(refused.is_empty(), "not covered by deny.toml: {refused:#?}");
}

#[test]
fn nothing_is_allowed_that_no_package_needs() {
    let (allowed, packages) = (allowed(), packages());
    let licences: BTreeSet<&str> = packages.iter().filter_map(|(_, licence)| licence.as_deref()).collect();
    for (place, licensee) in allowed.iter().enumerate() {
        let mut others = allowed.clone();
        others.remove(place);
        let is_needed = licences.iter().any(|licence| !is_covered(licence, &others));
        assert!(is_needed, "no package needs {licensee}");
    }
}

#[test]
fn one_of_alternatives_and_all_of_a_conjunction_must_be_allowed() {
    let allowed = ["MIT", "BSD-3-Clause"].map(|name| Licensee::parse(name).unwrap());
    let covered = ["MIT", "GPL-3.0-only OR MIT", "GPL-2.0-only/MIT", "Apache-2.0 / MIT"];
    let covered = covered.into_iter().chain(["(Apache-2.0 OR MIT) AND BSD-3-Clause"]);
    for expression in covered {
        assert!(is_covered(expression, &allowed), "{expression}");
    }
    let refused = ["GPL-3.0-only", "MIT AND GPL-3.0-only", "Apache-2.0 OR ISC", "(MIT OR ISC) AND Zlib"];
    for expression in refused.into_iter().chain(["", "Free for all", "Apache-2.0 WITH LLVM-exception"]) {
        assert!(!is_covered(expression, &allowed), "{expression}");
    }
}
