//! Words of `#[canonical(..)]` that are unknown, incomplete, or exclude each other. Each type is usable: there is one error.

use ecss_can::types::{Canonical, Instant};

#[derive(Canonical)]
struct Unknown {
    #[canonical(aged = self.time)]
    at: Instant,
}

#[derive(Canonical)]
struct WithoutHorizon {
    #[canonical(age)]
    at: Instant,
    #[canonical(value)]
    count: u8,
}

#[derive(Canonical)]
struct DueHasNone {
    #[canonical(due = self.time)]
    at: Instant,
}

#[derive(Canonical)]
struct Twice {
    #[canonical(due, age = self.time)]
    at: Instant,
    #[canonical(value = 1)]
    #[canonical(value = 2)]
    count: u8,
}

#[derive(Canonical)]
struct EachNeedsAnArray {
    #[canonical(each = |_| ())]
    machine: Option<u8>,
}

#[derive(Canonical)]
#[canonical(within = Duration)]
struct NotOfAType {
    count: u8,
}

#[derive(Canonical)]
#[canonical(context = u8)]
#[canonical(context = u16)]
struct TwoContexts {
    count: u8,
}

#[derive(Canonical)]
union Overlaid {
    one: u8,
    other: u8,
}

fn uses(mut unknown: Unknown, mut words: WithoutHorizon) {
    unknown.canonical(Instant::ZERO, &());
    words.canonical(Instant::ZERO, &());
}

fn main() {}
