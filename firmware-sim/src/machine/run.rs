//! Carries on what was begun, one small step a call.

use asperity_core::protocol::{Axis as Name, Fault, MachineState, RANGES, Range, Reading};

use super::begin::SETTLE_US;
use super::{Happening, Job, Machine, Progress};
use crate::clock::{Instant, earlier};
use crate::detector::{self, Exposure, View};
use crate::transition::Input;

/// Time the amplifier takes to change its range, microseconds.
const SWITCH_US: u64 = 5000;

/// Later than this, microseconds, a point does not follow the last one as if nobody had been late.
const LATENESS_US: u64 = 20_000;

impl Machine {
    /// When `step` has something to do; the past means now.
    pub(crate) fn due(&self) -> Option<Instant> {
        let at_once = self.news.is_some()
            || self.announced != self.state
            || self.injected.lamp_off
            || self.held.is_some_and(|held| held.has_to_send());
        if at_once {
            return Some(Instant(0));
        }
        let job = match self.job {
            Job::None => None,
            Job::Trace { .. } | Job::TraceAll(_) => Some(Instant(0)),
            Job::Ready { since } => {
                let go = |held: super::Held| held.may_measure() || held.measured == held.count();
                self.held.is_some_and(go).then_some(since)
            }
            Job::Motion { end }
            | Job::Read { end, .. }
            | Job::Dark { end }
            | Job::Reference { end }
            | Job::Point { end } => Some(end),
        };
        earlier(job, earlier(self.sigma.due(), self.theta.due()))
    }

    /// Something that was not yet told.
    pub(crate) fn news(&mut self) -> Option<Happening> {
        if let Some(fault) = self.news.take() {
            return Some(Happening::Fault(fault));
        }
        if self.announced == self.state {
            return None;
        }
        self.announced = self.state;
        Some(Happening::State(self.state))
    }

    /// Does the next thing that is due by `now`.
    pub(crate) fn step(&mut self, now: Instant) -> Progress {
        if let Some(news) = self.news() {
            return Progress::Happened(news);
        }
        if core::mem::take(&mut self.injected.lamp_off) {
            self.fail(Fault::LampFailed, now);
            return Progress::Some;
        }
        if let Some(point) = self.point_to_send() {
            return Progress::Happened(point);
        }
        match self.due() {
            Some(due) if due <= now => {}
            _ => return Progress::Nothing,
        }
        let fault = [&mut self.sigma, &mut self.theta].into_iter().find_map(|axis| {
            let end = axis.due().filter(|&end| end <= now)?;
            axis.advance(end).map(|fault| (fault, end))
        });
        if let Some((fault, end)) = fault {
            self.fail(fault, end);
            return Progress::Some;
        }
        self.job(now)
    }

    fn point_to_send(&mut self) -> Option<Happening> {
        let held = self.held.as_mut().filter(|held| held.has_to_send())?;
        let index = held.send;
        held.send += 1;
        self.point(index).map(Happening::Point)
    }

    fn done(&mut self) {
        self.job = Job::None;
        if self.state == MachineState::Homing {
            self.homed = true;
        }
        // the table knows no error for it
        let _ = self.enter(Input::Done);
    }

    fn job(&mut self, now: Instant) -> Progress {
        match &mut self.job {
            Job::None => return Progress::Nothing,
            Job::Trace { tracing, arm, light } => {
                let (arm, light) = (*arm, light);
                let all = tracing.chunk(&self.config, &mut |reach, flux| {
                    if reach.holds(arm) {
                        *light += flux;
                    }
                });
                let light = *light;
                if all {
                    let us = self.config.scaled(u64::from(self.integration_us));
                    self.job = Job::Read { end: now.after(us), arm, light };
                }
                return Progress::Traced;
            }
            Job::TraceAll(tracing) => {
                let Some(held) = &self.held else { return Progress::Nothing };
                let sums = self.memory.sums();
                let all = tracing.chunk(&self.config, &mut |reach, flux| {
                    held.angles.add(reach, flux, sums);
                });
                if all {
                    self.job = Job::Ready { since: now };
                }
                return Progress::Traced;
            }
            &mut Job::Motion { end } if end <= now => self.done(),
            &mut Job::Read { end, arm, light } if end <= now => {
                return self.read_now(end, arm, light);
            }
            &mut Job::Dark { end } if end <= now => self.dark_now(end),
            &mut Job::Reference { end } if end <= now => self.reference_now(end),
            &mut Job::Ready { since } => self.next_point(since, now),
            &mut Job::Point { end } if end <= now => self.point_now(end),
            _ => return Progress::Some,
        }
        Progress::Some
    }

    /// Reads the detector; `None` if the amplifier must change its range first, or on a fault.
    fn expose(&mut self, view: View, relative: f32, range: Range, now: Instant) -> Option<Reading> {
        if core::mem::take(&mut self.injected.over_range) {
            self.fail(Fault::OverRange, now);
            return None;
        }
        let (aperture, integration_us) = (self.aperture, self.integration_us);
        let exposure = Exposure { view, relative, aperture, integration_us, now };
        let reading = detector::read(&self.config, &exposure, range, self.dark.as_ref());
        let stays = core::mem::replace(&mut self.gain, reading.range) == reading.range;
        if stays {
            return Some(reading);
        }
        let later = now.after(self.config.scaled(SWITCH_US));
        match &mut self.job {
            Job::Read { end, .. } | Job::Reference { end } | Job::Point { end } => *end = later,
            _ => {}
        }
        None
    }

    fn read_now(&mut self, now: Instant, arm: i32, light: f32) -> Progress {
        let view = View::Sample { sigma: self.sigma.encoder(now), arm };
        let Some(reading) = self.expose(view, light, self.range, now) else {
            return Progress::Some;
        };
        self.reading = Some(reading);
        self.done();
        Progress::Happened(Happening::Reading)
    }

    fn dark_now(&mut self, now: Instant) {
        let mut dark = [0.0; RANGES as usize];
        for (range, slot) in (0..RANGES).zip(&mut dark) {
            // each range is tried in its turn, so no time is lost by changing
            self.gain = range;
            match self.expose(View::Dark, 0.0, Range::Fixed(range), now) {
                Some(reading) => *slot = reading.signal,
                None => return,
            }
        }
        self.dark = Some(dark);
        self.done();
    }

    fn reference_now(&mut self, now: Instant) {
        if let Some(reading) = self.expose(View::Beam, 1.0, Range::Auto, now) {
            self.reference = Some((reading.signal, reading.range));
            self.done();
        }
    }

    /// On to the next point, as far as credit goes.
    fn next_point(&mut self, since: Instant, now: Instant) {
        let Some(held) = self.held else { return self.done() };
        if held.measured >= held.count() {
            return self.done();
        }
        if !held.may_measure() {
            return;
        }
        let start = if now.since(since) < LATENESS_US { since } else { now };
        let there = self.go(Name::Theta, held.angles.encoder(held.measured), start);
        let us = SETTLE_US + u64::from(self.integration_us);
        self.job = Job::Point { end: there.after(self.config.scaled(us)) };
    }

    fn point_now(&mut self, now: Instant) {
        let Some(held) = self.held else { return self.done() };
        let (index, sigma) = (held.measured, self.sigma.encoder(now));
        let view = View::Sample { sigma, arm: held.angles.arm(index) };
        let light = self.memory.light(index);
        let Some(reading) = self.expose(view, light, self.range, now) else { return };
        self.memory.keep(index, &reading);
        if let Some(held) = &mut self.held {
            held.measured += 1;
        }
        self.job = Job::Ready { since: now };
    }
}
