//! One facet between two directions: its normal, its Fresnel factor, its Jacobian.
//!
//! With `h = n_i wi + n_o wo` one expression serves reflection (`n_i = n_o`, the half vector of
//! \[Walter2007, eq. 13\]) and transmission (its eq. 16), and it is the same to the last bit from both
//! ends of a path, which keeps the law reciprocal where `h` is a small difference.
//!
//! **The cosines at the facet.** Directions are unit vectors, so all cosines follow from `|h|^2` alone,
//! and this defines them in every precision, whatever the rounding of the components:
//! reflection, `|wi.m| = |h| / 2`; transmission, with `h = a + n b` (a in the air, b in the dielectric) and
//! `s = n^2 - 1`, `2 a.h = |h|^2 - s`, `2 n b.h = |h|^2 + s`. No root is spent on normalising, and
//! Fresnel's factors become symmetric in the two ends: with `P = (s^2 - |h|^4) / |h|^2` and `w` one over the cosine of the
//! deviation, `1 - F` times `|wi.m|` and the Jacobian is `e P^2 (1 + w^2) / (8 s^2)`, `e` the far index over the near one.
//!
//! **Single precision.** Two differences are ill-conditioned, each once:
//! - `h = a + n b`: the rounding of `n b` is magnified by `1 / |h_xy|`, a thousandfold in a lobe of alpha 1e-3. What the
//!   rounding took from the product is added again: each component is right to two units of its own last digit.
//! - `|h|^2 - K`, with `K = s` where a facet is seen at grazing incidence and `K = 4 (1 - e^2)` at the critical angle, where
//!   the root `g` of the difference makes a unit of rounding 3e-4 of the reflectance. Near zero the difference is summed
//!   from two parts of every term (`difference`), and is then right to 1e-13.
//!
//! Nothing here branches: both cases share their quotients, whose terms are selected. A loop over pairs
//! then becomes vector instructions, and a pair on unpredictable sides causes no mispredicted branches.

#![allow(clippy::needless_bitwise_bool, reason = "lazy operators would be branches")]

use crate::direction::Direction;
use crate::math::Real;
use crate::quantity::RelativeIor;
use crate::scope;

/// One of two values. Where loops become vector instructions both are computed, and neither costs a branch
/// that random directions mispredict; a microcontroller computes only the one it needs. The bits are the same.
///
/// A macro instead of a function of two closures: the compiler may leave a large closure out of line, and no loop
/// with a call in it becomes vector instructions.
macro_rules! choose {
    ($condition:expr, $yes:expr, $no:expr) => {
        if cfg!(target_arch = "arm") {
            if $condition { $yes } else { $no }
        } else {
            let (yes, no) = ($yes, $no);
            if $condition { yes } else { no }
        }
    };
}

/// A function of each of three, in line for the same reason.
macro_rules! each {
    ($three:expr, $function:ident($($other:expr),*)) => {{
        let [x, y, z] = $three;
        [$function(x, $($other),*), $function(y, $($other),*), $function(z, $($other),*)]
    }};
}

