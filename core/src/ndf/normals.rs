//! Facet normals with a given angular law: normalisation, quantiles, visible share.
//!
//! The law `F(theta)` is the density per solid angle of the facet normal, theta in [0, pi/2]:
//! `p(m) = F(theta_m) / C`, `C = 2 pi * integral of F sin theta`. Everything is computed in double
//! precision when the density is made, and kept in fixed-size tables.

use core::f64::consts::{FRAC_PI_2, PI};

use super::edge::Edges;
use super::law::{Law, Profile};
use super::visible::VisibleShare;
use crate::direction::Direction;
use crate::math::Real;
use crate::quadrature::{hermite, monotone_slope};
use crate::sampling::inverse_smoothstep;

/// Share of the normals that is cut off at either end of the table of quantiles.
const NO_ACCOUNT: f64 = 1e-9;
/// The computation of a law from a half vector.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form<T> {
    /// The normal law about 0: `2^-(halvings t^2)`.
    Normal { halvings: T },
    /// Another power of `t`, by way of `t^2 / delta^2`.
    Power { narrowness: T },
    /// From the angle.
    Angle,
    /// From the angle to an edge, where the law needs more digits than an angle has.
    Edges(Edges<T>),
}

impl<T: Real> Form<T> {
    fn of(law: &Law<f64>) -> Self {
        let narrowness = 1.0 / (law.delta() * law.delta());
        let normal = law.profile() == Profile::Gauss && law.n().total_cmp(&2.0).is_eq();
        match Edges::of(law) {
            Some(edges) => Self::Edges(edges),
            None if law.centre() > 0.0 => Self::Angle,
            None if normal => {
                Self::Normal { halvings: T::from_f64(0.5 * narrowness * core::f64::consts::LOG2_E) }
            }
            None => Self::Power { narrowness: T::from_f64(narrowness) },
        }
    }
}

/// A normalised density of facet normals with an inverse-CDF table of `N` nodes.
///
/// Quantiles are kept for `t = 1 - cos theta`, in which the density is `F` itself and finite at the pole,
/// at nodes `x_k = k / (N - 1)` of the probability `u = 3 x^2 - 2 x^3`, dense at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalDensity<T, const N: usize> {
    law: Law<T>,
    form: Form<T>,
    /// `1 / C`, 1/sr.
    inverse_norm: T,
    twice_inverse_norm: T,
    /// `t` and `dt/dx` at the nodes.
    quantiles: [[T; 2]; N],
    visible: VisibleShare<T>,
}

impl<T: Real, const N: usize> NormalDensity<T, N> {
    /// Normalises a law whose variable is the polar angle of the normal, in radians.
    pub fn new(law: Law<T>) -> Self {
        const { assert!(N >= 4, "a table of quantiles needs four nodes at least") };
        let wide: Law<f64> = law.cast();
        let mut total = 0.0;
        each_panel(&wide, |a, b| total += panel_mass(&wide, a, b));
        let table = quantile_table::<N>(&wide, total);
        let slope = |x| tangent(table_value(&table, x));
        Self {
            law,
            form: Form::of(&wide),
            inverse_norm: T::from_f64(0.5 / (PI * total)),
            twice_inverse_norm: T::from_f64(1.0 / (PI * total)),
            quantiles: table.map(|row| row.map(T::from_f64)),
            visible: VisibleShare::new(slope),
        }
    }

    /// The density of the same law in another precision: that of its rounded parameters.
    pub fn cast<U: Real>(&self) -> NormalDensity<U, N> {
        NormalDensity::new(self.law.cast())
    }

    /// The law.
    pub fn law(&self) -> &Law<T> {
        &self.law
    }

    /// `p(m)` in 1/sr from the sine and cosine of the polar angle, or any common multiple of them.
    #[inline]
    pub fn density(&self, sin: T, cos: T) -> T {
        self.law.value(sin.atan2(cos)) * self.inverse_norm
    }

    /// `2 p(m)` of the direction of a half vector, from `h_x^2 + h_y^2` and `h_z^2`; where these are not enough, from
    /// the same with their rounding errors.
    #[inline]
    pub(crate) fn twice_of_squares(
        &self,
        xy2: T,
        z2: T,
        in_two: impl FnOnce() -> [[T; 2]; 2],
    ) -> T {
        let value = match &self.form {
            Form::Normal { halvings } => (T::angle_squared(xy2, z2) * *halvings).halved(),
            Form::Power { narrowness } => {
                let power = T::HALF * self.law.n();
                self.law.falls((T::angle_squared(xy2, z2) * *narrowness).pow(power))
            }
            Form::Angle => self.law.value(xy2.sqrt().atan2(z2.sqrt())),
            Form::Edges(edges) => edges.value(&self.law, in_two()),
        };
        value * self.twice_inverse_norm
    }

    /// Draws a normal with density `p(m)` from two uniforms in [0, 1).
    #[inline]
    pub fn sample(&self, u: [T; 2]) -> Direction<T> {
        let t = self.quantile(u[1]);
        let sin = (t * (T::TWO - t)).sqrt_positive();
        let (s, c) = (T::TWO * T::PI * u[0]).sin_cos();
        Direction::from_unit(sin * c, sin * s, (T::ONE - t).max(T::MIN_POSITIVE))
    }

