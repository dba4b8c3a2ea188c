//! Each configuration is built once in a process: cargo needs more than a second to determine that nothing has changed.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use crate::images::Error;

/// Images of a configuration, `None` until they are built.
type Slot = Arc<Mutex<Option<Vec<PathBuf>>>>;

/// Images that this process has built, by the name of their configuration.
static BUILT: Mutex<BTreeMap<String, Slot>> = Mutex::new(BTreeMap::new());

/// Returns the images of a configuration, which `build` makes at the first call. Other configurations can be built
/// meanwhile.
///
/// # Errors
/// Those of `build`; the next call builds again.
pub fn once(
    configuration: String,
    build: impl FnOnce() -> Result<Vec<PathBuf>, Error>,
) -> Result<Vec<PathBuf>, Error> {
    // A build that panicked has left no images.
    let slot = BUILT.lock().unwrap_or_else(PoisonError::into_inner).entry(configuration).or_default().clone();
    let mut images = slot.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(images) = &*images {
        return Ok(images.clone());
    }
    let built = build()?;
    Ok(images.insert(built).clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failure() -> Error {
        Error::Spawn("cargo".into(), std::io::Error::other("out of order"))
    }

    #[test]
    fn configuration_is_built_once() {
        let path = vec![PathBuf::from("a")];
        let build = || Ok(path.clone());
        assert_eq!(once("built once".into(), build).unwrap(), path);
        let again = once("built once".into(), || panic!("built twice"));
        assert_eq!(again.unwrap(), path);
        assert_eq!(once("another".into(), || Ok(Vec::new())).unwrap(), [""; 0].map(PathBuf::from));
    }

    #[test]
    fn failed_build_is_tried_again() {
        assert!(once("fails".into(), || Err(failure())).is_err());
        assert_eq!(once("fails".into(), || Ok(vec!["b".into()])).unwrap(), [PathBuf::from("b")]);
    }
}
