//! Where images are built for a board.

use crate::Error;
use crate::board_crate::BoardCrate;
use crate::elsewhere::Elsewhere;

/// Where images are built for a board, and what their folders are named after.
pub(crate) enum Site {
    /// This workspace; the name of the board.
    Here(String),
    /// A workspace that is generated.
    Elsewhere(Elsewhere),
}

impl Site {
    /// The site for a board.
    ///
    /// # Errors
    /// When the folder of a board elsewhere has no usable `Cargo.toml`.
    pub(crate) fn of(board: BoardCrate) -> Result<Site, Error> {
        match board {
            BoardCrate::Shipped(name) => Ok(Site::Here(name.to_owned())),
            BoardCrate::Elsewhere(folder) => Ok(Site::Elsewhere(Elsewhere::of(folder)?)),
        }
    }

    /// Name of the board in folders, different for each board.
    pub(crate) fn id(&self) -> String {
        match self {
            Site::Here(name) => name.clone(),
            Site::Elsewhere(elsewhere) => elsewhere.id(),
        }
    }

    /// Name of the board for people.
    pub(crate) fn name(&self) -> &str {
        match self {
            Site::Here(name) => name,
            Site::Elsewhere(elsewhere) => &elsewhere.package,
        }
    }

    /// Feature of the images that chooses the board. A generated workspace has none.
    pub(crate) fn feature(&self) -> Option<&str> {
        match self {
            Site::Here(name) => Some(name),
            Site::Elsewhere(_) => None,
        }
    }
}
