//! Programs that end: each leaves a record, its board is reset and reports it, and the others fly on.

use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::board::{Fittings, State};
use twin::peripherals::FlashSpeed;
use twin::spacecraft::Bus;

use flight::*;

const PANIC: u8 = 1;
const FAULT: u8 = 2;
const STACK_OVERFLOW: u8 = 3;
const LATE_TASK: u8 = 4;
const WATCHDOG: u8 = 5;
const BROWN_OUT: u8 = 6;
const OSCILLATOR: u8 = 7;

const RESET_SLAVE: u8 = 3;
/// All are operational by then.
const FLOWN_MS: u64 = 400;

/// After its reset a board is operational again, and its emergency is over.
const OPERATIONAL_AFTER: Time = Time::from_ms(400);

/// `LDR r0, [pc, #4]; LDR r1, [pc, #4]; BX r1; NOP`, then both words.
const CALL: [u16; 4] = [0x4801, 0x4902, 0x4708, 0xBF00];

/// Data frames of one identifier that `node` sent on either bus after `from`.
fn sent(flight: &Flight, node: u8, id: u16, from: Time) -> impl Iterator<Item = &Seen> {
    let sender = flight.board(node).0;
    flight.frames.iter().filter(move |seen| seen.sender == sender && seen.id() == Some(id) && seen.end > from)
}

/// Commands that the master has sent to `node`.
fn commanded(flight: &Flight, node: u8) -> usize {
    sent(flight, MASTER, 0x300 + u16::from(node), Time::ZERO).count()
}

/// Emergencies of the victim after `from`: code, register, information. Each once: a slave that is reset announces to the
/// master that it finds what it sent before.
fn emergencies(flight: &Flight, from: Time) -> Vec<Vec<u8>> {
    let mut told: Vec<Vec<u8>> = Vec::new();
    for seen in sent(flight, RESET_SLAVE, 0x080 + u16::from(RESET_SLAVE), from) {
        if !told.iter().any(|data| data == seen.data()) {
            told.push(seen.data().to_vec());
        }
    }
    told
}

fn is_operational(flight: &Flight, node: u8) -> bool {
    Bus::ALL.into_iter().any(|bus| flight.is_operational(node, bus))
}

/// Functions of the return addresses in the record of a board.
fn callers(flight: &Flight, node: u8) -> Vec<String> {
    let board = flight.twin.board(flight.board(node));
    let record = board.symbol("boards_stm32f4::post_mortem::record::POST_MORTEM").unwrap().address;
    // Behind checksum, cause and program counter.
    let addresses = (3..11).map(|n| word_at(flight, node, record + 4 * n));
    addresses.filter_map(|at| board.function_at(at & !1)).map(str::to_owned).collect()
}

/// The victim reports `cause` at `pc` once, after its boot-up message, and is operational again; slave 2 executed each command.
fn assert_reported(flight: &Flight, ended: Time, cause: u8, pc: u32) {
    let [a, b, c, d] = pc.to_le_bytes();
    let told = emergencies(flight, ended);
    let expected = [[0, 0x61, 1, cause, a, b, c, d], [0, 0, 0, 0, 0x61, cause, 0, 0]];
    assert_eq!(told, expected, "{}", flight.log(RESET_SLAVE));
    let first = flight.first_after(ended, |seen| seen.sender == flight.board(RESET_SLAVE).0).unwrap();
    assert_eq!(first.data(), [BOOT_UP], "before the emergency");
    assert!(is_operational(flight, RESET_SLAVE), "{}", flight.log(RESET_SLAVE));
    assert!(is_operational(flight, 2) && !flight.fell_back(2, ms(FLOWN_MS)));
    assert_eq!(flight.executed(2) as usize, commanded(flight, 2), "slave 2 executes each command");
}

fn flown() -> Flight {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(FLOWN_MS);
    flight
}

