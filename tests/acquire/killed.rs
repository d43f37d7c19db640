//! A client killed at any moment, and resumed: the same file to the byte.

use std::fs;
use std::path::Path;
use std::time::Duration;

use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

use crate::bench::folder;
use crate::programs::{Instrument, run, start};

const INSTRUMENT: &str = "--rays 2000 --acceleration 150 --seed 3 --silence-ms 600";
const PLAN: &str = "--sigma 0,30 --theta-range -20:50 --step 0.2 --sample killed --ior 1.49 \
                    --rough-side source --integration-ms 20 --credit 8";

/// What one client after another leaves behind.
#[derive(Clone, Copy, Debug, Default)]
struct Kills {
    before_the_journal: u32,
    with_a_journal: u32,
    after_the_end: u32,
}

/// Kills `count` acquisitions on one line at random moments, and resumes each.
fn kill(line: &str, count: u32, seed: u128) -> Kills {
    let (folder, instrument) = (folder(), Instrument::start(&format!("{line} {INSTRUMENT}")));
    let folder = folder.path();
    let acquire =
        |file: &str, more: &str| format!("acquire --port {} -o {file} {more}", instrument.port);
    let undisturbed = run(folder, &acquire("undisturbed.csv", PLAN)).ok();
    let wanted = fs::read(folder.join("undisturbed.csv")).unwrap();
    let mut generator = Pcg64Mcg::new(seed);
    let mut kills = Kills::default();
    for k in 0..count {
        let file = format!("{k}.csv");
        let share = f64::from(generator.next_u32()) / f64::from(u32::MAX);
        let mut child = start(folder, &acquire(&file, PLAN));
        std::thread::sleep(undisturbed.time.mul_f64(share));
        child.kill().unwrap();
        child.wait().unwrap();
        let there = |name: &str| folder.join(name).exists();
        let resume = match (there(&format!("{file}.journal")), there(&file)) {
            (true, _) => {
                kills.with_a_journal += 1;
                Some("--resume")
            }
            (false, true) => {
                kills.after_the_end += 1;
                None
            }
            (false, false) => {
                kills.before_the_journal += 1;
                Some(PLAN)
            }
        };
        if let Some(how) = resume {
            run(folder, &acquire(&file, how)).ok();
        }
        assert_eq!(fs::read(folder.join(&file)).unwrap(), wanted, "{line}: kill {k} at {share}");
        tidy(folder, &file);
    }
    kills
}

/// What was killed may leave its temporary files; nothing else.
fn tidy(folder: &Path, file: &str) {
    fs::remove_file(folder.join(file)).unwrap();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(name == "undisturbed.csv" || name.starts_with('.'), "left over: {name}");
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn fifty_killed_acquisitions_resume_to_the_same_bytes() {
    let network = std::thread::spawn(|| kill("--tcp 127.0.0.1:0", 25, 1));
    let terminal = kill("--pty", 25, 2);
    let network = network.join().unwrap();
    println!("terminal {terminal:?}, network {network:?}");
    // kills that all fall into one phase would prove little
    assert!(terminal.with_a_journal + network.with_a_journal > 20);
}

#[test]
fn a_killed_client_leaves_a_stage_at_rest() {
    let (folder, instrument) = (folder(), Instrument::start("--pty --rays 2000 --silence-ms 400"));
    let folder = folder.path();
    // not accelerated: it moves for seconds
    let line = format!("acquire --port {} -o a.csv {PLAN}", instrument.port);
    let mut child = start(folder, &line);
    std::thread::sleep(Duration::from_millis(700));
    child.kill().unwrap();
    child.wait().unwrap();
    std::thread::sleep(Duration::from_millis(800));
    let status = run(folder, &format!("instrument status --port {} --json", instrument.port)).ok();
    let status: serde_json::Value = serde_json::from_str(&status.out).unwrap();
    assert_eq!(status["state"], "idle", "{status}");
}
