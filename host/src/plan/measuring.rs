//! The shortest schedule of a goniophotometer that tells the width of a law.
//!
//! A reading tells as much of a width as it changes with it, squared; readings of the same noise add what they tell. The schedule
//! in the least time is searched that tells more than half of what the usual 5 x 1801 readings tell: the width it gives is then
//! on average one standard error of the usual schedule from that of the usual schedule.

use crate::acquire::Draft;
use crate::acquire::estimate::typical;
use crate::boundary::Boundary;
use crate::measurement::Metadata;
use crate::reconstruct::ScanRequest;
use crate::watch::Watch;

use super::record::Measure;

/// Incidences that an instrument is asked for, degrees: those of the GP-200.
const SIGMAS: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
/// Steps that are tried, degrees.
const STEPS: [f64; 5] = [0.1, 0.2, 0.3, 0.5, 1.0];
/// Share of the usual information that is kept.
const KEPT: f64 = 0.6;
/// Step of the search over angles of observation, degrees.
const COARSE: usize = 5;
/// Angles of observation whose information is computed, one a degree.
const ANGLES: usize = 181;

/// The information of readings a degree apart, by incidence.
struct Information(Vec<[f64; ANGLES]>);

impl Information {
    /// From the readings of two laws whose widths differ by a little; `None` if the instrument cannot see one of them.
    fn of(laws: [&Boundary; 2]) -> Option<Self> {
        let request =
            ScanRequest { sigma_deg: SIGMAS.to_vec(), step_deg: 1.0, ..ScanRequest::default() };
        let scans =
            laws.map(|law| request.of_boundary(law, Metadata::default(), Watch::nobody()).ok());
        let [Some(a), Some(b)] = scans else { return None };
        let mut all = vec![[0.0; ANGLES]; SIGMAS.len()];
        for (a, b) in a.measurement.readings().iter().zip(b.measurement.readings()) {
            let incidence = SIGMAS.iter().position(|s| (s - a.sigma_deg).abs() < 1e-6)?;
            let angle = (a.theta_deg + 90.0).round() as usize;
            let slot = all.get_mut(incidence)?.get_mut(angle)?;
            *slot = (b.value - a.value).powi(2);
        }
        Some(Self(all))
    }

    /// Of some incidences between two angles, at a step.
    fn sum(&self, sigmas: usize, [from, to]: [usize; 2], step: f64) -> f64 {
        let kept = self.0.iter().enumerate().filter(|(k, _)| sigmas >> k & 1 == 1);
        kept.map(|(_, of)| of[from..=to].iter().sum::<f64>()).sum::<f64>() / step
    }
}

/// The shortest schedule for a law, known to about this width; `laws` are two of its widths that differ by a little.
pub(super) fn shortest(
    laws: [&Boundary; 2],
    ior: f64,
    wavelength_nm: Option<f64>,
) -> Option<Measure> {
    let information = Information::of(laws)?;
    let every = (1 << SIGMAS.len()) - 1;
    let all = information.sum(every, [0, ANGLES - 1], STEPS[0]);
    let instrument = typical();
    let usual = Draft::default().schedule().ok()?.estimate(&instrument).as_secs_f64();
    let mut best: Option<(f64, Draft, f64, usize)> = None;
    for sigmas in (1..=every).filter(|set: &usize| set.count_ones() >= 2) {
        for from in (0..ANGLES).step_by(COARSE) {
            for to in (from + COARSE..ANGLES).step_by(COARSE) {
                for step in STEPS {
                    let kept = information.sum(sigmas, [from, to], step) / all;
                    let points = f64::from(sigmas.count_ones()) * ((to - from) as f64 / step + 1.0);
                    // every point takes at least a tenth of a second
                    let shorter = best.as_ref().is_none_or(|(time, ..)| 0.1 * points < *time);
                    if kept < KEPT || !shorter {
                        continue;
                    }
                    let chosen = SIGMAS.iter().enumerate().filter(|(k, _)| sigmas >> k & 1 == 1);
                    let draft = Draft {
                        sigma_deg: Some(chosen.map(|(_, deg)| *deg).collect()),
                        theta_from_deg: Some(from as f64 - 90.0),
                        theta_to_deg: Some(to as f64 - 90.0),
                        theta_step_deg: Some(step),
                        aperture_deg: Some(0.6),
                        geometry: Some("transmission".into()),
                        ior: Some(ior),
                        rough_side: Some("source".into()),
                        wavelength_nm,
                        ..Draft::default()
                    };
                    let Ok(schedule) = draft.schedule() else { continue };
                    let time = schedule.estimate(&instrument).as_secs_f64();
                    if best.as_ref().is_none_or(|(least, ..)| time < *least) {
                        best = Some((time, draft, kept, schedule.points() as usize));
                    }
                }
            }
        }
    }
    let (time, schedule, kept, points) = best?;
    Some(Measure {
        schedule,
        points,
        hours_saved: (usual - time) / 3600.0,
        error_ratio: 1.0 / kept.sqrt(),
    })
}

/// Hours of the usual schedule.
pub(super) fn usual_hours() -> f64 {
    let schedule = Draft::default().schedule();
    schedule.map_or(f64::NAN, |s| s.estimate(&typical()).as_secs_f64() / 3600.0)
}
