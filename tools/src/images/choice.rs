//! Selection of the board of a package: by a dependency `board` in its manifest, or by a feature for each of its
//! boards.

use serde_json::Value;

use crate::images::board_crate::dependencies;
use crate::images::{Error, Package, target};

/// Selection of the board in a manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// It has a dependency with the name `board`, independent of features.
    pub is_fixed: bool,
    /// Its features, including optional dependencies.
    pub features: Vec<String>,
}

impl Package {
    /// Determines by cargo how the package selects its board.
    ///
    /// # Errors
    /// [`Error::NoPackage`], or when cargo cannot read the manifest.
    pub fn choice(&self) -> Result<Choice, Error> {
        let metadata = target::metadata(&self.manifest)?;
        choice(&metadata, &self.name).map_err(|packages| Error::NoPackage {
            name: self.name.clone(),
            manifest: self.manifest.clone(),
            packages,
        })
    }
}

/// Returns the selection of the package `name`, from the output of `cargo metadata`.
///
/// # Errors
/// Without such a package: the names of all packages.
fn choice(metadata: &Value, name: &str) -> Result<Choice, Vec<String>> {
    let packages = metadata["packages"].as_array().map(Vec::as_slice).unwrap_or_default();
    let Some(package) = packages.iter().find(|package| package["name"] == name) else {
        let names = packages.iter().filter_map(|package| package["name"].as_str());
        return Err(names.map(str::to_owned).collect());
    };
    let is_fixed = dependencies(package).any(|board| board["optional"] == false);
    let features = package["features"].as_object().into_iter().flat_map(|features| features.keys());
    Ok(Choice { is_fixed, features: features.cloned().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metadata(dependency: &str, features: &str) -> Value {
        let text = format!(
            r#"{{"packages": [{{"name": "heater", "dependencies": [{dependency}], "features": {features}}}]}}"#
        );
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn dependency_that_is_called_board_is_the_board() {
        let renamed = r#"{"name": "pyboard-v11", "rename": "board", "optional": false}"#;
        let plain = r#"{"name": "board", "rename": null, "optional": false}"#;
        let other = r#"{"name": "pyboard-v11", "rename": null, "optional": false}"#;
        for (dependency, is_fixed) in [(renamed, true), (plain, true), (other, false)] {
            let choice = choice(&metadata(dependency, "{}"), "heater").unwrap();
            assert_eq!(choice.is_fixed, is_fixed, "{dependency}");
        }
    }

    #[test]
    fn boards_as_optional_dependencies_are_features() {
        let optional = r#"{"name": "pyboard-v11", "rename": null, "optional": true}"#;
        let metadata = metadata(optional, r#"{"pyboard-v11": ["dep:pyboard-v11"]}"#);
        let expected = Choice { is_fixed: false, features: vec!["pyboard-v11".to_owned()] };
        assert_eq!(choice(&metadata, "heater"), Ok(expected));
        assert_eq!(choice(&metadata, "cooler"), Err(vec!["heater".to_owned()]));
    }
}
