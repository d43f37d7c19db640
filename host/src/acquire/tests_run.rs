//! Whole acquisitions: however they are disturbed, the scan is the same.

use std::cell::Cell;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use asperity_core::protocol::{Event, Frame, MachineState, Message, Microdegrees, Point};

use super::mock::{Device, Fate};
use super::transport::InProcess;
use super::{AcquireError, Draft, Job, Journal, JournalError, Patience, Summary, Trouble, run};

const PLAN: &str =
    "sigma_deg = [0, 30]\ntheta_from_deg = -2\ntheta_to_deg = 2\nintegration_ms = 1\n";

fn job(output: &Path, resume: bool) -> Job<'_> {
    let schedule = Draft::parse(PLAN, output).unwrap().schedule().unwrap();
    let patience = Patience::default();
    Job { schedule: Some(schedule), output, credit: 8, resume, recalibrate: false, patience }
}

fn go(job: &Job<'_>, device: Device) -> Result<Summary, AcquireError> {
    let mut last = 0;
    run(job, || Ok(InProcess::new(device)), &AtomicBool::new(false), &mut |progress| {
        assert!(progress.done > last && progress.total == 82);
        last = progress.done;
    })
}

/// The scan that an undisturbed instrument gives.
fn expected(folder: &Path) -> String {
    let path = folder.join("expected.csv");
    let done = go(&job(&path, false), Device::new()).unwrap();
    assert_eq!((done.points, done.resumed, done.recoveries), (82, 0, 0));
    assert!(!Journal::path_of(&path).exists());
    fs::read_to_string(path).unwrap()
}

/// An instrument that does something to the `k`-th point sent.
fn at_point(k: u32, mut tamper: impl FnMut(&mut Point) -> Fate + 'static) -> Device {
    let count = Cell::new(0);
    Device::tampered(move |_, frame: &mut Frame| {
        let Message::Event(Event::Point(point)) = &mut frame.message else { return Fate::Pass };
        count.set(count.get() + 1);
        if count.get() == k + 1 { tamper(point) } else { Fate::Pass }
    })
}

/// A journal that ends after 30 points, the instrument having been given up there.
fn broken_off(folder: &Path) -> (PathBuf, String) {
    let path = folder.join("scan.csv");
    let broken = at_point(30, |point| {
        point.reading.signal = f32::NAN;
        Fate::Pass
    });
    let Err(AcquireError::Link(e)) = go(&job(&path, false), broken) else { panic!("it went on") };
    assert!(matches!(*e.trouble, Trouble::Nonsense(_)), "{e}");
    let journal = fs::read_to_string(Journal::path_of(&path)).unwrap();
    assert_eq!(journal.lines().filter(|line| line.starts_with("point")).count(), 30);
    (path, journal)
}

/// The instrument as it was left: homed, set, calibrated.
fn as_left() -> Device {
    let mut device = Device::new();
    let status = &mut device.status;
    (status.homed, status.lamp, status.calibration) = (true, true, Some(2));
    (status.aperture, status.integration_us) = (Microdegrees(600_000), 1000);
    status.state = MachineState::Idle;
    device
}

#[test]
fn lost_repeated_and_garbled_frames_leave_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    assert_eq!(expected.lines().filter(|line| line.starts_with("30,")).count(), 41);
    for (name, every, fate) in
        [("drop", 3, Fate::Drop), ("corrupt", 4, Fate::Corrupt), ("twice", 1, Fate::Twice)]
    {
        let path = folder.path().join(name);
        // without a period that a client might fall in step with
        let chance =
            move |k: u64| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40).is_multiple_of(every);
        let fate = move |k: u64, _: &mut _| if chance(k) { fate } else { Fate::Pass };
        let device = Device::tampered(fate);
        let done = go(&job(&path, false), device).unwrap();
        assert_eq!(done.points, 82, "{name}");
        assert_eq!(fs::read_to_string(path).unwrap(), expected, "{name}");
    }
}

#[test]
fn a_lost_line_is_mended_and_leaves_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    for k in [0, 7, 8, 40, 41, 81] {
        let path = folder.path().join(format!("cut{k}"));
        let done = go(&job(&path, false), at_point(k, |_| Fate::Cut)).unwrap();
        assert_eq!(done.recoveries, 1, "{k}");
        assert_eq!(fs::read_to_string(path).unwrap(), expected, "{k}");
    }
}

#[test]
fn an_instrument_without_its_calibration_needs_another_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.csv");
    let error = go(&job(&path, false), at_point(20, |_| Fate::Restart)).unwrap_err();
    assert!(matches!(error, AcquireError::OtherCalibration { .. }), "{error}");
    let error = go(&job(&path, true), Device::new()).unwrap_err();
    assert!(error.to_string().contains("--recalibrate"), "{error}");
    let again = Job { recalibrate: true, ..job(&path, true) };
    let done = go(&again, Device::new()).unwrap();
    assert_eq!((done.calibrations.len(), done.points), (2, 82));
}

