//! Time of a node (ECSS 7.1, 7.2): what clients set and read, what PDOs bring and carry.

mod clients;
mod devices;
mod distribution;
mod doubt;
mod mapped;
mod masters;
mod producers;
mod universal;

use ecss_can::link::Stamp;
use ecss_can::node::SpacecraftDevice;
use ecss_can::node::extend::LinkEvent;
use ecss_can::types::{FineInstant, Instant, Scet};

use self::devices::Node;
use crate::bench::{NOMINAL, frame};

fn scet(coarse: u32, fine: u32) -> Scet {
    Scet::new(coarse, fine).unwrap()
}

fn us(us: u64) -> Instant {
    Instant::from_micros(us)
}

/// Runs to `until`, a heartbeat of the master every 100 ms.
fn run<D: SpacecraftDevice>(slave: &mut Node<D>, until: Instant) {
    while slave.now.as_micros() / 100_000 < until.as_micros() / 100_000 {
        let next = (slave.now.as_micros() / 100_000 + 1) * 100_000;
        slave.run_until(us(next));
        slave.receive(NOMINAL, 0x701, &[5]);
    }
    slave.run_until(until);
}

/// A SYNC that was stamped in hardware, units of 2^-8 us, and is handled now.
fn sync_at<D: SpacecraftDevice>(slave: &mut Node<D>, units: u64) {
    let stamp = Stamp::captured(FineInstant::from_units(units));
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x080, &[]), stamp });
}

/// A SYNC ended now.
fn sync<D: SpacecraftDevice>(slave: &mut Node<D>) {
    let now = FineInstant::from(slave.now).units();
    sync_at(slave, now);
}

/// The spacecraft time arrives.
fn time<D: SpacecraftDevice>(slave: &mut Node<D>, time: Scet) {
    slave.receive(NOMINAL, 0x181, &time.encode());
}
