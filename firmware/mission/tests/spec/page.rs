//! The table of `docs/profiles.md` has the values of the shipped profiles.

use ecss_can::boot::BootPolicy;
use ecss_can::link::bit_timing::Network;
use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::link::bus_off::BusOffPolicy;
use ecss_can::profile::Profile;
use ecss_can::redundancy::Pair;
use ecss_can::time::ClockPolicy;
use ecss_can::types::{Bus, CobId, Duration, NodeId};
use mission::{LIBRECUBE, STANDARD, TWO_MASTERS};

const PAGE: &str = include_str!("../../../../docs/profiles.md");

/// Name, unit and value of each field.
type Values = Vec<(&'static str, &'static str, String)>;

fn ms(time: Duration) -> String {
    let us = time.as_micros();
    assert!(us.is_multiple_of(1_000), "{us} µs: no whole milliseconds");
    thousands(time.as_millis())
}

/// Formats a number with a comma between groups of three digits.
fn thousands(number: u64) -> String {
    match number {
        0..1_000 => number.to_string(),
        _ => format!("{},{:03}", thousands(number / 1_000), number % 1_000),
    }
}

fn yes(is: bool) -> String {
    if is { "yes" } else { "no" }.to_owned()
}

/// Formats the parts of a list; "none" if it is empty.
fn list<T>(parts: &[T], part: impl Fn(&T) -> String) -> String {
    match parts {
        [] => "none".to_owned(),
        parts => parts.iter().map(part).collect::<Vec<_>>().join(", "),
    }
}

fn nodes(nodes: &[NodeId]) -> String {
    list(nodes, |node| node.get().to_string())
}

fn cob_id(id: CobId) -> String {
    format!("{:03X}h", id.raw())
}

/// Formats a rate. A rate has no accessors, so it is found in a list; a new one has to be added there.
fn rate(rate: Rate) -> String {
    let known = [(128, 1_000), (256, 2_000), (512, 3_000), (1_024, 6_000)];
    let same = known.into_iter().find(|(burst, per_second)| Rate::new(*burst, *per_second) == rate);
    let (burst, per_second) = same.expect("a rate of this list");
    format!("{} / {}", thousands(u64::from(burst)), thousands(u64::from(per_second)))
}

