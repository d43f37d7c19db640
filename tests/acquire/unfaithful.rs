//! Every misbehaviour: a clear error within a bounded time, or the right bytes; a stage at rest; and what was
//! measured is kept and leads to the right bytes when the instrument behaves again.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use asperity::acquire::{
    AcquireError, InProcess, Job, Journal, Schedule, Summary, Transport as _, run,
};
use asperity_core::protocol::{Frame, MachineState, Message, Request, encode};
use asperity_firmware_sim::Config;
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::bench::{begin, config, folder, schedule};
use crate::hostile::{Behaviour, Heard, Hostile, kind, request};
use crate::misdeeds::{self, Expected, Misdeed};

/// Two incidences of 41 points, no setting as after power-on.
const PLAN: &str = "
    sigma_deg = [0, 30]
    theta_from_deg = -20
    theta_to_deg = 60
    theta_step_deg = 2
    aperture_deg = 2
    integration_ms = 5
    range = 0
    sample = \"hostile\"
    ior = 1.49
    rough_side = \"source\"
";

/// No acquisition may take longer on a line of this kind, by the line's clock: three times what an answer and a
/// lost line are waited for.
const LIMIT: Duration = Duration::from_mins(3);

fn acquire(line: &mut InProcess<Hostile>, job: &Job<'_>) -> Result<Summary, AcquireError> {
    run(job, || Ok(line), &AtomicBool::new(false), &mut |_| {})
}

/// Some requests by hand, as somebody else; nobody else owns it by then.
fn tell(line: &mut InProcess<Hostile>, requests: &[Request]) {
    for (sequence, request) in (0..).zip(requests) {
        let message = Message::Request(*request);
        line.send(encode(&Frame { session: 0xabc, sequence, message }).as_bytes()).unwrap();
        line.pause(Duration::from_millis(100));
    }
    let mut buffer = [0; 4096];
    while line.receive(&mut buffer, Duration::from_millis(300)).unwrap() > 0 {}
}

/// An instrument with its lamp switched off, and then somebody in between.
fn instrument(config: &Config, behaviour: Behaviour) -> InProcess<Hostile> {
    let mut line = InProcess::new(Hostile::new(config, Behaviour::good()));
    tell(&mut line, &[Request::Claim, Request::Lamp(false), Request::Release]);
    line.peer_mut().behave(behaviour);
    line
}

fn at_rest(line: &InProcess<Hostile>) -> bool {
    matches!(line.peer().simulator.state(), MachineState::Idle | MachineState::Fault)
}

/// The scan of an instrument that does what it says.
fn wanted(folder: &Path, schedule: &Schedule) -> (Vec<u8>, BTreeSet<String>) {
    let output = folder.join("good.csv");
    let mut line = instrument(&config(7), Behaviour::good());
    let done = acquire(&mut line, &begin(schedule, &output)).unwrap();
    assert_eq!((done.points, done.recoveries, done.above_beam), (82, 0, None));
    let kinds = line.peer().heard.keys().cloned().collect();
    (fs::read(output).unwrap(), kinds)
}

