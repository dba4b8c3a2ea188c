//! Depth of the queues of a node. It is a type, so that a small node has small queues.

use heapless::vec::{OwnedVecStorage, Vec, VecInner, VecStorage};

/// Depth of the queues of a node: commands and events in its outbox, frames in the transmit queue of each bus.
pub trait Depth: 'static {
    /// Number of places of each queue.
    const PLACES: usize;
    /// Storage type of a list.
    type Of<T>: VecStorage<T>;

    /// Places of a queue, first in, first out.
    type Ring<T>: AsMut<[Option<T>]>;

    /// Makes the places of an empty queue.
    fn ring<T>() -> Self::Ring<T>;

    /// Makes an empty list.
    fn list<T>() -> VecInner<T, usize, Self::Of<T>>;
}

/// Depth of `N` places for each queue.
#[derive(Debug)]
pub struct Places<const N: usize>;

impl<const N: usize> Depth for Places<N> {
    const PLACES: usize = N;
    type Of<T> = OwnedVecStorage<T, N>;
    type Ring<T> = [Option<T>; N];

    fn ring<T>() -> [Option<T>; N] {
        [const { None }; N]
    }

    fn list<T>() -> Vec<T, N> {
        Vec::new()
    }
}
