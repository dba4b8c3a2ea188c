//! What an execution did, as far as it can be told from outside.

/// Steps that can be told apart.
const STEPS: usize = 1 << 16;

/// The steps that were seen in a campaign: each is something observed, together with what was observed before it. An input
/// that takes a new step is worth to be mutated further.
#[derive(Debug)]
pub struct Signature {
    seen: Vec<bool>,
    before: u32,
    /// Whether the present execution took a new one.
    is_new: bool,
}

impl Default for Signature {
    fn default() -> Self {
        Signature { seen: vec![false; STEPS], before: 0, is_new: false }
    }
}

impl Signature {
    /// Another execution.
    pub(crate) fn begin(&mut self) {
        (self.before, self.is_new) = (0, false);
    }

    /// Something was observed: an answer, a state, an event.
    pub fn note(&mut self, observed: u32) {
        let step = (self.before.rotate_left(5) ^ observed).wrapping_mul(0x9E37_79B1);
        let seen = &mut self.seen[(step >> 16) as usize % STEPS];
        self.is_new |= !*seen;
        *seen = true;
        self.before = observed;
    }

    /// Whether the present execution took a new step.
    pub(crate) const fn is_new(&self) -> bool {
        self.is_new
    }

    /// How many steps were taken.
    pub fn steps(&self) -> usize {
        self.seen.iter().filter(|seen| **seen).count()
    }
}
