//! Programs that end: each leaves a record, its board is reset and reports the record, and the other boards continue.

use can_twin::board::{Fittings, State};
use can_twin::peripherals::FlashSpeed;
use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::time::Time;
use flight::*;

const PANIC: u8 = 1;
const FAULT: u8 = 2;
const STACK_OVERFLOW: u8 = 3;
const LATE_TASK: u8 = 4;
const WATCHDOG: u8 = 5;
const BROWN_OUT: u8 = 6;
const OSCILLATOR: u8 = 7;

const RESET_SLAVE: u8 = 3;
/// Time at which all boards are operational.
const FLOWN_MS: u64 = 400;

/// Time after a reset in which a board is operational again and its emergency has ended.
const OPERATIONAL_AFTER: Time = Time::from_ms(400);

/// `LDR r0, [pc, #4]; LDR r1, [pc, #4]; BX r1; NOP`, then both words.
const CALL: [u16; 4] = [0x4801, 0x4902, 0x4708, 0xBF00];

/// Asserts that the slave has executed each command of the master.
fn assert_commanded(flight: &Flight, node: u8) {
    let commands = flight.with_id(0x300 + u16::from(node)).filter(|seen| seen.sender == 0);
    assert_eq!(flight.executed(node) as usize, commands.count(), "slave {node} executes each command");
}

/// Returns the emergencies of the victim after `from`, each once: code, register, information. After a reset a slave
/// repeats them when it finds its master.
fn emergencies(flight: &Flight, from: Time) -> Vec<&[u8]> {
    let mut reported = Vec::new();
    for data in flight.emergencies(RESET_SLAVE, from) {
        if !reported.contains(&data) {
            reported.push(data);
        }
    }
    reported
}

/// Returns the data of the emergency that reports the end of a program, and of the message that ends the emergency.
fn emergency(cause: u8, pc: u32) -> [[u8; 8]; 2] {
    let [a, b, c, d] = pc.to_le_bytes();
    [[0, 0x61, 1, cause, a, b, c, d], [0, 0, 0, 0, 0x61, cause, 0, 0]]
}

fn assert_victim_runs(flight: &Flight) {
    let is_up = Bus::ALL.into_iter().any(|bus| flight.is_operational(RESET_SLAVE, bus));
    assert!(is_up, "{}", flight.log(RESET_SLAVE));
}

/// Asserts that slave 2 was operational at all times since `from`, and executed each command.
fn assert_other_flew_on(flight: &Flight, from: Time) {
    assert!(Bus::ALL.into_iter().any(|bus| flight.is_operational(2, bus)), "{}", flight.log(2));
    flight.assert_kept_running([2], from);
    assert_commanded(flight, 2);
}

/// Returns the functions of the return addresses in the record of a board.
fn callers(flight: &Flight, node: u8) -> Vec<String> {
    let board = flight.emulated(node);
    let record = board.symbol("ecss_can_stm32f4::post_mortem::record::POST_MORTEM").unwrap().address;
    // After checksum, cause and program counter.
    let addresses = (3..11).map(|n| word_at(flight, node, record + 4 * n));
    addresses.filter_map(|at| board.function_at(at & !1)).map(str::to_owned).collect()
}

/// Asserts that the victim reports `cause` at `pc` once, after its boot-up message, and is operational again, and that
/// slave 2 executed each command.
fn assert_reported(flight: &Flight, ended: Time, cause: u8, pc: u32) {
    assert_eq!(emergencies(flight, ended), emergency(cause, pc), "{}", flight.log(RESET_SLAVE));
    let first = flight.of(RESET_SLAVE).find(|seen| seen.end > ended).unwrap();
    assert_eq!(first.data(), [BOOT_UP], "before the emergency");
    assert_victim_runs(flight);
    assert_other_flew_on(flight, ms(FLOWN_MS));
}

fn flown() -> Flight {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(FLOWN_MS);
    flight
}

/// Returns the answer of node 3 to an expedited upload of object 2032h.
fn record(flight: &mut Flight, guest: GuestId, sub: u8) -> u32 {
    let answer = flight.ask(guest, RESET_SLAVE, [0x40, 0x32, 0x20, sub, 0, 0, 0, 0]);
    u32::from_le_bytes(answer[4..].try_into().unwrap())
}

