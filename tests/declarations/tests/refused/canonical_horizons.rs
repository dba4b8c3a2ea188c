//! Instants without a horizon, and machines without their context.

use ecss_can::types::{Canonical, Duration, Instant, PerBus};

#[derive(Canonical)]
struct Missing {
    at: Instant,
    other: Option<Instant>,
    each: [PerBus<Instant>; 2],
}

enum Opaque {
    Unit,
}

#[derive(Canonical)]
enum NotCanonical {
    Holds(Opaque),
}

#[derive(Canonical)]
#[canonical(context = Duration)]
struct Guard {
    #[canonical(age = *context)]
    since: Instant,
}

#[derive(Canonical)]
struct WithoutContext {
    guard: Guard,
}

#[derive(Canonical)]
struct WrongContext {
    #[canonical(within = 500)]
    guard: Option<Guard>,
}

#[derive(Canonical)]
struct NoInstant {
    #[canonical(due)]
    count: u8,
}

#[derive(Canonical)]
struct NoDuration {
    #[canonical(age = 500)]
    at: Instant,
}

fn main() {}
