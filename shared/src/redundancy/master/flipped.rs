//! An active master whose memory has a flipped bit.

use super::{MasterAction, MasterRedundancy, MasterSetup, OneBoard, Sending};
use crate::link::access::BusAccess;
use crate::link::machine::Outgoing;
use crate::redundancy::Parameters;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState};

const STATES: [NmtState; 4] =
    [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational];

const PARAMETERS: Parameters = Parameters {
    consumer: Duration::from_millis(250),
    producer: Duration::from_millis(100),
    bdefault: Bus::Nominal,
    ttoggle: 2,
    ntoggle: Parameters::NO_LIMIT,
    ctoggle: 0,
};

/// An active master that has sent its first heartbeat.
fn active() -> MasterRedundancy {
    let setup = MasterSetup {
        parameters: PARAMETERS,
        silent_share: 50,
        dwell: Duration::from_millis(10_000),
        grace: Duration::from_millis(1),
        access: BusAccess::Parallel,
        lifetime: Duration::from_millis(100),
    };
    let mut master = MasterRedundancy::new(OneBoard, &setup);
    assert!(master.start(Instant::ZERO));
    master.boot_up(Instant::ZERO);
    while master.poll(Instant::ZERO, Instant::ZERO).is_some() {}
    master.on_sent(master.active(), CobId::new(0x701).unwrap(), Instant::ZERO);
    master
}

/// State in the next heartbeat, that by which services are allowed.
fn states(master: &mut MasterRedundancy) -> (u8, NmtState) {
    let now = master.deadline().unwrap();
    let Some(MasterAction::Heartbeat { frame, .. }) = master.poll(now, now) else { panic!("no heartbeat") };
    (frame.data()[0], master.state())
}

/// Given an active master in Operational, when any one of the copies of its NMT state is another state, then its heartbeats and its
/// services have Operational after the next comparison.
#[test]
fn a_flipped_nmt_state_of_a_master_is_corrected() {
    for copy in 0..3 {
        for state in STATES {
            let mut master = active();
            let written = *master.parameters();
            assert!(!master.refresh(written, Instant::ZERO));
            match copy {
                0 => *master.nmt.state_mut() = state,
                1 => *master.manager.state_mut() = state,
                _ => master.state = state,
            }
            let is_other = state != NmtState::Operational;
            assert_eq!(master.refresh(written, Instant::ZERO), is_other, "copy {copy}: {state:?}");
            assert_eq!(states(&mut master), (5, NmtState::Operational), "copy {copy}: {state:?}");
            let outgoing =
                Outgoing { frame: Frame::of(CobId::new(0x302).unwrap(), []), expires: Instant::NEVER };
            assert!(matches!(master.send(outgoing), Sending::Now(_)));
        }
    }
}

/// Given an active master, when any bit of the parameters in use flips, then they are those of the dictionary after the next
/// comparison, and the heartbeats have their period.
#[test]
fn a_flipped_parameter_of_a_master_is_corrected() {
    for bit in 0..3 * 40 {
        let mut master = active();
        let (now, written) = (Instant::from_micros(1_000), *master.parameters());
        let mut flipped = written;
        let inverted = |span: Duration| Duration::from_micros(span.as_micros() ^ 1 << (bit % 40));
        match bit / 40 {
            0 => flipped.consumer = inverted(written.consumer),
            1 => flipped.producer = inverted(written.producer),
            _ => flipped.ttoggle ^= 1 << (bit % 8),
        }
        master.configure(flipped, now);
        assert!(master.refresh(written, now), "bit {bit}");
        assert_eq!(*master.parameters(), written, "bit {bit}");
        assert_eq!(master.manager.deadline().map(|due| due <= now + written.producer), Some(true));
    }
}
