//! The SDO client of `ecss-can` and a third-party server, connected by a line in virtual time.

use std::collections::VecDeque;

use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::{Client, Payload};
use ecss_can::types::{Address, Duration, Instant};
use second::host::{pull, push};

/// Timeout of the client, shorter than that of the servers, so that the client detects a loss first.
const TIMEOUT: Duration = Duration::from_millis(20);

/// Duration of a frame with 8 bytes at 1 Mbit/s, with stuff bits and the intermission after it.
const FRAME: Duration = Duration::from_micros(130);

/// Period in which a server checks its clock when the line is idle.
const TICK: Duration = Duration::from_millis(1);

/// Upper bound of the duration of a transfer.
const LONGEST: Duration = Duration::from_millis(60_000);

/// An SDO server.
pub trait Server {
    /// Handles a request.
    fn on_request(&mut self, request: Payload, now: Instant);

    /// Handles the progress of time.
    fn tick(&mut self, now: Instant);

    /// Returns the next response.
    fn next_response(&mut self) -> Option<Payload>;
}

/// Direction of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Request,
    Response,
}

/// Decides the fate of a frame: it may be changed, and `false` loses it. Frames of both directions are counted from 0.
pub type Fate = Box<dyn FnMut(usize, &mut Payload) -> bool>;

/// Client, line, server.
pub struct Line<S> {
    client: Client,
    pub server: S,
    now: Instant,
    requests: VecDeque<Payload>,
    fate: Fate,
    /// Frames of the last transfer as they were sent, including lost ones.
    pub sent: Vec<(Way, Payload)>,
}

impl<S: Server> Line<S> {
    /// Makes a line that loses nothing.
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

    /// Sets the fate of frames of all transfers from now on.
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

    /// Starts to write a value, provides at most a sub-block, and gives up after `frames` frames.
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
        // Frames that were passed to the bus before and are not sent yet.
        self.requests = requests.into();
        while self.carry() {}
    }

    /// Runs a transfer to its end, while `work` provides or takes bytes.
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

    /// Carries one frame, and returns whether there was any. Responses win, because their COB-IDs are lower.
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
