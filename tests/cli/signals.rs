//! Signals at any moment of any long verb, once or twice: nothing temporary is left, and the status says how it ended.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::{Done, Folder};

/// A generous limit for everything that is waited for.
const LIMIT: Duration = Duration::from_mins(2);

/// The signals that are one to the program, and their numbers.
const SIGNALS: [(&str, i32); 3] = [("INT", 2), ("TERM", 15), ("HUP", 1)];

/// A small generator: the moments are the same in every run of the test, as far as the machine allows.
struct Moments(u64);

impl Moments {
    fn below(&mut self, n: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    fn wait(&mut self, most_ms: u64) {
        sleep(Duration::from_millis(self.below(most_ms)));
    }
}

/// A run that is ended by force if the test fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Running {
    fn ended(&mut self) -> bool {
        self.0.try_wait().expect("the run can be asked").is_some()
    }

    /// Whether it has signals caught; where the system does not tell, a second is enough.
    fn listens(&self, signals: &[(&str, i32)]) -> bool {
        let Some(caught) = of_process(&self.0.id().to_string(), "SigCgt:") else {
            sleep(Duration::from_secs(1));
            return true;
        };
        signals.iter().all(|(_, number)| caught & (1 << (number - 1)) != 0)
    }

    /// Sends a signal; a run that has just ended takes none.
    fn send(&mut self, (name, _): (&str, i32)) {
        if !self.ended() {
            let id = self.0.id().to_string();
            drop(Command::new("kill").args([&format!("-{name}"), &id]).output());
        }
    }

    fn wait(&mut self, what: &str, done: impl Fn(&mut Self) -> bool) {
        let begun = Instant::now();
        while !done(self) {
            assert!(begun.elapsed() < LIMIT, "{what} after {LIMIT:?}");
            sleep(Duration::from_millis(2));
        }
    }
}

/// A set of signals of a process, one bit each; `None` where the system does not tell.
fn of_process(id: &str, set: &str) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    u64::from_str_radix(status.lines().find_map(|l| l.strip_prefix(set))?.trim(), 16).ok()
}

/// The signals that these tests were not started deaf to, as `nohup` does: a program inherits that.
fn heard() -> Vec<(&'static str, i32)> {
    let ignored = of_process("self", "SigIgn:").unwrap_or(0);
    SIGNALS.into_iter().filter(|(_, number)| ignored & (1 << (number - 1)) == 0).collect()
}

/// Inputs of all verbs.
fn inputs() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    let height = |k: u32| 0.02 * f64::from((k.wrapping_mul(2_654_435_761)) >> 25);
    let row =
        |y: u32, n: u32| (0..n).map(|x| format!("{:.3}", height(y * n + x))).collect::<Vec<_>>();
    let rows = |n: u32| (0..n).map(|y| row(y, n).join(" ") + "\n").collect::<String>();
    let map = |n: u32| format!("# heights in um\n{}", rows(n));
    folder.write("map.txt", map(32));
    folder.write("large.txt", map(900));
    let map = "--map map.txt --pixel-um 0.5 --ior 1.5";
    folder.run(&format!("model measured-ray --set scale=1 {map} -o r.json")).ok();
    folder.run("model heights --set delta=0.5 --ior 1.5 -o h.json").ok();
    let pairs = |n| format!("wix,wiy,wiz,wox,woy,woz\n{}", "0,0.6,0.8,0,0,1\n".repeat(n));
    folder.write("pairs.csv", pairs(10));
    folder.write("many.csv", pairs(600_000));
    folder
}

/// A long run of every verb; `IN` is the folder of the inputs.
const LINES: [&str; 11] = [
    "fit IN/s.csv --method heights --fit-rays 1e7 -o f.json --plot f",
    "fit IN/s.csv --method ggx -o f.json --plot f",
    "compare IN/s.csv --methods ggx,heights --fit-rays 1e7 -o out",
    "scan IN/m.json --rays 1e9 --sigma 0,10 -o v.csv",
    "tabulate IN/h.json --rays 1e6 -o t.bsdft --rust t.rs --c t.h",
    "trade IN/s.csv --methods ggx,heights --fit-rays 1e7 --csv t.csv --plot t.svg",
    "stats IN/large.txt --pixel-um 0.5 --plot p",
    "check --map IN/map.txt --pixel-um 0.5 --ior 1.5 --rays 2e6",
    "demo -o demo",
    "eval IN/r.json --input IN/pairs.csv --rays 2e6 -o e.csv",
    "eval IN/m.json --input IN/many.csv -o e.csv",
];

