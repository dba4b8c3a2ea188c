//! The minimal slave on a computer: its application in a mock spacecraft, commanded by a plain master, beside a plain slave.

use std::process::ExitCode;

use ecss_can::node::minimal::MinimalSlave;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::NodeId;
use mission::application::minimal::Application;
use mission::minimal::Shipped;
use mission::{PROFILE, host};

const NODE: NodeId = NodeId::of::<6>();

/// A slave with an SDO server: the master chooses its bus by such slaves only.
const SLAVE: NodeId = NodeId::of::<2>();

/// The profile of the mission, in which the node is a minimal slave.
const WITH_MINIMAL: &Profile =
    &Profile { minimal: &[MinimalNode { node: NODE, has_heartbeat: true }], ..*PROFILE };

/// Runs the application with the options of the command line.
pub fn run() -> ExitCode {
    host::run(
        "Run the application of the minimal slave, node 6, beside a plain master and a plain slave on mock buses",
        |spacecraft, console| {
            host::master(spacecraft, WITH_MINIMAL, NODE, console);
            host::slave(spacecraft, WITH_MINIMAL, SLAVE);
            let slave = MinimalSlave::builder(NODE, WITH_MINIMAL, Shipped::new());
            let (slave, events) = spacecraft.power_on(|| slave.build());
            spacecraft.spawn(Application::new(slave, events, host::PrintedIndicators::new(console)).run());
        },
    )
}
