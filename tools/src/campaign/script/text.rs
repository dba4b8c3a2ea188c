//! Scripts as text: a line for the run, and one for each fault.

use std::fmt;
use std::str::FromStr;

use clap::ValueEnum;
use ecss_can::types::Bus;

use super::{Fault, SECOND, SECOND_BOARD, Script, UNUSED_NODE};
use crate::campaign::kind::Kind;

fn bus_name(bus: Bus) -> &'static str {
    match bus {
        Bus::Nominal => "nominal",
        Bus::Redundant => "redundant",
    }
}

impl fmt::Display for Script {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let access = if self.selective { "selective" } else { "parallel" };
        write!(f, "# microseconds; node n sits at 2 n metres; slave 4 has {access} access")?;
        let (end, masters) = match self.masters {
            1 => (String::new(), String::new()),
            count => (
                format!("; node {SECOND_BOARD}: second master, at {}", self.place(SECOND_BOARD)),
                format!(" masters={count}"),
            ),
        };
        writeln!(f, "{end}")?;
        writeln!(
            f,
            "run seed={}{masters} slaves={} selective={} assigned={} length={}",
            self.seed,
            self.slaves,
            u8::from(self.selective),
            u8::from(self.assigned),
            self.length
        )?;
        self.faults.iter().try_for_each(|fault| writeln!(f, "{fault}"))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at={}", self.kind.name(), self.at)?;
        if let Some(lasts) = self.lasts {
            write!(f, " lasts={lasts}")?;
        }
        if !self.kind.is_of_node() {
            write!(f, " bus={}", bus_name(self.bus))?;
        }
        let rest: [(&str, u64); 6] = [
            ("node", self.node.into()),
            ("place", self.place.into()),
            ("value", self.value.into()),
            ("times", self.times.into()),
            ("every", self.every),
            ("in_frame", self.in_frame.into()),
        ];
        rest.into_iter()
            .filter(|(_, value)| *value > 0)
            .try_for_each(|(key, value)| write!(f, " {key}={value}"))
    }
}

/// Keys of the line `run`, and of a fault.
const OF_RUN: [&str; 6] = ["seed", "masters", "slaves", "selective", "assigned", "length"];
const OF_FAULT: [&str; 9] = ["at", "lasts", "bus", "node", "place", "value", "times", "every", "in_frame"];

/// Key-value pairs of a line, after its first word.
struct Pairs<'a> {
    line: &'a str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> Pairs<'a> {
    fn of(line: &'a str) -> Result<(&'a str, Pairs<'a>), String> {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        let pairs = words.map(|word| word.split_once('=').ok_or(format!("`{word}`: expected KEY=VALUE")));
        let pairs: Vec<_> = pairs.collect::<Result<_, _>>()?;
        let known: &[&str] = if first == "run" { &OF_RUN } else { &OF_FAULT };
        for (nth, (key, value)) in pairs.iter().enumerate() {
            if !known.contains(key) {
                return Err(format!("`{line}`: unknown {key}={value}, allowed are {}", known.join(", ")));
            }
            if pairs[..nth].iter().any(|(earlier, _)| earlier == key) {
                return Err(format!("`{line}`: {key}={value} is the second {key}, allowed is one"));
            }
        }
        Ok((first, Pairs { line, pairs }))
    }

    fn text(&self, key: &str) -> Option<&'a str> {
        self.pairs.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }

    /// Returns a number up to `most`; 0 if it is missing.
    fn number(&self, key: &str, most: u64) -> Result<u64, String> {
        let text = self.text(key).unwrap_or("0");
        let value = text.parse().ok().filter(|value| *value <= most);
        value.ok_or_else(|| format!("`{}`: {key}={text}, allowed are 0 to {most}", self.line))
    }
}

/// Longest run, an hour, in microseconds.
const HOUR_US: u64 = 3_600 * SECOND;

impl FromStr for Script {
    type Err = String;

    fn from_str(text: &str) -> Result<Script, String> {
        let lines = (1..).zip(text.trim_start_matches('\u{FEFF}').lines().map(str::trim));
        let mut script = None;
        for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
            read_line(line, &mut script).map_err(|wrong| format!("line {number}: {wrong}"))?;
        }
        let mut script: Script = script.ok_or("no line `run seed=.. slaves=.. selective=.. length=..`")?;
        if script.length == 0 {
            script.length = script.shortest_length();
        }
        Ok(script)
    }
}

fn read_line(line: &str, script: &mut Option<Script>) -> Result<(), String> {
    let (word, pairs) = Pairs::of(line)?;
    match (word, &mut *script) {
        ("run", None) => {
            let slaves = pairs.number("slaves", 125)? as u8;
            if slaves == 0 {
                return Err(format!("`{line}`: slaves=0, allowed are 1 to 125"));
            }
            *script = Some(Script {
                seed: pairs.number("seed", u64::MAX)?,
                masters: read_masters(&pairs)?,
                slaves,
                selective: pairs.number("selective", 1)? == 1,
                assigned: pairs.number("assigned", 1)? == 1,
                length: pairs.number("length", HOUR_US)?,
                faults: Vec::new(),
            });
        }
        (_, None) => return Err(format!("`{line}`: a script begins with `run`")),
        (_, Some(script)) => {
            let fault = read_fault(word, &pairs, script)?;
            script.faults.push(fault);
        }
    }
    Ok(())
}

