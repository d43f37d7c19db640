//! A question to the atlas and its answer.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use serde::Serialize;

use super::region::{GAP_INSIDE, MOST_IN_AIR, Region};
use super::table::{Engine, Measure, Solution, solutions};

/// Rq in wavelengths and slopes of the surfaces; not all pairs have a solution.
const HEIGHTS: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0];
const SLOPES: [f64; 6] = [0.05, 0.1, 0.2, 0.3, 0.5, 0.8];
/// A surface may be this factor outside.
const EDGE: f64 = 1.02;
/// Indices for which a figure for 1.49 says something.
const INDICES: [f64; 2] = [1.4, 1.6];

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Rms height in vacuum wavelengths, above 0.
    pub rq_over_lambda: f64,
    /// Rms slope along the plane of incidence, above 0.
    pub rms_slope: f64,
    /// Index of the dielectric over that of air.
    pub ior: f64,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// Where the light comes from.
    pub side: Side,
    /// Where it goes.
    pub lobe: Lobe,
    /// What computes it.
    pub engine: Engine,
    /// What of the light is compared.
    pub measure: Measure,
}

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quote {
    /// Error, % of the peak; the middle of the interval, in logarithms.
    pub error_percent: f64,
    /// The interval holds nine of ten errors of surfaces that the interpolation does not know.
    pub low_percent: f64,
    /// Its upper end.
    pub high_percent: f64,
    /// The nearest solution.
    pub nearest: Nearest,
}

/// The solution that is nearest to a question.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// Rms height in vacuum wavelengths.
    pub rq_over_lambda: f64,
    /// Rms slope.
    pub rms_slope: f64,
    /// Angle of incidence, degrees.
    pub incidence_deg: f64,
    /// Its error, %.
    pub error_percent: f64,
    /// Flux of the lobe, of the incident light.
    pub flux: f64,
    /// The same by the engine.
    pub engine_flux: f64,
    /// Share of the flux of the lobe that is coherent.
    pub coherent_share: f64,
}

/// Why there is no answer: nothing is extrapolated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Outside {
    /// Too smooth or too rough.
    #[error("Rq of {0:.3} wavelengths is outside the atlas, 0.02 to 3")]
    Height(f64),
    /// Too gentle or too steep.
    #[error("rms slope {0:.3} is outside the atlas, 0.05 to 0.8")]
    Slope(f64),
    /// Structures that are too fine or too coarse.
    #[error(
        "Rq of {0:.3} wavelengths with a slope of {1:.3} is outside the atlas, at a corner that it lacks"
    )]
    Corner(f64, f64),
    /// Too slanting.
    #[error("an incidence of {0} deg is outside the atlas, 0 to 60 deg")]
    Incidence(f64),
    /// Near the critical angle.
    #[error(
        "{0} deg inside is outside the atlas, which has 0 to 30 and 60 deg there; the critical angle is between"
    )]
    Critical(f64),
    /// Another material.
    #[error("an index of {0} is outside the atlas, which is for 1.49 and quoted from 1.4 to 1.6")]
    Index(f64),
}

/// What the engine errs by, with its interval.
///
/// # Errors
/// [`Outside`].
pub fn quote(question: &Question) -> Result<Quote, Outside> {
    let Question { rq_over_lambda: rq, rms_slope: slope, incidence_deg, side, lobe, .. } =
        *question;
    question.is_inside()?;
    let outside = match side {
        Side::Dielectric if incidence_deg <= GAP_INSIDE[1] => Outside::Critical(incidence_deg),
        _ => Outside::Incidence(incidence_deg),
    };
    let region = Region::of(side, lobe, incidence_deg).ok_or(outside)?;
    let course = region.course(question.engine, question.measure).ok_or(outside)?;
    let found = course.process.at(region.place(rq, slope, incidence_deg));
    let [low, middle, high] =
        [-1.0, 0.0, 1.0].map(|side| (found.value + side * course.reach * found.deviation).exp());
    let nearest = question.nearest(region).ok_or(outside)?;
    Ok(Quote { error_percent: middle, low_percent: low, high_percent: high, nearest })
}

