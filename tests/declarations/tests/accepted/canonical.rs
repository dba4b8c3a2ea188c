//! Every attribute of `#[derive(Canonical)]`, in each form of a type.
#![deny(warnings)]

use ecss_can::types::{Bus, Canonical, Duration, Instant, Instants, PerBus};

#[derive(Canonical)]
#[canonical(context = Duration)]
pub struct Words<const N: usize> {
    #[canonical(due)]
    pub due: Option<Instant>,
    #[canonical(age = *context)]
    pub age: PerBus<Option<Instant>>,
    #[canonical(grid = self.period)]
    pub grid: (Instant, Bus),
    pub period: Duration,
    #[canonical(within = self.period)]
    pub within: Option<Nested>,
    #[canonical(each = |_| self.period)]
    pub each: [Option<Nested>; N],
    #[canonical(value = 0)]
    pub value: u8,
    #[canonical(value = self.both.filter(|at| *at > now), due)]
    pub both: Option<Instant>,
    pub r#type: bool,
}

#[derive(Clone, Copy, Canonical)]
#[canonical(context = Duration)]
pub enum Nested {
    Unit,
    Unnamed(u8, #[canonical(age = *context)] Instant),
    Named {
        #[canonical(due)]
        at: Instant,
    },
}

#[derive(Canonical)]
pub enum Alone {
    Only(#[canonical(due)] Instant),
}

#[derive(Canonical)]
pub enum Never {}

#[derive(Canonical)]
pub struct Unit;

/// The macro bounds `I` and `M`; the declaration bounds `T`, whose context the macro cannot know.
#[derive(Canonical)]
#[canonical(context = u8)]
pub struct Generic<I, M, T: Canonical<Context = u8>>(
    #[canonical(due)] pub Vec2<I>,
    pub Option<M>,
    #[canonical(within = *context)] pub T,
);

pub struct Vec2<I>(pub [I; 2]);

impl<I: Instants> Instants for Vec2<I> {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        self.0.replace(function);
    }
}

fn main() {
    let mut generic = Generic(Vec2([Instant::ZERO; 2]), Some(true), Noting);
    generic.canonical(Instant::from_micros(5), &3);
    assert_eq!(generic.0.0, [Instant::ORIGIN; 2]);
    Unit.canonical(Instant::ZERO, &());
}

#[derive(Canonical)]
#[canonical(context = u8)]
struct Noting;
