//! The power-on self test: every evaluator on seeded input, summed up in one checksum a section.
//!
//! A workstation and a microcontroller must agree in every bit, in debug and release; what an
//! instrument computes is then what the laboratory can recompute. A section that disagrees says where to
//! look, and the first one is the place to start.
//! Double precision is software on a Cortex-M4F, some fifty times slower, so its sections are small.

use asperity_core::bsdf::{
    AllBounces, COMPENSATION_NUMBERS, Compensation, Ggx, Normals, OpaqueGgx, Smooth, Walk,
};
use asperity_core::direction::Direction;
use asperity_core::gonio::{AngleGrid, Geometry, Goniophotometer, Scan};
use asperity_core::math::{Fast, Real};
use asperity_core::metric::rmsd_percent;
use asperity_core::ndf::ggx_facets::GgxFacets;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::plate::{Plate, RoughSide};
use asperity_core::quantity::Alpha;

use crate::digest::Digest;
use crate::seeded::{Source, ior, law, ray};
use crate::{hostile, selftest_laws};

/// The number of sections.
pub const COUNT: usize = 22;

/// A name and the function that computes the checksum.
pub type Section = (&'static str, fn() -> u64);

/// The sections, in the order in which they build upon one another.
pub const SECTIONS: [Section; COUNT] = [
    ("math-f32", || functions::<f32>(500)),
    ("math-f64", || functions::<f64>(60)),
    ("smooth-f32", || smooth::<f32>(500)),
    ("ggx-f32", || ggx::<f32>(400)),
    ("ggx-f64", || ggx::<f64>(60)),
    ("opaque-f32", || opaque::<f32>(400)),
    ("normals-f32", || normals::<f32>(300)),
    ("plate-f32", || plate::<f32>(300)),
    ("scan-f32", || scan::<f32>(2000)),
    ("scan-f64", || scan::<f64>(200)),
    ("math-fast-f32", || functions::<Fast<f32>>(2000)),
    ("ggx-fast-f32", || ggx::<Fast<f32>>(3000)),
    ("normals-fast-f32", || normals::<Fast<f32>>(300)),
    ("microfacets-f32", || selftest_laws::microfacets::<f32>(50)),
    ("about-specular-f32", || selftest_laws::about_specular::<f32>(32)),
    ("about-specular-f64", || selftest_laws::about_specular::<f64>(16)),
    ("hostile-f32", || hostile::closed_forms::<f32>(100_000).digest.finish()),
    ("hostile-fast-f32", || hostile::closed_forms::<Fast<f32>>(200_000).digest.finish()),
    ("bounces-f32", || bounces::<f32>(150)),
    ("bounces-fast-f32", || bounces::<Fast<f32>>(300)),
    ("walk-f32", || walk::<f32>(60)),
    ("hostile-f64", || hostile::closed_forms::<f64>(1000).digest.finish()),
];

/// The checksum of every section.
pub fn sections() -> [(&'static str, u64); COUNT] {
    SECTIONS.map(|(name, run)| (name, run()))
}

/// The checksum of all sections.
pub fn digest() -> u64 {
    combine(&sections())
}

/// The checksum of checksums already computed.
pub fn combine(sections: &[(&str, u64)]) -> u64 {
    let mut all = Digest::new();
    for &(_, section) in sections {
        all.word(section);
    }
    all.finish()
}

fn rough<T: Real>(alpha: f64) -> Option<Ggx<T>> {
    Some(Ggx::new(Alpha::new(T::from_f64(alpha)).ok()?, ior()?))
}

fn facets<T: Real, const N: usize>(profile: Profile, n: f64) -> Option<Normals<T, N>> {
    let law = Law::new(profile, T::from_f64(0.15), T::from_f64(n), T::ZERO).ok()?;
    Some(Normals::new(NormalDensity::new(law), ior()?))
}

/// The elementary functions on seeded arguments of either sign.
fn functions<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(1));
    for _ in 0..count {
        let (u, v): (T, T) = (source.uniform(), source.uniform());
        let x = (u - T::HALF) * T::from_f64(40.0);
        let (s, c) = x.sin_cos();
        d.reals(&[s, c, x.tan(), x.exp(), x.cbrt(), x.floor(), x.atan2(v)]);
        d.reals(&[u.sqrt(), u.ln(), u.asin(), u.acos(), u.pow(x)]);
    }
    d.finish()
}

/// Fresnel factors, Snell's law and rays of the smooth face.
fn smooth<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(2));
    if let Some(eta) = ior::<T>() {
        let face = Smooth { eta };
        for k in 0..count {
            let wi = source.direction(k);
            let f = face.fresnel(wi);
            d.reals(&[f.reflected, f.transmitted]);
            d.direction(Some(face.reflect(wi)));
            d.direction(face.refract(wi));
            ray(&face, wi, &mut source, &mut d);
        }
    }
    d.finish()
}

