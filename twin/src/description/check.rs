//! Checks of a description: each value by the part, each pin once.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use super::{Description, format};
use crate::bxcan::Side;
use crate::model::{CanPins, MOST_LEDS, Model, Oscillator, Part, Pins, Straps};
use crate::peripherals::{CAPTURE_PINS, TIM3_PINS, can_pins};
use crate::pin::Pin;

/// Frequencies of a crystal and of an external clock, Hz (DS8626 and DS10693, "External clock source characteristics").
const CRYSTAL: RangeInclusive<f64> = 4e6..=26e6;
const EXTERNAL: RangeInclusive<f64> = 1e6..=50e6;

/// Pins that are reserved: debug probe and oscillator.
const RESERVED: [(Pin, &str); 4] = [
    (Pin::new('A', 13), "SWDIO of the debug probe"),
    (Pin::new('A', 14), "SWCLK of the debug probe"),
    (Pin::new('H', 0), "OSC_IN of the oscillator"),
    (Pin::new('H', 1), "OSC_OUT of the oscillator"),
];

/// Pins of LEDs, in the order of their names.
type Leds = [Option<Pin>; MOST_LEDS];

/// Pins of a description that were read, with their fields.
#[derive(Default)]
pub(super) struct Checker {
    used: Vec<(Pin, String)>,
}

impl Checker {
    /// # Errors
    /// Field, what was found, what is allowed.
    pub(super) fn description(&mut self, raw: &format::Board) -> Result<Description, String> {
        let is_allowed =
            |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
        if raw.name.is_empty() || !raw.name.chars().all(is_allowed) {
            let name = &raw.name;
            return Err(format!("name = \"{name}\": allowed are lower-case letters, digits and hyphens"));
        }
        let part = Part::named(&raw.chip).map_err(|why| format!("chip = \"{}\": {why}", raw.chip))?;
        let format::Oscillator { frequency, kind } = &raw.oscillator;
        let oscillator =
            oscillator(frequency, kind).map_err(|(field, error)| format!("oscillator.{field} = {error}"))?;
        let pins = self.pins(part, raw)?;
        Ok(Description {
            name: raw.name.clone(),
            chip: raw.chip.clone(),
            model: Model { part, oscillator, pins },
        })
    }

    fn pins(&mut self, part: Part, raw: &format::Board) -> Result<Pins, String> {
        let can = [self.can(part, Side::Can1, &raw.can1)?, self.can(part, Side::Can2, &raw.can2)?];
        let capture = raw.capture.as_ref().map(|capture| {
            let mut wire = |side, text: &str| self.one_of(part, side, text, &CAPTURE_PINS);
            Ok::<_, String>([wire("capture.can1", &capture.can1)?, wire("capture.can2", &capture.can2)?])
        });
        let capture = capture.transpose()?;
        let pulse = raw.pulse.as_ref();
        let pulse = pulse.map(|text| self.one_of(part, "pulse", text, &TIM3_PINS.concat())).transpose()?;
        let straps = raw.straps.as_ref().map(|straps| self.straps(part, straps)).transpose()?;
        let leds = self.leds(part, &raw.leds)?;
        // Such a board does not use CAN2, and may take its pins.
        self.used.retain(|(_, field)| !field.starts_with("can2."));
        let switch = raw.transceiver_switch.as_ref();
        let transceiver_switch = switch.map(|text| self.pin(part, "transceiver-switch", text)).transpose()?;
        Ok(Pins { can, capture, pulse, straps, leds, transceiver_switch })
    }

    fn can(&mut self, part: Part, side: Side, raw: &format::Can) -> Result<CanPins, String> {
        let bus = side.to_string().to_lowercase();
        let [rx, tx] = can_pins::places(side)
            .map(|places| places.iter().copied().filter(|pin| part.has_pin(*pin)).collect::<Vec<_>>());
        Ok(CanPins {
            rx: self.one_of(part, &format!("{bus}.rx"), &raw.rx, &rx)?,
            tx: self.one_of(part, &format!("{bus}.tx"), &raw.tx, &tx)?,
        })
    }

