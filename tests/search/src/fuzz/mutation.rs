//! New inputs from old ones.

use fastrand::Rng;

/// Largest number of bytes of an input.
pub const LONGEST: usize = 256;

/// Boundary values.
const EDGES: [u8; 16] = [0, 1, 2, 4, 7, 8, 0x10, 0x20, 0x40, 0x7F, 0x80, 0x81, 0xA0, 0xC0, 0xFE, 0xFF];

/// Makes an input from one of `pool`, or a new one.
pub fn next(rng: &mut Rng, pool: &[Vec<u8>], into: &mut Vec<u8>) {
    into.clear();
    if pool.is_empty() || rng.u8(..16) == 0 {
        let len = rng.usize(1..=LONGEST);
        into.extend(std::iter::repeat_with(|| rng.u8(..)).take(len));
        return;
    }
    into.extend(&pool[rng.usize(..pool.len())]);
    for _ in 0..=rng.u8(..4) {
        mutate(rng, pool, into);
    }
    into.truncate(LONGEST);
}

fn mutate(rng: &mut Rng, pool: &[Vec<u8>], input: &mut Vec<u8>) {
    let at = rng.usize(..=input.len());
    let end = (at + rng.usize(1..=12)).min(input.len());
    match (rng.u8(..8), input.get_mut(at)) {
        (0, Some(byte)) => *byte ^= 1 << rng.u8(..8),
        (1, Some(byte)) => *byte = rng.u8(..),
        (2, Some(byte)) => *byte = EDGES[rng.usize(..EDGES.len())],
        (3, _) => drop(input.drain(at..end)),
        (4, _) => {
            let count = rng.usize(1..=12);
            input.splice(at..at, std::iter::repeat_with(|| rng.u8(..)).take(count));
        }
        // Repeats earlier bytes.
        (5, _) => {
            let again = input[at..end].to_vec();
            let to = rng.usize(..=input.len());
            input.splice(to..to, again);
        }
        // Copies bytes of another input.
        (6, _) => {
            let other = &pool[rng.usize(..pool.len())];
            let from = rng.usize(..=other.len());
            input.truncate(at);
            input.extend(&other[from..]);
        }
        _ => {
            let other = &pool[rng.usize(..pool.len())];
            let from = rng.usize(..=other.len());
            let to = (from + rng.usize(1..=24)).min(other.len());
            input.splice(at..at, other[from..to].iter().copied());
        }
    }
}
