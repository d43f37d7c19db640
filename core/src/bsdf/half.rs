//! One facet between two directions: its normal, its Fresnel factor, its Jacobian.
//!
//! With `h = n_i wi + n_o wo` one expression serves reflection (`n_i = n_o`, the half vector of
//! \[Walter2007, eq. 13\]) and transmission (its eq. 16), and it is the same to the last bit from both
//! ends of a path, which is what keeps the law reciprocal where `h` is a small difference. The cosines
//! at the facet stay scaled by `|h|`, which the Fresnel formulas do not mind, so that no square root is
//! spent on normalising.
//!
//! Nothing here branches: both cases share their quotients, whose terms are selected. A loop over pairs
//! then becomes vector instructions, and a pair on unforeseeable sides costs no chain of mispredictions.

use crate::direction::Direction;
use crate::math::Real;
use crate::quantity::RelativeIor;
use crate::scope;

/// The facet of normal `m = +-h / |h|`, `m_z > 0`, that turns `wi` into `wo`.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "table"), allow(dead_code, reason = "tables ask for all of it"))]
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
        let sign_i = T::ONE.copysign(iz);
        let (mirrored, below) = (sign_i * oz > T::ZERO, iz < T::ZERO);
        let answered = scope::lobe(mirrored) & scope::side(below);
        // known to the compiler where this build has one lobe, or one side, only
        let mirrored = scope::REFLECTION && (mirrored || !scope::TRANSMISSION);
        let below = scope::DIELECTRIC && (below || !scope::AIR);
        let n = eta.get();
        let r = if below { eta.inverse() } else { n };
        // From the air's direction to the dielectric's, whichever comes first: h = a + n b. In reflection
        // the common index is left out.
        let weight = choose(mirrored, || T::ONE, || n);
        let swap = |i: T, o: T| if below { (o, i) } else { (i, o) };
        let ((ax, bx), (ay, by), (az, bz)) = (swap(ix, ox), swap(iy, oy), swap(iz, oz));
        let (hx, hy, hz) = (ax + weight * bx, ay + weight * by, az + weight * bz);
        let (xy2, z2) = (hx * hx + hy * hy, hz * hz);
        let hh = xy2 + z2;
        let eta2 = r * r;

        // Reflection. For unit vectors wi.h = |h|^2 / 2: a sum of squares, symmetric in wi and wo.
        // Total reflection is no case of its own: with g = 0 neither |rs| nor |rp| is below 1.
        let half = T::HALF * hh;
        let step = (r - T::ONE) * (r + T::ONE);

        // Transmission. Seen from the front by both: (w.m)(w.n) > 0, where m = h times the sign of h_z.
        let i_h = ix * hx + iy * hy + iz * hz;
        let o_h = ox * hx + oy * hy + oz * hz;
        let front = sign_i * T::ONE.copysign(hz);
        let seen = || (front * i_h).min(-front * o_h).min(hz.abs());

        // The Fresnel factors of `crate::fresnel` from cosines that carry the factor |h|: rs and rp of F;
        // for 1 - F the same places hold c / s and c / p.
        let c = choose(mirrored, || half, || i_h.abs());
        let g = choose(mirrored, || (step * hh + half * half).sqrt_positive(), || r * o_h.abs());
        let s = c + g;
        let p = eta2 * c + g;
        let first = choose(mirrored, || step * hh, || c) / choose(mirrored, || s * s, || s);
        let second =
            choose(mirrored, || step * (c * s - hh), || c) / choose(mirrored, || s * p, || p);
        let reflected = || (T::HALF * (first * first + second * second)).min(T::ONE);
        let transmitted = || T::TWO * (first * (g / s) + eta2 * second * (g / p));

        // All of these are positive if there is a facet; the last term makes NaN of any NaN.
        let least = choose(mirrored, || hh, seen).min(iz.abs()).min(oz.abs()) + T::ZERO * hh;
        Self {
            possible: (least > T::ZERO) & !eta.is_matched() & answered,
            xy2,
            z2,
            ih: c,
            along: (ix * hx + iy * hy) * T::ONE.copysign(hz),
            turn: choose(mirrored, || T::from_f64(0.25), || (n * c / hh) * (g / hh)),
            share: choose(
                mirrored,
                || reflected() * T::from_f64(0.25),
                || transmitted() * (n * c / hh) * (g / hh),
            ),
        }
    }
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
