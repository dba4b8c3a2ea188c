//! The parameter store of the boards on emulated flash: power fails in each of its operations.
//!
//! The program is `parameter_store` of `firmware/checks`. At each start it reports the set that it finds, and saves the
//! next one. With PC0 at ground it saves a long set first.

use std::sync::OnceLock;

use can_twin::board::{Defect, EmulatedBoard, Remains, State};
use can_twin::model::FLASH_BASE;
use can_twin::pin::Pin;
use can_twin::wire::time::Time;
use flight::{NUCLEO_F446RE, PYBOARD_V11, STM32F4DISCOVERY, bare, parsed, words};

const BOARDS: [&str; 3] = [PYBOARD_V11, NUCLEO_F446RE, STM32F4DISCOVERY];
const STRAP: Pin = Pin::new('C', 0);
const SECTOR: u32 = 128 << 10;

fn board(name: &str) -> EmulatedBoard {
    let image = parsed(&ecss_can_cli::images::build_check(name, "parameter_store").unwrap());
    EmulatedBoard::new(bare(name, image), 0)
}

/// Returns the complete flash.
fn flash(board: &EmulatedBoard) -> Vec<u8> {
    board.read_memory(FLASH_BASE, board.config().model.part.flash_bytes() as usize).unwrap()
}

/// Returns another board with the same flash.
fn copy(board: &EmulatedBoard) -> EmulatedBoard {
    let mut copy = EmulatedBoard::new(board.config().clone(), 0);
    copy.write_flash(FLASH_BASE, &flash(board)).unwrap();
    copy
}

/// Report of the program about its last start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Report {
    state: u32,
    found: u32,
    saved: u32,
    damaged: u32,
    mixed: u32,
}

fn report(board: &EmulatedBoard) -> Report {
    let [state, found, saved, damaged, mixed] = words(board, "REPORT");
    Report { state, found, saved, damaged, mixed }
}

/// Runs until the program is done, or power fails.
fn run(board: &mut EmulatedBoard) {
    board.power(true);
    let end = board.now() + Time::from_ms(3000);
    while board.now() < end && *board.state() == State::Running && ![2, 3].contains(&report(board).state) {
        board.run_until(board.now() + Time::from_ms(1)).unwrap();
    }
    assert_eq!(board.counters().panics, 0, "{:?}", board.take_log());
}

/// Runs a start from power-on until it is done.
fn start(board: &mut EmulatedBoard) -> Report {
    board.power(false);
    run(board);
    let report = report(board);
    assert_eq!((board.state(), report.state, report.mixed), (&State::Running, 2, 0));
    report
}

/// Starts once for each operation of a start and each kind of partial result, with a loss of power at that operation.
/// `check` gets the report of the next start.
fn cut_at_each_operation(board: &EmulatedBoard, mixtures: u64, check: impl Fn(u64, Remains, Report)) -> u64 {
    let mut whole = copy(board);
    start(&mut whole);
    let operations = whole.counters().flash_programs + whole.counters().flash_erases;
    for operation in 1..=operations {
        let kinds = [Remains::Old, Remains::New].into_iter().chain((0..mixtures).map(Remains::Mixed));
        for remains in kinds {
            let mut cut = copy(board);
            cut.cut_power_at(operation, remains);
            run(&mut cut);
            assert_eq!(*cut.state(), State::Off, "operation {operation} took place");
            check(operation, remains, start(&mut cut));
        }
    }
    operations
}

/// Returns a board whose next start changes to another page that is not empty, and the number of its short set.
fn full_page() -> (EmulatedBoard, u32) {
    static FLASH: OnceLock<Vec<u8>> = OnceLock::new();
    const STARTS: u32 = 25;
    let mut full = board(PYBOARD_V11);
    let fill = || {
        let store = full.symbol("__store_start").unwrap().address;
        let mut board = board(PYBOARD_V11);
        board.write_flash(store + SECTOR, &[0x5A; SECTOR as usize]).unwrap();
        board.drive(STRAP, Some(false));
        // Three quarters of 128 KiB, in steps of 4012 + 52 bytes; the next start makes room.
        for number in 1..=STARTS {
            assert_eq!(start(&mut board).saved, 2 * number);
        }
        assert_eq!(board.counters().flash_erases, 0);
        flash(&board)
    };
    let content = FLASH.get_or_init(fill);
    full.write_flash(FLASH_BASE, content).unwrap();
    (full, 2 * STARTS)
}