fn ggx<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(3));
    for alpha in [0.01, 0.3, 1.5] {
        law(rough::<T>(alpha), count / 3, &mut source, &mut d);
    }
    d.finish()
}

/// All bounces, with shares of later ones that any surface might have.
fn bounces<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(8));
    let later = Compensation::from_numbers(&[T::from_f64(0.1); COMPENSATION_NUMBERS]);
    for alpha in [0.01, 0.3, 1.5] {
        let whole = rough::<T>(alpha).zip(later.as_ref());
        let whole = whole.map(|(single, later)| AllBounces { single, later: *later });
        law(whole, count / 3, &mut source, &mut d);
    }
    d.finish()
}

/// The walk from facet to facet.
fn walk<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(9));
    for alpha in [0.3, 1.5] {
        let Some(single) = rough::<T>(alpha) else { continue };
        let walk = Walk::new(GgxFacets::new(single.alpha), single.eta);
        for k in 0..count / 2 {
            let wi = source.direction(k);
            ray(&walk, wi, &mut source, &mut d);
        }
    }
    d.finish()
}

fn opaque<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(4));
    let alpha = Alpha::new(T::from_f64(0.25)).ok();
    let metal = alpha.and_then(|a| OpaqueGgx::new(a, T::from_f64(0.8), T::from_f64(0.05)));
    law(metal, count, &mut source, &mut d);
    d.finish()
}

fn normals<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(5));
    law(facets::<T, 64>(Profile::Gauss, 2.0), count / 2, &mut source, &mut d);
    law(facets::<T, 64>(Profile::Cauchy, 2.5), count / 2, &mut source, &mut d);
    d.finish()
}

/// Rays through the plate, both ways round, every exit counted.
fn plate<T: Real>(rays: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(6));
    if let (Some(rough), Some(eta)) = (rough::<T>(0.5), ior::<T>()) {
        for side in [RoughSide::Source, RoughSide::Detector] {
            let plate = Plate::new(rough, eta, side);
            for k in 0..rays / 2 {
                let w: Direction<T> = source.direction(k);
                let wi = Direction::from_unit(w.x(), w.y(), w.z().abs());
                let out = plate.trace(wi, &mut || source.uniform(), &mut |wo, flux| {
                    d.direction(Some(wo));
                    d.real(flux);
                });
                d.reals(&[out.reflected, out.transmitted, out.lost]);
            }
        }
    }
    d.finish()
}

/// Two Monte Carlo scans of 181 angles, and the error of one against the other.
fn scan<T: Real>(rays: u32) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(7));
    if let (Some(rough), Some(eta)) = (rough::<T>(0.2), ior::<T>()) {
        let grid = AngleGrid { start_deg: T::from_f64(-90.0), step_deg: T::ONE, count: 181 };
        let plate = Plate::new(rough, eta, RoughSide::Source);
        let mut measure = |geometry| -> Scan<T, 181> {
            let aperture_deg = T::from_f64(3.0);
            let instrument = Goniophotometer { aperture_deg, geometry };
            instrument.scan(&plate, T::from_f64(30.0), grid, rays, &mut source.0)
        };
        let (through, back) = (measure(Geometry::Transmission), measure(Geometry::Reflection));
        d.reals(through.readings());
        d.reals(back.readings());
        d.real(rmsd_percent(through.readings(), back.readings()).unwrap_or(T::ZERO));
    }
    d.finish()
}

#[cfg(test)]
mod tests {
    use super::{Profile, Source, combine, facets, ior, rough, scan, sections};

    #[test]
    fn all_quantities_exist() {
        assert!(
            ior::<f32>().is_some() && rough::<f32>(0.01).is_some() && rough::<f64>(1.5).is_some()
        );
        assert!(facets::<f32, 64>(Profile::Gauss, 2.0).is_some());
        assert!(facets::<f32, 64>(Profile::Cauchy, 2.5).is_some());
    }

    #[test]
    fn sections_differ_from_one_another_and_repeat() {
        let first = sections();
        assert_eq!(first, sections());
        for (i, a) in first.iter().enumerate() {
            assert!(first.iter().skip(i + 1).all(|b| a.1 != b.1 && a.0 != b.0), "{}", a.0);
        }
        let mut other = first;
        other[3].1 ^= 1;
        assert_ne!(combine(&first), combine(&other));
    }

    #[test]
    fn a_scan_that_sees_no_light_would_be_no_test() {
        assert_ne!(scan::<f32>(0), scan::<f32>(200));
    }

    #[test]
    fn directions_cover_both_sides_and_the_tangent_plane() {
        let mut source = Source::new(0);
        let z = core::array::from_fn::<f32, 64, _>(|k| source.direction::<f32>(k).z());
        assert!(z.iter().any(|&z| z > 0.5) && z.iter().any(|&z| z < -0.5));
        assert!(z.iter().filter(|z| z.abs() < 1e-3).count() >= 8);
    }
}
