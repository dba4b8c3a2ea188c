//! The *checkout*: the repository that this program was built in. An installed program has none.

use std::env;
use std::path::PathBuf;
use std::sync::LazyLock;

use crate::images::workspace;

/// Variable that selects the sources of the images.
const VARIABLE: &str = "ECSS_CAN_SOURCES";
const SHIPPED: &str = "shipped";

/// Returns whether the images are built in the checkout: it is there, and no variable selects the shipped sources.
pub(in crate::images) fn is_there() -> bool {
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| {
        env::var(VARIABLE).as_deref() != Ok(SHIPPED)
            && workspace().join("firmware/master/Cargo.toml").is_file()
    });
    *IS_THERE
}

/// Returns the next `Cargo.toml` from the current folder upwards, if there is one.
pub(in crate::images) fn next_manifest() -> Option<PathBuf> {
    let here = env::current_dir().ok()?;
    here.ancestors().map(|folder| folder.join("Cargo.toml")).find(|path| path.is_file())
}

/// Returns the next `Cargo.toml` from the current folder upwards. `None`: there is none, or it belongs to the checkout in which
/// the images are built.
pub(in crate::images) fn manifest_elsewhere() -> Option<PathBuf> {
    let manifest = next_manifest()?;
    let is_ours = is_there() && workspace().canonicalize().is_ok_and(|root| manifest.starts_with(root));
    (!is_ours).then_some(manifest)
}
