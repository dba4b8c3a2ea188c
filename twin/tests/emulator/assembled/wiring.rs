//! Pins of the controllers, and wirings other than that of our spacecraft.

use std::sync::Arc;

use can_twin::board::{BoardConfig, EmulatedBoard, Fittings};
use can_twin::bxcan::Side;
use can_twin::guest::GuestEvent;
use can_twin::image::{Image, Symbol};
use can_twin::model::{CanPins, Model, Oscillator, Part};
use can_twin::pin::Pin;
use can_twin::spacecraft::{Bus, Event, LogRecord, Spacecraft, SpacecraftConfig, Wiring};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use can_twin::wire::timing::{BitTiming, Quantum};

use super::programs::*;

const WORD: u32 = 0x1122_3344;
/// CAN1 at the transceiver of the nominal bus.
const NOMINAL: [Pin; 2] = [Pin::new('B', 8), Pin::new('B', 9)];

/// Gives pins alternate function 9.
fn can_pins(pins: &[Pin]) -> Vec<u16> {
    let ports: u32 = pins.iter().fold(0, |ports, pin| ports | 1 << pin.port_index());
    let mut program = store(RCC + 0x30, ports);
    for port in 0..9 {
        let of_port = || pins.iter().filter(|pin| pin.port_index() == port).map(|pin| u32::from(pin.number));
        if of_port().count() == 0 {
            continue;
        }
        let base = 0x4002_0000 + 0x400 * port as u32;
        for (half, register) in [(0..8, 0x20), (8..16, 0x24)] {
            let functions = of_port().filter(|n| half.contains(n)).map(|n| 9 << (4 * (n % 8)));
            program.extend(store(base + register, functions.sum()));
        }
        program.extend(store(base, of_port().map(|n| 2 << (2 * n)).sum()));
    }
    program
}

/// A board that sends a word on `can` behind `pins`, then sleeps.
fn sender(can: u32, pins: &[Pin]) -> BoardConfig {
    let parts =
        [start_both_controllers(&can_pins(pins)), join(can, MEGABIT), send(can, 0x123, WORD), SLEEP.to_vec()];
    board("sender", image(&parts.concat(), &STOP))
}

fn frame() -> WireFrame {
    WireFrame::standard(0x123, &WORD.to_le_bytes())
}

/// Returns the events of a guest on each of the first two buses with one board in 5 ms, and the board's log.
fn heard_of(board: BoardConfig) -> ([Vec<GuestEvent>; 2], Vec<LogRecord>) {
    let mut spacecraft = spacecraft([board]);
    let guests = Bus::ALL.map(|bus| spacecraft.add_guest(bus, 1.0));
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    (guests.map(|guest| heard(&mut spacecraft, guest)), spacecraft.take_logs())
}

/// Pins and the smallest package that has them (DS8626 table 9).
#[test]
fn can_leads_to_its_bus_behind_every_pair_of_its_pins() {
    let pin = Pin::new;
    for (can, pins, part) in [
        (CAN1, [pin('B', 8), pin('B', 9)], "STM32F405RG"),
        (CAN1, [pin('A', 11), pin('A', 12)], "STM32F405RG"),
        (CAN1, [pin('A', 11), pin('B', 9)], "STM32F405RG"),
        (CAN1, [pin('D', 0), pin('D', 1)], "STM32F405VG"),
        (CAN1, [pin('I', 9), pin('H', 13)], "STM32F407IG"),
        (CAN2, [pin('B', 12), pin('B', 13)], "STM32F405RG"),
        (CAN2, [pin('B', 5), pin('B', 6)], "STM32F405RG"),
    ] {
        let mut model = Model { part: Part::named(part).unwrap(), ..Model::shipped("pyboard-v11") };
        model.pins.can[usize::from(can == CAN2)] = CanPins { rx: pins[0], tx: pins[1] };
        let (heard, log) = heard_of(BoardConfig { model, ..sender(can, &pins) });
        let received = vec![GuestEvent::Received(frame())];
        let expected = if can == CAN1 { [received, vec![]] } else { [vec![], received] };
        assert_eq!(heard, expected, "{pins:?}");
        assert_eq!(log, [], "{pins:?}");
    }
}

