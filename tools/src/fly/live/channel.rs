//! The SLCAN channel of one client: closed, open or listening, and the effect of each command.

use can_twin::wire::controller::ErrorCounters;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;

use super::network::kbit;
use super::slcan::{self, Command, ERROR, OK};

/// Tolerance of the bit rate of a channel, as a divisor of the bus's rate: 0.5 %.
const TOLERANCE: u32 = 200;

/// Period of the stamps of received frames, which count milliseconds and restart every minute.
const STAMP_PERIOD_MS: u64 = 60_000;

/// How a client takes part in the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Does not take part.
    #[default]
    Closed,
    /// Receives and sends.
    Open,
    /// Receives only.
    Listening,
}

/// Reason why a line was answered with BEL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The line is no command, or a malformed one.
    #[error("no SLCAN command, or a malformed one")]
    NoCommand,
    /// The line is longer than any command.
    #[error("longer than any command, {} characters", slcan::LONGEST)]
    TooLong,
    /// The command needs an open channel.
    #[error("the channel is closed, open it with O")]
    Closed,
    /// The command sends, and the channel only listens.
    #[error("the channel only listens, open it with O to send")]
    Listening,
    /// The command changes a setting, and the channel is open.
    #[error("the channel is open, close it with C to change a setting")]
    Open,
    /// The channel has the requested state already: every client closes its channel before it opens it.
    #[error("it is so already")]
    Already,
    /// The command opens the channel at a bit rate other than that of the bus.
    #[error("cannot be opened with {} kbit/s, the bus has {} kbit/s", kbit(*.asked), kbit(*.bus))]
    WrongBitRate {
        /// Bit rate that the client set, bit/s.
        asked: u32,
        /// Bit rate of the bus, bit/s.
        bus: u32,
    },
}

impl Refusal {
    /// Returns whether the refusal is an error of the client.
    pub fn is_mistake(self) -> bool {
        self != Refusal::Already
    }
}

/// State of a channel.
#[derive(Clone, Debug)]
pub struct Channel {
    /// How it takes part in the bus.
    pub mode: Mode,
    /// Bit rate of the bus, bit/s.
    bus: u32,
    /// Serial number that it reports.
    number: u16,
    /// Bit rate that the client set, bit/s.
    bit_rate: u32,
    stamps: bool,
    /// Frames were dropped for this client since the status flags were read last.
    pub overrun: bool,
}

impl Channel {
    /// Makes a closed channel to a bus with this bit rate, bit/s. A client that sets no bit rate gets that of the bus.
    pub fn new(bus: u32, number: u16) -> Self {
        Channel { mode: Mode::Closed, bus, number, bit_rate: bus, stamps: false, overrun: false }
    }

    /// Executes a line and appends the answer. Returns a frame to send. `errors`: error counters of the node on the
    /// bus.
    ///
    /// # Errors
    /// Reason of a refusal; the answer is BEL then, and nothing has changed.
    pub fn obey(
        &mut self,
        line: &[u8],
        errors: ErrorCounters,
        out: &mut Vec<u8>,
    ) -> Result<Option<WireFrame>, Refusal> {
        let outcome = Command::parse(line).ok_or(Refusal::NoCommand).and_then(|command| {
            self.admits(command)?;
            Ok(self.execute(command, errors, out))
        });
        out.push(if outcome.is_ok() { OK } else { ERROR });
        outcome
    }

    /// Checks that a command is allowed in the state of the channel.
    fn admits(&self, command: Command) -> Result<(), Refusal> {
        let refusal = match (command, self.mode) {
            (Command::Open | Command::Listen, Mode::Closed)
                if self.bit_rate.abs_diff(self.bus) > self.bus / TOLERANCE =>
            {
                Refusal::WrongBitRate { asked: self.bit_rate, bus: self.bus }
            }
            (Command::Close, Mode::Closed)
            | (Command::Open, Mode::Open)
            | (Command::Listen, Mode::Listening) => Refusal::Already,
            (Command::Send(_) | Command::Status, Mode::Closed) => Refusal::Closed,
            (Command::Send(_), Mode::Listening) => Refusal::Listening,
            (
                Command::Open | Command::Listen | Command::BitRate(_) | Command::Stamps(_),
                Mode::Open | Mode::Listening,
            ) => Refusal::Open,
            _ => return Ok(()),
        };
        Err(refusal)
    }

    /// Executes an allowed command. Appends the answer without its end.
    fn execute(&mut self, command: Command, errors: ErrorCounters, out: &mut Vec<u8>) -> Option<WireFrame> {
        match command {
            Command::Empty => {}
            Command::BitRate(rate) => self.bit_rate = rate,
            Command::Open => self.mode = Mode::Open,
            Command::Listen => self.mode = Mode::Listening,
            Command::Close => self.mode = Mode::Closed,
            Command::Send(frame) => {
                out.push(if matches!(frame.id, WireId::Standard(_)) { b'z' } else { b'Z' });
                return Some(frame);
            }
            Command::Version => out.extend(b"V0101"),
            Command::SoftwareVersion => out.extend(b"v0101"),
            Command::SerialNumber => out.extend(format!("N{:04X}", self.number).into_bytes()),
            Command::Status => out.extend(format!("F{:02X}", self.take_flags(errors)).into_bytes()),
            Command::Stamps(stamps) => self.stamps = stamps,
        }
        None
    }

