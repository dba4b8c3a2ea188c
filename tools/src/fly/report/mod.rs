//! The report of a flight: one self-contained HTML file.

mod axis;
pub mod clocks;
mod events;
mod faults;
mod flags;
mod header;
mod kind;
mod lanes;
mod states;
mod tables;
mod timeline;
mod values;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::fly::change::Since;
use crate::fly::curves::ValueCurve;
use crate::fly::drawing::paint::{self, BASE, Sheet};
use crate::fly::drawing::{Layout, Picture};
use crate::fly::flight::Flight;
use crate::fly::meaning::Scope;
use crate::fly::plan::BusAccess;
use crate::fly::record::Bus;
use crate::fly::summary::Summary;
use crate::images::support::board::Profile;

const PAGE_STYLE: &str = include_str!("page.css");

/// Colours and letters of the pictures, by class.
const SHEETS: &[Sheet] = &[BASE, include_str!("flight.sheet")];

/// Returns the bus timeline as a separate picture.
pub fn timeline(flight: &Flight) -> String {
    timeline::overview(flight, Layout::WIDE).standalone()
}

/// Returns the errors of the clocks as a separate picture.
pub fn clocks(flight: &Flight) -> String {
    clocks::draw(flight, Layout::WIDE).standalone()
}

/// Returns the page; `curves`: values of PDOs over time.
pub fn page(flight: &Flight, curves: &[ValueCurve], summary: &Summary) -> String {
    let scope = flight.plan.scope();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "A run on two CAN buses" }
                style { (PreEscaped(PAGE_STYLE)) (PreEscaped(paint::dark(SHEETS))) }
            }
            body {
                main {
                    (header::header(flight, summary))
                    (header::tiles(summary))
                    (section("Pass criteria", CHECKS_HELP, &tables::checks(summary)))
                    (section("The two buses", &buses_help(flight), &both(|layout| timeline::overview(flight, layout))))
                    @for (since, title, help) in [
                        (Since::Cut, "Around the cut", cut_help(flight)),
                        (Since::Loss, "Around the takeover", LOSS_HELP.into()),
                    ] {
                        @if let Some(wide) = timeline::close_up(flight, since, Layout::WIDE) {
                            @let narrow = timeline::close_up(flight, since, Layout::NARROW);
                            (section(title, &help, &each(&wide, narrow.as_ref())))
                        }
                    }
                    (section("What every node did", NODES_HELP, &html! {
                        (both(|layout| states::draw(flight, layout)))
                        (states_key())
                    }))
                    @if flight.clocks.is_empty() {
                        (section("The clocks of the slaves", "", &tables::unjudged(summary)))
                    } @else {
                        (section("The clocks of the slaves", &clocks_help(flight), &html! {
                            (both(|layout| clocks::draw(flight, layout)))
                            @if let Some(wide) = clocks::histogram(flight, Layout::WIDE) {
                                (each(&wide, clocks::histogram(flight, Layout::NARROW).as_ref()))
                            }
                            (tables::clocks(flight))
                            (tables::unjudged(summary))
                        }))
                    }
                    .columns {
                        (section("Fail-over", &failover_help(flight), &tables::failover(flight)))
                        (section("Frames", "Completed frames per bus, and the share of the run in which the bus was busy.", &tables::frames(flight)))
                    }
                    (section("Emergencies", EMERGENCIES_HELP, &events::emergencies(summary)))
                    @if !summary.pdo_values.is_empty() {
                        (section("Values of PDOs", PDOS_HELP, &html! {
                            (tables::pdos(summary))
                            (values::charts(flight, curves))
                        }))
                    }
                    @if !summary.pdo_mismatches.is_empty() {
                        (section("Receive PDOs that do not match", MISMATCHES_HELP, &html! {
                            ul { @for mismatch in &summary.pdo_mismatches { li { (mismatch) } } }
                        }))
                    }
                    @if !summary.aborted.is_empty() {
                        (section("Aborted frames", ABORTED_HELP, &tables::aborted(summary)))
                    }
                    (section("Boards", &boards_help(scope), &html! {
                        (tables::boards(flight))
                        p.totals {
                            "All boards: " (tables::number("lost_frames", summary.lost_frames)) " frames lost, "
                            (tables::number("aborted_frames", summary.aborted_frames)) " aborted, "
                            (tables::number("resets", summary.resets)) " resets, "
                            (tables::number("lockups", summary.lockups)) " lock-ups, "
                            (tables::number("panics", summary.panics)) " panics."
                        }
                    }))
                    (section("Date and images", "", &html! {
                        (tables::origin(summary))
                        @if !summary.data_sheets.is_empty() { (tables::sheets(summary)) }
                    }))
                    (section("Other events", EVENTS_HELP, &events::others(flight)))
                    (story(flight))
                    (section("How to read this", "", &how_to_read(flight)))
                    footer { (footer(summary)) }
                }
            }
        }
    };
    page.into_string() + "\n"
}

