//! Waveforms of the documentation, taken from a simulated bus.

use anyhow::Context;
use can_twin::wire::bus::WireConfig;
use can_twin::wire::fault::{Fault, Flip, Nodes, Place};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use ecss_can_cli::fly::drawing::waveform::{Options, draw};

/// Time of SOF of the first frame.
const SOF: Time = Time::from_us(20);
/// Positions along a cable of 40 m.
const POSITIONS: [f64; 3] = [0.0, 25.0, 40.0];
const NAMES: [&str; 3] = ["master", "slave 2", "slave 3"];
/// Delay of isolation and transceiver, out and in.
const TRANSCEIVER_NS: u32 = 150;

/// One picture: its file in `docs/` and its traffic.
struct Scene {
    file: &'static str,
    title: &'static str,
    /// Senders, as indices of [`NAMES`], and their frames. All start at [`SOF`].
    frames: Vec<(usize, WireFrame)>,
    fault: Option<Fault>,
    /// Bit times from SOF to the end of the picture, which begins 3 µs before SOF.
    bits: u64,
    /// Width of a bit.
    bit_width: f64,
}

fn scenes() -> [Scene; 3] {
    let heartbeat = |slave: u16| WireFrame::standard(0x700 + slave, &[0x05]);
    [
        Scene {
            file: "waveform-frame.svg",
            title: "A command to slave 2 on 40 m of cable at 1 Mbit/s: code 0002h, value 41, sequence 41; stuff bits, propagation delay, acknowledgement",
            frames: vec![(0, WireFrame::standard(0x302, &[0x02, 0x00, 0x29, 0, 0, 0, 0, 0x29]))],
            fault: None,
            bits: 124,
            bit_width: 12.0,
        },
        Scene {
            file: "waveform-error.svg",
            title: "SYNC with one bit disturbed at slave 3: its error flag makes the others see an error too, and the master repeats the frame",
            frames: vec![(0, WireFrame::standard(0x080, &[]))],
            fault: Some(Fault::Flip(Flip::new(Place::Bit(16), Nodes::of(&[2])))),
            bits: 98,
            bit_width: 12.0,
        },
        Scene {
            file: "waveform-arbitration.svg",
            title: "Two slaves send their heartbeats at the same time: 702h beats 703h, which follows after the intermission",
            frames: vec![(1, heartbeat(2)), (2, heartbeat(3))],
            fault: None,
            bits: 80,
            bit_width: 14.0,
        },
    ]
}

impl Scene {
    fn render(&self) -> anyhow::Result<String> {
        let config = WireConfig { transceiver_ns: TRANSCEIVER_NS, ..WireConfig::default() };
        let mut bench = Bench::new(
            config,
            POSITIONS.iter().map(|&position_m| (position_m, Station::default())).collect(),
        );
        for &(node, frame) in &self.frames {
            bench.stations[node].queue.push_back((SOF, frame));
        }
        if let Some(fault) = self.fault {
            bench.wire.schedule(Time::ZERO, fault)?;
        }
        let to = SOF + Time::from_us(self.bits);
        bench.wire.record_waveform(SOF - Time::from_us(3), to);
        bench.leap(to);
        let waveform = bench.wire.take_waveform().context("the span of the waveform is over")?;
        let options = Options { title: self.title, names: &NAMES, bit_width: self.bit_width };
        Ok(draw(&waveform, options).standalone())
    }
}

/// Returns names and contents of all pictures.
pub fn pictures() -> anyhow::Result<Vec<(&'static str, String)>> {
    scenes().iter().map(|scene| Ok((scene.file, scene.render()?))).collect()
}
