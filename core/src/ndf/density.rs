//! What a microfacet law has to know of a density of normals, and its visible normals.
//!
//! `D(m)` is the area of facets per mean area and solid angle, 1/sr, with `integral of D (m.n) = 1`. Everything about
//! masking follows from one function of the cotangent `mu` of the polar angle of a direction: the mean excess
//! `L(mu) = E[(p - mu)+]` of the slope `p` along the direction. `Lambda = L / mu`, `G1 = 1 / (1 + Lambda)`, and the
//! projected area of the facets that face the direction is `|cos| + sin L` \[Smith 1967; Heitz 2014\].
//!
//! A density is the same for all azimuths, or it is one whose slopes are stretched (`super::stretched`): `excess`, `steeper`,
//! `slope_above` and `tail` are then of the slopes before, and [`Density::unstretched`] says how these see a direction.

use core::f64::consts::{FRAC_1_PI, PI};
use core::marker::PhantomData;

use crate::direction::Direction;
use crate::math::Real;
use crate::quadrature::EIGHT_POINTS;

/// A density of microfacet normals, the same for all azimuths but for a stretch of its slopes.
pub trait Density<T: Real>: Copy {
    /// The same density in another precision.
    type In<U: Real>: Density<U>;

    /// `D` in 1/sr of a vector of any length, from `x^2 + y^2` and `z^2`; `in_two` gives both with their rounding errors.
    fn d(&self, xy2: T, z2: T, in_two: impl FnOnce() -> [[T; 2]; 2]) -> T;

    /// `D` of a vector where a density with a direction of its own has to know it: from the squares of [`Self::d`], or from the
    /// vector, each component with its rounding error.
    #[inline(always)]
    fn d_of(
        &self,
        [xy2, z2]: [T; 2],
        in_two: impl FnOnce() -> [[T; 2]; 2],
        _vector: impl FnOnce() -> [[T; 2]; 3],
    ) -> T {
        self.d(xy2, z2, in_two)
    }

    /// Whether it depends on the azimuth.
    fn is_anisotropic(&self) -> bool {
        false
    }

    /// A direction as the slopes see it before they are stretched, of any length: `z` is kept, and `x` and `y` are stretched
    /// as the slopes are.
    #[inline(always)]
    fn unstretched(&self, w: [f64; 3]) -> [f64; 3] {
        w
    }

    /// The unit normal of a facet that has this one before its slopes are stretched.
    #[inline(always)]
    fn stretched(&self, m: [f64; 3]) -> [f64; 3] {
        m
    }

    /// `E[(p - mu)+]`, the mean excess of the slope along a direction over its cotangent `mu`, from 0 to infinity.
    fn excess(&self, mu: f64) -> f64;

    /// The share of the mean area below facets of a polar tangent above `slope`: 1 at 0.
    fn steeper(&self, slope: f64) -> f64;

    /// Its inverse: the polar tangent above which a share from 0 to 1 lies.
    fn slope_above(&self, share: f64) -> f64;

    /// Typical slope of the facets: a length scale for quadrature.
    fn slope(&self) -> T;

    /// The power `k` that makes the slope above a share `y^k`, times `y^(k - 1)`, bounded: at least 2.
    fn tail(&self) -> f64 {
        2.0
    }

    /// The same density in another precision, each parameter rounded once.
    fn cast<U: Real>(&self) -> Self::In<U>;

    /// Projected area of the facets that face a direction, over the mean area: `|cos| / G1`, at least `|cos|`.
    #[inline]
    fn visible_area(&self, w: Direction<T>) -> T {
        let [x, y, z] = self.unstretched(w.xyz().map(Real::to_f64));
        let (sin, cos) = (Real::sqrt(x * x + y * y), Real::abs(z));
        if sin > 0.0 { T::from_f64(cos + sin * self.excess(cos / sin)) } else { w.z().abs() }
    }

    /// Smith's `Lambda` of a direction on either side; infinite in the surface.
    fn lambda(&self, w: Direction<T>) -> T {
        let [x, y, z] = self.unstretched(w.xyz().map(Real::to_f64));
        let (sin, cos) = (Real::sqrt(x * x + y * y), Real::abs(z));
        if sin > 0.0 { T::from_f64(self.excess(cos / sin) * (sin / cos)) } else { T::ZERO }
    }