impl Question {
    fn is_inside(&self) -> Result<(), Outside> {
        let Self { rq_over_lambda: rq, rms_slope: slope, ior, incidence_deg, .. } = *self;
        if !(INDICES[0]..=INDICES[1]).contains(&ior) {
            return Err(Outside::Index(ior));
        }
        if !(0.0..=MOST_IN_AIR).contains(&incidence_deg) {
            return Err(Outside::Incidence(incidence_deg));
        }
        let (row, up) = between(&HEIGHTS, rq).ok_or(Outside::Height(rq))?;
        let (column, along) = between(&SLOPES, slope).ok_or(Outside::Slope(slope))?;
        // of the four surfaces about it one may be missing, on the far side of the diagonal
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let missing: Vec<(usize, usize)> = corners
            .into_iter()
            .filter(|(i, j)| !is_solved(HEIGHTS[row + i], SLOPES[column + j]))
            .collect();
        let away = |at: usize, x: f64| if at == 0 { x } else { 1.0 - x };
        match missing[..] {
            [] => Ok(()),
            [(i, j)] if away(i, up) + away(j, along) >= 1.0 => Ok(()),
            _ => Err(Outside::Corner(rq, slope)),
        }
    }

    fn nearest(&self, region: Region) -> Option<Nearest> {
        let here = region.place(self.rq_over_lambda, self.rms_slope, self.incidence_deg);
        let distance = |s: &Solution| {
            let there = region.place(s.rq_over_lambda, s.rms_slope, s.incidence_deg);
            here.iter().zip(there).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
        };
        let known = solutions().iter().filter(|s| region.holds(s));
        let s = known.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some(Nearest {
            rq_over_lambda: s.rq_over_lambda,
            rms_slope: s.rms_slope,
            incidence_deg: s.incidence_deg,
            error_percent: s.error_percent(self.engine, self.measure),
            flux: s.flux,
            engine_flux: s.flux_of(self.engine),
            coherent_share: s.coherent_flux / s.flux,
        })
    }
}

/// The interval of a scale that holds a value, and the place in it from 0 to 1, in logarithms.
fn between(scale: &[f64], x: f64) -> Option<(usize, f64)> {
    let (first, last) = (*scale.first()?, *scale.last()?);
    if !(first / EDGE..=last * EDGE).contains(&x) {
        return None;
    }
    let x = x.clamp(first, last);
    let k = scale.partition_point(|s| *s <= x).clamp(1, scale.len() - 1) - 1;
    Some((k, (x / scale[k]).ln() / (scale[k + 1] / scale[k]).ln()))
}

