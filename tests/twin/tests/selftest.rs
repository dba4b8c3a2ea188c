//! The self-test of the boards: all is well, and each fault once by its name.

use std::sync::Arc;

use can_wire::fault::Fault;
use can_wire::time::Time;
use twin::board::{BoardConfig, Fittings, State};
use twin::crystal::Crystal;
use twin::image::Image;
use twin::model::Model;
use twin::peripherals::Pin;
use twin::rtt::Level;
use twin::spacecraft::{Bus, Spacecraft, SpacecraftConfig};

const BOARDS: [(&str, Model); 2] =
    [("pyboard-v11", Model::PYBOARD_V11), ("nucleo-f446re", Model::NUCLEO_F446RE)];

/// Straps of node 2, and the LED that is on every board.
fn pins(model: Model) -> (Pin, Pin) {
    match model {
        Model::PYBOARD_V11 => (Pin::new('A', 3), Pin::new('B', 4)),
        _ => (Pin::new('C', 1), Pin::new('A', 5)),
    }
}

/// What a flight showed.
struct Flown {
    /// Lines of the log at level info.
    good: Vec<String>,
    /// Lines at level error.
    bad: Vec<String>,
    /// Times at which the activity LED went on.
    blinks: usize,
    /// The LED is on at the end.
    is_lit: bool,
}

/// Flies the self-test on one board that hangs alone on both buses, for `ms`.
fn flown(
    (name, model): (&str, Model),
    fittings: Fittings,
    has_straps: bool,
    faults: &[(Bus, Fault)],
    ms: u64,
) -> Flown {
    let elf = firmware_images::build_example(name, "selftest").unwrap();
    let image = Arc::new(Image::parse(&std::fs::read(elf).unwrap()).unwrap());
    let (strap, led) = pins(model);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for (bus, fault) in faults {
        spacecraft.wire_mut(*bus).schedule(Time::ZERO, *fault).unwrap();
    }
    let id = spacecraft.add_board(BoardConfig {
        name: "bare".to_owned(),
        model,
        image,
        straps: has_straps.then_some((strap, false)).into_iter().collect(),
        crystal: Crystal::ppm(20.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings,
    });
    spacecraft.run_until(Time::from_ms(ms)).unwrap();
    let logs = spacecraft.take_logs();
    let of = |level| logs.iter().filter(move |line| line.level == Some(level)).map(|line| line.text.clone());
    let (good, bad) = (of(Level::Info).collect(), of(Level::Error).collect());
    let board = spacecraft.board_mut(id);
    assert_eq!((board.state(), board.counters().panics), (&State::Running, 0));
    let changes = board.take_pin_changes();
    Flown {
        good,
        bad,
        blinks: changes.iter().filter(|change| change.pin == led && change.high).count(),
        is_lit: board.pin_level(led),
    }
}

/// Given a board as it should be, then every check is good and the LED stays on.
#[test]
fn sound_board_passes_every_check() {
    for board in BOARDS {
        let Flown { good, bad, blinks, is_lit } = flown(board, Fittings::default(), true, &[], 500);
        assert_eq!(bad, [""; 0], "{board:?}");
        let checks = [
            "1 clock: good",
            "2 controller of the nominal bus: good",
            "3 controller of the redundant bus: good",
            "4 transceiver of the nominal bus: good",
            "6 capture of the nominal bus: good",
            "5 transceiver of the redundant bus: good",
            "7 capture of the redundant bus: good",
            "8 parameter store: good",
            "9 straps: good",
            "this board is node 2",
            "selftest: all good",
        ];
        assert_eq!(good, checks, "{board:?}");
        assert_eq!((blinks, is_lit), (1, true), "{board:?}");
    }
}

/// Given one fault, then the log names it and the LED blinks its number.
#[test]
fn each_fault_is_reported_by_its_name_and_number() {
    let sound = Fittings::default();
    let no_wires = Fittings { capture_wires: false, ..sound };
    let short = |bus, level| [(bus, Fault::Short { position_m: 0.0, level })];
    let [nominal_silent, redundant_silent] = Bus::ALL.map(|bus| short(bus, true));
    let redundant_dominant = short(Bus::Redundant, false);
    let captures = ["6 capture of the nominal bus: TooFew(0)", "7 capture of the redundant bus: TooFew(0)"];
    for board in BOARDS {
        for (fittings, has_straps, faults, reports, number) in [
            (no_wires, true, &[][..], &captures[..], 6),
            (sound, false, &[], &["9 straps: Parity"], 9),
            (sound, true, &nominal_silent, &["4 transceiver of the nominal bus: NoEcho"], 4),
            (sound, true, &redundant_silent, &["5 transceiver of the redundant bus: NoEcho"], 5),
            (sound, true, &redundant_dominant, &["5 transceiver of the redundant bus: Dominant"], 5),
        ] {
            let Flown { bad, blinks, is_lit, .. } =
                flown(board, fittings, has_straps, faults, 1_000 + 500 * number as u64);
            let sum = format!("selftest: failed, first in check {number}");
            let expected: Vec<&str> = reports.iter().copied().chain([sum.as_str()]).collect();
            assert_eq!(bad.len(), expected.len(), "{board:?}: {bad:#?}");
            for (found, expected) in bad.iter().zip(expected) {
                assert!(found.starts_with(expected), "{board:?}: {found} for {expected}");
            }
            assert_eq!((blinks, is_lit), (number, false), "{board:?}: {bad:#?}");
        }
    }
}

/// Given a broken oscillator, then no check begins, the log says why, and the LED blinks without end.
#[test]
fn broken_oscillator_is_reported_before_any_check() {
    for board in BOARDS {
        let fittings = Fittings { hse_starts: false, ..Fittings::default() };
        let Flown { good, bad, blinks, .. } = flown(board, fittings, true, &[], 1_500);
        assert_eq!(good, [""; 0]);
        assert!(bad.len() == 1 && bad[0].contains("HSE does not start"), "{bad:?}");
        assert!(blinks >= 2, "{board:?}: {blinks}");
    }
}