const MISMATCHES_HELP: &str = "By the data sheets of sender and receiver: another length, type or order of values, or a COB-ID that \
    no board sends. No check of the flight depends on it.";

const BUSES_HELP: &str = "Every frame that completed is a tick in the row of its kind. The shaded stretch is the bus on \
    which the master sends its heartbeat: that is what makes a bus the active one.";

const CLAIMS_HELP: &str = "The active master also sends claims, one with each heartbeat, on both buses. A standby that is cut off \
    from the active bus hears them on the other one and stays silent.";

fn buses_help(flight: &Flight) -> String {
    if flight.masters() > 1 { format!("{BUSES_HELP} {CLAIMS_HELP}") } else { BUSES_HELP.into() }
}

const CUT_HELP: &str = "The same, stretched. After the cut, no node acknowledges the master. None of its frames completes \
    until it moves to the other bus and takes the slaves with parallel access along.";

const PARTED_HELP: &str = "The same, stretched. The cut parts the nominal bus. The standby and the slaves on its side hear no \
    701h any more. These slaves become pre-operational after their consumer time. The active master moves to the redundant bus, \
    and all slaves follow. ";

const UNMOVED_HELP: &str = "The same, stretched. The cut parts the nominal bus, and the active master stays there. The standby \
    hears no 701h any more. ";

const SILENT_HELP: &str = "The standby hears claims on the redundant bus all the time and stays silent: exactly one master is \
    active.";

fn cut_help(flight: &Flight) -> String {
    match (flight.masters(), flight.switch()) {
        (1, _) => CUT_HELP.into(),
        (_, Some(_)) => format!("{PARTED_HELP}{SILENT_HELP}"),
        (_, None) => format!("{UNMOVED_HELP}{SILENT_HELP}"),
    }
}

const LOSS_HELP: &str = "The same, stretched. Without its master the network is silent but for the slaves, which become \
    pre-operational after their consumer time of 250 ms. The other board was silent up to then: after its own consumer time of \
    400 ms it sends 701h, and starts the slaves.";

const NODES_HELP: &str = "Taken from the wires: heartbeats and commands that reached the node, not its own memory. The thin \
    line below a bar is the bus on which the node works. Point at a bar for its times.";

fn clocks_help(flight: &Flight) -> String {
    let means = match flight.plan.profile {
        Profile::Standard | Profile::Standby => {
            "SYNC goes out every 100 ms, the spacecraft time every second."
        }
        Profile::Librecube => {
            "SYNC goes out every 5 s and the spacecraft time every 10 s: the clocks are much less accurate than in the profile \
             standard."
        }
    };
    format!(
        "Each board raises a pin when a second of its spacecraft time begins. The error is the distance of a slave's edge from the \
         master's edge of the same second, without sign, from the first spacecraft time that reached the slave. The scale is \
         logarithmic. {means} Crystals drift by 0.1 ppm/s for 40 s and make noise. The delay of the cable, 5 ns per metre, is not corrected. \
         Settled is what comes 20 s after the first spacecraft time: the histograms and the table are of it."
    )
}

fn failover_help(flight: &Flight) -> String {
    let works = match flight.plan.scope() {
        Scope::Mission => {
            "Fail-over: from the cut until the slave was commanded, or answered, on the other bus."
        }
        Scope::Protocol => {
            "Fail-over: from the cut to the slave's first heartbeat as operational on the other bus."
        }
    };
    let takeover = " Takeover: from the loss of the active master until the slave worked for the other one.";
    let takeover = if flight.masters() > 1 { takeover } else { "" };
    let access = match flight.plan.scope() {
        Scope::Mission => "",
        Scope::Protocol => {
            " The access of an image of your own is that of its first heartbeat after the master has changed the bus; a dash without \
             such a change."
        }
    };
    format!("{works}{takeover}{access}")
}

const CHECKS_HELP: &str =
    "The run passes when every check holds. Fail-over times and clock errors are reported, not judged.";

const EMERGENCIES_HELP: &str = "Emergency messages (EMCY), with the error code and the error register as CiA 301 names them. Code \
    0000h ends an error. The details are the field of the manufacturer. Equal messages of a node are one row.";

const PDOS_HELP: &str =
    "The last frame of each PDO, with the names that the data sheet of its sender has for the objects in it.";

const EVENTS_HELP: &str = "Power, faults that the demo caused, boot-up messages, NMT commands, and changes of state and bus as \
    the wires show them.";

const ABORTED_HELP: &str = "Frames that a board took back before they were sent, by the result of the latest attempt to send them. A \
    master does so when it leaves a bus: a frame that waits there would be out of date when the bus comes back. Failed: an error, \
    for example no acknowledgement. An aborted frame is no fault.";

