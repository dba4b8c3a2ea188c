//! Descriptions that are read, and deliberate mistakes in them.

use super::*;
use crate::model::{CanPins, MOST_LEDS, Part, Pins, Straps};
use crate::pin::Pin;

/// A board with an STM32F407VG and other pins than the shipped boards.
const DISCOVERY: &str = r#"
name = "discovery"
chip = "STM32F407VGT6"
pulse = "PC9"
transceiver-switch = "PB6"
oscillator = { frequency = "8MHz", kind = "crystal" }
can1 = { rx = "PD0", tx = "PD1" }
can2 = { rx = "PB5", tx = "PB6" }
capture = { can1 = "PA3", can2 = "PA2" }
straps = { bits = ["PC0", "PC1", "PC2", "PC3"], parity = "PC4", maintenance = "PC5" }
leds = { green = "PD12", orange = "PD13", red = "PD14", blue = "PD15" }
"#;

const fn pin(port: char, number: u8) -> Pin {
    Pin::new(port, number)
}

#[test]
fn each_field_of_a_description_is_read() {
    let board = Description::parse(DISCOVERY, "board.toml").unwrap();
    assert_eq!((&*board.name, &*board.chip), ("discovery", "STM32F407VGT6"));
    assert_eq!(board.model.part, Part::named("STM32F407VG").unwrap());
    assert_eq!(board.model.oscillator, Oscillator { hz: 8_000_000, external: false });
    let expected = Pins {
        can: [CanPins { rx: pin('D', 0), tx: pin('D', 1) }, CanPins { rx: pin('B', 5), tx: pin('B', 6) }],
        capture: Some([pin('A', 3), pin('A', 2)]),
        pulse: Some(pin('C', 9)),
        straps: Some(Straps {
            bits: [pin('C', 0), pin('C', 1), pin('C', 2), pin('C', 3)],
            parity: pin('C', 4),
            maintenance: Some(pin('C', 5)),
        }),
        // In the order of their names.
        leds: std::array::from_fn(|n| [15, 12, 13, 14].get(n).map(|&number| pin('D', number))),
        transceiver_switch: Some(pin('B', 6)),
    };
    assert_eq!(board.model.pins, expected);
}

/// Given a board with the two buses only, then it has no wires to capture inputs, no straps and no LEDs.
#[test]
fn fields_beside_part_oscillator_and_buses_are_optional() {
    let text = "name = \"bare\"\nchip = \"STM32F446VE\"\noscillator = { frequency = \"24.5MHz\", kind = \"external\" }\n\
                can1 = { rx = \"PA11\", tx = \"PA12\" }\ncan2 = { rx = \"PB12\", tx = \"PB13\" }\n";
    let Model { oscillator, pins, .. } = Description::parse(text, "board.toml").unwrap().model;
    assert_eq!(oscillator, Oscillator { hz: 24_500_000, external: true });
    assert_eq!((pins.capture, pins.straps, pins.leds), (None, None, [None; MOST_LEDS]));
    assert_eq!((pins.pulse, pins.transceiver_switch), (None, None));
}

