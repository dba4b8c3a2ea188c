//! The self-test of the boards: without a fault, and with each fault by its name.

use can_twin::board::{BoardConfig, Defect, Fittings, State};
use can_twin::bxcan::StuckBits;
use can_twin::crystal::Crystal;
use can_twin::pin::Pin;
use can_twin::rtt::Level;
use can_twin::spacecraft::{Bus, Spacecraft, SpacecraftConfig};
use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use flight::{NUCLEO_F446RE, PYBOARD_V11, STM32F4DISCOVERY, bare, parsed};

const BOARDS: [&str; 3] = [PYBOARD_V11, NUCLEO_F446RE, STM32F4DISCOVERY];

/// Returns the strap of node 2 and the SYNC LED of a board.
fn pins(name: &str) -> (Pin, Pin) {
    match name {
        PYBOARD_V11 => (Pin::new('A', 3), Pin::new('B', 4)),
        NUCLEO_F446RE => (Pin::new('C', 1), Pin::new('A', 5)),
        _ => (Pin::new('E', 8), Pin::new('D', 12)),
    }
}

/// Results of a flight.
struct Flown {
    /// Lines of the log at level info.
    good: Vec<String>,
    /// Lines at level error.
    bad: Vec<String>,
    /// Times at which the SYNC LED went on.
    blinks: usize,
    /// Whether the LED is on at the end.
    is_lit: bool,
}

/// Faults of a board and of its buses, which have no other node.
struct Bench<'a> {
    fittings: Fittings,
    has_straps: bool,
    faults: &'a [(Bus, Fault)],
    defect: Option<Defect>,
    option_bytes: Option<u32>,
}

/// Returns a bench without a fault.
fn sound() -> Bench<'static> {
    let fittings = Fittings::default();
    Bench { fittings, has_straps: true, faults: &[], defect: None, option_bytes: None }
}