    /// Smith's masking of one direction, `G1`, 0 to 1.
    fn g1(&self, w: Direction<T>) -> T {
        let area = self.visible_area(w);
        if area > T::ZERO { w.z().abs() / area } else { T::ZERO }
    }

    /// Draws a facet normal visible from `w`, on the air side, from two uniforms in [0, 1); density
    /// `G1 |w.m| D / |cos|`. Continuous in both; the normal has z > 0.
    fn sample_visible(&self, w: Direction<T>, u: [T; 2]) -> Direction<T> {
        let [x, y, z] = self.unstretched(w.xyz().map(Real::to_f64));
        let [u0, u1] = u.map(Real::to_f64);
        let across = Real::sqrt(x * x + y * y);
        let (s, c, slope);
        if across > 0.0 {
            let mu = Real::abs(z) / across;
            slope = visible_slope(self, mu, 1.0 - u1);
            let (sin, cos) = Real::sin_cos(visible_azimuth(slope, mu, u0));
            (s, c) = ((y * cos + x * sin) / across, (x * cos - y * sin) / across);
        } else {
            slope = self.slope_above(1.0 - u1);
            (s, c) = Real::sin_cos(2.0 * PI * u0);
        }
        let slope = Real::min(slope, STEEPEST);
        let cos = 1.0 / Real::sqrt(1.0 + slope * slope);
        let sin = slope * cos;
        let [x, y, z] = self.stretched([c * sin, s * sin, cos]).map(T::from_f64);
        Direction::from_unit(x, y, z.max(T::MIN_POSITIVE))
    }

    /// The same from either side: a `w` with z < 0 looks up at the facets that are steeper than it.
    ///
    /// Their projected area is `sin L`, `|cos|` less than that from the opposite direction.
    fn sample_facing(&self, w: Direction<T>, u: [T; 2]) -> Direction<T> {
        if w.z() < T::ZERO { facing_from_below(self, w, u) } else { self.sample_visible(w, u) }
    }
}

/// A facet normal that faces a direction with z < 0.
fn facing_from_below<T: Real, D: Density<T>>(
    density: &D,
    w: Direction<T>,
    u: [T; 2],
) -> Direction<T> {
    let [x, y, z] = density.unstretched(w.xyz().map(Real::to_f64));
    let [u0, u1] = u.map(Real::to_f64);
    let across = Real::max(Real::sqrt(x * x + y * y), f64::MIN_POSITIVE);
    let mu = z / across;
    let slope = Real::min(steep_slope(density, mu, density.steeper(-mu), 1.0 - u1), STEEPEST);
    let (s, c) = Real::sin_cos(visible_azimuth(slope, mu, u0));
    let cos = 1.0 / Real::sqrt(1.0 + slope * slope);
    let sin = slope * cos / across;
    let m = density.stretched([(x * c - y * s) * sin, (y * c + x * s) * sin, cos]);
    let [x, y, z] = m.map(T::from_f64);
    Direction::from_unit(x, y, z.max(T::MIN_POSITIVE))
}

/// A slope beyond which facets are upright.
const STEEPEST: f64 = 1e150;
/// Panels of the integral over facets steeper than the direction.
const PANELS: usize = 6;

/// The polar tangent of a visible facet from the share `v` of the visible area that is steeper.
///
/// Facets less steep than the direction are all visible, and at one tangent their mean visible area is their projected
/// one: `mu dU`, in terms of their share `U`. Of those at a tangent `s > mu` it is `mu g dU`,
/// `g(s / mu) = (phi0 + sqrt((s / mu)^2 - 1)) / pi` with `cos phi0 = -mu / s`, which is integrated over `1 - U = y^k`.
fn visible_slope<T: Real, D: Density<T>>(density: &D, mu: f64, v: f64) -> f64 {
    let steeper = density.steeper(mu);
    let excess = density.excess(mu);
    let wanted = v * (mu + excess);
    let share = (wanted - excess) / mu;
    if share >= steeper || steeper <= 0.0 {
        return density.slope_above(Real::min(Real::max(share, 0.0), 1.0));
    }
    steep_slope(density, mu, steeper, wanted / (excess + mu * steeper))
}