#[test]
fn a_resumed_scan_is_the_same_scan() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    let (path, journal) = broken_off(folder.path());
    let error = go(&job(&path, false), as_left()).unwrap_err();
    assert!(error.to_string().contains("--resume"), "{error}");
    // torn anywhere in its last line
    let torn = journal.trim_end().rfind('\n').unwrap() + 1;
    for end in torn..=journal.len() {
        fs::write(Journal::path_of(&path), &journal[..end]).unwrap();
        let done = go(&job(&path, true), as_left()).unwrap();
        assert_eq!(done.resumed, if end == journal.len() { 30 } else { 29 });
        assert_eq!(fs::read_to_string(&path).unwrap(), expected);
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn the_first_point_of_what_is_missing_is_approached_from_below() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = broken_off(folder.path());
    let job = Job { schedule: None, ..job(&path, true) };
    let seen = std::rc::Rc::new(Cell::new(0));
    let least = std::rc::Rc::clone(&seen);
    let mut device = as_left();
    device.tamper = Box::new(move |_, frame| {
        if let Message::Response(asperity_core::protocol::Response::Status(status)) = frame.message
        {
            least.set(least.get().max(status.theta.0));
        }
        Fate::Pass
    });
    go(&job, device).unwrap();
    // point 30 is at 1 degree
    assert_eq!(seen.get(), 500_000);
}

#[test]
fn damage_in_a_journal_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    let (path, journal) = broken_off(folder.path());
    let lines: Vec<&str> = journal.lines().collect();
    let without = |k: usize| [&lines[..k], &lines[k + 1..]].concat().join("\n") + "\n";
    let twice = |k: usize| [&lines[..=k], &lines[k..]].concat().join("\n") + "\n";
    let swapped = |k: usize| {
        [&lines[..k], &[lines[k + 1], lines[k]], &lines[k + 2..]].concat().join("\n") + "\n"
    };
    let changed = journal.replacen("point 0 5", "point 0 6", 1);
    fs::remove_file(Journal::path_of(&path)).unwrap();
    let (_, other) = broken_off(folder.path());
    let other: Vec<&str> = other.lines().collect();
    let five = lines.iter().position(|line| line.starts_with("point 0 5 ")).unwrap();
    // the same readings under the same schedule: only the journal is another one
    let mixed = [&lines[..five], &other[five..]].concat().join("\n") + "\n";
    for (what, text, line, word) in [
        ("changed", changed, five + 1, "checksum"),
        ("gone", without(five), five + 1, "does not follow"),
        ("twice", twice(five), five + 2, "does not follow"),
        ("swapped", swapped(five), five + 1, "does not follow"),
        ("last twice", twice(lines.len() - 1), lines.len() + 1, "does not follow"),
        ("of another journal", mixed, five + 1, "another journal"),
        ("no header", without(0), 1, "is no journal"),
        ("no schedule line", without(2), 3, "does not follow"),
    ] {
        fs::write(Journal::path_of(&path), text).unwrap();
        let Err(AcquireError::Journal(e)) = go(&job(&path, true), as_left()) else {
            panic!("{what}")
        };
        let said = e.to_string();
        assert!(
            matches!(e, JournalError::Damaged { line: at, .. } if at == line),
            "{what}: {said}"
        );
        assert!(said.contains(word), "{what}: {said}");
        // the remedy is one
        assert_eq!(said.contains("head -n"), line > 3, "{what}: {said}");
        if line > 3 {
            let text = fs::read_to_string(Journal::path_of(&path)).unwrap();
            let good: Vec<&str> = text.lines().take(line - 1).collect();
            fs::write(Journal::path_of(&path), good.join("\n") + "\n").unwrap();
            go(&job(&path, true), as_left()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), expected, "{what}");
            fs::remove_file(&path).unwrap();
        }
    }
}

