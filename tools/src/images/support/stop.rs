//! Ctrl-C and SIGTERM as a flag, for an orderly end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// Flag that the program has to end.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Makes Ctrl-C and SIGTERM set the flag from now on. Before this call they end the program at once, also while it
    /// builds images or waits for another build.
    ///
    /// # Errors
    /// When the system does not allow it, or on the second call.
    pub fn at_ctrl_c() -> anyhow::Result<Stop> {
        let stop = Stop::default();
        let raised = stop.clone();
        ctrlc::set_handler(move || raised.ask()).context("cannot handle Ctrl-C")?;
        Ok(stop)
    }

    /// Sets the flag.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns whether the flag is set.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
