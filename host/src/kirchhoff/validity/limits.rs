//! Where the Kirchhoff approximation may be trusted on a height map, and whether the map is sampled well enough for its waves;
//! the figures of \[Sokolov eqs 9-11\] beside it. `CONVENTIONS.md` gives the reason for every limit.
//!
//! There are two verdicts: of the reading with the specular light, and of the diffuse light alone. Both ask that hardly any facet
//! violates the conditions of `margins`, that pixel and steps carry the light, and that no more light comes out than
//! went in, as far as the balance is known; the second, that the correlation length is long enough beside the wavelength.

use std::f64::consts::SQRT_2;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;
use serde::Serialize;

pub use super::conditions::{
    FarField, LobeValidity, MOST_EXCESS, MOST_SHARE, MOST_VIOLATING, Violating,
};
use super::facets::{Facets, Question};
use super::light::{LOBES, Light, SIDES};
use super::margins::{Angles, correlation_um};
pub use super::margins::{LEAST_LENGTH, LEAST_MARGIN, Margins};
use crate::kirchhoff::slopes::Slopes;
use crate::kirchhoff::wavelengths::Wavelengths;
use crate::surface::{Edges, HeightMap, Incomplete, Roughness};

/// The meaning of ">>" in eq. (9): `2 pi R cos^3` must be larger than this many wavelengths.
pub const CURVATURE_WAVELENGTHS: f64 = 10.0;
/// The meaning of ">>" in eq. (11): `cos theta` must be larger than this many `Rq / l`.
pub const COS_RQ_OVER_ACL: f64 = 3.0;
/// Correlation areas of a map at least.
pub const FEWEST_AREAS: f64 = 100.0;
/// Validity of the Kirchhoff approximation on a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validity {
    /// The light.
    #[serde(rename = "wavelength_nm")]
    pub wavelengths: Wavelengths,
    /// Relative index of the dielectric.
    pub ior: f64,
    /// The larger pitch, um.
    pub pixel_um: f64,
    /// Rms height, um.
    pub rq_um: f64,
    /// Eq. (10): Rq over the 1/e autocorrelation length; `None` if the autocorrelation does not fall to 1/e.
    pub rq_over_acl: Option<f64>,
    /// Eq. (11): the largest angle of incidence or observation from the mean normal, on either side, degrees;
    /// 0 if there is none, `None` with [`rq_over_acl`](Self::rq_over_acl).
    pub most_angle_deg: Option<f64>,
    /// Rms slope of steps between neighbours, mean square of both directions.
    pub rms_slope: f64,
    /// Rms slope along the direction in which it is largest.
    pub steepest_slope: f64,
    /// `sqrt(2) Rq` over that slope, um: the 1/e autocorrelation length if heights and autocorrelation were Gaussian, shorter
    /// than that of a map with fine structures on coarse ones; `None` if the map is flat.
    pub correlation_um: Option<f64>,
    /// Area of the map over the square of its autocorrelation length: the number of its independent parts.
    pub correlation_areas: Option<f64>,
    /// The angular reach of the pixel from the specular direction, for each wavelength, side and lobe.
    pub far_fields: Vec<FarField>,
    /// The conditions of every lobe, for each wavelength, side, lobe and incidence.
    pub lobes: Vec<LobeValidity>,
}

/// Why there is no verdict.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ValidityError {
    /// Points are missing.
    #[error(transparent)]
    Incomplete(#[from] Incomplete),
    /// An angle of incidence out of range, degrees.
    #[error("an incidence of {0} deg; give 0 to below 90 degrees")]
    Incidence(f64),
    /// A height, slope or length that is none.
    #[error("a {name} of {value}; give a finite one, not below zero, of lengths above it")]
    Size {
        /// Of what.
        name: &'static str,
        /// The given value.
        value: f64,
    },
}

/// The lost light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// Where the light comes from.
    pub side: Side,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// `1 - R - T`.
    pub lost: f64,
}

impl Validity {
    /// The default incidences, degrees.
    pub const INCIDENCES_DEG: [f64; 3] = [0.0, 30.0, 60.0];

