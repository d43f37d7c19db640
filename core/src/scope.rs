//! The scope of this build: the features of cargo as constants, so that the compiler leaves out what is off.
//!
//! All but `slot` are on by default, and all only ever add. What is off scatters nothing: values, densities and fluxes of light
//! from a side, or into a lobe, that was left out are 0, and its rays are lost (`None`), as many as there would
//! be; what remains keeps its bits. Laws, precisions and tools that were left out cannot be named.
//!
//! | feature | without it |
//! |---|---|
//! | `air`, `dielectric` | light from that side scatters nothing |
//! | `reflection`, `transmission` | that lobe is empty |
//! | `ggx` | no [`bsdf::Ggx`](crate::bsdf), no `OpaqueGgx` |
//! | `normals` (needs `f64`) | no `bsdf::Normals`, no `ndf::law` and `ndf::normals`, no `quadrature` |
//! | `microfacet` (needs `normals`) | no `bsdf::Microfacet`, no densities of `ndf` for it, no `bsdf::Walk`; `bsdf::AllBounces` needs `ggx` too |
//! | `tails` (needs `f64`) | no `bsdf::ShiftInvariant` |
//! | `table` (needs `f32`) | no `table` |
//! | `checksum` (needs `table`) | no checksum of a table |
//! | `f32`, `f64` | that type is no [`Real`](crate::math::Real) |
//! | `fast` | no `math::Fast` |
//! | `slot` (not by default; needs `ggx`, `normals`, `table`) | no `slot` |
//! | `gonio` | no `plate`, `gonio` and `metric` |
//! | `protocol` | no `protocol`, and no dependency on postcard and serde; nor on crc without `checksum` |
//!
//! The smooth boundary, Fresnel's and Snell's laws know no lobes or sides to leave out.

#![cfg_attr(
    not(any(feature = "ggx", feature = "normals", feature = "table", feature = "tails")),
    allow(dead_code, reason = "without a law nobody asks")
)]

/// Light may come from the air.
pub(crate) const AIR: bool = cfg!(feature = "air");
/// Light may come from the dielectric.
pub(crate) const DIELECTRIC: bool = cfg!(feature = "dielectric");
/// Light may go back to its side.
pub(crate) const REFLECTION: bool = cfg!(feature = "reflection");
/// Light may go through.
pub(crate) const TRANSMISSION: bool = cfg!(feature = "transmission");

/// Whether this build includes light from a side, `below` or above.
#[inline(always)]
pub(crate) const fn side(below: bool) -> bool {
    (AIR && !below) || (DIELECTRIC && below)
}

/// Whether this build includes a lobe, `mirrored` or not.
#[inline(always)]
pub(crate) const fn lobe(mirrored: bool) -> bool {
    (REFLECTION && mirrored) || (TRANSMISSION && !mirrored)
}
