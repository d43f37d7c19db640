//! The two programs: the instrument's, running until it is dropped, and the client's.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use asperity_tests::program;

/// No client may take longer, whatever it meets.
const TIME_LIMIT: Duration = Duration::from_mins(2);

fn path(name: &str) -> PathBuf {
    program::path(name, "acquire").unwrap_or_else(|why| panic!("{why}"))
}

/// `gonio-sim`, listening.
#[derive(Debug)]
pub(crate) struct Instrument {
    child: Child,
    /// What `--port` takes.
    pub(crate) port: String,
}

impl Instrument {
    /// Starts it; the arguments are separated by blanks.
    pub(crate) fn start(arguments: &str) -> Self {
        static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
        let mut child = Command::new(PROGRAM.get_or_init(|| path("gonio-sim")))
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.trim().strip_prefix("listening on ").unwrap_or_else(|| panic!("{line:?}"));
        Self { port: port.to_owned(), child }
    }
}

impl Drop for Instrument {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// `asperity` with arguments separated by blanks, in a folder.
pub(crate) fn asperity(folder: &Path, arguments: &str) -> Command {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    let mut command = Command::new(PROGRAM.get_or_init(|| path("asperity")));
    command.args(arguments.split_whitespace()).current_dir(folder).stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A client at work.
pub(crate) fn start(folder: &Path, arguments: &str) -> Child {
    asperity(folder, arguments).spawn().unwrap()
}

/// How a client ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
    pub(crate) time: Duration,
    /// Most memory it held, bytes; 0 where the system does not say.
    pub(crate) memory: u64,
}

impl Ended {
    /// Itself, if it ended well.
    #[track_caller]
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }
}

/// Runs a client to its end.
pub(crate) fn run(folder: &Path, arguments: &str) -> Ended {
    wait(start(folder, arguments), arguments)
}

/// Waits for a client that prints little.
pub(crate) fn wait(mut child: Child, what: &str) -> Ended {
    let (start, mut memory) = (Instant::now(), 0);
    while child.try_wait().unwrap().is_none() {
        memory = memory.max(high_water(child.id()));
        if start.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
            panic!("hangs: {what}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let time = start.elapsed();
    let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code: status.code(), out: text(stdout), err: text(stderr), time, memory }
}

fn high_water(pid: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}