#[test]
fn each_start_finds_what_the_last_one_saved() {
    for name in BOARDS {
        let mut board = board(name);
        let store = board.symbol("__store_start").unwrap().address;
        let end = FLASH_BASE + board.config().model.part.flash_bytes();
        assert_eq!(store, end - 2 * SECTOR, "the last two sectors");
        let before = flash(&board)[..(store - FLASH_BASE) as usize].to_vec();
        for number in 0..5 {
            let report = start(&mut board);
            assert_eq!((report.found, report.saved, report.damaged), (number, number + 1, 0));
        }
        assert_eq!(board.counters().flash_erases, 0);
        assert_eq!(flash(&board)[..before.len()], before, "the program is as it was");
    }
}

/// Given a board with a set and a worn bit in the word that the next save programs, when it saves, then the save fails,
/// although the data cache holds the intended word. The next start finds the previous set and saves after the worn
/// word.
#[test]
fn a_save_into_a_worn_word_fails_and_the_set_before_holds() {
    for name in BOARDS {
        let mut board = board(name);
        assert_eq!(start(&mut board).saved, 1);
        let store = board.symbol("__store_start").unwrap().address;
        // Behind magic, epoch and 13 words of the first set come the length of the second one, its number, and a word whose first byte
        // is 66. The number is in the same line, which the data cache holds since it was read back.
        let address = store + 4 * (2 + 13 + 2);
        board.power(false);
        board.inflict(Defect::WornFlash { address, bits: 1 });
        run(&mut board);
        let worn = report(&board);
        assert_eq!((worn.state, worn.found), (3, 1), "{name}");
        let next = start(&mut board);
        assert_eq!((next.found, next.saved, next.damaged), (1, 2, 0), "{name}");
        assert_eq!(start(&mut board).found, 2, "{name}");
    }
}

/// Given error flags in FLASH_SR that an earlier operation left there, when a board saves, then the save ends and its set is found.
#[test]
fn error_flags_of_an_earlier_operation_fail_no_save() {
    for name in BOARDS {
        let mut board = board(name);
        board.power(true);
        // PGSERR, PGPERR, PGAERR, WRPERR, OPERR.
        board.leave_flash_errors(0xF2);
        run(&mut board);
        assert_eq!((report(&board).state, report(&board).saved), (2, 1), "{name}");
        assert_eq!(start(&mut board).found, 1, "{name}");
    }
}

#[test]
fn a_save_cut_short_leaves_the_old_set_or_the_new() {
    let mut board = board(PYBOARD_V11);
    assert_eq!(start(&mut board).saved, 1);
    assert_eq!(start(&mut board).saved, 2);
    board.power(false);
    let operations = cut_at_each_operation(&board, 4, |operation, remains, report| {
        // Length, ten words, CRC, commit: before the last operation the old set is stored.
        let found = if operation == 13 && report.found == 3 { 3 } else { 2 };
        assert_eq!(report.found, found, "operation {operation}, {remains:?}");
        match remains {
            Remains::Old if operation == 13 => assert_eq!((report.found, report.damaged), (2, 0)),
            Remains::New if operation == 13 => assert_eq!((report.found, report.damaged), (3, 0)),
            _ => assert_eq!(report.damaged, 0, "operation {operation}, {remains:?}"),
        }
    });
    assert_eq!(operations, 13);
}

#[test]
fn a_change_of_pages_at_a_start_cut_short_keeps_the_set() {
    let (board, saved) = full_page();
    let operations = cut_at_each_operation(&board, 3, |operation, remains, report| {
        // Erasing, 13 operations to copy the set, magic, epoch; then the next set is saved.
        let done = operation == 1 + 13 + 2 + 13 && report.found == saved + 1;
        assert_eq!(report.found, saved + u32::from(done), "operation {operation}, {remains:?}");
    });
    assert_eq!(operations, 1 + 13 + 2 + 13);
}

/// Given a start that erases, then the chip stops for a second if it erases at x32, and for two seconds otherwise.
#[test]
fn a_start_that_erases_takes_a_second() {
    let (mut board, saved) = full_page();
    let before = board.now();
    assert_eq!(start(&mut board).found, saved);
    assert_eq!(board.counters().flash_erases, 1);
    let took = board.now().since(before);
    assert!(took > Time::from_ms(1000) && took < Time::from_ms(1200), "{took:?}");
}