/// Given a slave, when one of its tasks hangs in a loop, then the supervisor records task and program counter and resets the
/// board within 1.2 s. When it hangs with interrupts off, the watchdog does, and the record names the task. For each task.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn hung_task_is_recorded_and_reported() {
    let number = tasks(&flown(), RESET_SLAVE).len();
    // Tasks of both buses, of deadlines, of pulses and of the application.
    assert_eq!(number, 5);
    let cases = [(&HANG[..], LATE_TASK, BODY, 1_400, 0), (&HANG_WITHOUT_INTERRUPTS, WATCHDOG, 0, 1_000, 1)];
    for (nth, (code, cause, pc, within_ms, bites)) in
        (0..number).flat_map(|nth| cases.map(|case| (nth, case)))
    {
        println!("task {nth}, {code:04X?}");
        let mut flight = flown();
        let hung = flight.end;
        let task = tasks(&flight, RESET_SLAVE)[nth];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(code));
        assert_eq!(flight.emulated(RESET_SLAVE).counters().watchdog_resets, bites);
        assert!(ended < hung + ms(within_ms), "{} us", ended.since(hung).as_us());
        flight.fly(ended + OPERATIONAL_AFTER);
        assert_reported(&flight, ended, cause, pc);
        let name = task.name.to_le_bytes();
        flight.assert_said(RESET_SLAVE, &format!("task b\"{}\"", name.escape_ascii()), ended);
    }
}

/// Given a slave whose count of uptime became negative by a flipped bit, when a task hangs, then the supervisor resets the board
/// as before.
#[test]
fn hung_task_is_reset_after_an_upset_of_the_uptime() {
    let mut flight = flown();
    let board = flight.emulated_mut(RESET_SLAVE);
    // The compiler keeps the only field of the static.
    let uptime = board.symbol("ecss_can_stm32f4::supervisor::UPTIME.0").unwrap().address;
    board.flip_memory(uptime + 3, 7).unwrap();
    let task = tasks(&flight, RESET_SLAVE)[2];
    let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&HANG));
    flight.fly(ended + OPERATIONAL_AFTER);
    assert_reported(&flight, ended, LATE_TASK, BODY);
}

/// Given a slave, when its program reaches an undefined instruction, then the record has its address, and is in the
/// dictionary.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn fault_is_recorded_and_reported() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
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

/// Given a slave, when its program panics, then the record has the end of the log with the place of the panic.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn panic_is_recorded_and_reported() {
    let mut flight = flown();
    // A place in the source: text, its length, line, column. Behind the program.
    let (place, text) = (CODE + 0x100, CODE + 0x200);
    let location = [text, 9, 1234, 5].map(u32::to_le_bytes).concat();
    let board = flight.emulated_mut(RESET_SLAVE);
    board.write_flash(text, b"flight.rs").unwrap();
    board.write_flash(place, &location).unwrap();
    let unwrap = board.symbol("core::option::unwrap_failed").unwrap().address | 1;
    let task = tasks(&flight, RESET_SLAVE)[2];
    let code = [halfwords(&CALL), place.to_le_bytes().to_vec(), unwrap.to_le_bytes().to_vec()].concat();
    let ended = end_program(&mut flight, RESET_SLAVE, task, &code);
    flight.assert_said(RESET_SLAVE, "panicked at flight.rs:1234:5", ms(FLOWN_MS));
    flight.fly(ended + OPERATIONAL_AFTER);
    let pc = u32::from_le_bytes(emergencies(&flight, ended)[0][4..].try_into().unwrap());
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

/// Given a slave, when its program reads by a null pointer or beyond the SRAM, writes to the program or to external
/// memory, or jumps into RAM, then that is a fault, recorded with the address of the instruction.
///
/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.3a
#[test]
fn wild_pointer_is_a_fault() {
    const SRAM: u32 = 0x2000_0000;
    for (instruction, address, pc) in [
        (LOAD, 0, BODY + 2),
        (LOAD, SRAM + (128 << 10), BODY + 2),
        (STORE, 0x0800_4000, BODY + 2),
        (STORE, 0x6000_0000, BODY + 2),
        (JUMP, SRAM + 0x1001, SRAM + 0x1000),
    ] {
        println!("{instruction:04X} {address:08X}");
        let mut flight = flown();
        let task = tasks(&flight, RESET_SLAVE)[2];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &accessing(instruction, address));
        flight.fly(ended + OPERATIONAL_AFTER);
        assert_reported(&flight, ended, FAULT, pc);
    }
}

