//! `cargo schedule`: analysis of a mission's network.
//!
//! [`response_times`] bounds the response time of every message of a bus, errors included. [`mission::messages`]
//! derives the messages of the demonstration mission from its objects. Both assume the behaviour of the boards' driver:
//! of all frames that wait on a node the one with the highest priority takes part in the next arbitration.
//!
//! ```
//! use std::time::Duration;
//! use ecss_can_cli::schedule::{Errors, Message, Network, response_times};
//!
//! let ms = Duration::from_millis;
//! let heartbeat = |id| Message { id, bytes: 1, period: ms(100), jitter: ms(0), deadline: ms(100), after: None };
//! let network = Network { bit_rate: 1_000_000, errors: Errors::NONE };
//! // The second waits for the first: 2 x 65 bits.
//! let times = response_times(&[heartbeat(0x701), heartbeat(0x702)], &network);
//! assert_eq!(times[1], Some(Duration::from_micros(130)));
//! ```

mod analysis;
mod message;
pub mod mission;
mod options;
mod table;

pub use analysis::response_times;
use anyhow::bail;
pub use message::{Errors, Message, Network};
pub use options::Options;

use crate::images::support::output;

/// Computes and prints the response times.
///
/// # Errors
/// When a deadline cannot be met.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let (network, assumed) = (options.network(), options.assumed());
    let named = mission::messages(options.profile(), &assumed);
    let messages: Vec<Message> = named.iter().map(|named| named.message).collect();
    let times = response_times(&messages, &network);
    table::lines(&named, &times, &network).iter().try_for_each(output::line)?;
    let is_late = |(message, time): &(&Message, &Option<_>)| time.is_none_or(|time| time > message.deadline);
    let late = messages.iter().zip(&times).filter(is_late).count();
    let load = network.load(&messages) * 100.0;
    output::line(format_args!(
        "\n{} messages, bus load at most {load:.1} % at {} kbit/s; errors: {}",
        messages.len(),
        network.bit_rate / 1_000,
        table::errors(&network.errors)
    ))?;
    output::line(table::ASSUMPTIONS)?;
    match late {
        0 => output::line("every deadline is met"),
        1 => bail!("1 deadline cannot be met"),
        late => bail!("{late} deadlines cannot be met"),
    }
}
