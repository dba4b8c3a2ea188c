//! The report of a flight: one HTML file that needs nothing else.

pub mod axis;
pub mod chart;
mod clocks;
mod paint;
mod states;
pub mod svg;
mod tables;
mod timeline;

use crate::flight::Flight;
use crate::meaning::Scope;
use crate::narrator::name;
use crate::outcome::UNKNOWN_IMAGES;
use crate::record::Bus;
use crate::summary::Summary;
use crate::track::BusAccess;
use crate::verdict::{Outcome, Verdict};
use axis::Layout;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use support::board::Profile;
use svg::Svg;

const PAGE_STYLE: &str = include_str!("page.css");

/// The bus timeline as a picture of its own.
pub fn timeline(flight: &Flight) -> String {
    timeline::overview(flight, Layout::WIDE).standalone()
}

/// The errors of the clocks as a picture of its own.
pub fn clocks(flight: &Flight) -> String {
    clocks::draw(flight, Layout::WIDE).standalone()
}

/// The whole page.
pub fn page(flight: &Flight, summary: &Summary) -> String {
    let scope = flight.plan.scope();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "A flight on two CAN buses" }
                style { (PreEscaped(PAGE_STYLE)) (PreEscaped(paint::dark())) }
            }
            body {
                main {
                    (header(flight, summary))
                    (tiles(summary))
                    (section("The two buses", BUSES_HELP, &both(|layout| timeline::overview(flight, layout))))
                    @if let Some(wide) = timeline::close_up(flight, Layout::WIDE) {
                        @let narrow = timeline::close_up(flight, Layout::NARROW);
                        @let (title, help) = around(flight);
                        (section(title, help, &each(&wide, narrow.as_ref())))
                    }
                    (section("What every node did", NODES_HELP, &html! {
                        (both(|layout| states::draw(flight, layout)))
                        (states_key())
                    }))
                    @if !flight.clocks.is_empty() {
                        (section("The clocks of the slaves", &clocks_help(flight), &html! {
                            (both(|layout| clocks::draw(flight, layout)))
                            @if let Some(wide) = clocks::histogram(flight, Layout::WIDE) {
                                (each(&wide, clocks::histogram(flight, Layout::NARROW).as_ref()))
                            }
                            (tables::clocks(flight))
                        }))
                    }
                    .columns {
                        (section("Fail-over", failover_help(flight), &tables::failover(flight)))
                        (section("Frames", "Completed frames per bus, and the share of the flight in which the bus was busy.", &tables::frames(flight)))
                    }
                    (section("Boards", boards_help(scope), &tables::boards(flight)))
                    (story(flight))
                    (section("How to read this", "", &how_to_read(flight)))
                    footer { (footer(summary)) }
                }
            }
        }
    };
    page.into_string() + "\n"
}

const BUSES_HELP: &str = "Every frame that completed is a tick in the row of its kind. The shaded stretch is the bus on \
    which the master sends its heartbeat: that is what makes a bus the active one.";

const CUT_HELP: &str = "The same, stretched. After the cut, no node acknowledges the master. None of its frames completes \
    until it moves to the other bus and takes the slaves with parallel access along.";

const LOSS_HELP: &str = "The same, stretched. Without its master the network is silent but for the slaves, which become \
    pre-operational after their consumer time of 250 ms. The other board was silent up to then: after its own consumer time of \
    400 ms it sends 701h, and starts the slaves.";

/// Title and help of the stretched picture.
fn around(flight: &Flight) -> (&'static str, &'static str) {
    match flight.loss() {
        Some(_) => ("Around the takeover", LOSS_HELP),
        None => ("Around the cut", CUT_HELP),
    }
}

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

fn failover_help(flight: &Flight) -> &'static str {
    match flight.plan.scope() {
        _ if flight.plan.loss.is_some() => {
            "From the loss of the active master until the slave worked for the other one."
        }
        Scope::Mission => "From the cut until the slave was commanded, or answered, on the other bus.",
        Scope::Protocol => "From the cut to the slave's first heartbeat as operational on the other bus.",
    }
}

fn boards_help(scope: Scope) -> &'static str {
    match scope {
        Scope::Mission => {
            "Crystal, place and power-on time come from the seed. Due are the commands that completed while the slave was \
             operational on that bus, by the observer's model; executed is the slave's own count."
        }
        Scope::Protocol => {
            "Crystal, place and power-on time come from the seed. The gap is the longest time without a heartbeat of the \
             node, on whichever bus, up to the end of the flight."
        }
    }
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

