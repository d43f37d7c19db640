//! One facet in the coordinates of a table: where it sends light, and what the table divides out.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::table::{Fall, Form};

/// Light from one side at one cosine of incidence, on its way into one lobe; its mirror direction has x > 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    pub(super) wi: Direction<f64>,
    lobe: Lobe,
    n_i: f64,
    n_o: f64,
    /// Far index over near one.
    beyond: f64,
}

/// What a facet makes of a beam.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    pub(super) wo: Direction<f64>,
    /// `|wi.m|`.
    cos_m: f64,
    /// `d omega_m / d omega_o`.
    pub(super) jacobian: f64,
    /// Fresnel's share.
    fresnel: f64,
}

impl Beam {
    pub(super) fn new(eta: f64, side: Side, lobe: Lobe, cos: f64) -> Self {
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (z, near, far) = match side {
            Side::Air => (cos, 1.0, eta),
            Side::Dielectric => (-cos, eta, 1.0),
        };
        let n_o = if lobe == Lobe::Reflection { near } else { far };
        Self { wi: Direction::from_unit(-sin, 0.0, z), lobe, n_i: near, n_o, beyond: far / near }
    }

    /// The facet of slope `s` and azimuth's cosine `p`; `None` if it sends nothing into the lobe.
    pub(super) fn turn(&self, s: f64, p: f64) -> Option<Turned> {
        let cos = 1.0 / s.hypot(1.0);
        let sin = s * cos;
        let m = Direction::from_unit(sin * p, sin * (1.0 - p * p).max(0.0).sqrt(), cos);
        let along = self.wi.dot(m);
        if (along > 0.0) != (self.wi.z() > 0.0) {
            return None;
        }
        let share = fresnel::dielectric(along.abs(), self.beyond);
        let (wo, fresnel) = match self.lobe {
            Lobe::Reflection => (self.wi.reflect(m), share.reflected),
            Lobe::Transmission => (self.wi.refract(m, self.beyond)?, share.transmitted),
        };
        if (wo.side()? == self.wi.side()?) != (self.lobe == Lobe::Reflection) {
            return None;
        }
        let cos_m = along.abs();
        let jacobian = match self.lobe {
            Lobe::Reflection => 0.25 / cos_m,
            Lobe::Transmission => {
                let o = wo.dot(m).abs();
                let length = self.n_i * cos_m - self.n_o * o;
                self.n_o * self.n_o * o / (length * length)
            }
        };
        let fine = jacobian.is_finite() && fresnel > 0.0 && cos_m > 0.0;
        fine.then_some(Turned { wo, cos_m, jacobian, fresnel })
    }

    /// `ars` of one `Q`.
    pub(super) fn per(&self, t: &Turned, form: Form, masking: f64) -> f64 {
        let share = t.cos_m * t.jacobian * t.fresnel;
        let sum = |w: Direction<f64>| {
            let cos2 = w.z() * w.z();
            w.z().abs() + (cos2 + masking * masking * (1.0 - cos2).max(0.0)).sqrt()
        };
        match form {
            Form::Masked => share * 4.0 * t.wo.z().abs() / (sum(self.wi) * sum(t.wo)),
            Form::Drawn => share / t.cos_m,
        }
    }
}

/// `q^n` of a slope.
pub(super) fn tail(fall: Fall, s: f64, s0: f64) -> f64 {
    let q = s0 * (1.0 + s * s) / (s0 * s0 + s * s);
    match fall {
        Fall::Flat => 1.0,
        Fall::Second => q,
        Fall::Fourth => q * q,
    }
}

/// Lobe, slope and azimuth's cosine of the facet between two directions; `towards` is the azimuth of the mirror direction,
/// which at normal incidence `wi` does not tell.
pub(super) fn between(
    eta: f64,
    towards: [f64; 2],
    wi: Direction<f64>,
    wo: Direction<f64>,
) -> Option<(Lobe, f64, f64)> {
    let ([ix, iy, iz], [ox, oy, oz]) = (wi.xyz(), wo.xyz());
    let index = |z: f64| if z > 0.0 { 1.0 } else { eta };
    let (n_i, n_o) = (index(iz), index(oz));
    let h = [n_i * ix + n_o * ox, n_i * iy + n_o * oy, n_i * iz + n_o * oz];
    let lobe = if (iz > 0.0) == (oz > 0.0) { Lobe::Reflection } else { Lobe::Transmission };
    let across = h[0].hypot(h[1]);
    let along = (towards[0] * h[0] + towards[1] * h[1]) * 1.0_f64.copysign(h[2]);
    let p = if across > 0.0 { (along / across).clamp(-1.0, 1.0) } else { 1.0 };
    let s = across / h[2].abs();
    s.is_finite().then_some((lobe, s, p))
}
