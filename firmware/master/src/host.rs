//! The master on a computer: its application in a mock spacecraft, with three plain slaves.

use std::process::ExitCode;

use ecss_can::types::NodeId;
use mission::application::master::{Application, Cables};
use mission::{PROFILE, host};

const SLAVES: [NodeId; 3] = [NodeId::of::<2>(), NodeId::of::<3>(), NodeId::of::<4>()];

/// Runs the application with the options of the command line.
pub fn run() -> ExitCode {
    host::run(
        "Run the application of the master beside three plain slaves on mock buses",
        |spacecraft, console| {
            let (master, events) = spacecraft.power_on(|| mission::master(PROFILE).build());
            for id in SLAVES {
                host::slave(spacecraft, PROFILE, id);
            }
            let cables: &'static Cables = Box::leak(Box::new(Cables::new()));
            spacecraft.spawn(cables.run(master));
            let indicators = host::PrintedIndicators::new(console);
            spacecraft.spawn(Application::new(master, events, indicators, cables, PROFILE.minimal).run());
        },
    )
}
