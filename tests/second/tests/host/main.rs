//! Nodes in virtual time: with third-party servers, and flights of host worlds that take minutes.

mod double_resets;
mod events;
mod jolts;
mod sdo_blocks;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Returns the failures of `count` flights, which run on all cores.
fn wrong(count: usize, fly: impl Fn(usize) -> Result<(), String> + Sync) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let fly_some = || {
        let numbers = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)));
        let numbers = numbers.take_while(|number| *number < count);
        numbers.filter_map(|number| fly(number).err()).collect::<Vec<_>>()
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(fly_some)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a flight does not panic")).collect()
    })
}
