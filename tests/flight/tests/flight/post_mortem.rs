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

const VICTIM: u8 = 3;
/// All are operational by then.
const FLOWN_MS: u64 = 400;

/// After its reset a board is operational again, and its emergency is over.
const OPERATIONAL_AFTER: Time = Time::from_ms(400);

/// `LDR r0, [pc, #4]; LDR r1, [pc, #4]; BX r1; NOP`, then both words.
const CALL: [u16; 4] = [0x4801, 0x4902, 0x4708, 0xBF00];

/// Data frames of one identifier that `node` sent on either bus after `from`.
fn sent(craft: &Craft, node: u8, id: u16, from: Time) -> impl Iterator<Item = &Seen> {
    let sender = craft.board(node).0;
    craft.frames.iter().filter(move |seen| seen.sender == sender && seen.id() == Some(id) && seen.end > from)
}

/// Commands that the master has sent to `node`.
fn commanded(craft: &Craft, node: u8) -> usize {
    sent(craft, MASTER, 0x300 + u16::from(node), Time::ZERO).count()
}

/// Emergencies of the victim after `from`: code, register, information.
fn emergencies(craft: &Craft, from: Time) -> Vec<Vec<u8>> {
    sent(craft, VICTIM, 0x080 + u16::from(VICTIM), from).map(|seen| seen.data().to_vec()).collect()
}

fn is_operational(craft: &Craft, node: u8) -> bool {
    Bus::ALL.into_iter().any(|bus| craft.is_operational(node, bus))
}

/// Functions of the return addresses in the record of a board.
fn callers(craft: &Craft, node: u8) -> Vec<String> {
    let board = craft.twin.board(craft.board(node));
    let record = board.symbol("boards_stm32f4::post_mortem::record::POST_MORTEM").unwrap().address;
    // Behind checksum, cause and program counter.
    let addresses = (3..11).map(|n| word_at(craft, node, record + 4 * n));
    addresses.filter_map(|at| board.function_at(at & !1)).map(str::to_owned).collect()
}

/// The victim reports `cause` at `pc` once, after its boot-up message, and is operational again; slave 2 executed each command.
fn assert_reported(craft: &Craft, felled: Time, cause: u8, pc: u32) {
    let [a, b, c, d] = pc.to_le_bytes();
    let told = emergencies(craft, felled);
    let expected = [[0, 0x61, 1, cause, a, b, c, d], [0, 0, 0, 0, 0x61, cause, 0, 0]];
    assert_eq!(told, expected, "{}", craft.log(VICTIM));
    let first = craft.first_after(felled, |seen| seen.sender == craft.board(VICTIM).0).unwrap();
    assert_eq!(first.data(), [BOOT_UP], "before the emergency");
    assert!(is_operational(craft, VICTIM), "{}", craft.log(VICTIM));
    assert!(is_operational(craft, 2) && !craft.fell_back(2, ms(FLOWN_MS)));
    assert_eq!(craft.executed(2) as usize, commanded(craft, 2), "slave 2 executes each command");
}

fn flown() -> Craft {
    let mut craft = Craft::new(&MASTER_AND_THREE[..3]);
    craft.fly_to(FLOWN_MS);
    craft
}

/// What node 3 answers to an expedited upload of object 2032h.
fn record(craft: &mut Craft, guest: twin::spacecraft::GuestId, sub: u8) -> u32 {
    craft.twin.inject(guest, craft.end, WireFrame::standard(0x603, &[0x40, 0x32, 0x20, sub, 0, 0, 0, 0]));
    let answer = craft.fly_until(|seen| seen.id() == Some(0x583));
    u32::from_le_bytes(answer.data()[4..8].try_into().unwrap())
}

/// Given a slave, when one of its tasks hangs in a loop, then the supervisor records task and program counter and resets the
/// board within 1.2 s. For each task.
#[test]
fn hung_task_is_recorded_and_reported() {
    let number = tasks(&flown(), VICTIM).len();
    // Both buses, what is due, pulses, the application.
    assert_eq!(number, 5);
    for nth in 0..number {
        let mut craft = flown();
        let hung = craft.end;
        let task = tasks(&craft, VICTIM)[nth];
        let felled = fell(&mut craft, VICTIM, task, &halfwords(&HANG));
        assert!(felled < hung + ms(1_400), "task {nth}: {} us", felled.since(hung).as_us());
        craft.fly(felled + OPERATIONAL_AFTER);
        assert_reported(&craft, felled, LATE_TASK, BODY);
        let name = task.name.to_le_bytes();
        let shown = format!("task b\"{}\"", name.escape_ascii());
        assert!(craft.said(VICTIM, &shown, felled).is_some(), "{shown}\n{}", craft.log(VICTIM));
    }
}

