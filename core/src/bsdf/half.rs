//! One facet between two directions: its normal, its Fresnel factor, its Jacobian.
//!
//! With `h = n_i wi + n_o wo` one expression serves reflection (`n_i = n_o`, the half vector of
//! \[Walter2007, eq. 13\]) and transmission (its eq. 16), and it is the same to the last bit from both
//! ends of a path, which is what keeps the law reciprocal where `h` is a small difference.
//!
//! **What the cosines at the facet are.** Directions are unit vectors, so all cosines follow from `|h|^2` alone,
//! and are defined so in every precision, whatever the rounding of the components:
//! reflection, `|wi.m| = |h| / 2`; transmission, with `h = a + n b` (a in the air, b in the dielectric) and
//! `s = n^2 - 1`, `2 a.h = |h|^2 - s`, `2 n b.h = |h|^2 + s`. No root is spent on normalising, and
//! Fresnel's factors become symmetric in the two ends.
//!
//! **What single precision loses, and how it is kept.** Two differences are ill-conditioned, each once:
//! - `h = a + n b`: the rounding of `n b` is magnified by `1 / |h_xy|`, a thousandfold in a lobe of alpha 1e-3. What the
//!   rounding took from the product is added again: each component is right to two units of its own last digit.
//! - `|h|^2 - K`, with `K = s` where a facet is seen at grazing incidence and `K = 4 (1 - e^2)` at the critical angle, where
//!   the root `g` of the difference makes a unit of rounding 3e-4 of the reflectance. Near zero the difference is summed
//!   from two parts of every term (`difference`), and is then right to 1e-13.
//!
//! Nothing here branches: both cases share their quotients, whose terms are selected. A loop over pairs
//! then becomes vector instructions, and a pair on unforeseeable sides costs no chain of mispredictions.

use crate::direction::Direction;
use crate::math::Real;
use crate::quantity::RelativeIor;

/// The facet of normal `m = +-h / |h|`, `m_z > 0`, that turns `wi` into `wo`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfVector<T> {
    /// Whether there is one: no direction in the surface, no facet turned away, no matched media, no NaN.
    /// If not, the other fields mean nothing, and may be infinite or NaN.
    pub(crate) possible: bool,
    /// `h_x^2 + h_y^2`.
    pub(crate) xy2: T,
    /// `h_z^2`.
    pub(crate) z2: T,
    /// `|wi . h|`.
    pub(crate) ih: T,
    /// `wi_x m_x + wi_y m_y` times `|h|`, for `wi` seen from its side of the facet: negative where the facet is turned
    /// towards the mirror direction.
    pub(crate) along: T,
    /// `|wi . m| J`, dimensionless: `share` without Fresnel's factor.
    pub(crate) turn: T,
    /// `|wi . m| * J * (F or 1 - F)`, dimensionless, where `J = d omega_m / d omega_o`:
    /// `F / 4` in reflection \[Walter2007, eq. 14\], eq. 17 times `|wi . m| (1 - F)` in transmission.
    pub(crate) share: T,
}

