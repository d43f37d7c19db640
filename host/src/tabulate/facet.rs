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
    form: Form,
    n_i: f64,
    n_o: f64,
    /// Far index over near one.
    beyond: f64,
}

/// The effect of a facet on a beam.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    pub(super) wo: Direction<f64>,
    /// `|wi.m|`.
    cos_m: f64,
    /// `d omega_m / d omega_o`.
    pub(super) jacobian: f64,
    /// The factor of the form without masking.
    share: f64,
}

impl Beam {
    pub(super) fn new(eta: f64, (side, lobe): (Side, Lobe), form: Form, cos: f64) -> Self {
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (z, near, far) = match side {
            Side::Air => (cos, 1.0, eta),
            Side::Dielectric => (-cos, eta, 1.0),
        };
        let n_o = if lobe == Lobe::Reflection { near } else { far };
        let wi = Direction::from_unit(-sin, 0.0, z);
        Self { wi, lobe, form, n_i: near, n_o, beyond: far / near }
    }

    /// The facet of slope `s` and azimuth's cosine `p`; `None` if it sends nothing into the lobe.
    pub(super) fn turn(&self, s: f64, p: f64) -> Option<Turned> {
        if self.form == Form::Direct {
            return self.moved(s, p);
        }
        let cos = 1.0 / (1.0 + s * s).sqrt();
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
        fine.then_some(Turned { wo, cos_m, jacobian, share: cos_m * jacobian * fresnel })
    }

    /// The same of [`Form::Direct`], where `s` is the length of `h_xy`.
    fn moved(&self, s: f64, p: f64) -> Option<Turned> {
        let (n_i, n_o, sign) = match self.lobe {
            Lobe::Reflection => (1.0, 1.0, 1.0),
            Lobe::Transmission => (self.n_i, self.n_o, -1.0),
        };
        let [x, _, z] = self.wi.xyz();
        let (ox, oy) =
            ((sign * s * p - n_i * x) / n_o, sign * s * (1.0 - p * p).max(0.0).sqrt() / n_o);
        let up = 1.0 - (ox * ox + oy * oy);
        if up <= 0.0 {
            return None;
        }
        let up = if (z > 0.0) == (self.lobe == Lobe::Reflection) { up.sqrt() } else { -up.sqrt() };
        let hh = 1.0 + s * s;
        let jacobian = n_o * n_o * up.abs() / (hh * hh.sqrt());
        let wo = Direction::from_unit(ox, oy, up);
        (jacobian > 0.0).then_some(Turned { wo, cos_m: 1.0, jacobian, share: 0.25 })
    }

    /// `ars` of one `Q`.
    pub(super) fn per(&self, t: &Turned, masking: f64) -> f64 {
        let sum = |w: Direction<f64>| {
            let cos2 = w.z() * w.z();
            w.z().abs() + (cos2 + masking * masking * (1.0 - cos2).max(0.0)).sqrt()
        };
        match self.form {
            Form::Drawn => t.share / t.cos_m,
            Form::Masked | Form::Direct => {
                t.share * 4.0 * t.wo.z().abs() / (sum(self.wi) * sum(t.wo))
            }
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

/// Slope and azimuth's cosine of the facet between two directions, or what stands for them in a form; `towards` is the azimuth of the mirror direction,
/// which at normal incidence `wi` does not tell.
pub(super) fn between(
    (eta, form): (f64, Form),
    towards: [f64; 2],
    wi: Direction<f64>,
    wo: Direction<f64>,
) -> Option<(f64, f64)> {
    let ([ix, iy, iz], [ox, oy, oz]) = (wi.xyz(), wo.xyz());
    let index = |z: f64| if z > 0.0 { 1.0 } else { eta };
    let mirrored = (iz > 0.0) == (oz > 0.0);
    let (n_i, n_o) = if mirrored { (1.0, 1.0) } else { (index(iz), index(oz)) };
    let mut h = [n_i * ix + n_o * ox, n_i * iy + n_o * oy, n_i * iz + n_o * oz];
    if form == Form::Direct {
        h[2] = if mirrored { 1.0 } else { -1.0 };
    }
    let across = h[0].hypot(h[1]);
    let along = (towards[0] * h[0] + towards[1] * h[1]) * 1.0_f64.copysign(h[2]);
    let p = if across > 0.0 { (along / across).clamp(-1.0, 1.0) } else { 1.0 };
    let s = across / h[2].abs();
    s.is_finite().then_some((s, p))
}
