//! `cargo twin` from outside: clients that speak SLCAN over TCP, good ones and bad ones.
//!
//! Virtual time is real time in these tests, so all time limits are generous.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use crate::{TOOLS, signal, wait_for};

/// Time limit of each wait.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running spacecraft, ended when it is dropped.
struct Twin {
    child: Child,
    stdout: BufReader<ChildStdout>,
    ports: [u16; 2],
    /// Printed bit rate of each bus.
    rates: [String; 2],
}

const NOMINAL: usize = 0;
const REDUNDANT: usize = 1;

impl Twin {
    fn start(arguments: &[&str]) -> Twin {
        let mut child = TOOLS
            .command(&["twin", "--slcan-nominal", "0", "--slcan-redundant", "0", "--seconds", "300"])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
        let mut rates = [const { String::new() }; 2];
        let mut ports = [0; 2];
        for (nth, bus) in ["nominal", "redundant"].into_iter().enumerate() {
            let mut line = String::new();
            stdout.read_line(&mut line).expect("a line");
            let port = line.trim_end().strip_prefix(&format!("{bus} bus: slcan socket://127.0.0.1:"));
            let port = port.and_then(|port| port.split_once(" at "));
            let (port, rate) = port.unwrap_or_else(|| panic!("no port in {line:?}"));
            ports[nth] = port.parse().expect("a number");
            rates[nth] = rate.to_owned();
        }
        Twin { child, stdout, ports, rates }
    }

    fn client(&self, bus: usize) -> Client {
        let stream = TcpStream::connect(("127.0.0.1", self.ports[bus])).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket option");
        Client { stream }
    }

    /// Connects a client and opens its channel.
    fn open(&self, bus: usize) -> Client {
        let mut client = self.client(bus);
        assert_eq!(client.asks("O"), "\r");
        client
    }

    /// Sends SIGINT. Returns all further output, and the exit code.
    fn interrupt(mut self) -> (String, Option<i32>) {
        signal(&self.child, "-INT");
        let mut said = String::new();
        self.stdout.read_to_string(&mut said).expect("UTF-8");
        (said, self.child.wait().expect("it ends").code())
    }
}

impl Drop for Twin {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Client {
    stream: TcpStream,
}

impl Client {
    fn says(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("it takes what is said");
    }

    /// Returns the next line with its end: a carriage return, or only BEL.
    fn next(&mut self) -> String {
        let mut line = Vec::new();
        loop {
            let mut byte = [0];
            self.stream.read_exact(&mut byte).expect("it goes on");
            line.push(byte[0]);
            if matches!(byte[0], b'\r' | 0x07) {
                return String::from_utf8(line).expect("ASCII");
            }
        }
    }

    /// Waits for a line. Returns all lines up to it.
    fn hears(&mut self, wanted: impl Fn(&str) -> bool) -> Vec<String> {
        let deadline = Instant::now() + PATIENCE;
        let mut lines = Vec::new();
        while Instant::now() < deadline {
            lines.push(self.next());
            if wanted(lines.last().expect("one")) {
                return lines;
            }
        }
        panic!("not heard in time; the last lines: {:?}", lines.iter().rev().take(20).collect::<Vec<_>>());
    }

    /// Sends a line and waits for its answer between the frames.
    fn asks(&mut self, line: &str) -> String {
        self.says(format!("{line}\r").as_bytes());
        let is_frame = |line: &str| line.starts_with(['t', 'T', 'r', 'R']);
        self.hears(|line| !is_frame(line)).pop().expect("the answer")
    }

    fn sends(&mut self, frame: &str) {
        assert_eq!(self.asks(frame), "z\r", "{frame}");
    }
}

#[test]
fn clients_hear_the_bus_and_each_other() {
    let twin = Twin::start(&["--slaves", "1"]);
    let [mut one, mut other] = [twin.open(NOMINAL), twin.open(NOMINAL)];
    // Node 2 is operational, the master's heartbeat is received.
    one.hears(|line| line == "t702105\r");
    other.hears(|line| line == "t701105\r");
    // The channel of the other bus is independent.
    let mut elsewhere = twin.open(REDUNDANT);
    elsewhere.sends("t7E61FF");
    one.sends("t7E51AA");
    other.hears(|line| line == "t7E51AA\r");
    other.sends("t7E41BB");
    let heard = one.hears(|line| line == "t7E41BB\r");
    assert!(!heard.iter().any(|line| line.starts_with("t7E5") || line.starts_with("t7E6")), "{heard:?}");
    // The frame takes effect: it stops node 2, and the master starts it again.
    one.sends("t00020202");
    other.hears(|line| line == "t702104\r");
    other.hears(|line| line == "t00020102\r");
    drop(one);
    other.hears(|line| line == "t702105\r");

    let (said, code) = twin.interrupt();
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("redundant bus: ") && said.contains("ended after"), "{said}");
    // 7E5h, 7E4h and NMT; the frame on the redundant bus was acknowledged by the slave and the master.
    assert!(said.contains("3 of them from clients; clients: 2"), "{said}");
    assert!(said.contains("1 of them from clients; clients: 1"), "{said}");
}

