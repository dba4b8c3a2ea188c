//! Many executions of a target.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use fastrand::Rng;

use crate::fuzz::{Input, Signature, Target, corpus, mutation};

/// Largest number of inputs kept for mutation. After that a new one replaces another.
const POOL: usize = 4_096;

/// Executions of a target on its corpus and on mutations of it.
pub struct Campaign {
    target: Target,
    rng: Rng,
    pool: Vec<Vec<u8>>,
    signature: Signature,
    input: Vec<u8>,
}

/// An input on which a target panicked.
#[derive(Debug)]
pub struct Failure {
    /// The input.
    pub input: Vec<u8>,
    /// Message of the panic.
    pub message: String,
}

impl Campaign {
    /// Makes a campaign from a seed, with the corpus of the target.
    pub fn new(target: Target, seed: u64) -> Campaign {
        let pool = corpus::load(target.name).into_iter().map(|(_, input)| input).collect();
        Campaign {
            target,
            rng: Rng::with_seed(seed),
            pool,
            signature: Signature::default(),
            input: Vec::new(),
        }
    }

    /// Runs the target on the corpus.
    ///
    /// # Errors
    /// On the first input with which it panics.
    pub fn replay(&mut self) -> Result<(), Failure> {
        self.pool.iter().try_for_each(|input| attempt(self.target, input, &mut self.signature))
    }

    /// Runs the target `executions` times, each on a new input.
    ///
    /// # Errors
    /// On the first input with which it panics.
    pub fn run(&mut self, executions: u64) -> Result<(), Failure> {
        for _ in 0..executions {
            mutation::next(&mut self.rng, &self.pool, &mut self.input);
            attempt(self.target, &self.input, &mut self.signature)?;
            if self.signature.is_new() {
                if self.pool.len() < POOL {
                    self.pool.push(self.input.clone());
                } else {
                    let at = self.rng.usize(..POOL);
                    self.pool[at].clone_from(&self.input);
                }
            }
        }
        Ok(())
    }

    /// Returns the number of different steps of the executions.
    pub fn steps(&self) -> usize {
        self.signature.steps()
    }
}

/// Runs a target once.
///
/// # Errors
/// When it panics.
pub fn attempt(target: Target, input: &[u8], signature: &mut Signature) -> Result<(), Failure> {
    signature.begin();
    catch_unwind(AssertUnwindSafe(|| (target.run)(Input::new(input), signature)))
        .map_err(|panic| Failure { input: input.to_vec(), message: message(&*panic) })
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// Returns a shorter input on which the target panics too. Parts are removed, from large ones to single bytes.
pub fn shorten(target: Target, failure: Failure) -> Failure {
    let mut shortest = failure;
    let mut part = shortest.input.len() / 2;
    while part > 0 {
        let mut at = 0;
        while at < shortest.input.len() {
            let mut input = shortest.input.clone();
            input.drain(at..(at + part).min(input.len()));
            match attempt(target, &input, &mut Signature::default()) {
                Err(shorter) => shortest = shorter,
                Ok(()) => at += part,
            }
        }
        part /= 2;
    }
    shortest
}
