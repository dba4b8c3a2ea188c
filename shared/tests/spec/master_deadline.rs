//! The deadline of a master, whatever it hears: before it nothing is to be done. The bench checks that after each event.

use ecss_can::node::Node;
use ecss_can::types::Bus;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, span};
use crate::console;
use crate::instrument::STANDARD;
use crate::random::cases;

/// What happens.
#[derive(Clone, Debug)]
enum Step {
    Wait {
        time: u64,
    },
    Heartbeat {
        bus: Bus,
        node: u16,
        state: u8,
    },
    Answer {
        node: u16,
    },
    Telemetry {
        bus: Bus,
        node: u16,
    },
    Rival {
        bus: Bus,
    },
    /// The bus took the last frame that was sent.
    Sent,
}

fn step() -> impl Strategy<Value = Step> {
    let bus = || prop_oneof![Just(NOMINAL), Just(REDUNDANT)];
    let node = || 2..10_u16;
    prop_oneof![
        4 => (1..400_u64).prop_map(|time| Step::Wait { time }),
        8 => (bus(), node(), prop_oneof![Just(0), Just(4), Just(5), Just(0x7F)])
            .prop_map(|(bus, node, state)| Step::Heartbeat { bus, node, state }),
        2 => node().prop_map(|node| Step::Answer { node }),
        2 => (bus(), node()).prop_map(|(bus, node)| Step::Telemetry { bus, node }),
        1 => bus().prop_map(|bus| Step::Rival { bus }),
        4 => Just(Step::Sent),
    ]
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn before_its_deadline_a_master_has_nothing_to_do(steps in vec(step(), 1..120)) {
        let mut master = Bench::new(console::master(&STANDARD));
        for step in steps {
            match step {
                Step::Wait { time } => master.run_until(master.now + span(time)),
                Step::Heartbeat { bus, node, state } => master.receive(bus, 0x700 + node, &[state]),
                Step::Answer { node } => master.receive(NOMINAL, 0x580 + node, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]),
                Step::Telemetry { bus, node } => master.receive(bus, 0x380 + node, &[1, 0, 0, 0, 0, 0, 0, 0]),
                Step::Rival { bus } => master.receive(bus, 0x701, &[5]),
                Step::Sent => {
                    if let Some(sent) = master.sent.pop() {
                        master.transmitted(sent.bus, sent.frame);
                    }
                }
            }
        }
    }
}

/// Given slaves that count and are in order, When their heartbeats go on, Then none of them makes anything due.
#[test]
fn heartbeats_in_order_leave_the_deadline_alone() {
    let mut master = Bench::new(console::master(&STANDARD));
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    for node in [2, 3, 4] {
        master.receive(NOMINAL, 0x700 + node, &[5]);
        master.receive(NOMINAL, 0x580 + node, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
    for at in (5..=1_005).step_by(50) {
        master.run_until(ms(at));
        let due = master.node.deadline();
        for node in [2, 3, 4] {
            master.receive(NOMINAL, 0x700 + node, &[5]);
        }
        assert_eq!(master.node.deadline(), due, "{at} ms");
    }
}
