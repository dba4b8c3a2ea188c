//! Output of the command.

use std::time::Duration;

use console::style;

use super::message::{Errors, Network};
use super::mission::{Named, micros};

/// Assumptions of the figures.
pub const ASSUMPTIONS: &str = "Longest stuffing; each node sends the most urgent of its frames first. An SDO answer, a PDO after SYNC and \
    telemetry count\nfrom the request or SYNC before them. No object limits NMT commands and SDO requests: one per slave and heartbeat period, \
    or --sdo.";

/// Returns a line for each COB-ID; if several messages share one, that of the latest.
pub fn lines(named: &[Named], times: &[Option<Duration>], network: &Network) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<7} {:<22} {:>5} {:>10} {:>8} {:>9} {:>9} {:>10}  verdict",
        "COB-ID", "message", "bytes", "period us", "frame us", "jitter us", "latest us", "deadline us"
    )];
    let mut rest: &[Named] = named;
    let mut index = 0;
    while let Some(first) = rest.first() {
        let count = rest.iter().take_while(|named| named.message.id == first.message.id).count();
        // `None`, no bound, is the latest of all.
        let latest = (index..index + count).max_by_key(|&m| times[m].unwrap_or(Duration::MAX));
        lines.extend(latest.map(|m| line(&named[m], count, times[m], network)));
        (rest, index) = (&rest[count..], index + count);
    }
    lines
}

fn line(Named { name, message }: &Named, count: usize, time: Option<Duration>, network: &Network) -> String {
    let name = if count > 1 { format!("{name}, {count} of them") } else { name.clone() };
    let verdict = match time {
        Some(time) if time <= message.deadline => style("in time").green().to_string(),
        Some(_) => style("LATE").red().bold().to_string(),
        None => style("NO BOUND").red().bold().to_string(),
    };
    format!(
        "{:<7} {name:<22} {:>5} {:>10} {:>8} {:>9} {:>9} {:>10}  {verdict}",
        format!("{:03X}h", message.id),
        message.bytes,
        micros(message.period),
        micros(network.transmission(message)),
        micros(message.jitter),
        time.map_or("-".into(), |time| micros(time).to_string()),
        micros(message.deadline),
    )
}

/// Returns the error model as text.
pub fn errors(errors: &Errors) -> String {
    match errors {
        Errors { burst: 0, interval: None } => "none".into(),
        Errors { burst, interval: None } => format!("{burst} at once"),
        Errors { burst, interval: Some(interval) } => {
            format!("{} at once, then one in {} ms", burst.max(&1), interval.as_millis())
        }
    }
}