#[test]
fn journals_of_the_former_version_go_on_to_the_same_scan() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    let (path, journal) = broken_off(folder.path());
    let mut old = String::new();
    for (k, line) in journal.lines().enumerate() {
        let text = line.rsplit_once(" ~").unwrap().0;
        let text = if k == 0 {
            // without the number that was drawn
            let words: Vec<&str> = text.splitn(6, ' ').collect();
            format!("{} 1 {} {} {}", words[0], words[2], words[3], words[5])
        } else {
            text.to_owned()
        };
        let sum = asperity_core::protocol::checksum(text.as_bytes());
        writeln!(old, "{text} ~{sum:08x}").unwrap();
    }
    assert!(old.starts_with("asperity-journal 1 42 "), "{old}");
    fs::write(Journal::path_of(&path), &old).unwrap();
    let stop = AtomicBool::new(false);
    let part = run(&job(&path, true), || Ok(InProcess::new(as_left())), &stop, &mut |at| {
        stop.store(at.done > 40, Ordering::SeqCst);
    });
    assert!(matches!(part, Err(AcquireError::Interrupted { .. })), "{part:?}");
    let begun = fs::read_to_string(Journal::path_of(&path)).unwrap();
    assert!(begun.starts_with(&old) && begun.len() > old.len());
    let done = go(&job(&path, true), as_left()).unwrap();
    assert!(done.resumed > 40);
    assert_eq!(fs::read_to_string(&path).unwrap(), expected);
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_no_journal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.csv");
    let journal = Journal::path_of(&path);
    for target in ["/dev/zero", "/"] {
        std::os::unix::fs::symlink(target, &journal).unwrap();
        let error = go(&job(&path, true), Device::new()).unwrap_err();
        assert!(error.to_string().contains("is no file"), "{error}");
        fs::remove_file(&journal).unwrap();
    }
}

#[test]
fn a_complete_journal_needs_no_instrument() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    let (path, begun) = broken_off(folder.path());
    let keep = folder.path().join("kept");
    let held = Journal::open(Journal::path_of(&path)).unwrap();
    let locked = go(&job(&path, true), as_left()).unwrap_err();
    assert!(locked.to_string().contains("another acquisition"), "{locked}");
    drop(held);
    // the journal as it is when the last point has come
    let watch = (Journal::path_of(&path), keep.clone());
    let schedule = job(&path, true);
    run(&schedule, || Ok(InProcess::new(as_left())), &AtomicBool::new(false), &mut |progress| {
        if progress.done == progress.total {
            fs::copy(&watch.0, &watch.1).unwrap();
        }
    })
    .unwrap();
    fs::rename(keep, Journal::path_of(&path)).unwrap();
    let never = || -> Result<InProcess<Device>, _> { panic!("not needed") };
    let done = run(&schedule, never, &AtomicBool::new(false), &mut |_| {}).unwrap();
    assert_eq!((done.resumed, fs::read_to_string(&path).unwrap()), (82, expected));
    assert!(!begun.is_empty() && !Journal::path_of(&path).exists());
    let missing = go(&schedule, as_left()).unwrap_err();
    assert!(missing.to_string().contains("nothing to resume"), "{missing}");
    let exists = go(&job(&path, false), as_left()).unwrap_err();
    assert!(exists.to_string().contains("exists already"), "{exists}");
}

#[test]
fn other_instruments_and_other_plans_do_not_continue_a_journal() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = broken_off(folder.path());
    let mut other = as_left();
    other.ident.serial = 1;
    let error = go(&job(&path, true), other).unwrap_err();
    assert!(error.to_string().contains("GP-200 1, not GP-200 42"), "{error}");
    let mut changed = job(&path, true);
    changed.schedule = Some(Draft::default().schedule().unwrap());
    let error = go(&changed, as_left()).unwrap_err();
    assert!(matches!(error, AcquireError::OtherPlan { .. }), "{error}");
}

/// Words of the message, and what is done to a point.
type Spoilt = (&'static str, fn(&mut Point));

#[test]
fn points_that_cannot_be_end_the_scan() {
    let folder = tempfile::tempdir().unwrap();
    let spoil: [Spoilt; 4] = [
        ("signal inf", |point| point.reading.signal = f32::INFINITY),
        ("it was read at", |point| point.theta.0 += 60_000),
        ("range 6", |point| point.reading.range = 6),
        ("more light than range 2 holds", |point| point.reading.over = true),
    ];
    for (k, (words, spoil)) in spoil.into_iter().enumerate() {
        let path = folder.path().join(format!("{k}.csv"));
        let device = at_point(50, move |point| {
            spoil(point);
            Fate::Pass
        });
        let error = go(&job(&path, false), device).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn an_interruption_keeps_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path());
    let path = folder.path().join("scan.csv");
    let stop = AtomicBool::new(false);
    let error = run(&job(&path, false), || Ok(InProcess::new(Device::new())), &stop, &mut |at| {
        stop.store(at.done > 50, Ordering::SeqCst);
    })
    .unwrap_err();
    assert!(matches!(error, AcquireError::Interrupted { done: 57, total: 82, .. }), "{error}");
    assert!(!path.exists());
    go(&job(&path, true), as_left()).unwrap();
    assert_eq!(fs::read_to_string(path).unwrap(), expected);
}
