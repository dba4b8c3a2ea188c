//! The session of `docs/bench.md` on an emulated board: an adapter on the nominal bus of a slave that is alone.
//!
//! In the blocks `text session` of the page, a line `$ cansend can0 ID#DATA` is sent, `$ while cansend can0 ID#DATA; do sleep 0.1; done &`
//! is sent each 100 ms from then on. A line of candump has to appear after the one before it; `..` is any byte. The lines of the block
//! `text log` have to appear in the log, in their order.

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

const PAGE: &str = include_str!("../../../../docs/bench.md");

/// Longest time from a line of the session to the frame of the next one.
const PATIENCE: Time = ms(2_500);

/// Time between two frames of the loop.
const LOOP: Time = ms(100);

/// A line of candump: identifier and bytes, `None` for any byte.
#[derive(Debug)]
struct Line {
    id: u16,
    data: Vec<Option<u8>>,
}

impl Line {
    /// `can0  702   [1]  7F`
    fn read(text: &str) -> Line {
        let mut words = text.split_whitespace().skip(1);
        let id = u16::from_str_radix(words.next().expect("an identifier"), 16).expect("hexadecimal");
        let length = words.next().expect("a length");
        let data: Vec<_> = words.map(|byte| u8::from_str_radix(byte, 16).ok()).collect();
        assert_eq!(length, format!("[{}]", data.len()), "{text}");
        Line { id, data }
    }

    fn is(&self, seen: &Seen) -> bool {
        let matches = |(wanted, found): (&Option<u8>, &u8)| wanted.is_none_or(|wanted| wanted == *found);
        seen.bus == Bus::Nominal
            && seen.id() == Some(self.id)
            && seen.data().len() == self.data.len()
            && self.data.iter().zip(seen.data()).all(matches)
    }
}

/// The frame of `ID#DATA`.
fn frame(text: &str) -> WireFrame {
    let (id, data) = text.split_once('#').expect("ID#DATA");
    let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).expect("hexadecimal");
    let data: Vec<u8> = (0..data.len()).step_by(2).map(byte).collect();
    WireFrame::standard(u16::from_str_radix(id, 16).expect("hexadecimal"), &data)
}

/// The lines of all blocks of code with this information, of all of them together.
fn lines(info: &str) -> Vec<String> {
    let (mut lines, mut is_wanted) = (Vec::new(), false);
    for event in Parser::new(PAGE) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(found))) => is_wanted = *found == *info,
            Event::Text(text) if is_wanted => lines.extend(text.lines().map(str::to_owned)),
            Event::End(TagEnd::CodeBlock) => is_wanted = false,
            _ => {}
        }
    }
    lines
}

/// The slave, the adapter, and a second one for the loop.
struct Bench {
    flight: Flight,
    adapter: GuestId,
    looping: GuestId,
    /// Frame of the loop, and the instant of the next one.
    repeated: Option<(WireFrame, Time)>,
}

impl Bench {
    fn new() -> Bench {
        let setup = BoardSetup { power_on_ms: 0, ..MASTER_AND_THREE[1] };
        let mut flight = Flight::with(&[setup], &STANDARD);
        let [adapter, looping] = [30.0, 30.1].map(|at| flight.twin.add_guest(Bus::Nominal, at));
        Bench { flight, adapter, looping, repeated: None }
    }

    /// Runs until a frame after `from` is that of the line, and returns its end.
    fn wait_for(&mut self, line: &Line, from: Time) -> Time {
        let deadline = self.flight.end + PATIENCE;
        loop {
            if let Some(seen) = self.flight.first_after(from, |seen| line.is(seen)) {
                return seen.end;
            }
            let since: Vec<_> = self.flight.on(Bus::Nominal).filter(|seen| seen.end > from).collect();
            assert!(self.flight.end < deadline, "{line:?} is not among {since:?}\n{}", self.flight.log(2));
            if let Some((frame, at)) = self.repeated.filter(|(_, at)| *at <= self.flight.end) {
                self.flight.twin.inject(self.looping, at, frame);
                self.repeated = Some((frame, at + LOOP));
            }
            self.flight.fly(self.flight.end + ms(1));
        }
    }
}

/// Given the page, when its frames are sent to an emulated slave, then the frames and the log of the page are seen.
#[test]
fn session_of_the_bench_page_is_what_a_slave_does() {
    let mut bench = Bench::new();
    let mut last = Time::ZERO;
    let session = lines("text session");
    assert!(session.len() > 20, "{session:?}");
    for line in &session {
        let now = bench.flight.end;
        match line.strip_prefix("$ ") {
            None => last = bench.wait_for(&Line::read(line), last),
            Some(command) => {
                let words: Vec<&str> = command.split([' ', ';']).collect();
                let at = words.iter().position(|word| *word == "can0").expect("cansend can0");
                let frame = frame(words[at + 1]);
                match words[0] {
                    "while" => bench.repeated = Some((frame, now)),
                    _ => bench.flight.twin.inject(bench.adapter, now, frame),
                }
            }
        }
    }
    let mut said = bench.flight.logs.iter().map(|log| log.text.as_str());
    for line in lines("text log") {
        let text = line.split_once(' ').expect("level and text").1.trim();
        assert!(
            said.any(|found| found == text),
            "{text} is not in the log, or not there:\n{}",
            bench.flight.log(2)
        );
    }
    bench.flight.assert_sound();
}
