//! Next events of the nodes of a segment on the bit path. Most events change the plans of one node only.

use crate::wire::fine::Fine;

/// One instant per member, and the earliest of all.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Earliest {
    pub(in crate::wire) at: Vec<Fine>,
    /// Earliest instant and its member; of equal instants the first member.
    pub(in crate::wire) first: (Fine, usize),
}

impl Default for Earliest {
    /// Makes it without members.
    fn default() -> Self {
        Earliest { at: Vec::new(), first: (Fine::NEVER, 0) }
    }
}

impl Earliest {
    /// Adds members with [`Fine::NEVER`].
    pub(in crate::wire) fn resize(&mut self, len: usize) {
        self.at.resize(len, Fine::NEVER);
    }

    pub(in crate::wire) fn set(&mut self, index: usize, at: Fine) {
        self.at[index] = at;
        if (at, index) < self.first {
            self.first = (at, index);
        } else if index == self.first.1 {
            self.find_first();
        }
    }

    /// Two simple searches compile to faster code than a combined one.
    fn find_first(&mut self) {
        let earliest = self.at.iter().copied().min().unwrap_or(Fine::NEVER);
        self.first = (earliest, self.at.iter().position(|&at| at == earliest).unwrap_or(0));
    }
}

/// Plans of the members of a segment, in their order.
#[derive(Clone, Debug, Default)]
pub(in crate::wire) struct Calendar {
    /// Instant of the next own action of each member.
    pub(in crate::wire) own: Earliest,
    /// Earliest instant of an event for each member.
    news: Vec<Fine>,
}

impl Calendar {
    /// Makes the plans of all members; [`Fine::NEVER`] for none.
    pub(in crate::wire) fn of(plans: impl Iterator<Item = (Fine, Fine)>) -> Calendar {
        let (at, news) = plans.unzip();
        let mut own = Earliest { at, ..Earliest::default() };
        own.find_first();
        Calendar { own, news }
    }

    /// Returns whether there are no plans yet.
    pub(in crate::wire) fn is_empty(&self) -> bool {
        self.news.is_empty()
    }

    /// Returns the earliest instant of an event for any member.
    pub(in crate::wire) fn news(&self) -> Fine {
        self.news.iter().copied().min().unwrap_or(Fine::NEVER)
    }

    /// Sets the plans of a member.
    pub(in crate::wire) fn set(&mut self, member: usize, own: Fine, news: Fine) {
        self.own.set(member, own);
        self.news[member] = news;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_is_the_earliest_and_of_several_the_first() {
        let mut calendar = Calendar::of([5, 3, 3].map(|at| (Fine(at), Fine(at + 10))).into_iter());
        assert_eq!((calendar.own.first, calendar.news()), ((Fine(3), 1), Fine(13)));
        calendar.set(1, Fine(9), Fine(30));
        assert_eq!((calendar.own.first, calendar.news()), ((Fine(3), 2), Fine(13)));
        calendar.set(0, Fine(3), Fine(11));
        assert_eq!((calendar.own.first, calendar.news()), ((Fine(3), 0), Fine(11)));
        calendar.set(0, Fine::NEVER, Fine::NEVER);
        calendar.set(2, Fine::NEVER, Fine::NEVER);
        assert_eq!((calendar.own.first, calendar.news()), ((Fine(9), 1), Fine(30)));
    }
}
