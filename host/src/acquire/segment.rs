//! One incidence: from the first missing point to the last.

use std::path::Path;
use std::time::Duration;

use asperity_core::protocol::{
    Axis, Calibration, DeviceError, Event, MachineState, Microdegrees, Point, RANGES, Range,
    Request, Segment, Status,
};

use super::client::{Client, describe};
use super::conditions::Conditions;
use super::error::Trouble;
use super::estimate;
use super::job::Progress;
use super::journal::{Journal, Stored};
use super::run_error::AcquireError;
use super::schedule::Schedule;
use super::signal;
use super::transport::Transport;

/// Tolerance of the position of a point, by the encoder, microdegrees; at most half a step.
const OFF_PLACE: i32 = 20_000;
/// Largest number of readings that an instrument may take until it has found its range.
const AUTO_READINGS: u32 = 2 * RANGES as u32;

/// The input of a segment.
pub(super) struct Course<'a> {
    pub(super) schedule: &'a Schedule,
    /// Which incidence, from 0.
    pub(super) sigma: usize,
    /// Its name on the line, used by no other segment of this session.
    pub(super) name: u32,
    /// Points requested at once, >= 1.
    pub(super) credit: u16,
    /// Which calibration is in force, from 0.
    pub(super) calibration: usize,
    /// The calibration found.
    pub(super) values: Calibration,
}

/// The end of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// All points are in the journal.
    Complete,
    /// The line was lost and recovered, or the instrument has stopped at some position.
    Disturbed,
}

/// Approaches the first missing point from below and scans the missing points.
pub(super) fn scan<T: Transport>(
    client: &mut Client<'_, T>,
    course: &Course<'_>,
    journal: &mut Journal,
    progress: &mut dyn FnMut(&Journal, Duration),
) -> Result<End, AcquireError> {
    let (schedule, before) = (course.schedule, client.recoveries());
    let first = journal.points(course.sigma).len() as u16;
    let Some(&sigma) = schedule.sigmas().get(course.sigma) else { return Ok(End::Complete) };
    if first >= schedule.count() {
        return Ok(End::Complete);
    }
    client.move_to(Axis::Sigma, sigma)?;
    client.move_to(Axis::Theta, schedule.run_up(first, client.ident()))?;
    client.ask(Request::Scan(Segment {
        segment: course.name,
        start: schedule.theta(0),
        step: schedule.step(),
        count: schedule.count(),
        first,
        credit: course.credit,
    }))?;
    if client.recoveries() != before {
        return Ok(End::Disturbed);
    }
    let mut taking = Taking {
        course,
        conditions: Conditions::of(schedule).at(sigma),
        before,
        next: first,
        fresh: Vec::new(),
        granted: first.saturating_add(course.credit).min(schedule.count()),
        heard: client.now(),
    };
    let end = taking.all(client, journal, progress);
    match &end {
        Ok(End::Complete) => {
            let limit = client.patience().motion(Duration::ZERO);
            client.wait_idle("the scan of a segment", limit)?;
        }
        Ok(End::Disturbed) => taking.salvage(client, journal)?,
        Err(AcquireError::Link(e)) if matches!(*e.trouble, Trouble::Interrupted) => {
            client.stop_now();
            taking.salvage(client, journal)?;
        }
        Err(_) => {}
    }
    end
}

/// The state of an instrument that has sent nothing for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    /// It measures, or waits for credit.
    Underway,
    /// It has measured points that did not arrive.
    Ahead,
    /// It has stopped, as after a long silence of its owner.
    Stopped,
}

/// A segment that is being scanned.
struct Taking<'a> {
    course: &'a Course<'a>,
    conditions: Conditions<'a>,
    /// [`Client::recoveries`] when it was begun.
    before: u32,
    /// First point that is not in the journal.
    next: u16,
    /// The points from `next` on that have come since the last status of the instrument. They are not in the journal:
    /// they belong there only if the settings are still the same.
    fresh: Vec<Stored>,
    /// First point not yet requested.
    granted: u16,
    /// Time of the last new point.
    heard: Duration,
}

