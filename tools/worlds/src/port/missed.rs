//! Frames that a controller misses.

use std::fmt;
use std::rc::Rc;

use ecss_can::types::Frame;

type IsMissed = dyn Fn(&Frame) -> bool;

/// Frames that a controller acknowledges on the bus but does not pass to its task. None by default.
#[derive(Clone, Default)]
pub(crate) struct Missed(Option<Rc<IsMissed>>);

impl Missed {
    /// Makes the set of the frames for which `is_missed` returns true at their end.
    pub fn those(is_missed: impl Fn(&Frame) -> bool + 'static) -> Missed {
        Missed(Some(Rc::new(is_missed)))
    }

    pub fn contains(&self, frame: &Frame) -> bool {
        self.0.as_ref().is_some_and(|is_missed| is_missed(frame))
    }
}

impl fmt::Debug for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "some" } else { "none" })
    }
}