/// What node 3 answers to an expedited upload of object 2032h.
fn record(flight: &mut Flight, guest: twin::spacecraft::GuestId, sub: u8) -> u32 {
    flight.twin.inject(guest, flight.end, WireFrame::standard(0x603, &[0x40, 0x32, 0x20, sub, 0, 0, 0, 0]));
    let answer = flight.fly_until(|seen| seen.id() == Some(0x583));
    u32::from_le_bytes(answer.data()[4..8].try_into().unwrap())
}

/// Given a slave, when one of its tasks hangs in a loop, then the supervisor records task and program counter and resets the
/// board within 1.2 s. For each task.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn hung_task_is_recorded_and_reported() {
    let number = tasks(&flown(), RESET_SLAVE).len();
    // Both buses, what is due, pulses, the application.
    assert_eq!(number, 5);
    for nth in 0..number {
        let mut flight = flown();
        let hung = flight.end;
        let task = tasks(&flight, RESET_SLAVE)[nth];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&HANG));
        assert!(ended < hung + ms(1_400), "task {nth}: {} us", ended.since(hung).as_us());
        flight.fly(ended + OPERATIONAL_AFTER);
        assert_reported(&flight, ended, LATE_TASK, BODY);
        let name = task.name.to_le_bytes();
        let shown = format!("task b\"{}\"", name.escape_ascii());
        assert!(flight.said(RESET_SLAVE, &shown, ended).is_some(), "{shown}\n{}", flight.log(RESET_SLAVE));
    }
}

/// Given a slave, when one of its tasks hangs with interrupts off, then the watchdog resets the board, and the record names
/// the task. For each task.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn task_that_hangs_without_interrupts_is_reset_by_the_watchdog() {
    for nth in 0..5 {
        let mut flight = flown();
        let hung = flight.end;
        let task = tasks(&flight, RESET_SLAVE)[nth];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&HANG_WITHOUT_INTERRUPTS));
        assert_eq!(flight.twin.board(flight.board(RESET_SLAVE)).counters().watchdog_resets, 1);
        assert!(ended < hung + ms(4_500), "task {nth}: {} us", ended.since(hung).as_us());
        flight.fly(ended + OPERATIONAL_AFTER);
        assert_reported(&flight, ended, WATCHDOG, 0);
        let name = task.name.to_le_bytes();
        let shown = format!("task b\"{}\"", name.escape_ascii());
        assert!(flight.said(RESET_SLAVE, &shown, ended).is_some(), "{shown}\n{}", flight.log(RESET_SLAVE));
    }
}

/// Given a slave, when its program is at an instruction that is none, then the record has its address; it is in the dictionary.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn fault_is_recorded_and_reported() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    flight.fly_to(FLOWN_MS);
    let task = tasks(&flight, RESET_SLAVE)[2];
    let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&UNDEFINED));
    flight.fly(ended + OPERATIONAL_AFTER);
    assert_reported(&flight, ended, FAULT, BODY);
    let shown: Vec<u32> = (1..=4).map(|sub| record(&mut flight, guest, sub)).collect();
    assert_eq!(shown, [FAULT.into(), 1, BODY, task.name]);
    // 8 addresses of 4 bytes, 128 bytes of the log.
    assert_eq!(record(&mut flight, guest, 5), 160);
}

