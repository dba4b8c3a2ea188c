//! Ports and CANopen slaves on the CAN driver of embassy-stm32: `firmware/examples/embassy-slave`. A guest is their master.

use can_twin::guest::{GuestEvent, Presence};
use can_twin::spacecraft::{Bus, GuestId, Spacecraft, SpacecraftConfig};
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use ecss_can_cli::images::Package;
use flight::{PYBOARD_V11, bare, parsed};

const HEARTBEAT: u16 = 0x703;
/// Heartbeat period of the default profile.
const PERIOD_MS: u64 = 100;
const OPERATIONAL: u8 = 5;

/// Program with the complete driver. The next one uses the trait `embedded_can::nb::Can`.
const BXCAN: &str = "bxcan-slave";
const NONBLOCKING: &str = "nonblocking-slave";

struct Bench {
    twin: Spacecraft,
    guest: GuestId,
}

impl Bench {
    /// Returns a bench in which the slave with this program was started and is Operational.
    fn operational(program: &str) -> Bench {
        let built = Package::of_workspace("embassy-slave").build(PYBOARD_V11).unwrap();
        let image = built.iter().find(|image| image.ends_with(program)).unwrap();
        let mut twin = Spacecraft::new(SpacecraftConfig::default());
        twin.add_board(bare(PYBOARD_V11, parsed(image)));
        let guest = twin.add_guest(Bus::Nominal, 10.0);
        let mut bench = Bench { twin, guest };
        bench.send(100, 0x000, &[1, 3]);
        bench.run_to(200);
        bench
    }

    fn send(&mut self, ms: u64, id: u16, data: &[u8]) {
        self.twin.inject(self.guest, Time::from_ms(ms), WireFrame::standard(id, data));
    }

    fn run_to(&mut self, ms: u64) {
        self.twin.run_until(Time::from_ms(ms)).unwrap();
        assert!(self.twin.boards().all(|(_, board)| board.counters().panics == 0));
    }

    /// Returns the frames of the slave since the last call, each with its end in milliseconds.
    fn heard(&mut self) -> Vec<(u64, u16, Vec<u8>)> {
        let of_slave = |(at, event): (Time, GuestEvent)| match event {
            GuestEvent::Received(frame) => {
                let WireId::Standard(id) = frame.id else { panic!("{frame:?}") };
                Some((at.as_us() / 1_000, id, frame.payload().to_vec()))
            }
            GuestEvent::Sent(_) => None,
        };
        self.twin.take_heard(self.guest).into_iter().filter_map(of_slave).collect()
    }

    /// Returns the ends of its heartbeats since the last call, in milliseconds. Asserts that all have this state, and
    /// that it has sent no other frame.
    fn heartbeats(&mut self, state: u8) -> Vec<u64> {
        let heard = self.heard().into_iter();
        heard
            .inspect(|(_, id, data)| assert_eq!((*id, &data[..]), (HEARTBEAT, &[state][..])))
            .map(|(at, ..)| at)
            .collect()
    }
}

/// Given embassy's driver of bxCAN, complete or by the trait of embedded-can, then the slave boots, obeys NMT, serves
/// SDO, and takes and sends PDOs.
#[test]
fn slaves_on_embassys_driver_serve_their_master() {
    for program in [BXCAN, NONBLOCKING] {
        serves(&mut Bench::operational(program));
    }
}

fn serves(bench: &mut Bench) {
    let boot = bench.heard();
    assert_eq!(boot.first().map(|(_, id, data)| (*id, &data[..])), Some((HEARTBEAT, &[0][..])), "{boot:?}");
    bench.send(210, 0x603, &[0x2F, 0x00, 0x60, 0, 30, 0, 0, 0]);
    bench.send(220, 0x603, &[0x2F, 0x00, 0x60, 0, 101, 0, 0, 0]);
    bench.send(230, 0x203, &[50]);
    bench.run_to(240);
    let answers: Vec<_> = bench.heard().into_iter().filter(|(_, id, _)| *id != HEARTBEAT).collect();
    let expected: [(u64, u16, Vec<u8>); 4] = [
        (210, 0x583, vec![0x60, 0x00, 0x60, 0, 0, 0, 0, 0]),
        (210, 0x183, 230_u16.to_le_bytes().to_vec()),
        (220, 0x583, vec![0x80, 0x00, 0x60, 0, 0x31, 0x00, 0x09, 0x06]),
        (230, 0x183, 250_u16.to_le_bytes().to_vec()),
    ];
    assert_eq!(answers, expected);
    bench.run_to(2_240);
    assert_eq!(bench.heartbeats(OPERATIONAL).len() as u64, 2_000 / PERIOD_MS);
}