/// Given one mistake in a good description, then the error names the file, the field, what was found and what is allowed.
#[test]
fn mistakes_are_refused_with_file_field_and_what_is_allowed() {
    let straps = r#"["PC0", "PC1", "PC2", "PC3"]"#;
    for (good, wrong, said) in [
        (r#"name = "discovery""#, r#"name = "My Board""#, &["name", "My Board", "lower-case"][..]),
        ("STM32F407VGT6", "STM32F412VG", &["chip", "STM32F412VG", "at most 100 MHz", "STM32F405"]),
        ("STM32F407VGT6", "STM32F407RG", &["chip", "STM32F407RG", "no package", "V (100 pins)"]),
        ("8MHz", "8", &["oscillator.frequency", "\"8\"", "4MHz to 26MHz"]),
        ("8MHz", "48MHz", &["oscillator.frequency", "48MHz", "4MHz to 26MHz", "crystal"]),
        ("8MHz", "NaNMHz", &["oscillator.frequency", "4MHz to 26MHz"]),
        ("crystal", "quartz", &["oscillator.kind", "quartz", "\"crystal\" and \"external\""]),
        ("PD0", "PC0", &["can1.rx", "PC0", "PB8, PA11, PD0"]),
        ("PD1", "PD0", &["can1.tx", "PD0", "can1.rx has this pin"]),
        ("\"PA3\"", "\"PA4\"", &["capture.can1", "PA4", "PA0, PA1, PA2, PA3"]),
        ("\"PA2\"", "\"PA3\"", &["capture.can2", "PA3", "capture.can1 has this pin"]),
        ("PC9", "PC10", &["pulse", "PC10", "PC9"]),
        ("PC2", "PC16", &["straps.bits[2]", "PC16", "no name of a pin", "PA0 to PK15"]),
        ("PC2", "PF2", &["straps.bits[2]", "PF2", "no such pin", "100 pins"]),
        ("PC4", "PD12", &["leds.green", "PD12", "straps.parity has this pin"]),
        ("PC5", "PA13", &["straps.maintenance", "PA13", "debug probe"]),
        ("PD13", "PH0", &["leds.orange", "PH0", "OSC_IN"]),
        (
            "leds = {",
            "leds = { a = \"PE0\", b = \"PE1\", c = \"PE2\", d = \"PE3\", e = \"PE4\", ",
            &["leds", "9 of them", "allowed are 8"],
        ),
        ("pulse = ", "pulses = ", &["unknown field `pulses`", "expected one of", "`pulse`"]),
        ("tx = \"PD1\"", "", &["missing field `tx`", "can1"]),
        ("\"PD14\"", "14", &["14", "expected a string"]),
        (straps, r#"["PC0", "PC1", "PC2"]"#, &["bits", "expected an array of length 4"]),
        (r#"name = "discovery""#, "", &["missing field `name`"]),
    ] {
        assert!(DISCOVERY.contains(good), "{good}");
        let wrong = DISCOVERY.replacen(good, wrong, 1);
        let error = Description::parse(&wrong, "my/board.toml").expect_err(&wrong).to_string();
        let names_all = error.starts_with("my/board.toml: ") && said.iter().all(|part| error.contains(part));
        assert!(names_all, "{said:?} in: {error}");
    }
}

/// Given the boards of this project, then each folder of `boards` with a description is among them.
#[test]
fn boards_of_the_project_have_a_description_each() {
    let folders = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../boards")).unwrap();
    let folders = folders.map(|folder| folder.unwrap().path());
    let mut there: Vec<_> = folders.filter(|folder| folder.join(FILE).is_file()).collect();
    there.sort();
    let of_folders = there.iter().map(|folder| folder.file_name().unwrap().to_str().unwrap().to_owned());
    assert_eq!(Description::names(), of_folders.collect::<Vec<_>>());
    for name in Description::names() {
        assert_eq!(Description::shipped(&name).name, name);
    }
}

/// Given the boards of this project, then part, oscillator and pins of each are those of docs/wiring.md.
#[test]
fn boards_of_the_project_are_those_of_the_wiring_page() {
    let pyboard = Model::shipped("pyboard-v11");
    assert_eq!(pyboard.part.to_string(), "STM32F405RG");
    assert_eq!(pyboard.oscillator, Oscillator { hz: 12_000_000, external: false });
    assert_eq!(pyboard.pins.straps.unwrap().maintenance, Some(pin('A', 7)));
    let nucleo = Model::shipped("nucleo-f446re");
    assert_eq!(nucleo.part.to_string(), "STM32F446RE");
    assert_eq!(nucleo.oscillator, Oscillator { hz: 8_000_000, external: true });
    assert_eq!(nucleo.pins.straps.unwrap().parity, pin('B', 0));
    let discovery = Model::shipped("stm32f4discovery");
    assert_eq!(discovery.part.to_string(), "STM32F407VG");
    assert_eq!(discovery.oscillator, Oscillator { hz: 8_000_000, external: false });
    assert_eq!(discovery.pins.can[0], CanPins { rx: pin('D', 0), tx: pin('D', 1) });
    assert_eq!(discovery.pins.capture, Some([pin('A', 2), pin('A', 3)]));
    assert_eq!(discovery.pins.straps.unwrap().parity, pin('E', 11));
    for model in [pyboard, nucleo] {
        let can2 = CanPins { rx: pin('B', 12), tx: pin('B', 13) };
        assert_eq!(model.pins.can, [CanPins { rx: pin('B', 8), tx: pin('B', 9) }, can2]);
        assert_eq!(model.pins.capture, Some([pin('A', 0), pin('A', 1)]));
        assert_eq!(
            (model.pins.pulse, model.pins.transceiver_switch),
            (Some(pin('B', 1)), Some(pin('B', 13)))
        );
    }
}

/// Given the example of docs/twin.md, then it describes a board.
#[test]
fn example_of_the_page_about_the_twin_is_read() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/twin.md")).unwrap();
    let example = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let board = Description::parse(example, "docs/twin.md").unwrap();
    assert_eq!(board.model.part.to_string(), "STM32F407VG");
    assert_eq!(board.model.pins.capture, Some([pin('A', 2), pin('A', 3)]));
    assert!(
        board.model.pins.straps.unwrap().maintenance.is_some()
            && board.model.pins.leds.iter().flatten().count() == 4
    );
}

/// Given the number of a board, then an odd number of straps is tied to ground, beginning with the lowest bit.
#[test]
fn straps_say_the_number_with_odd_parity() {
    let straps = Model::shipped("pyboard-v11").pins.straps.unwrap();
    for (node, closed) in [(2, &[3][..]), (3, &[2, 3, 6]), (15, &[2, 3, 4, 5, 6]), (1, &[2]), (0, &[6])] {
        let expected: Vec<_> = closed.iter().map(|number| (pin('A', *number), false)).collect();
        assert_eq!(straps.closed(node), expected, "node {node}");
    }
}

/// Given byte order marks, line ends and encodings of editors on other systems, then the file describes the same board.
/// Inside a value they are refused with its field.
#[test]
fn description_is_read_with_marks_and_letters_of_editors() {
    let here = tempfile::tempdir().unwrap();
    let file = here.path().join(FILE);
    let read = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        Description::read(&file)
    };
    let expected = Description::parse(DISCOVERY, "board.toml").unwrap();
    assert_eq!(read(["\u{FEFF}", DISCOVERY].concat().as_bytes()).as_ref(), Ok(&expected));
    assert_eq!(read(DISCOVERY.replace('\n', "\r\n").as_bytes()).as_ref(), Ok(&expected));
    // "für" in Windows-1252.
    assert_eq!(read(&[b"# f\xFCr\n", DISCOVERY.as_bytes()].concat()).as_ref(), Ok(&expected));
    let wrong = read(
        &[b"name = \"f\xFCr\"\n", DISCOVERY.replacen("name = \"discovery\"", "", 1).as_bytes()].concat(),
    );
    let error = wrong.unwrap_err().to_string();
    assert!(error.contains("name = \"f") && error.contains("allowed are lower-case letters"), "{error}");
}

#[test]
fn file_that_is_not_there_is_named() {
    let error = Description::read(Path::new("no/such/board.toml")).unwrap_err().to_string();
    assert!(error.starts_with("no/such/board.toml: "), "{error}");
}

#[test]
fn oscillator_of_the_command_line_is_frequency_and_kind() {
    assert_eq!(oscillator("8MHz"), Ok(Oscillator { hz: 8_000_000, external: false }));
    assert_eq!(oscillator("8MHz crystal"), Ok(Oscillator { hz: 8_000_000, external: false }));
    assert_eq!(oscillator("50MHz,external"), Ok(Oscillator { hz: 50_000_000, external: true }));
    for wrong in ["", "8", "50MHz", "8MHz quartz", "0.5MHz external"] {
        assert!(oscillator(wrong).is_err_and(|error| error.contains("allowed are")), "{wrong}");
    }
}