    /// The conditions for light of these angles of incidence in the plane x-z, from both sides.
    ///
    /// # Errors
    /// Missing points, and angles that are not angles of incidence.
    pub fn of(
        map: &HeightMap,
        edges: Edges,
        eta: RelativeIor<f64>,
        wavelengths: &Wavelengths,
        incidences_deg: &[f64],
    ) -> Result<Self, ValidityError> {
        if let Some(bad) = incidences_deg.iter().find(|deg| !(0.0..90.0).contains(*deg)) {
            return Err(ValidityError::Incidence(*bad));
        }
        map.need_complete()?;
        let roughness = &Roughness::of(map);
        let lights = Light::all(wavelengths, eta.get());
        let incidences: Vec<(Side, f64)> = SIDES
            .iter()
            .flat_map(|&side| incidences_deg.iter().map(move |&deg| (side, deg)))
            .collect();
        let cases = |light: Light| incidences.iter().filter(move |(side, _)| *side == light.side);
        let ascending = |mut limits: Vec<f64>| {
            limits.sort_by(f64::total_cmp);
            limits.dedup();
            limits
        };
        let steps = |l: &Light| cases(*l).map(|c| l.most_step_um(c.1)).collect::<Vec<_>>();
        let question = Question {
            light: incidences
                .iter()
                .map(|&(side, deg)| {
                    let (sine, cosine) = deg.to_radians().sin_cos();
                    [sine, cosine, if side == Side::Air { 1.0 } else { -1.0 }]
                })
                .collect(),
            curvature_um: ascending(lights.iter().map(least_curvature_um).collect()),
            step_um: ascending(lights.iter().flat_map(steps).collect()),
            // the wavelength has no part in these
            lobes: incidences
                .iter()
                .flat_map(|&(side, deg)| {
                    LOBES
                        .map(|lobe| Angles::of(&Light { um: 1.0, side, lobe, eta: eta.get() }, deg))
                })
                .collect(),
        };
        let facets = Facets::of(map, edges, &question)?;
        let number = |limits: &[f64], limit: f64| limits.partition_point(|l| *l < limit);

        let rms_slope = rms_slope(roughness);
        let slopes = Slopes::of(map, edges);
        let steepest_slope = slopes.steepest();
        let correlation_um = correlation_um(roughness.rq_um, steepest_slope);
        let pixel_um = map.dx_um().max(map.dy_um());
        let area_um2 = map.nx() as f64 * map.dx_um() * map.ny() as f64 * map.dy_um();
        let rq_over_acl = match roughness.acl_um {
            Some(l) => Some(roughness.rq_um / l),
            None => (roughness.rq_um <= 0.0).then_some(0.0),
        };
        let mut validity = Self {
            wavelengths: wavelengths.clone(),
            ior: eta.get(),
            pixel_um,
            rq_um: roughness.rq_um,
            rq_over_acl,
            most_angle_deg: rq_over_acl
                .map(|ratio| (COS_RQ_OVER_ACL * ratio).min(1.0).acos().to_degrees()),
            rms_slope,
            steepest_slope,
            correlation_um: Some(correlation_um).filter(|l| l.is_finite()),
            correlation_areas: roughness.acl_um.map(|l| area_um2 / (l * l)),
            far_fields: lights.iter().map(|l| FarField::of(l, pixel_um, rms_slope)).collect(),
            lobes: Vec::new(),
        };
        for light in &lights {
            let curved = number(&question.curvature_um, least_curvature_um(light));
            for (k, &(_, deg)) in incidences.iter().enumerate().filter(|c| c.1.0 == light.side) {
                let step = number(&question.step_um, light.most_step_um(deg));
                let way = 2 * k + LOBES.iter().position(|lobe| *lobe == light.lobe).unwrap_or(0);
                validity.lobes.push(LobeValidity {
                    wavelength_nm: light.nm(),
                    side: light.side,
                    lobe: light.lobe,
                    incidence_deg: deg,
                    specular_deg: light.specular_deg(deg),
                    curved_fraction: facets.curved_share(k, curved),
                    undersampled_fraction: facets.step_share(step),
                    phase_rms: light.momentum(deg) * roughness.rq_um,
                    turned_away_fraction: facets.turned_away(k),
                    margins: question.lobes[way].margins(slopes.along(1.0, 0.0)),
                    violating: facets.violating(way),
                    correlation_wavelengths: validity.correlation_um.map(|l| l / light.um),
                    least_correlation_wavelengths: question.lobes[way].least_length(),
                    lost: None,
                    passes: false,
                    diffuse_passes: false,
                });
            }
        }
        validity.decide();
        Ok(validity)
    }

