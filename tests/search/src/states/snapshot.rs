//! Known numbers of states. Another number means that a rule has changed, or that the search is not reproducible.

use model::world::Crew;

/// File of the numbers: masters (`1+`: in use, `1?`: no slave is assigned, `2=`: two with equal clocks, `2?`: and no
/// slave is assigned; `1!`, `2!`: one slave, which reports), faults, states.
pub const PATH: &str = "tests/search/states.txt";

/// Returns the known number of states of a search with up to `faults` faults.
pub fn states(crew: Crew, faults: u8) -> Option<usize> {
    let masters = match crew {
        Crew::OneMaster => "1",
        Crew::OneMasterInUse => "1+",
        Crew::OneMasterUnassigned => "1?",
        Crew::TwoMasters => "2",
        Crew::TwoMastersInStep => "2=",
        Crew::TwoMastersUnassigned => "2?",
        Crew::OneMasterWithReports => "1!",
        Crew::TwoMastersWithReports => "2!",
    };
    let rows = include_str!("../../states.txt").lines().map(|line| line.split(' ').collect::<Vec<_>>());
    let mut known = rows.filter_map(|row| match row[..] {
        [crew, most, states] if crew == masters => Some((most.parse::<u8>().ok()?, states.parse().ok()?)),
        _ => None,
    });
    known.find(|(most, _)| *most == faults).map(|(_, states)| states)
}
