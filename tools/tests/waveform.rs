//! Pictures of waveforms that a simulated bus recorded.

use can_twin::wire::fault::{Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use can_twin::wire::waveform::{Bit, Waveform};
use ecss_can_cli::fly::drawing::waveform::{Options, draw};
use svg::parser::Event;

/// SYNC of node 0 at 20 us, whose stuff bit at 16 is flipped at node 2: three error flags, and a second attempt.
fn disturbed() -> Waveform {
    let sender = Station::default().sending(Time::from_us(20), WireFrame::standard(0x080, &[]));
    let mut bench = Bench::together(vec![sender, Station::default(), Station::default()]);
    let flip = Fault::Flip(Flip::new(Place::Bit(16), Nodes::of(&[2])));
    bench.wire.schedule(Time::ZERO, flip).unwrap();
    bench.wire.record_waveform(Time::from_us(15), Time::from_us(115));
    bench.leap(Time::from_us(115));
    bench.wire.take_waveform().unwrap()
}

/// Elements of the picture by class, and its texts.
fn contents(picture: &str) -> (Vec<String>, Vec<String>) {
    let (mut classes, mut texts) = (Vec::new(), Vec::new());
    for event in svg::read(picture).unwrap() {
        match event {
            Event::Tag(_, _, attributes) => classes.extend(attributes.get("class").map(ToString::to_string)),
            Event::Text(words) => texts.push(words.to_owned()),
            Event::Error(error) => panic!("{error}"),
            _ => {}
        }
    }
    (classes, texts)
}

#[test]
fn a_picture_shows_every_bit_and_what_happened() {
    let waveform = disturbed();
    let options = Options { title: "before < after & more", names: &["sender"], ..Options::default() };
    let (classes, texts) = contents(&draw(&waveform, options).standalone());
    let count = |class: &str| classes.iter().filter(|&has| has == class).count();
    let all = |is: fn(&Bit) -> bool| {
        waveform.lanes.iter().flat_map(|lane| &lane.bits).filter(|&bit| is(bit)).count()
    };
    // The legend contains each mark once in addition.
    assert_eq!(count("sample"), all(|_| true) + 1);
    assert_eq!(count("stuff"), all(|bit| bit.field == Field::Stuff) + 1);
    assert_eq!(count("flip"), 1 + 1);
    assert_eq!((count("band flag"), count("band superposition"), count("band ack")), (3, 1, 3));
    for words in [
        "before &lt; after &amp; more",
        "sender",
        "node 2",
        "identifier 080h",
        "DLC 0",
        "end of frame",
        "flipped: reads 0",
        "bit error: sent 1, saw 0, TEC 8",
        "stuff error, REC 1",
        "REC 9",
        "sent, TEC 7",
    ] {
        assert!(texts.iter().any(|text| text == words), "{words}: {texts:?}");
    }
}

/// A long span is drawn with narrow bits, without digits.
#[test]
fn narrow_bits_have_no_digits() {
    let options = Options { bit_width: 3.0, ..Options::default() };
    let (classes, _) = contents(&draw(&disturbed(), options).standalone());
    assert!(!classes.iter().any(|class| class.starts_with("digit")));
    assert!(classes.iter().any(|class| class == "band crc"));
}
