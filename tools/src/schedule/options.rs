//! The command line.

use std::time::Duration;

use clap::Args;
use ecss_can::profile;

use super::message::{Errors, Network};
use super::mission::Assumed;
use crate::images::support::board::Profile;
use crate::numbers;

/// Command line of `schedule`.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 0: every deadline is met; 1: one cannot be met; 2: a wrong argument.")]
pub struct Options {
    /// Mission profile whose numbers count
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Standard)]
    profile: Profile,

    /// Number of slaves: nodes 2, 3, 4, ...; the master commands 14 of them [1..125]
    #[arg(long, value_name = "N", default_value_t = 14, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=125))]
    nodes: u8,

    /// Bit rate in kbit/s [default: that of the profile]
    #[arg(long, value_name = "KBIT", value_parser = bit_rate)]
    bit_rate: Option<u32>,

    /// Errors that the bus may have: so many at once, and one more in each interval of MS milliseconds
    #[arg(long, value_name = "BURST[:MS]", default_value = "0", value_parser = errors)]
    errors: Errors,

    /// Milliseconds between two SDO requests to one slave, at least [1..60000] [default: the heartbeat period]
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=60_000))]
    sdo: Option<u64>,

    /// Microseconds that software may need from an event to the release of its frame [0..1000000]
    #[arg(long, value_name = "US", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    jitter: u64,
}

fn bit_rate(text: &str) -> Result<u32, String> {
    let allowed = ecss_can_eds::BIT_RATES;
    let found = text.parse().ok().filter(|rate| allowed.contains(rate));
    found.map(u32::from).ok_or_else(|| {
        let all: Vec<String> = allowed.iter().map(u16::to_string).collect();
        format!("allowed are {} kbit/s", all.join(", "))
    })
}

/// Reads the value of `--errors`.
fn errors(text: &str) -> Result<Errors, &'static str> {
    const ALLOWED: &str =
        "allowed are a burst of 0 to 100 errors and an interval of 1 to 60000 ms, for example 2:10";
    let (burst, interval) = match text.split_once(':') {
        Some((burst, interval)) => (burst, Some(interval)),
        None => (text, None),
    };
    let burst = burst.parse().ok().filter(|burst| *burst <= 100).ok_or(ALLOWED)?;
    let interval = match interval.map(str::parse) {
        None => None,
        Some(Ok(ms @ 1..=60_000)) => Some(Duration::from_millis(ms)),
        Some(_) => return Err(ALLOWED),
    };
    Ok(Errors { burst, interval })
}

impl Options {
    pub(crate) fn profile(&self) -> &'static profile::Profile {
        numbers(self.profile)
    }

    pub(crate) fn network(&self) -> Network {
        let bit_rate = self.bit_rate.map_or(self.profile().network.bit_rate.get(), |kbit| kbit * 1_000);
        Network { bit_rate, errors: self.errors }
    }

    pub(crate) fn assumed(&self) -> Assumed {
        Assumed {
            slaves: self.nodes,
            sdo: self.sdo.map(Duration::from_millis),
            jitter: Duration::from_micros(self.jitter),
        }
    }
}
