//! Facets of a profile, and the light of single facets.
//!
//! Every facet that faces the light gets its share of it, whatever stands between, and reflects or transmits it once by Fresnel's and
//! Snell's laws; light that it sends into the surface is lost. This is Walter's microfacet model with G = 1 and the density of
//! facets of the profile itself, to which Kirchhoff's integral tends where waves are short.

use crate::angles::Gathered;
use crate::fresnel;
use crate::problem::{Incidence, Problem, RigorousError, Side};
use crate::series::Series;
use crate::waves::Kind;

/// The largest change of slope from facet to facet.
const CHANGE: f64 = 0.01;
/// The most facets in a period.
const MOST: usize = 1 << 15;

/// A profile as plane facets of equal width.
#[derive(Clone, Debug)]
pub(crate) struct Facets {
    /// um.
    pub(crate) period: f64,
    /// um.
    pub(crate) width: f64,
    /// Heights of their ends, um.
    pub(crate) heights: Vec<f64>,
    /// The largest slope.
    pub(crate) steepest: f64,
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
}

/// A ray at a facet: unit vectors, x along the profile, z into the air.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Where the mirrored ray goes.
    pub(crate) mirrored: [f64; 2],
    /// Where the refracted ray goes; `None` on total reflection.
    pub(crate) refracted: Option<[f64; 2]>,
    /// The reflected share, TE, TM and the mean of both.
    pub(crate) reflected: [f64; 3],
}

impl Facets {
    pub(crate) fn new(problem: &Problem) -> Self {
        let profile = problem.profile();
        let period = profile.period_um();
        let series = Series::new(profile.heights_um(), period, 1e-9 * problem.wavelength_um());
        let least = 8 * series.highest().max(16);
        let sharpest = (0..least)
            .map(|j| series.at(period * j as f64 / least as f64).second.abs())
            .fold(0.0, f64::max);
        let count = ((sharpest * period / CHANGE) as usize).clamp(least, MOST.max(least));
        let width = period / count as f64;
        let heights: Vec<f64> = (0..count).map(|j| series.at(width * j as f64).value).collect();
        let steepest = (0..count)
            .map(|j| ((heights[(j + 1) % count] - heights[j]) / width).abs())
            .fold(0.0, f64::max);
        let lowest = heights.iter().fold(f64::MAX, |a, h| a.min(*h));
        let highest = heights.iter().fold(f64::MIN, |a, h| a.max(*h));
        Self { period, width, heights, steepest, lowest, highest }
    }

    /// The height of the left end of a facet, counted from any period.
    #[inline]
    pub(crate) fn height(&self, facet: i64) -> f64 {
        self.heights[facet.rem_euclid(self.heights.len() as i64) as usize]
    }

    /// The height at `x` um from the left end of a facet.
    #[inline]
    pub(crate) fn surface(&self, x: f64, facet: i64) -> f64 {
        let (left, right) = (self.height(facet), self.height(facet + 1));
        left + (right - left) * x / self.width
    }

    /// Its unit normal, into the air.
    #[inline]
    pub(crate) fn normal(&self, facet: i64) -> [f64; 2] {
        let slope = (self.height(facet + 1) - self.height(facet)) / self.width;
        let scale = 1.0 / slope.hypot(1.0);
        [-slope * scale, scale]
    }
}

/// The unit vector along which light of an incidence travels.
pub(crate) fn travel(problem: &Problem, incidence: Incidence) -> Result<[f64; 2], RigorousError> {
    let Incidence { side, order } = incidence;
    let last = problem.last_order(side);
    if order.abs() > last {
        return Err(RigorousError::Incidence { order, last });
    }
    let sine = problem.sine(side, order);
    let cos = (1.0 - sine * sine).max(0.0).sqrt();
    Ok([sine, if side == Side::Air { -cos } else { cos }])
}

/// Light that travels along `d` meets a facet of normal `m`; `eta` is the index of the medium beyond over that of the light.
#[inline]
pub(crate) fn meet(d: [f64; 2], m: [f64; 2], eta: f64) -> Meeting {
    let along = d[0] * m[0] + d[1] * m[1]; // negative: from the air
    let cos = along.abs().min(1.0);
    let mirrored = [0, 1].map(|axis| d[axis] - 2.0 * along * m[axis]);
    let g2 = (eta - 1.0) * (eta + 1.0) + cos * cos;
    let refracted = (g2 > 0.0).then(|| {
        let push = (g2.sqrt() - cos) * 1.0f64.copysign(along);
        let to = [0, 1].map(|axis| (d[axis] + push * m[axis]) / eta);
        let length = to[0].hypot(to[1]);
        to.map(|x| x / length)
    });
    let [te, tm] = fresnel::reflected(cos, eta);
    Meeting { mirrored, refracted, reflected: [te, tm, 0.5 * (te + tm)] }
}

/// The light of single facets for TE, TM and unpolarised light, as shares of the incident flux.
///
/// # Errors
/// An incidence that does not travel.
pub fn facets(problem: &Problem, incidence: Incidence) -> Result<[Gathered; 3], RigorousError> {
    gather(problem, &Facets::new(problem), incidence)
}

pub(crate) fn gather(
    problem: &Problem,
    facets: &Facets,
    incidence: Incidence,
) -> Result<[Gathered; 3], RigorousError> {
    let d = travel(problem, incidence)?;
    let above = incidence.side == Side::Air;
    let eta = problem.index_of(incidence.side.other()) / problem.index_of(incidence.side);
    let mut gathered: [Gathered; 3] = Default::default();
    for facet in 0..facets.heights.len() as i64 {
        let m = facets.normal(facet);
        let along = d[0] * m[0] + d[1] * m[1];
        if (along < 0.0) != above {
            continue; // faces away
        }
        let share = along.abs() / (m[1] * d[1].abs() * facets.heights.len() as f64);
        let meeting = meet(d, m, eta);
        for (light, gathered) in gathered.iter_mut().enumerate() {
            let reflected = share * meeting.reflected[light];
            if (meeting.mirrored[1] > 0.0) == above {
                gathered.of_mut(Kind::Reflected).add(meeting.mirrored[0], reflected);
            }
            if let Some(to) = meeting.refracted.filter(|to| (to[1] > 0.0) != above) {
                gathered.of_mut(Kind::Transmitted).add(to[0], share - reflected);
            }
        }
    }
    Ok(gathered)
}

#[cfg(test)]
mod tests {
    use super::meet;

    #[test]
    fn a_meeting_keeps_to_snells_law() {
        let (s, c) = 0.4f64.sin_cos();
        for (d, eta) in [([s, -c], 1.49), ([s, c], 1.0 / 1.49), ([-s, -c], 1.0 / 1.2)] {
            let tilt = [0.1f64.sin(), 0.1f64.cos()];
            let meeting = meet(d, tilt, eta);
            let to = meeting.refracted.unwrap();
            let along = |v: [f64; 2]| v[0] * tilt[1] - v[1] * tilt[0];
            assert!((eta * along(to) - along(d)).abs() < 1e-14);
            assert!((along(meeting.mirrored) - along(d)).abs() < 1e-14);
            assert!(to[1] * d[1] > 0.0 && meeting.mirrored[1] * d[1] < 0.0);
        }
        assert!(meet([0.9, 0.19f64.sqrt()], [0.0, 1.0], 1.0 / 1.49).refracted.is_none());
    }
}