#[test]
fn a_controller_that_reaches_no_bus_is_told_with_the_reason() {
    let pin = Pin::new;
    let unwired = Fittings { wiring: Wiring { can1: None, ..Wiring::default() }, ..Fittings::default() };
    let on_pins = |pins: &[Pin]| sender(CAN1, pins);
    for (board, reason) in [
        (on_pins(&[pin('C', 8), pin('C', 9)]), "no pin carries CAN1_RX (AF9)"),
        (on_pins(&[pin('B', 8), pin('C', 9)]), "no pin carries CAN1_TX (AF9)"),
        // CAN2 has these.
        (on_pins(&[pin('B', 12), pin('B', 13)]), "no pin carries CAN1_RX (AF9)"),
        (on_pins(&[pin('D', 0), pin('D', 1)]), "PD0 carries CAN1_RX, and the package of 64 pins lacks it"),
        (
            on_pins(&[pin('B', 8), pin('A', 12)]),
            "PA12 carries CAN1_TX, and the board has the transceiver at PB9",
        ),
        (
            BoardConfig { fittings: unwired, ..on_pins(&[pin('B', 8), pin('B', 9)]) },
            "the board's wiring has no bus behind its transceiver",
        ),
    ] {
        let (heard, log) = heard_of(board);
        assert_eq!(heard, [vec![], vec![]], "{reason}");
        let log: Vec<_> = log.into_iter().map(|line| line.text).collect();
        assert_eq!(log, [format!("twin: CAN1 takes part in no bus: {reason}")]);
    }
}

/// Given a program for a crystal of 12 MHz on a board with one of 8 MHz, then its HCLK is 112 MHz and its controllers
/// run at two thirds of their bit rate, and the log and the warnings of the board report it, once for each controller.
#[test]
fn unknown_bit_rate_is_reported_with_the_oscillator() {
    let program = [join_both_buses(), SLEEP.to_vec()].concat();
    let expected = ["CAN1", "CAN2"].map(|can| {
        format!(
            "{can} runs at 666.7 kbit/s, which is no bit rate of CiA 301: HCLK is 112 MHz, and the oscillator of the board \
             has 8 MHz; build the image for this oscillator, or correct the oscillator of the board"
        )
    });
    for (hz, expected) in [(8_000_000, &expected[..]), (12_000_000, &[])] {
        let config = board("clocked", image(&program, &STOP));
        let oscillator = Oscillator { hz, external: false };
        let config = BoardConfig { model: Model { oscillator, ..config.model }, ..config };
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let board = spacecraft.add_board(config);
        spacecraft.run_until(Time::from_ms(5)).unwrap();
        spacecraft.reset(board);
        spacecraft.run_until(Time::from_ms(10)).unwrap();
        assert_eq!(spacecraft.board(board).warnings(), expected);
        let log: Vec<_> = spacecraft.take_logs().into_iter().map(|line| line.text).collect();
        assert_eq!(log, expected.iter().map(|text| format!("twin: {text}")).collect::<Vec<_>>());
    }
}

/// Given a program that moves CAN1 to other pins than those of its transceiver, then the warnings of the board report
/// it.
#[test]
fn a_controller_at_other_pins_is_among_the_warnings() {
    let pin = Pin::new;
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let board = spacecraft.add_board(sender(CAN1, &[pin('A', 11), pin('A', 12)]));
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    let expected =
        "CAN1 takes part in no bus: PA11 carries CAN1_RX, and the board has the transceiver at PB8";
    assert_eq!(spacecraft.board(board).warnings(), [expected]);
}