impl<T: Real> HalfVector<T> {
    /// The facet between two directions, on any sides.
    #[inline(always)]
    pub(crate) fn between(eta: RelativeIor<T>, wi: Direction<T>, wo: Direction<T>) -> Self {
        let [ix, iy, iz] = wi.xyz();
        let [ox, oy, oz] = wo.xyz();
        let (below, n) = (iz < T::ZERO, eta.get());
        let mirrored = T::ONE.copysign(iz) * oz > T::ZERO;
        // From the air's direction to the dielectric's, whichever comes first: h = a + n b. In reflection
        // the common index is left out.
        let swap = |i: T, o: T| if below { (o, i) } else { (i, o) };
        let term = |i: T, o: T| {
            let (a, b) = swap(i, o);
            choose(mirrored, || Sum::of(a, b, T::ZERO), || Sum::of_product(a, n, b))
        };
        let (x, y, z) = (term(ix, ox), term(iy, oy), term(iz, oz));
        let (hx, hy, hz) = (x.value, y.value, z.value);
        let (xy2, z2) = (hx * hx + hy * hy, hz * hz);
        let hh = xy2 + z2;

        // |h|^2 - K, what is small where a facet is seen at grazing incidence (transmission), and four times
        // g^2 = e^2 - 1 + cos^2 (reflection)
        let [step, step_low] = eta.step(below & mirrored);
        let scale = choose(mirrored, || T::from_f64(-4.0), || T::ONE.copysign(step));
        let (limit, limit_low) = (scale * step, scale * step_low);
        let rough = hh - limit;
        let near = T::IN_TWO & (rough.abs() * T::from_f64(32.0) < hh);
        let excess = choose(near, || difference([x, y, z], [limit, limit_low]), || rough);

        // Reflection, from c^2 and g^2. Total reflection is no case of its own: with g = 0 neither rs nor rp is below 1.
        let c2 = T::from_f64(0.25) * hh;
        let reflected = || {
            let g2 = T::from_f64(0.25) * excess.max(T::ZERO);
            let cg = (c2 * g2).sqrt();
            // rs = step / (c + g)^2, rp = rs u / v
            let (u, v) = (cg + c2 - T::ONE, cg - c2 + T::ONE);
            let rs_v = step / ((c2 + g2 + (cg + cg)) * v);
            (T::HALF * (rs_v * rs_v) * (u * u + v * v)).min(T::ONE)
        };

        // Transmission, from c = |a.h| and g = n |b.h|, of which one is the small difference; c + g = |s|.
        let small = T::HALF * -excess;
        let large = T::HALF * (hh + limit);
        let (c, g) = if step > T::ZERO { (small, large) } else { (large, small) };
        let part = small * large / hh;
        let transmitted = || {
            let p = n * n * c + g;
            let both = T::ONE / (step * step) + n * n / (p * p);
            T::TWO * (small * large) * both
        };
        // seen from the front by both: (w.m)(w.n) > 0
        let seen = || small.min(-scale * hz);

        // All of these are positive if there is a facet; the last term makes NaN of any NaN.
        let least = choose(mirrored, || hh, seen).min(iz.abs()).min(oz.abs()) + T::ZERO * hh;
        let turn = choose(mirrored, || T::from_f64(0.25), || n * part / hh);
        Self {
            possible: (least > T::ZERO) & !eta.is_matched(),
            xy2,
            z2,
            ih: choose(mirrored, || T::HALF * hh, || if below { g * eta.inverse() } else { c }),
            along: (ix * hx + iy * hy) * T::ONE.copysign(hz),
            turn,
            share: choose(mirrored, reflected, transmitted) * turn,
        }
    }
}

/// A component of `h`: a sum, and what its rounding took (0 in double precision).
#[derive(Clone, Copy)]
struct Sum<T> {
    value: T,
    rest: T,
}

impl<T: Real> Sum<T> {
    /// `a + b + tail`, where the tail is small beside `b`.
    #[inline(always)]
    fn of(a: T, b: T, tail: T) -> Self {
        let sum = a + b;
        let tail = a.sum_error(b, sum) + tail;
        Self { value: sum, rest: tail }
    }

    /// `a + n b`. Where the two cancel their sum is exact \[Sterbenz\] and only the product was rounded.
    #[inline(always)]
    fn of_product(a: T, n: T, b: T) -> Self {
        let product = n * b;
        if !T::IN_TWO {
            return Self { value: a + product, rest: T::ZERO };
        }
        let sum = a + product;
        let lost = n.product_error(b, product);
        let value = sum + lost;
        let rest = (sum - value) + (a.sum_error(product, sum) + lost);
        Self { value, rest }
    }
}

/// `|h|^2 - limit` where the two nearly cancel: squares, sums and the limit in two parts each.
#[inline(always)]
fn difference<T: Real>(h: [Sum<T>; 3], [limit, limit_low]: [T; 2]) -> T {
    let [x, y, z] = h;
    let square = |s: Sum<T>| {
        let square = s.value * s.value;
        (square, s.value.product_error(s.value, square) + s.value * (s.rest + s.rest))
    };
    let ((x2, x_low), (y2, y_low), (z2, z_low)) = (square(x), square(y), square(z));
    let xy2 = x2 + y2;
    let hh = xy2 + z2;
    let low = (x_low + y_low) + z_low + (x2.sum_error(y2, xy2) + xy2.sum_error(z2, hh));
    (hh - limit) + (low - limit_low)
}

/// One of two values. Where loops become vector instructions both are computed, and neither costs a branch
/// that random directions mispredict; on a microcontroller only the one that is wanted is. The bits are
/// the same.
#[inline(always)]
fn choose<T>(condition: bool, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
    if cfg!(target_arch = "arm") {
        if condition { yes() } else { no() }
    } else {
        let (yes, no) = (yes(), no());
        if condition { yes } else { no }
    }
}
