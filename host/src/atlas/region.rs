//! The solutions that belong together, and the interpolation between them, in logarithms.
//!
//! A region is a side, a lobe and a range of incidences. From inside there are two ranges, as the critical angle, 42.2 degrees, parts them. In each
//! the logarithm of an error is a function of the logarithms of Rq over the wavelength and of the slope, and of the incidence. The correlation
//! lengths are the same everywhere: they were chosen for good predictions of left-out surfaces, that of the incidence for good
//! predictions of all that is known at 30 degrees from 0 and 60.

use std::sync::OnceLock;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use super::kriging::{Estimate, Place, Point, Process};
use super::table::{Engine, Measure, Solution, solutions};

/// Correlation lengths: of ln Rq, of ln slope, of the incidence in degrees.
const LENGTHS: [f64; 3] = [2.5, 1.8, 100.0];
/// Where the coordinates begin: Rq, slope.
const MIDDLE: [f64; 2] = [0.25, 0.2];
/// Angles of observation that an error is the mean of, as far as they are independent: those of a lobe.
const INDEPENDENT: f64 = 10.0;
/// The noise of a logarithm is never more than this.
const MOST_NOISE: f64 = 2.0;
/// Share of the left-out lobes that their intervals hold.
pub(super) const HELD: f64 = 0.93;

/// Largest incidence in air, degrees.
pub(super) const MOST_IN_AIR: f64 = 61.0;
/// Incidences from inside that have no solutions, degrees.
pub(super) const GAP_INSIDE: [f64; 2] = [31.0, 58.0];

/// Side, lobe and range of incidences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) side: Side,
    pub(super) lobe: Lobe,
    /// Beyond the critical angle.
    pub(super) beyond: bool,
}

impl Region {
    pub(super) const ALL: [Self; 6] = {
        const fn of(side: Side, lobe: Lobe, beyond: bool) -> Region {
            Region { side, lobe, beyond }
        }
        [
            of(Side::Air, Lobe::Reflection, false),
            of(Side::Air, Lobe::Transmission, false),
            of(Side::Dielectric, Lobe::Reflection, false),
            of(Side::Dielectric, Lobe::Transmission, false),
            of(Side::Dielectric, Lobe::Reflection, true),
            of(Side::Dielectric, Lobe::Transmission, true),
        ]
    };

    /// `None` where there are no solutions.
    pub(super) fn of(side: Side, lobe: Lobe, incidence_deg: f64) -> Option<Self> {
        let beyond = match side {
            Side::Air => (incidence_deg <= MOST_IN_AIR).then_some(false)?,
            Side::Dielectric if incidence_deg <= GAP_INSIDE[0] => false,
            Side::Dielectric => {
                (GAP_INSIDE[1]..=MOST_IN_AIR).contains(&incidence_deg).then_some(true)?
            }
        };
        Some(Self { side, lobe, beyond })
    }

    pub(super) fn holds(self, solution: &Solution) -> bool {
        Self::of(solution.side, solution.lobe, solution.incidence_deg) == Some(self)
    }

    /// The place of a surface at an incidence, degrees. Beyond the critical angle there is one incidence only.
    pub(super) fn place(self, rq_over_lambda: f64, rms_slope: f64, incidence_deg: f64) -> Place {
        [
            (rq_over_lambda / MIDDLE[0]).ln() / LENGTHS[0],
            (rms_slope / MIDDLE[1]).ln() / LENGTHS[1],
            if self.beyond { 0.0 } else { incidence_deg / LENGTHS[2] },
        ]
    }

    /// The interpolation for an engine.
    pub(super) fn course(self, engine: Engine, measure: Measure) -> Option<&'static Course> {
        static FOUND: [[[OnceLock<Option<Course>>; 2]; 3]; 6] =
            [const { [const { [const { OnceLock::new() }; 2] }; 3] }; 6];
        let number = Self::ALL.iter().position(|region| *region == self)?;
        FOUND[number][engine as usize][measure as usize]
            .get_or_init(|| Course::of(self, engine, measure))
            .as_ref()
    }
}

