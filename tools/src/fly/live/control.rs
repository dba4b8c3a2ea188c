//! The control port: commands of programs over TCP, one per line. The answer ends with a line `ok` or `error`.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use anyhow::Context;

/// Longest line.
const LONGEST: usize = 256;
/// Programs at the same time.
const MOST_PROGRAMS: usize = 8;

/// Listens for programs.
pub struct ControlPort {
    /// Listener for programs.
    pub listener: TcpListener,
    programs: Vec<Program>,
}

struct Program {
    stream: TcpStream,
    /// Received part of the next line.
    begun: Vec<u8>,
}

impl ControlPort {
    /// Listens on an address.
    ///
    /// # Errors
    /// When that is not possible.
    pub fn listen(address: SocketAddr) -> anyhow::Result<ControlPort> {
        let open = || {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            Ok::<_, io::Error>(listener)
        };
        let listener = open().with_context(|| {
            format!("cannot listen on {address}; choose another port with --control, 0 is any free one")
        })?;
        Ok(ControlPort { listener, programs: Vec::new() })
    }

    /// Executes each received line by `obey`, and sends the answer.
    pub fn serve(&mut self, mut obey: impl FnMut(&str) -> Result<String, String>) {
        while self.programs.len() < MOST_PROGRAMS
            && let Ok((stream, _)) = self.listener.accept()
        {
            if stream.set_nonblocking(true).is_ok() {
                self.programs.push(Program { stream, begun: Vec::new() });
            }
        }
        self.programs.retain_mut(|program| program.serve(&mut obey).is_ok());
    }
}

impl Program {
    /// # Errors
    /// When it has disconnected, does not read its answers, or sends too long a line: it is dropped.
    fn serve(&mut self, obey: &mut impl FnMut(&str) -> Result<String, String>) -> io::Result<()> {
        let mut part = [0; LONGEST];
        loop {
            match self.stream.read(&mut part) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.begun.extend_from_slice(&part[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) => return Err(error),
            }
            while let Some(end) = self.begun.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.begun.drain(..=end).collect();
                let answer = match obey(String::from_utf8_lossy(&line).trim()) {
                    Ok(said) => format!("{said}\nok\n"),
                    Err(said) => format!("{said}\nerror\n"),
                };
                self.stream.write_all(answer.as_bytes())?;
            }
            if self.begun.len() > LONGEST {
                return Err(ErrorKind::InvalidData.into());
            }
        }
    }
}
