//! What a master reads of the errors that it may not have heard.

use async_canopen::emcy::machine::{ActiveErrors, ErrorReader, ReadOutcome};
use async_canopen::types::{Address, Duration, Instant, NodeId};

const NODE: NodeId = NodeId::of::<5>();
const TIMEOUT: Duration = Duration::from_millis(100);
/// Between two looks at the register.
const PERIOD: Duration = Duration::from_millis(10_000);
const REGISTER: Address = Address::new(0x1001, 0);

fn at(ms: u64) -> Instant {
    Instant::from_micros(ms * 1_000)
}

/// The questions of the first two seconds, each answered so: when, and what is read.
fn questions(
    reader: &mut ErrorReader,
    errors: &mut ActiveErrors,
    answer: impl Fn(Address) -> ReadOutcome,
) -> Vec<(u64, Address)> {
    let (mut now, mut asked) = (at(0), vec![]);
    while let Some(due) = reader.deadline().filter(|due| *due < at(2_000)) {
        now = now.max(due);
        let Some((node, object)) = reader.question(errors, |_| true, now) else { break };
        assert_eq!(node, NODE);
        asked.push((now.since(at(0)).as_millis(), object));
        assert!(asked.len() < 100, "without end");
        reader.on_answer(answer(object), errors, TIMEOUT, now);
    }
    asked
}

/// Given a node that does not answer, then it is asked three times, with a pause for others, and left alone until it boots.
///
/// Verifies: ECSS 5.3.3.2.2a
/// Notices: ECSS 5.3.3.2.2a: a slave that left the bus is asked for ever, and the others are not.
#[test]
fn a_question_without_an_answer_is_asked_three_times() {
    let (mut reader, mut errors) = (ErrorReader::new(PERIOD), ActiveErrors::default());
    reader.on_heard(NODE, false, at(0));
    let asked = questions(&mut reader, &mut errors, |_| ReadOutcome::Missing);
    assert_eq!(asked, [0, 100, 200].map(|ms| (ms, REGISTER)));
    reader.on_heard(NODE, false, at(0));
    assert_eq!(reader.deadline(), Some(at(10_000)), "with all others");
    reader.on_heard(NODE, true, at(250));
    assert_eq!(reader.deadline(), Some(at(300)));
}

/// Given a register that the known errors do not explain, then the history is read until it is explained, and the register
/// once more a second later.
#[test]
fn the_history_is_read_until_the_register_is_explained() {
    let (mut reader, mut errors) = (ErrorReader::new(PERIOD), ActiveErrors::default());
    reader.on_heard(NODE, false, at(0));
    let history = |sub| Address::new(0x1003, sub);
    let asked = questions(&mut reader, &mut errors, |object| {
        ReadOutcome::Value(match (object.index, object.sub) {
            (0x1001, _) => 0x09,
            (_, 0) => 8,
            // A voltage, which is over, then two temperatures of the same class.
            (_, 1) => 0x0001_3100,
            (_, sub) => 0x0000_4200 | u32::from(sub) << 16,
        })
    });
    let first = [REGISTER, history(0), history(1), history(2)].map(|object| (0, object));
    assert_eq!(asked, [&first[..], &[(1_000, REGISTER)]].concat());
    let sources: Vec<_> = errors.iter().map(|error| (error.code.get(), error.source)).collect();
    assert_eq!(sources, [(0x4200, 2)]);
}

/// Given a slave whose register changes without a message, then the master knows it within a period. A slave that is lost is
/// not asked.
#[test]
fn each_node_is_asked_once_in_a_period() {
    let (mut reader, mut errors) = (ErrorReader::new(PERIOD), ActiveErrors::default());
    reader.on_heard(NODE, false, at(5));
    let mut asked = vec![];
    while let Some(due) = reader.deadline().filter(|due| *due < at(35_000)) {
        let Some((_, object)) = reader.question(&errors, |_| true, due) else { break };
        asked.push((due.since(at(0)).as_millis(), object));
        reader.on_answer(ReadOutcome::Value(0), &mut errors, TIMEOUT, due);
    }
    assert_eq!(asked, [0, 10_005, 20_005, 30_005].map(|ms| (ms, REGISTER)));
    reader.lose(NODE);
    assert_eq!(reader.question(&errors, |_| true, at(40_005)), None);
    assert_eq!(reader.deadline(), Some(at(50_005)), "no busy loop");
    reader.on_heard(NODE, false, at(41_000));
    assert_eq!(reader.question(&errors, |_| true, at(41_000)), Some((NODE, REGISTER)));
}
