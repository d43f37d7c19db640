//! Slow, independent twins: the textbook formulas spelled out, and integrals by brute force.

use std::f64::consts::{PI, TAU};
use std::ops::{Add, Div, Mul, Sub};

/// A vector.
pub type Vec3 = [f64; 3];

/// Scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a x + b y`.
pub fn combine(a: f64, x: Vec3, b: f64, y: Vec3) -> Vec3 {
    [a * x[0] + b * y[0], a * x[1] + b * y[1], a * x[2] + b * y[2]]
}

/// A vector at unit length.
pub fn unit(v: Vec3) -> Vec3 {
    let length = v[0].hypot(v[1]).hypot(v[2]);
    v.map(|x| x / length)
}

/// The vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// From polar angle and azimuth.
pub fn spherical(theta: f64, phi: f64) -> Vec3 {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

#[derive(Clone, Copy, Debug)]
struct Complex(f64, f64);

impl Complex {
    fn norm2(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
}
impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for Complex {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
}
impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
}
impl Div for Complex {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let n = self * Self(o.0, -o.1);
        Self(n.0 / o.norm2(), n.1 / o.norm2())
    }
}

/// Reflectances and transmittances of the two polarisations.
#[derive(Clone, Copy, Debug)]
pub struct Polarised {
    /// `|r_s|^2`, `|r_p|^2`.
    pub reflected: [f64; 2],
    /// Flux transmitted, s and p.
    pub transmitted: [f64; 2],
}

impl Polarised {
    /// Mean of the reflectances.
    pub fn unpolarised(&self) -> f64 {
        0.5 * (self.reflected[0] + self.reflected[1])
    }
    /// Mean of the transmittances.
    pub fn through(&self) -> f64 {
        0.5 * (self.transmitted[0] + self.transmitted[1])
    }
}

/// Fresnel by complex amplitudes; `n` is the far index over the near one, `theta` the incidence.
pub fn fresnel(cos_i: f64, n: f64) -> Polarised {
    let (c, n1) = (Complex(cos_i, 0.0), Complex(n, 0.0));
    let square = 1.0 - (1.0 - cos_i) * (1.0 + cos_i) / (n * n);
    // Evanescent beyond the critical angle: an imaginary cosine.
    let t =
        if square >= 0.0 { Complex(square.sqrt(), 0.0) } else { Complex(0.0, (-square).sqrt()) };
    let two_c = Complex(2.0 * cos_i, 0.0);
    let rs = (c - n1 * t) / (c + n1 * t);
    let rp = (n1 * c - t) / (n1 * c + t);
    let ts = two_c / (c + n1 * t);
    let tp = two_c / (n1 * c + t);
    let flux = n * t.0 / cos_i;
    Polarised {
        reflected: [rs.norm2(), rp.norm2()],
        transmitted: [flux * ts.norm2(), flux * tp.norm2()],
    }
}

/// GGX of Walter et al. 2007 by angles, for a boundary of index `n` below and 1 above.
#[derive(Clone, Copy, Debug)]
pub struct TextbookGgx {
    /// Width.
    pub alpha: f64,
    /// Index below over index above.
    pub n: f64,
}

impl TextbookGgx {
    /// Equation 33, from the polar angle of the facet.
    pub fn d(&self, m: Vec3) -> f64 {
        if m[2] <= 0.0 {
            return 0.0;
        }
        let theta = m[0].hypot(m[1]).atan2(m[2]);
        let a2 = self.alpha.powi(2);
        a2 / (PI * theta.cos().powi(4) * (a2 + theta.tan().powi(2)).powi(2))
    }

    /// Equation 34; `v` and the normal on the side of light.
    pub fn g1(&self, v: Vec3, m: Vec3) -> f64 {
        if dot(v, m) * v[2] <= 0.0 {
            return 0.0;
        }
        let tan = v[0].hypot(v[1]) / v[2];
        2.0 / (1.0 + (1.0 + (self.alpha * tan).powi(2)).sqrt())
    }

