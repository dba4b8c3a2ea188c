//! Runs the image of `judge/image` and compares its output with that of QEMU (`judge/README.md`).

use std::collections::BTreeMap;

use can_twin::cpu::{Config, Core, Stop, Width};

use crate::board::{FLASH, Memory, PERIPHERAL, Piece, RAM};

const IMAGE: &[u8] = include_bytes!("../qemu/image.bin");
/// Output of QEMU.
const ANSWERS: &str = include_str!("../qemu/answers.txt");
/// Holds the table of the differences that have a reason.
const README: &str = include_str!("../../judge/README.md");
const TABLE: &str = "## Where QEMU differs from the manual";

const SEMIHOSTING: u8 = 0xAB;
const SYS_WRITE0: u32 = 4;
const SYS_EXIT: u32 = 0x18;
/// Limit of steps, more than the image needs.
const MOST_STEPS: u32 = 2_000_000;

/// Runs the image to its SYS_EXIT and returns what it prints.
fn output() -> String {
    // Memories of an STM32F405, as far as the image uses them; TIM2 keeps what is written.
    let mut memory = Memory::writable([(RAM, vec![0; 0x3_0000]), (PERIPHERAL, vec![0; 0x400])]);
    memory.0.push(Piece { from: FLASH, content: IMAGE.to_vec(), is_writable: false });
    let mut core = Core::new(Config::stm32f4(0x1_0000));
    core.attach_debugger();
    let mut text = String::new();
    for _ in 0..MOST_STEPS {
        match core.step(&mut memory) {
            Ok(_) => assert!(!core.is_locked_up(), "the core is locked up after:\n{}", end_of(&text)),
            Err(Stop::Breakpoint { immediate: SEMIHOSTING, address }) => {
                let mut registers = core.registers();
                match registers.r[0] {
                    SYS_WRITE0 => text += &string_at(&mut memory, registers.r[1]),
                    SYS_EXIT => return text,
                    other => panic!("semihosting operation {other:02X}h"),
                }
                registers.r[15] = address + 2;
                core.set_registers(&registers);
            }
            Err(stop) => panic!("{stop:X?} after:\n{}", end_of(&text)),
        }
    }
    panic!("no end after:\n{}", end_of(&text));
}

fn string_at(memory: &mut Memory, address: u32) -> String {
    (address..)
        .map(|at| memory.peek(at, Width::Byte).expect("text in RAM") as u8)
        .take_while(|&byte| byte != 0)
        .map(char::from)
        .collect()
}

fn end_of(text: &str) -> &str {
    let from = text.len().saturating_sub(400);
    &text[from..]
}

/// Lines by case, number and name, with their values.
fn lines(text: &str) -> BTreeMap<&str, &str> {
    let lines: BTreeMap<_, _> = text.lines().filter_map(|line| line.rsplit_once(' ')).collect();
    assert_eq!(lines.len(), text.lines().count(), "each line has a name of its own");
    lines
}

/// The table of the README: line, QEMU's value, and the value by the manual.
fn explained() -> Vec<[&'static str; 3]> {
    let (_, section) = README.split_once(TABLE).expect("the section about QEMU");
    section
        .lines()
        .take_while(|line| !line.starts_with('#'))
        .filter_map(|row| row.strip_prefix("| `"))
        .map(|row| {
            let mut cells = row.split(" | ").map(|cell| cell.trim_matches('`'));
            std::array::from_fn(|_| cells.next().expect("four columns"))
        })
        .collect()
}

/// Given the image that QEMU ran. When this core runs it. Then each line has the value of QEMU, or the one that the table gives.
#[test]
fn image_prints_what_it_prints_in_qemu() {
    let text = output();
    let (ours, theirs) = (lines(&text), lines(ANSWERS));
    let explained = explained();
    let mut found = Vec::new();
    let mut differences = Vec::new();
    let names = ours.keys().chain(theirs.keys().filter(|name| !ours.contains_key(*name)));
    for name in names {
        let value = |lines: &BTreeMap<&str, &'_ str>| {
            lines.get(name).map_or("-".to_owned(), |&value| value.to_owned())
        };
        let (expected, actual) = (value(&theirs), value(&ours));
        if expected == actual {
            continue;
        }
        if explained.contains(&[name, expected.as_str(), actual.as_str()]) {
            found.push(*name);
        } else {
            differences.push(format!("{name}: QEMU {expected}, this core {actual}"));
        }
    }
    let compared = ours.len().max(theirs.len());
    println!(
        "{compared} lines compared, {} equal, {} different with a reason, {} without",
        compared - found.len() - differences.len(),
        found.len(),
        differences.len()
    );
    assert!(differences.is_empty(), "without a reason in judge/README.md:\n{}", differences.join("\n"));
    let unused: Vec<&str> =
        explained.iter().map(|[name, ..]| *name).filter(|name| !found.contains(name)).collect();
    assert!(unused.is_empty(), "judge/README.md lists lines that do not differ: {unused:?}");
}
