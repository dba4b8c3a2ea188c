//! Shared data of areas: images, and flights that several areas use.

use std::cell::{OnceCell, RefCell};
use std::ops::ControlFlow;
use std::sync::{Arc, LazyLock};

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::Crystal;
use can_twin::image::Image;
use can_twin::wire::time::Time;
use ecss_can_cli::fly::flight::Flight;
use ecss_can_cli::fly::mission;
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::images::support::board::{Board, Profile};
use ecss_can_cli::images::support::fleet;
use ecss_can_cli::images::{Images, LOG};

/// The board on the twin.
pub static FLOWN: LazyLock<Board> = LazyLock::new(|| Board::shipped(Board::DEFAULT));

/// Returns the board of a node with this image: straps of the node, a perfect crystal, at 0 m, powered from the start.
pub fn board(node: u8, image: &Arc<Image>) -> BoardConfig {
    BoardConfig {
        name: format!("node {node}"),
        model: FLOWN.model(),
        image: image.clone(),
        straps: FLOWN.straps(node),
        crystal: Crystal::ppm(0.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings: Fittings::default(),
    }
}

/// Context of all areas.
#[derive(Default)]
pub struct Context {
    images: RefCell<Vec<(Board, Profile, Images)>>,
    demo: OnceCell<Flight>,
}

impl Context {
    /// Returns master and slave image, which are built once.
    ///
    /// # Errors
    /// When they cannot be built.
    pub fn images(&self, board: &Board, profile: Profile) -> anyhow::Result<Images> {
        let known = self.images.borrow().iter().find(|it| (&it.0, it.1) == (board, profile)).cloned();
        if let Some((.., images)) = known {
            return Ok(images);
        }
        let images = ecss_can_cli::images::build(board.name(), profile.name())?;
        self.images.borrow_mut().push((board.clone(), profile, images.clone()));
        Ok(images)
    }

    /// Returns the flight of `cargo demo` without options.
    ///
    /// # Errors
    /// When it cannot be flown.
    pub fn demo(&self) -> anyhow::Result<&Flight> {
        if let Some(flight) = self.demo.get() {
            return Ok(flight);
        }
        let flight = self.fly(Plan::default())?;
        Ok(self.demo.get_or_init(|| flight))
    }

    /// Flies a plan with shipped images. Boards with one controller have a separate image and are not supported.
    ///
    /// # Errors
    /// When the images cannot be built or flown.
    pub fn fly(&self, plan: Plan) -> anyhow::Result<Flight> {
        let built = self.images(&plan.board, plan.profile)?;
        let mut images = fleet::shipped(&built, plan.boards.iter().map(|board| board.node))?;
        let minimal: Vec<_> = plan.boards.iter().filter(|board| board.is_minimal).collect();
        if !minimal.is_empty() {
            let path = ecss_can_cli::images::build_minimal(plan.board.name(), plan.profile.name(), LOG)?;
            let image = fleet::image(&path)?;
            images.extend(minimal.iter().map(|board| (board.node, image.clone())));
        }
        mission::fly(plan, &images, |_, _| ControlFlow::Continue(()))
    }
}

/// Converts a time to milliseconds.
pub fn milliseconds(time: Time) -> f64 {
    time.as_secs_f64() * 1e3
}
