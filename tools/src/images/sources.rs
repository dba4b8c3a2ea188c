//! Place of the sources of the images: the checkout that this program was built in, or the sources that it contains.
//!
//! A program that was installed from packages has no checkout. It writes its [shipped sources](crate::images::shipped) to
//! `ecss-can-VERSION` in the target directory, and builds images there. The environment variable `ECSS_CAN_SOURCES=shipped`
//! does so in a program with a checkout.

use std::env;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::images::{Error, shipped, target, workspace};

/// Variable that selects the sources.
const VARIABLE: &str = "ECSS_CAN_SOURCES";
const SHIPPED: &str = "shipped";

/// Place of the sources of the images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::images) enum Sources {
    /// Root of the repository that this program was built in.
    Checkout(PathBuf),
    /// Folder that the shipped sources are written to.
    Shipped(PathBuf),
}

impl Sources {
    /// Returns the place for this process.
    pub(in crate::images) fn get() -> &'static Sources {
        static SOURCES: LazyLock<Sources> = LazyLock::new(|| {
            if is_checkout() {
                Sources::Checkout(workspace())
            } else {
                Sources::Shipped(target::target().join(concat!("ecss-can-", env!("CARGO_PKG_VERSION"))))
            }
        });
        &SOURCES
    }

    /// Returns the root of the workspace, which [`Sources::write`] may have to write first.
    pub(in crate::images) fn root(&self) -> &Path {
        match self {
            Sources::Checkout(root) | Sources::Shipped(root) => root,
        }
    }

    /// Returns whether `Cargo.lock` contains each package, so that cargo must not change it.
    pub(in crate::images) fn is_locked(&self) -> bool {
        matches!(self, Sources::Checkout(_))
    }

    /// Writes the sources, unless they are in a checkout.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub(in crate::images) fn write(&self) -> Result<(), Error> {
        match self {
            Sources::Checkout(_) => Ok(()),
            Sources::Shipped(root) => shipped::write(root),
        }
    }
}

/// Returns whether the images are built in the checkout that this program was built in: it is there, and no variable selects
/// the shipped sources.
pub(in crate::images) fn is_checkout() -> bool {
    static IS_CHECKOUT: LazyLock<bool> = LazyLock::new(|| {
        env::var(VARIABLE).as_deref() != Ok(SHIPPED)
            && workspace().join("firmware/master/Cargo.toml").is_file()
    });
    *IS_CHECKOUT
}