    /// The BSDF, equations 20 and 21.
    pub fn f(&self, wi: Vec3, wo: Vec3) -> f64 {
        let (eta_i, eta_o) = match (wi[2] > 0.0, wo[2] > 0.0) {
            (true, true) => (1.0, 1.0),
            (false, false) => (self.n, self.n),
            (true, false) => (1.0, self.n),
            (false, true) => (self.n, 1.0),
        };
        let cosines = (wi[2] * wo[2]).abs();
        if wi[2] * wo[2] > 0.0 {
            let h = unit(combine(1.0, wi, 1.0, wo));
            let m = if h[2] > 0.0 { h } else { h.map(|x| -x) };
            let far = if wi[2] > 0.0 { self.n } else { 1.0 / self.n };
            let f = fresnel(dot(wi, m).abs(), far).unpolarised();
            f * self.g1(wi, m) * self.g1(wo, m) * self.d(m) / (4.0 * cosines)
        } else {
            let h = unit(combine(-eta_i, wi, -eta_o, wo));
            let m = if h[2] > 0.0 { h } else { h.map(|x| -x) };
            let (im, om) = (dot(wi, m), dot(wo, m));
            if im * om >= 0.0 {
                return 0.0;
            }
            let through = fresnel(im.abs(), eta_o / eta_i).through();
            let denominator = (eta_i * im + eta_o * om).powi(2);
            (im * om).abs() / cosines
                * eta_o.powi(2)
                * through
                * self.g1(wi, m)
                * self.g1(wo, m)
                * self.d(m)
                / denominator
        }
    }
}

/// Nodes and weights of the `n`-point Gauss-Legendre rule on [0, 1].
pub fn gauss(n: u32) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut p0, mut p1) = (1.0, x);
        for k in 2..=n {
            let k = f64::from(k);
            (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
        }
        (p1, f64::from(n) * (x * p1 - p0) / (x * x - 1.0))
    };
    (0..n)
        .map(|k| {
            let mut x = -(PI * (f64::from(k) + 0.75) / (f64::from(n) + 0.5)).cos();
            for _ in 0..20 {
                let (p, d) = legendre(x);
                x -= p / d;
            }
            let d = legendre(x).1;
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * d * d))
        })
        .collect()
}

/// Integral of `f` over all directions, on rings about `axis` that are dense within `width` of it.
///
/// `tan(psi / 2) = width t / (1 - t)`; `rings` panels of three Gauss points in `t`, `spokes` azimuths.
pub fn over_the_sphere(
    axis: Vec3,
    width: f64,
    [rings, spokes]: [u32; 2],
    mut f: impl FnMut(Vec3) -> f64,
) -> f64 {
    let other = if axis[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = unit(cross(other, axis));
    let y = cross(axis, x);
    let rule = gauss(3);
    let mut sum = 0.0;
    for ring in 0..rings {
        for &(node, weight) in &rule {
            let t = (f64::from(ring) + node) / f64::from(rings);
            let q = width * t / (1.0 - t);
            let psi = 2.0 * q.atan();
            let slope = 2.0 / (1.0 + q * q) * width / (1.0 - t).powi(2);
            let mut around = 0.0;
            for spoke in 0..spokes {
                let (s, c) = (TAU * (f64::from(spoke) + 0.5) / f64::from(spokes)).sin_cos();
                let across = combine(c, x, s, y);
                around += f(unit(combine(psi.cos(), axis, psi.sin(), across)));
            }
            sum += around * psi.sin() * slope * weight;
        }
    }
    sum * TAU / (f64::from(rings) * f64::from(spokes))
}

/// Mirror direction of a flat boundary, and Snell's direction or, beyond the critical angle, the
/// grazing one: where to look for the two lobes of a rough boundary of index `n` below.
pub fn lobes(wi: Vec3, n: f64) -> [Vec3; 2] {
    let far = if wi[2] > 0.0 { n } else { 1.0 / n };
    let sin = wi[0].hypot(wi[1]);
    let (ux, uy) = if sin > 0.0 { (wi[0] / sin, wi[1] / sin) } else { (1.0, 0.0) };
    let t = (sin / far).min(1.0);
    let cos = (1.0 - t * t).sqrt();
    [[-wi[0], -wi[1], wi[2]], [-ux * t, -uy * t, -wi[2].signum() * cos]]
}

/// Scattered fractions on the side of `wi` and on the other, by brute force over all directions.
pub fn fluxes(
    wi: Vec3,
    n: f64,
    width: f64,
    grid: [u32; 2],
    mut ars: impl FnMut(Vec3) -> f64,
) -> [f64; 2] {
    let [mirror, snell] = lobes(wi, n);
    let mut part =
        |axis, width, same: bool| {
            over_the_sphere(axis, width, grid, |w| {
                if (w[2] * wi[2] > 0.0) == same { ars(w) } else { 0.0 }
            })
        };
    [part(mirror, width, true), part(snell, width, false)]
}
