//! Values of PDOs by the names of their objects, as the data sheets of the boards have them.

use std::collections::BTreeMap;

use can_wire::frame::WireId;
use can_wire::time::Time;
use serde::Serialize;

use super::flight::Flight;
use super::options::OwnSheet;
use super::plan::{BoardPlan, Plan};
use super::sheet::Sheet;
use support::board::Profile;
use support::misuse::Misuse;
use support::node::{MASTER, Node, is_master};

/// Data sheets of the shipped images.
const OF_MASTER: &str = include_str!("../../../docs/eds/master.eds");
const OF_SLAVE: &str = include_str!("../../../docs/eds/slave.eds");
const OF_MINIMAL: &str = include_str!("../../../docs/eds/minimal.eds");
const OF_MINIMAL_LIBRECUBE: &str = include_str!("../../../docs/eds/minimal-librecube.eds");

/// Data sheets of the boards that have one.
#[derive(Clone, Debug, Default)]
pub struct Sheets(BTreeMap<Node, Sheet>);

/// The last values of a PDO.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PdoValues {
    /// Board that sends it.
    pub node: Node,
    /// Number of the transmit PDO, from 1.
    pub pdo: u16,
    /// COB-ID, for example `382h`.
    pub cob_id: String,
    /// Number of its frames that completed, on both buses.
    pub frames: u64,
    /// End of the last one, virtual seconds.
    pub last_at_seconds: f64,
    /// Names of its objects, with the values in the last frame.
    pub values: Vec<(String, String)>,
}

impl Sheets {
    /// Those of the shipped images of a plan, and those of the user.
    ///
    /// # Errors
    /// When a file of the user cannot be read or is no data sheet, or its node is not in the plan.
    pub fn of(plan: &Plan, own: &[OwnSheet]) -> Result<Sheets, Misuse> {
        let wrong = |own: &OwnSheet, cause: String| {
            let text =
                format!("invalid value '{}={}' for '--eds <N=FILE>': {cause}", own.node, own.file.display());
            Misuse::of("demo", text)
        };
        let mut sheets = BTreeMap::new();
        for own in own {
            if !plan.boards.iter().any(|board| board.node == own.node) {
                return Err(wrong(
                    own,
                    format!("no board is node {}; give the Node-ID of one that flies", own.node),
                ));
            }
            let text = std::fs::read_to_string(&own.file).map_err(|error| wrong(own, error.to_string()))?;
            let sheet = Sheet::read(&text, own.node).map_err(|cause| wrong(own, cause))?;
            if sheets.insert(own.node, sheet).is_some() {
                return Err(wrong(own, format!("node {} has two; give one", own.node)));
            }
        }
        for board in &plan.boards {
            if let Some(text) = shipped(plan, board)
                && !sheets.contains_key(&board.node)
            {
                // Both masters have Node-ID 1.
                let node = if is_master(board.node) { MASTER } else { board.node };
                let sheet = Sheet::read(text, node);
                sheets.insert(
                    board.node,
                    sheet.map_err(|cause| Misuse::of("demo", format!("docs/eds: {cause}")))?,
                );
            }
        }
        Ok(Sheets(sheets))
    }

    /// The last values of all PDOs that were sent, by board and number.
    pub fn values(&self, flight: &Flight) -> Vec<PdoValues> {
        let mut found: BTreeMap<(Node, u16), PdoValues> = BTreeMap::new();
        for (at, seen) in flight.frames() {
            let WireId::Standard(id) = seen.frame.id else { continue };
            let pdos = self.0.get(&seen.from).into_iter().flat_map(|sheet| &sheet.pdos);
            let Some(pdo) = pdos.into_iter().find(|pdo| pdo.id == id) else { continue };
            let Some(values) = pdo.values(seen.frame.payload()) else { continue };
            let entry = found.entry((seen.from, pdo.number)).or_insert_with(|| PdoValues {
                node: seen.from,
                pdo: pdo.number,
                cob_id: format!("{id:03X}h"),
                frames: 0,
                last_at_seconds: 0.0,
                values: Vec::new(),
            });
            entry.frames += 1;
            entry.last_at_seconds = seconds(at);
            entry.values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        }
        found.into_values().collect()
    }
}

fn seconds(at: Time) -> f64 {
    (at.as_secs_f64() * 1e6).round() / 1e6
}

/// The data sheet of a shipped image; `None` for an image of the user's.
fn shipped(plan: &Plan, board: &BoardPlan) -> Option<&'static str> {
    match (&board.own_image, board.is_minimal) {
        (Some(_), _) => None,
        (None, _) if is_master(board.node) => Some(OF_MASTER),
        (None, true) if plan.profile == Profile::Librecube => Some(OF_MINIMAL_LIBRECUBE),
        (None, true) => Some(OF_MINIMAL),
        (None, false) => Some(OF_SLAVE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    /// Given a master that distributes its time every 10 s, the last time 30 s at 30.05 s, then the PDO has both parts by name.
    #[test]
    fn spacecraft_time_of_the_shipped_master_has_names() {
        let flight = sample::flight();
        let mut all = Sheets::of(&flight.plan, &[]).unwrap().values(&flight);
        all.retain(|pdo| pdo.node == 1);
        let time = all.first().expect("spacecraft time of the master");
        assert_eq!((time.pdo, &*time.cob_id), (1, "181h"));
        let value =
            |name: &str| time.values.iter().find(|(own, _)| own.contains(name)).map(|(_, value)| &**value);
        assert_eq!((value("Coarse"), value("Fine")), (Some("30"), Some("0")), "{time:?}");
        // At 20.05 s no node acknowledged the master.
        assert_eq!((time.frames, time.last_at_seconds), (3, 30.05));
    }

    #[test]
    fn a_sheet_of_the_user_is_a_node_and_a_file() {
        assert_eq!("3=a=b.eds".parse(), Ok(OwnSheet { node: 3, file: "a=b.eds".into() }));
        for (wrong, said) in [("3", "for example"), ("0=x", "1 to 15"), ("16=x", "1 to 15"), ("3=", "file")] {
            assert!(wrong.parse::<OwnSheet>().is_err_and(|error| error.contains(said)), "{wrong}");
        }
    }

    #[test]
    fn a_sheet_of_no_board_is_refused() {
        let own = OwnSheet { node: 9, file: "a.eds".into() };
        let error = Sheets::of(&sample::plan(), &[own]).unwrap_err().to_string();
        assert!(
            error.contains("'9=a.eds' for '--eds <N=FILE>'") && error.contains("no board is node 9"),
            "{error}"
        );
    }
}
