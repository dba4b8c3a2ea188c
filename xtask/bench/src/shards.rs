//! A run of the benchmarks on many machines: each measures a shard of the steps of all areas, and `merge` joins their rows.

use std::path::{Path, PathBuf};

use firmware_images::support::output::{line, note};
use firmware_images::support::project;
use firmware_images::support::shard::{self, Part, Run, Shard};
use serde::{Deserialize, Serialize};

use super::areas::Area;
use super::context::Context;
use super::row::Row;
use super::{COMMAND, Measured, Output, announce, compiler, judge, open, print, table, write};

/// What decides the rows, beside the commit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Parameters {
    /// Names of the areas, with commas.
    areas: String,
    /// Compiler of the images.
    compiler: String,
}

/// Rows of a step of an area, each with its name.
#[derive(Debug, Serialize, Deserialize)]
struct Step {
    area: String,
    rows: Vec<(String, Row)>,
}

/// Measures a shard of the steps of `areas`, prints its rows, and writes them to `out`.
///
/// # Errors
/// When there are fewer steps than shards, or something cannot be measured or written.
pub fn measure(context: &Context, areas: &[&Area], shard: Shard, out: Option<&Path>) -> anyhow::Result<()> {
    let steps: Vec<(&Area, u64)> =
        areas.iter().flat_map(|area| (0..area.steps).map(|step| (*area, step))).collect();
    let total = steps.len() as u64;
    shard.check(COMMAND, total, "steps of these areas")?;
    let default = || project::target("bench").join(shard.file("part"));
    let out = out.map_or_else(default, Path::to_owned);
    shard::prepare(COMMAND, &out)?;
    let names: Vec<&str> = areas.iter().map(|area| area.name).collect();
    let parameters = Parameters { areas: names.join(","), compiler: compiler(context)? };
    let run = Run { command: COMMAND.into(), commit: shard::commit(), shards: shard.count, parameters };

    let mut results = Vec::new();
    for index in shard.share(total) {
        let (area, step) = steps[index as usize];
        announce(area.name, &format!("step {} of {}", step + 1, area.steps));
        let rows = (area.measure)(context, step)?;
        table::lines(area.name, &rows).iter().try_for_each(line)?;
        let rows = rows.into_iter().map(|row| (row.name.clone(), row)).collect();
        results.push(Step { area: area.name.into(), rows });
    }
    Part { run, shard: shard.index, results }.write(&out)?;
    note(format_args!("rows of shard {shard} written to {}", project::shown(&out)));
    Ok(())
}

/// Joins the rows of all shards, then does with them what one run does.
///
/// # Errors
/// When the files are not all parts of one run, a file cannot be written, or, asked to check, a target does not hold.
pub fn merge(files: &[PathBuf], output: &Output) -> anyhow::Result<()> {
    let (run, parts): (Run<Parameters>, Vec<Vec<Step>>) = shard::merged(COMMAND, files)?;
    let summary = open(COMMAND, &output.out())?;
    let measured = Measured { areas: joined(parts.into_iter().flatten()), compiler: run.parameters.compiler };
    for (area, rows) in &measured.areas {
        print(area, rows, output)?;
    }
    write(summary, &measured, output)?;
    judge(&measured, output)
}

/// Rows by area, from steps in their order.
fn joined(steps: impl Iterator<Item = Step>) -> Vec<(String, Vec<Row>)> {
    let mut areas: Vec<(String, Vec<Row>)> = Vec::new();
    for Step { area, rows } in steps {
        let rows = rows.into_iter().map(|(name, row)| Row { name, ..row });
        match areas.last_mut() {
            Some((last, joined)) if *last == area => joined.extend(rows),
            _ => areas.push((area, rows.collect())),
        }
    }
    areas
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given an area whose steps are in two shards, when they are joined, then it has all rows, in their order.
    #[test]
    fn area_of_two_shards_has_all_rows_in_order() {
        let row = |name: &str| Row::lower(name, 1, "ns").within(2);
        let step = |area: &str, name: &str| {
            let text =
                serde_json::to_string(&Step { area: area.into(), rows: vec![(name.into(), row(name))] });
            serde_json::from_str::<Step>(&text.unwrap()).unwrap()
        };
        let steps = [step("time", "a"), step("time", "c"), step("time", "b"), step("bound", "a")];
        let expected =
            [("time".to_owned(), vec![row("a"), row("c"), row("b")]), ("bound".to_owned(), vec![row("a")])];
        assert_eq!(joined(steps.into_iter()), expected);
    }
}