/// Given a slave, when its program panics, then the record has the end of the log, which says where.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn panic_is_recorded_and_reported() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    // A place in the source: text, its length, line, column. Behind the program.
    let (place, text) = (CODE + 0x100, CODE + 0x200);
    let location = [text, 9, 1234, 5].map(u32::to_le_bytes).concat();
    let board = flight.twin.board_mut(id);
    board.write_flash(text, b"flight.rs").unwrap();
    board.write_flash(place, &location).unwrap();
    let unwrap = board.symbol("core::option::unwrap_failed").unwrap().address | 1;
    let task = tasks(&flight, RESET_SLAVE)[2];
    let code = [halfwords(&CALL), place.to_le_bytes().to_vec(), unwrap.to_le_bytes().to_vec()].concat();
    let ended = end_program(&mut flight, RESET_SLAVE, task, &code);
    assert!(
        flight.said(RESET_SLAVE, "panicked at flight.rs:1234:5", ms(FLOWN_MS)).is_some(),
        "{}",
        flight.log(RESET_SLAVE)
    );
    flight.fly(ended + OPERATIONAL_AFTER);
    let told = emergencies(&flight, ended);
    let pc = u32::from_le_bytes(told[0][4..8].try_into().unwrap());
    assert_eq!(word_at(&flight, RESET_SLAVE, pc) as u16, 0xDE00, "the trap behind the message");
    // The first caller outside of `core`, `panic-probe` and the log: the code in place of the task is not in the image, so it
    // is the executor that polled it.
    let callers = callers(&flight, RESET_SLAVE);
    let is_of_panic =
        |name: &&String| ["core::", "panic_probe::", "defmt", "__rustc"].iter().any(|of| name.contains(of));
    let place = callers.iter().find(|name| !is_of_panic(name));
    assert!(place.is_some_and(|name| name.contains("embassy_executor")), "{callers:?}");
    assert_reported(&flight, ended, PANIC, pc);
}

/// Given a slave, when its stack grows below memory, then the fault is handled on another stack and recorded without address.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn stack_overflow_is_recorded_and_reported() {
    let mut flight = flown();
    let task = tasks(&flight, RESET_SLAVE)[2];
    let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&OVERFLOW));
    flight.fly(ended + OPERATIONAL_AFTER);
    assert_reported(&flight, ended, STACK_OVERFLOW, 0);
}

/// Given a slave, when its supply falls below the threshold for a moment, then it says so; nothing else of RAM is believed.
///
/// Verifies: ECSS 6.4a, 6.4a.2
#[test]
fn brown_out_is_reported() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    // Level 3, 2.7 V: BOR_LEV 0.
    flight.twin.board_mut(id).set_option_bytes(0x0FFF_AAE0);
    flight.twin.brown_out(id);
    flight.fly_to(FLOWN_MS + 400);
    let told = emergencies(&flight, ms(FLOWN_MS));
    assert_eq!(
        told,
        [[0, 0x32, 5, BROWN_OUT, 0, 0, 0, 0], [0, 0, 0, 0, 0x32, BROWN_OUT, 0, 0]],
        "{}",
        flight.log(RESET_SLAVE)
    );
    assert!(flight.is_operational(RESET_SLAVE, Bus::Nominal));
    assert!(
        flight.said(RESET_SLAVE, "last reset: cause 6, 1 in a row, at 00000000h", ms(FLOWN_MS)).is_some(),
        "{}",
        flight.log(RESET_SLAVE)
    );
}

/// A board as delivered has no brown-out reset: a supply that falls is a power-on.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn brown_out_as_delivered_is_a_power_on() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    flight.twin.brown_out(id);
    flight.fly_to(FLOWN_MS + 400);
    assert_eq!(emergencies(&flight, ms(FLOWN_MS)), [[0_u8; 8]; 0]);
    assert!(flight.is_operational(RESET_SLAVE, Bus::Nominal));
}

/// Power-on, the reset pin and a command are no ends that are reported.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn other_resets_are_not_reported() {
    let mut flight = flown();
    let guest_free = emergencies(&flight, ms(0));
    let id = flight.board(RESET_SLAVE);
    flight.twin.reset(id);
    flight.fly_to(FLOWN_MS + 400);
    assert_eq!((guest_free, emergencies(&flight, ms(0))), (vec![], vec![]));
    assert!(flight.is_operational(RESET_SLAVE, Bus::Nominal));
    assert!(flight.said(RESET_SLAVE, "last reset", ms(0)).is_none(), "{}", flight.log(RESET_SLAVE));
}