/// Given a slave, when one of its tasks hangs with interrupts off, then the watchdog resets the board, and the record names
/// the task. For each task.
#[test]
fn task_that_hangs_without_interrupts_is_reset_by_the_watchdog() {
    for nth in 0..5 {
        let mut craft = flown();
        let hung = craft.end;
        let task = tasks(&craft, VICTIM)[nth];
        let felled = fell(&mut craft, VICTIM, task, &halfwords(&HANG_WITHOUT_INTERRUPTS));
        assert_eq!(craft.twin.board(craft.board(VICTIM)).counters().watchdog_resets, 1);
        assert!(felled < hung + ms(4_500), "task {nth}: {} us", felled.since(hung).as_us());
        craft.fly(felled + OPERATIONAL_AFTER);
        assert_reported(&craft, felled, WATCHDOG, 0);
        let name = task.name.to_le_bytes();
        let shown = format!("task b\"{}\"", name.escape_ascii());
        assert!(craft.said(VICTIM, &shown, felled).is_some(), "{shown}\n{}", craft.log(VICTIM));
    }
}

/// Given a slave, when its program is at an instruction that is none, then the record has its address; it is in the dictionary.
#[test]
fn fault_is_recorded_and_reported() {
    let mut craft = Craft::new(&MASTER_AND_THREE[..3]);
    let guest = craft.twin.add_guest(Bus::Nominal, 30.0);
    craft.fly_to(FLOWN_MS);
    let task = tasks(&craft, VICTIM)[2];
    let felled = fell(&mut craft, VICTIM, task, &halfwords(&UNDEFINED));
    craft.fly(felled + OPERATIONAL_AFTER);
    assert_reported(&craft, felled, FAULT, BODY);
    let shown: Vec<u32> = (1..=4).map(|sub| record(&mut craft, guest, sub)).collect();
    assert_eq!(shown, [FAULT.into(), 1, BODY, task.name]);
    // 8 addresses of 4 bytes, 128 bytes of the log.
    assert_eq!(record(&mut craft, guest, 5), 160);
}

/// Given a slave, when its program panics, then the record has the end of the log, which says where.
#[test]
fn panic_is_recorded_and_reported() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    // A place in the source: text, its length, line, column. Behind the program.
    let (place, text) = (CODE + 0x100, CODE + 0x200);
    let location = [text, 9, 1234, 5].map(u32::to_le_bytes).concat();
    let board = craft.twin.board_mut(id);
    board.write_flash(text, b"flight.rs").unwrap();
    board.write_flash(place, &location).unwrap();
    let unwrap = board.symbol("core::option::unwrap_failed").unwrap().address | 1;
    let task = tasks(&craft, VICTIM)[2];
    let code = [halfwords(&CALL), place.to_le_bytes().to_vec(), unwrap.to_le_bytes().to_vec()].concat();
    let felled = fell(&mut craft, VICTIM, task, &code);
    assert!(
        craft.said(VICTIM, "panicked at flight.rs:1234:5", ms(FLOWN_MS)).is_some(),
        "{}",
        craft.log(VICTIM)
    );
    craft.fly(felled + OPERATIONAL_AFTER);
    let told = emergencies(&craft, felled);
    let pc = u32::from_le_bytes(told[0][4..8].try_into().unwrap());
    assert_eq!(word_at(&craft, VICTIM, pc) as u16, 0xDE00, "the trap behind the message");
    // The first caller outside of `core`, `panic-probe` and the log: the code in place of the task is not in the image, so it
    // is the executor that polled it.
    let callers = callers(&craft, VICTIM);
    let is_of_panic =
        |name: &&String| ["core::", "panic_probe::", "defmt", "__rustc"].iter().any(|of| name.contains(of));
    let place = callers.iter().find(|name| !is_of_panic(name));
    assert!(place.is_some_and(|name| name.contains("embassy_executor")), "{callers:?}");
    assert_reported(&craft, felled, PANIC, pc);
}

/// Given a slave, when its stack grows below memory, then the fault is handled on another stack and recorded without address.
#[test]
fn stack_overflow_is_recorded_and_reported() {
    let mut craft = flown();
    let task = tasks(&craft, VICTIM)[2];
    let felled = fell(&mut craft, VICTIM, task, &halfwords(&OVERFLOW));
    craft.fly(felled + OPERATIONAL_AFTER);
    assert_reported(&craft, felled, STACK_OVERFLOW, 0);
}

