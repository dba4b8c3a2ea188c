//! Foreign traffic on a bus: random frames that no board admits.

use crate::spacecraft::{Bus, GuestId, Spacecraft};
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;

/// Mean time that a frame of 8 random bytes and an 11-bit identifier keeps the bus busy, µs.
const MEAN_FRAME_US: f64 = 117.0;

/// Lead time with which frames are passed to their senders.
const AHEAD: Time = Time::from_ms(5);

/// Two controllers that keep a bus busy for a share of the time.
#[derive(Debug)]
pub struct Traffic {
    senders: [GuestId; 2],
    /// Share of the time for which the frames keep the bus busy, 0 to 1.
    load: f64,
    random: fastrand::Rng,
    /// Instant until which frames have been passed to the senders.
    loaded: Time,
}

impl Traffic {
    /// Makes traffic on `bus` from 2 m and 33 m, beginning at `from`. Add all boards before.
    pub fn new(spacecraft: &mut Spacecraft, bus: Bus, load: f64, seed: u64, from: Time) -> Traffic {
        let senders = [2.0, 33.0].map(|position_m| spacecraft.add_guest(bus, position_m));
        Traffic { senders, load, random: fastrand::Rng::with_seed(seed), loaded: from }
    }

    /// Passes on the frames until `until` and slightly longer: random data with random identifiers, below and above all
    /// of the boards'. Without load there are no frames.
    pub fn hand_over(&mut self, spacecraft: &mut Spacecraft, until: Time) {
        // Discards received frames, which would accumulate.
        for sender in self.senders {
            spacecraft.take_heard(sender);
        }
        if self.load <= 0.0 {
            return;
        }
        let gap = MEAN_FRAME_US / self.load;
        while self.loaded < until + AHEAD {
            let random = &mut self.random;
            let id = match random.u8(..3) {
                0 => random.u16(0x001..0x080),
                1 => random.u16(0x101..0x180),
                _ => random.u16(0x780..0x7F0),
            };
            let frame = WireFrame::standard(id, &random.u64(..).to_le_bytes());
            let sender = self.senders[random.usize(..self.senders.len())];
            let ticks = (0.5 + random.f64()) * gap * Time::from_us(1).0 as f64;
            self.loaded += Time(ticks as u64);
            spacecraft.inject(sender, self.loaded, frame);
        }
    }
}
