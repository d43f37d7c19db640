//! The instrument's firmware on an emulated Cortex-M4F, driven over its serial port like a real one.

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asperity::acquire::transport::{Transport, open};
use asperity::acquire::{Client, Draft, InProcess, Job, Patience, Peer, Schedule, run};
use asperity_core::protocol::Diagnostics;
use asperity_firmware_sim::{Config, Instant, Simulator};
use asperity_needs::absent;

use crate::elf;
use crate::emulator::{Firmware, Instrument};
/// What a small instrument has.
const FLASH: usize = 64 * 1024;
const RAM: usize = 16 * 1024;

/// A whole grid of the GP-200 at one incidence: as many points as the memory holds; then a shorter one.
const PLANS: [&str; 2] = [
    "sigma_deg = [30]\nintegration_ms = 5\n",
    "sigma_deg = [0, 60]\ntheta_step_deg = 2\nintegration_ms = 5\nrange = 1\n",
];

/// The same instrument in this process.
struct Twin(Simulator);

impl Peer for Twin {
    fn exchange(&mut self, bytes: &[u8], now: Duration, out: &mut Vec<u8>) {
        let now = Instant(now.as_micros() as u64);
        self.0.handle(bytes, now, &mut |bytes: &[u8]| out.extend_from_slice(bytes));
    }

    fn poll_at(&self) -> Option<Duration> {
        self.0.poll_at().map(|at| Duration::from_micros(at.0))
    }
}

fn schedule(text: &str) -> Schedule {
    let sample = "sample = \"emulated\"\nior = 1.49\nrough_side = \"source\"\n";
    Draft::parse(&format!("{text}{sample}"), Path::new("plan.toml")).unwrap().schedule().unwrap()
}

/// Measures every plan, and asks how the firmware is; the files.
fn measure(line: &mut dyn Transport, folder: &Path) -> (Vec<Vec<u8>>, Diagnostics) {
    let mut files = Vec::new();
    for (k, text) in PLANS.iter().enumerate() {
        let output = folder.join(format!("{k}.csv"));
        let job = Job {
            schedule: Some(schedule(text)),
            output: &output,
            // all of it in flight
            credit: 1801,
            resume: false,
            recalibrate: false,
            patience: Patience::default(),
        };
        let summary = run(&job, || Ok(&mut *line), &AtomicBool::new(false), &mut |_| {}).unwrap();
        assert_eq!(summary.recoveries, 0, "the line was lost");
        files.push(fs::read(&output).unwrap());
        fs::remove_file(&output).unwrap();
    }
    let mut client = Client::connect(line, Patience::default()).unwrap();
    (files, client.diagnostics().unwrap())
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_firmware_measures_the_same_bits_over_its_serial_port() {
    let elf = match Firmware::Instrument.path() {
        Ok(path) => path,
        Err(remedy) => return absent(&remedy),
    };
    let instrument = match Instrument::start(&elf) {
        Ok(instrument) => instrument,
        Err(remedy) => return absent(&remedy),
    };
    let folder = tempfile::tempdir().unwrap();
    let mut line = open(&instrument.port, 115_200).unwrap();
    let begun = std::time::Instant::now();
    let (emulated, diagnostics) = measure(&mut *line, folder.path());
    println!("{} points in {:?}", 1801 + 2 * 91, begun.elapsed());
    let mut twin = InProcess::new(Twin(Simulator::new(Config::emulated())));
    let (here, _) = measure(&mut twin, folder.path());
    assert!(emulated == here, "the emulated instrument measures other bits");

    let size = elf::size(&fs::read(elf).unwrap()).unwrap();
    let stack = diagnostics.stack_bytes as usize;
    println!(
        "flash {} bytes; RAM: variables {} and stack {} of {RAM} bytes; frames {} good, {} bad",
        size.flash, size.variables, stack, diagnostics.frames, diagnostics.bad_frames
    );
    assert!(size.flash <= FLASH, "{size:?}");
    assert!(stack > 1000 && size.variables + stack <= RAM, "{size:?}, stack {stack}");
    assert_eq!(diagnostics.bad_frames, 0);
}

#[test]
fn the_firmware_neither_allocates_nor_formats_panics() {
    let elf = match Firmware::Instrument.path() {
        Ok(path) => fs::read(path).unwrap(),
        Err(remedy) => return absent(&remedy),
    };
    let names = elf::symbols(&elf).unwrap();
    // if the names were stripped, finding none would mean nothing
    assert!(names.iter().any(|n| n.contains("Reset")), "no symbols in the firmware");
    for name in &names {
        let unwanted = ["__rust_alloc", "__rg_alloc", "__rdl_alloc", "core3fmt", "panic_bounds"];
        assert!(!unwanted.iter().any(|u| name.contains(u)), "in the firmware: {name}");
    }
}
