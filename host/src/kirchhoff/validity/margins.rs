//! The margins of a lobe: its distance from where Kirchhoff's integral fails.
//!
//! A facet whose slope is `p` along the plane of incidence and `q` across it turns the middle of a lobe by about `r p` along the
//! plane and `r q cos theta_o` out of it, with `r = |n_i cos theta_i - n_o cos theta_o| / (n_o cos theta_o)` in
//! transmission and 2 in reflection. The integral gives such facets light although
//! - (a) they send it below the horizon,
//! - (b) they face away from it, `p tan theta_i > 1`,
//! - (c) it meets them on the other side of the critical angle than the mean plane, where Fresnel's factors are others.
//!
//! A margin is the slope along the plane at which that begins, in rms slopes of the surface. Against rigorous solutions for grooves
//! with Gaussian heights, three of all of them tell the lobes that err by less than 1 % of the peak (`CONVENTIONS.md`).

use std::f64::consts::{FRAC_PI_2, SQRT_2};

use asperity_core::bsdf::Lobe;
use serde::{Serialize, Serializer};

use super::light::Light;

/// Margins at least, of a Gaussian surface.
pub const LEAST_MARGIN: f64 = 3.0;
/// Correlation length at least for the diffuse light alone, times the square of the cosine of the largest angle, in
/// vacuum wavelengths.
pub const LEAST_LENGTH: f64 = 0.75;

/// Distances of a lobe from where the approximation fails, in rms slopes; infinite where it never does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// (a) Of the middle of the lobe from the horizon; 0 beyond the critical angle, where transmission has no middle.
    #[serde(rename = "horizon_margin", serialize_with = "finite")]
    pub horizon: f64,
    /// (b) Of facets from facing away.
    #[serde(rename = "away_margin", serialize_with = "finite")]
    pub away: f64,
    /// (c) Of the incidence from the critical angle.
    #[serde(rename = "critical_margin", serialize_with = "finite")]
    pub critical: f64,
}

impl Margins {
    /// The smallest.
    pub fn least(&self) -> f64 {
        self.horizon.min(self.away).min(self.critical)
    }
}

/// Which of (a), (b) and (c) a facet violates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Violations {
    pub(super) horizon: bool,
    pub(super) away: bool,
    pub(super) critical: bool,
}

impl Violations {
    pub(super) fn any(self) -> bool {
        self.horizon || self.away || self.critical
    }
}

/// Angles of a lobe, radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Angles {
    incidence: f64,
    tangent: f64,
    /// Middle of the lobe from the normal; `None` on total reflection.
    specular: Option<f64>,
    /// Turn of the light for a slope of 1, along the plane of incidence and out of it.
    turns: [f64; 2],
    /// Where total reflection begins; `None` from the thinner medium.
    critical: Option<f64>,
    /// The larger of the angles on either side.
    largest: f64,
    /// Square of the smallest slope that violates anything.
    harmless: f64,
}

impl Angles {
    pub(super) fn of(light: &Light, incidence_deg: f64) -> Self {
        let incidence = incidence_deg.to_radians();
        let (near, far) = light.media();
        let refracted = |n: f64| {
            let sine = near / n * incidence.sin();
            (sine < 1.0).then(|| sine.asin())
        };
        let critical = (near > far).then(|| (far / near).asin());
        let (specular, turns) = match light.lobe {
            Lobe::Reflection => (Some(incidence), [2.0, 2.0 * incidence.cos()]),
            Lobe::Transmission => match refracted(far) {
                Some(out) => {
                    let across = (near * incidence.cos() - far * out.cos()).abs() / far;
                    (Some(out), [across / out.cos(), across])
                }
                None => (None, [0.0; 2]),
            },
        };
        let largest = incidence.max(refracted(far).unwrap_or(0.0));
        let mut angles = Self {
            incidence,
            tangent: incidence.tan(),
            specular,
            turns,
            critical,
            largest,
            harmless: 0.0,
        };
        angles.harmless = angles.margins(1.0).least().powi(2);
        angles
    }

    /// For a surface of this rms slope along the plane of incidence.
    pub(super) fn margins(&self, slope: f64) -> Margins {
        let over = |room: f64, turn: f64| {
            if room <= 0.0 {
                0.0
            } else if turn * slope > 0.0 {
                room / (turn * slope)
            } else {
                f64::INFINITY
            }
        };
        Margins {
            horizon: self.specular.map_or(0.0, |out| over(FRAC_PI_2 - out, self.turns[0])),
            away: over(1.0, self.tangent),
            critical: self
                .critical
                .map_or(f64::INFINITY, |critical| over((critical - self.incidence).abs(), 1.0)),
        }
    }

    /// The conditions that a facet of slopes `p` along and `q` across the plane of incidence violates, it or its
    /// mirror image.
    #[inline]
    pub(super) fn violated(&self, p: f64, q: f64) -> Violations {
        // turns out of the plane bring nothing sooner to its limit than turns in it
        if p * p + q * q < self.harmless {
            return Violations::default();
        }
        let horizon = self.specular.is_none_or(|out| {
            let [along, across] = [self.turns[0] * p, self.turns[1] * q];
            let turn = along.hypot(across);
            turn >= FRAC_PI_2 || outward(out, turn, along) <= 0.0
        });
        let critical = self.critical.is_some_and(|critical| {
            let tilt = p.hypot(q);
            if self.incidence < critical {
                outward(self.incidence, tilt.min(FRAC_PI_2), p) <= critical.cos()
            } else {
                outward(self.incidence, -tilt.min(FRAC_PI_2), p) >= critical.cos()
            }
        });
        Violations { horizon, away: p.abs() * self.tangent >= 1.0, critical }
    }

