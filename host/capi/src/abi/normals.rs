//! A rough dielectric whose facets are drawn from a law of angles.

use core::ffi::c_void;
use core::mem::MaybeUninit;

use super::pointer::{self, AsperityUniform, Storage};
use crate::law::{AsperityRay, NormalsLaw};
use crate::options::AsperityQuantity as Quantity;
use crate::status::AsperityStatus;

/// A rough dielectric whose facets are drawn from a law of angles. Opaque: only functions of this library look inside; it may be copied.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AsperityNormals {
    /// Room for it.
    opaque: [MaybeUninit<u32>; 512],
}

impl AsperityNormals {
    /// Storage without an object in it.
    pub const EMPTY: Self = Self { opaque: [MaybeUninit::new(0); 512] };
}

impl Storage for AsperityNormals {
    type Law = NormalsLaw;
    const MARK: u32 = 0x4e4f_5231;
}

/// `profile` is an `asperity_profile` of width `delta` (1e-6 to 10, radians), exponent `n` (0.1 to 100) and centre
/// `theta0` (0 to pi/2); `eta` is the index of the dielectric over that of air, 0.1 to 10; `tier` an `asperity_tier`.
/// Integrates in double precision, with a few KiB of stack.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_init(
    normals: *mut AsperityNormals,
    profile: u32,
    delta: f32,
    n: f32,
    theta0: f32,
    eta: f32,
    tier: u32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::store(normals, NormalsLaw::new(profile, [delta, n, theta0], eta, tier)) }
}

/// The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_eval(
    normals: *const AsperityNormals,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(normals, Quantity::Eval, wi, wo, out) }
}

/// Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_ars(
    normals: *const AsperityNormals,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(normals, Quantity::Ars, wi, wo, out) }
}

/// Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_pdf(
    normals: *const AsperityNormals,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(normals, Quantity::Pdf, wi, wo, out) }
}

/// Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_sample(
    normals: *const AsperityNormals,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    ray: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(normals, 1, wi, uniform, state, ray) }
}

/// An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
/// direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
/// first; the others are computed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_batch(
    normals: *const AsperityNormals,
    quantity: u32,
    count: usize,
    wi: *const f32,
    wi_stride: usize,
    wo: *const f32,
    wo_stride: usize,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::values(normals, quantity, count, (wi, wi_stride), (wo, wo_stride), out) }
}

/// Draws `count` rays for light from one `wi`, to `count` rays in a row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_normals_sample_batch(
    normals: *const AsperityNormals,
    count: usize,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    rays: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(normals, count, wi, uniform, state, rays) }
}
