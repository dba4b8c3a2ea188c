//! Instructions of the host for one instruction of the emulated core, as valgrind's callgrind counts them.
//!
//! The program is the example `speed` of `twin-core`: a loop of mixed instructions on a bus of two plain memories. The count is the
//! difference between two lengths of it.

use firmware_images::support::needs::VALGRIND;

use super::Area;
use crate::callgrind::{self, Build};
use crate::context::Context;
use crate::row::Row;

pub const AREA: Area = Area {
    name: "core",
    about: "instructions of the host per emulated one",
    needs: &[VALGRIND],
    steps: 1,
    measure,
};

/// Emulated instructions of the two runs.
const LENGTHS: [u64; 2] = [200_000, 1_200_000];

fn measure(_: &Context, _: u64) -> anyhow::Result<Vec<Row>> {
    let program = callgrind::build_example("twin-core", "speed", Build::Release)?;
    let count = |length: u64| callgrind::count(&program, &[&length.to_string()]);
    let [short, long] = LENGTHS;
    let spent = count(long)?.saturating_sub(count(short)?);
    Ok(vec![Row::lower("host_instructions", spent as f64 / (long - short) as f64, "instructions")])
}