/// Given a slave, when its supply falls below the threshold for a moment, then it says so; nothing else of RAM is believed.
#[test]
fn brown_out_is_reported() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    // Level 3, 2.7 V: BOR_LEV 0.
    craft.twin.board_mut(id).set_option_bytes(0x0FFF_AAE0);
    craft.twin.brown_out(id);
    craft.fly_to(FLOWN_MS + 400);
    let told = emergencies(&craft, ms(FLOWN_MS));
    assert_eq!(
        told,
        [[0, 0x32, 5, BROWN_OUT, 0, 0, 0, 0], [0, 0, 0, 0, 0x32, BROWN_OUT, 0, 0]],
        "{}",
        craft.log(VICTIM)
    );
    assert!(craft.is_operational(VICTIM, Bus::Nominal));
    assert!(
        craft.said(VICTIM, "last reset: cause 6, 1 in a row, at 00000000h", ms(FLOWN_MS)).is_some(),
        "{}",
        craft.log(VICTIM)
    );
}

/// A board as delivered has no brown-out reset: a supply that falls is a power-on.
#[test]
fn brown_out_as_delivered_is_a_power_on() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    craft.twin.brown_out(id);
    craft.fly_to(FLOWN_MS + 400);
    assert_eq!(emergencies(&craft, ms(FLOWN_MS)), [[0_u8; 8]; 0]);
    assert!(craft.is_operational(VICTIM, Bus::Nominal));
}

/// Power-on, the reset pin and a command are no ends that are reported.
#[test]
fn other_resets_are_not_reported() {
    let mut craft = flown();
    let guest_free = emergencies(&craft, ms(0));
    let id = craft.board(VICTIM);
    craft.twin.reset(id);
    craft.fly_to(FLOWN_MS + 400);
    assert_eq!((guest_free, emergencies(&craft, ms(0))), (vec![], vec![]));
    assert!(craft.is_operational(VICTIM, Bus::Nominal));
    assert!(craft.said(VICTIM, "last reset", ms(0)).is_none(), "{}", craft.log(VICTIM));
}

/// Given the master, when one of its tasks hangs, then it is reset and reports that once, after its boot-up message. Its slaves
/// stay operational and execute each command before and after.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn hung_master_is_reset_and_goes_on() {
    let mut craft = flown();
    let hung = craft.end;
    let is_of_bus = |task: &Task| task.name.to_le_bytes() == *b"bus ";
    let task = tasks(&craft, MASTER).into_iter().find(is_of_bus).unwrap();
    let felled = fell(&mut craft, MASTER, task, &halfwords(&HANG));
    craft.fly(felled + ms(1_000));
    assert!(craft.said(MASTER, "last reset: cause 4", felled).is_some(), "{}", craft.log(MASTER));
    let first = craft.first_after(felled, |seen| seen.sender == craft.board(MASTER).0).unwrap();
    assert_eq!((first.id(), first.data()), (Some(0x701), &[BOOT_UP][..]), "before the emergency");
    let reported: Vec<Vec<u8>> =
        sent(&craft, MASTER, 0x081, felled).map(|seen| seen.data().to_vec()).collect();
    // The program counter is that of the hook in flash.
    let [a, b, c, d] = BODY.to_le_bytes();
    let expected = [[0, 0x61, 1, LATE_TASK, a, b, c, d], [0, 0, 0, 0, 0x61, LATE_TASK, 0, 0]];
    assert_eq!(reported, expected, "{}", craft.log(MASTER));
    for node in [2, 3] {
        assert!(craft.is_operational(node, Bus::Nominal), "{}", craft.log(node));
        assert_eq!(craft.executed(node) as usize, commanded(&craft, node));
    }
    let last = craft.sent(MASTER, Bus::Nominal, 0x302).last().unwrap().end;
    assert!(last > felled + ms(800) && felled < hung + ms(1_400), "it commands again");
}

/// Given a slave in flight, when its oscillator stops, then it is silent at once and stays off both buses; after it was mended
/// the board reports it.
#[test]
fn oscillator_that_stops_silences_the_board() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    craft.twin.board_mut(id).fail_oscillator();
    let failed = craft.end;
    craft.fly(failed + ms(1_500));
    let since = |seen: &&Seen| seen.end > failed;
    assert!(
        craft.frames.iter().filter(since).all(|seen| seen.sender != id.0 && !seen.reached.contains(&VICTIM))
    );
    for bus in Bus::ALL {
        assert_eq!(craft.attempts(VICTIM, bus).filter(|at| *at > failed).count(), 0);
    }
    assert!(craft.said(VICTIM, "HSE does not start", failed).is_some(), "{}", craft.log(VICTIM));
    assert!(is_operational(&craft, 2) && !craft.fell_back(2, failed));
    assert_eq!(craft.executed(2) as usize, commanded(&craft, 2));

    craft.twin.board_mut(id).mend_oscillator();
    craft.twin.reset(id);
    let mended = craft.end;
    craft.fly(mended + OPERATIONAL_AFTER);
    let told = emergencies(&craft, mended);
    assert_eq!((told.len(), &told[0][..4]), (2, &[0, 0x50, 1, OSCILLATOR][..]), "{}", craft.log(VICTIM));
    assert!(is_operational(&craft, VICTIM), "{}", craft.log(VICTIM));
}