/// Given a slave, when its supply falls below the threshold for a moment, then it reports that, and uses nothing else
/// from RAM.
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
    let expected = [[0, 0x32, 5, BROWN_OUT, 0, 0, 0, 0], [0, 0, 0, 0, 0x32, BROWN_OUT, 0, 0]];
    assert_eq!(emergencies(&flight, ms(FLOWN_MS)), expected, "{}", flight.log(RESET_SLAVE));
    flight.assert_operational([RESET_SLAVE], Bus::Nominal);
    flight.assert_said(RESET_SLAVE, "last reset: cause 6, 1 in a row, at 00000000h", ms(FLOWN_MS));
}

/// Given a power-on or a reset by the pin, then no end of a program is reported. A new board has no brown-out reset, so
/// a drop of its supply is a power-on.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn other_resets_are_not_reported() {
    for falls in [true, false] {
        let mut flight = flown();
        let id = flight.board(RESET_SLAVE);
        if falls {
            flight.twin.brown_out(id);
        } else {
            flight.twin.reset(id);
        }
        flight.fly_to(FLOWN_MS + 400);
        assert_eq!(emergencies(&flight, ms(0)), [[0_u8; 8]; 0], "the supply falls: {falls}");
        flight.assert_operational([RESET_SLAVE], Bus::Nominal);
        assert_eq!(flight.said(RESET_SLAVE, "last reset", ms(0)), None, "{}", flight.log(RESET_SLAVE));
    }
}

/// Given the master, when one of its tasks hangs, then it is reset and reports that once, after its boot-up message. Its slaves
/// stay operational and execute each command before and after.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.3a
#[test]
fn hung_master_is_reset_and_goes_on() {
    let mut flight = flown();
    let hung = flight.end;
    let task = task_named(&flight, MASTER, b"bus ");
    let ended = end_program(&mut flight, MASTER, task, &halfwords(&HANG));
    flight.fly(ended + ms(1_000));
    flight.assert_said(MASTER, "last reset: cause 4", ended);
    let first = flight.of(MASTER).find(|seen| seen.end > ended).unwrap();
    assert_eq!((first.id(), first.data()), (Some(0x701), &[BOOT_UP][..]), "before the emergency");
    // The program counter is that of the hook in flash.
    let reported: Vec<&[u8]> = flight.emergencies(MASTER, ended).collect();
    assert_eq!(reported, emergency(LATE_TASK, BODY), "{}", flight.log(MASTER));
    flight.assert_operational([2, 3], Bus::Nominal);
    [2, 3].into_iter().for_each(|node| assert_commanded(&flight, node));
    let last = flight.sent(MASTER, Bus::Nominal, 0x302).last().unwrap().end;
    assert!(last > ended + ms(800) && ended < hung + ms(1_400), "it commands again");
}

/// Given a slave in flight, when its oscillator stops, then it is silent at once and stays off both buses. After the
/// repair the board reports the fault.
///
/// Verifies: ECSS 6.4a.2
#[test]
fn oscillator_that_stops_silences_the_board() {
    let mut flight = flown();
    flight.emulated_mut(RESET_SLAVE).fail_oscillator();
    let failed = flight.end;
    flight.fly(failed + ms(1_500));
    flight.assert_absent(RESET_SLAVE, failed);
    flight.assert_said(RESET_SLAVE, "HSE does not start", failed);
    assert_other_flew_on(&flight, failed);

    flight.emulated_mut(RESET_SLAVE).mend_oscillator();
    flight.reset(RESET_SLAVE);
    let mended = flight.end;
    flight.fly(mended + OPERATIONAL_AFTER);
    let reported = emergencies(&flight, mended);
    assert_eq!(reported.len(), 2, "{reported:?}\n{}", flight.log(RESET_SLAVE));
    assert_eq!(reported[0][..4], [0, 0x50, 1, OSCILLATOR]);
    assert_victim_runs(&flight);
}