    /// `1 - cos theta` below which a share `u` of the normals lies.
    fn quantile(&self, u: T) -> T {
        table_value(&self.quantiles, inverse_smoothstep(u))
    }

    /// The share of the normals that face a direction of given `|cos theta|` and `sin theta`: 1/2 to 1.
    #[inline]
    pub fn visible(&self, cos: T, sin: T) -> T {
        self.visible.of(cos.abs(), sin)
    }
}

/// Hermite interpolation of the quantile table at `x` in [0, 1].
#[inline]
fn table_value<T: Real, const N: usize>(table: &[[T; 2]; N], x: T) -> T {
    let cells = T::from_f64((N - 1) as f64);
    let position = x * cells;
    let k = position.to_index().min(N - 2);
    match (table.get(k), table.get(k + 1)) {
        (Some(&a), Some(&b)) => {
            let s = (position - T::from_f64(k as f64)).max(T::ZERO).min(T::ONE);
            hermite(s, T::ONE / cells, a, b).max(T::ZERO).min(T::ONE)
        }
        _ => T::ZERO,
    }
}

/// Calls `visit(a, b)` for panels that cover [0, pi/2] in order and are graded about the centre of the
/// law: geometric, and finer near one width away, where a large exponent makes an edge.
fn each_panel(law: &Law<f64>, mut visit: impl FnMut(f64, f64)) {
    let (centre, delta, n) = (law.centre(), law.delta(), law.n());
    let least = 1e-6 * delta;
    let fine = 1.0 + Real::min(0.25, 4.0 / n);
    let ratio = |y: f64| if y > 0.25 * delta && y < 8.0 * delta { fine } else { 1.5 };
    let mut y = centre;
    while y > least {
        let next = y / ratio(y);
        visit(centre - y, if next > least { centre - next } else { centre });
        y = next;
    }
    let most = FRAC_PI_2 - centre;
    let mut y = 0.0;
    while y < most {
        let next = if y > 0.0 { y * ratio(y) } else { least };
        let end = if next < most { next } else { most };
        visit(centre + y, centre + end);
        y = next;
    }
}

/// `integral of F sin theta` over [a, b] by eight points.
fn panel_mass(law: &Law<f64>, a: f64, b: f64) -> f64 {
    let sum: f64 = EIGHT_POINTS.iter().map(|&(x, w)| w * mass_density(law, a + x * (b - a))).sum();
    sum * (b - a)
}

fn mass_density(law: &Law<f64>, theta: f64) -> f64 {
    law.value(theta) * Real::sin_cos(theta).0
}

/// The eight-point Gauss-Legendre rule on [0, 1]: [`gauss_legendre`] computed once and for all.
const EIGHT_POINTS: [(f64, f64); 8] = [
    (0.01985507175123188, 0.05061426814518813),
    (0.101_666_761_293_186_64, 0.11119051722668724),
    (0.2372337950418355, 0.15685332293894363),
    (0.4082826787521751, 0.181341891689181),
    (0.591717321247825, 0.181341891689181),
    (0.7627662049581645, 0.15685332293894363),
    (0.8983332387068134, 0.11119051722668724),
    (0.9801449282487681, 0.05061426814518813),
];

/// Quantiles of `t = 1 - cos theta` and their slopes `dt/dx`.
fn quantile_table<const N: usize>(law: &Law<f64>, total: f64) -> [[f64; 2]; N] {
    let mut table = [[1.0, 0.0]; N];
    let node = |k: usize| k as f64 / (N - 1) as f64;
    // A tail of no account is cut off, or the outermost cell would spread over all angles beyond.
    let least = if law.centre() > 0.0 { NO_ACCOUNT } else { 0.0 };
    let (mut below, mut k) = (0.0, 0);
    each_panel(law, |a, b| {
        let mass = panel_mass(law, a, b) / total;
        while k < N {
            let x = node(k);
            let u = Real::min(Real::max(x * x * (3.0 - 2.0 * x), least), 1.0 - NO_ACCOUNT);
            let target = u - below;
            if target > mass {
                break;
            }
            let theta = invert_panel(law, total, (a, b), mass, target);
            let half = Real::sin_cos(0.5 * theta).0;
            if let Some(row) = table.get_mut(k) {
                // du/dt = F / total, du/dx = 6 x (1 - x)
                *row = [2.0 * half * half, 6.0 * x * (1.0 - x) * total / law.value(theta)];
            }
            k += 1;
        }
        below += mass;
    });
    limit_slopes(&mut table);
    table
}

/// The angle in the panel below which a share `target` of all normals lies, counted from its start.
fn invert_panel(law: &Law<f64>, total: f64, (a, b): (f64, f64), mass: f64, target: f64) -> f64 {
    let h = b - a;
    let (da, db) = (mass_density(law, a) / total, mass_density(law, b) / total);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let s = 0.5 * (low + high);
        if hermite(s, h, [0.0, da], [mass, db]) < target { low = s } else { high = s }
    }
    let mut theta = a + 0.5 * (low + high) * h;
    for _ in 0..2 {
        let density = mass_density(law, theta) / total;
        let step = (panel_mass(law, a, theta) / total - target) / density;
        if step.is_finite() {
            theta = Real::min(Real::max(theta - step, a), b);
        }
    }
    theta
}