fn header(flight: &Flight, summary: &Summary) -> Markup {
    let Verdict { outcome, reasons } = &summary.verdict;
    let (class, verdict) = match outcome {
        Outcome::Passed => ("good", "flew as it should"),
        Outcome::Failed => ("bad", "failed"),
        Outcome::Interrupted => ("bad", "interrupted"),
    };
    let cut = flight.cut().map(|(at, bus)| {
        format!("At {} s the {} bus was cut next to the master.", at.as_secs_f64(), bus.name())
    });
    let fault = cut.or_else(|| loss(flight)).unwrap_or("No bus was cut.".into());
    let Summary { boards, board, profile, seed, virtual_seconds, own_images, .. } = summary;
    let profile = if own_images.len() < *boards { format!(", profile {profile}") } else { String::new() };
    html! {
        header {
            h1 { "A flight on two CAN buses" }
            span.verdict.(class) { (verdict) }
        }
        p.lead {
            (masters(summary)) " and " (boards - summary.masters) " slaves (" (board) (profile) ", seed " (seed) ") flew "
            (format!("{virtual_seconds:.0}")) " s of virtual time. " (fault)
        }
        @if flight.plan.scope() == Scope::Protocol {
            p.lead { (notice(flight)) }
        }
        @if !reasons.is_empty() {
            ul.faults { @for reason in reasons { li { (reason) } } }
        }
    }
}

fn masters(summary: &Summary) -> &'static str {
    if summary.masters == 1 { "One master" } else { "Two masters" }
}

/// What became of a master that lost its power.
fn loss(flight: &Flight) -> Option<String> {
    let (at, board) = flight.loss()?;
    let end = flight.takeover().map_or("; no board took over".into(), |takeover| {
        let took = duration(takeover.took().as_secs_f64() * 1e3);
        format!("; {} took over {took} after its last heartbeat", name(takeover.to))
    });
    Some(format!("At {} s {}, the active one, lost its power{end}.", at.as_secs_f64(), name(board)))
}

/// The images of the user's, and what the report leaves out for them.
fn notice(flight: &Flight) -> String {
    let boards = flight.plan.boards.iter();
    let own = boards.filter_map(|board| Some(format!("{}: {}", name(board.node), board.own_image.as_ref()?)));
    let own = own.collect::<Vec<_>>().join(", ");
    let mut left_out = UNKNOWN_IMAGES.to_owned();
    left_out[..1].make_ascii_uppercase();
    format!("{left_out} ({own}). The verdict is about NMT states, lost frames, lock-ups, panics and resets.")
}

fn tiles(summary: &Summary) -> Markup {
    let slaves = summary.boards - summary.masters;
    let fastest = summary.failover_ms.values().flatten().copied().reduce(f64::min);
    let slowest = summary.failover_ms.values().flatten().copied().reduce(f64::max);
    let mut tiles = vec![(
        format!("{} of {slaves}", summary.slaves_operational_at_end),
        "slaves operational at the end".into(),
    )];
    if let Some(mission) = &summary.mission {
        tiles.push((mission.tc_executed.to_string(), format!("commands executed, {} due", mission.tc_due)));
        tiles.push((mission.tm_received.to_string(), "telemetry replies received".into()));
    } else {
        tiles.push((summary.bus_changes.to_string(), "changes of bus by the master".into()));
        let highest = summary.bus_load_percent.values().copied().fold(0.0, f64::max);
        tiles.push((format!("{highest} %"), "load of the busier bus".into()));
    }
    if let Some(takeover) = summary.takeover_ms {
        tiles.push((duration(takeover), "without a master's heartbeat".into()));
    }
    if let (Some(fastest), Some(slowest)) = (fastest, slowest) {
        tiles.push((duration(fastest), "fastest fail-over".into()));
        tiles.push((duration(slowest), "slowest fail-over".into()));
    }
    tiles.push((summary.lost_frames.to_string(), "frames lost".into()));
    html! {
        .tiles { @for (value, what) in tiles { .tile { b { (value) } span { (what) } } } }
    }
}

/// A picture for wide pages and one for narrow ones; the style sheet shows one of them.
fn both(draw: impl Fn(Layout) -> Svg) -> Markup {
    each(&draw(Layout::WIDE), Some(&draw(Layout::NARROW)))
}

