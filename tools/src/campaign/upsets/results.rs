//! Results of the upsets of a campaign or of a shard of it: collected, joined, printed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::fly::Flown;
use super::outcome::Outcome;
use super::place::{Place, Upset};
use crate::images::support::shard::Run;

/// Parameters of a campaign: they and the commit determine its results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// Seed of the instants and places.
    pub seed: u64,
    /// Number of masters.
    pub masters: u8,
    /// Number of draws of each place.
    pub draws: BTreeMap<Place, u64>,
}

impl Asked {
    /// Returns the number of draws of all places.
    pub fn total(&self) -> u64 {
        self.draws.values().sum()
    }

    /// Returns the place of a draw, and its number there.
    pub fn place(&self, number: u64) -> Option<(Place, u64)> {
        let mut first = 0;
        self.draws.iter().find_map(|(place, count)| {
            let within = number.checked_sub(first)?;
            first += count;
            (within < *count).then_some((*place, within))
        })
    }
}

/// An upset that is listed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Listed {
    /// Number of the draw.
    pub draw: u64,
    /// Its outcome.
    pub outcome: Outcome,
    /// Board and place.
    pub name: String,
    /// The upset as text, for `--replay`.
    pub upset: String,
    /// Reasons.
    pub reasons: Vec<String>,
}

/// Results of some draws.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Results {
    /// Number of upsets by place and outcome.
    pub counts: BTreeMap<Place, BTreeMap<Outcome, u64>>,
    /// Bad and unjudged upsets.
    pub listed: Vec<Listed>,
}

impl Results {
    /// Counts a draw that was not flown.
    pub fn count(&mut self, place: Place, outcome: Outcome) {
        *self.counts.entry(place).or_default().entry(outcome).or_default() += 1;
    }

    /// Adds a draw that was flown.
    pub fn add(&mut self, draw: u64, upset: &Upset, flown: Flown) {
        let Flown { name, outcome, reasons } = flown;
        self.count(upset.place, outcome);
        if outcome.is_bad() || outcome == Outcome::Unjudged {
            self.listed.push(Listed { draw, outcome, name, upset: upset.to_string(), reasons });
        }
    }

    /// Sorts by the number of the draw, so that equal campaigns give equal files.
    pub fn sort(&mut self) {
        self.listed.sort_by_key(|listed| listed.draw);
    }

    /// Joins the results of all shards.
    pub fn joined(parts: Vec<Results>) -> Results {
        let mut sum = Results::default();
        for part in parts {
            for (place, outcomes) in part.counts {
                let entry = sum.counts.entry(place).or_default();
                outcomes.into_iter().for_each(|(outcome, count)| *entry.entry(outcome).or_default() += count);
            }
            sum.listed.extend(part.listed);
        }
        sum.sort();
        sum
    }

    /// Returns the number of bad upsets.
    pub fn bad(&self) -> usize {
        self.listed.iter().filter(|listed| listed.outcome.is_bad()).count()
    }

    /// Returns the results of this campaign as text: a row for each place, and the listed upsets.
    pub fn lines(&self, run: &Run<Asked>) -> Vec<String> {
        let columns = Outcome::ALL.map(|outcome| format!("{:>15}", outcome.name())).concat();
        let mut lines = vec![format!("{:<12}{:>7}{columns}", "place", "draws")];
        for place in Place::ALL {
            let Some(counts) = self.counts.get(&place) else { continue };
            let cells = Outcome::ALL.map(|outcome| format!("{:>15}", counts.get(&outcome).unwrap_or(&0)));
            let total: u64 = counts.values().sum();
            lines.push(format!("{:<12}{total:>7}{}", place.name(), cells.concat()));
        }
        let Asked { seed, masters, .. } = run.parameters;
        let total: u64 = self.counts.values().flat_map(BTreeMap::values).sum();
        let world = if masters == 1 { "one master" } else { "two masters" };
        lines.push(String::new());
        lines.push(format!("{total} upsets with {world}; seed {seed}, {}", run.commit));
        for Listed { draw, outcome, name, upset, reasons } in &self.listed {
            lines.push(format!("\ndraw {draw}: {}: {name}", outcome.name()));
            lines.extend(reasons.iter().map(|reason| format!("  {reason}")));
            lines.push(format!("  {upset}"));
        }
        lines.push(format!("{} bad upsets", self.bad()));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::upsets::place::Target;

    #[test]
    fn draws_follow_each_other_place_by_place() {
        let draws = BTreeMap::from([(Place::Ram, 3), (Place::Masks, 0), (Place::Flash, 2)]);
        let asked = Asked { seed: 1, masters: 1, draws };
        let places: Vec<_> = (0..=asked.total()).map(|number| asked.place(number)).collect();
        let expected =
            [(Place::Ram, 0), (Place::Ram, 1), (Place::Ram, 2), (Place::Flash, 0), (Place::Flash, 1)];
        assert_eq!(places[..5], expected.map(Some));
        assert_eq!(places[5], None);
    }

    #[test]
    fn joined_shards_are_the_sum_in_the_order_of_draws() {
        let upset = Upset {
            masters: 1,
            place: Place::Flash,
            board: 0,
            at_us: 5_000_000,
            target: Target::Address(0x0800_0000),
            bit: 0,
        };
        let flown = |outcome| Flown { name: "master: f".into(), outcome, reasons: Vec::new() };
        let (mut first, mut second) = (Results::default(), Results::default());
        second.add(1, &upset, flown(Outcome::NotRecovered));
        second.add(2, &upset, flown(Outcome::None));
        first.add(7, &upset, flown(Outcome::Unjudged));
        first.count(Place::Ram, Outcome::NotUsed);
        let joined = Results::joined(vec![first, second]);
        assert_eq!(joined.listed.iter().map(|listed| listed.draw).collect::<Vec<_>>(), [1, 7]);
        assert_eq!((joined.bad(), joined.counts[&Place::Flash].len()), (1, 3));
    }
}