/// The facet of normal `m = +-h / |h|`, `m_z > 0`, that turns `wi` into `wo`.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(all(feature = "normals", feature = "table")),
    allow(dead_code, reason = "only together do they ask for all of it")
)]
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
    /// `2 |wi . h|`: half of it costs two instructions more.
    pub(crate) cosine: T,
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
    #[cfg(any(feature = "ggx", feature = "normals"))]
    pub(crate) fn between(eta: RelativeIor<T>, wi: Direction<T>, wo: Direction<T>) -> Self {
        Self::found::<true>(eta, wi, wo)
    }

    /// The same in one part: for a table, which is no closer to its law than single precision here.
    #[inline(always)]
    #[cfg(feature = "table")]
    pub(crate) fn roughly(eta: RelativeIor<T>, wi: Direction<T>, wo: Direction<T>) -> Self {
        Self::found::<false>(eta, wi, wo)
    }

    #[inline(always)]
    fn found<const TWO: bool>(eta: RelativeIor<T>, wi: Direction<T>, wo: Direction<T>) -> Self {
        let (iz, oz) = (wi.z(), wo.z());
        let mirrored = T::ONE.copysign(iz) * oz > T::ZERO;
        let answered = scope::lobe(mirrored) & scope::side(iz < T::ZERO);
        if !cfg!(target_arch = "arm") {
            let inclined = (iz != T::ZERO) & (oz != T::ZERO);
            let half = Self::of::<TWO>(eta, wi, wo, mirrored, iz < T::ZERO);
            return Self { possible: half.possible & inclined & answered, ..half };
        }
        // A microcontroller gets a copy for each way of the light, in which nothing is left to choose.
        match (iz > T::ZERO, oz > T::ZERO) {
            (true, true) if scope::AIR && scope::REFLECTION => {
                Self::of::<TWO>(eta, wi, wo, true, false)
            }
            (true, false) if scope::AIR && scope::TRANSMISSION && oz < T::ZERO => {
                Self::of::<TWO>(eta, wi, wo, false, false)
            }
            (false, true) if scope::DIELECTRIC && scope::TRANSMISSION && iz < T::ZERO => {
                Self::of::<TWO>(eta, wi, wo, false, true)
            }
            (false, false)
                if scope::DIELECTRIC && scope::REFLECTION && (iz < T::ZERO) & (oz < T::ZERO) =>
            {
                Self::of::<TWO>(eta, wi, wo, true, true)
            }
            _ => {
                let [xy2, z2, ih, cosine, along, turn, share] = [T::ZERO; 7];
                Self { possible: false, xy2, z2, ih, cosine, along, turn, share }
            }
        }
    }

    /// `h_x^2 + h_y^2` and `h_z^2`, each with what its rounding took, where the digits of a number are not enough.
    #[cfg(feature = "normals")]
    #[inline(never)]
    pub(crate) fn squares_in_two(
        eta: RelativeIor<T>,
        wi: Direction<T>,
        wo: Direction<T>,
    ) -> [[T; 2]; 2] {
        let ([ix, iy, iz], [ox, oy, oz]) = (wi.xyz(), wo.xyz());
        let swap = |i: T, o: T| if iz < T::ZERO { [o, i] } else { [i, o] };
        let mirrored = T::ONE.copysign(iz) * oz > T::ZERO;
        squares([swap(ix, ox), swap(iy, oy), swap(iz, oz)], eta.get(), mirrored)
    }

    /// `h` itself, each component with what its rounding took, for facets with a direction of their own.
    #[cfg(feature = "microfacet")]
    #[inline(never)]
    pub(crate) fn vector_in_two(
        eta: RelativeIor<T>,
        wi: Direction<T>,
        wo: Direction<T>,
    ) -> [[T; 2]; 3] {
        let ([ix, iy, iz], [ox, oy, oz]) = (wi.xyz(), wo.xyz());
        let swap = |i: T, o: T| if iz < T::ZERO { [o, i] } else { [i, o] };
        let mirrored = T::ONE.copysign(iz) * oz > T::ZERO;
        let pairs = [swap(ix, ox), swap(iy, oy), swap(iz, oz)];
        pairs.map(|pair| component_in_two(pair, eta.get(), mirrored))
    }

    /// The facet without the difference in two parts, and whether all its bits are those of [`Self::between`]: not
    /// where that difference is needed, nor where a direction is not `ordinary`. For loops over many pairs.
    ///
    /// `lost(a, b, product)` is `a * b - product`, exactly wherever that is a number.
    #[cfg(feature = "ggx")]
    #[inline(always)]
    pub(crate) fn plainly(
        eta: RelativeIor<T>,
        wi: Direction<T>,
        wo: Direction<T>,
        lost: impl Fn(T, T, T) -> T,
    ) -> (Self, bool) {
        let (iz, oz) = (wi.z(), wo.z());
        let mirrored = T::ONE.copysign(iz) * oz > T::ZERO;
        let answered = scope::lobe(mirrored) & scope::side(iz < T::ZERO);
        let (half, near) = Self::in_one_or_two::<false>(eta, wi, wo, mirrored, iz < T::ZERO, lost);
        (Self { possible: half.possible & answered, ..half }, !near & ordinary(wi) & ordinary(wo))
    }

    #[inline(always)]
    fn of<const TWO: bool>(
        eta: RelativeIor<T>,
        wi: Direction<T>,
        wo: Direction<T>,
        mirrored: bool,
        below: bool,
    ) -> Self {
        // nothing is lost: a zero whose sum with anything is that, to the bit
        let lost = |a: T, b: T, product| if TWO { a.product_error(b, product) } else { -T::ZERO };
        Self::in_one_or_two::<TWO>(eta, wi, wo, mirrored, below, lost).0
    }

    /// The facet, and whether `|h|^2` and its limit nearly cancel: their difference is then taken in `TWO` parts, or
    /// else the caller has to.
    #[inline(always)]
    fn in_one_or_two<const TWO: bool>(
        eta: RelativeIor<T>,
        wi: Direction<T>,
        wo: Direction<T>,
        mirrored: bool,
        below: bool,
        lost: impl Fn(T, T, T) -> T,
    ) -> (Self, bool) {
        let ([ix, iy, iz], [ox, oy, oz], n) = (wi.xyz(), wo.xyz(), eta.get());
        // From the air's direction to the dielectric's, whichever comes first: h = a + n b. In reflection
        // the common index is left out.
        let swap = |i: T, o: T| if below & !mirrored { [o, i] } else { [i, o] };
        let [xs, ys, zs] = [swap(ix, ox), swap(iy, oy), swap(iz, oz)];
        let [hx, hy, hz] = each!([xs, ys, zs], component(n, mirrored, &lost));
        let (xy2, z2) = (hx * hx + hy * hy, hz * hz);
        let hh = xy2 + z2;

        // |h|^2 - limit, what is small where a facet is seen at grazing incidence (transmission), and four times
        // g^2 = e^2 - 1 + cos^2 (reflection)
        let limits = eta.limit(mirrored, below);
        let limit = limits[0];
        let rough = hh - limit;
        let near = T::IN_TWO & (rough.abs() * T::from_f64(32.0) < hh);
        // no array, nor a closure: on a device either is stored by every call that may need it
        let excess = choose!(
            near & TWO,
            difference(xs[0], xs[1], ys[0], ys[1], zs[0], zs[1], n, mirrored, limits[0], limits[1]),
            rough
        );

        // Reflection, all cosines twice as large: c^2 = |h|^2, g^2 the excess, negative on total reflection.
        // rs = (c^2 - g^2) / (c + g)^2, rp = rs u / v
        let bounced = || {
            // negative on total reflection, where nobody asks; that it is not spares a device the library's root
            let squared = hh * excess;
            let cg = if cfg!(target_arch = "arm") { squared.abs() } else { squared }.sqrt();
            let (u, v) = (cg + (hh - T::from_f64(4.0)), cg - (hh - T::from_f64(4.0)));
            [u, v, (hh + excess + (cg + cg)) * v]
        };
        // Transmission, from 2 a.h and 2 n b.h, of which one is the small difference. Their sizes sum to 2 |s|, so
        // ts ~ 1 / |s|, and tp = ts / cos of the deviation, 2 n cos = n^2 + 1 - |h|^2.
        let (small, large) = (-excess, hh + limit);
        let [squares, through] = eta.transmission(below);

        // A quotient takes a loop longer than all that is chosen here: one for both, unless only one is computed.
        let [u, v, whole] = if cfg!(target_arch = "arm") { [T::ZERO; 3] } else { bounced() };
        let both = || choose!(mirrored, limit, small * large) / choose!(mirrored, whole, hh);
        let both = if cfg!(target_arch = "arm") { T::ZERO } else { both() };

        let partly = || {
            let [u, v, rs_v] = if cfg!(target_arch = "arm") {
                let [u, v, whole] = bounced();
                [u, v, limit / whole]
            } else {
                [u, v, both]
            };
            T::from_f64(0.125) * (rs_v * rs_v) * (u * u + v * v)
        };
        let quarter = T::from_f64(0.25);
        let reflected = || choose!(excess > T::ZERO, partly(), quarter);
        let part = if cfg!(target_arch = "arm") { small * large / hh } else { both };
        let transmitted = || {
            let w = (n + n) / (squares - hh);
            through.abs() * (part * part) * (T::ONE + w * w)
        };
        // seen from the front by both: (w.m)(w.n) > 0
        let seen = || (small > T::ZERO) & (hz * through < T::ZERO);
        let turned = || quarter * if below { eta.inverse() } else { n } * part / hh;
        let crossing = || {
            let c = if below == (through > T::ZERO) { large } else { small };
            if below { c * eta.inverse() } else { c }
        };

        // No comparison holds for a NaN, nor for the limits of matched media; what is infinite becomes one.
        let mirror = || hh + T::ZERO * excess > T::ZERO;
        let crossed = || seen() & (hh > T::ZERO);
        let cosine = choose!(mirrored, hh, crossing());
        let half = Self {
            possible: choose!(mirrored, mirror(), crossed()),
            xy2,
            z2,
            ih: T::HALF * cosine,
            cosine,
            along: (ix * hx + iy * hy) * T::ONE.copysign(hz),
            turn: choose!(mirrored, quarter, turned()),
            share: choose!(mirrored, reflected(), transmitted()),
        };
        (half, near)
    }
}

