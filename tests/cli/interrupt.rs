//! Ctrl-C: the first ends the work with what it has.

use std::fs;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::{Done, Folder};

/// A generous limit for everything that is waited for.
const LIMIT: Duration = Duration::from_mins(1);

/// A run that is ended by force if the test fails.
struct Running(Option<Child>);

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            drop(child.kill());
            drop(child.wait());
        }
    }
}

impl Running {
    fn child(&mut self) -> &mut Child {
        self.0.as_mut().expect("not ended yet")
    }

    /// Waits until there is a file whose name starts with the sign, or is it in a folder, and the run listens to the signal.
    fn wait_until_busy(&mut self, folder: &Folder, sign: &str) {
        let begun = Instant::now();
        let is_there =
            || folder.names().iter().any(|n| n.starts_with(sign)) || folder.path(sign).exists();
        while !(is_there() && self.listens()) {
            let ended = self.child().try_wait().expect("the run can be asked");
            assert!(ended.is_none(), "ended by itself: {ended:?}");
            assert!(begun.elapsed() < LIMIT, "not busy after {LIMIT:?}: {:?}", folder.names());
            sleep(Duration::from_millis(10));
        }
    }

    /// Whether SIGINT is caught; where the system does not tell, a second is enough.
    fn listens(&mut self) -> bool {
        let Ok(status) = fs::read_to_string(format!("/proc/{}/status", self.child().id())) else {
            sleep(Duration::from_secs(1));
            return true;
        };
        let caught = status.lines().find_map(|l| l.strip_prefix("SigCgt:")).unwrap_or("0");
        u64::from_str_radix(caught.trim(), 16).is_ok_and(|set| set & (1 << (2 - 1)) != 0)
    }

    /// One Ctrl-C.
    fn interrupt(&mut self) {
        let id = self.child().id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().expect("kill runs");
        assert!(sent.success());
    }

    /// The end of the run.
    fn end(mut self) -> Done {
        let begun = Instant::now();
        while self.child().try_wait().expect("the run can be asked").is_none() {
            assert!(begun.elapsed() < LIMIT, "still running {LIMIT:?} after Ctrl-C");
            sleep(Duration::from_millis(10));
        }
        let child = self.0.take().expect("not ended yet");
        child.wait_with_output().expect("the run has ended").into()
    }
}

/// A scan that is being made.
const OPENED: &str = ".scan.csv.";

fn start(folder: &Folder, line: &str, sign: &str) -> Running {
    let child = folder.command(line.split_whitespace()).spawn().expect("the program runs");
    let mut run = Running(Some(child));
    run.wait_until_busy(folder, sign);
    run
}

#[test]
fn a_scan_without_a_finished_incidence_leaves_nothing() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.write("scan.csv", "an older scan");
    let mut run = start(&folder, "scan m.json --rays 1e9 --sigma 0,10 -o scan.csv", OPENED);
    run.interrupt();
    let done = run.end().with_code(1);
    assert!(done.err.starts_with("no: interrupted"), "{}", done.err);
    assert!(done.out.is_empty(), "{}", done.out);
    assert_eq!(folder.names(), ["m.json", "scan.csv"]);
    assert_eq!(folder.text("scan.csv"), "an older scan");
}

#[test]
fn a_scan_keeps_its_finished_incidences() {
    const INCIDENCES: usize = 8000;
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let sigmas: Vec<String> = (0..INCIDENCES).map(|k| format!("{}", k as f64 / 100.0)).collect();
    let line = format!(
        "scan m.json --rays 1e5 --step 45 --theta-range -45:45 --sigma {} -o scan.csv",
        sigmas.join(",")
    );
    // How long the first incidence takes is not known: wait twice as long each time.
    let mut wait = Duration::from_millis(300);
    let done = loop {
        let mut run = start(&folder, &line, OPENED);
        sleep(wait);
        run.interrupt();
        let done = run.end().with_code(1);
        if folder.path("scan.csv").exists() || wait > LIMIT {
            break done;
        }
        wait *= 2;
    };
    assert!(done.err.starts_with("no: interrupted; the finished incidences"), "{}", done.err);
    assert_eq!(folder.names(), ["m.json", "scan.csv"]);
    let text = folder.text("scan.csv");
    let rows = text.lines().filter(|l| !l.starts_with(['#', 's'])).count();
    assert!(rows >= 3 && rows % 3 == 0 && rows < 3 * INCIDENCES, "{rows} rows");
    assert!(done.out.starts_with(&format!("{rows} readings")), "{}", &done.out);
    // what was kept is a scan, if one of too few readings to be believed
    folder.run("fit scan.csv --method ggx --max-misfit 1000 --sigma-range 0:0 --accept").ok();
}

#[test]
fn a_comparison_keeps_its_finished_fits() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    let line = "compare s.csv --methods ggx,heights,normals --fit-rays 1e9 -o .";
    let mut run = start(&folder, line, "s/ggx.cell.json");
    run.interrupt();
    let done = run.end().with_code(1);
    assert!(done.err.contains("no: interrupted; what was finished is written"), "{}", done.err);
    let results = &folder.json("compare.json")["samples"][0]["results"];
    assert_eq!((&results[0]["method"], &results[0]["describes"]), (&"ggx".into(), &true.into()));
    // a fit of so many rays is not finished; what it has found so far is there, and is no fit
    assert_eq!(results[1]["describes"], false, "{results}");
    assert!(results[1]["notes"].to_string().contains("interrupted"), "{results}");
    assert!(
        !folder.path("s/heights.cell.json").exists() && folder.path("s/ggx.cell.json").exists()
    );
    assert!(folder.path("s/all-log.png").exists() && folder.path("report.html").exists());
    assert!(!folder.names().iter().any(|n| n.starts_with('.')), "{:?}", folder.names());
}

#[test]
fn a_trade_keeps_its_finished_rows() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    let line = "trade s.csv --methods ggx,heights --fit-rays 1e9 --table-kib 8 --csv t.csv";
    // How long the first method takes is not known: wait twice as long each time.
    let mut wait = Duration::from_secs(2);
    let done = loop {
        let mut run = start(&folder, line, ".t.csv.");
        sleep(wait);
        run.interrupt();
        let done = run.end().with_code(1);
        if folder.path("t.csv").exists() || wait > LIMIT {
            break done;
        }
        assert!(done.err.contains("no: interrupted before"), "{}", done.err);
        wait *= 2;
    };
    assert!(done.err.contains("no: interrupted; what was finished is written"), "{}", done.err);
    let text = folder.text("t.csv");
    assert!(text.lines().count() > 1 && !text.contains("heights"), "{text}");
    assert_eq!(folder.names(), ["m.json", "s.csv", "t.csv"]);
}
