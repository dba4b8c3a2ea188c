//! Values of PDOs by the names of their objects, as the data sheets of the boards have them.

use std::collections::BTreeMap;

use can_wire::frame::WireId;
use can_wire::time::Time;
use eds::pdos;
use serde::Serialize;

use super::flight::Flight;
use super::narrator::name;
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

    /// Receive PDOs that do not fit what is sent, by the data sheets of both. A COB-ID without sender is one of them if its receiver is an
    /// image of the user's and each board has a data sheet: the shipped master has PDOs for slaves that do not fly.
    pub fn mismatches(&self, plan: &Plan) -> Vec<String> {
        let of = |board: &BoardPlan| Some(self.0.get(&board.node)?.node(&name(board.node)));
        let nodes: Vec<pdos::Node> = plan.boards.iter().filter_map(of).collect();
        let is_own = |text: &String| {
            let mut own = plan.boards.iter().filter(|board| board.own_image.is_some());
            own.any(|board| text.starts_with(&format!("{}:", name(board.node))))
        };
        let unsent = if nodes.len() == plan.boards.len() { pdos::unsent(&nodes) } else { Vec::new() };
        pdos::mismatches(&nodes).into_iter().chain(unsent.into_iter().filter(is_own)).collect()
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

    /// Given the shipped images, then their mappings match. Given a slave of the user's with another order, another COB-ID and a PDO that is
    /// too long, then each is named; the last two only when all boards have data sheets.
    #[test]
    fn mappings_that_differ_are_named_by_both_sheets() {
        let mut plan = sample::plan();
        let shipped = Sheets::of(&plan, &[]).unwrap();
        assert_eq!(shipped.mismatches(&plan), [""; 0]);
        let sheet = |text: &str| Sheet::read(text, 2).unwrap();
        let own = "[1400sub1]\nDefaultValue=0x40000181\n\
            [1600sub0]\nDefaultValue=2\n[1600sub1]\nDefaultValue=0x21000120\n[1600sub2]\nDefaultValue=0x21000218\n\
            [2100sub1]\nParameterName=Coarse\nDataType=0x0007\n[2100sub2]\nParameterName=Fine\nDataType=0x0016\n\
            [1401sub1]\nDefaultValue=0x333\n[1601sub0]\nDefaultValue=1\n[1601sub1]\nDefaultValue=0x21000120\n";
        plan.boards[1].own_image = Some("own".into());
        let mut sheets = Sheets::of(&plan, &[]).unwrap();
        sheets.0.insert(2, sheet(own));
        let said = sheets.mismatches(&plan);
        assert!(
            said[0].starts_with(
                "node 2: RPDO 1 (181h) has Coarse with 32 bits at place 1, TPDO 1 of master has "
            ),
            "{said:?}"
        );
        assert_eq!(said[1..], ["node 2: RPDO 2 (333h) is sent by no node"]);
        sheets.0.insert(2, sheet(&own.replace("0x21000218\n", "0x21000238\n")));
        let said = sheets.mismatches(&plan);
        assert!(
            said[0].ends_with("has 11 bytes, TPDO 1 of master has 7: the receiver rejects it"),
            "{said:?}"
        );
        sheets.0.remove(&4);
        assert_eq!(sheets.mismatches(&plan).len(), 1, "node 4 may send 333h");
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