/// Given the master, when one of its tasks hangs, then it is reset and reports that once, after its boot-up message. Its slaves
/// stay operational and execute each command before and after.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.3a
#[test]
fn hung_master_is_reset_and_goes_on() {
    let mut flight = flown();
    let hung = flight.end;
    let is_of_bus = |task: &Task| task.name.to_le_bytes() == *b"bus ";
    let task = tasks(&flight, MASTER).into_iter().find(is_of_bus).unwrap();
    let ended = end_program(&mut flight, MASTER, task, &halfwords(&HANG));
    flight.fly(ended + ms(1_000));
    assert!(flight.said(MASTER, "last reset: cause 4", ended).is_some(), "{}", flight.log(MASTER));
    let first = flight.first_after(ended, |seen| seen.sender == flight.board(MASTER).0).unwrap();
    assert_eq!((first.id(), first.data()), (Some(0x701), &[BOOT_UP][..]), "before the emergency");
    let reported: Vec<Vec<u8>> =
        sent(&flight, MASTER, 0x081, ended).map(|seen| seen.data().to_vec()).collect();
    // The program counter is that of the hook in flash.
    let [a, b, c, d] = BODY.to_le_bytes();
    let expected = [[0, 0x61, 1, LATE_TASK, a, b, c, d], [0, 0, 0, 0, 0x61, LATE_TASK, 0, 0]];
    assert_eq!(reported, expected, "{}", flight.log(MASTER));
    for node in [2, 3] {
        assert!(flight.is_operational(node, Bus::Nominal), "{}", flight.log(node));
        assert_eq!(flight.executed(node) as usize, commanded(&flight, node));
    }
    let last = flight.sent(MASTER, Bus::Nominal, 0x302).last().unwrap().end;
    assert!(last > ended + ms(800) && ended < hung + ms(1_400), "it commands again");
}

/// Given a slave in flight, when its oscillator stops, then it is silent at once and stays off both buses; after it was mended
/// the board reports it.
///
/// Verifies: ECSS 6.4a.2
#[test]
fn oscillator_that_stops_silences_the_board() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    flight.twin.board_mut(id).fail_oscillator();
    let failed = flight.end;
    flight.fly(failed + ms(1_500));
    let since = |seen: &&Seen| seen.end > failed;
    assert!(
        flight
            .frames
            .iter()
            .filter(since)
            .all(|seen| seen.sender != id.0 && !seen.reached.contains(&RESET_SLAVE))
    );
    for bus in Bus::ALL {
        assert_eq!(flight.attempts(RESET_SLAVE, bus).filter(|at| *at > failed).count(), 0);
    }
    assert!(flight.said(RESET_SLAVE, "HSE does not start", failed).is_some(), "{}", flight.log(RESET_SLAVE));
    assert!(is_operational(&flight, 2) && !flight.fell_back(2, failed));
    assert_eq!(flight.executed(2) as usize, commanded(&flight, 2));

    flight.twin.board_mut(id).mend_oscillator();
    flight.twin.reset(id);
    let mended = flight.end;
    flight.fly(mended + OPERATIONAL_AFTER);
    let told = emergencies(&flight, mended);
    assert_eq!(
        (told.len(), &told[0][..4]),
        (2, &[0, 0x50, 1, OSCILLATOR][..]),
        "{}",
        flight.log(RESET_SLAVE)
    );
    assert!(is_operational(&flight, RESET_SLAVE), "{}", flight.log(RESET_SLAVE));
}