/// Returns a bench in which a PDO of this slave is not acknowledged for most of a second, because its master was
/// removed after the command.
fn unheard(program: &str) -> Bench {
    let mut bench = Bench::operational(program);
    bench.heard();
    bench.send(201, 0x203, &[50]);
    for us in 201_000.. {
        bench.twin.run_until(Time::from_us(us)).unwrap();
        if bench.twin.take_heard(bench.guest).iter().any(|(_, event)| matches!(event, GuestEvent::Sent(_))) {
            break;
        }
    }
    bench.twin.set_presence(bench.guest, Presence::Away);
    bench.run_to(1_150);
    assert!(bench.twin.wire(Bus::Nominal).error_counters(0).transmit >= 128, "it has tried");
    bench.twin.set_presence(bench.guest, Presence::Present);
    bench
}

/// Given a PDO that no node acknowledges, when its lifetime ends, then the port aborts it: the PDO is not sent when the master is back.
#[test]
fn pdo_that_nobody_acknowledges_is_aborted() {
    let mut bench = unheard(BXCAN);
    bench.run_to(2_150);
    assert_eq!(bench.heartbeats(OPERATIONAL).len() as u64, 1_000 / PERIOD_MS + 1);
    bench.send(2_160, 0x603, &[0x40, 0x01, 0x60, 0, 0, 0, 0, 0]);
    bench.run_to(2_170);
    let answer = vec![0x4B, 0x01, 0x60, 0, 250, 0, 0, 0];
    assert!(bench.heard().contains(&(2_160, 0x583, answer)), "it took the command");
}

/// Given a driver without abort, then the old PDO and the first unacknowledged heartbeat are sent when the master is
/// back, which is the limit in docs/ports.md. Of the frames in the queue only the last one has not expired.
#[test]
fn pdo_in_a_driver_without_abort_leaves_late() {
    let mut bench = unheard(NONBLOCKING);
    bench.run_to(1_199);
    let heard = bench.heard();
    let ids: Vec<u16> = heard.iter().map(|(_, id, _)| *id).collect();
    assert_eq!(ids, [0x183, HEARTBEAT, HEARTBEAT], "{heard:?}");
}

/// Given a bus that is stuck at one level, when it is repaired, then the controller recovers by itself (ABOM), and the
/// slave is Operational.
#[test]
fn slaves_on_embassys_driver_survive_bus_off() {
    for program in [BXCAN, NONBLOCKING] {
        let mut bench = Bench::operational(program);
        let short = Fault::Short { position_m: 5.0, level: true };
        bench.twin.wire_mut(Bus::Nominal).schedule(Time::from_ms(200), short).unwrap();
        bench.run_to(900);
        assert!(bench.twin.wire(Bus::Nominal).error_counters(0).bus_off());
        bench.heard();
        bench.twin.wire_mut(Bus::Nominal).schedule(Time::from_ms(900), Fault::ClearShorts).unwrap();
        bench.run_to(2_000);
        let ends = bench.heartbeats(OPERATIONAL);
        assert!(ends.len() >= 4, "{program}: {ends:?}");
    }
}

/// Frames of a guest at 5, 15, 25, 35, 45 and 55 ms, and the board that changes the mode of its port every 10 ms; another guest, too,
/// if `others_acknowledge`. Returns the log of the board, and the milliseconds in which the frames were acknowledged.
fn modes(others_acknowledge: bool) -> (Vec<String>, Vec<u64>) {
    let built = Package::of_workspace("embassy-slave").build(PYBOARD_V11).unwrap();
    let image = built.iter().find(|image| image.ends_with("bxcan-modes")).unwrap();
    let mut twin = Spacecraft::new(SpacecraftConfig::default());
    twin.add_board(bare(PYBOARD_V11, parsed(image)));
    let guest = twin.add_guest(Bus::Nominal, 10.0);
    if others_acknowledge {
        twin.add_guest(Bus::Nominal, 20.0);
    }
    for number in 0..6_u16 {
        let at = Time::from_ms(u64::from(5 + 10 * number));
        twin.inject(guest, at, WireFrame::standard(0x100 + number, &[]));
    }
    twin.run_until(Time::from_ms(60)).unwrap();
    let is_own = |event: &GuestEvent| matches!(event, GuestEvent::Sent(_));
    let sent = twin.take_heard(guest).into_iter().filter(|(_, event)| is_own(event));
    let sent = sent.map(|(at, _)| at.as_us() / 1_000).collect();
    (twin.take_logs().into_iter().map(|log| log.text).collect(), sent)
}

/// Given another node that acknowledges, then the port receives while it is on the bus or listens.
#[test]
fn port_on_embassys_driver_receives_on_the_bus_and_listening() {
    let (log, sent) = modes(true);
    assert_eq!(sent, [5, 15, 25, 35, 45, 55]);
    let expected = ["sent", "received 101", "received 103", "sent", "received 104", "sent", "received 105"];
    assert_eq!(log, expected);
}

/// Given no other node, then the port acknowledges on the bus alone: off it and listening, the frames of the guest wait.
#[test]
fn port_on_embassys_driver_acknowledges_on_the_bus_alone() {
    let (_, sent) = modes(false);
    // The clock of the board starts about 2 ms after its power.
    assert!(matches!(sent[..], [10..=13, 15, 40..=43, 40..=43, 45, 55]), "{sent:?}");
}
