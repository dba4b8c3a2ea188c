//! What cannot be described is refused, with the reason.
//!
//! Verifies: ECSS 6.6a

use ecss_can::od::{Declared, Names, Object, Objects, Place, Record, Run, Variable, VisibleString};
use ecss_can::types::{AbortCode, NodeId};
use ecss_can_eds::{Commissioning, Description, Error};

use crate::fixture::{description, device, fixture};

/// `derive(Objects)` refuses it; by hand it can be written.
#[derive(Default)]
struct Twice(One);

#[derive(Objects)]
struct One {
    /// One
    #[object(0x2000, ro)]
    one: u8,
}

impl Objects for Twice {
    const COUNT: u16 = One::COUNT;
    const DECLARED: &'static Declared = One::DECLARED;

    fn object(index: u16) -> Option<(&'static Object, u16, u16)> {
        One::object(index)
    }

    fn each_object(visit: &mut dyn FnMut(&'static Object)) {
        One::each_object(visit);
        One::each_object(visit);
    }

    fn describe(visit: &mut dyn FnMut(&'static Object, &'static Names)) {
        One::describe(visit);
        One::describe(visit);
    }

    fn variable(&mut self, place: Place) -> Option<&mut dyn Variable> {
        self.0.variable(place)
    }

    fn bits(&self, place: Place, run: Run) -> Option<u64> {
        self.0.bits(place, run)
    }

    fn set_bits(&mut self, place: Place, run: Run, bits: u64) -> Option<()> {
        self.0.set_bits(place, run, bits)
    }
}

#[test]
fn an_index_that_is_described_twice() {
    let refused = Description::new(&device(), |_| Twice::default()).unwrap_err();
    assert_eq!(refused, Error::Twice { index: 0x2000 });
    assert_eq!(refused.to_string(), "2000h is declared twice");
}

/// Declares a sub-index and does not have it.
struct Hollow;

impl Record for Hollow {
    const ENTRIES: &'static [ecss_can::od::Entry] = Full::ENTRIES;
    const NAMES: &'static [&'static str] = Full::NAMES;

    fn variable(&mut self, _sub: u8) -> Option<&mut dyn Variable> {
        None
    }
}

impl Default for Hollow {
    fn default() -> Self {
        Hollow
    }
}

#[derive(Record)]
struct Full {
    /// Value
    #[sub(1, ro)]
    value: u8,
}

#[derive(Objects)]
struct Holder {
    /// Hollow
    #[object(0x2001, record)]
    hollow: Hollow,
}

#[test]
fn a_value_that_is_declared_and_missing() {
    let refused = Description::new(&device(), |_| Holder::default()).unwrap_err();
    assert_eq!(refused, Error::Missing { index: 0x2001, sub: 1, code: AbortCode::NoSubIndex });
}

#[derive(Objects)]
struct Named {
    /// Temperature in °C
    #[object(0x2000, ro)]
    temperature: u8,
}

#[test]
fn a_name_beyond_ascii() {
    let refused = Description::new(&device(), |_| Named::default()).unwrap_err();
    assert_eq!(refused, Error::Text { text: "Temperature in °C".into() });
}

#[test]
fn texts_that_readers_cut() {
    let long = "x".repeat(242);
    let comments = ["a ; comment", "a # comment", "a\\", "a \\; b"];
    let quoted = ["\"a\"", "'a'", "`a`"];
    let ends = [" blank first", "blank last ", "two\nlines", &long];
    for text in comments.into_iter().chain(quoted).chain(ends) {
        let mut device = device();
        device.comments.push(text.into());
        let refused = Description::new(&device, fixture).unwrap_err();
        assert_eq!(refused, Error::Text { text: text.into() });

        let commissioning = Commissioning { name: text.into(), ..Commissioning::new(NodeId::MASTER) };
        let refused = description().dcf("", "", &commissioning, &mut fixture(NodeId::MASTER));
        assert_eq!(refused, Err(Error::Text { text: text.into() }));
    }
}

#[test]
fn a_string_value_that_readers_cut() {
    let mut configured = fixture(NodeId::MASTER);
    for text in ["a;b", "a#b"] {
        configured.types.visible_string = VisibleString::new(text.as_bytes()).unwrap();
        let commissioning = Commissioning::new(NodeId::MASTER);
        let refused = description().dcf("", "", &commissioning, &mut configured);
        assert_eq!(refused, Err(Error::Text { text: text.into() }));
    }
}

/// Given a device with a bit rate beside those of the standard, when it lacks 500, 250 or 125 kbit/s, then it is not described.
///
/// Verifies: ECSS 5.4.2b
/// Notices: ECSS 5.4.2b: one of the three rates is enough for a further one.
#[test]
fn further_bit_rate_without_those_of_the_standard() {
    for further in [10, 20, 50, 800] {
        for others in [&[][..], &[1000], &[125], &[125, 250, 1000], &[125, 500], &[250, 500, 1000]] {
            let device = ecss_can_eds::Device { bit_rates: [others, &[further]].concat(), ..device() };
            let refused = Description::new(&device, fixture).unwrap_err();
            assert_eq!(refused, Error::BitRate { rate: further });
            assert_eq!(
                refused.to_string(),
                format!(
                    "bit rate {further} kbit/s is for devices with 125, 250 and 500 kbit/s (ECSS 5.4.2b): name all in `bit_rates`"
                )
            );
        }
    }
}