#[test]
fn bad_clients_harm_nobody() {
    let twin = Twin::start(&["--slaves", "1"]);
    let mut good = twin.open(NOMINAL);
    good.hears(|line| line == "t702105\r");

    let mut rubbish = twin.client(NOMINAL);
    rubbish.says(&(0..=255).cycle().take(100_000).collect::<Vec<u8>>());
    assert_eq!(rubbish.next(), "\x07");
    // It can continue correctly: one line end for the invalid line, one for an empty line.
    rubbish.says(b"\r\r");
    assert_eq!(rubbish.hears(|line| line != "\x07").pop().as_deref(), Some("\r"));
    let mut endless = twin.client(NOMINAL);
    endless.says(&[b't'; 300_000]);
    let mut hanging = twin.client(NOMINAL);
    hanging.says(b"O\r");
    let mut hasty = twin.open(NOMINAL);
    hasty.says(b"t7E3");
    drop(hasty);
    let mut greedy = twin.client(NOMINAL);
    greedy.says(b"O\r");
    greedy.says(b"t7E2400010203\r");
    drop(greedy);

    // The last frame of a client that disconnected at once is sent, half a frame is not.
    let heard = good.hears(|line| line == "t7E2400010203\r");
    assert!(!heard.iter().any(|line| line.starts_with("t7E3")), "{heard:?}");
    good.hears(|line| line == "t702105\r");
    good.sends("t00020202");
    good.hears(|line| line == "t702104\r");
    drop((endless, hanging));
    let (said, code) = twin.interrupt();
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_client_too_many_is_turned_away_and_harms_nobody() {
    let mut twin = Twin::start(&["--slaves", "1"]);
    let mut clients: Vec<Client> = (0..16).map(|_| twin.open(NOMINAL)).collect();
    let mut late = twin.client(NOMINAL);
    let address = late.stream.local_addr().expect("connected");
    let mut heard = Vec::new();
    late.stream.read_to_end(&mut heard).expect("a connection that is closed in good order");
    assert!(heard.is_empty(), "no answer, no frame: {heard:?}");
    wait_for(&mut twin.stdout, &format!("nominal bus: {address} turned away, there are 16 clients"));

    // The limit of the other bus is separate; connected clients still receive the bus and each other.
    drop(twin.open(REDUNDANT));
    clients[0].sends("t7E51AA");
    for client in &mut clients[1..] {
        client.hears(|line| line == "t7E51AA\r");
    }
    clients[15].hears(|line| line == "t702105\r");
    // A place that becomes free is used again.
    let address = clients.remove(7).stream.local_addr().expect("connected");
    wait_for(&mut twin.stdout, &format!("nominal bus: {address} left"));
    let mut next = twin.open(NOMINAL);
    next.sends("t7E41BB");
    clients[0].hears(|line| line == "t7E41BB\r");

    let (said, code) = twin.interrupt();
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("2 of them from clients; clients: 17"), "{said}");
}

#[test]
fn who_asks_for_another_bit_rate_does_not_get_in() {
    let twin = Twin::start(&["--slaves", "1"]);
    assert_eq!(twin.rates, ["1000 kbit/s", "1000 kbit/s"]);
    let mut client = twin.client(NOMINAL);
    assert_eq!(client.asks("S6"), "\r");
    assert_eq!(client.asks("O"), "\x07");
    assert_eq!(client.asks("t0000"), "\x07");
    let (said, _) = twin.interrupt();
    assert!(said.contains("cannot be opened with 500 kbit/s, the bus has 1000 kbit/s"), "{said}");
}

