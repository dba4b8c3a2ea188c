//! What a data sheet says in comments: how long strings may be, what "save" does not keep.
//!
//! Verifies: ECSS 6.6a

use ecss_can::od::{Enumeration, Objects};
use ecss_can_eds::{Description, Error};

use crate::fixture::{Fixture, description, device, fixture};
use crate::ini::Ini;

fn lines(description: &Description) -> Vec<String> {
    let eds = Ini::parse(&description.eds("fixture.eds"));
    let comments = eds.section("Comments");
    let count: usize = comments.get("Lines").parse().unwrap();
    // Behind the two of the device.
    (3..=count).map(|line| comments.get(&format!("Line{line}")).to_owned()).collect()
}

/// The values of an object of each node.
const PROGRAM: &str = "2033sub3: 0 Unchecked, 1 Whole, 2 Damaged, 3 Mended";

#[test]
fn capacities_of_writable_strings_are_comments() {
    // 600Ah, 600Bh and 1008h to 100Ah are strings, too, but no client writes them.
    assert_eq!(lines(&description()), ["6009 takes at most 9 bytes", PROGRAM]);
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(i8)]
enum Mode {
    Boost = 8,
    #[default]
    Off = 0,
    Reverse = -1,
}

#[derive(Objects)]
struct Heater {
    /// Mode
    #[object(0x6001, rw, default = Mode::Reverse)]
    mode: Mode,
    /// Modes
    #[object(0x6002, array, ro)]
    modes: [Mode; 3],
    /// Mode of a phase
    #[object(0x6003.., rw, low = 0)]
    phases: [Mode; 2],
}

/// Given values of an enumeration, then a comment names them, and the limits are the least and the greatest number, or those of the
/// declaration.
#[test]
fn values_of_an_enumeration_are_limits_and_a_comment() {
    let description = Description::new(&device(), |_| Heater::default()).unwrap();
    let names = "8 Boost, 0 Off, -1 Reverse";
    let expected = ["6001", "6002sub1 to 6002sub3", "6003", "6004"].map(|at| format!("{at}: {names}"));
    assert_eq!(lines(&description), expected);
    let eds = Ini::parse(&description.eds("heater.eds"));
    for (section, low) in [("6001", "-1"), ("6002sub3", "-1"), ("6004", "0")] {
        let section = eds.section(section);
        assert_eq!(
            (section.get("DataType"), section.get("LowLimit"), section.get("HighLimit")),
            ("0x0002", low, "8")
        );
    }
    assert_eq!(eds.section("6001").get("DefaultValue"), "-1");
    assert!(eds.section("6002sub0").find("LowLimit").is_none());
}

/// Given an enumeration with more names than a line takes, then they are in several lines, and each begins with the object.
#[test]
fn many_names_of_an_enumeration_are_several_comments() {
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
    #[repr(u16)]
    enum Many {
        #[default]
        NothingHasHappenedSinceTheLastReset,
        BatteryVoltageIsBelowItsLowerLimit,
        CurrentOfTheHeaterExceedsItsLimit,
        SensorDoesNotAnswerOnItsInterface,
        TemperatureIsOutsideOfTheTable,
        ValveHasNotReachedItsPosition,
        PressureRisesWithoutACommand,
    }
    #[derive(Objects)]
    struct Device {
        /// Many
        #[object(0x6001, ro)]
        many: Many,
    }
    let lines = lines(&Description::new(&device(), |_| Device::default()).unwrap());
    assert_eq!(lines.len(), 2);
    assert!(lines[0].starts_with("6001: 0 NothingHasHappenedSinceTheLastReset, 1 "), "{lines:?}");
    assert!(
        lines[1].starts_with("6001: ") && lines[1].ends_with(" 6 PressureRisesWithoutACommand"),
        "{lines:?}"
    );
}

#[test]
fn name_of_an_enumeration_that_readers_do_not_know_is_refused() {
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
    #[repr(u8)]
    enum Unit {
        #[default]
        Kühl,
    }
    #[derive(Objects)]
    struct Device {
        /// Unit
        #[object(0x6001, ro)]
        unit: Unit,
    }
    let refused = Description::new(&device(), |_| Device::default()).unwrap_err();
    assert_eq!(refused, Error::Text { text: "Kühl".into() });
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
    assert_eq!(lines(&saving.unwrap()), ["6009 takes at most 9 bytes", PROGRAM, expected]);
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
    let commissioning = ecss_can_eds::Commissioning::new(node);
    let dcf = description().dcf("fixture.dcf", "fixture.eds", &commissioning, &mut configured).unwrap();
    let dcf = Ini::parse(&dcf);
    assert!((1..=8).all(|sub| dcf.section(&format!("1003sub{sub}")).find("ParameterValue").is_none()));
}