/// Makes the table monotone between its nodes.
fn limit_slopes<const N: usize>(table: &mut [[f64; 2]; N]) {
    let cells = (N - 1) as f64;
    let values = table.map(|row| row[0]);
    for (k, row) in table.iter_mut().enumerate() {
        let here = row[0];
        let left = k.checked_sub(1).and_then(|j| values.get(j));
        let right = values.get(k + 1);
        let secant = |other: Option<&f64>| other.map(|v| (v - here).abs() * cells);
        let (l, r) = (secant(left), secant(right));
        row[1] = monotone_slope(row[1], l.or(r).unwrap_or(0.0), r.or(l).unwrap_or(0.0));
    }
}

/// The tangent of the angle of which `t = 1 - cos`.
fn tangent(t: f64) -> f64 {
    Real::sqrt(t * (2.0 - t)) / (1.0 - t)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{EIGHT_POINTS, NormalDensity};
    use crate::direction::Direction;
    use crate::ndf::law::{Law, Profile};
    use crate::quadrature::gauss_legendre;
    use std::format;

    fn density(profile: Profile, delta: f64, n: f64, centre: f64) -> NormalDensity<f64, 256> {
        NormalDensity::new(Law::new(profile, delta, n, centre).unwrap())
    }

    #[test]
    fn the_constant_rule_is_the_computed_one() {
        for (a, b) in EIGHT_POINTS.iter().zip(gauss_legendre::<8>()) {
            assert!((a.0 - b.0).abs() < 2e-16 && (a.1 - b.1).abs() < 2e-16, "{a:?} {b:?}");
        }
    }

    /// Mass below `theta` by brute force, one million midpoints in ln(theta).
    fn mass_below(d: &NormalDensity<f64, 256>, theta: f64) -> f64 {
        let (low, steps) = (1e-12_f64.ln(), 400_000);
        let h = (theta.ln() - low) / f64::from(steps);
        (0..steps)
            .map(|k| {
                let t = (low + (f64::from(k) + 0.5) * h).exp();
                d.density(t.sin(), t.cos()) * t.sin() * core::f64::consts::TAU * t * h
            })
            .sum()
    }

    #[test]
    fn normalisation_and_quantiles_agree_with_brute_force() {
        for (profile, delta, n, centre) in [
            (Profile::Gauss, 0.1, 2.0, 0.0),
            (Profile::Gauss, 0.3, 0.7, 0.0),
            (Profile::Gauss, 0.2, 64.0, 0.0),
            (Profile::Gauss, 1e-4, 2.0, 0.0),
            (Profile::Gauss, 0.05, 2.0, 0.4),
            (Profile::Cauchy, 0.1, 2.5, 0.0),
            (Profile::Cauchy, 1e-3, 0.5, 0.0),
            (Profile::Cauchy, 0.2, 64.0, 0.0),
            (Profile::Cauchy, 1.5, 3.0, 0.0),
        ] {
            let d = density(profile, delta, n, centre);
            let case = format!("{profile:?} {delta} {n} {centre}");
            assert!((mass_below(&d, core::f64::consts::FRAC_PI_2) - 1.0).abs() < 1e-5, "{case}");
            for u in [0.001, 0.01, 0.1, 0.37, 0.5, 0.8, 0.95, 0.99, 0.999] {
                let theta = (1.0 - d.quantile(u)).acos();
                let got = mass_below(&d, theta);
                assert!((got - u).abs() < 2e-4 * u.min(1.0 - u).max(0.05), "{case}: {u} {got}");
            }
        }
    }

    #[test]
    fn the_visible_share_agrees_with_counting() {
        for (profile, delta, n) in
            [(Profile::Gauss, 0.1, 2.0), (Profile::Cauchy, 0.3, 2.0), (Profile::Gauss, 1.5, 8.0)]
        {
            let d = density(profile, delta, n, 0.0);
            for theta in [0.0_f64, 0.5, 1.0, 1.3, 1.5, 1.56, 1.5706] {
                let w = Direction::from_angles(theta, 0.0);
                let (mut seen, steps) = (0_u32, 600);
                for i in 0..steps {
                    for j in 0..steps {
                        let u = [
                            (f64::from(j) + (f64::from(i) * 0.618_034).fract()) / f64::from(steps),
                            (f64::from(i) + 0.5) / f64::from(steps),
                        ];
                        seen += u32::from(d.sample(u).dot(w) > 0.0);
                    }
                }
                let counted = f64::from(seen) / f64::from(steps * steps);
                let got = d.visible(w.z(), w.x());
                assert!(
                    (got - counted).abs() < 5e-4,
                    "{profile:?} {delta} {theta}: {got} {counted}"
                );
            }
        }
    }
}