fn read_masters(pairs: &Pairs<'_>) -> Result<u8, String> {
    match pairs.text("masters") {
        None | Some("1") => Ok(1),
        Some("2") => Ok(2),
        Some(other) => Err(format!("`{}`: masters={other}, allowed are 1 and 2", pairs.line)),
    }
}

fn read_fault(word: &str, pairs: &Pairs<'_>, script: &Script) -> Result<Fault, String> {
    let kind = Kind::from_str(word, false).map_err(|_| {
        let names: Vec<_> = Kind::value_variants().iter().map(|kind| kind.name()).collect();
        format!("`{word}` is no fault: allowed are {}", names.join(", "))
    })?;
    let bus = match pairs.text("bus") {
        Some("nominal") | None => Bus::Nominal,
        Some("redundant") => Bus::Redundant,
        Some(other) => {
            return Err(format!("`{}`: bus={other}, allowed are nominal and redundant", pairs.line));
        }
    };
    let last = if kind == Kind::UnknownNode { UNUSED_NODE } else { script.slaves + 1 };
    let is_second = script.masters == 2 && pairs.text("node") == Some("128");
    let node = if is_second { SECOND_BOARD } else { pairs.number("node", last.into())? as u8 };
    let (needs_slave, needs_node) = (
        matches!(kind, Kind::ResetSlave | Kind::PowerSlave | Kind::Clash),
        matches!(kind, Kind::Disconnect | Kind::Stuck | Kind::Babble | Kind::Drift),
    );
    let is_slave = node >= 2 && node != SECOND_BOARD;
    if needs_slave && !is_slave || needs_node && node < 1 || kind.is_foreign() && node == SECOND_BOARD {
        return Err(format!("`{}`: node={node} is not possible for this fault", pairs.line));
    }
    let is_master = matches!(kind, Kind::ResetMaster | Kind::PowerMaster) && node != SECOND_BOARD;
    let is_master = is_master || kind == Kind::ForeignMaster;
    Ok(Fault {
        at: pairs.number("at", HOUR_US)?,
        lasts: pairs.text("lasts").map(|_| pairs.number("lasts", HOUR_US)).transpose()?,
        kind,
        bus,
        node: if is_master { 1 } else { node },
        place: pairs.number("place", 256)? as u32,
        value: pairs.number("value", u32::MAX.into())? as u32,
        times: pairs.number("times", 100_000)? as u32,
        every: pairs.number("every", HOUR_US)?,
        in_frame: pairs.number("in_frame", 1)? == 1,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given byte order marks and line ends of editors on other systems, then the text is the same script.
    #[test]
    fn script_is_read_with_ends_of_lines_and_marks_of_editors() {
        let script = Script::random(7, 3, 0);
        let edited = format!("\u{FEFF}  {}", script.to_string().replace('\n', " \r\n\r\n"));
        assert_eq!(edited.parse(), Ok(script));
    }

    #[test]
    fn script_without_length_leaves_room_for_recovery() {
        let length = |text: &str| text.parse::<Script>().unwrap().length;
        assert_eq!(length("run slaves=2"), 60_000_000);
        assert_eq!(length("run slaves=2\ncut at=40000000 lasts=1000000 place=3"), 71_000_000);
        assert_eq!(length("run slaves=2 length=1000000"), 1_000_000);
    }

    #[test]
    fn wrong_scripts_are_refused_with_what_is_allowed() {
        let refused = |text: &str, part: &str| {
            let error = text.parse::<Script>().unwrap_err();
            assert!(error.contains(part), "{error}");
        };
        refused("", "no line `run");
        refused("cut at=1", "begins with `run`");
        refused("run slaves=126", "0 to 125");
        refused("run slaves=2\nfire at=1", "allowed are cut, short");
        refused("run slaves=2\ncut at=1 bus=third", "nominal and redundant");
        refused("run slaves=2\nreset-slave at=1 node=4", "0 to 3");
        refused("run slaves=2 masters=3", "1 and 2");
        refused("run slaves=2\nreset-master at=1 node=128", "0 to 3");
        refused("run masters=2 slaves=2\nreset-slave at=1 node=128", "not possible");
        refused("run slaves=2\nreset-slave at=1", "not possible");
        refused("run slaves=2\ncut soon", "KEY=VALUE");
        refused("run slaves=0", "line 1: `run slaves=0`: slaves=0, allowed are 1 to 125");
        refused(
            "# two\n\nrun slaves=2\ncut at=1 plcae=3",
            "line 4: `cut at=1 plcae=3`: unknown plcae=3, allowed are at,",
        );
        refused("run slaves=2 at=1", "unknown at=1, allowed are seed, masters");
        refused("run slaves=2\ncut at=1 at=2", "at=2 is the second at, allowed is one");
        refused("run slaves=2 length=0x10", "length=0x10, allowed are 0 to 3600000000");
    }
}
