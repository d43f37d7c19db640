//! One incidence: from the first missing point to the last.

use std::time::Duration;

use asperity_core::protocol::{
    Axis, DeviceError, Event, MachineState, Microdegrees, Point, RANGES, Range, Request, Segment,
};

use super::client::Client;
use super::error::Trouble;
use super::estimate;
use super::journal::{Journal, Stored};
use super::plan::Plan;
use super::run::{AcquireError, Progress};
use super::transport::Transport;

/// How far from its place a point may have been read, by the encoder, microdegrees; never more than
/// half a step.
const OFF_PLACE: i32 = 20_000;
/// How many readings an instrument may take until it has found its range.
const AUTO_READINGS: u32 = 2 * RANGES as u32;

/// What a segment needs to know.
pub(super) struct Course<'a> {
    pub(super) plan: &'a Plan,
    /// Which incidence, from 0.
    pub(super) sigma: usize,
    /// Its name on the line, used by no other segment of this session.
    pub(super) name: u32,
    /// Points asked for at once, >= 1.
    pub(super) credit: u16,
    /// Which calibration is in force, from 0.
    pub(super) calibration: usize,
}

/// How a segment ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// All points are in the journal.
    Complete,
    /// The line was lost and found, or the instrument has stopped; it stands somewhere.
    Disturbed,
}

/// Goes there from below, and scans what is missing.
pub(super) fn scan<T: Transport>(
    client: &mut Client<'_, T>,
    course: &Course<'_>,
    journal: &mut Journal,
    progress: &mut dyn FnMut(&Journal, Duration),
) -> Result<End, AcquireError> {
    let (plan, before) = (course.plan, client.recoveries());
    let first = journal.points(course.sigma).len() as u16;
    let Some(&sigma) = plan.sigmas().get(course.sigma) else { return Ok(End::Complete) };
    if first >= plan.count() {
        return Ok(End::Complete);
    }
    client.move_to(Axis::Sigma, sigma)?;
    client.move_to(Axis::Theta, plan.run_up(first, client.ident()))?;
    client.ask(Request::Scan(Segment {
        segment: course.name,
        start: plan.theta(0),
        step: plan.step(),
        count: plan.count(),
        first,
        credit: course.credit,
    }))?;
    if client.recoveries() != before {
        return Ok(End::Disturbed);
    }
    let mut taking = Taking {
        course,
        before,
        next: first,
        granted: first.saturating_add(course.credit).min(plan.count()),
        heard: client.now(),
    };
    while taking.next < plan.count() {
        if !taking.step(client, journal, progress)? {
            return Ok(End::Disturbed);
        }
    }
    client.wait_idle("the scan of a segment", client.patience().motion(Duration::ZERO))?;
    Ok(End::Complete)
}

/// How an instrument is found that has sent nothing for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    /// It measures, or waits for credit.
    Underway,
    /// It has measured points that have not come.
    Ahead,
    /// It has stopped, as it does when it has not heard of its owner for long.
    Stopped,
}

/// A segment that is being scanned.
struct Taking<'a> {
    course: &'a Course<'a>,
    /// [`Client::recoveries`] when it was begun.
    before: u32,
    /// First point that is not in the journal.
    next: u16,
    /// First point that has not been asked for.
    granted: u16,
    /// When the last new point came.
    heard: Duration,
}