/// Flies the self-test on a board for `ms`.
fn flown(name: &str, bench: &Bench<'_>, ms: u64) -> Flown {
    let image = parsed(&ecss_can_cli::images::build_check(name, "selftest").unwrap());
    let (strap, led) = pins(name);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for (bus, fault) in bench.faults {
        spacecraft.wire_mut(*bus).schedule(Time::ZERO, *fault).unwrap();
    }
    let id = spacecraft.add_board(BoardConfig {
        straps: bench.has_straps.then_some((strap, false)).into_iter().collect(),
        crystal: Crystal::ppm(20.0),
        fittings: bench.fittings,
        ..bare(name, image)
    });
    let board = spacecraft.board_mut(id);
    bench.defect.into_iter().for_each(|defect| board.inflict(defect));
    bench.option_bytes.into_iter().for_each(|bytes| board.set_option_bytes(bytes));
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

/// Given a board without a fault, then every check passes and the LED stays on.
#[test]
fn sound_board_passes_every_check() {
    for board in BOARDS {
        let Flown { good, bad, blinks, is_lit } = flown(board, &sound(), 500);
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

/// Asserts that the first failing check on each board is `number`: the log has these reports and a summary, and the LED
/// blinks the number.
fn assert_reports(bench: &Bench<'_>, number: usize, reports: &[&str]) {
    for board in BOARDS {
        let Flown { bad, blinks, is_lit, .. } = flown(board, bench, 1_000 + 500 * number as u64);
        let sum = format!("selftest: failed, first in check {number}");
        let expected: Vec<&str> = reports.iter().copied().chain([sum.as_str()]).collect();
        assert_eq!(bad.len(), expected.len(), "{board:?}: {bad:#?} for {reports:?}");
        for (found, expected) in bad.iter().zip(expected) {
            assert!(found.starts_with(expected), "{board:?}: {found} for {expected}");
        }
        assert_eq!((blinks, is_lit), (number, false), "{board:?}: {bad:#?}");
    }
}

/// Given one fault, then the log names it and the LED blinks its number.
#[test]
fn each_fault_is_reported_by_its_name_and_number() {
    let no_wires = Fittings { capture_wires: false, ..Fittings::default() };
    let captures = ["6 capture of the nominal bus: TooFew(0)", "7 capture of the redundant bus: TooFew(0)"];
    assert_reports(&Bench { fittings: no_wires, ..sound() }, 6, &captures);
    assert_reports(&Bench { has_straps: false, ..sound() }, 9, &["9 straps: Open"]);
    for (bus, level, report, number) in [
        (Bus::Nominal, true, "4 transceiver of the nominal bus: NoEcho", 4),
        (Bus::Redundant, true, "5 transceiver of the redundant bus: NoEcho", 5),
        (Bus::Redundant, false, "5 transceiver of the redundant bus: Dominant", 5),
    ] {
        let faults = [(bus, Fault::Short { position_m: 0.0, level })];
        assert_reports(&Bench { faults: &faults, ..sound() }, number, &[report]);
    }
}

/// Given a broken oscillator, then no check starts, the log has the reason, and the LED keeps blinking.
#[test]
fn broken_oscillator_is_reported_before_any_check() {
    for board in BOARDS {
        let fittings = Fittings { hse_starts: false, ..Fittings::default() };
        let Flown { good, bad, blinks, .. } = flown(board, &Bench { fittings, ..sound() }, 1_500);
        assert_eq!(good, [""; 0]);
        assert!(bad.len() == 1 && bad[0].contains("HSE does not start"), "{bad:?}");
        assert!(blinks >= 2, "{board:?}: {blinks}");
    }
}

/// Registers of the CAN controllers, by their offset.
const MSR: u32 = 0x004;
const TSR: u32 = 0x008;
const BTR: u32 = 0x01C;
const RDLR0: u32 = 0x1B8;
const FA1R: u32 = 0x21C;
const CAN2: u32 = 0x400;
const INAK: u32 = 1 << 0;
const RQCP0: u32 = 1 << 0;
const TXOK0: u32 = 1 << 1;
const LBKM: u32 = 1 << 30;

/// Given a controller with bits that are stuck, then the check of that controller names the failing function.
#[test]
fn broken_controllers_are_reported_with_what_fails() {
    let (nominal, redundant) = ("2 controller of the nominal bus", "3 controller of the redundant bus");
    let lines = ["4 transceiver of the nominal bus", "5 transceiver of the redundant bus"];
    // Offset in the controller, bits stuck at 0, at 1; what the controller and its line report.
    let cases = [
        (MSR, INAK, 0, "Init", Some("Controller(Init)")),
        (MSR, 0, INAK, "Start", Some("Dominant")),
        (TSR, RQCP0, 0, "Transmit", Some("Controller(Transmit)")),
        (TSR, TXOK0, 0, "Error(", None),
        // It listens to its pins and sends nothing.
        (BTR, LBKM, 0, "Transmit", None),
        // 5500FFAAh with its lowest bit set.
        (RDLR0, 0, 1, "Content(1365, 1426128811)", None),
    ];
    for (side, (number, controller)) in [(2, nominal), (3, redundant)].into_iter().enumerate() {
        for (offset, zeros, ones, found, line) in cases {
            let offset = offset + CAN2 * side as u32;
            let defect = Some(Defect::Can(StuckBits { offset, zeros, ones }));
            let of_line = line.map(|line| format!("{}: {line}", lines[side]));
            let reports: Vec<_> = [format!("{controller}: {found}")].into_iter().chain(of_line).collect();
            let reports: Vec<&str> = reports.iter().map(String::as_str).collect();
            assert_reports(&Bench { defect, ..sound() }, number, &reports);
        }
    }
}

/// Given filter banks of one controller that cannot be switched on, then it alone receives nothing.
#[test]
fn stuck_filter_banks_are_reported_by_their_controller() {
    for (number, banks, report) in [
        (2, 0x0000_3FFF, "2 controller of the nominal bus: Receive"),
        (3, 0x0FFF_C000, "3 controller of the redundant bus: Receive"),
    ] {
        let stuck = StuckBits { offset: FA1R, zeros: banks, ones: 0 };
        assert_reports(&Bench { defect: Some(Defect::Can(stuck)), ..sound() }, number, &[report]);
    }
}

/// Given capture wires that are exchanged, then both are reported as such.
#[test]
fn exchanged_capture_wires_are_reported() {
    let reports = ["6 capture of the nominal bus: Swapped", "7 capture of the redundant bus: Swapped"];
    assert_reports(&Bench { defect: Some(Defect::ExchangedCaptures), ..sound() }, 6, &reports);
}

/// Given a prescaler with half of its value, then 10 ms of the timer are 840 000 cycles of the core, and some hundred
/// for reading both.
#[test]
fn wrong_clock_is_reported_with_its_cycles() {
    for board in BOARDS {
        let bench = Bench { defect: Some(Defect::Apb1Prescaler), ..sound() };
        // The LED is twice as fast too: it blinks each second.
        let Flown { bad, blinks, is_lit, .. } = flown(board, &bench, 700);
        let rate = bad[0].strip_prefix("1 clock: Rate(").and_then(|rest| rest.split_once(')'));
        let cycles: u32 = rate.and_then(|(cycles, _)| cycles.parse().ok()).unwrap_or_default();
        assert!(bad.len() == 2 && cycles.abs_diff(840_000) < 1_000, "{board:?}: {bad:#?}");
        assert_eq!(bad[1], "selftest: failed, first in check 1");
        assert_eq!((blinks, is_lit), (1, false), "{board:?}");
    }
}

/// Given write-protected sectors of the parameter store, then there is no store.
#[test]
fn failing_flash_is_reported_as_no_store() {
    // Sectors 6, 7 and 10, 11: the last two of either part.
    let protected = Bench { option_bytes: Some(0x033F_AAED), ..sound() };
    assert_reports(&protected, 8, &["no parameter store", "8 parameter store: "]);
}
