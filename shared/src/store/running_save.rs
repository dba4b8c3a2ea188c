//! A save or a restore that runs: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).
//!
//! A client writes one of these objects, and its answer waits until the flash has the new set. The save moves on by a
//! slice of a few words, and pauses between two slices: a word of flash stops the processor, and frames wait.

use async_canopen::store::machine::SaveEnd;

use crate::store::{Group, ParameterStore, Parameters, Save, StoreError, StoreRequest};
use crate::types::{AbortCode, Address, Duration, Instant, NodeId};

/// Steps of a slice: 32 bytes of values at most, 0.8 ms where flash takes 100 µs for a word.
const STEPS: u32 = 4;

/// Time from the end of a slice to the next one.
const PAUSE: Duration = Duration::from_micros(100);

/// Answer of the SDO server to the client that asked for the save.
#[derive(Clone, Copy, Debug)]
enum Answer {
    /// No client waits.
    None,
    /// The server is about to send the answer.
    Due,
    /// The answer waits until the save ends.
    Held([u8; 8]),
}

/// A save or a restore that runs.
pub struct RunningSave {
    save: Save,
    /// Object and sub-index that were written.
    at: Address,
    answer: Answer,
    due: Instant,
}

impl RunningSave {
    /// Begins to save a group, or to restore its defaults at the next reset.
    ///
    /// # Errors
    /// The abort code to answer.
    pub fn begin(
        store: &mut dyn ParameterStore,
        id: NodeId,
        at: Address,
        now: Instant,
    ) -> Result<Self, AbortCode> {
        let group = Group::from_sub(at.sub).ok_or(AbortCode::NoSubIndex)?;
        let request = StoreRequest::of(at.index).ok_or(AbortCode::NoObject)?;
        let save = Save::begin(store, id, group, request).map_err(StoreError::abort_code)?;
        Ok(RunningSave { save, at, answer: Answer::Due, due: now })
    }

    /// Returns when the next slice is due.
    pub const fn deadline(&self) -> Instant {
        self.due
    }

    /// Keeps the answer to the client until the end. Returns `false` for the answer to another request.
    pub fn hold(&mut self, answer: &[u8; 8]) -> bool {
        let is_due = matches!(self.answer, Answer::Due);
        if is_due {
            self.answer = Answer::Held(*answer);
        }
        is_due
    }

    /// Notes that no client waits for the answer.
    pub fn drop_answer(&mut self) {
        self.answer = Answer::None;
    }

    /// Continues by a slice. Returns the end of the save.
    pub fn advance(
        &mut self,
        store: &mut dyn ParameterStore,
        parameters: &mut impl Parameters,
        now: Instant,
    ) -> Option<SaveEnd> {
        for _ in 0..STEPS {
            let result = match self.save.advance(store, parameters) {
                Ok(false) => continue,
                Ok(true) => Ok(()),
                Err(error) => Err(error.abort_code()),
            };
            let answer = if let Answer::Held(answer) = self.answer { Some(answer) } else { None };
            return Some(SaveEnd { at: self.at, result, answer });
        }
        self.due = now + PAUSE;
        None
    }
}