fn each(wide: &Svg, narrow: Option<&Svg>) -> Markup {
    html! {
        .wide { (wide.inline()) }
        .narrow { @if let Some(narrow) = narrow { (narrow.inline()) } }
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
        ("phase-operational", "operational"),
        ("phase-stopped", "stopped"),
        ("phase-silent", "silent"),
        ("on-nominal", "on the nominal bus"),
        ("on-redundant", "on the redundant bus"),
    ];
    let patch = |class| {
        let mut patch = Svg::new(14.0, 14.0, "");
        patch.rect(class, 0.0, 0.0, 14.0, 14.0);
        patch.inline()
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
                        span class=(format!("{:?}", line.tone)) {
                            (format!(
                                "{:>10.4} s  {:<9}  {:<8}  {}",
                                line.at.as_secs_f64(),
                                line.bus.map_or("", Bus::name),
                                line.who,
                                line.text
                            ))
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

/// Milliseconds in the unit that reads best.
fn duration(milliseconds: f64) -> String {
    if milliseconds < 1000.0 {
        format!("{milliseconds:.1} ms")
    } else {
        format!("{:.2} s", milliseconds / 1000.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    fn rendered(flight: &Flight) -> String {
        page(flight, &Summary::of(flight))
    }

    #[test]
    fn the_page_reports_the_flight() {
        let page = rendered(&sample::flight());
        for expected in [
            "flew as it should",
            "2 of 2",
            "cut next to the master, 20.0 s",
            "master switches, 600.0 ms after the cut",
            "605.0 ms",
            "12.41 s",
            "node 4: pre-operational on the nominal bus, 22.3000 s to 32.3500 s",
            "heartbeat moved to the redundant bus",
        ] {
            assert!(page.contains(expected), "{expected}");
        }
    }

    #[test]
    fn a_page_of_unknown_images_has_no_commands() {
        let mut flight = sample::flight();
        flight.plan.boards[1].own_image = Some("heater".into());
        let page = rendered(&flight);
        for expected in [
            "(node 2: heater)",
            "neither read nor judged",
            "PDOs, slaves",
            "800.0 ms",
            "2.25 %",
            "profile librecube",
        ] {
            assert!(page.contains(expected), "{expected}");
        }
        for forbidden in ["commands executed", "telemetry replies", "TM reply", "TC due"] {
            assert!(!page.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn the_page_needs_nothing_else() {
        let page = rendered(&sample::flight());
        for forbidden in ["src=", "href=", "url(", "@import", "<script"] {
            assert!(!page.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn faults_are_on_top_and_escaped() {
        let flight = sample::flight();
        let mut summary = Summary::of(&flight);
        summary.verdict = Verdict { outcome: Outcome::Failed, reasons: vec!["node 2 <panicked>".into()] };
        let page = page(&flight, &summary);
        assert!(page.contains("<li>node 2 &lt;panicked&gt;</li>"));
        assert!(!page.contains("flew as it should"));
    }

    #[test]
    fn the_timeline_stands_alone() {
        let picture = timeline(&sample::flight());
        let first = picture.lines().next().expect("a line");
        assert!(
            first.starts_with("<svg ") && first.contains(" xmlns=\"http://www.w3.org/2000/svg\""),
            "{first}"
        );
        assert!(picture.contains("prefers-color-scheme: dark"));
    }

    /// Given a renderer that knows no style sheets (librsvg, ImageMagick and Inkscape know no variables of CSS), Then every
    /// element still has its paint.
    #[test]
    fn timeline_is_painted_without_style_sheets() {
        let picture = timeline(&sample::flight());
        assert!(!picture.contains("var("));
        let (before, rest) = picture.split_once("<style>").expect("the sheet for dark ground");
        let (_, body) = rest.split_once("</style>").expect("its end");
        assert!(before.contains("font-family=") && before.contains("width=\"1160\""), "{before}");
        let drawn: Vec<&str> = body
            .lines()
            .filter(|line| ["<rect", "<line", "<path", "<text"].iter().any(|tag| line.starts_with(tag)))
            .collect();
        assert!(drawn.len() > 40, "{}", drawn.len());
        for element in &drawn {
            let paint =
                if element.starts_with("<line") || element.starts_with("<path") { "stroke" } else { "fill" };
            assert!(element.contains(&format!(" {paint}=\"#")), "{element}");
        }
        let paths = drawn.iter().filter(|element| element.starts_with("<path"));
        assert!(paths.clone().count() > 8 && paths.clone().all(|path| path.contains(" fill=\"none\"")));
    }

    /// Given a page of 400 px, Then the pictures for narrow pages fit into it, with the cut and all letters.
    #[test]
    fn narrow_pictures_fit_a_page_of_400_px() {
        let number = |element: &str, name: &str| -> Option<f64> {
            let (_, rest) = element.split_once(&format!(" {name}=\""))?;
            rest.split_once('"')?.0.parse().ok()
        };
        let flight = sample::flight();
        let pictures = [
            timeline::overview(&flight, Layout::NARROW),
            timeline::close_up(&flight, Layout::NARROW).expect("there was a cut"),
            states::draw(&flight, Layout::NARROW),
            clocks::draw(&flight, Layout::NARROW),
            clocks::histogram(&flight, Layout::NARROW).expect("a clock has settled"),
        ];
        let mut cuts = 0;
        for picture in pictures.map(|picture| picture.inline().into_string()) {
            let width = number(&picture, "width").expect("a width");
            assert!(width <= 400.0, "{width}");
            if let Some(cut) = picture.lines().find(|line| line.contains("class=\"cut\"")) {
                let cut = number(cut, "x1").expect("a place");
                assert!((82.0..width).contains(&cut), "{cut}");
                cuts += 1;
            }
            for text in picture.lines().filter(|line| line.starts_with("<text")) {
                let words = text.split(['<', '>']).nth(2).expect("words");
                // The narrowest letters that a reader may have.
                let (x, length) = (number(text, "x").expect("a place"), 5.5 * words.len() as f64);
                let (from, to) = match text {
                    text if text.contains("\"end\"") => (x - length, x),
                    text if text.contains("\"middle\"") => (x - length / 2.0, x + length / 2.0),
                    _ => (x, x + length),
                };
                assert!(from >= 0.0 && to <= width, "{text}");
            }
        }
        assert_eq!(cuts, 4, "all but the histogram show the cut");
        let page = rendered(&flight);
        assert_eq!(page.matches("<div class=\"narrow\">").count(), 5);
        assert!(
            !page.contains("min-width: 860px"),
            "nothing may force the pictures to be wider than the page"
        );
    }
}