/// What a run may not leave: temporary files, empty folders, empty files.
fn left(folder: &Folder) -> Vec<String> {
    let content = folder.content();
    let is_empty = |path: &Path| !content.keys().any(|other| other.parent() == Some(path));
    let bad = content.iter().filter(|(path, bytes)| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let empty = bytes.as_ref().map_or_else(|| is_empty(path), Vec::is_empty);
        name.starts_with('.') || name.ends_with(".part") || empty
    });
    bad.map(|(path, _)| path.display().to_string()).collect()
}

#[test]
fn a_signal_at_any_moment_leaves_nothing() {
    let rounds = if std::env::var_os("ASPERITY_EXTENSIVE").is_some() { 30 } else { 2 };
    let (inputs, mut moments) = (inputs(), Moments(20_261_128));
    let at = inputs.path("");
    let at = at.to_string_lossy();
    let signals = heard();
    let (mut first, mut second, mut finished) = (0, 0, 0);
    for round in 0..rounds {
        for line in LINES {
            let folder = Folder::new();
            let words = line.split(' ').map(|word| word.replace("IN/", &at));
            let mut command = folder.command(words);
            // what is made elsewhere is seen too
            let child = command.env("TMPDIR", folder.path("")).spawn().expect("the program runs");
            let mut run = Running(child);
            run.wait("deaf", |run| run.listens(&signals) || run.ended());
            moments.wait(500);
            let twice = round % 2 == 1;
            let signal = signals[moments.below(signals.len() as u64) as usize];
            run.send(signal);
            let mut last = signal;
            if twice {
                moments.wait(60);
                last = signals[moments.below(signals.len() as u64) as usize];
                run.send(last);
            }
            run.wait(line, Running::ended);
            let code = run.0.try_wait().expect("it has ended").and_then(|status| status.code());
            let what = format!("{line}, {} {twice}: {code:?} {:?}", signal.0, folder.names());
            match code {
                Some(0) => finished += 1,
                Some(1) => first += 1,
                // two that wait together are taken in any order
                Some(n) if twice && [signal.1, last.1].contains(&(n - 128)) => second += 1,
                _ => panic!("{what}"),
            }
            assert!(left(&folder).is_empty(), "{what}: {:?}", left(&folder));
        }
    }
    let all = rounds * LINES.len();
    assert!(
        first + second > all / 2 && second > 0,
        "{first} + {second} of {all}, {finished} finished"
    );
}

/// A program that was started deaf to the loss of its terminal stays so.
#[test]
fn nohup_is_heeded() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let mut command = Command::new("nohup");
    command.arg(crate::program::program()).args(["scan", "m.json", "--rays", "1e9", "-o", "v.csv"]);
    command.current_dir(folder.path("")).stdin(std::process::Stdio::null());
    let child =
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn();
    let Ok(child) = child else { return };
    let mut run = Running(child);
    run.wait("not busy", |_| folder.names().iter().any(|n| n.starts_with(".v.csv")));
    run.send(("HUP", 1));
    sleep(Duration::from_millis(300));
    assert!(!run.ended(), "hung up all the same");
    run.send(("TERM", 15));
    run.wait("still running", Running::ended);
    assert_eq!(folder.names(), ["m.json"]);
}

/// Who waits for the rest of a pipe is ended by the first signal.
#[test]
fn a_verb_that_waits_for_input_ends() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let mut command = folder.command(["eval", "m.json", "-o", "e.csv"]);
    let child = command.stdin(std::process::Stdio::piped()).spawn().expect("the program runs");
    let mut run = Running(child);
    run.wait("not busy", |_| folder.names().iter().any(|n| n.starts_with(".e.csv")));
    run.send(("INT", 2));
    run.wait("still running", Running::ended);
    let id = std::mem::replace(&mut run.0, Command::new("true").spawn().expect("true"));
    let done: Done = id.wait_with_output().expect("it has ended").into();
    assert_eq!((done.code, done.err.as_str()), (Some(1), "no: interrupted\n"));
    assert_eq!(folder.names(), ["m.json"]);
}