/// Returns the values of a profile. The pattern has no `..`, so a new field does not compile until it has a row.
fn values(profile: &Profile) -> Values {
    let Profile {
        name: _,
        network: Network { bit_rate, length, node_delay, oscillator_tolerance, jump_width },
        heartbeat,
        late_heartbeat,
        consumer,
        bdefault,
        ttoggle,
        ntoggle,
        master_ntoggle,
        sync,
        time,
        event,
        selective,
        silent_share,
        dwell,
        stamped,
        clocks: ClockPolicy { tolerance, drift, excursion, agreeing },
        sdo_timeout,
        slaves,
        settings,
        minimal,
        boot: BootPolicy { time: boot_time, goes_on },
        grace,
        bus_off: BusOffPolicy { pause, patience, attempts, window },
        budget: BudgetPolicy { cob_id: of_cob_id, slave, master, heard, silence },
        autostart,
        standby,
    } = *profile;
    let bus = if bdefault == Bus::Nominal { "nominal" } else { "redundant" };
    let late_us = late_heartbeat.as_micros();
    let slave_nodes: Vec<NodeId> = slaves.iter().map(|slave| slave.node).collect();
    let minimal_nodes: Vec<NodeId> = minimal.iter().map(|slave| slave.node).collect();
    let mut written: Vec<String> =
        settings.iter().map(|setting| format!("{:04X}h", setting.at.index)).collect();
    written.sort();
    written.dedup();
    let pair = |part: fn(Pair) -> String| standby.map_or("–".to_owned(), part);
    vec![
        ("network.bit_rate", "kbit/s", thousands(u64::from(bit_rate.get() / 1_000))),
        ("network.length", "m", length.0.to_string()),
        ("network.node_delay", "ns", node_delay.0.to_string()),
        ("network.oscillator_tolerance", "ppm", thousands(u64::from(oscillator_tolerance.0))),
        ("network.jump_width", "quanta", jump_width.to_string()),
        ("heartbeat", "ms", ms(heartbeat)),
        ("late_heartbeat", "µs", thousands(late_us)),
        ("consumer", "ms", ms(consumer)),
        ("bdefault", "bus", bus.to_owned()),
        ("ttoggle", "times", ttoggle.to_string()),
        ("ntoggle", "times", ntoggle.to_string()),
        ("master_ntoggle", "times", master_ntoggle.to_string()),
        ("sync", "ms", ms(sync)),
        ("time", "ms", ms(time)),
        ("event", "ms", ms(event)),
        ("selective", "nodes", nodes(selective)),
        ("silent_share", "%", silent_share.to_string()),
        ("dwell", "ms", ms(dwell)),
        ("stamped", "COB-IDs", list(stamped, |id| cob_id(*id))),
        ("clocks.tolerance", "ppm", tolerance.0.to_string()),
        ("clocks.drift", "ppb/s", drift.to_string()),
        ("clocks.excursion", "ppb", thousands(u64::from(excursion))),
        ("clocks.agreeing", "times", agreeing.to_string()),
        ("sdo_timeout", "ms", ms(sdo_timeout)),
        ("slaves", "nodes", nodes(&slave_nodes)),
        ("settings", "objects", list(&written, String::clone)),
        ("minimal", "nodes", nodes(&minimal_nodes)),
        ("boot.time", "ms", ms(boot_time)),
        ("boot.goes_on", "", yes(goes_on)),
        ("grace", "ms", ms(grace)),
        ("bus_off.pause", "ms", ms(pause)),
        ("bus_off.patience", "ms", ms(patience)),
        ("bus_off.attempts", "times", attempts.to_string()),
        ("bus_off.window", "ms", ms(window)),
        ("budget.cob_id", "frames / frames per s", rate(of_cob_id)),
        ("budget.slave", "frames / frames per s", rate(slave)),
        ("budget.master", "frames / frames per s", rate(master)),
        ("budget.heard", "frames / frames per s", rate(heard)),
        ("budget.silence", "ms", ms(silence)),
        ("autostart", "", yes(autostart)),
        ("standby.consumer", "ms", pair(|pair| ms(pair.consumer))),
        ("standby.prime_listens", "ms", pair(|pair| ms(pair.prime_listens))),
        ("standby.second_listens", "ms", pair(|pair| ms(pair.second_listens))),
        ("standby.prime_claims", "COB-ID", pair(|pair| cob_id(pair.prime_claims))),
        ("standby.second_claims", "COB-ID", pair(|pair| cob_id(pair.second_claims))),
    ]
}

/// Given the table of the page, then its rows have name, unit and the three values of the code, in the order of the code.
#[test]
fn table_of_profiles_has_the_values_of_the_code() {
    let profiles = [&STANDARD, &TWO_MASTERS, &LIBRECUBE];
    let head = profiles.map(|profile| format!("`{}`", profile.name));
    assert!(PAGE.contains(&format!("| name | unit | meaning | {} |", head.join(" | "))), "{head:?}");
    let [standard, standby, librecube] = profiles.map(values);
    let expected = standard.into_iter().zip(standby).zip(librecube);
    let expected: Vec<[String; 5]> = expected
        .map(|(((name, unit, one), (_, _, two)), (_, _, three))| {
            [format!("`{name}`"), unit.to_owned(), one, two, three]
        })
        .collect();
    let rows = PAGE.lines().skip_while(|line| !line.starts_with("| name | unit |")).skip(2);
    let found: Vec<[String; 5]> = rows
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let [name, unit, meaning, values @ ..] = &cells[..] else { panic!("{line}: too few cells") };
            assert!(!meaning.is_empty(), "{line}: no meaning");
            let [one, two, three] = values else { panic!("{line}: a value for each profile") };
            [name, unit, one, two, three].map(|cell| cell.to_string())
        })
        .collect();
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected, "docs/profiles.md has the left row, the code the right one");
    }
    assert_eq!(found.len(), expected.len(), "rows of docs/profiles.md, and of the code");
}
