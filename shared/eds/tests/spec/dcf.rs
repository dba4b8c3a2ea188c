//! What a DCF has beside its EDS.
//!
//! Verifies: ECSS 6.6a

use ecss_can::od::VisibleString;
use ecss_can::types::NodeId;
use ecss_can_eds::Commissioning;

use crate::fixture::{Fixture, description, fixture};
use crate::ini::Ini;

const NODE: NodeId = NodeId::of::<3>();

fn dcf(configured: &mut Fixture) -> Ini {
    let commissioning = Commissioning {
        name: "camera".into(),
        bit_rate: 500,
        network: 2,
        network_name: "nominal".into(),
        manager: true,
        ..Commissioning::new(NODE)
    };
    Ini::parse(&description().dcf("fixture-3.dcf", "fixture.eds", &commissioning, configured).unwrap())
}

/// Where `ParameterValue` stands, and what it says.
fn parameters(dcf: &Ini) -> Vec<(String, String)> {
    let parameter =
        |name: &str| dcf.section(name).find("ParameterValue").map(|value| (name.into(), value.into()));
    dcf.names().filter_map(parameter).collect()
}

fn owned<const N: usize>(pairs: [(&str, &str); N]) -> Vec<(String, String)> {
    pairs.map(|(name, value)| (name.into(), value.into())).into()
}

#[test]
fn device_as_made_differs_only_where_eds_cannot_express_it() {
    let told = parameters(&dcf(&mut fixture(NODE)));
    assert_eq!(told, owned([("2103", "0x000300FA"), ("2104", "-7"), ("2105", "node 3")]));
}

/// Notices: ECSS 6.6a: a DCF has no value for a COB-ID that was moved from its formula.
#[test]
fn a_configured_device_tells_what_differs() {
    let mut configured = fixture(NODE);
    configured.communication.heartbeat.time = 100;
    configured.pdos.tpdos[1].cob_id = 0x4000_0183;
    configured.consumers.consumer_heartbeat[0] = 0x0001_00FA;
    configured.types.visible_string = VisibleString::empty();
    // The default of another node is a difference, too.
    configured.communication.emcy.cob_id = 0x84;
    configured.nodes.shifted = 0;
    let told = parameters(&dcf(&mut configured));
    assert_eq!(
        told,
        owned([
            ("1014", "0x00000084"),
            ("1016sub1", "0x000100FA"),
            ("1017", "0x0064"),
            ("1801sub1", "0x40000183"),
            ("6009", ""),
            ("2103", "0x00000000"),
            ("2104", "-7"),
            ("2105", "node 3"),
        ])
    );
}

#[test]
fn all_else_is_as_in_the_eds() {
    let eds = Ini::parse(&description().eds("fixture.eds"));
    let dcf = dcf(&mut fixture(NODE));
    for name in eds.names().filter(|name| *name != "FileInfo") {
        let (section, original) = (dcf.section(name), eds.section(name));
        let kept = section.keywords().into_iter().filter(|keyword| *keyword != "ParameterValue");
        assert_eq!(kept.collect::<Vec<_>>(), original.keywords(), "[{name}]");
        assert!(original.keywords().iter().all(|keyword| section.get(keyword) == original.get(keyword)));
    }
    assert_eq!(dcf.section("FileInfo").get("FileName"), "fixture-3.dcf");
    assert_eq!(dcf.section("FileInfo").get("LastEDS"), "fixture.eds");
}

#[test]
fn the_device_is_commissioned() {
    let mut configured = fixture(NODE);
    configured.communication.identity.serial = 0xBEEF;
    let dcf = dcf(&mut configured);
    let section = dcf.section("DeviceComissioning");
    let told: Vec<(&str, &str)> =
        section.keywords().into_iter().map(|keyword| (keyword, section.get(keyword))).collect();
    assert_eq!(
        told,
        [
            ("NodeID", "3"),
            ("NodeName", "camera"),
            ("Baudrate", "500"),
            ("NetNumber", "2"),
            ("NetworkName", "nominal"),
            ("CANopenManager", "1"),
            ("LSS_SerialNumber", "0x0000BEEF"),
        ]
    );
}
