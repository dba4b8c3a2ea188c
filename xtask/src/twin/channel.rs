//! The SLCAN channel of one client: closed, open or listening, and what each command does in it.

use can_wire::controller::ErrorCounters;
use can_wire::frame::WireFrame;
use can_wire::time::Time;

use super::filter::Filter;
use super::slcan::{self, Command, ERROR, OK};

/// Bit rate of both buses, bit/s: the only one with which a channel opens.
pub const BIT_RATE: u32 = 1_000_000;

/// Stamps of received frames count milliseconds and begin anew every minute.
const STAMP_PERIOD_MS: u64 = 60_000;

/// Whether and how a client takes part in the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Not at all.
    #[default]
    Closed,
    /// It hears and sends.
    Open,
    /// It hears.
    Listening,
}

/// What a line led to, besides its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    None,
    /// This frame is to be sent.
    Send(WireFrame),
    /// The channel stayed closed: it asked for this bit rate, which the bus does not have.
    WrongBitRate(u32),
}

/// State of a channel.
#[derive(Clone, Debug)]
pub struct Channel {
    mode: Mode,
    bit_rate: u32,
    stamps: bool,
    filter: Filter,
    /// Frames were dropped since the flags were read last.
    overrun: bool,
}

impl Channel {
    /// A closed channel. Who sets no bit rate gets that of the bus.
    pub fn new() -> Self {
        Channel {
            mode: Mode::Closed,
            bit_rate: BIT_RATE,
            stamps: false,
            filter: Filter::default(),
            overrun: false,
        }
    }

    /// Whether and how it takes part.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// A frame was dropped for this client; the status flags tell.
    pub fn lost_a_frame(&mut self) {
        self.overrun = true;
    }

    /// Does what a line asks for, `number` being the serial number and `errors` those of the node on the bus. Appends the
    /// answer.
    pub fn obey(&mut self, line: &[u8], number: u16, errors: ErrorCounters, out: &mut Vec<u8>) -> Effect {
        let Some(command) = Command::parse(line) else {
            out.push(ERROR);
            return Effect::None;
        };
        let closed = self.mode == Mode::Closed;
        let mut effect = Effect::None;
        let done = match command {
            Command::Empty => true,
            Command::BitRate(rate) if closed => {
                self.bit_rate = rate;
                true
            }
            Command::Open | Command::Listen if closed && self.bit_rate != BIT_RATE => {
                effect = Effect::WrongBitRate(self.bit_rate);
                false
            }
            Command::Open if closed => {
                self.mode = Mode::Open;
                true
            }
            Command::Listen if closed => {
                self.mode = Mode::Listening;
                true
            }
            Command::Close if !closed => {
                self.mode = Mode::Closed;
                true
            }
            Command::Send(frame) if self.mode == Mode::Open => {
                effect = Effect::Send(frame);
                out.push(
                    line.first().map_or(b'z', |name| if name.is_ascii_lowercase() { b'z' } else { b'Z' }),
                );
                true
            }
            Command::Version => {
                out.extend(b"V0101");
                true
            }
            Command::SoftwareVersion => {
                out.extend(b"v0101");
                true
            }
            Command::SerialNumber => {
                out.extend(format!("N{number:04X}").into_bytes());
                true
            }
            Command::Status if !closed => {
                out.extend(format!("F{:02X}", self.take_flags(errors)).into_bytes());
                true
            }
            Command::Stamps(stamps) if closed => {
                self.stamps = stamps;
                true
            }
            Command::Code(code) if closed => {
                self.filter.code = code;
                true
            }
            Command::Mask(mask) if closed => {
                self.filter.mask = mask;
                true
            }
            _ => false,
        };
        out.push(if done { OK } else { ERROR });
        effect
    }

    /// Status flags of the CAN232: 2 error warning, 3 data overrun, 5 error passive.
    fn take_flags(&mut self, errors: ErrorCounters) -> u8 {
        let worst = errors.transmit.max(errors.receive);
        let overrun = std::mem::take(&mut self.overrun);
        u8::from(worst >= 96) << 2 | u8::from(overrun) << 3 | u8::from(worst >= 128) << 5
    }

