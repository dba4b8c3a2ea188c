//! The report of a flight: one HTML file that needs nothing else.

mod axis;
mod paint;
mod states;
mod svg;
mod tables;
mod timeline;

use super::flight::Flight;
use super::record::Bus;
use super::summary::Summary;
use super::verdict::{Outcome, Verdict};
use axis::Layout;
use svg::{Svg, escape};

const PAGE_STYLE: &str = include_str!("page.css");

/// The bus timeline as a picture of its own.
pub fn timeline(flight: &Flight) -> String {
    timeline::overview(flight, Layout::WIDE).standalone()
}

/// The whole page.
pub fn page(flight: &Flight, summary: &Summary) -> String {
    let sections = [
        section(
            "The two buses",
            "Every frame that completed is a tick in the row of its kind. The shaded stretch is the bus on which the \
             master sends its heartbeat: that is what makes a bus the active one.",
            &both(|layout| timeline::overview(flight, layout)),
        ),
        timeline::close_up(flight, Layout::WIDE).map_or(String::new(), |wide| {
            let narrow = timeline::close_up(flight, Layout::NARROW);
            section(
                "Around the cut",
                "The same, stretched. After the cut nobody acknowledges the master, so none of its frames completes \
                 until it moves to the other bus and takes the slaves with parallel access along.",
                &each(&wide, narrow.as_ref()),
            )
        }),
        section(
            "What every node did",
            "As the wires tell it: heartbeats and commands that reached the node, not its own memory. The thin line \
             below a bar is the bus it works on. Point at a bar for its times.",
            &(both(|layout| states::draw(flight, layout)) + &states_key()),
        ),
        format!(
            "<div class=\"columns\">\n{}{}</div>\n",
            section("Fail-over", FAILOVER_HELP, &tables::failover(flight)),
            section("Frames", "Completed frames per bus.", &tables::frames(flight)),
        ),
        section("Boards", BOARDS_HELP, &tables::boards(flight)),
        story(flight),
        section("How to read this", "", HOW_TO_READ),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>A flight on two CAN buses</title>\n<style>\n{PAGE_STYLE}{}</style>\n</head>\n<body>\n<main>\n\
         {}{}{}<footer>{}</footer>\n</main>\n</body>\n</html>\n",
        paint::dark(),
        header(flight, summary),
        tiles(summary),
        sections.concat(),
        footer(summary),
    )
}

const FAILOVER_HELP: &str = "From the cut until the slave was commanded, or answered, on the other bus.";

const BOARDS_HELP: &str = "Crystal, place and power-on time come from the seed. Due are the commands that completed \
    while the slave was operational on that bus, by the observer's model; executed is the slave's own count.";

const HOW_TO_READ: &str = "<p>All times are virtual: the boards are emulated, the same seed gives the same flight. \
    Each board runs the real firmware image; each bus carries real bit timing, arbitration and acknowledgement.</p>\n\
    <p><b>Parallel access</b>: both controllers of the slave are live, it follows the master's first message on the \
    other bus and stays operational. <b>Selective access</b>: the slave hears one bus at a time; it misses the \
    master's heartbeat for one consumer time (2.5 s), becomes pre-operational, and changes to the other bus after \
    Ttoggle = 5 consumer times (12.5 s after the last heartbeat). The master then starts it unasked.</p>\n\
    <p>The logs beside this file hold every frame: <code>bus-nominal.log</code> and <code>bus-redundant.log</code> for \
    can-utils, <code>spacecraft.pcapng</code> for Wireshark, <code>summary.json</code> for programs.</p>\n";

fn header(flight: &Flight, summary: &Summary) -> String {
    let Verdict { outcome, reasons } = &summary.verdict;
    let (class, verdict) = match outcome {
        Outcome::Passed => ("good", "flew as it should"),
        Outcome::Failed => ("bad", "failed"),
        Outcome::Interrupted => ("bad", "interrupted"),
    };
    let cut = flight.cut().map_or("No bus was cut.".into(), |(at, bus)| {
        format!("At {} s the {} bus was cut next to the master.", at.as_secs_f64(), bus.name())
    });
    let faults = match reasons.as_slice() {
        [] => String::new(),
        reasons => {
            let items: String =
                reasons.iter().map(|reason| format!("<li>{}</li>\n", escape(reason))).collect();
            format!("<ul class=\"faults\">\n{items}</ul>\n")
        }
    };
    format!(
        "<header><h1>A flight on two CAN buses</h1><span class=\"verdict {class}\">{verdict}</span></header>\n\
         <p class=\"lead\">One master and {} slaves ({}, profile {}, seed {}) flew {:.0} s of virtual time. {cut}</p>\n\
         {faults}",
        summary.boards - 1,
        summary.board,
        summary.profile,
        summary.seed,
        summary.virtual_seconds,
    )
}