fn is_solved(rq: f64, slope: f64) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
    solutions().iter().any(|s| same(s.rq_over_lambda, rq) && same(s.rms_slope, slope))
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::{Outside, Question, quote};
    use crate::atlas::{Engine, Measure, solutions};

    fn question(rq: f64, slope: f64, deg: f64, engine: Engine) -> Question {
        Question {
            rq_over_lambda: rq,
            rms_slope: slope,
            ior: 1.49,
            incidence_deg: deg,
            side: Side::Air,
            lobe: Lobe::Transmission,
            engine,
            measure: Measure::Reading,
        }
    }

    #[test]
    fn at_its_solutions_the_atlas_says_what_they_say() {
        let mut held = 0;
        for s in solutions() {
            let asked = Question {
                side: s.side,
                lobe: s.lobe,
                ..question(s.rq_over_lambda, s.rms_slope, s.incidence_deg, Engine::Rays)
            };
            let found = quote(&asked).unwrap();
            let known = s.error_percent(Engine::Rays, Measure::Reading);
            held += usize::from(found.low_percent <= known && known <= found.high_percent);
            assert!(found.low_percent < found.error_percent, "{found:?}");
            assert!(found.error_percent < found.high_percent, "{found:?}");
            let nearest = found.nearest;
            assert!((nearest.error_percent / known - 1.0).abs() < 1e-12, "{found:?}");
            assert!((nearest.coherent_share * nearest.flux - s.coherent_flux).abs() < 1e-12);
        }
        assert!(held >= 490, "{held}");
    }

    #[test]
    fn transmission_is_where_waves_are_at_home_and_slopes_are_what_spoils_them() {
        // the summary of the solutions: up to 30 deg at any Rq, between their surfaces too
        for (slope, most) in [(0.1, 0.03), (0.2, 0.12), (0.3, 0.35), (0.5, 1.0), (0.8, 2.5)] {
            for rq in [0.06, 0.15, 0.3, 0.6, 1.2] {
                for deg in [0.0, 12.0, 30.0] {
                    let found = quote(&question(rq, slope, deg, Engine::Kirchhoff)).unwrap();
                    assert!(found.error_percent < most, "{rq} {slope} {deg} {found:?}");
                }
            }
        }
        let of = |slope| quote(&question(0.6, slope, 20.0, Engine::Kirchhoff)).unwrap();
        assert!(of(0.14).error_percent < 0.5 * of(0.25).error_percent);
        assert!(of(0.25).high_percent < of(0.6).low_percent);
    }

    #[test]
    fn rays_are_right_where_heights_are_large_beside_the_wavelength() {
        let air = |rq, lobe| {
            let question = Question { lobe, ..question(rq, 0.2, 0.0, Engine::Rays) };
            quote(&question).unwrap().error_percent
        };
        for [smooth, rough] in [[0.07, 0.3], [0.3, 0.6], [0.6, 1.4]] {
            let [a, b] = [smooth, rough].map(|rq| air(rq, Lobe::Transmission));
            assert!(b < a, "{smooth} {a} {rough} {b}");
        }
        // q_z is four times as large in reflection
        assert!(air(1.4, Lobe::Transmission) < 1.0 && air(0.6, Lobe::Transmission) > 1.0);
        assert!(air(0.35, Lobe::Reflection) < 1.5 && air(0.15, Lobe::Reflection) > 2.0);
        // neither engine inside near the critical angle
        let inside = Question {
            side: Side::Dielectric,
            lobe: Lobe::Reflection,
            ..question(0.3, 0.25, 30.0, Engine::Rays)
        };
        for engine in [Engine::Rays, Engine::Kirchhoff] {
            let found = quote(&Question { engine, ..inside }).unwrap();
            assert!(found.low_percent > 5.0, "{engine:?} {found:?}");
        }
    }

    #[test]
    fn what_no_solution_surrounds_is_outside() {
        let of = |rq, slope, deg| quote(&question(rq, slope, deg, Engine::Kirchhoff));
        assert_eq!(of(3.5, 0.2, 0.0), Err(Outside::Height(3.5)));
        assert_eq!(of(0.01, 0.2, 0.0), Err(Outside::Height(0.01)));
        assert_eq!(of(0.4, 0.03, 0.0), Err(Outside::Slope(0.03)));
        assert_eq!(of(0.4, 0.9, 0.0), Err(Outside::Slope(0.9)));
        assert_eq!(of(2.5, 0.06, 0.0), Err(Outside::Corner(2.5, 0.06)));
        assert_eq!(of(0.025, 0.7, 0.0), Err(Outside::Corner(0.025, 0.7)));
        assert_eq!(of(0.4, 0.2, 70.0), Err(Outside::Incidence(70.0)));
        assert_eq!(of(0.4, 0.2, -1.0), Err(Outside::Incidence(-1.0)));
        assert!(of(f64::NAN, 0.2, 0.0).is_err() && of(0.4, f64::NAN, 0.0).is_err());
        assert!(of(0.4, 0.2, f64::NAN).is_err());
        let metal = Question { ior: 2.5, ..question(0.4, 0.2, 0.0, Engine::Rays) };
        assert_eq!(quote(&metal), Err(Outside::Index(2.5)));
        let inside = |deg| {
            let question = question(0.4, 0.2, deg, Engine::Rays);
            quote(&Question { side: Side::Dielectric, ..question })
        };
        for deg in [31.5, 42.2, 50.0] {
            assert_eq!(inside(deg), Err(Outside::Critical(deg)));
        }
        assert!(inside(15.0).is_ok() && inside(60.0).is_ok() && inside(62.0).is_err());
        // a lacking corner takes half of the square with it
        assert!(of(0.025, 0.31, 0.0).is_ok() && of(3.05, 0.2, 0.0).is_ok());
    }

    #[test]
    fn intervals_are_wider_between_surfaces_and_incidences() {
        for engine in Engine::ALL {
            let width = |rq, slope, deg| {
                let found = quote(&question(rq, slope, deg, engine)).unwrap();
                found.high_percent / found.low_percent
            };
            assert!(width(0.57, 0.25, 30.0) > width(0.4, 0.2, 30.0), "{engine:?}");
            assert!(width(0.4, 0.2, 45.0) > width(0.4, 0.2, 60.0), "{engine:?}");
        }
    }
}
