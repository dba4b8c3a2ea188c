//! What a data sheet says in comments: how long strings may be, what "save" does not keep.
//!
//! Verifies: ECSS 6.6a

use eds::Description;

use crate::fixture::{Fixture, description, device, fixture};
use crate::ini::Ini;

fn lines(description: &Description) -> Vec<String> {
    let eds = Ini::parse(&description.eds("fixture.eds"));
    let comments = eds.section("Comments");
    let count: usize = comments.get("Lines").parse().unwrap();
    // Behind the two of the device.
    (3..=count).map(|line| comments.get(&format!("Line{line}")).to_owned()).collect()
}

#[test]
fn capacities_of_writable_strings_are_comments() {
    // 600Ah, 600Bh and 1008h to 100Ah are strings, too, but no client writes them.
    assert_eq!(lines(&description()), ["6009 takes at most 9 bytes"]);
}

#[test]
fn what_save_does_not_keep_is_a_comment() {
    let saving = Description::new(&device(), |node| {
        let mut objects: Fixture = fixture(node);
        objects.spacecraft.storage.store = [1; 4];
        objects
    });
    // Ctoggle; time, self-test, how the Node-ID is kept; for receive PDOs, write-only, a DOMAIN.
    let expected = "Not kept by 1010h: 2000sub4 2010 2030 2046 6006 6007 600F";
    assert_eq!(lines(&saving.unwrap()), ["6009 takes at most 9 bytes", expected]);
}

#[test]
fn errors_of_the_past_have_no_default() {
    let eds = Ini::parse(&description().eds("fixture.eds"));
    assert_eq!(eds.section("1003sub0").get("DefaultValue"), "0x00");
    for sub in 1..=8 {
        assert!(eds.section(&format!("1003sub{sub}")).find("DefaultValue").is_none(), "{sub}");
    }
}

#[test]
fn errors_of_the_past_are_no_parameters_of_a_dcf() {
    let node = ecss_can::types::NodeId::of::<3>();
    let mut configured = fixture(node);
    configured.communication.emcy.errors.errors = [0x8130; 8];
    let commissioning = eds::Commissioning::new(node);
    let dcf = description().dcf("fixture.dcf", "fixture.eds", &commissioning, &mut configured).unwrap();
    let dcf = Ini::parse(&dcf);
    assert!((1..=8).all(|sub| dcf.section(&format!("1003sub{sub}")).find("ParameterValue").is_none()));
}