/// Given a slave that ends again and again, when that was five times in a row, then it is silent for 10 minutes before it tries
/// again; power-on ends that.
#[test]
fn five_resets_in_a_row_silence_the_board() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    for row in 1..=5 {
        let task = tasks(&craft, VICTIM)[2];
        let felled = fell(&mut craft, VICTIM, task, &halfwords(&UNDEFINED));
        craft.fly(felled + ms(100));
        let said = format!("{row} in a row");
        assert!(craft.said(VICTIM, &said, felled.since(ms(10))).is_some(), "{said}\n{}", craft.log(VICTIM));
        let boots = craft.first_after(felled, |seen| seen.sender == id.0).is_some();
        assert_eq!(boots, row < 5, "{row}");
    }
    craft.fly(craft.end + ms(4_000));
    let silent = craft.end.since(ms(4_000));
    assert!(
        craft.first_after(silent, |seen| seen.sender == id.0 || seen.reached.contains(&VICTIM)).is_none()
    );
    // The others would fly the 10 minutes too: that takes long.
    let others = [MASTER, 2].map(|node| craft.board(node));
    others.into_iter().for_each(|other| craft.twin.power(other, false));
    craft.fly(silent + ms(598_000));
    others.into_iter().for_each(|other| craft.twin.power(other, true));
    craft.fly(craft.end + ms(1_000));
    assert!(craft.first_after(silent, |seen| seen.sender == id.0).is_none(), "still silent");
    craft.fly(craft.end + ms(2_500));
    assert!(is_operational(&craft, VICTIM), "{}", craft.log(VICTIM));

    craft.twin.power(id, false);
    craft.fly(craft.end + ms(100));
    craft.twin.power(id, true);
    craft.fly(craft.end + OPERATIONAL_AFTER);
    let powered = craft.end;
    let task = tasks(&craft, VICTIM)[2];
    fell(&mut craft, VICTIM, task, &halfwords(&UNDEFINED));
    craft.fly(craft.end + ms(100));
    assert!(craft.said(VICTIM, "1 in a row", powered).is_some(), "{}", craft.log(VICTIM));
}

/// Given the quickest watchdog, LSI at 47 kHz, and the slowest flash, when a slave erases a sector of its store at its start, which
/// takes 2 s, then the watchdog does not bite.
#[test]
fn longest_erase_is_shorter_than_the_watchdog() {
    let quick = Fittings { lsi_hz: 47_000, flash_speed: FlashSpeed::Slowest, ..Fittings::default() };
    let fittings = |node| if node == VICTIM { quick } else { Fittings::default() };
    let mut craft = Craft::fitted(&MASTER_AND_THREE[..3], fittings);
    let id = craft.board(VICTIM);
    // The first word of the store: no page, and not erased.
    craft.twin.board_mut(id).write_flash(0x080C_0000, &[0; 4]).unwrap();
    craft.fly_to(1_900);
    assert!(craft.first_after(ms(0), |seen| seen.sender == id.0).is_none(), "it erases");
    craft.fly_to(3_000);
    let counters = craft.twin.board(id).counters();
    assert_eq!((counters.flash_erases, counters.watchdog_resets, counters.system_resets), (1, 0, 0));
    assert!(is_operational(&craft, VICTIM), "{}", craft.log(VICTIM));
}

/// Given a debugger on a slave, when its program meets a fault, then it stops there, silent on both buses, until it is reset. The
/// record is written all the same.
#[test]
fn fault_with_a_debugger_stops_the_program() {
    let mut craft = flown();
    let id = craft.board(VICTIM);
    let at = poll_function(&craft, VICTIM, tasks(&craft, VICTIM)[2]);
    let board = craft.twin.board_mut(id);
    board.attach_debugger();
    board.write_flash(CODE, &halfwords(&UNDEFINED)).unwrap();
    board.write_memory(at, &(CODE | 1).to_le_bytes()).unwrap();
    let felled = craft.end + ms(200);
    craft.fly(felled + ms(3_000));
    let board = craft.twin.board(id);
    assert_eq!((board.state(), resets(&craft, VICTIM)), (&State::Halted, 0));
    assert!(
        craft
            .frames
            .iter()
            .filter(|seen| seen.end > felled)
            .all(|seen| seen.sender != id.0 && !seen.reached.contains(&VICTIM))
    );
    assert!(is_operational(&craft, 2) && !craft.fell_back(2, ms(FLOWN_MS)));
    craft.twin.reset(id);
    craft.fly(craft.end + OPERATIONAL_AFTER);
    assert_reported(&craft, felled, FAULT, CODE);
}
