//! Canonical form of the state of a machine: states that will always behave alike become equal.

use heapless::Vec;

use super::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus};

/// State machine whose states have a canonical form. From two states with equal canonical forms it makes the same
/// decisions, each relative to its own present.
///
/// A model checker visits every state once. A machine that notes instants never returns to the same state, because the
/// time differs. In the canonical form the present is [`Instant::ORIGIN`], and an age that has no effect any more is
/// forgotten. The *horizon* of an instant is the greatest age that has an effect.
///
/// The [derive macro](derive@Canonical) takes the horizon from the attribute of the field. An instant without one does
/// not compile.
///
/// ```
/// use async_canopen::types::{Canonical, Duration, Instant};
///
/// /// Repeats a request until it is answered, and more slowly if the last answer is at least a second old.
/// #[derive(Debug, PartialEq, Canonical)]
/// #[canonical(context = Duration)] // of the owner: time until a request expires
/// struct Requests {
///     #[canonical(due)]
///     next: Instant,
///     #[canonical(age = Duration::from_millis(1_000))]
///     answered: Instant,
///     #[canonical(value = self.open.filter(|since| now < *since + *context), age = *context)]
///     open: Option<Instant>,
///     is_urgent: bool,
/// }
///
/// let at = |ms| Instant::ZERO + Duration::from_millis(ms);
/// let expires = Duration::from_millis(500);
/// let canonical = |answered, open, now| {
///     let mut requests = Requests { next: at(now + 10), answered: at(answered), open: Some(at(open)), is_urgent: false };
///     requests.canonical(at(now), &expires);
///     requests
/// };
/// let one = canonical(3_000, 3_900, 4_000);
/// assert_eq!(one.next, Instant::ORIGIN + Duration::from_millis(10));
/// assert_eq!(canonical(7_500, 8_900, 9_000), one); // both answers are at least a second old
/// assert_ne!(canonical(8_100, 8_900, 9_000), one); // the answer is younger
/// assert_eq!(canonical(8_100, 8_500, 9_000).open, None); // expired
/// ```
///
/// # Limits
///
/// - Take the canonical form after everything that is due was polled.
/// - The macro cannot know whether a horizon is long enough. One that is too short makes states equal that differ.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no canonical form of its own",
    label = "the horizon of an instant is missing, or a type does not derive `Canonical`",
    note = "at an instant: `#[canonical(due)]` if it is compared with now alone, `#[canonical(age = ..)]` with the \
            greatest age that has an effect, or `#[canonical(grid = ..)]` with the period",
    note = "any other type: `#[derive(Canonical)]`"
)]
pub trait Canonical {
    /// Values of the owner of the machine on which horizons depend, for example its parameters. `()` for none.
    type Context;

    /// Makes the state canonical. `now`: the present, when everything due was polled. It becomes [`Instant::ORIGIN`].
    fn canonical(&mut self, now: Instant, context: &Self::Context);
}

pub use async_canopen_derive::Canonical;

// Each implementation is `do_not_recommend`, also those of the macro: a list of all types that have a canonical form would
// hide the notes of the trait.

/// Types without time: a state is canonical as it is. A [`Duration`] does not depend on the present.
macro_rules! timeless {
    ($($timeless:ty),*) => {
        $(#[diagnostic::do_not_recommend]
        impl Canonical for $timeless {
            type Context = ();

            fn canonical(&mut self, _: Instant, (): &()) {}
        })*
    };
}

timeless!(bool, u8, u16, u32, u64, u128, Bus, CobId, Duration, Frame, NmtState, NodeId);

#[diagnostic::do_not_recommend]
impl<T: Canonical> Canonical for Option<T> {
    type Context = T::Context;

    fn canonical(&mut self, now: Instant, context: &T::Context) {
        self.iter_mut().for_each(|machine| machine.canonical(now, context));
    }
}

#[diagnostic::do_not_recommend]
impl<T: Canonical> Canonical for PerBus<T> {
    type Context = T::Context;

    fn canonical(&mut self, now: Instant, context: &T::Context) {
        self.nominal.canonical(now, context);
        self.redundant.canonical(now, context);
    }
}

#[diagnostic::do_not_recommend]
impl<T: Canonical, const N: usize> Canonical for [T; N] {
    type Context = T::Context;

    fn canonical(&mut self, now: Instant, context: &T::Context) {
        self.iter_mut().for_each(|machine| machine.canonical(now, context));
    }
}

#[diagnostic::do_not_recommend]
impl<T: Canonical, const N: usize> Canonical for Vec<T, N> {
    type Context = T::Context;

    fn canonical(&mut self, now: Instant, context: &T::Context) {
        self.iter_mut().for_each(|machine| machine.canonical(now, context));
    }
}

#[diagnostic::do_not_recommend]
impl<A: Canonical<Context = ()>, B: Canonical<Context = ()>> Canonical for (A, B) {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.0.canonical(now, &());
        self.1.canonical(now, &());
    }
}