    fn straps(&mut self, part: Part, raw: &format::Straps) -> Result<Straps, String> {
        let [a, b, c, d] = &raw.bits;
        let mut bit = |n: usize, text: &str| self.pin(part, &format!("straps.bits[{n}]"), text);
        let bits = [bit(0, a)?, bit(1, b)?, bit(2, c)?, bit(3, d)?];
        let parity = self.pin(part, "straps.parity", &raw.parity)?;
        let maintenance = raw.maintenance.as_ref();
        let maintenance = maintenance.map(|text| self.pin(part, "straps.maintenance", text)).transpose()?;
        Ok(Straps { bits, parity, maintenance })
    }

    fn leds(&mut self, part: Part, raw: &BTreeMap<String, String>) -> Result<Leds, String> {
        if raw.len() > MOST_LEDS {
            return Err(format!("leds: {} of them; allowed are {MOST_LEDS}", raw.len()));
        }
        let mut leds = Leds::default();
        for (place, (name, text)) in leds.iter_mut().zip(raw) {
            *place = Some(self.pin(part, &format!("leds.{name}"), text)?);
        }
        Ok(leds)
    }

    /// Reads a pin that must be one of `allowed`.
    fn one_of(&mut self, part: Part, field: &str, text: &str, allowed: &[Pin]) -> Result<Pin, String> {
        let pin = self.pin(part, field, text)?;
        if allowed.contains(&pin) {
            return Ok(pin);
        }
        let allowed: Vec<_> = allowed.iter().map(Pin::to_string).collect();
        Err(format!(
            "{field} = \"{text}\": the {part} has this signal at other pins; allowed are {}",
            allowed.join(", ")
        ))
    }

    /// Reads a pin, which the package must have and no other field may use.
    fn pin(&mut self, part: Part, field: &str, text: &str) -> Result<Pin, String> {
        let wrong = |what: &str| Err(format!("{field} = \"{text}\": {what}"));
        let Some(pin) = Pin::named(text) else {
            return wrong("no name of a pin; allowed are PA0 to PK15, as the package has them");
        };
        if !part.has_pin(pin) {
            let pins = part.package_pins();
            return wrong(&format!(
                "the {part} has no such pin; allowed are pins of its package of {pins} pins"
            ));
        }
        if let Some((_, what)) = RESERVED.iter().find(|(reserved, _)| *reserved == pin) {
            return wrong(&format!("this pin is {what}; allowed is any other pin"));
        }
        if let Some((_, other)) = self.used.iter().find(|(used, _)| *used == pin) {
            return wrong(&format!("{other} has this pin; allowed is a pin that no other field has"));
        }
        self.used.push((pin, field.to_owned()));
        Ok(pin)
    }
}

/// # Errors
/// Which field is wrong; what was found, and what is allowed.
pub(super) fn oscillator(frequency: &str, kind: &str) -> Result<Oscillator, (&'static str, String)> {
    let (external, range) = match kind.trim() {
        "crystal" => (false, CRYSTAL),
        "external" => (true, EXTERNAL),
        _ => return Err(("kind", format!("\"{kind}\": allowed are \"crystal\" and \"external\""))),
    };
    let number = frequency.trim().strip_suffix("MHz").map(str::trim_end);
    let hz = number.and_then(|number| number.parse::<f64>().ok()).map(|mhz| mhz * 1e6);
    match hz {
        Some(hz) if range.contains(&hz) => Ok(Oscillator { hz: hz.round() as u64, external }),
        _ => {
            let [from, to] = [range.start(), range.end()].map(|hz| hz / 1e6);
            let what = if external { "a clock from outside" } else { "a crystal" };
            Err((
                "frequency",
                format!("\"{frequency}\": allowed are {from}MHz to {to}MHz for {what}, such as \"8MHz\""),
            ))
        }
    }
}
