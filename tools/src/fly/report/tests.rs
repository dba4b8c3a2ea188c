use can_twin::wire::time::Time;

use super::*;
use crate::fly::curves::ValueCurve;
use crate::fly::drawing::Picture;
use crate::fly::pdos::{SheetName, Sheets};
use crate::fly::sample;
use crate::fly::verdict::{Outcome, Verdict};

fn rendered(flight: &Flight) -> String {
    page(flight, &[], &sample::summary(flight))
}

/// Checks that a page has some texts and others not.
fn assert_page(page: &str, expected: &[&str], forbidden: &[&str]) {
    expected.iter().for_each(|part| assert!(page.contains(part), "no {part:?}"));
    forbidden.iter().for_each(|part| assert!(!page.contains(part), "{part:?}"));
}

/// Given a flight, then the page reports it and needs no other file.
#[test]
fn the_page_reports_the_flight() {
    let expected = [
        "ran as it should",
        "2 of 2",
        "cut next to the master, 20.0 s",
        "master switches, 600.0 ms after the cut",
        "605.0 ms",
        "12.41 s",
        "node 4: pre-operational on the nominal bus, 22.3000 s to 32.3500 s",
        "heartbeat moved to the redundant bus",
    ];
    let others = ["src=", "href=", "url(", "@import", "<script"];
    assert_page(&rendered(&sample::flight()), &expected, &others);
}

/// Given aborted frames, a clock that is not judged and a value of an own slave, then the page has a section for each.
#[test]
fn page_has_aborted_frames_causes_and_curves() {
    let flight = sample::flight();
    let mut summary = sample::summary(&flight);
    let name = |file: &str, device| SheetName { file: file.into(), device };
    summary.data_sheets =
        [(1, name("master.eds", None)), (2, name("heater.eds", Some("Heater".into())))].into();
    let curve = ValueCurve {
        node: 2,
        cob_id: "382h".into(),
        name: "Temperature [K]".into(),
        points: vec![(Time::from_ms(1_000), 280.5), (Time::from_ms(2_000), 281.5)],
    };
    let expected = [
        "<h2>Aborted frames</h2>",
        "<td data-label=\"COB-ID\">701h</td><td data-label=\"frames\">2</td><td data-label=\"failed\">2</td>",
        "The clock of node 4 is not judged: it received no spacecraft time (181h).",
        "<b>node 2: Temperature [K]</b> <span>382h</span>",
        "<td>heater.eds</td><td>Heater</td><td>node 2</td>",
    ];
    summary.pdo_values = Sheets::of(&flight.plan, &[]).expect("the shipped sheets").values(&flight);
    assert_page(&page(&flight, &[curve], &summary), &expected, &[]);
}

#[test]
fn a_page_of_unknown_images_has_no_commands() {
    let mut flight = sample::flight();
    flight.plan.boards[1].own_image = Some("heater".into());
    let expected = [
        "(node 2: heater)",
        "neither read nor judged",
        "PDOs, slaves",
        "800.0 ms",
        "2.25 %",
        "profile librecube",
    ];
    let commands = ["commands executed", "telemetry replies", "TM reply", "TC due"];
    assert_page(&rendered(&flight), &expected, &commands);
}

#[test]
fn faults_are_on_top_and_escaped() {
    let flight = sample::flight();
    let mut summary = sample::summary(&flight);
    summary.verdict = Verdict { outcome: Outcome::Failed, reasons: vec!["node 2 <panicked>".into()] };
    let page = page(&flight, &[], &summary);
    assert_page(&page, &["<li>node 2 &lt;panicked&gt;</li>"], &["ran as it should"]);
}

#[test]
fn the_timeline_stands_alone() {
    let picture = timeline(&sample::flight());
    let first = picture.lines().next().expect("a line");
    assert!(first.starts_with("<svg ") && first.contains(" xmlns=\"http://www.w3.org/2000/svg\""), "{first}");
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
    let tags = [("<rect", "fill"), ("<text", "fill"), ("<line", "stroke"), ("<path", "stroke")];
    let painted = |line: &'_ str| tags.iter().find(|(tag, _)| line.starts_with(tag)).map(|(_, paint)| *paint);
    let drawn: Vec<(&str, &str)> = body.lines().filter_map(|line| Some((line, painted(line)?))).collect();
    assert!(drawn.len() > 40, "{}", drawn.len());
    for (element, paint) in &drawn {
        assert!(element.contains(&format!(" {paint}=\"#")), "{element}");
    }
    let paths = drawn.iter().map(|(element, _)| element).filter(|element| element.starts_with("<path"));
    assert!(paths.clone().count() > 8 && paths.clone().all(|path| path.contains(" fill=\"none\"")));
}