/// Given a slave whose program keeps ending, when it has ended five times in a row, then it is silent for 10 minutes
/// before it starts again. A power-on ends the silence.
#[test]
fn five_resets_in_a_row_silence_the_board() {
    let mut flight = flown();
    let id = flight.board(RESET_SLAVE);
    for row in 1..=5 {
        let task = tasks(&flight, RESET_SLAVE)[2];
        let ended = end_program(&mut flight, RESET_SLAVE, task, &halfwords(&UNDEFINED));
        flight.fly(ended + ms(100));
        flight.assert_said(RESET_SLAVE, &format!("{row} in a row"), ended.since(ms(10)));
        let boots = flight.first_after(ended, |seen| seen.sender == id.0).is_some();
        assert_eq!(boots, row < 5, "{row}");
    }
    flight.fly(flight.end + ms(4_000));
    let silent = flight.end.since(ms(4_000));
    flight.assert_absent(RESET_SLAVE, silent);
    // The other boards are switched off, because a simulation of their 10 minutes takes long.
    let others = [MASTER, 2].map(|node| flight.board(node));
    others.into_iter().for_each(|other| flight.twin.power(other, false));
    flight.fly(silent + ms(598_000));
    others.into_iter().for_each(|other| flight.twin.power(other, true));
    flight.fly(flight.end + ms(1_000));
    assert!(flight.first_after(silent, |seen| seen.sender == id.0).is_none(), "still silent");
    flight.fly(flight.end + ms(2_500));
    assert_victim_runs(&flight);

    flight.twin.power(id, false);
    flight.fly(flight.end + ms(100));
    flight.twin.power(id, true);
    flight.fly(flight.end + OPERATIONAL_AFTER);
    let powered = flight.end;
    let task = tasks(&flight, RESET_SLAVE)[2];
    end_program(&mut flight, RESET_SLAVE, task, &halfwords(&UNDEFINED));
    flight.fly(flight.end + ms(100));
    flight.assert_said(RESET_SLAVE, "1 in a row", powered);
}

/// Given the quickest watchdog, LSI at 47 kHz, and the slowest flash, when a slave erases a sector of its store at its
/// start, which takes 2 s, then the watchdog causes no reset.
#[test]
fn longest_erase_is_shorter_than_the_watchdog() {
    let quick = Fittings { lsi_hz: 47_000, flash_speed: FlashSpeed::Slowest, ..Fittings::default() };
    let fittings = |node| if node == RESET_SLAVE { quick } else { Fittings::default() };
    let mut flight = Flight::fitted(&MASTER_AND_THREE[..3], fittings);
    // The first word of the store is neither that of a page nor erased.
    flight.emulated_mut(RESET_SLAVE).write_flash(0x080C_0000, &[0; 4]).unwrap();
    flight.fly_to(1_900);
    assert_eq!(flight.of(RESET_SLAVE).next(), None, "it erases");
    flight.fly_to(3_000);
    let counters = flight.emulated(RESET_SLAVE).counters();
    assert_eq!((counters.flash_erases, counters.watchdog_resets, counters.system_resets), (1, 0, 0));
    assert_victim_runs(&flight);
}

/// Given a debugger on a slave, when its program meets a fault, then it stops there, silent on both buses, until it is
/// reset. The record is still written.
///
/// Verifies: ECSS 6.4a.2, 6.5.3a
#[test]
fn fault_with_a_debugger_stops_the_program() {
    let mut flight = flown();
    let at = poll_function(&flight, RESET_SLAVE, tasks(&flight, RESET_SLAVE)[2]);
    let board = flight.emulated_mut(RESET_SLAVE);
    board.attach_debugger();
    board.write_flash(CODE, &halfwords(&UNDEFINED)).unwrap();
    board.write_memory(at, &(CODE | 1).to_le_bytes()).unwrap();
    let ended = flight.end + ms(200);
    flight.fly(ended + ms(3_000));
    assert_eq!((flight.emulated(RESET_SLAVE).state(), resets(&flight, RESET_SLAVE)), (&State::Halted, 0));
    flight.assert_absent(RESET_SLAVE, ended);
    assert_other_flew_on(&flight, ms(FLOWN_MS));
    flight.reset(RESET_SLAVE);
    flight.fly(flight.end + OPERATIONAL_AFTER);
    assert_reported(&flight, ended, FAULT, CODE);
}