/// The logarithm of an error over a region.
#[derive(Debug)]
pub(super) struct Course {
    pub(super) process: Process,
    /// Each point as other surfaces predict it.
    pub(super) left_out: Vec<Estimate>,
    /// Half an interval, in standard deviations.
    pub(super) reach: f64,
}

impl Course {
    fn of(region: Region, engine: Engine, measure: Measure) -> Option<Self> {
        let inside = || solutions().iter().filter(|s| region.holds(s));
        let mut surfaces: Vec<[f64; 2]> = Vec::new();
        let mut points = Vec::new();
        for s in inside() {
            let surface = [s.rq_over_lambda, s.rms_slope];
            let same =
                |other: &[f64; 2]| other.iter().zip(surface).all(|(a, b)| (a - b).abs() < 1e-9);
            let group = surfaces.iter().position(same).unwrap_or_else(|| {
                surfaces.push(surface);
                surfaces.len() - 1
            });
            let error = s.error_percent(engine, measure);
            points.push(Point {
                at: region.place(s.rq_over_lambda, s.rms_slope, s.incidence_deg),
                value: error.ln(),
                noise: noise(error, s.floor_percent(measure)),
                group,
            });
        }
        let process = Process::through(points)?;
        let left_out = process.left_out()?;
        let mut course = Self { process, left_out, reach: 0.0 };
        course.reach = course.reach_without(None);
        Some(course)
    }

    /// Half of the interval that holds a share of [`HELD`] of the left-out points, those of a group left aside.
    pub(super) fn reach_without(&self, group: Option<usize>) -> f64 {
        let points = self.process.points().iter().zip(&self.left_out);
        let mut off: Vec<f64> = points
            .filter(|(p, _)| Some(p.group) != group)
            .map(|(p, e)| (p.value - e.value).abs() / e.deviation)
            .collect();
        off.sort_by(f64::total_cmp);
        // between neighbours
        let at = HELD * (off.len().max(1) - 1) as f64;
        let [low, high] =
            [at.floor(), at.ceil()].map(|k| off.get(k as usize).copied().unwrap_or(0.0));
        low + (high - low) * at.fract()
    }
}

/// Variance of the logarithm of an error from which a noise of known size was subtracted, in squares.
fn noise(error: f64, floor: f64) -> f64 {
    let of_square = (2.0 * floor.powi(4) + 4.0 * (floor * error).powi(2)) / INDEPENDENT;
    (of_square / (4.0 * error.powi(4))).min(MOST_NOISE * MOST_NOISE)
}

#[cfg(test)]
mod tests {
    use asperity_core::direction::Side;

    use super::{LENGTHS, Region};
    use crate::atlas::{Engine, Measure};

    #[test]
    fn what_is_known_at_30_degrees_follows_from_0_and_60() {
        // twice as far from the next solutions as any question about an incidence
        for engine in [Engine::Kirchhoff, Engine::Rays] {
            for measure in Measure::ALL {
                for region in Region::ALL.into_iter().filter(|r| r.side == Side::Air) {
                    let course = region.course(engine, measure).unwrap();
                    let is_middle = |deg: f64| (deg - 30.0).abs() < 5.0;
                    let rest = course.process.without(|p| is_middle(p.at[2] * LENGTHS[2])).unwrap();
                    let points = course.process.points().iter();
                    let middle: Vec<_> =
                        points.filter(|p| is_middle(p.at[2] * LENGTHS[2])).collect();
                    assert_eq!(middle.len(), 42);
                    let held = middle.iter().filter(|p| {
                        let found = rest.at(p.at);
                        let deviation = found.deviation.hypot(p.noise.sqrt());
                        (found.value - p.value).abs() <= course.reach * deviation
                    });
                    let held = held.count();
                    assert!(held >= 37, "{engine:?} {measure:?} {:?} {held}", region.lobe);
                }
            }
        }
    }

    #[test]
    fn the_critical_angle_parts_the_inside() {
        let of = |deg| Region::of(Side::Dielectric, super::Lobe::Reflection, deg).map(|r| r.beyond);
        assert_eq!(
            [0.0, 30.2, 42.0, 59.0, 61.5].map(of),
            [Some(false), Some(false), None, Some(true), None]
        );
    }
}
