//! Master boards of a mission: one, or two of which one is the standby of the other.

use core::fmt::Debug;

use crate::redundancy::{Pair, Standby, Strap};
use crate::types::{Canonical, CobId, Duration, Flag, Instant, correct};

/// Master boards of a mission. The image of a mission with one board has no code for a standby.
pub trait MasterBoards: Debug + Canonical<Context = ()> + 'static {
    /// Returns the role of this board. `None`: the mission has one master board.
    fn standby(&self) -> Option<&Standby>;

    /// Returns the role of this board, to be changed. `None`: the mission has one master board.
    fn standby_mut(&mut self) -> Option<&mut Standby>;

    /// Corrects by copies what does not change, and bounds stored instants. Call it periodically. Returns whether a bit was
    /// wrong.
    fn refresh(&mut self, now: Instant) -> bool;
}

/// One master board, which is active at power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
pub struct OneBoard;

/// Two master boards (ECSS 8.1a, Figure 4-2), if the profile has numbers for them.
#[doc(alias("standby master", "redundant master"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct TwoBoards {
    are_two: Flag,
    /// Of one board it has no meaning.
    standby: Standby,
    /// Copies of the numbers of `standby`: two of the three have to agree.
    copies: [(Pair, Strap); 2],
}

/// Numbers of one board, without a meaning.
const OF_ONE: Pair = Pair {
    consumer: Duration::ZERO,
    prime_listens: Duration::ZERO,
    second_listens: Duration::ZERO,
    prime_claims: CobId::SYNC,
    second_claims: CobId::SYNC,
};

impl TwoBoards {
    /// Makes the board with this strap, before power-on. Without a `pair` it is as [`OneBoard`].
    pub fn new(pair: Option<Pair>, strap: Strap) -> TwoBoards {
        let (are_two, pair) = (Flag::of(pair.is_some()), pair.unwrap_or(OF_ONE));
        TwoBoards { are_two, standby: Standby::new(pair, strap), copies: [(pair, strap); 2] }
    }
}

impl MasterBoards for OneBoard {
    fn standby(&self) -> Option<&Standby> {
        None
    }

    fn standby_mut(&mut self) -> Option<&mut Standby> {
        None
    }

    fn refresh(&mut self, _: Instant) -> bool {
        false
    }
}

impl MasterBoards for TwoBoards {
    fn standby(&self) -> Option<&Standby> {
        self.are_two.is_set().then_some(&self.standby)
    }

    fn standby_mut(&mut self) -> Option<&mut Standby> {
        self.are_two.is_set().then_some(&mut self.standby)
    }

    fn refresh(&mut self, now: Instant) -> bool {
        let mut own = (*self.standby.pair(), self.standby.strap());
        let [first, second] = &mut self.copies;
        let is_wrong = correct([&mut own, first, second]);
        self.standby.refresh(own, now);
        is_wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Instant = Instant::from_micros(46_912_496_118);
    const PAIR: Pair = Pair {
        consumer: Duration::from_millis(400),
        prime_listens: Duration::from_millis(700),
        second_listens: Duration::from_millis(1_000),
        prime_claims: CobId::new(0x680).unwrap(),
        second_claims: CobId::new(0x681).unwrap(),
    };
    const STRAPS: [Strap; 2] = [Strap::Prime, Strap::Second];

    /// The numbers of a mission, each with a bit that flipped.
    fn flipped() -> impl Iterator<Item = Pair> {
        let span = |span: Duration, bit: u32| Duration::from_micros(span.as_micros() ^ 1 << bit);
        let id = |id: CobId, bit: u32| CobId::new(id.raw() ^ 1 << (bit % 11));
        let pair = PAIR;
        (0..64).flat_map(move |bit| {
            let spans = [
                Pair { consumer: span(pair.consumer, bit), ..pair },
                Pair { prime_listens: span(pair.prime_listens, bit), ..pair },
                Pair { second_listens: span(pair.second_listens, bit), ..pair },
            ];
            let prime = id(pair.prime_claims, bit).map(|prime_claims| Pair { prime_claims, ..pair });
            let second = id(pair.second_claims, bit).map(|second_claims| Pair { second_claims, ..pair });
            spans.into_iter().chain(prime).chain(second)
        })
    }

    /// Given one of two boards, when a bit of its numbers or of a copy flips, then they are right after the next look.
    #[test]
    fn flipped_number_of_a_board_is_corrected() {
        for (copy, strap) in (0..3).flat_map(|copy| STRAPS.map(|strap| (copy, strap))) {
            for pair in flipped().chain([PAIR]) {
                let strap_too = if pair == PAIR { STRAPS[1 - strap as usize] } else { strap };
                let mut boards = TwoBoards::new(Some(PAIR), strap);
                boards.standby.start(NOW);
                let before = boards.clone();
                match copy {
                    0 => boards.standby.refresh((pair, strap_too), NOW),
                    nth => boards.copies[nth - 1] = (pair, strap_too),
                }
                assert!(boards.refresh(NOW), "copy {copy}: {pair:?}");
                assert!(!boards.refresh(NOW));
                assert_eq!((boards.standby().unwrap().pair(), boards.standby.strap()), (&PAIR, strap));
                assert_eq!(boards.copies, before.copies);
            }
        }
    }

    /// Given one of two boards, when it looks for flipped bits, then it takes over no later than a power-on would have it.
    #[test]
    fn end_of_the_silence_of_the_other_board_is_bounded() {
        let mut boards = TwoBoards::new(Some(PAIR), Strap::Second);
        boards.standby.start(NOW + Duration::from_millis(1 << 30));
        assert!(!boards.refresh(NOW));
        let Pair { consumer, second_listens, .. } = PAIR;
        assert_eq!(boards.standby.deadline(), Some(NOW + consumer.max(second_listens)));
    }
}