/// A program that captures at PA0 and PA1, makes its pulse at PB1, and joins the nominal bus.
fn stamping() -> Vec<u16> {
    [
        start_both_controllers(&can_pins(&NOMINAL)),
        store(RCC + 0x30, 0b11),
        store(RCC + 0x40, 1 << 25 | 1 << 26 | 1 << 3 | 1 << 1),
        store(GPIOA + 0x20, 0x22),
        store(GPIOA, 0xA800_000A),
        store(GPIOB + 0x20, 2 << 4),
        store(GPIOB, 2 << 2 | 2 << 16 | 2 << 18),
        store(TIM5 + 0x18, 0x0101),
        store(TIM5 + 0x20, 0xBB),
        store(TIM3 + 0x1C, 0b111 << 12),
        store(TIM3 + 0x20, 1 << 12),
        join(CAN1, MEGABIT),
        SLEEP.to_vec(),
    ]
    .concat()
}

/// Given wires from CAN_RX and a pulse at other pins than those of the program, then the warnings of the board name both pins. A program
/// that uses no wire, and a board without wires, get none.
#[test]
fn wires_to_pins_that_the_program_does_not_use_are_warned_of() {
    let warnings = |program: &[u16], capture: Option<[u8; 2]>, pulse: Option<Pin>, capture_wires: bool| {
        let mut config = board("stamping", image(program, &STOP));
        config.model.pins.capture = capture.map(|pins| pins.map(|pin| Pin::new('A', pin)));
        config.model.pins.pulse = pulse;
        config.fittings.capture_wires = capture_wires;
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let board = spacecraft.add_board(config);
        spacecraft.run_until(Time::from_ms(8)).unwrap();
        spacecraft.board(board).warnings().to_vec()
    };
    let (right, wrong) = (Some(Pin::new('B', 1)), Some(Pin::new('B', 0)));
    let [can1, can2] = [("CAN1", "PA2"), ("CAN2", "PA3")]
        .map(|(can, pin)| format!("TIM5 captures at PA0, and the board has the wire from {can}_RX at {pin}"));
    assert_eq!(warnings(&stamping(), Some([2, 3]), right, true), [can1, can2.clone()]);
    assert_eq!(warnings(&stamping(), Some([0, 3]), right, true), [can2]);
    let pulse = "TIM3 drives PB1, and the board has the pulse at PB0";
    assert_eq!(warnings(&stamping(), Some([0, 1]), wrong, true), [pulse]);
    for (capture, pulse, wires) in
        [(Some([0, 1]), right, true), (None, None, true), (Some([2, 3]), right, false)]
    {
        assert_eq!(warnings(&stamping(), capture, pulse, wires), [""; 0], "{capture:?} {pulse:?}");
    }
    let plain = [start_both_controllers(&can_pins(&NOMINAL)), join(CAN1, MEGABIT), SLEEP.to_vec()];
    assert_eq!(warnings(&plain.concat(), Some([2, 3]), wrong, true), [""; 0]);
}

/// Given an image for another chip, then there is no such board.
#[test]
#[should_panic(
    expected = "foreign: the image was linked for DEV_ID 421h (STM32F446), the board has an STM32F405RG (413h)"
)]
fn a_board_does_not_take_the_image_of_another_chip() {
    let image = Image::from_flash(vec![0; 8]).with_symbol("__device_id", Symbol { address: 0x421, size: 0 });
    EmulatedBoard::new(board("foreign", Arc::new(image)), 0);
}

#[test]
fn both_controllers_of_a_board_may_share_a_bus() {
    let program = [join_both_buses(), send(CAN1, 0x123, WORD), receive(CAN2, RAM), SLEEP.to_vec()].concat();
    let wiring = Wiring { can1: Some(Bus::Nominal), can2: Some(Bus::Nominal) };
    let fittings = Fittings { wiring, ..Fittings::default() };
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let board = spacecraft.add_board(BoardConfig { fittings, ..board("both", image(&program, &STOP)) });
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    assert_eq!(word(spacecraft.board(board), RAM), WORD);
    assert_eq!(spacecraft.place(board, Side::Can1), Some((Bus::Nominal, 0)));
    assert_eq!(spacecraft.place(board, Side::Can2), Some((Bus::Nominal, 1)));
}

