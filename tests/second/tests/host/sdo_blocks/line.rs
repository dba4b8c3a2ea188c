//! The SDO client of `ecss-can` and a server of others, joined by a line in virtual time.

use std::collections::VecDeque;

use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::{Client, Payload};
use ecss_can::types::{Address, Duration, Instant};
use second::host::{pull, push};

/// Shorter than that of the servers: what is lost is missed by the client first.
const TIMEOUT: Duration = Duration::from_millis(20);

/// A frame with 8 bytes at 1 Mbit/s, with stuff bits and the pause behind it.
const FRAME: Duration = Duration::from_micros(130);

/// How often a server looks at its clock when nothing is on the line.
const TICK: Duration = Duration::from_millis(1);

/// No transfer of these tests takes so long.
const LONGEST: Duration = Duration::from_millis(60_000);

/// An SDO server.
pub trait Server {
    /// A request came in.
    fn on_request(&mut self, request: Payload, now: Instant);

    /// Time goes by.
    fn tick(&mut self, now: Instant);

    /// What it sends next.
    fn next_response(&mut self) -> Option<Payload>;
}

/// Which way a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Request,
    Response,
}

/// What becomes of a frame: it may be changed, and `false` loses it. Frames of both ways are counted from 0 on.
pub type Fate = Box<dyn FnMut(usize, &mut Payload) -> bool>;

/// Client, line, server.
pub struct Line<S> {
    client: Client,
    pub server: S,
    now: Instant,
    requests: VecDeque<Payload>,
    fate: Fate,
    /// What was sent in the last transfer, also what was lost, as it was sent.
    pub sent: Vec<(Way, Payload)>,
}

impl<S: Server> Line<S> {
    /// A line that loses nothing.
    pub fn new(server: S) -> Line<S> {
        Line {
            client: Client::new(TIMEOUT),
            server,
            now: Instant::ZERO,
            requests: VecDeque::new(),
            fate: Box::new(|_, _| true),
            sent: Vec::new(),
        }
    }

    /// What becomes of the frames of all transfers from now on.
    pub fn disturb(&mut self, fate: impl FnMut(usize, &mut Payload) -> bool + 'static) {
        self.fate = Box::new(fate);
    }

    /// Writes a value by blocks.
    pub fn download(&mut self, at: Address, value: &[u8]) -> Result<usize, Error> {
        self.client.start_download(at, value.len(), Mode::Block);
        let mut rest = value;
        self.transfer(|client| push(client, &mut rest))
    }

    /// Reads a value of at most `most` bytes by blocks.
    pub fn upload(&mut self, at: Address, most: usize) -> Result<Vec<u8>, Error> {
        self.client.start_upload(at, most, Mode::Block);
        let mut value = Vec::new();
        let outcome = self.transfer(|client| _ = pull(client, &mut value));
        while pull(&mut self.client, &mut value) > 0 {}
        outcome.map(|size| {
            assert_eq!(value.len(), size);
            value
        })
    }

    /// Begins to write a value, of which no more than a sub-block is given, and gives up after `frames` frames.
    pub fn give_up_download(&mut self, at: Address, value: &[u8], frames: usize) {
        self.client.start_download(at, value.len(), Mode::Block);
        self.client.push(value);
        self.sent.clear();
        while self.sent.len() < frames {
            let mut requests = Vec::new();
            self.client.poll(self.now, &mut |payload| requests.push(payload));
            self.requests.extend(requests);
            assert!(self.carry(), "the transfer stands still");
        }
        let mut requests = Vec::new();
        self.client.cancel(&mut |payload| requests.push(payload));
        // What was given to the bus before and has not left.
        self.requests = requests.into();
        while self.carry() {}
    }

    /// Runs a transfer to its end, while `work` gives or takes bytes.
    fn transfer(&mut self, mut work: impl FnMut(&mut Client)) -> Result<usize, Error> {
        self.sent.clear();
        let begun = self.now;
        loop {
            assert!(self.now.since(begun) < LONGEST, "the transfer does not end");
            work(&mut self.client);
            let mut requests = Vec::new();
            self.client.poll(self.now, &mut |payload| requests.push(payload));
            self.requests.extend(requests);
            if let Some(outcome) = self.client.outcome() {
                while self.carry() {}
                return outcome;
            }
            if !self.carry() && !self.client.needs_application() {
                self.now += TICK;
                self.server.tick(self.now);
            }
        }
    }

    /// One frame; responses win, their COB-IDs are the lower ones. Whether there was any.
    fn carry(&mut self) -> bool {
        let (way, mut payload) = if let Some(response) = self.server.next_response() {
            (Way::Response, response)
        } else if let Some(request) = self.requests.pop_front() {
            (Way::Request, request)
        } else {
            return false;
        };
        let nth = self.sent.len();
        self.sent.push((way, payload));
        self.now += FRAME;
        self.server.tick(self.now);
        let arrives = (self.fate)(nth, &mut payload);
        if way == Way::Request {
            self.client.on_sent();
        }
        match way {
            Way::Request if arrives => self.server.on_request(payload, self.now),
            Way::Response if arrives => {
                let mut requests = Vec::new();
                self.client.on_response(&payload, self.now, &mut |payload| requests.push(payload));
                self.requests.extend(requests);
            }
            _ => {}
        }
        true
    }
}