/// What comes of a misbehaviour; all that is wrong with that.
fn judge(
    deed: Misdeed,
    k: usize,
    schedule: &Schedule,
    folder: &Path,
    wanted: &[u8],
) -> Vec<String> {
    let Misdeed { name, expected, behaviour, drift, reachable, spoils } = deed;
    let mut wrong = Vec::new();
    let output = folder.join(format!("{k}.csv"));
    let journal = Journal::path_of(&output);
    let config = Config { drift_per_hour: drift, ..config(7) };
    let mut line = instrument(&config, behaviour);
    let begun = line.now();
    let result = acquire(&mut line, &begin(schedule, &output));
    let took = line.now().saturating_sub(begun);
    let mut check = |good: bool, what: String| {
        if !good {
            wrong.push(format!("{name}: {what}"));
        }
    };
    check(took < LIMIT, format!("it took {took:?}"));
    check(at_rest(&line) || !reachable, "the stage goes on".to_owned());
    match (&result, expected) {
        (Ok(_), Expected::Completes) => {
            check(fs::read(&output).is_ok_and(|got| got == wanted), "other bytes".to_owned());
            check(!journal.exists(), "a journal is left".to_owned());
            return wrong;
        }
        (Err(e), Expected::Ends(words)) => {
            let text = e.to_string();
            let named = words.iter().any(|word| text.contains(word));
            let all = words.iter().all(|word| text.contains(word));
            let any = words.len() > 1 && words.iter().all(|word| word.contains(" is not over"));
            check(if any { named } else { all }, format!("`{text}`, expected {words:?}"));
            check(text.len() < 420 && !text.contains('\n'), format!("a long message: {text}"));
            check(!output.exists(), "a scan in spite of the error".to_owned());
        }
        (Ok(_), _) => check(false, "it completed".to_owned()),
        (Err(e), _) => check(false, format!("`{e}`")),
    }
    line.peer_mut().mend();
    line.pause(Duration::from_secs(6));
    check(at_rest(&line), "the stage goes on after 6 s".to_owned());
    if drift != 0.0 {
        // another lamp
        line = instrument(&self::config(7), Behaviour::good());
    }
    let _ = line.reconnect();
    tell(&mut line, &[Request::Claim, Request::ClearFault, Request::Release]);
    let resume = journal.exists();
    let mut again = again(schedule, &output, resume);
    if spoils {
        let refused = acquire(&mut line, &again).map_err(|e| e.to_string());
        let named = refused.as_ref().is_err_and(|e| e.contains("delete the journal"));
        check(named, format!("{refused:?} of a journal that is false"));
        fs::remove_file(&journal).unwrap();
        again = self::again(schedule, &output, false);
    }
    let before = journal_points(&journal);
    match acquire(&mut line, &again) {
        Ok(done) => check(done.resumed == before, format!("{} of {before} resumed", done.resumed)),
        Err(e) => check(false, format!("and then `{e}`")),
    }
    check(fs::read(&output).is_ok_and(|got| got == wanted), "other bytes afterwards".to_owned());
    check(!journal.exists(), "a journal is left over".to_owned());
    wrong
}

/// Once more, with the journal if there is one.
fn again<'a>(schedule: &Schedule, output: &'a Path, resume: bool) -> Job<'a> {
    let plan_given = (!resume).then(|| schedule.clone());
    Job { schedule: plan_given, resume, recalibrate: resume, ..begin(schedule, output) }
}

fn journal_points(journal: &Path) -> u64 {
    let text = fs::read_to_string(journal).unwrap_or_default();
    text.lines().filter(|line| line.starts_with("point ")).count() as u64
}

