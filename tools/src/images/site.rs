//! Workspace in which images are built for a board.

use std::path::PathBuf;

use crate::images::Error;
use crate::images::board_crate::BoardCrate;
use crate::images::elsewhere::Elsewhere;
use crate::images::sources::Sources;

/// Workspace in which images are built for a board, and names of their folders.
pub(in crate::images) struct Site {
    /// Name of the board in folders, different for each board.
    pub(in crate::images) id: String,
    /// Name of the board in messages; in the workspace of the sources also the feature of the images that selects it.
    pub(in crate::images) name: String,
    /// The workspace that is generated for a board of another repository; `None`: the workspace of the sources.
    pub(in crate::images) elsewhere: Option<Elsewhere>,
}

impl Site {
    /// Returns the site for a board.
    ///
    /// # Errors
    /// When the folder of a board elsewhere has no usable `Cargo.toml`.
    pub(in crate::images) fn of(board: BoardCrate) -> Result<Site, Error> {
        match board {
            BoardCrate::Shipped(name) => Ok(Site { id: name.into(), name: name.into(), elsewhere: None }),
            BoardCrate::Elsewhere(folder) => {
                let board = Elsewhere::of(folder)?;
                Ok(Site { id: board.id(), name: board.package.clone(), elsewhere: Some(board) })
            }
        }
    }

    /// Folder of the workspace.
    pub(in crate::images) fn home(&self) -> PathBuf {
        self.elsewhere.as_ref().map_or_else(|| Sources::get().root().to_owned(), Elsewhere::home)
    }

    /// Returns whether cargo must not change `Cargo.lock`.
    pub(in crate::images) fn is_locked(&self) -> bool {
        self.elsewhere.is_none() && Sources::get().is_locked()
    }

    /// Writes the workspace, if it is generated.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub(in crate::images) fn write(&self) -> Result<(), Error> {
        Sources::get().write()?;
        self.elsewhere.as_ref().map_or(Ok(()), Elsewhere::write)
    }
}
