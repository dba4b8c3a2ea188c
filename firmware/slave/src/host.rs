//! The slave on a computer: its application in a mock spacecraft, commanded by a plain master.

use std::process::ExitCode;

use ecss_can::types::NodeId;
use mission::application::slave::Application;
use mission::{PROFILE, host};

const NODE: NodeId = NodeId::of::<2>();

/// Runs the application with the options of the command line.
pub fn run() -> ExitCode {
    host::run(
        "Run the application of the slave, node 2, beside a plain master on mock buses",
        |spacecraft, console| {
            host::master(spacecraft, PROFILE, NODE, console);
            let (slave, events) =
                spacecraft.power_on(|| mission::slave(NODE, PROFILE, host::memory()).build());
            spacecraft.spawn(Application::new(slave, events, host::PrintedIndicators::new(console)).run());
        },
    )
}