impl Taking<'_> {
    fn all<T: Transport>(
        &mut self,
        client: &mut Client<'_, T>,
        journal: &mut Journal,
        progress: &mut dyn FnMut(&Journal, Duration),
    ) -> Result<End, AcquireError> {
        while self.next < self.course.schedule.count() {
            if !self.step(client, journal, progress)? {
                return Ok(End::Disturbed);
            }
        }
        Ok(End::Complete)
    }

    /// Waits for points, stores them, requests more; `false` if the line was lost.
    ///
    /// Only a new point shows that the scan goes on. The client requests the status if none came, if the instrument
    /// reports that it has stopped, if all requested points have come, and at least once per second.
    fn step<T: Transport>(
        &mut self,
        client: &mut Client<'_, T>,
        journal: &mut Journal,
        progress: &mut dyn FnMut(&Journal, Duration),
    ) -> Result<bool, AcquireError> {
        client.heed_stop()?;
        let patience = client.patience();
        let events = client.events(client.now() + patience.poll)?;
        let (points, taken) = self.points(client, &events);
        if !points.is_empty() {
            self.fresh.extend(points);
            self.heard = client.now();
        }
        if client.recoveries() != self.before {
            return taken.map(|()| false);
        }
        let stopped = events.iter().any(|e| matches!(e, Event::State(_) | Event::Fault(_)));
        let quiet = client.now().saturating_sub(self.heard).min(client.unheard()) >= patience.poll;
        let due = stopped || quiet || self.has_all() || client.unheard() >= patience.keep_alive;
        if !due && taken.is_ok() {
            return Ok(true);
        }
        let found = self.look(client, journal, progress);
        taken?;
        let found = found?;
        if client.recoveries() != self.before {
            return Ok(false);
        }
        if self.next >= self.course.schedule.count() {
            return Ok(true);
        }
        match found {
            Found::Stopped => Ok(false),
            Found::Ahead => self.go_on(client),
            Found::Underway if self.has_all() => self.go_on(client),
            Found::Underway => Ok(true),
        }
    }

    /// First point that has not come.
    fn wanted(&self) -> u16 {
        self.next + self.fresh.len() as u16
    }

    /// Whether all requested points have come.
    fn has_all(&self) -> bool {
        self.wanted() >= self.granted
    }

    /// The new points in order, and what ends the scan, if anything.
    fn points<T: Transport>(
        &self,
        client: &Client<'_, T>,
        events: &[Event],
    ) -> (Vec<Stored>, Result<(), AcquireError>) {
        let mut points = Vec::new();
        for event in events {
            let Event::Point(point) = event else { continue };
            // of an older segment; there already; or behind one that was lost
            let expected = self.wanted() + points.len() as u16;
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
        let schedule = self.course.schedule;
        let (reading, place) = (point.reading, schedule.theta(point.index));
        let nonsense = |what: String| {
            let said = format!("point {} at theta {} deg: {what}", point.index, place.degrees());
            client.fail(Trouble::Nonsense(said))
        };
        if point.index >= schedule.count() {
            return Err(nonsense("beyond the end of the segment".to_owned()).into());
        }
        let near = (schedule.step().0 / 2).min(OFF_PLACE);
        if point.theta.0.abs_diff(place.0) > near.unsigned_abs() {
            let at = point.theta.degrees();
            return Err(nonsense(format!("it was read at {at} deg")).into());
        }
        let other = matches!(schedule.range(), Range::Fixed(range) if range != reading.range);
        if other || reading.range >= RANGES {
            return Err(nonsense(format!("it was read in range {}", reading.range)).into());
        }
        signal::check_reading(&self.course.values, &reading).map_err(nonsense)?;
        if reading.over {
            let sigma =
                schedule.sigmas().get(self.course.sigma).map_or(0.0, |sigma| sigma.degrees());
            let theta_deg = place.degrees();
            let range = reading.range;
            return Err(AcquireError::OverRange { sigma_deg: sigma, theta_deg, range });
        }
        let (theta, calibration) = (point.theta, self.course.calibration);
        Ok(Stored { theta, reading, calibration })
    }

    /// Requests the status, and stores the new points if the settings are still the same.
    fn look<T: Transport>(
        &mut self,
        client: &mut Client<'_, T>,
        journal: &mut Journal,
        progress: &mut dyn FnMut(&Journal, Duration),
    ) -> Result<Found, AcquireError> {
        let status = client.status()?;
        if client.recoveries() != self.before {
            // what it says is of another run
            return Ok(Found::Stopped);
        }
        client.refuse_fault(&status)?;
        self.confirm(client, &status, journal.path())?;
        if self.store(journal)? {
            progress(journal, client.now());
        }
        let schedule = self.course.schedule;
        let slowest = estimate::travel(&client.ident().theta, Microdegrees(0), schedule.step())
            + estimate::reading(schedule.integration_us()) * AUTO_READINGS;
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
        // what it has sent before it answered is here, and not yet looked at
        let here = |event: &Event| matches!(event, Event::Point(p) if p.segment == self.course.name && p.index >= self.next);
        Ok(match status.state {
            _ if client.waiting().any(here) => Found::Underway,
            _ if measured > self.next => Found::Ahead,
            MachineState::Idle => Found::Stopped,
            _ => Found::Underway,
        })
    }

    /// Whether the instrument is set as the schedule wants it, and calibrated as the journal says.
    fn confirm<T: Transport>(
        &self,
        client: &Client<'_, T>,
        status: &Status,
        journal: &Path,
    ) -> Result<(), AcquireError> {
        self.conditions.check(status).map_err(|trouble| client.fail(trouble))?;
        if status.calibration == Some(self.course.values.id) {
            return Ok(());
        }
        let instrument = describe(client.ident());
        Err(AcquireError::OtherCalibration { instrument, path: journal.to_owned() })
    }

    /// Writes the new points to the journal; whether there were any.
    fn store(&mut self, journal: &mut Journal) -> Result<bool, AcquireError> {
        journal.add_points(self.course.sigma, &self.fresh)?;
        self.next = self.wanted();
        let any = !self.fresh.is_empty();
        self.fresh.clear();
        Ok(any)
    }

    /// Stores the points that came before the scan was interrupted, if the settings are still the same.
    fn salvage<T: Transport>(
        &mut self,
        client: &mut Client<'_, T>,
        journal: &mut Journal,
    ) -> Result<(), AcquireError> {
        if !self.fresh.is_empty()
            && let Some(status) = client.glance()
            && self.confirm(client, &status, journal.path()).is_ok()
        {
            self.store(journal)?;
        }
        Ok(())
    }

    /// Reports the stored points and requests the next ones; `false` if the segment must begin again.
    fn go_on<T: Transport>(&mut self, client: &mut Client<'_, T>) -> Result<bool, AcquireError> {
        let (segment, next, credit) = (self.course.name, self.next, self.course.credit);
        match client.ask(Request::Continue { segment, next, credit }) {
            Ok(_) => {}
            Err(e) if is_forgotten(&e.trouble) => return Ok(false),
            Err(e) => return Err(e.into()),
        }
        self.granted = next.saturating_add(credit).min(self.course.schedule.count());
        Ok(client.recoveries() == self.before)
    }
}

/// Whether the instrument has lost its settings, as after a restart.
pub(super) fn is_forgotten(trouble: &Trouble) -> bool {
    use DeviceError::{LampOff, NoSegment, NotHomed, NotOwner};
    let Trouble::Refused { why, .. } = trouble else { return false };
    matches!(why, NoSegment | NotHomed | LampOff | NotOwner)
}

/// The [`Progress`] after some points.
pub(super) fn progress_of(journal: &Journal, begun: (u64, Duration), now: Duration) -> Progress {
    let (done, total) = (journal.len(), journal.schedule().points());
    let measured = done.saturating_sub(begun.0);
    let each = now.saturating_sub(begun.1).as_secs_f64() / measured.max(1) as f64;
    Progress { done, total, seconds_left: each * total.saturating_sub(done) as f64 }
}