/// Whether no product with a component can overflow, nor what its rounding loses be too small for a number where
/// it matters: a height that is neither tiny nor huge, and nothing huge beside it. No NaN.
/// A tiny `x` or `y` does not matter: if the sum it belongs to is not tiny too, what is lost is far below half a
/// unit of it; if it is, its square is 0.
#[cfg(feature = "ggx")]
#[inline(always)]
fn ordinary<T: Real>(w: Direction<T>) -> bool {
    let ([x, y, z], small, large) = (w.xyz(), T::from_f64(1e-24), T::from_f64(1e24));
    (z.abs() > small) & (z.abs() < large) & (x * x + y * y < large)
}

/// `a + n b`, and what its rounding took. Where the two cancel their sum is exact \[Sterbenz\] and only the product was
/// rounded.
#[inline(always)]
fn sum_of_product<T: Real>(a: T, n: T, b: T, lost: impl Fn(T, T, T) -> T) -> (T, T) {
    let product = n * b;
    let sum = a + product;
    if !T::IN_TWO {
        return (sum, T::ZERO);
    }
    let lost = lost(n, b, product);
    let value = sum + lost;
    (value, (sum - value) + (a.sum_error(product, sum) + lost))
}

/// `a + b`, or `a + n b`.
#[inline(always)]
fn component<T: Real>([a, b]: [T; 2], n: T, mirrored: bool, lost: impl Fn(T, T, T) -> T) -> T {
    choose!(mirrored, a + b, sum_of_product(a, n, b, lost).0)
}

