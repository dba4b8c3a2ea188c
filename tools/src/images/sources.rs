//! Place of the sources of the images: the checkout that this program was built in, or the sources that it contains.
//!
//! A program that was installed from packages has no checkout. It writes its [shipped sources](crate::images::shipped) to
//! `ecss-can-VERSION` in the target directory, and builds images there. The environment variable `ECSS_CAN_SOURCES=shipped`
//! does so in a program with a checkout.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::images::{Error, checkout, shipped, target, workspace};

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
            if checkout::is_there() {
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
