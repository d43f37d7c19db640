//! Signals at random moments of an acquisition: the stage stops at once, and nothing is left but the journal.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

use crate::bench::folder;
use crate::programs::{Ended, Instrument, run, start, wait};

/// An instrument that would go on for ever if nobody told it to stop.
const INSTRUMENT: &str = "--rays 1000 --acceleration 40 --seed 4 --silence-ms 600000";
const PLAN: &str = "--sigma 0,30 --theta-range -20:40 --step 1 --sample signalled --ior 1.49 \
                    --rough-side source --integration-ms 100 --credit 8";

fn signal(child: &Child, name: &str) {
    let pid = child.id().to_string();
    assert!(Command::new("kill").args([&format!("-{name}"), &pid]).status().unwrap().success());
}

/// What the instrument is doing, and whether somebody owns it.
fn state(folder: &Path, port: &str) -> (String, bool) {
    let status = run(folder, &format!("instrument status --port {port} --json")).ok();
    let status: serde_json::Value = serde_json::from_str(&status.out).unwrap();
    (status["state"].as_str().unwrap_or_default().to_owned(), status["in_use"] == true)
}

/// Signals, one after another, at a moment of an acquisition; how it ended.
fn disturb(folder: &Path, port: &str, file: &str, after: Duration, names: &[&str]) -> Ended {
    let mut generator = Pcg64Mcg::new(u128::from(after.as_micros() as u64));
    let child = start(folder, &format!("acquire --port {port} -o {file} {PLAN}"));
    std::thread::sleep(after);
    for name in names {
        signal(&child, name);
        std::thread::sleep(Duration::from_millis(u64::from(generator.next_u32() % 30)));
    }
    wait(child, file)
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn a_signal_at_any_moment_stops_the_stage_and_leaves_the_journal() {
    let instrument = Instrument::start(&format!("--pty {INSTRUMENT}"));
    let (folder, port) = (folder(), &instrument.port);
    let folder = folder.path();
    let undisturbed = run(folder, &format!("acquire --port {port} -o good.csv {PLAN}")).ok();
    let wanted = fs::read(folder.join("good.csv")).unwrap();
    let mut generator = Pcg64Mcg::new(13);
    let cases: [&[&str]; 9] = [
        &["INT"],
        &["TERM"],
        &["HUP"],
        &["INT", "INT"],
        &["TERM", "TERM"],
        &["HUP", "INT"],
        &["INT"],
        &["TERM"],
        &["HUP", "HUP", "HUP"],
    ];
    let mut kept = 0;
    for (k, names) in cases.into_iter().enumerate() {
        let share = 0.1 + 0.8 * f64::from(generator.next_u32()) / f64::from(u32::MAX);
        let file = format!("{k}.csv");
        let done = disturb(folder, port, &file, undisturbed.time.mul_f64(share), names);
        let (what, in_use) = state(folder, port);
        assert_eq!((what.as_str(), in_use), ("idle", false), "{names:?} at {share}: {done:?}");
        let there = |name: &str| folder.join(name).exists();
        let journal = there(&format!("{file}.journal"));
        match done.code {
            Some(0) => assert!(there(&file) && !journal, "{names:?}: {done:?}"),
            Some(1) => {
                assert!(done.err.contains("interrupted"), "{names:?}: {done:?}");
                assert_eq!(journal, done.err.contains("--resume"), "{names:?}: {done:?}");
            }
            // before there was anything to be told, or by the second one
            None | Some(130) => {}
            code => panic!("{code:?} of {names:?}: {done:?}"),
        }
        kept += u32::from(journal);
        if journal {
            run(folder, &format!("acquire --port {port} -o {file} --resume")).ok();
            assert_eq!(fs::read(folder.join(&file)).unwrap(), wanted, "{names:?} at {share}");
        }
        drop(fs::remove_file(folder.join(&file)));
        let left: Vec<_> = fs::read_dir(folder).unwrap().flatten().map(|e| e.file_name()).collect();
        assert_eq!(left, ["good.csv"], "{names:?} at {share}: {done:?}");
    }
    println!("{kept} of {} with a journal; undisturbed {:?}", cases.len(), undisturbed.time);
    assert!(kept >= 5, "{kept}");
}