/// Given a slave that ends again and again, when that was five times in a row, then it is silent for 10 minutes before it tries
/// again; power-on ends that.
#[test]
fn five_resets_in_a_row_silence_the_board() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    for row in 1..=5 {
        let task = tasks(&flight, RESET_SLAVE)[2];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&UNDEFINED));
        flight.fly(ended + ms(100));
        let said = format!("{row} in a row");
        assert!(
            flight.said(RESET_SLAVE, &said, ended.since(ms(10))).is_some(),
            "{said}\n{}",
            flight.log(RESET_SLAVE)
        );
        let boots = flight.first_after(ended, |seen| seen.sender == id.0).is_some();
        assert_eq!(boots, row < 5, "{row}");
    }
    flight.fly(flight.end + ms(4_000));
    let silent = flight.end.since(ms(4_000));
    assert!(
        flight
            .first_after(silent, |seen| seen.sender == id.0 || seen.reached.contains(&RESET_SLAVE))
            .is_none()
    );
    // The others would fly the 10 minutes too: that takes long.
    let others = [MASTER, 2].map(|node| flight.board(node));
    others.into_iter().for_each(|other| flight.twin.power(other, false));
    flight.fly(silent + ms(598_000));
    others.into_iter().for_each(|other| flight.twin.power(other, true));
    flight.fly(flight.end + ms(1_000));
    assert!(flight.first_after(silent, |seen| seen.sender == id.0).is_none(), "still silent");
    flight.fly(flight.end + ms(2_500));
    assert!(is_operational(&flight, RESET_SLAVE), "{}", flight.log(RESET_SLAVE));

    flight.twin.power(id, false);
    flight.fly(flight.end + ms(100));
    flight.twin.power(id, true);
    flight.fly(flight.end + OPERATIONAL_AFTER);
    let powered = flight.end;
    let task = tasks(&flight, RESET_SLAVE)[2];
    end_program(&mut flight, RESET_SLAVE, task, &halfwords(&UNDEFINED));
    flight.fly(flight.end + ms(100));
    assert!(flight.said(RESET_SLAVE, "1 in a row", powered).is_some(), "{}", flight.log(RESET_SLAVE));
}

/// Given the quickest watchdog, LSI at 47 kHz, and the slowest flash, when a slave erases a sector of its store at its start, which
/// takes 2 s, then the watchdog does not bite.
#[test]
fn longest_erase_is_shorter_than_the_watchdog() {
    let quick = Fittings { lsi_hz: 47_000, flash_speed: FlashSpeed::Slowest, ..Fittings::default() };
    let fittings = |node| if node == RESET_SLAVE { quick } else { Fittings::default() };
    let mut flight = Flight::fitted(&MASTER_AND_THREE[..3], fittings);
    let id = flight.board(RESET_SLAVE);
    // The first word of the store: no page, and not erased.
    flight.twin.board_mut(id).write_flash(0x080C_0000, &[0; 4]).unwrap();
    flight.fly_to(1_900);
    assert!(flight.first_after(ms(0), |seen| seen.sender == id.0).is_none(), "it erases");
    flight.fly_to(3_000);
    let counters = flight.twin.board(id).counters();
    assert_eq!((counters.flash_erases, counters.watchdog_resets, counters.system_resets), (1, 0, 0));
    assert!(is_operational(&flight, RESET_SLAVE), "{}", flight.log(RESET_SLAVE));
}

/// Given a debugger on a slave, when its program meets a fault, then it stops there, silent on both buses, until it is reset. The
/// record is written all the same.
///
/// Verifies: ECSS 6.4a.2, 6.5.3a
#[test]
fn fault_with_a_debugger_stops_the_program() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    let at = poll_function(&flight, RESET_SLAVE, tasks(&flight, RESET_SLAVE)[2]);
    let board = flight.twin.board_mut(id);
    board.attach_debugger();
    board.write_flash(CODE, &halfwords(&UNDEFINED)).unwrap();
    board.write_memory(at, &(CODE | 1).to_le_bytes()).unwrap();
    let ended = flight.end + ms(200);
    flight.fly(ended + ms(3_000));
    let board = flight.twin.board(id);
    assert_eq!((board.state(), resets(&flight, RESET_SLAVE)), (&State::Halted, 0));
    assert!(
        flight
            .frames
            .iter()
            .filter(|seen| seen.end > ended)
            .all(|seen| seen.sender != id.0 && !seen.reached.contains(&RESET_SLAVE))
    );
    assert!(is_operational(&flight, 2) && !flight.fell_back(2, ms(FLOWN_MS)));
    flight.twin.reset(id);
    flight.fly(flight.end + OPERATIONAL_AFTER);
    assert_reported(&flight, ended, FAULT, CODE);
}