/// Judges all; shows all that is wrong.
fn all_good(deeds: Vec<Misdeed>) {
    let (folder, schedule) = (folder(), schedule(PLAN));
    let (wanted, _) = wanted(folder.path(), &schedule);
    let count = deeds.len();
    let wrong: Vec<String> = deeds
        .into_par_iter()
        .enumerate()
        .flat_map(|(k, deed)| judge(deed, k, &schedule, folder.path(), &wanted))
        .collect();
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn whatever_an_instrument_does_ends_clearly_or_right() {
    let deeds = misdeeds::all();
    assert!(deeds.len() >= 60, "{}", deeds.len());
    all_good(deeds);
}

/// What is said when requests of a kind are never answered.
fn silence(kind: &str) -> Expected {
    Expected::Ends(match kind {
        "Identify" => &["no answer within 5"],
        "Claim" => &["its ownership failed 3 times"],
        "Status" => &["not when it is asked for its status"],
        "Home" => &["homing failed 3 times"],
        "Move" => &["a movement failed 3 times"],
        "Aperture" => &["the aperture failed 3 times"],
        "Range" => &["the range failed 3 times"],
        "Integration" => &["the integration time failed 3 times"],
        "Lamp" => &["switching the lamp failed 3 times"],
        "Dark" | "Reference" => &["a calibration failed 3 times"],
        "LastCalibration" => &["the calibration's values failed 3 times"],
        "Scan" => &["the scan of a segment failed 3 times"],
        "Continue" => &["more points of a segment failed 3 times"],
        // at the end, when all is in the journal
        _ => return Expected::Completes,
    })
}

/// The kinds of requests of an acquisition.
fn kinds() -> BTreeSet<String> {
    let folder = folder();
    let kinds = wanted(folder.path(), &schedule(PLAN)).1;
    assert!(kinds.len() >= 15 && kinds.contains("Reference"), "{kinds:?}");
    kinds
}

/// Something is done to requests of that kind, to the first alone or to all of them.
fn at(name: &str, once: bool, what: Heard) -> Behaviour {
    let name = name.to_owned();
    Behaviour::hears(move |frame, count| {
        let this = request(frame).is_some_and(|request| kind(&request) == name);
        if this && !(once && count > 1) { what } else { Heard::Pass }
    })
}

fn deed(name: String, expected: Expected, behaviour: Behaviour) -> Misdeed {
    Misdeed { name, expected, behaviour, drift: 0.0, reachable: true, spoils: false }
}

#[test]
fn silence_at_any_step_ends_clearly_and_one_lost_request_does_no_harm() {
    let mut deeds = Vec::new();
    for kind in kinds() {
        let silent = at(&kind, false, Heard::Lost);
        let silent = deed(format!("silent to {kind}"), silence(&kind), silent);
        deeds.push(Misdeed { reachable: kind != "Stop" && kind != "Status", ..silent });
        let once = at(&kind, true, Heard::Lost);
        deeds.push(deed(format!("silent to {kind} once"), Expected::Completes, once));
    }
    all_good(deeds);
}

#[test]
fn a_line_that_closes_at_any_step_is_opened_again_or_ends_it_clearly() {
    let mut deeds = Vec::new();
    for kind in kinds() {
        let soon = at(&kind, true, Heard::Cut(Duration::from_secs(2)));
        deeds.push(deed(format!("cut at {kind} for a while"), Expected::Completes, soon));
        let never = at(&kind, false, Heard::Cut(Duration::from_hours(1)));
        let expected = match kind.as_str() {
            "Release" | "Stop" => Expected::Completes,
            _ => Expected::Ends(&["the connection was lost and not back within"]),
        };
        deeds.push(deed(format!("cut at {kind} for good"), expected, never));
    }
    all_good(deeds);
}

#[test]
fn an_interruption_at_any_moment_stops_the_stage_at_once_and_keeps_what_is_measured() {
    let (folder, schedule) = (folder(), schedule(PLAN));
    let (wanted, _) = wanted(folder.path(), &schedule);
    let mut generator = Pcg64Mcg::new(15);
    let moments: Vec<u64> = (0..40).map(|_| u64::from(generator.next_u32() % 3500)).collect();
    let begun = moments.par_iter().enumerate().map(|(k, &ms)| {
        let output = folder.path().join(format!("{k}.csv"));
        let journal = Journal::path_of(&output);
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let mut first = true;
        // once, at that time after the first byte
        let behaviour = Behaviour::good().chatters(Duration::from_millis(ms + 1), move |_| {
            flag.store(!std::mem::take(&mut first), Ordering::SeqCst);
            Vec::new()
        });
        let mut line = instrument(&config(7), behaviour);
        let start = line.now();
        let result = run(&begin(&schedule, &output), || Ok(&mut line), &stop, &mut |_| {});
        let late = line.now().saturating_sub(start).saturating_sub(Duration::from_millis(ms));
        assert!(late < Duration::from_millis(500), "{ms} ms: {late:?}");
        assert!(at_rest(&line), "{ms} ms: the stage goes on");
        assert_eq!(line.peer().simulator.status().owner, None, "{ms} ms");
        let done = match result {
            Err(AcquireError::Interrupted { done, .. }) => done,
            Err(AcquireError::NotBegun) => 0,
            Ok(_) => return 0,
            Err(e) => panic!("{ms} ms: {e}"),
        };
        assert!(!output.exists() && done == journal_points(&journal), "{ms} ms");
        line.peer_mut().mend();
        let resume = journal.exists();
        let resumed = acquire(&mut line, &again(&schedule, &output, resume)).unwrap();
        assert_eq!(resumed.resumed, done, "{ms} ms");
        assert!(fs::read(&output).unwrap() == wanted, "{ms} ms: other bytes");
        u32::from(done > 0)
    });
    // some of them in the middle of points
    assert!(begun.sum::<u32>() > 5);
}

#[test]
fn however_much_credit_the_instrument_hears_of_its_owner_every_second() {
    let (folder, schedule) = (folder(), schedule(&PLAN.replace("= 5\n", "= 400\n")));
    for credit in [1, 16, 1801] {
        let output = folder.path().join(format!("{credit}.csv"));
        // as slow as a real one, and less patient
        let config = Config { acceleration: 1, silence_us: 1_500_000, ..config(7) };
        let mut line = instrument(&config, Behaviour::good());
        let job = Job { credit, ..begin(&schedule, &output) };
        let done = acquire(&mut line, &job).unwrap();
        assert_eq!((done.points, done.recoveries), (82, 0), "credit {credit}");
        let peer = line.peer();
        assert!(peer.longest_silence < Duration::from_millis(1450), "{:?}", peer.longest_silence);
        // begun once each
        assert_eq!(peer.heard.get("Scan"), Some(&2), "credit {credit}");
    }
}
