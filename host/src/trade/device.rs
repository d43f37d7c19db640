//! A Cortex-M4F in QEMU: instructions are counted, not timed, so the figures are the same on every machine.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use std::thread::sleep;
use std::time::{Duration, Instant};

use super::pairs::Pairs;
use super::payload::Payload;
use super::thumb::Functions;
use crate::input::read_file;
use crate::watch::Watch;

const EMULATOR: &str = "qemu-system-arm";
/// Largest program that is read.
const MOST_BYTES: u64 = 64 << 20;
/// Limit for a program that hangs.
const TIME_LIMIT: Duration = Duration::from_mins(2);

/// Why the device is missing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDevice {
    /// The file is not such a program; bad input.
    #[error("{}: {what}; give the program made by {}", path.display(), Device::HOW)]
    Program {
        /// The file.
        path: PathBuf,
        /// The fault.
        what: String,
    },
    /// No emulator is installed.
    #[error("there is no {EMULATOR}; on Debian: apt-get install qemu-system-arm")]
    Emulator,
}

/// The program for the device, and what runs it.
#[derive(Clone, Debug)]
pub struct Device {
    program: Vec<u8>,
    functions: Option<Functions>,
}

/// The counts of a tier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counted {
    pub(super) eval: Option<u32>,
    pub(super) sample: Option<u32>,
    pub(super) code: Option<usize>,
    pub(super) ram: Option<usize>,
    pub(super) digest: Option<u64>,
}

/// By the name of the tier, `f32-fast`.
pub(super) type Counts = BTreeMap<String, Counted>;

impl Device {
    /// The command that makes the program.
    pub const HOW: &str = "`cargo build --profile device -p asperity-firmware-sim --no-default-features --features qemu --bin trade \
                           --target thumbv7em-none-eabihf`";

    /// Reads the program and looks for the emulator.
    ///
    /// # Errors
    /// [`NoDevice`].
    pub fn open(path: &Path) -> Result<Self, NoDevice> {
        let error = |what: String| NoDevice::Program { path: path.into(), what };
        let program =
            read_file(path, MOST_BYTES).map_err(|e| error(format!("cannot be read ({e})")))?;
        Payload::fits(&program).map_err(|unfit| error(unfit.to_string()))?;
        let asked = Command::new(EMULATOR).arg("--version").stdout(Stdio::null()).status();
        if asked.is_err_and(|e| e.kind() == ErrorKind::NotFound) {
            return Err(NoDevice::Emulator);
        }
        let functions = Functions::of(&program);
        Ok(Self { program, functions })
    }

    /// Runs a model; what was counted, by tier.
    pub(super) fn run(
        &self,
        model: &Payload,
        pairs: &Pairs,
        watch: Watch<'_>,
    ) -> Result<Counts, String> {
        let program = model.in_program(&self.program, pairs).map_err(|e| e.to_string())?;
        let mut file = tempfile::NamedTempFile::new().map_err(|e| e.to_string())?;
        file.write_all(&program).and_then(|()| file.flush()).map_err(|e| e.to_string())?;
        let text = emulate(file.path(), watch)?;
        if !text.lines().any(|line| line == "ok") {
            let last = text.lines().last().unwrap_or("nothing").to_owned();
            return Err(format!("the program on the device did not come to its end: {last}"));
        }
        Ok(self.counts(&text))
    }

    fn counts(&self, text: &str) -> Counts {
        let mut counts = Counts::new();
        let mut entries: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let Some(tier) = words.get(1).filter(|_| words.len() > 2) else { continue };
            let at = counts.entry((*tier).to_owned()).or_default();
            match words[..] {
                ["count", _, "ars", n] => at.eval = n.parse().ok(),
                ["count", _, "sample", n] => at.sample = n.parse().ok(),
                ["ram", _, n] => at.ram = n.parse().ok(),
                ["digest", _, hash] => at.digest = u64::from_str_radix(hash, 16).ok(),
                ["code", _, _, address] => {
                    entries.entry((*tier).to_owned()).or_default().extend(address.parse::<u32>());
                }
                _ => {}
            }
        }
        for (tier, at) in &mut counts {
            let entries = entries.get(tier).filter(|e| e.len() == 2);
            at.code = entries.and_then(|e| self.functions.as_ref()?.bytes(e));
        }
        counts
    }
}

/// The output of a program by semihosting; an instruction takes a nanosecond of the board's time.
fn emulate(program: &Path, watch: Watch<'_>) -> Result<String, String> {
    let mut qemu = Command::new(EMULATOR)
        .args(["-M", "mps2-an386", "-cpu", "cortex-m4", "-nographic", "-monitor", "none"])
        .args(["-serial", "null", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(program)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| format!("{EMULATOR} cannot be started ({e})"))?;
    let mut pipe = qemu.stdout.take().ok_or("no output")?;
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    let begun = Instant::now();
    let ended = loop {
        match qemu.try_wait() {
            Ok(Some(status)) => break Ok(status),
            Ok(None) if watch.is_stopped() => break Err("interrupted".to_owned()),
            Ok(None) if begun.elapsed() > TIME_LIMIT => break Err("no end in sight".to_owned()),
            Ok(None) => sleep(Duration::from_millis(5)),
            Err(e) => break Err(e.to_string()),
        }
    };
    if ended.is_err() {
        drop(qemu.kill());
        drop(qemu.wait());
    }
    let text = reader.join().map_err(|_| "its output cannot be read".to_owned());
    ended?;
    text?.map_err(|e| e.to_string())
}