/// Given one controller behind a transceiver switch (ECSS Figure A-6), then it is on the bus that the pin selects, and
/// keeps its error counters: no node acknowledges it on the first bus, a guest does so on the other one.
#[test]
fn transceiver_switch_leads_the_controller_from_bus_to_bus() {
    let switch = Pin::new('C', 0);
    let fittings = Fittings { transceiver_switch: Some(switch), ..Fittings::default() };
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let sender = sender(CAN1, &NOMINAL);
    let board = spacecraft.add_board(BoardConfig { fittings, ..sender });
    let guest = spacecraft.add_guest(Bus::Redundant, 1.0);
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    assert_eq!(spacecraft.place(board, Side::Can1), Some((Bus::Nominal, 0)));
    assert_eq!(spacecraft.place(board, Side::Can2), None);
    assert_eq!(spacecraft.wire(Bus::Nominal).error_counters(0).transmit, 128);
    assert_eq!(spacecraft.take_heard(guest), []);
    spacecraft.schedule(Time::ZERO, board, Event::Drive(switch, Some(true)));
    spacecraft.run_until(Time::from_ms(10)).unwrap();
    assert_eq!(spacecraft.place(board, Side::Can1), Some((Bus::Redundant, 0)));
    assert_eq!(heard(&mut spacecraft, guest), [GuestEvent::Received(frame())]);
    assert_eq!(spacecraft.wire(Bus::Redundant).error_counters(0).transmit, 127);
}

/// Given two pairs of boards on two networks other than those of the spacecraft, then each board receives from its peer
/// only.
#[test]
fn boards_talk_on_the_network_that_their_wiring_names() {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let pairs = [(Bus::Third, 0xAAAA), (Bus::Fourth, 0xBBBB)].map(|(bus, sent)| {
        let fittings = Fittings { wiring: Wiring { can1: Some(bus), can2: None }, ..Fittings::default() };
        let on_can1 = [start_both_controllers(&can_pins(&NOMINAL)), join(CAN1, MEGABIT)].concat();
        let ear = [&on_can1[..], &receive(CAN1, RAM), &SLEEP].concat();
        let mouth = [&on_can1[..], &send(CAN1, 0x123, sent), &SLEEP].concat();
        let mut add = |name, program: &[u16]| {
            spacecraft.add_board(BoardConfig { fittings, ..board(name, image(program, &STOP)) })
        };
        add("mouth", &mouth);
        (add("ear", &ear), sent)
    });
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    for (ear, sent) in pairs {
        assert_eq!(word(spacecraft.board(ear), RAM), sent);
    }
}

/// Given a guest at 250 kbit/s, then it reaches a board at 250 kbit/s and no other.
#[test]
fn a_guest_has_a_bit_rate_of_its_own() {
    // 4 us in 14 quanta of 2/7 us: 12 ticks of PCLK1.
    const QUARTER: u32 = 2 << 20 | 9 << 16 | 11;
    let timing = BitTiming::new(Quantum::new(96, 1), 10, 3, 1);
    for (btr, reaches) in [(QUARTER, true), (MEGABIT, false)] {
        let pins = can_pins(&NOMINAL);
        let program =
            [start_both_controllers(&pins), join(CAN1, btr), receive(CAN1, RAM), SLEEP.to_vec()].concat();
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let board = spacecraft.add_board(board("ear", image(&program, &STOP)));
        let guest = spacecraft.add_guest_at(Bus::Nominal, 1.0, timing);
        spacecraft.inject(guest, Time::from_ms(4), frame());
        spacecraft.run_until(Time::from_ms(8)).unwrap();
        let sent = heard(&mut spacecraft, guest).contains(&GuestEvent::Sent(frame()));
        assert_eq!((sent, word(spacecraft.board(board), RAM) == WORD), (reaches, reaches), "BTR {btr:08X}h");
    }
}
