//! Thousands of scans on bad lines with broken machines: the file is the right one, or an error says why not
//! and the journal leads to the right one.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

use asperity::acquire::{AcquireError, InProcess, Job, Journal, Schedule};
use asperity_core::protocol::{Axis, Frame, MachineState, Message, Request, encode};
use asperity_firmware_sim::MachineFault;
use asperity_firmware_sim::fault::LinkFaults;
use asperity_tests::count;
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::bench::{Bench, Trouble, acquire, begin, config, folder, schedule};

/// Three incidences of 41 points.
const PLAN: &str = "
    sigma_deg = [0, 30, 60]
    theta_from_deg = -20
    theta_to_deg = 60
    theta_step_deg = 2
    integration_ms = 5
    sample = \"soak\"
    ior = 1.49
    rough_side = \"source\"
";

/// Attempts with `--resume` on a line that has been mended.
const ATTEMPTS: usize = 4;

/// What goes wrong in campaign `k`; the name of the kind for the summary.
fn trouble(k: usize) -> (&'static str, Trouble) {
    let mut generator = Pcg64Mcg::new(0x50a << 32 | k as u128);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX);
    let rate = (0.02 + 0.2 * uniform()) as f32;
    let none = LinkFaults::NONE;
    let mut all = LinkFaults::rate(rate * 0.5);
    (all.stall, all.disconnect) = (0.02 * rate, 0.02 * rate);
    let faults = [
        MachineFault::StalledAxis(Axis::Sigma),
        MachineFault::StalledAxis(Axis::Theta),
        MachineFault::LimitSwitch(Axis::Sigma),
        MachineFault::LimitSwitch(Axis::Theta),
        MachineFault::OverRange,
        MachineFault::LampOff,
    ];
    let kinds: [(&str, LinkFaults, f64, usize); 14] = [
        ("drop", LinkFaults { drop: rate, ..none }, 0.0, 0),
        ("flip", LinkFaults { flip: rate, ..none }, 0.0, 0),
        ("duplicate", LinkFaults { duplicate: rate, ..none }, 0.0, 0),
        ("delay", LinkFaults { delay: rate, ..none }, 0.0, 0),
        ("truncate", LinkFaults { truncate: rate, ..none }, 0.0, 0),
        ("stall", LinkFaults { stall: 0.2 * rate, ..none }, 0.0, 0),
        ("disconnect", LinkFaults { disconnect: 0.2 * rate, ..none }, 0.0, 0),
        ("all", all, 0.0, 0),
        ("all, machine", all, 0.0, 1),
        ("1 % of bytes", none, 0.01, 0),
        ("10 % of bytes", none, 0.1, 0),
        ("10 % of bytes, all, machine", all, 0.1, 2),
        ("machine", none, 0.0, 1),
        ("machine twice", none, 0.0, 2),
    ];
    let (name, link, noise, broken) = kinds[k % kinds.len()];
    let machine = (0..broken)
        .map(|_| (Duration::from_secs_f64(3.0 * uniform()), faults[(6.0 * uniform()) as usize % 6]))
        .collect();
    // from the first byte on nobody would be found; so mostly from somewhere in the scan on
    let noise_from = Duration::from_secs_f64((2.2 * uniform() - 0.2).max(0.0));
    (name, Trouble { link, noise, noise_from, machine, seed: k as u64 })
}

/// How a campaign went.
#[derive(Clone, Debug, Default)]
struct Tally {
    campaigns: u32,
    at_once: u32,
    resumed: u32,
    bytes_hit: u64,
    bad_frames: u64,
    errors: BTreeMap<String, u32>,
}

impl Tally {
    fn with(mut self, other: Self) -> Self {
        self.campaigns += other.campaigns;
        self.at_once += other.at_once;
        self.resumed += other.resumed;
        self.bytes_hit += other.bytes_hit;
        self.bad_frames += other.bad_frames;
        for (error, count) in other.errors {
            *self.errors.entry(error).or_default() += count;
        }
        self
    }
}

