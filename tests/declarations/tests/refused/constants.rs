//! Constants of fields that do not exist, or that leave open which of several is meant.

use ecss_can::od::{Field, Objects, Record};
use ecss_can::types::Address;

#[derive(Objects)]
struct Amplifier {
    /// Limits
    #[object(0x6000, array, rw)]
    limits: [u8; 2],
    /// Channels
    #[object(0x6001.., record)]
    channels: [Channel; 3],
    /// Mode
    #[object(0x6010, rw)]
    mode: u8,
}

#[derive(Record)]
struct Channel {
    /// Gains
    #[sub(1.., rw)]
    gains: [u8; 4],
}

const THIRD_LIMIT: Field<u8> = Amplifier::LIMITS.sub(3);
const FOURTH_CHANNEL: Field = Amplifier::CHANNELS.nth(3).sub(1);
const FIFTH_GAIN: Field<u8> = Amplifier::CHANNELS.nth(0).field(Channel::GAINS.nth(4));
const ANY_CHANNEL: Field = Amplifier::CHANNELS.sub(1);
const ANY_GAIN: Field<u8> = Amplifier::CHANNELS.nth(0).field(Channel::GAINS);
const INDEX_OF_ANY: Address = Address::new(Amplifier::CHANNELS.index(), 0);

fn main() {}
