//! Frames that a controller misses.

use std::fmt;
use std::rc::Rc;

use ecss_can::types::Frame;

type IsMissed = dyn Fn(&Frame) -> bool;

/// Frames that a controller acknowledges on the bus and does not give to its task. None by default.
#[derive(Clone, Default)]
pub(crate) struct Missed(Option<Rc<IsMissed>>);

impl Missed {
    /// The frames for which `is_missed` returns true, at the end of the frame.
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
