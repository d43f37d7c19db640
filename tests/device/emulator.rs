//! Builds firmware for the device and runs it in QEMU.
//!
//! An `Err` is a missing tool, with its remedy; anything else that goes wrong is a failure.

use std::io::{BufRead as _, BufReader, ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// QEMU needs half a second; a firmware that hangs must not hang the tests.
const TIME_LIMIT: Duration = Duration::from_mins(2);

/// The programs for the device.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Firmware {
    /// Prints checksums and ends.
    SelfTest,
    /// The simulated goniophotometer.
    Instrument,
    /// Counts the instructions of a model that is written into it.
    Trade,
    /// Counts those of laws and tables it has.
    Counts,
}

impl Firmware {
    /// The path of the program, built once.
    pub(crate) fn path(self) -> Result<PathBuf, String> {
        static SELF_TEST: OnceLock<Result<PathBuf, String>> = OnceLock::new();
        static INSTRUMENT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
        static TRADE: OnceLock<Result<PathBuf, String>> = OnceLock::new();
        static COUNTS: OnceLock<Result<PathBuf, String>> = OnceLock::new();
        match self {
            Self::SelfTest => SELF_TEST.get_or_init(|| build_qemu("selftest", "device")).clone(),
            Self::Counts => COUNTS.get_or_init(|| build_qemu("counts", "device")).clone(),
            Self::Trade => TRADE.get_or_init(|| build_qemu("trade", "device")).clone(),
            Self::Instrument => INSTRUMENT.get_or_init(|| build_qemu("qemu", "firmware")).clone(),
        }
    }
}

fn build_qemu(program: &str, profile: &str) -> Result<PathBuf, String> {
    let choice = ["--no-default-features", "--features", "qemu", "--bin", program];
    let package = ["--package", "asperity-firmware-sim", "--profile", profile];
    let folder = build(&[&package[..], &choice[..]].concat(), "")?;
    Ok(folder.join(TARGET).join(profile).join(program))
}

/// Runs `cargo build` for the device; the folder of what it makes.
pub(crate) fn build(arguments: &[&str], flags: &str) -> Result<PathBuf, String> {
    let settings = std::env::var("ASPERITY_DEVICE_ENV").unwrap_or_default();
    if settings.is_empty() && !target_is_installed() {
        return Err(format!("no Rust target {TARGET}; install it: rustup target add {TARGET}"));
    }
    // A directory of its own: the outer cargo holds the lock of the other one.
    let name = if flags.is_empty() { "device" } else { "device-strict" };
    let target_dir = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(name);
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .arg("build")
        .args(arguments)
        .args(["--target", TARGET, "--target-dir"])
        .arg(&target_dir)
        .envs(settings.split_whitespace().filter_map(|s| s.split_once('=')));
    // flags meant for the host, such as those of a coverage run
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(name);
    }
    if !flags.is_empty() {
        cargo.env("RUSTFLAGS", flags);
    }
    let out = cargo.output().unwrap_or_else(|e| panic!("cannot start cargo: {e}"));
    let log = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{arguments:?} does not build:\n{log}");
    Ok(target_dir)
}

fn target_is_installed() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let out = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    out.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
}

/// QEMU with a firmware, its standard output piped.
fn start(elf: &Path, settings: &[&str]) -> Result<Child, String> {
    let started = Command::new("qemu-system-arm")
        .args(["-M", "mps2-an386", "-cpu", "cortex-m4", "-monitor", "none"])
        .args(settings)
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn();
    match started {
        Ok(child) => Ok(child),
        Err(e) if e.kind() == ErrorKind::NotFound => {
            Err("no qemu-system-arm; on Debian: apt-get install qemu-system-arm".into())
        }
        Err(e) => panic!("cannot start qemu-system-arm: {e}"),
    }
}

/// The instrument, running until it is dropped, at the end of a serial line.
#[derive(Debug)]
pub(crate) struct Instrument {
    qemu: Child,
    /// The pseudo terminal that is the other end of UART0.
    pub(crate) port: String,
}

impl Instrument {
    /// Switches it on.
    pub(crate) fn start(elf: &Path) -> Result<Self, String> {
        let mut qemu = start(elf, &["-display", "none", "-serial", "pty"])?;
        let mut line = String::new();
        // "char device redirected to /dev/pts/3 (label serial0)"
        BufReader::new(qemu.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.split_whitespace().find(|word| word.starts_with('/'));
        let port = port.unwrap_or_else(|| panic!("QEMU names no terminal: {line:?}")).to_owned();
        Ok(Self { qemu, port })
    }
}

impl Drop for Instrument {
    fn drop(&mut self) {
        drop(self.qemu.kill());
        drop(self.qemu.wait());
    }
}

/// Runs a firmware to its end and returns what it printed.
///
/// With `-icount shift=0` an instruction takes 1 ns of the board's time, so counts are repeatable.
pub(crate) fn run(elf: &Path) -> Result<String, String> {
    let settings = ["-nographic", "-serial", "null", "-icount", "shift=0", "-semihosting-config"];
    let mut qemu = start(elf, &[&settings[..], &["enable=on,target=native"]].concat())?;
    let mut pipe = qemu.stdout.take().unwrap();
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    let success = wait(&mut qemu);
    let text = reader.join().unwrap().unwrap();
    match success {
        Some(true) => Ok(text),
        Some(false) => panic!("the firmware reports a failure:\n{text}"),
        None => panic!("the firmware did not end within {TIME_LIMIT:?}:\n{text}"),
    }
}

/// Whether it ended well; `None` if it had to be stopped.
fn wait(child: &mut Child) -> Option<bool> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status.success());
        }
        if start.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