    /// The verdicts with the lost light: where more light comes out than went in, nothing is valid.
    #[must_use]
    pub fn balanced(mut self, losses: &[Loss]) -> Self {
        for lobe in &mut self.lobes {
            let of_lobe = |l: &&Loss| {
                l.side == lobe.side && l.incidence_deg.total_cmp(&lobe.incidence_deg).is_eq()
            };
            lobe.lost = losses.iter().find(of_lobe).map(|l| l.lost).or(lobe.lost);
        }
        self.decide();
        self
    }

    /// The only place that decides which lobes pass.
    fn decide(&mut self) {
        for k in 0..self.lobes.len() {
            let lobe = &self.lobes[k];
            let passes = lobe.is_seen_aright()
                && lobe.is_sampled()
                && lobe.conserves_energy()
                && self.carried(lobe).is_none_or(FarField::is_wide_enough);
            let diffuse_passes = passes && lobe.is_long_enough();
            self.lobes[k] = LobeValidity { passes, diffuse_passes, ..*lobe };
        }
    }

    /// The angular reach of the pixel for a lobe.
    fn carried(&self, lobe: &LobeValidity) -> Option<&FarField> {
        self.far_fields.iter().find(|f| {
            (f.side, f.lobe) == (lobe.side, lobe.lobe)
                && f.wavelength_nm.total_cmp(&lobe.wavelength_nm).is_eq()
        })
    }

    /// The part for one path of the light alone.
    pub fn of_lobe(mut self, side: Side, lobe: Lobe) -> Self {
        self.lobes.retain(|l| l.side == side && l.lobe == lobe);
        self.far_fields.retain(|f| f.side == side && f.lobe == lobe);
        self
    }

    /// Whether the reading of a lobe may be trusted at this angle of incidence for all wavelengths.
    ///
    /// Between two examined incidences both must pass; beyond the largest the result is `false`.
    pub fn passes(&self, side: Side, lobe: Lobe, incidence_deg: f64) -> bool {
        self.all(side, lobe, incidence_deg, |l| l.passes)
    }

    /// The same for its diffuse light alone.
    pub fn diffuse_passes(&self, side: Side, lobe: Lobe, incidence_deg: f64) -> bool {
        self.all(side, lobe, incidence_deg, |l| l.diffuse_passes)
    }

    fn all(
        &self,
        side: Side,
        lobe: Lobe,
        incidence_deg: f64,
        passes: fn(&LobeValidity) -> bool,
    ) -> bool {
        const SAME: f64 = 1e-9;
        let of_lobe = || self.lobes.iter().filter(|l| l.side == side && l.lobe == lobe);
        let angles = || of_lobe().map(|l| l.incidence_deg);
        let next = angles().filter(|a| *a >= incidence_deg - SAME).min_by(f64::total_cmp);
        let last = angles().filter(|a| *a <= incidence_deg + SAME).max_by(f64::total_cmp);
        let Some(next) = next else { return false };
        let last = last.unwrap_or(next);
        let judges = |l: &&LobeValidity| {
            [last, next].iter().any(|angle| l.incidence_deg.total_cmp(angle).is_eq())
        };
        of_lobe().filter(judges).all(passes)
    }
}

/// Eq. (9): the smallest `2 pi R cos^3` that will do, um.
fn least_curvature_um(light: &Light) -> f64 {
    CURVATURE_WAVELENGTHS * light.scattered_um()
}

