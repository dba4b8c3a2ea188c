//! Several boards with hand-assembled programs on two wires.

use std::sync::Arc;

use can_twin::board::{BoardConfig, State};
use can_twin::bxcan::Side;
use can_twin::crystal::Crystal;
use can_twin::image::Image;
use can_twin::spacecraft::{BoardId, Bus, Event, Spacecraft, SpacecraftConfig, WireRecord};
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

use super::programs::*;

const PING: u32 = 0x1122_3344;
const PONG: u32 = 0x5566_7788;

/// Sends on both buses, then waits for the answer on the nominal one.
fn asker() -> Arc<Image> {
    let program = [
        join_both_buses(),
        send(CAN1, 0x123, PING),
        send(CAN2, 0x124, PING),
        receive(CAN1, RAM),
        STOP.to_vec(),
    ]
    .concat();
    image(&program, &STOP)
}

/// Waits for a frame on each bus, then answers on the nominal one.
fn answerer() -> Arc<Image> {
    let program = [
        join_both_buses(),
        receive(CAN1, RAM),
        receive(CAN2, RAM + 4),
        send(CAN1, 0x0AB, PONG),
        STOP.to_vec(),
    ]
    .concat();
    image(&program, &STOP)
}

/// Sleeps; the interrupt of FIFO 0 copies the frame.
fn sleeper() -> Arc<Image> {
    let program =
        [join_both_buses(), store(NVIC_ISER0, 1 << 20), store(CAN1 + 0x14, 1 << 1), SLEEP.to_vec()].concat();
    let handler = [&copy(CAN1 + 0x1B8, RAM)[..], &store(CAN1 + 0x0C, 1 << 5), &RETURN].concat();
    image(&program, &handler)
}

/// Joins the buses and spins.
fn bystander() -> Arc<Image> {
    image(&[join_both_buses(), STOP.to_vec()].concat(), &STOP)
}

fn conversation(quantum: Time) -> (Vec<WireRecord>, Spacecraft) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig { quantum, ..SpacecraftConfig::default() });
    spacecraft.add_board(BoardConfig { crystal: Crystal::ppm(20.0), ..board("asker", asker()) });
    spacecraft.add_board(BoardConfig {
        crystal: Crystal::ppm(-20.0),
        position_m: 10.0,
        power_on_at: Time::from_us(150),
        ..board("answerer", answerer())
    });
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    (spacecraft.take_frames(), spacecraft)
}

#[test]
fn frames_travel_on_both_buses_and_back() {
    let frame = |id, word: u32| WireFrame::standard(id, &word.to_le_bytes());
    let expected = [
        (Bus::Nominal, frame(0x123, PING), 0),
        (Bus::Redundant, frame(0x124, PING), 0),
        (Bus::Nominal, frame(0x0AB, PONG), 1),
    ];
    for quantum_us in [1, 13, 20] {
        let (records, spacecraft) = conversation(Time::from_us(quantum_us));
        assert_eq!(completed(&records), expected, "quantum of {quantum_us} us");
        assert_eq!(words(spacecraft.board(BoardId(1)), RAM), [PING; 2]);
        assert_eq!(word(spacecraft.board(BoardId(0)), RAM), PONG);
    }
}

#[test]
fn the_record_does_not_depend_on_the_run() {
    let (reference, _) = conversation(Time::from_us(20));
    assert_eq!(conversation(Time::from_us(20)).0, reference);
}

#[test]
fn frames_last_their_stuffed_length_by_the_senders_crystal() {
    let (records, _) = conversation(Time::from_us(20));
    let Some(Observation::Completed { trace, .. }) = records
        .iter()
        .map(|record| &record.record)
        .find(|record| matches!(record, Observation::Completed { .. }))
    else {
        panic!("no frame")
    };
    assert_eq!(trace.frame.id, WireId::Standard(0x123));
    // 1 Mbit/s on a crystal that is 20 ppm fast: 335.99 ticks, which rounds to one microsecond.
    assert_eq!(trace.bit_time, Time::from_us(1));
    let bits = trace.end.since(trace.start).as_us();
    // 44 + 32 bits without stuffing, at most (34 + 32 - 1) / 4 stuff bits.
    assert!((76..=92).contains(&bits), "{bits} bits");
}

#[test]
fn a_frame_wakes_a_sleeping_core_through_its_interrupt() {
    let mut spacecraft = spacecraft([board("asker", asker()), board("sleeper", sleeper())]);
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    assert_eq!(word(spacecraft.board(BoardId(1)), RAM), PING);
}

#[test]
fn interrupt_follows_the_frame_by_its_entry_time_only() {
    // The handler first raises PB4, so the edge shows when it ran.
    let program = [
        join_both_buses(),
        store(GPIOB, 0x0A0A_0180),
        store(NVIC_ISER0, 1 << 20),
        store(CAN1 + 0x14, 1 << 1),
        SLEEP.to_vec(),
    ]
    .concat();
    let handler = [&store(GPIOB + 0x18, 1 << 4)[..], &store(CAN1 + 0x0C, 1 << 5), &RETURN].concat();
    let observer = board("observer", image(&program, &handler));
    let mut spacecraft = spacecraft([board("asker", asker()), observer]);
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    let raised = spacecraft.board_mut(BoardId(1)).take_pin_changes()[0].at;
    let records = spacecraft.take_frames();
    let valid = records
        .iter()
        .find_map(|record| match &record.record {
            Observation::Completed { receivers, .. } => receivers.first().map(|&(_, at)| at),
            _ => None,
        })
        .unwrap();
    // 12 cycles of entry, four moves and a store: under 0.2 us.
    assert!(raised > valid && raised.since(valid) < Time::from_ns(200), "{:?}", raised.since(valid));
}

