//! The text facade.

use super::bench::{Bench, SESSION, quick, segment};
use crate::{Instant, MachineFault, Simulator};
use asperity_core::protocol::{Axis, DeviceError, MachineState, Request};
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

/// A terminal.
struct Terminal {
    simulator: Box<Simulator>,
    now: Instant,
}

impl Terminal {
    fn new() -> Self {
        Self { simulator: Box::new(Simulator::new(quick())), now: Instant(0) }
    }

    fn bytes(&mut self, line: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        self.simulator.handle(line, self.now, &mut |b: &[u8]| out.extend_from_slice(b));
        out
    }

    fn send(&mut self, line: &str) -> String {
        String::from_utf8(self.bytes(line.as_bytes())).unwrap()
    }

    /// Until nothing goes on.
    fn wait(&mut self) -> String {
        let mut said = String::new();
        while let Some(at) = self.simulator.poll_at() {
            self.now = self.now.max(at);
            said.push_str(&self.send(""));
        }
        said
    }

    fn error(&mut self) -> String {
        self.send("SYST:ERR?\n")
    }

    fn homed() -> Self {
        let mut terminal = Self::new();
        assert_eq!(terminal.send("*RST\n"), "");
        assert_eq!(terminal.wait(), "");
        assert_eq!(terminal.error(), "0,\"No error\"\n");
        assert!(terminal.simulator.status().homed);
        terminal
    }
}

#[test]
fn it_introduces_itself() {
    let mut terminal = Terminal::new();
    assert_eq!(terminal.send("*idn?\r\n"), "Asperity,GP-200 simulator,200001,0.1.0\n");
    assert_eq!(terminal.send("HELLO\n"), "");
    assert_eq!(terminal.error(), "-113,\"Undefined header\"\n");
    assert_eq!(terminal.error(), "0,\"No error\"\n");
    assert_eq!(terminal.send("MEAS?\n"), "");
    assert_eq!(terminal.error(), "-221,\"Settings conflict\"\n");
}

#[test]
fn it_moves_and_measures() {
    let mut terminal = Terminal::homed();
    let start = terminal.now;
    assert_eq!(terminal.send("GON:ANG 30,-10.5\n"), "");
    assert_eq!(terminal.send("GON:ANG 0,0\n"), "");
    assert_eq!(terminal.error(), "-221,\"Settings conflict\"\n");
    assert_eq!(terminal.wait(), "");
    // one after the other: 3 s and 0.525 s
    assert_eq!(terminal.now.since(start), 3_527_000);
    assert_eq!(terminal.send("GON:ANG?\n"), "30.000000,-10.500000\n");
    terminal.send("GON:ANG 86,0\n");
    assert_eq!(terminal.error(), "-222,\"Data out of range\"\n");
    terminal.send("GON:ANG 30,30\n");
    terminal.wait();
    assert_eq!(terminal.send("MEAS?\n"), "");
    let said = terminal.wait();
    let current: f64 = said.trim_end().parse().unwrap();
    assert!(said.ends_with('\n') && current > 1.0 && current < 800.0, "{said}");
    assert_eq!(terminal.wait(), "");
}

#[test]
fn a_fault_is_an_error_and_a_reset_leads_out() {
    let mut terminal = Terminal::homed();
    terminal.simulator.inject(MachineFault::OverRange);
    terminal.send("MEAS?\n");
    assert_eq!(terminal.wait(), "");
    assert_eq!(terminal.error(), "-240,\"Hardware error\"\n");
    terminal.send("MEAS?\n");
    assert_eq!(terminal.error(), "-240,\"Hardware error\"\n");
    terminal.send("*RST\n");
    terminal.wait();
    assert_eq!(terminal.simulator.state(), MachineState::Idle);
    terminal.send("MEAS?\n");
    assert!(!terminal.wait().is_empty());
}

#[test]
fn points_come_as_a_block() {
    let mut terminal = Terminal::homed();
    terminal.send("SCAN:DATA?\n");
    assert_eq!(terminal.error(), "-230,\"Data corrupt or stale\"\n");
    let mut bench = Bench::homed(quick());
    let points = bench.scan(segment(0, 100_000, 30));
    bench.accept(Request::Release);
    let out = bench.raw(b"SCAN:DATA?\n");
    assert_eq!(&out[..5], b"#3120");
    assert_eq!((out.len(), out[125]), (126, b'\n'));
    for (value, point) in out[5..125].chunks(4).zip(&points) {
        let value = f32::from_le_bytes(value.try_into().unwrap());
        assert_eq!(value.to_bits(), point.reading.signal.to_bits(), "nA without a calibration");
    }
    // relative with one
    assert!(bench.answer_to(SESSION, 900, Request::Claim).is_some());
    bench.sequence = 900;
    bench.calibrate();
    let points = bench.scan(segment(0, 100_000, 30));
    bench.accept(Request::Release);
    let out = bench.raw(b"SCAN:DATA?\n");
    let value = f32::from_le_bytes(out[5..9].try_into().unwrap());
    let reading = points[0].reading;
    assert!((value - (reading.signal - reading.dark) / 800.0).abs() < 1e-3 * value);
}

#[test]
fn frames_and_text_share_the_port() {
    let mut bench = Bench::new(quick());
    // a session owns it, so it listens to frames
    assert!(bench.raw(b"*IDN?\n").is_empty());
    assert!(bench.answer_to(SESSION, 100, Request::Status).is_some(), "the garbage is skipped");
    bench.sequence = 100;
    // quiet for 5 s: text again, though not for everything
    bench.wait(4_999_999);
    assert!(bench.raw(b"*IDN?\n").is_empty());
    bench.raw(b"\0");
    bench.wait(5_000_000);
    assert!(bench.raw(b"*IDN?\n").starts_with(b"Asperity,"));
    assert!(bench.ask(Request::Status).is_ok());
}

#[test]
fn a_session_protects_the_instrument_from_text() {
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Theta, -90_000_000);
    bench.wait(5_000_000);
    let text = |bench: &mut Bench, line: &[u8]| String::from_utf8(bench.raw(line)).unwrap();
    assert!(text(&mut bench, b"GON:ANG?\n").ends_with("-90.000000\n"));
    for line in [&b"GON:ANG 1,1\n"[..], b"MEAS?\n", b"SCAN:DATA?\n"] {
        assert_eq!(text(&mut bench, line), "");
        assert_eq!(text(&mut bench, b"SYST:ERR?\n"), "-203,\"Command protected\"\n");
    }
    assert_eq!(bench.simulator.status().owner, Some(SESSION));
    // an owner that has been silent for so long gives way to a reset, as it does to a claim
    assert_eq!(text(&mut bench, b"*RST\n"), "");
    let status = bench.simulator.status();
    assert_eq!((status.owner, status.state), (None, MachineState::Homing));
    // a request of the old owner, and it is told
    assert_eq!(bench.refused(Request::Stop), DeviceError::NotOwner);
}

#[test]
fn text_after_a_release_in_one_piece_of_bytes() {
    let mut bench = Bench::new(quick());
    let mut bytes = Bench::frame(SESSION, bench.sequence + 1, Request::Release);
    bytes.extend_from_slice(b"GON:ANG?\n");
    bytes.extend_from_slice(&Bench::frame(SESSION, bench.sequence + 2, Request::Claim));
    let out = bench.raw(&bytes);
    let text = b"0.000000,0.000000\n";
    assert!(out.windows(text.len()).any(|w| w == text));
    assert_eq!(bench.simulator.status().owner, Some(SESSION));
}