/// Given a flight of two masters, then the page names all faults, stretches cut and takeover, and shows the roles of both boards.
#[test]
fn page_of_two_masters_shows_faults_and_roles() {
    let expected = [
        "At 5 s master 2, the standby, was reset. At 10 s the nominal bus was cut between the slaves. At 20 s master, the active \
         one, lost its power; master 2 took over 399.0 ms after its last heartbeat.",
        "<h2>Around the cut</h2>",
        "<h2>Around the takeover</h2>",
        "cut between the slaves, 10.0 s",
        "master switches, 1201.0 ms after the cut",
        "master 2 takes over, 399.0 ms after the last heartbeat",
        "master: active on the nominal bus, 0.9010 s to 11.2010 s",
        "master: off, 20.0000 s to 40.0000 s",
        "master 2: starting on the nominal bus, 5.0000 s to 5.0010 s",
        "master 2: standby on the redundant bus, 11.2010 s to 20.3000 s",
        "master 2: active on the redundant bus, 20.3010 s to 40.0000 s",
        "<th>takeover</th>",
        "<td>claims, master</td>",
    ];
    assert_page(&rendered(&sample::standby::flight()), &expected, &["without a known meaning"]);
    let of_two = ["Around the takeover", "takeover</th>", "claims"];
    assert_page(&rendered(&sample::flight()), &[], &of_two);
}

/// Pictures of a flight for narrow pages.
fn narrow(flight: &Flight) -> Vec<String> {
    let close_ups = [Since::Cut, Since::Loss].map(|since| timeline::close_up(flight, since, Layout::NARROW));
    let mut pictures: Vec<Picture> = close_ups.into_iter().flatten().collect();
    pictures.push(timeline::overview(flight, Layout::NARROW));
    pictures.push(states::draw(flight, Layout::NARROW));
    pictures.push(clocks::draw(flight, Layout::NARROW));
    pictures.extend(clocks::histogram(flight, Layout::NARROW));
    pictures.iter().map(|picture| picture.inline()).collect()
}

fn number(element: &str, name: &str) -> Option<f64> {
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    rest.split_once('"')?.0.parse().ok()
}

/// Returns left and right end of a text with letters of width `letter`, and its height.
fn place(text: &str, letter: f64) -> (f64, f64, f64) {
    let words = text.split(['<', '>']).nth(2).expect("words");
    let (x, y) = (number(text, "x").expect("a place"), number(text, "y").expect("a height"));
    let length = letter * words.len() as f64;
    match text {
        text if text.contains("\"end\"") => (x - length, x, y),
        text if text.contains("\"middle\"") => (x - length / 2.0, x + length / 2.0, y),
        _ => (x, x + length, y),
    }
}

/// Given a page of 400 px, Then the pictures for narrow pages fit into it, with the cut and all letters.
#[test]
fn narrow_pictures_fit_a_page_of_400_px() {
    for (flight, pictures, cuts) in [(sample::flight(), 5, 4), (sample::standby::flight(), 6, 10)] {
        let narrow = narrow(&flight);
        assert_eq!(narrow.len(), pictures);
        let mut seen = 0;
        for picture in narrow {
            let width = number(&picture, "width").expect("a width");
            assert!(width <= 400.0, "{width}");
            for cut in picture.lines().filter(|line| line.contains("class=\"cut\"")) {
                let cut = number(cut, "x1").expect("a place");
                assert!((82.0..width).contains(&cut), "{cut}");
                seen += 1;
            }
            for text in picture.lines().filter(|line| line.starts_with("<text")) {
                // The narrowest letters of a reader's font.
                let (from, to, _) = place(text, 5.5);
                assert!(from >= 0.0 && to <= width, "{text}");
            }
        }
        assert_eq!(seen, cuts, "all but the histogram show the faults");
        let page = rendered(&flight);
        assert_eq!(page.matches("<div class=\"narrow\">").count(), pictures);
        let is_forced = page.contains("min-width: 860px");
        assert!(!is_forced, "nothing may force the pictures to be wider than the page");
    }
}

/// Given a flight with three faults, then no label of a fault overlaps another one or the title of a lane, at the default length and
/// with the faults close together.
#[test]
fn labels_of_faults_do_not_overlap() {
    let mut short = sample::standby::flight();
    short.end = Time::from_ms(400_000);
    for flight in [sample::standby::flight(), short] {
        for picture in narrow(&flight) {
            let labels =
                picture.lines().filter(|line| line.contains("-label") || line.contains("class=\"bus-"));
            let places: Vec<_> = labels.map(|text| (place(text, 7.4), text)).collect();
            for (index, ((left, right, y), text)) in places.iter().enumerate() {
                let mut others = places[..index].iter().filter(|((.., other), _)| other == y);
                let other = others.find(|((from, to, _), _)| from < right && left < to);
                assert!(other.is_none(), "{text} overlaps {other:?}");
            }
        }
    }
}