    /// The line of a frame that was on the bus at `at`, when this client wants it.
    pub fn line(&self, at: Time, frame: &WireFrame) -> Option<Vec<u8>> {
        if self.mode == Mode::Closed || !self.filter.accepts(frame) {
            return None;
        }
        let stamp = (at.as_us() / 1000 % STAMP_PERIOD_MS) as u16;
        let mut line = Vec::with_capacity(slcan::LONGEST + 5);
        slcan::write_frame(&mut line, frame, self.stamps.then_some(stamp));
        Some(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Desk {
        channel: Channel,
        errors: ErrorCounters,
    }

    impl Desk {
        fn new() -> Self {
            Desk { channel: Channel::new(), errors: ErrorCounters::default() }
        }

        fn says(&mut self, line: &str) -> (String, Effect) {
            let mut out = Vec::new();
            let effect = self.channel.obey(line.as_bytes(), 1, self.errors, &mut out);
            (String::from_utf8(out).unwrap(), effect)
        }

        fn answer(&mut self, line: &str) -> String {
            self.says(line).0
        }

        fn hears(&self, ms: u64, frame: WireFrame) -> Option<String> {
            self.channel.line(Time::from_ms(ms), &frame).map(|line| String::from_utf8(line).unwrap())
        }
    }

    fn heartbeat() -> WireFrame {
        WireFrame::standard(0x703, &[5])
    }

    #[test]
    fn a_session_of_a_usual_client_works() {
        let mut desk = Desk::new();
        // What python-can sends for bitrate=1000000: close, rate, an empty line, open, and open again.
        for (line, answer) in [("C", "\x07"), ("S8", "\r"), ("", "\r"), ("O", "\r"), ("O", "\x07")] {
            assert_eq!(desk.answer(line), answer, "{line}");
        }
        assert_eq!(desk.says("t703105"), ("z\r".into(), Effect::Send(heartbeat())));
        let extended = desk.says("T000000000");
        assert!(matches!(extended, (answer, Effect::Send(_)) if answer == "Z\r"));
        assert_eq!(desk.hears(1, heartbeat()), Some("t703105\r".into()));
        assert_eq!(desk.answer("C"), "\r");
        assert_eq!(desk.hears(1, heartbeat()), None);
    }

    #[test]
    fn a_closed_channel_sends_and_hears_nothing() {
        let mut desk = Desk::new();
        assert_eq!(desk.says("t703105"), ("\x07".into(), Effect::None));
        assert_eq!(desk.answer("F"), "\x07");
        assert_eq!(desk.hears(1, heartbeat()), None);
    }

    #[test]
    fn a_listening_channel_hears_and_cannot_send() {
        let mut desk = Desk::new();
        assert_eq!(desk.answer("L"), "\r");
        assert_eq!(desk.says("t703105"), ("\x07".into(), Effect::None));
        assert_eq!(desk.hears(1, heartbeat()), Some("t703105\r".into()));
    }

    #[test]
    fn settings_change_only_while_the_channel_is_closed() {
        let mut desk = Desk::new();
        desk.answer("O");
        for line in ["S8", "s0014", "Z1", "M00000000", "mFFFFFFFF", "L", "O"] {
            assert_eq!(desk.answer(line), "\x07", "{line}");
        }
        desk.answer("C");
        for line in ["S8", "s0014", "Z1", "M00000000", "mFFFFFFFF", "L"] {
            assert_eq!(desk.answer(line), "\r", "{line}");
        }
    }

    #[test]
    fn a_channel_of_another_bit_rate_stays_closed() {
        let mut desk = Desk::new();
        assert_eq!(desk.answer("S6"), "\r");
        assert_eq!(desk.says("O"), ("\x07".into(), Effect::WrongBitRate(500_000)));
        assert_eq!(desk.says("L"), ("\x07".into(), Effect::WrongBitRate(500_000)));
        assert_eq!(desk.channel.mode(), Mode::Closed);
        assert_eq!(desk.answer("s0014"), "\r");
        assert_eq!(desk.says("O"), ("\r".into(), Effect::None));
    }

    #[test]
    fn stamps_count_milliseconds_of_a_minute() {
        let mut desk = Desk::new();
        desk.answer("Z1");
        desk.answer("O");
        for (ms, line) in [(0, "t7031050000\r"), (59_999, "t703105EA5F\r"), (60_001, "t7031050001\r")] {
            assert_eq!(desk.hears(ms, heartbeat()), Some(line.into()));
        }
    }

    #[test]
    fn only_accepted_frames_are_forwarded() {
        let mut desk = Desk::new();
        desk.answer("ME060E060");
        desk.answer("m001F001F");
        desk.answer("O");
        assert_eq!(desk.hears(0, heartbeat()), Some("t703105\r".into()));
        assert_eq!(desk.hears(0, WireFrame::standard(0x702, &[5])), None);
    }

    #[test]
    fn the_flags_tell_of_errors_and_of_losses_once() {
        let mut desk = Desk::new();
        desk.answer("O");
        assert_eq!(desk.answer("F"), "F00\r");
        desk.channel.lost_a_frame();
        assert_eq!(desk.answer("F"), "F08\r");
        assert_eq!(desk.answer("F"), "F00\r");
        desk.errors.transmit = 96;
        assert_eq!(desk.answer("F"), "F04\r");
        desk.errors.receive = 128;
        assert_eq!(desk.answer("F"), "F24\r");
    }

    #[test]
    fn it_tells_who_it_is() {
        let mut desk = Desk::new();
        for (line, answer) in [("V", "V0101\r"), ("v", "v0101\r"), ("N", "N0001\r")] {
            assert_eq!(desk.answer(line), answer);
        }
    }
}
