//! The table at the end of a flight, for the terminal.

use super::flight::Flight;
use super::narrator::name;
use super::summary::Summary;

/// All boards in a table, the totals below.
pub fn text(flight: &Flight, summary: &Summary) -> String {
    let head = ["board", "access", "at the end", "fail-over", "TC due", "executed", "lost", "aborted"]
        .map(String::from);
    let rows = flight.boards.iter().map(|board| {
        let track = &flight.observer.nodes()[&board.node];
        let now = track.now();
        let of_slave = |text: String| track.access.map_or(String::new(), |_| text);
        [
            name(board.node),
            track.access.map_or("", |access| access.name()).into(),
            format!("{}, {} bus", now.phase.name(), now.bus.name()),
            track.failover.map_or(of_slave("-".into()), |took| format!("{:.1} ms", took.as_secs_f64() * 1e3)),
            of_slave(track.tc_due.to_string()),
            of_slave(board.telltale.commands.to_string()),
            board.lost_frames.to_string(),
            board.aborted_frames.to_string(),
        ]
    });
    let table = aligned(&std::iter::once(head).chain(rows).collect::<Vec<_>>(), 3);
    let frames: u64 = summary.frames.values().sum();
    format!(
        "{table}\n\
         {} of {} slaves operational; TC: {} on the wire, {} due, {} executed, {} repeats dropped;\n\
         TM: {} requested, {} received\n\
         {frames} frames completed, {} lost, {} aborted; {} lock-ups, {} panics\n\
         stamps of SYNC: {}\n\
         {} s of virtual time in {} s on this computer ({} million emulated instructions per second; cycle counts \
         are model cycles,\nflash wait states included)\n",
        summary.slaves_operational_at_end,
        summary.boards - 1,
        summary.tc_sent,
        summary.tc_due,
        summary.tc_executed,
        summary.tc_repeats,
        summary.tm_requested,
        summary.tm_received,
        summary.lost_frames,
        summary.aborted_frames,
        summary.lockups,
        summary.panics,
        stamps(flight, summary),
        summary.virtual_seconds,
        summary.wall_seconds,
        summary.emulated_mips,
    )
}

fn stamps(flight: &Flight, summary: &Summary) -> String {
    let compared = flight.stamp_errors.compared;
    match summary.stamp_worst_error_ns {
        Some(worst) => {
            format!("{}; {compared} compared with the truth, at most {worst} ns off", summary.stamp_source)
        }
        None => summary.stamp_source.into(),
    }
}

/// Columns of equal width, the first `left` aligned to the left, the others (numbers) to the right.
fn aligned<const N: usize>(rows: &[[String; N]], left: usize) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(widths)
            .enumerate()
            .map(
                |(column, (cell, width))| {
                    if column < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                },
            )
            .collect();
        text += cells.join("   ").trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "bb", "1"], ["ccc", "d", "22"]].map(|row| row.map(String::from));
        assert_eq!(aligned(&rows, 2), "a     bb    1\nccc   d    22\n");
    }

    #[test]
    fn every_board_and_the_totals_are_there() {
        let flight = sample::flight();
        let text = text(&flight, &Summary::of(&flight));
        for expected in [
            "master               operational, redundant bus",
            "node 4   selective   operational, redundant bus   12406.0 ms      271        271",
            "2 of 2 slaves operational; TC: 778 on the wire, 660 due, 660 executed, 0 repeats dropped",
        ] {
            assert!(text.contains(expected), "no {expected:?} in\n{text}");
        }
    }
}