    /// The light that a facet receives relative to a facet of the mean plane, it and its mirror image together.
    #[inline]
    pub(super) fn taken(&self, p: f64) -> f64 {
        (p.abs() * self.tangent).max(1.0)
    }

    /// The correlation length from which on the diffuse light alone is right, in vacuum wavelengths.
    pub(super) fn least_length(&self) -> f64 {
        LEAST_LENGTH / self.largest.cos().powi(2)
    }
}

/// Cosine of the angle from the normal of a direction at `angle` from it that is turned outwards by `turn`, of which `along` says
/// how much is in the plane.
fn outward(angle: f64, turn: f64, along: f64) -> f64 {
    // of the great circle on which it turns, the share that leads away from the normal
    let size = turn.abs();
    let share = if size > 0.0 { along.abs().min(size) / size } else { 0.0 };
    angle.cos() * turn.cos() - angle.sin() * turn.sin() * share
}

/// Autocorrelation length of the Gaussian surface of this rms height and slope, um; infinite for a level one.
pub(super) fn correlation_um(rq_um: f64, slope: f64) -> f64 {
    if rq_um > 0.0 && slope > 0.0 { SQRT_2 * rq_um / slope } else { f64::INFINITY }
}

/// Numbers for files: what is infinite is absent.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_some(value) } else { serializer.serialize_none() }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::{Angles, Light};

    fn angles(side: Side, lobe: Lobe, deg: f64) -> Angles {
        Angles::of(&Light { um: 0.55, side, lobe, eta: 1.49 }, deg)
    }

    fn near(a: f64, b: f64) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn margins_are_the_rule_of_the_atlas() {
        let s = 0.2;
        let rad = f64::to_radians;
        let mirrored = angles(Side::Air, Lobe::Reflection, 60.0).margins(s);
        near(mirrored.horizon, rad(30.0) / (2.0 * s));
        near(mirrored.away, rad(30.0).tan() / s);
        assert!(mirrored.critical.is_infinite());
        // (90 - theta_o) / (s |n_i cos ti - n_o cos to| / (n_o cos to))
        let out = (1.49 * rad(30.0).sin()).asin();
        let through = angles(Side::Dielectric, Lobe::Transmission, 30.0).margins(s);
        let turn = (1.49 * rad(30.0).cos() - out.cos()).abs() / out.cos();
        near(through.horizon, (rad(90.0) - out) / (s * turn));
        near(through.critical, ((1.0_f64 / 1.49).asin() - rad(30.0)) / s);
        // beyond the critical angle nothing is transmitted in any direction of its own
        let beyond = angles(Side::Dielectric, Lobe::Transmission, 50.0);
        assert!(beyond.specular.is_none() && beyond.margins(1e-9).horizon <= 0.0);
        assert!(beyond.violated(0.0, 0.0).horizon);
        // a level surface is far from everything
        assert!(angles(Side::Air, Lobe::Transmission, 0.0).margins(0.0).least().is_infinite());
    }

    #[test]
    fn facets_violate_where_their_margin_is_used_up() {
        for side in [Side::Air, Side::Dielectric] {
            for lobe in [Lobe::Reflection, Lobe::Transmission] {
                for deg in [0.0, 20.0, 35.0, 60.0, 80.0] {
                    let angles = angles(side, lobe, deg);
                    if angles.specular.is_none() {
                        continue;
                    }
                    let limit = angles.margins(1.0);
                    for sign in [-1.0, 1.0] {
                        for share in [0.2, 0.7, 0.999, 1.001, 1.4, 3.0] {
                            let p = sign * share * limit.least();
                            let found = angles.violated(p, 0.0);
                            let case = format!("{side:?} {lobe:?} {deg} {p}");
                            assert_eq!(found.any(), share > 1.0, "{case}");
                            assert_eq!(found.away, p.abs() >= limit.away, "{case}");
                            assert_eq!(found.horizon, p.abs() >= limit.horizon, "{case}");
                        }
                    }
                }
            }
        }
        // at normal incidence all azimuths are alike, and at 60 deg slopes across the plane matter less
        let level = angles(Side::Air, Lobe::Reflection, 0.0);
        for around in [0.0, 0.7, 1.5] {
            let (sin, cos) = f64::sin_cos(around);
            let limit = std::f64::consts::FRAC_PI_4;
            assert!(!level.violated(0.999 * limit * cos, 0.999 * limit * sin).any());
            assert!(level.violated(1.001 * limit * cos, 1.001 * limit * sin).horizon);
        }
        let slanted = angles(Side::Air, Lobe::Reflection, 60.0);
        assert!(slanted.violated(0.3, 0.0).any() && !slanted.violated(0.0, 0.5).any());
        let inside = angles(Side::Dielectric, Lobe::Reflection, 50.0);
        assert!(inside.violated(0.14, 0.0).critical && !inside.violated(0.0, 0.14).critical);
    }

    #[test]
    fn short_correlation_spoils_diffuse_light_the_sooner_the_more_it_slants() {
        let length = |side, deg| angles(side, Lobe::Transmission, deg).least_length();
        near(length(Side::Air, 0.0), 0.75);
        near(length(Side::Air, 30.0), 1.0);
        near(length(Side::Air, 60.0), 3.0);
        let out: f64 = 1.49 * 0.5;
        near(length(Side::Dielectric, 30.0), 0.75 / (1.0 - out * out));
    }
}
