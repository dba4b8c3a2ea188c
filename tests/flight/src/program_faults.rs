//! Faults that end a program. The harness lets the executor poll other code in place of a task, which flipped bits in
//! RAM would do too.

use can_twin::wire::time::Time;

use crate::{Flight, ms};

/// Flash behind the program.
pub const CODE: u32 = 0x080B_0000;

/// `B .`
pub const HANG: [u16; 1] = [0xE7FE];
/// `CPSID i; B .`
pub const HANG_WITHOUT_INTERRUPTS: [u16; 2] = [0xB672, 0xE7FE];
/// `UDF #1`: `UDF #0` is the end of a panic.
pub const UNDEFINED: [u16; 1] = [0xDE01];
/// `PUSH {r0-r7}; B .-2`
pub const OVERFLOW: [u16; 2] = [0xB4FF, 0xE7FD];
/// `LDR r1, [r0]`
pub const LOAD: u16 = 0x6801;
/// `STR r1, [r0]`
pub const STORE: u16 = 0x6001;
/// `BX r0`
pub const JUMP: u16 = 0x4700;
/// Start of the code that runs in place of a task. It notes the task as the running one, as `supervised` does. `LDR r0,
/// [pc, #60]; LDR r1, [pc, #64]; STR r1, [r0]; NOP`, and at 40h both words.
const NOTED: [u16; 4] = [0x480F, 0x4910, 0x6001, 0xBF00];
/// Address of the code that runs in place of a task, behind `NOTED`.
pub const BODY: u32 = CODE + 8;
/// Words of `NOTED`.
const WORDS: u32 = CODE + 0x40;

/// Code that executes an instruction, [`LOAD`], [`STORE`] or [`JUMP`], with an address in r0: `LDR r0, [pc, #4]`, the
/// instruction, `B .`, `NOP`, the address.
pub fn accessing(instruction: u16, address: u32) -> Vec<u8> {
    [halfwords(&[0x4801, instruction, 0xE7FE, 0xBF00]), address.to_le_bytes().to_vec()].concat()
}

/// A word of the memory of a board.
///
/// # Panics
/// When there is no memory.
pub fn word_at(flight: &Flight, node: u8, address: u32) -> u32 {
    let bytes = flight.emulated(node).read_memory(address, 4).unwrap();
    u32::from_le_bytes(bytes.try_into().unwrap())
}

/// A supervised task.
#[derive(Clone, Copy)]
pub struct Task {
    /// Address of its storage.
    header: u32,
    /// First four characters of its name.
    pub name: u32,
}

/// Returns the tasks in the list of the supervisor. An entry has a name and a waker, and one word of the waker is the
/// address of the storage.
///
/// # Panics
/// When the image has no such list.
pub fn tasks(flight: &Flight, node: u8) -> Vec<Task> {
    let list = flight.emulated(node).symbol("ecss_can_stm32f4::supervisor::TASK_LIST").unwrap();
    let words: Vec<u32> = (0..list.size / 4).map(|n| word_at(flight, node, list.address + 4 * n)).collect();
    let is_ram = |word: &u32| word >> 24 == 0x20;
    let is_name =
        |word: &&u32| word.to_le_bytes().iter().all(|byte| byte.is_ascii_lowercase() || *byte == b' ');
    let places = words.iter().enumerate().filter(|(_, word)| is_name(word));
    let tasks = places.map(|(at, name)| {
        let header = words[at + 1..at + 3].iter().copied().find(is_ram).unwrap();
        Task { header, name: *name }
    });
    tasks.collect()
}

/// Returns the task whose name begins with these four characters.
///
/// # Panics
/// When there is none.
pub fn task_named(flight: &Flight, node: u8, name: &[u8; 4]) -> Task {
    tasks(flight, node).into_iter().find(|task| task.name.to_le_bytes() == *name).unwrap()
}

/// Returns the address of the word in the header of a task that holds its poll function. It is the only address of code
/// in the header.
///
/// # Panics
/// When there is none.
pub fn poll_function(flight: &Flight, node: u8, task: Task) -> u32 {
    let is_code = |at: &u32| {
        let word = word_at(flight, node, *at);
        word >> 24 == 0x08 && word & 1 == 1
    };
    (0..16).map(|n| task.header + 4 * n).find(is_code).unwrap()
}

/// Returns the code as bytes.
pub fn halfwords(code: &[u16]) -> Vec<u8> {
    code.iter().flat_map(|half| half.to_le_bytes()).collect()
}

/// Returns the number of resets of a board by its program or its watchdog.
pub fn resets(flight: &Flight, node: u8) -> u64 {
    let counters = flight.emulated(node).counters();
    counters.system_resets + counters.watchdog_resets
}

/// Lets `node` run `code` in place of a task until its board is reset. Returns the time of the reset.
///
/// # Panics
/// When it is not reset within 5 s.
pub fn end_program(flight: &mut Flight, node: u8, task: Task, code: &[u8]) -> Time {
    let before = resets(flight, node);
    let at = poll_function(flight, node, task);
    let board = flight.emulated_mut(node);
    // A minimal slave has no record, and notes no task: the word goes to the end of its RAM.
    let running = board
        .symbol("ecss_can_stm32f4::post_mortem::record::RUNNING")
        .map_or(0x2001_FFF0, |symbol| symbol.address);
    board.write_flash(CODE, &halfwords(&NOTED)).unwrap();
    board.write_flash(BODY, code).unwrap();
    board.write_flash(WORDS, &[running, task.name].map(u32::to_le_bytes).concat()).unwrap();
    board.write_memory(at, &(CODE | 1).to_le_bytes()).unwrap();
    let patience = flight.end + ms(5_000);
    while resets(flight, node) == before {
        flight.fly(flight.end + ms(5));
        assert!(flight.end < patience, "node {node} was not reset\n{}", flight.log(node));
    }
    flight.end
}