    /// Takes the status flags of the CAN232: 2 error warning, 3 data overrun, 5 error passive.
    fn take_flags(&mut self, errors: ErrorCounters) -> u8 {
        let worst = errors.transmit.max(errors.receive);
        let overrun = std::mem::take(&mut self.overrun);
        u8::from(worst >= 96) << 2 | u8::from(overrun) << 3 | u8::from(worst >= 128) << 5
    }

    /// Returns the line of a frame that was on the bus at `at`; `None` while the channel is closed.
    pub fn line(&self, at: Time, frame: &WireFrame) -> Option<Vec<u8>> {
        if self.mode == Mode::Closed {
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
        /// At a bus of 1 Mbit/s.
        fn new() -> Self {
            Desk::at(1_000_000)
        }

        fn at(bit_rate: u32) -> Self {
            Desk { channel: Channel::new(bit_rate, 1), errors: ErrorCounters::default() }
        }

        fn says(&mut self, line: &str) -> (String, Result<Option<WireFrame>, Refusal>) {
            let mut out = Vec::new();
            let outcome = self.channel.obey(line.as_bytes(), self.errors, &mut out);
            (String::from_utf8(out).unwrap(), outcome)
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
        assert_eq!(desk.says("t703105"), ("z\r".into(), Ok(Some(heartbeat()))));
        let extended = desk.says("T000000000");
        assert!(matches!(extended, (answer, Ok(Some(_))) if answer == "Z\r"));
        assert_eq!(desk.hears(1, heartbeat()), Some("t703105\r".into()));
        assert_eq!(desk.answer("C"), "\r");
        assert_eq!(desk.hears(1, heartbeat()), None);
    }

    #[test]
    fn a_closed_channel_sends_and_hears_nothing() {
        let mut desk = Desk::new();
        assert_eq!(desk.says("t703105"), ("\x07".into(), Err(Refusal::Closed)));
        assert_eq!(desk.answer("F"), "\x07");
        assert_eq!(desk.hears(1, heartbeat()), None);
    }

    #[test]
    fn a_listening_channel_hears_and_cannot_send() {
        let mut desk = Desk::new();
        assert_eq!(desk.answer("L"), "\r");
        assert_eq!(desk.says("t703105"), ("\x07".into(), Err(Refusal::Listening)));
        assert_eq!(desk.hears(1, heartbeat()), Some("t703105\r".into()));
    }

    #[test]
    fn settings_change_only_while_the_channel_is_closed() {
        let mut desk = Desk::new();
        desk.answer("O");
        for line in ["S8", "s0014", "Z1", "L", "O"] {
            assert_eq!(desk.answer(line), "\x07", "{line}");
        }
        desk.answer("C");
        for line in ["S8", "s0014", "Z1", "L"] {
            assert_eq!(desk.answer(line), "\r", "{line}");
        }
    }

    #[test]
    fn a_channel_of_another_bit_rate_stays_closed() {
        let mut desk = Desk::new();
        assert_eq!(desk.answer("S6"), "\r");
        let refusal = Refusal::WrongBitRate { asked: 500_000, bus: 1_000_000 };
        assert_eq!(desk.says("O"), ("\x07".into(), Err(refusal)));
        assert_eq!(desk.says("L"), ("\x07".into(), Err(refusal)));
        assert_eq!(refusal.to_string(), "cannot be opened with 500 kbit/s, the bus has 1000 kbit/s");
        assert_eq!(desk.channel.mode, Mode::Closed);
        assert_eq!(desk.answer("s0014"), "\r");
        assert_eq!(desk.says("O"), ("\r".into(), Ok(None)));
    }

    /// Given a bus with each rate of CiA 301, when a client sets this rate or none, then its channel opens; with the
    /// rate of 1 Mbit/s it opens only on a bus of 1 Mbit/s.
    #[test]
    fn a_channel_opens_at_the_bit_rate_of_its_bus() {
        let rates = [("S0", 10), ("S1", 20), ("S2", 50), ("S4", 125), ("S5", 250), ("S6", 500), ("S7", 800)];
        for (line, kbit) in rates.into_iter().chain([("S8", 1_000)]) {
            assert_eq!(Desk::at(kbit * 1_000).answer("O"), "\r", "without a rate, {kbit} kbit/s");
            let opened = |rate| {
                let mut desk = Desk::at(kbit * 1_000);
                [desk.answer(rate), desk.answer("O")]
            };
            assert_eq!(opened(line), ["\r", "\r"], "{kbit} kbit/s");
            let expected = if kbit == 1_000 { "\r" } else { "\x07" };
            assert_eq!(opened("S8"), ["\r", expected], "{kbit} kbit/s");
        }
        // A clock that cannot be divided to 800 kbit/s exactly: 42 MHz by 52.5.
        let mut near = Desk::at(802_000);
        assert_eq!([near.answer("S7"), near.answer("O")], ["\r", "\r"]);
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
    fn the_flags_tell_of_errors_and_of_losses_once() {
        let mut desk = Desk::new();
        desk.answer("O");
        assert_eq!(desk.answer("F"), "F00\r");
        desk.channel.overrun = true;
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

    #[test]
    fn what_is_so_already_is_no_mistake() {
        let mut desk = Desk::new();
        let refusal = |desk: &mut Desk, line: &str| desk.says(line).1.expect_err("refused");
        assert!(!refusal(&mut desk, "C").is_mistake());
        desk.answer("O");
        assert!(!refusal(&mut desk, "O").is_mistake());
        assert!(refusal(&mut desk, "L").is_mistake());
        assert!(refusal(&mut desk, "S8").is_mistake());
        assert!(refusal(&mut desk, "X1").is_mistake());
    }
}