/// Given images for 125 kbit/s, when a client sets this rate or none, then it receives and sends; a client that sets 1
/// Mbit/s is refused.
#[test]
fn clients_are_served_at_the_bit_rate_of_the_images() {
    let images = ecss_can_cli::images::build("pyboard-v11", "standard+kbit-125").expect("images");
    let (master, slave) = (images.master.display().to_string(), format!("2={}", images.slave.display()));
    let twin = Twin::start(&["--slaves", "0", "--master", &master, "--slave", &slave]);
    assert_eq!(twin.rates, ["125 kbit/s", "125 kbit/s"]);
    let mut slow = twin.client(NOMINAL);
    assert_eq!((slow.asks("S4"), slow.asks("O")), ("\r".into(), "\r".into()));
    slow.hears(|line| line == "t702105\r");
    let mut fast = twin.client(NOMINAL);
    assert_eq!((fast.asks("S8"), fast.asks("O")), ("\r".into(), "\x07".into()));
    let mut other = twin.open(NOMINAL);
    other.sends("t7E51AA");
    slow.hears(|line| line == "t7E51AA\r");
    let (said, code) = twin.interrupt();
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("cannot be opened with 1000 kbit/s, the bus has 125 kbit/s"), "{said}");
}

/// Given a slave for 125 kbit/s among boards for 1 Mbit/s, then both rates and the boards are named before the flight.
#[test]
fn a_board_with_another_bit_rate_is_named() {
    let images = ecss_can_cli::images::build("pyboard-v11", "standard+kbit-125").expect("images");
    let slave = format!("3={}", images.slave.display());
    let arguments = ["twin", "--slcan-nominal", "0", "--slcan-redundant", "0", "--seconds", "0.1"];
    let (code, _, stderr) =
        TOOLS.run(&[&arguments[..], &["--profile", "standard", "--slaves", "1", "--slave", &slave]].concat());
    assert_eq!(code, 0, "{stderr}");
    let named = "boards disagree: 125, 1000 kbit/s; slave 3 at 125 kbit/s; master, slave 2 at 1000 kbit/s";
    assert!(stderr.contains(named), "{stderr}");
}

#[test]
fn without_the_master_a_client_is_node_1() {
    let twin = Twin::start(&["--slaves", "2", "--no-master"]);
    let mut client = twin.open(NOMINAL);
    client.hears(|line| line == "t70217F\r");
    let heard = client.hears(|line| line == "t70317F\r");
    assert!(!heard.iter().any(|line| line.starts_with("t701")), "{heard:?}");
    client.sends("t701105");
    client.sends("t00020100");
    client.hears(|line| line == "t702105\r");
    client.hears(|line| line == "t703105\r");
    // There is no other master.
    client.sends("t00028003");
    client.hears(|line| line == "t70317F\r");
    let heard = client.hears(|line| line == "t70317F\r");
    assert!(!heard.iter().any(|line| line == "t703105\r"), "{heard:?}");
}

/// Given an image in a folder of the user, when it runs alone, then its board boots with the straps of its Node-ID.
#[test]
fn own_image_flies_with_the_straps_of_its_node() {
    let images = ecss_can_cli::images::build("pyboard-v11", "librecube").expect("images");
    let folder = tempfile::tempdir().expect("a folder");
    let own = folder.path().join("own.elf");
    std::fs::copy(&images.slave, &own).expect("a copy");
    let twin = Twin::start(&["--slaves", "0", "--no-master", "--slave", &format!("9={}", own.display())]);
    let mut client = twin.open(NOMINAL);
    client.hears(|line| line == "t70917F\r");
    let (said, code) = twin.interrupt();
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("slave 9") && !said.contains("slave 2") && !said.contains("master "), "{said}");
}

#[test]
fn a_port_that_is_taken_is_refused_with_what_to_do() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("bound").port().to_string();
    let (code, _, stderr) = TOOLS.run(&["twin", "--slcan-nominal", "0", "--slcan-redundant", &port]);
    let place = format!("127.0.0.1:{port}");
    assert!(code == 1 && stderr.contains(&place) && stderr.contains("--slcan-redundant"), "{stderr}");
}

#[test]
fn an_address_that_others_reach_is_warned_of() {
    let arguments = ["twin", "--listen", "0.0.0.0", "--slcan-nominal", "0", "--slcan-redundant", "0"];
    let (code, _, stderr) = TOOLS.run(&[&arguments[..], &["--slaves", "1", "--seconds", "0.1"]].concat());
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("without a password"), "{stderr}");
}