#[test]
fn a_controller_off_its_pins_neither_hears_nor_acknowledges() {
    let deaf = [join_both_buses(), store(GPIOB, 0x0000_0280), STOP.to_vec()].concat();
    // The sender may start only after the other controller has left its pins.
    let late = BoardConfig { power_on_at: Time::from_ms(1), ..board("asker", asker()) };
    let mut spacecraft = spacecraft([late, board("deaf", image(&deaf, &STOP))]);
    spacecraft.run_until(Time::from_ms(8)).unwrap();
    assert_eq!(completed(&spacecraft.take_frames()), []);
    assert!(spacecraft.wire(Bus::Nominal).counters().ack_errors > 0);
    assert_eq!(spacecraft.board(BoardId(1)).can_stats(Side::Can1).stored, [0, 0]);
}

#[test]
fn a_cut_separates_the_boards_until_it_heals() {
    let listener = BoardConfig { position_m: 10.0, ..board("bystander", bystander()) };
    let mut spacecraft = spacecraft([board("asker", asker()), listener]);
    spacecraft.wire_mut(Bus::Nominal).cut(5.0);
    spacecraft.wire_mut(Bus::Nominal).schedule(Time::from_ms(6), Fault::Restore { position_m: 5.0 }).unwrap();
    spacecraft.run_until(Time::from_ms(6)).unwrap();
    assert_eq!(completed(&spacecraft.take_frames()), []);
    spacecraft.run_until(Time::from_ms(8)).unwrap();
    let frames: Vec<_> = completed(&spacecraft.take_frames()).iter().map(|&(bus, ..)| bus).collect();
    assert_eq!(frames, [Bus::Nominal, Bus::Redundant]);
}

#[test]
fn scheduled_events_reach_their_board_in_order() {
    let mut spacecraft = spacecraft([board("bystander", bystander())]);
    let id = BoardId(0);
    spacecraft.schedule(Time::from_ms(7), id, Event::Power(true));
    spacecraft.schedule(Time::from_ms(4), id, Event::Power(false));
    spacecraft.run_until(Time::from_ms(3)).unwrap();
    assert_eq!(spacecraft.board(id).hclk(), 168_000_000);
    spacecraft.run_until(Time::from_ms(5)).unwrap();
    assert_eq!(*spacecraft.board(id).state(), State::Off);
    spacecraft.run_until(Time::from_us(7100)).unwrap();
    assert_eq!(*spacecraft.board(id).state(), State::Running);
    assert_eq!(spacecraft.board(id).hclk(), 16_000_000, "it starts again on HSI");
}

#[test]
fn a_refused_access_stops_one_board_and_leaves_the_others() {
    let lost = board("lost", image(&store(0x4000_7400, 0), &STOP));
    let mut spacecraft = spacecraft([lost, board("bystander", bystander())]);
    let error = spacecraft.run_until(Time::from_ms(4)).unwrap_err();
    assert_eq!((error.board.as_str(), error.address), ("lost", 0x4000_7400));
    spacecraft.run_until(Time::from_ms(4)).unwrap();
    assert_eq!(spacecraft.board(BoardId(1)).hclk(), 168_000_000);
}

#[test]
fn sleeping_boards_cost_next_to_nothing() {
    let mut spacecraft = spacecraft([board("one", sleeper()), board("two", sleeper())]);
    spacecraft.run_until(Time::from_ms(10)).unwrap();
    let before: Vec<_> = spacecraft.boards().map(|(_, board)| board.counters().instructions).collect();
    spacecraft.run_until(Time::from_ms(3_600_000)).unwrap();
    let after: Vec<_> = spacecraft.boards().map(|(_, board)| board.counters().instructions).collect();
    assert_eq!(before, after, "an hour asleep");
}

/// RM0090 32.4.1: leaving initialisation takes 11 recessive bits, which a full bus has only between two frames.
#[test]
fn a_board_joins_a_bus_without_pauses() {
    // The mailbox is requested again as soon as it is empty; the intermission leaves time for that.
    let again = [store(CAN1 + 8, 1), store(CAN1 + 0x180, 0x456 << 21 | 1), wait_for(CAN1 + 8, 0)].concat();
    let back = 0_u16.wrapping_sub(again.len() as u16 + 2) & 0x07FF; // B to its beginning
    let loops = [&send(CAN1, 0x456, PING)[..], &again, &[0xE000 | back]].concat();
    let jammer = [join_both_buses(), loops].concat();
    let late = BoardConfig {
        crystal: Crystal::ppm(-100.0),
        power_on_at: Time::from_ms(3),
        ..board("late", asker())
    };
    let mut spacecraft =
        spacecraft([board("jammer", image(&jammer, &STOP)), board("bystander", bystander()), late]);
    spacecraft.run_until(Time::from_ms(10)).unwrap();
    let records = spacecraft.take_frames();
    let frames = completed(&records);
    let second_start = |pair: &[WireRecord]| pair[1].at.since(pair[0].at);
    let busiest = records.windows(2).map(second_start).min().unwrap();
    assert!(busiest < Time::from_us(95), "the bus is full: {busiest:?}");
    assert!(
        frames.iter().any(|&(bus, _, sender)| bus == Bus::Nominal && sender == 2),
        "the late board sends"
    );
}