fn tiles(summary: &Summary) -> String {
    let slaves = summary.boards - 1;
    let fastest = summary.failover_ms.values().flatten().copied().reduce(f64::min);
    let slowest = summary.failover_ms.values().flatten().copied().reduce(f64::max);
    let mut tiles = vec![
        (
            format!("{} of {slaves}", summary.slaves_operational_at_end),
            "slaves operational at the end".into(),
        ),
        (summary.tc_executed.to_string(), format!("commands executed, {} due", summary.tc_due)),
        (summary.tm_received.to_string(), "telemetry replies received".into()),
    ];
    if let (Some(fastest), Some(slowest)) = (fastest, slowest) {
        tiles.push((duration(fastest), "fastest fail-over".into()));
        tiles.push((duration(slowest), "slowest fail-over".into()));
    }
    tiles.push((summary.lost_frames.to_string(), "frames lost".into()));
    let tiles: String = tiles
        .iter()
        .map(|(value, what)| format!("<div class=\"tile\"><b>{value}</b><span>{what}</span></div>\n"))
        .collect();
    format!("<div class=\"tiles\">\n{tiles}</div>\n")
}

/// A picture for wide pages and one for narrow ones; the style sheet shows one of them.
fn both(draw: impl Fn(Layout) -> Svg) -> String {
    each(&draw(Layout::WIDE), Some(&draw(Layout::NARROW)))
}

fn each(wide: &Svg, narrow: Option<&Svg>) -> String {
    let narrow = narrow.map_or(String::new(), Svg::inline);
    format!("<div class=\"wide\">{}</div>\n<div class=\"narrow\">{narrow}</div>\n", wide.inline())
}

fn section(title: &str, help: &str, body: &str) -> String {
    let help = if help.is_empty() { String::new() } else { format!("<p>{help}</p>\n") };
    format!("<section>\n<h2>{title}</h2>\n{help}{body}</section>\n")
}

fn states_key() -> String {
    let entries = [
        ("phase-off", "off"),
        ("phase-starting", "starting"),
        ("phase-pre-operational", "pre-operational"),
        ("phase-operational", "operational"),
        ("phase-stopped", "stopped"),
        ("on-nominal", "on the nominal bus"),
        ("on-redundant", "on the redundant bus"),
    ];
    let entries = entries.map(|(class, name)| {
        format!(
            "<span><svg class=\"chart\" viewBox=\"0 0 14 14\" aria-hidden=\"true\">\
             <rect {} width=\"14\" height=\"14\" rx=\"3\"/></svg>{name}</span>\n",
            paint::attributes(class)
        )
    });
    format!("<div class=\"key\">\n{}</div>\n", entries.concat())
}

fn story(flight: &Flight) -> String {
    let lines: String = flight
        .story
        .iter()
        .map(|line| {
            format!(
                "<span class=\"{:?}\">{:>10.4} s  {:<9}  {:<7}  {}</span>\n",
                line.tone,
                line.at.as_secs_f64(),
                line.bus.map_or("", Bus::name),
                line.who,
                escape(&line.text)
            )
        })
        .collect();
    format!(
        "<section><details>\n<summary>The story, line by line ({} lines)</summary>\n<div class=\"story\">{lines}</div>\n\
         </details></section>\n",
        flight.story.len()
    )
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
    fn the_page_tells_the_flight() {
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
        assert!(picture.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
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
        ];
        for picture in pictures.map(|picture| picture.inline()) {
            let width = number(&picture, "width").expect("a width");
            assert!(width <= 400.0, "{width}");
            let cut = picture.lines().find(|line| line.contains("class=\"cut\"")).expect("the cut is drawn");
            let cut = number(cut, "x1").expect("a place");
            assert!((82.0..width).contains(&cut), "{cut}");
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
        let page = rendered(&flight);
        assert_eq!(page.matches("<div class=\"narrow\">").count(), 3);
        assert!(
            !page.contains("min-width: 860px"),
            "nothing may force the pictures to be wider than the page"
        );
    }
}
