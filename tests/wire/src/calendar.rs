//! Who of a segment does something next, bit by bit. Most of what happens changes the plans of one node.

use crate::fine::Fine;

/// Plans of the members of a segment, in their order.
#[derive(Debug, Default)]
pub(crate) struct Calendar {
    /// When each does something by itself.
    own: Vec<Fine>,
    /// When each may have to be told of something.
    news: Vec<Fine>,
    /// The earliest of `own`, and whose it is: of several, the first.
    first: (Fine, usize),
}

impl Calendar {
    /// The plans of all members, [`Fine::NEVER`] for none.
    pub(crate) fn of(plans: impl Iterator<Item = (Fine, Fine)>) -> Calendar {
        let (own, news) = plans.unzip();
        let mut calendar = Calendar { own, news, first: (Fine::NEVER, 0) };
        calendar.find_first();
        calendar
    }

    /// Nobody has been asked.
    pub(crate) fn is_empty(&self) -> bool {
        self.own.is_empty()
    }

    pub(crate) fn first(&self) -> (Fine, usize) {
        self.first
    }

    /// When somebody may have to be told of something.
    pub(crate) fn news(&self) -> Fine {
        self.news.iter().copied().min().unwrap_or(Fine::NEVER)
    }

    /// A member has other plans.
    pub(crate) fn set(&mut self, member: usize, own: Fine, news: Fine) {
        (self.own[member], self.news[member]) = (own, news);
        if (own, member) < self.first {
            self.first = (own, member);
        } else if member == self.first.1 {
            self.find_first();
        }
    }

    /// Two plain searches, which the compiler makes faster than one for both.
    fn find_first(&mut self) {
        let earliest = self.own.iter().copied().min().unwrap_or(Fine::NEVER);
        self.first = (earliest, self.own.iter().position(|&at| at == earliest).unwrap_or(0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_is_the_earliest_and_of_several_the_first() {
        let mut calendar = Calendar::of([5, 3, 3].map(|at| (Fine(at), Fine(at + 10))).into_iter());
        assert_eq!((calendar.first(), calendar.news()), ((Fine(3), 1), Fine(13)));
        calendar.set(1, Fine(9), Fine(30));
        assert_eq!((calendar.first(), calendar.news()), ((Fine(3), 2), Fine(13)));
        calendar.set(0, Fine(3), Fine(11));
        assert_eq!((calendar.first(), calendar.news()), ((Fine(3), 0), Fine(11)));
        calendar.set(0, Fine::NEVER, Fine::NEVER);
        calendar.set(2, Fine::NEVER, Fine::NEVER);
        assert_eq!((calendar.first(), calendar.news()), ((Fine(9), 1), Fine(30)));
    }
}
