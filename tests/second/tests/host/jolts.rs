//! One jolt breaks the bus of a slave and resets it: every distance and order, see [`campaign::jolt`].

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use campaign::jolt::table;
use campaign::{World, fly};

#[test]
fn slave_that_a_jolt_strikes_twice_is_served() {
    let (scripts, next) = (table(), AtomicUsize::new(0));
    let fly_some = || {
        let numbers = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)));
        let flown =
            numbers.map_while(|number| scripts.get(number)).map(|script| (script, fly(World::Host, script)));
        let bad = flown.filter(|(_, outcome)| !outcome.violations.is_empty());
        bad.map(|(script, outcome)| format!("{:?}\n{script}", outcome.violations)).collect::<Vec<_>>()
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let bad: Vec<String> = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(fly_some)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a flight catches its panics")).collect()
    });
    assert!(bad.is_empty(), "{} of {}:\n{}", bad.len(), scripts.len(), bad.join("\n"));
}