/// Rms slope, mean square of the directions that have neighbours.
fn rms_slope(roughness: &Roughness) -> f64 {
    match (roughness.rms_slope_x, roughness.rms_slope_y) {
        (Some(x), Some(y)) => x.hypot(y) / SQRT_2,
        (one, other) => one.or(other).unwrap_or(0.0),
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    use super::Validity;
    use crate::kirchhoff::Wavelengths;
    use crate::surface::{Edges, HeightMap};

    fn waves(period: f64, height: f64) -> HeightMap {
        let (n, pitch, tau) = (256_u32, 0.25, std::f64::consts::TAU);
        let at = |k: u32| {
            let (x, y) = (pitch * f64::from(k % n), pitch * f64::from(k / n));
            height * ((tau * x / period).sin() + (tau * y / period).sin())
        };
        let heights = (0..n * n).map(at).collect();
        HeightMap::new((n as usize, n as usize), (pitch, pitch), heights).unwrap()
    }

    fn validity(map: &HeightMap, nm: &str) -> Validity {
        let eta = RelativeIor::new(1.5).unwrap();
        let light = nm.parse::<Wavelengths>().unwrap();
        Validity::of(map, Edges::Periodic, eta, &light, &[0.0, 40.0]).unwrap()
    }

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-3 * b.abs().max(1e-3), "{a} {b}");
    }

    #[test]
    fn figures_follow_from_their_formulas() {
        // heights h (sin + sin): Rq = h, autocorrelation (1 + cos) / 2 along either axis
        let v = validity(&waves(4.0, 0.1), "500");
        let level = 2.0 * (-1.0_f64).exp() - 1.0;
        let l = 4.0 * level.acos() / std::f64::consts::TAU;
        assert!((v.rq_over_acl.unwrap() / (0.1 / l) - 1.0).abs() < 0.02, "{:?}", v.rq_over_acl);
        near(v.most_angle_deg.unwrap(), (3.0 * v.rq_over_acl.unwrap()).acos().to_degrees());
        near(v.correlation_areas.unwrap(), (64.0 * v.rq_over_acl.unwrap() / 0.1).powi(2));
    }

    #[test]
    fn sampling_is_judged_by_the_light_that_leaves() {
        let v = validity(&waves(16.0, 0.2), "500");
        let reach = |side, lobe| {
            v.far_fields.iter().find(|f| f.side == side && f.lobe == lobe).unwrap().reach_deg
        };
        // 0.25 um pixel: lambda / (2 pixel) is 1 in air, 2/3 in the dielectric
        near(reach(Side::Air, Lobe::Reflection), 90.0);
        near(reach(Side::Dielectric, Lobe::Transmission), 90.0);
        near(reach(Side::Air, Lobe::Transmission), (2.0_f64 / 3.0).asin().to_degrees());
        near(reach(Side::Dielectric, Lobe::Reflection), (2.0_f64 / 3.0).asin().to_degrees());
        let lobe = v.far_fields[0].lobe_deg.to_radians();
        near((lobe / 2.0).tan(), 3.0349 * v.rms_slope);
        assert!(v.passes(Side::Air, Lobe::Transmission, 12.0));
        // waves h (sin + sin): the rms slope along x is k h / sqrt 2
        near(v.steepest_slope, 0.2 * std::f64::consts::TAU / 16.0 / std::f64::consts::SQRT_2);
        near(v.correlation_um.unwrap(), 0.2 * std::f64::consts::SQRT_2 / v.steepest_slope);
        // both neighbours of an angle have a say
        let mut worse = v.clone();
        for lobe in worse.lobes.iter_mut().filter(|l| l.incidence_deg < 1.0) {
            lobe.passes = false;
        }
        assert!(!worse.passes(Side::Air, Lobe::Transmission, 12.0));
        assert!(worse.passes(Side::Air, Lobe::Transmission, 40.0));
        assert!(!v.passes(Side::Air, Lobe::Transmission, 41.0), "not looked at");
    }
}
