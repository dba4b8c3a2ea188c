//! Observable behaviour of an execution.

/// Number of distinguishable steps.
const STEPS: usize = 1 << 16;

/// The steps of a campaign. A step is an observation together with the one before it. An input with a new step is
/// mutated further.
#[derive(Debug)]
pub struct Signature {
    seen: Vec<bool>,
    before: u32,
    /// Whether the present execution has a new step.
    is_new: bool,
}

impl Default for Signature {
    fn default() -> Self {
        Signature { seen: vec![false; STEPS], before: 0, is_new: false }
    }
}

impl Signature {
    /// Starts another execution.
    pub(crate) fn begin(&mut self) {
        (self.before, self.is_new) = (0, false);
    }

    /// Records an observation: an answer, a state, an event.
    pub fn note(&mut self, observed: u32) {
        let step = (self.before.rotate_left(5) ^ observed).wrapping_mul(0x9E37_79B1);
        let seen = &mut self.seen[(step >> 16) as usize % STEPS];
        self.is_new |= !*seen;
        *seen = true;
        self.before = observed;
    }

    /// Returns whether the present execution has a new step.
    pub(crate) const fn is_new(&self) -> bool {
        self.is_new
    }

    /// Returns the number of steps.
    pub fn steps(&self) -> usize {
        self.seen.iter().filter(|seen| **seen).count()
    }
}