/// The polar tangent, at least `|mu|`, of a visible facet from the share `v` of the visible area of such facets that is
/// steeper. `steeper` is their share of the mean area; `mu` is negative from below.
fn steep_slope<T: Real, D: Density<T>>(density: &D, mu: f64, steeper: f64, v: f64) -> f64 {
    let steep = Steep {
        density,
        mu,
        power: density.tail(),
        start: Real::pow(steeper, 1.0 / density.tail()),
        of: PhantomData,
    };
    let mut sums = [0.0; PANELS];
    let mut total = 0.0;
    for (p, sum) in sums.iter_mut().enumerate() {
        *sum = steep.integral([p, p + 1].map(|k| k as f64 / PANELS as f64));
        total += *sum;
    }
    let mut left = v * total;
    let mut panel = 0.0;
    for sum in sums.iter().take(PANELS - 1) {
        if left < *sum {
            break;
        }
        left -= *sum;
        panel += 1.0;
    }
    let start = panel / PANELS as f64;
    let (mut low, mut high) = (start, start + 1.0 / PANELS as f64);
    let mut x = 0.5 * (low + high);
    for _ in 0..40 {
        let error = steep.integral([start, x]) - left;
        if error > 0.0 {
            high = x;
        } else {
            low = x;
        }
        if Real::abs(error) <= 1e-13 * total {
            break;
        }
        let newton = x - error / steep.density(x);
        x = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    steep.facet(x)[0]
}

/// The facets steeper than a direction of cotangent `mu`, negative from below, along `x` from the steepest at 0 to those just as steep at 1.
struct Steep<'a, T, D> {
    density: &'a D,
    mu: f64,
    power: f64,
    /// `y` of the facets just as steep.
    start: f64,
    of: PhantomData<T>,
}

impl<T: Real, D: Density<T>> Steep<'_, T, D> {
    /// The tangent at `x`, and the share of the area per `x`. A smoothstep removes the roots at both ends.
    fn facet(&self, x: f64) -> [f64; 2] {
        let y = self.start * x * x * (3.0 - 2.0 * x);
        let share = Real::pow(y, self.power);
        let slope = Real::min(Real::max(self.density.slope_above(share), self.mu.abs()), STEEPEST);
        let per = if y > 0.0 { self.power * share / y } else { 0.0 };
        [slope, per * self.start * 6.0 * x * (1.0 - x)]
    }

    /// Their visible area per `x`, times the tangent of the direction's elevation.
    fn density(&self, x: f64) -> f64 {
        let [s, per] = self.facet(x);
        let root = Real::sqrt((s - self.mu) * (s + self.mu));
        let area = self.mu * last_azimuth(s, self.mu) + root;
        per * FRAC_1_PI * if self.mu < 0.0 { Real::max(area, 0.0) } else { area }
    }

    fn integral(&self, [a, b]: [f64; 2]) -> f64 {
        let sum: f64 = EIGHT_POINTS.iter().map(|&(x, w)| w * self.density(a + x * (b - a))).sum();
        sum * (b - a)
    }
}

/// The largest azimuth at which a facet of polar tangent `slope` faces a direction of cotangent `mu`.
fn last_azimuth(slope: f64, mu: f64) -> f64 {
    if slope > mu.abs() {
        PI - Real::acos(mu / slope)
    } else if mu >= 0.0 {
        PI
    } else {
        0.0
    }
}

/// The azimuth of a visible facet from that of the direction, with density `(mu + slope cos)+`: Kepler's equation, whose
/// left side is concave, so that Newton's steps from below stay below.
fn visible_azimuth(slope: f64, mu: f64, u: f64) -> f64 {
    let slope = Real::min(slope, STEEPEST);
    let (b, a) = (mu / (mu.abs() + slope), slope / (mu.abs() + slope));
    let end = last_azimuth(slope, mu);
    let side = 2.0 * u - 1.0;
    let area = |phi: f64| b * phi + a * Real::sin_cos(phi).0;
    let (wanted, full) = (side.abs() * area(end), area(end));
    let (mut low, mut high) = (0.0, end);
    let mut phi = Real::min(wanted, end);
    for _ in 0..60 {
        let (sin, cos) = Real::sin_cos(phi);
        let error = b * phi + a * sin - wanted;
        if error > 0.0 {
            high = phi;
        } else {
            low = phi;
        }
        if Real::abs(error) <= 1e-14 * full {
            break;
        }
        let newton = phi - error / (b + a * cos);
        phi = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    if side < 0.0 { -phi } else { phi }
}
