//! `gonio-sim`: a goniophotometer on a pseudo terminal or a TCP port.

mod arguments;
mod line;

use std::io::{self, Write as _};
use std::process::ExitCode;
use std::time::Duration;

use asperity_firmware_sim::fault::{Direction, Link};
use asperity_firmware_sim::{Instant, MachineFault, Simulator};
use clap::Parser as _;

use arguments::Arguments;
use line::{Event, Line, Network, Terminal};

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "gonio-sim: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let config = arguments.config()?;
    let link = arguments.link_faults()?.map(|faults| Box::new(Link::new(faults, config.seed)));
    let (line, place) = open(arguments.tcp.as_deref()).map_err(|e| e.to_string())?;
    let mut faults = arguments.faults.clone();
    faults.sort_by_key(|&(at, _)| at);
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "listening on {place}")
        .and_then(|()| stdout.flush())
        .map_err(|e| e.to_string())?;
    let start = std::time::Instant::now();
    let mut bench =
        Bench { simulator: Box::new(Simulator::new(config)), line, link, faults, start };
    bench.serve().map_err(|e| e.to_string())
}

fn open(tcp: Option<&str>) -> io::Result<(Line, String)> {
    match tcp {
        Some(address) => {
            let (network, name) = Network::open(address)?;
            Ok((Line::Network(network), format!("tcp:{name}")))
        }
        None => Terminal::open().map(|(terminal, name)| (Line::Terminal(terminal), name)),
    }
}

/// The instrument, its line, and what is going to go wrong.
struct Bench {
    simulator: Box<Simulator>,
    line: Line,
    link: Option<Box<Link>>,
    /// In the order of time.
    faults: Vec<(Instant, MachineFault)>,
    start: std::time::Instant,
}

impl Bench {
    fn now(&self) -> Instant {
        Instant(u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX))
    }

    /// Until the line fails.
    fn serve(&mut self) -> io::Result<()> {
        let mut bytes = Vec::new();
        loop {
            self.turn(&bytes);
            let now = self.now();
            let link = self.link.as_ref().and_then(|link| link.poll_at());
            let fault = self.faults.first().map(|&(at, _)| at);
            let next = [self.simulator.poll_at(), link, fault].into_iter().flatten().min();
            let limit = next.map(|next| Duration::from_micros(next.since(now)));
            bytes.clear();
            match self.line.wait(limit)? {
                Event::Nothing => {}
                Event::Bytes(got) => bytes = got,
                Event::Gone => self.simulator.disconnected(self.now()),
            }
        }
    }

    /// One call of the instrument.
    fn turn(&mut self, bytes: &[u8]) {
        let now = self.now();
        while let Some(&(at, fault)) = self.faults.first()
            && at <= now
        {
            self.simulator.inject(fault);
            self.faults.remove(0);
        }
        let line = &mut self.line;
        // all that is said in one call goes out in one piece
        let mut said = Vec::new();
        let Some(link) = &mut self.link else {
            self.simulator.handle(bytes, now, &mut |out: &[u8]| said.extend_from_slice(out));
            if !said.is_empty() {
                line.send(&said);
            }
            return;
        };
        link.send(Direction::ToInstrument, bytes, now);
        let mut got = Vec::new();
        link.receive(Direction::ToInstrument, now, &mut |b: &[u8]| got.extend_from_slice(b));
        self.simulator.handle(&got, now, &mut |out: &[u8]| said.extend_from_slice(out));
        for piece in said.chunks(1024) {
            link.send(Direction::ToClient, piece, now);
            link.receive(Direction::ToClient, now, &mut |b: &[u8]| line.send(b));
        }
        link.receive(Direction::ToClient, now, &mut |b: &[u8]| line.send(b));
        if link.take_break() {
            // the instrument hears of it from a line that can be broken
            self.line.hang_up();
        }
    }
}
