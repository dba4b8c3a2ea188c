//! What a slave reports while its bus fails is known to the master afterwards: every millisecond, see [`host::events`].

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use host::events::{flights, fly};

#[test]
fn reports_at_every_millisecond_of_a_failure_are_known_afterwards() {
    let (all, next) = (flights(), AtomicUsize::new(0));
    let fly_some = || {
        let numbers = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)));
        let flown = numbers.map_while(|number| all.get(number));
        flown.filter_map(|flight| fly(*flight).err()).collect::<Vec<_>>()
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let wrong: Vec<String> = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(fly_some)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a flight does not panic")).collect()
    });
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n"));
}