/// The kind of an error, without its numbers.
fn kind(error: &AcquireError) -> String {
    match error {
        AcquireError::Link(e) => {
            let debug = format!("{:?}", e.trouble);
            debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
        }
        other => {
            let debug = format!("{other:?}");
            debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
        }
    }
}

/// Leaves the fault, as the operator does who has looked what is wrong.
fn clear(line: &mut InProcess<Bench>) {
    use asperity::acquire::Transport as _;
    // the owner that failed is forgotten after its silence, and its stage is at rest
    line.pause(Duration::from_secs(6));
    let state = line.peer().simulator.state();
    assert!(matches!(state, MachineState::Idle | MachineState::Fault), "still {state}");
    for (sequence, request) in
        [Request::Claim, Request::ClearFault, Request::Release].into_iter().enumerate()
    {
        let message = Message::Request(request);
        let frame = Frame { session: 0xabc, sequence: sequence as u16, message };
        line.send(encode(&frame).as_bytes()).unwrap();
        line.pause(Duration::from_millis(100));
    }
    // whatever was answered
    let mut buffer = [0; 4096];
    while line.receive(&mut buffer, Duration::from_millis(300)).unwrap() > 0 {}
}

fn campaign(k: usize, schedule: &Schedule, folder: &Path, wanted: &[u8]) -> Tally {
    let (name, trouble) = trouble(k);
    let output = folder.join(format!("{k}.csv"));
    let mut line = InProcess::new(Bench::new(&config(7), &trouble));
    let mut tally = Tally { campaigns: 1, ..Tally::default() };
    let mut job = begin(schedule, &output);
    job.credit = [1, 4, 16, 64][k / 14 % 4];
    let mut result = acquire(&mut line, &job);
    let bad = line.peer().simulator.diagnostics().bad_frames;
    (tally.bytes_hit, tally.bad_frames) = (line.peer().hit, u64::from(bad));
    if result.is_ok() {
        tally.at_once = 1;
    }
    for _ in 0..ATTEMPTS {
        let Err(error) = result else { break };
        let text = error.to_string();
        assert!(!text.is_empty() && text.len() < 400 && !text.contains('\n'), "{k} {name}: {text}");
        *tally.errors.entry(kind(&error)).or_default() += 1;
        assert!(!output.exists(), "{k} {name}: a file in spite of {text}");
        line.peer_mut().mend();
        clear(&mut line);
        let resume = Journal::path_of(&output).exists();
        let again = Job {
            schedule: (!resume).then(|| schedule.clone()),
            resume,
            recalibrate: resume,
            ..job.clone()
        };
        result = acquire(&mut line, &again);
        tally.resumed = 1;
    }
    if let Err(error) = result {
        panic!("campaign {k} ({name}) does not end well even on a good line: {error}");
    }
    let written = fs::read(&output).unwrap();
    assert!(written == wanted, "campaign {k} ({name}): {}", String::from_utf8_lossy(&written));
    assert!(!Journal::path_of(&output).exists(), "campaign {k} ({name}): the journal is left over");
    fs::remove_file(output).unwrap();
    tally
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn thousands_of_scans_with_faults_end_right_or_say_why_and_resume() {
    let (folder, schedule) = (folder(), schedule(PLAN));
    let output = folder.path().join("undisturbed.csv");
    let mut line = InProcess::new(Bench::new(&config(7), &Trouble::NONE));
    let summary = acquire(&mut line, &begin(&schedule, &output)).unwrap();
    assert_eq!((summary.points, summary.recoveries), (123, 0));
    let wanted = fs::read(&output).unwrap();

    let total = (0..count(5040))
        .into_par_iter()
        .map(|k| campaign(k, &schedule, folder.path(), &wanted))
        .reduce(Tally::default, Tally::with);
    println!("{total:#?}");
    assert!(total.campaigns >= 5000);
    // faults that hit nothing would prove nothing, nor would lines on which nothing gets through
    assert!(total.at_once > 2000 && total.resumed > 1000, "{total:?}");
    assert!(total.bytes_hit > 50_000 && total.bad_frames > 50_000, "{total:?}");
}