/// The same and what its rounding took.
#[inline(always)]
fn component_in_two<T: Real>([a, b]: [T; 2], n: T, mirrored: bool) -> [T; 2] {
    let (value, rest) = choose!(
        mirrored,
        (a + b, a.sum_error(b, a + b)),
        sum_of_product(a, n, b, T::product_error)
    );
    [value, rest]
}

/// The square of `a + b`, or of `a + n b`, and what its roundings took.
#[cfg_attr(target_arch = "arm", inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline(always))]
fn square<T: Real>(pair: [T; 2], n: T, mirrored: bool) -> [T; 2] {
    let [value, rest] = component_in_two(pair, n, mirrored);
    let square = value * value;
    [square, value.product_error(value, square) + value * (rest + rest)]
}

/// `h_x^2 + h_y^2` and `h_z^2` of `h = a + b`, or `a + n b`, of each pair, and what their roundings took.
#[inline(always)]
fn squares<T: Real>(pairs: [[T; 2]; 3], n: T, mirrored: bool) -> [[T; 2]; 2] {
    let [[x2, x_low], [y2, y_low], z] = each!(pairs, square(n, mirrored));
    let xy2 = x2 + y2;
    [[xy2, x2.sum_error(y2, xy2) + (x_low + y_low)], z]
}

/// `|h|^2 - limit` where the two nearly cancel: all in two parts each.
#[cfg_attr(target_arch = "arm", cold, inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline(always))]
#[allow(
    clippy::too_many_arguments,
    reason = "an array is put on the stack by every call that may need it"
)]
fn difference<T: Real>(
    ax: T,
    bx: T,
    ay: T,
    by: T,
    az: T,
    bz: T,
    n: T,
    mirrored: bool,
    limit: T,
    limit_low: T,
) -> T {
    let pairs = [[ax, bx], [ay, by], [az, bz]];
    let [[xy2, xy_low], [z2, z_low]] = squares(pairs, n, mirrored);
    let hh = xy2 + z2;
    (hh - limit) + (xy_low + z_low + xy2.sum_error(z2, hh) - limit_low)
}
