//! Builds the firmware for the device and runs it in QEMU.
//!
//! An `Err` is a missing tool, with its remedy; anything else that goes wrong is a failure.

use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

const TARGET: &str = "thumbv7em-none-eabihf";

/// QEMU needs half a second; a firmware that hangs must not hang the tests.
const TIME_LIMIT: Duration = Duration::from_mins(2);

/// The path of the firmware, built once.
pub(crate) fn firmware() -> Result<PathBuf, String> {
    static BUILT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    BUILT.get_or_init(build).clone()
}

fn build() -> Result<PathBuf, String> {
    let settings = std::env::var("ASPERITY_DEVICE_ENV").unwrap_or_default();
    if settings.is_empty() && !target_is_installed() {
        return Err(format!("no Rust target {TARGET}; install it: rustup target add {TARGET}"));
    }
    // A directory of its own: the outer cargo holds the lock of the other one.
    let target_dir = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("device");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .args(["build", "--release", "--package", "asperity-firmware-sim", "--no-default-features"])
        .args(["--features", "qemu", "--bin", "qemu", "--target", TARGET, "--target-dir"])
        .arg(&target_dir)
        .envs(settings.split_whitespace().filter_map(|s| s.split_once('=')));
    // flags meant for the host, such as those of a coverage run
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(name);
    }
    let out = cargo.output().unwrap_or_else(|e| panic!("cannot start cargo: {e}"));
    let log = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "the firmware does not build:\n{log}");
    Ok(target_dir.join(TARGET).join("release").join("qemu"))
}

fn target_is_installed() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let out = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    out.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
}

/// Runs a firmware to its end and returns what it printed.
///
/// With `-icount shift=0` an instruction takes 1 ns of the board's time, so counts are repeatable.
pub(crate) fn run(elf: &Path) -> Result<String, String> {
    let started = Command::new("qemu-system-arm")
        .args(["-M", "mps2-an386", "-cpu", "cortex-m4", "-nographic", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native"])
        .args(["-icount", "shift=0", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn();
    let mut qemu = match started {
        Ok(child) => child,
        Err(e) if e.kind() == ErrorKind::NotFound => {
            return Err("no qemu-system-arm; on Debian: apt-get install qemu-system-arm".into());
        }
        Err(e) => panic!("cannot start qemu-system-arm: {e}"),
    };
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
