//! A table made by `asperity tabulate`, in arrays of the caller.

use core::ffi::c_void;

use super::pointer::{self, AsperityUniform};
use super::source::{AsperityTable, AsperityTableSource};
use crate::law::AsperityRay;
use crate::options;
use crate::options::AsperityQuantity as Quantity;
use crate::status::AsperityStatus;

#[inline(always)]
unsafe fn init(
    table: *mut AsperityTable,
    source: Result<&AsperityTableSource, AsperityStatus>,
    tier: u32,
    trusted: bool,
) -> AsperityStatus {
    if let Err(e) = pointer::check(table) {
        return e;
    }
    // SAFETY: the promise of `abi`; the storage has been checked
    unsafe {
        // no closure: it would be one function for trusted and other tables
        let done = match source {
            Ok(source) => source.init(table, tier, trusted),
            Err(e) => Err(e),
        };
        match done {
            Ok(()) => AsperityStatus::Ok,
            Err(e) => pointer::store(table, Err(e)),
        }
    }
}

/// Checks the arrays of `source`, and their checksum, and views them: they must outlive the object and its copies. `tier` is an
/// `asperity_tier`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_init(
    table: *mut AsperityTable,
    source: *const AsperityTableSource,
    tier: u32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { init(table, pointer::refer(source), tier, false) }
}

/// The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_eval(
    table: *const AsperityTable,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(table, Quantity::Eval, wi, wo, out) }
}

/// Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_ars(
    table: *const AsperityTable,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(table, Quantity::Ars, wi, wo, out) }
}

/// Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_pdf(
    table: *const AsperityTable,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::value(table, Quantity::Pdf, wi, wo, out) }
}

/// Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_sample(
    table: *const AsperityTable,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    ray: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(table, 1, wi, uniform, state, ray) }
}

/// An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
/// direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
/// first; the others are computed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_batch(
    table: *const AsperityTable,
    quantity: u32,
    count: usize,
    wi: *const f32,
    wi_stride: usize,
    wo: *const f32,
    wo_stride: usize,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::values(table, quantity, count, (wi, wi_stride), (wo, wo_stride), out) }
}

/// Draws `count` rays for light from one `wi`, to `count` rays in a row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_sample_batch(
    table: *const AsperityTable,
    count: usize,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    rays: *mut AsperityRay,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { pointer::rays(table, count, wi, uniform, state, rays) }
}

/// The same without a look at the numbers in the arrays and at the checksum, for a table that `asperity_table_init` has taken elsewhere, such as
/// in the tests of a firmware: it spares flash and start-up time. Lengths are checked; other numbers than those that
/// were taken give wrong values, and nothing worse.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_init_trusted(
    table: *mut AsperityTable,
    source: *const AsperityTableSource,
    tier: u32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { init(table, pointer::refer(source), tier, true) }
}

/// The same of a payload: what follows the first line of a `.bsdft` file. Of `source` the arrays and their lengths are
/// not looked at. The payload, and each array in it, must be aligned to its numbers (8-bit values may be followed by a
/// misaligned array: `ASPERITY_STATUS_MISALIGNED`; then give copies to `asperity_table_init`). For little-endian
/// machines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_init_payload(
    table: *mut AsperityTable,
    source: *const AsperityTableSource,
    payload: *const c_void,
    bytes: usize,
    tier: u32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe {
        let source = pointer::refer(source).and_then(|s| s.over(payload.cast(), bytes));
        init(table, source.as_ref().map_err(|e| *e), tier, false)
    }
}

/// 1 for the table of an opaque body, which has no index and no inside; 0 for that of a dielectric.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_is_opaque(
    table: *const AsperityTable,
    out: *mut u32,
) -> AsperityStatus {
    let run = || {
        // SAFETY: the promise of `abi`
        let table = unsafe { pointer::stored(table) }?;
        // SAFETY: as above
        unsafe { pointer::write(out, u32::from(table.is_opaque())) }
    };
    run().err().unwrap_or(AsperityStatus::Ok)
}

/// Diffusely reflected fraction of the flux at a cosine of incidence, from an `asperity_side`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_reflectance(
    table: *const AsperityTable,
    cosine: f32,
    side: u32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { flux(table, cosine, side, out, |[reflected, _]| reflected) }
}

/// Diffusely transmitted fraction of the flux.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn asperity_table_transmittance(
    table: *const AsperityTable,
    cosine: f32,
    side: u32,
    out: *mut f32,
) -> AsperityStatus {
    // SAFETY: the promise of `abi`
    unsafe { flux(table, cosine, side, out, |[_, transmitted]| transmitted) }
}

unsafe fn flux(
    table: *const AsperityTable,
    cosine: f32,
    side: u32,
    out: *mut f32,
    which: fn([f32; 2]) -> f32,
) -> AsperityStatus {
    let run = || {
        // SAFETY: the promise of `abi`
        let table = unsafe { pointer::stored(table) }?;
        let value = table.fluxes(cosine, options::side(side)?).map(which)?;
        // SAFETY: as above
        unsafe { pointer::write(out, value) }
    };
    run().err().unwrap_or(AsperityStatus::Ok)
}
