//! Flash and static RAM of the images of every board, profile `standard`.
//!
//! Protocol code is what belongs to `ecss_can` by its name in the symbol table, and the tasks of the image: the compiler
//! inlines the tasks of a bus and of a node into these one-line wrappers. The application's task is among them, so the
//! figure is an upper bound.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::ValueEnum;

use super::Area;
use crate::context::Context;
use crate::row::Row;
use support::board::Board;
use support::board::Profile;
use support::elf::{Facts, Memory, Symbol};

pub const AREA: Area = Area { name: "size", about: "flash and static RAM of the images", measure };

/// Budgets of the slave: the whole image, its variables, its protocol code.
const SLAVE_FLASH: u64 = 64 << 10;
const SLAVE_RAM: u64 = 16 << 10;
const SLAVE_PROTOCOL: u64 = 24 << 10;

/// Longest name of a symbol in a table; generic ones can be endless.
const NAME: usize = 100;

fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (board, role, path) in images(context)? {
        let facts = Facts::read(&path)?;
        let protocol: u64 =
            facts.symbols.iter().filter(|symbol| is_protocol(symbol)).map(|symbol| symbol.bytes).sum();
        let row = |what: &str, value: u64, budget: u64| {
            let row = Row::lower(format!("{}.{role}.{what}", board.name()), value, "bytes");
            if role == "slave" { row.within(budget) } else { row }
        };
        rows.push(row("flash", facts.size.flash, SLAVE_FLASH));
        rows.push(row("ram", facts.size.ram, SLAVE_RAM));
        rows.push(row("protocol_flash", protocol, SLAVE_PROTOCOL));
    }
    Ok(rows)
}

/// The `count` biggest symbols of each image, flash and RAM together.
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
    for &board in Board::value_variants() {
        let built = context.images(board, Profile::Standard)?;
        images.extend([(board, "master", built.master), (board, "slave", built.slave)]);
    }
    Ok(images)
}

fn is_protocol(symbol: &Symbol) -> bool {
    let of_task = symbol.name.contains("slave::tasks::") || symbol.name.contains("master::tasks::");
    symbol.memory == Memory::Flash && (symbol.name.contains("ecss_can::") || of_task)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn protocol_code_is_known_by_its_name() {
        let counts = |memory, name: &str| is_protocol(&Symbol { name: name.into(), memory, bytes: 1 });
        assert!(counts(Memory::Flash, "<ecss_can::node::slave::Slave>::run"));
        assert!(counts(Memory::Flash, "<Task<slave::tasks::__node_task::{closure#0}>>::poll"));
        assert!(!counts(Memory::Flash, "<boards::bxcan::events::EventQueue>::poll"));
        assert!(!counts(Memory::Ram, "ecss_can::somewhere::STATE"));
    }
}