fn boards_help(scope: Scope) -> String {
    let columns = match scope {
        Scope::Mission => {
            "Crystal, place and power-on time come from the seed. Due are the commands that completed while the slave was \
             operational on that bus, by the observer's model; executed is the slave's own count."
        }
        Scope::Protocol => {
            "Crystal, place and power-on time come from the seed. The gap is the longest time without a heartbeat of the \
             node, on whichever bus, up to the end of the flight."
        }
    };
    format!(
        "{columns} Aborted frames were taken back before they were sent, which is no fault. Lost are frames that a board received \
             and its program never handled."
    )
}

fn how_to_read(flight: &Flight) -> Markup {
    let is_selective = |(_, access)| access == BusAccess::Selective;
    let has_selective = flight.plan.slaves().any(is_selective);
    let has_minimal = flight.plan.boards.iter().any(|board| board.is_minimal);
    let [consumer, search] =
        [flight.plan.consumer_time(), flight.plan.toggling_time()].map(|time| time.as_secs_f64());
    html! {
        p {
            "All times are virtual: the boards are emulated, the same seed gives the same flight. Each board runs the real \
             firmware image; each bus carries real bit timing, arbitration and acknowledgement."
        }
        p {
            b { "Parallel access" } ": both controllers of the slave are live, it follows the master's first message on \
             the other bus and stays operational. "
            @if has_selective {
                b { "Selective access" } ": the slave hears one bus at a time; it misses the master's heartbeat for one \
                 consumer time (" (consumer) " s), becomes pre-operational, and changes to the other bus after Ttoggle = " (flight.plan.ttoggle())
                " consumer times (" (search) " s after the last heartbeat). The master then starts it unasked."
            }
            @if has_minimal {
                " " b { "Minimal" } ": a slave of the minimal set (ECSS clause 9), without NMT, SDO and boot-up. It is operational \
                 from power-on, and follows the master's heartbeat by parallel or selective access."
            }
            @if flight.plan.boards.iter().any(|board| board.has_one_controller) {
                " " b { "One controller" } ": it changes the bus by a switch between its CAN controller and two transceivers \
                 (ECSS Figure A-6), so it has selective access."
            }
        }
        p {
            "The logs beside this file hold every frame: " code { "bus-nominal.log" } " and " code { "bus-redundant.log" }
            " for can-utils, " code { "spacecraft.pcapng" } " for Wireshark, " code { "summary.json" } " for programs."
        }
    }
}

/// A picture for wide pages and one for narrow ones; the style sheet shows one of them.
fn both(draw: impl Fn(Layout) -> Picture) -> Markup {
    each(&draw(Layout::WIDE), Some(&draw(Layout::NARROW)))
}

fn each(wide: &Picture, narrow: Option<&Picture>) -> Markup {
    html! {
        .wide { (PreEscaped(wide.inline())) }
        .narrow { @if let Some(narrow) = narrow { (PreEscaped(narrow.inline())) } }
    }
}

fn section(title: &str, help: &str, body: &Markup) -> Markup {
    html! {
        section {
            h2 { (title) }
            @if !help.is_empty() { p { (help) } }
            (body)
        }
    }
}

fn states_key() -> Markup {
    let entries = [
        ("phase-off", "off"),
        ("phase-starting", "starting"),
        ("phase-standby", "standby"),
        ("phase-pre-operational", "pre-operational"),
        ("phase-operational", "operational, of a master: active"),
        ("phase-stopped", "stopped"),
        ("phase-silent", "silent"),
        ("on-nominal", "on the nominal bus"),
        ("on-redundant", "on the redundant bus"),
    ];
    let patch = |class| {
        let mut patch = Picture::new(14.0, 14.0, "", SHEETS);
        patch.rect(class, 0.0, 0.0, 14.0, 14.0);
        PreEscaped(patch.inline())
    };
    html! {
        .key { @for (class, name) in entries { span { (patch(class)) (name) } } }
    }
}

fn story(flight: &Flight) -> Markup {
    html! {
        section {
            details {
                summary { "The story, line by line (" (flight.story.len()) " lines)" }
                .story {
                    @for line in &flight.story {
                        @let (at, bus) = (line.at.as_secs_f64(), line.bus.map_or("", Bus::name));
                        span class=(format!("{:?}", line.tone)) {
                            (format!("{at:>10.4} s  {bus:<9}  {:<8}  {}", line.who, line.text))
                        }
                        "\n"
                    }
                }
            }
        }
    }
}

fn footer(summary: &Summary) -> String {
    format!(
        "Emulated at {} million instructions per second: {} s of virtual time in {} s. Cycle counts are model cycles, \
         flash wait states included. Frame time stamps in the firmware: {}.",
        summary.emulated_mips, summary.virtual_seconds, summary.wall_seconds, summary.stamp_source
    )
}

/// Formats milliseconds in the most readable unit.
fn duration(milliseconds: f64) -> String {
    if milliseconds < 1000.0 {
        format!("{milliseconds:.1} ms")
    } else {
        format!("{:.2} s", milliseconds / 1000.0)
    }
}

/// Formats an instant in seconds, without a place for a line break.
fn instant(seconds: f64) -> String {
    format!("{seconds:.4}\u{a0}s")
}

#[cfg(test)]
mod tests;
