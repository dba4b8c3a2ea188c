//! Flash and static RAM of the images of every board, profile `standard`, and the deepest stack of the demo.
//!
//! The names in the symbol table assign flash to parts of the software: see [`share`]. A part includes code that was
//! inlined into it, and lacks code that was inlined into other parts.

use std::fmt::Write as _;
use std::path::PathBuf;

use ecss_can_cli::fly::Options;
use ecss_can_cli::fly::flight::BoardCount;
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::fly::record::MASTER;
use ecss_can_cli::images::LOG;
use ecss_can_cli::images::support::board::Board;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::elf::{Facts, Memory, Symbol};

use crate::bench::context::{Context, FLOWN};
use crate::bench::row::Row;
use crate::bench::share::{self, PROTOCOL};

/// Budgets of the slaves: the whole image, its variables.
const SLAVE: [u64; 2] = [72 * 1024, 16 * 1024];
const MINIMAL: [u64; 2] = [20 * 1024, 4 * 1024];

/// Budget of the services of CANopen: slightly more than the flash that CANopenNode uses for them.
const CANOPEN: u64 = 26 << 10;

/// Longest name of a symbol in a table. Generic ones can be very long.
const NAME: usize = 100;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (board, role, path) in images(context)? {
        let facts = Facts::read(&path)?;
        let parts = parts(&facts);
        let protocol = parts.iter().filter(|(part, _)| PROTOCOL.contains(part)).map(|(_, bytes)| bytes).sum();
        let row =
            |what: &str, value: u64| Row::lower(format!("{}.{role}.{what}", board.name()), value, "bytes");
        let within = |row: Row, which: usize| match role {
            "slave" => row.within(SLAVE[which]),
            "minimal" => row.within(MINIMAL[which]),
            _ => row,
        };
        rows.push(within(row("flash", facts.size.flash), 0));
        rows.push(within(row("ram", facts.size.ram), 1));
        rows.push(row("protocol_flash", protocol));
        let row = |(part, bytes)| Row::lower(format!("{}.{role}.flash.{part}", board.name()), bytes, "bytes");
        rows.extend(parts.into_iter().map(row));
    }
    rows.push(canopen_only()?);
    rows.extend(stacks(context)?);
    Ok(rows)
}

/// Measures the flash of a slave with CiA 301 only and 4 + 4 PDOs: its image minus that of the same board without a
/// node.
fn canopen_only() -> anyhow::Result<Row> {
    let flash = |name: &str| -> anyhow::Result<u64> {
        let image = ecss_can_cli::images::build_fixture(name, "standard")?;
        Ok(Facts::read(&image)?.size.flash)
    };
    let bytes = flash("size-canopen")?.saturating_sub(flash("size-bus")?);
    Ok(Row::lower("canopen_only", bytes, "bytes").within(CANOPEN))
}

/// Returns the bytes of flash of each part with any. Their sum is the image.
fn parts(facts: &Facts) -> Vec<(&'static str, u64)> {
    let of = |part: &str| -> u64 {
        let symbols = facts.symbols.iter().filter(|symbol| symbol.memory == Memory::Flash);
        symbols.filter(|symbol| share::part(&symbol.name) == part).map(|symbol| symbol.bytes).sum()
    };
    let mut parts: Vec<_> = share::parts().map(|part| (part, of(part))).collect();
    let named: u64 = parts.iter().map(|(_, bytes)| bytes).sum();
    // Contents without a symbol: padding, texts, the initial values of variables.
    if let Some((_, others)) = parts.last_mut() {
        *others += facts.size.flash.saturating_sub(named);
    }
    parts.retain(|(_, bytes)| *bytes > 0);
    parts
}

/// Returns the deepest stacks of the master and of any slave in the demo, and of a minimal slave in
/// [`beside_a_minimal_slave`], from reset to the end of the flight.
fn stacks(context: &Context) -> anyhow::Result<[Row; 3]> {
    let (master, slaves): (Vec<_>, Vec<_>) =
        context.demo()?.boards.iter().partition(|board| board.node == MASTER);
    let plan = beside_a_minimal_slave()?;
    let minimal: Vec<_> =
        plan.boards.iter().filter(|board| board.is_minimal).map(|board| board.node).collect();
    let flight = context.fly(plan)?;
    let minimal: Vec<_> = flight.boards.iter().filter(|board| minimal.contains(&board.node)).collect();
    let deepest = |boards: &[&BoardCount]| boards.iter().map(|board| board.stack).max().unwrap_or(0);
    let row = |role: &str, boards: &[&BoardCount]| {
        Row::lower(format!("{}.{role}.stack", FLOWN.name()), u64::from(deepest(boards)), "bytes")
    };
    Ok([row("master", &master), row("slave", &slaves), row("minimal", &minimal)])
}

/// The flight of `cargo demo --minimal 1 --seconds 10`.
/// Boards whose images are counted: one with the stack in CCM and one with all of it in RAM. The code of other boards is the same.
const BOARDS: [&str; 2] = [Board::DEFAULT, "nucleo-f446re"];

fn beside_a_minimal_slave() -> anyhow::Result<Plan> {
    Ok(Plan::new(&Options { minimal: 1, seconds: 10.0, ..Options::default() })?)
}

/// Returns the `count` largest symbols of each image by flash and RAM together.
///
/// # Errors
/// When an image cannot be built or read.
pub fn biggest_symbols(context: &Context, count: usize) -> anyhow::Result<String> {
    let mut text = String::new();
    for (board, role, path) in images(context)? {
        writeln!(text, "\nbiggest symbols of {role}, {}:", board.name())?;
        for Symbol { name, memory, bytes } in Facts::read(&path)?.symbols.into_iter().take(count) {
            let cut: String = name.chars().take(NAME).collect();
            let more = if cut.len() < name.len() { "..." } else { "" };
            writeln!(text, "{bytes:>7} {:<6} {cut}{more}", memory.name())?;
        }
    }
    Ok(text)
}

fn images(context: &Context) -> anyhow::Result<Vec<(Board, &'static str, PathBuf)>> {
    let mut images = Vec::new();
    for board in BOARDS.map(Board::shipped) {
        let built = context.images(&board, Profile::Standard)?;
        let minimal = ecss_can_cli::images::build_minimal(board.name(), Profile::Standard.name(), LOG)?;
        images.extend([(board.clone(), "master", built.master), (board.clone(), "slave", built.slave)]);
        images.push((board, "minimal", minimal));
    }
    Ok(images)
}

#[cfg(test)]
mod tests {
    use ecss_can_cli::images::support::elf::Size;

    use super::*;

    #[test]
    fn parts_add_up_to_the_image() {
        let symbol = |memory, name: &str, bytes| Symbol { name: name.into(), memory, bytes };
        let facts = Facts {
            size: Size { flash: 100, ram: 7 },
            symbols: vec![
                symbol(Memory::Flash, "<async_canopen::nmt::slave::Nmt>::on_command", 30),
                symbol(Memory::Flash, "slave::application::log", 20),
                symbol(Memory::Flash, "__INTERRUPTS", 1),
                symbol(Memory::Ram, "async_canopen::nmt::STATE", 7),
            ],
            compiler: None,
        };
        assert_eq!(parts(&facts), [("nmt", 30), ("application", 20), ("others", 50)]);
    }
}
