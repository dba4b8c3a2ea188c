//! The SDO client of `ecss-can` on a computer, with a socket and real time.

use std::time::{Duration as Span, Instant as Wall};

use anyhow::{Context, ensure};
use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::sdo::machine::{Client, Payload};
use ecss_can::types::{Address, Duration, Instant};

use crate::slcan::Channel;

/// Timeout of a transfer, long because the computer may be busy.
const TIMEOUT: Duration = Duration::from_millis(20_000);

/// Longest time until boards have power and a node acknowledges frames.
const UNTIL_IT_IS_HEARD: Span = Span::from_secs(60);

/// Bytes that the application provides or takes at once.
const CHUNK: usize = 50;

/// Gives bytes to a download.
pub fn push(client: &mut Client, rest: &mut &[u8]) {
    let pushed = client.push(rest.get(..CHUNK).unwrap_or(rest));
    *rest = rest.get(pushed..).unwrap_or_default();
}

/// Takes bytes of an upload, and returns their number.
pub fn pull(client: &mut Client, value: &mut Vec<u8>) -> usize {
    let mut part = [0; CHUNK];
    let pulled = client.pull(&mut part);
    value.extend(part.iter().take(pulled));
    pulled
}

/// The client of one server.
pub struct Host {
    channel: Channel,
    client: Client,
    server: u8,
    power_on: Wall,
    /// Payloads of the last transfer, requests and responses as they went over the bus.
    pub exchanged: Vec<Payload>,
    /// Number, from 0, of the payload of each transfer that is lost if it is a response.
    pub misses: Option<usize>,
}

impl Host {
    /// Makes a client of node `server` on the bus at this address, and waits until a node is heard.
    ///
    /// # Errors
    /// When the bus cannot be reached or stays silent.
    pub fn new(url: &str, server: u8) -> anyhow::Result<Host> {
        let mut channel = Channel::open(url)?;
        let heard = channel.receive(Wall::now() + UNTIL_IT_IS_HEARD)?;
        ensure!(heard.is_some(), "nobody is heard on {url}");
        let client = Client::new(TIMEOUT);
        Ok(Host { channel, client, server, power_on: Wall::now(), exchanged: Vec::new(), misses: None })
    }

    /// Writes a value, and returns the result of the transfer.
    ///
    /// # Errors
    /// When the spacecraft has closed the connection.
    pub fn download(
        &mut self,
        at: Address,
        value: &[u8],
        mode: Mode,
    ) -> anyhow::Result<Result<usize, Error>> {
        self.client.start_download(at, value.len(), mode);
        let mut rest = value;
        self.transfer(|client| push(client, &mut rest))
    }

    /// Reads a value of at most `most` bytes.
    ///
    /// # Errors
    /// When the spacecraft has closed the connection.
    pub fn upload(&mut self, at: Address, most: usize, mode: Mode) -> anyhow::Result<Result<Vec<u8>, Error>> {
        self.client.start_upload(at, most, mode);
        let mut value = Vec::new();
        let outcome = self.transfer(|client| _ = pull(client, &mut value))?;
        // The last bytes are still in the client.
        while pull(&mut self.client, &mut value) > 0 {}
        if let Ok(size) = outcome {
            ensure!(value.len() == size, "{} bytes of {size}", value.len());
        }
        Ok(outcome.map(|_| value))
    }

    /// Runs a transfer to its end, while `work` provides or takes bytes.
    fn transfer(&mut self, mut work: impl FnMut(&mut Client)) -> anyhow::Result<Result<usize, Error>> {
        self.exchanged.clear();
        loop {
            let mut requests = Vec::new();
            work(&mut self.client);
            self.client.poll(self.now(), &mut |payload| requests.push(payload));
            self.send(&requests)?;
            if let Some(outcome) = self.client.outcome() {
                return Ok(outcome);
            }
            if self.client.needs_application() {
                continue;
            }
            let deadline = self.client.deadline().context("the transfer waits for nothing")?;
            let until = self.power_on + Span::from_micros(deadline.as_micros());
            let Some(frame) = self.channel.receive(until)? else { continue };
            if frame.id != 0x580 + u16::from(self.server) {
                continue;
            }
            let payload = Payload::try_from(frame.data.as_slice()).context("a response has 8 bytes")?;
            let is_missed = self.misses == Some(self.exchanged.len());
            self.exchanged.push(payload);
            if is_missed {
                continue;
            }
            let mut requests = Vec::new();
            self.client.on_response(&payload, self.now(), &mut |payload| requests.push(payload));
            self.send(&requests)?;
        }
    }

    fn send(&mut self, requests: &[Payload]) -> anyhow::Result<()> {
        for payload in requests {
            self.channel.send(0x600 + u16::from(self.server), payload)?;
            self.exchanged.push(*payload);
            // TCP blocks when the bus is slower.
            self.client.on_sent();
        }
        Ok(())
    }

    fn now(&self) -> Instant {
        Instant::from_micros(u64::try_from(self.power_on.elapsed().as_micros()).unwrap_or(u64::MAX))
    }
}
