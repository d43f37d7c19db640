//! A rough dielectric of GGX facets.

use core::ffi::c_void;
use core::mem::MaybeUninit;

use super::pointer::{self, AsperityUniform, Storage};
use crate::law::{AsperityRay, GgxLaw};
use crate::options::AsperityQuantity as Quantity;
use crate::status::AsperityStatus;

/// A rough dielectric of GGX facets. Opaque: only functions of this library look inside; it may be copied.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AsperityGgx {
    /// Room for it.
    opaque: [MaybeUninit<u32>; 16],
}

impl AsperityGgx {
    /// Storage without an object in it.
    pub const EMPTY: Self = Self { opaque: [MaybeUninit::new(0); 16] };
}

impl Storage for AsperityGgx {
    type Law = GgxLaw;
    const MARK: u32 = 0x4747_5831;
}

/// `alpha` is the width of the slopes, 1e-6 to 100; `eta` the index of the dielectric over that of air, 0.1 to 10;
/// `tier` an `asperity_tier`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_init(
    ggx: *mut AsperityGgx,
    alpha: f32,
    eta: f32,
    tier: u32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::store(ggx, GgxLaw::new(alpha, eta, tier)) }
}

/// The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_eval(
    ggx: *const AsperityGgx,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(ggx, Quantity::Eval, wi, wo, out) }
}

/// Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_ars(
    ggx: *const AsperityGgx,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(ggx, Quantity::Ars, wi, wo, out) }
}

/// Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_pdf(
    ggx: *const AsperityGgx,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(ggx, Quantity::Pdf, wi, wo, out) }
}

/// Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_sample(
    ggx: *const AsperityGgx,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    ray: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(ggx, 1, wi, uniform, state, ray) }
}

/// An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
/// direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
/// first; the others are computed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_batch(
    ggx: *const AsperityGgx,
    quantity: u32,
    count: usize,
    wi: *const f32,
    wi_stride: usize,
    wo: *const f32,
    wo_stride: usize,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::values(ggx, quantity, count, (wi, wi_stride), (wo, wo_stride), out) }
}

/// Draws `count` rays for light from one `wi`, to `count` rays in a row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_ggx_sample_batch(
    ggx: *const AsperityGgx,
    count: usize,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    rays: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(ggx, count, wi, uniform, state, rays) }
}