impl Taking<'_> {
    /// Waits for points, stores them, asks for more; `false` if the line was lost.
    fn step<T: Transport>(
        &mut self,
        client: &mut Client<'_, T>,
        journal: &mut Journal,
        progress: &mut dyn FnMut(&Journal, Duration),
    ) -> Result<bool, AcquireError> {
        client.heed_stop()?;
        let events = client.events(client.now() + client.patience().poll)?;
        let quiet = events.is_empty();
        let (points, end) = self.points(client, &events);
        if !points.is_empty() {
            journal.add_points(self.course.sigma, &points)?;
            self.next += points.len() as u16;
            self.heard = client.now();
            progress(journal, self.heard);
        }
        end?;
        if client.recoveries() != self.before {
            return Ok(false);
        }
        if self.next >= self.course.plan.count() {
            return Ok(true);
        }
        let stopped = events.iter().any(|e| matches!(e, Event::State(_) | Event::Fault(_)));
        let found = if quiet || stopped { self.look(client)? } else { Found::Underway };
        if client.recoveries() != self.before || found == Found::Stopped {
            return Ok(false);
        }
        if found == Found::Ahead || self.next >= self.granted {
            return self.go_on(client);
        }
        Ok(true)
    }

    /// New points in order from those that came; what ends the scan, if anything does.
    fn points<T: Transport>(
        &self,
        client: &Client<'_, T>,
        events: &[Event],
    ) -> (Vec<Stored>, Result<(), AcquireError>) {
        let mut points = Vec::new();
        for event in events {
            let Event::Point(point) = event else { continue };
            // of an older segment; there already; or behind one that was lost
            let expected = self.next + points.len() as u16;
            if point.segment != self.course.name || point.index != expected {
                continue;
            }
            match self.check(client, point) {
                Ok(stored) => points.push(stored),
                Err(e) => return (points, Err(e)),
            }
        }
        (points, Ok(()))
    }

    fn check<T: Transport>(
        &self,
        client: &Client<'_, T>,
        point: &Point,
    ) -> Result<Stored, AcquireError> {
        let plan = self.course.plan;
        let (reading, place) = (point.reading, plan.theta(point.index));
        let nonsense = |what: String| {
            let said = format!("point {} at theta {} deg: {what}", point.index, place.degrees());
            client.fail(Trouble::Nonsense(said))
        };
        if point.index >= plan.count() {
            return Err(nonsense("beyond the end of the segment".to_owned()).into());
        }
        let near = (plan.step().0 / 2).min(OFF_PLACE);
        if point.theta.0.abs_diff(place.0) > near.unsigned_abs() {
            let at = point.theta.degrees();
            return Err(nonsense(format!("it was read at {at} deg")).into());
        }
        if !reading.signal.is_finite() || !reading.dark.is_finite() {
            return Err(
                nonsense(format!("signal {}, dark {}", reading.signal, reading.dark)).into()
            );
        }
        let other = matches!(plan.range(), Range::Fixed(range) if range != reading.range);
        if other || reading.range >= RANGES {
            return Err(nonsense(format!("it was read in range {}", reading.range)).into());
        }
        if reading.over {
            let sigma = plan.sigmas().get(self.course.sigma).map_or(0.0, |sigma| sigma.degrees());
            let theta_deg = place.degrees();
            let range = reading.range;
            return Err(AcquireError::OverRange { sigma_deg: sigma, theta_deg, range });
        }
        let (theta, calibration) = (point.theta, self.course.calibration);
        Ok(Stored { theta, reading, calibration })
    }

    /// Asks how far it is.
    fn look<T: Transport>(&self, client: &mut Client<'_, T>) -> Result<Found, AcquireError> {
        let status = client.status()?;
        if let (MachineState::Fault, Some(fault)) = (status.state, status.fault) {
            return Err(client.fail(Trouble::Fault(fault)).into());
        }
        let plan = self.course.plan;
        let slowest = estimate::travel(&client.ident().theta, Microdegrees(0), plan.step())
            + estimate::reading(plan.integration_us()) * AUTO_READINGS;
        let limit = client.patience().motion(slowest);
        if client.now().saturating_sub(self.heard) > limit {
            let seconds = limit.as_secs_f64();
            let what = "the next point of the scan";
            return Err(client.fail(Trouble::Overdue { what, seconds }).into());
        }
        let measured = match status.segment {
            Some((name, measured)) if name == self.course.name => measured,
            _ => 0,
        };
        Ok(match status.state {
            _ if measured > self.next => Found::Ahead,
            MachineState::Idle => Found::Stopped,
            _ => Found::Underway,
        })
    }

    /// Says what is stored, and asks for what comes next; `false` if the segment has to be begun anew.
    fn go_on<T: Transport>(&mut self, client: &mut Client<'_, T>) -> Result<bool, AcquireError> {
        let (segment, next, credit) = (self.course.name, self.next, self.course.credit);
        match client.ask(Request::Continue { segment, next, credit }) {
            Ok(_) => {}
            Err(e) if is_forgotten(&e.trouble) => return Ok(false),
            Err(e) => return Err(e.into()),
        }
        self.granted = next.saturating_add(credit).min(self.course.plan.count());
        Ok(client.recoveries() == self.before)
    }
}

/// Whether the instrument says that it has lost what it was told, as after a restart.
pub(super) fn is_forgotten(trouble: &Trouble) -> bool {
    use DeviceError::{LampOff, NoSegment, NotHomed, NotOwner};
    let Trouble::Refused { why, .. } = trouble else { return false };
    matches!(why, NoSegment | NotHomed | LampOff | NotOwner)
}

/// What [`Progress`] says after some points.
pub(super) fn progress_of(journal: &Journal, begun: (u64, Duration), now: Duration) -> Progress {
    let (done, total) = (journal.len(), journal.plan().points());
    let measured = done.saturating_sub(begun.0);
    let each = now.saturating_sub(begun.1).as_secs_f64() / measured.max(1) as f64;
    Progress { done, total, seconds_left: each * total.saturating_sub(done) as f64 }
}
