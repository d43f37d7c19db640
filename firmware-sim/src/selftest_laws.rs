//! Sections of the self test for microfacets of a free density and for scatter about the specular direction.

use asperity_core::bsdf::tail::Shape;
use asperity_core::bsdf::{Lobe, Masking, Microfacet, ShiftInvariant};
use asperity_core::math::Real;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::density::Density;
use asperity_core::ndf::stretched::Stretched;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::{Alpha, RelativeIor};

use crate::digest::Digest;
use crate::seeded::{Source, ior, law};

fn width<T: Real>(x: f64) -> Option<Alpha<T>> {
    Alpha::new(T::from_f64(x)).ok()
}

fn facets<T: Real, D: Density<T>>(
    density: Option<D>,
    masking: Masking,
) -> Option<Microfacet<T, D>> {
    Some(Microfacet::new(density?, ior()?).with_masking(masking))
}

/// Beckmann and Student with both maskings, and Student with two widths.
pub(crate) fn microfacets<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(8));
    let student = || Student::new(width(0.3)?, T::from_f64(3.0)).ok();
    for masking in [Masking::Separable, Masking::Correlated] {
        let beckmann = width(0.4).map(Beckmann::new);
        law(facets::<T, _>(beckmann, masking), count / 5, &mut source, &mut d);
        law(facets::<T, _>(student(), masking), count / 5, &mut source, &mut d);
    }
    let widths = width(0.2).zip(width(0.5)).map(|(x, y)| [x, y]);
    let brushed = widths
        .and_then(|widths| Stretched::student(widths, T::from_f64(3.0), T::from_f64(0.4)).ok());
    law(facets::<T, _>(brushed, Masking::Separable), count / 5, &mut source, &mut d);
    d.finish()
}

/// All shapes, of a sheet and of a face.
pub(crate) fn about_specular<T: Real>(count: usize) -> u64 {
    let (mut d, mut source) = (Digest::new(), Source::new(9));
    let number = T::from_f64;
    let shapes = [
        Shape::Abg { a: number(0.02), b: number(0.05), g: number(2.5) },
        Shape::Harvey { b0: number(0.5), l: number(0.1), s: number(-2.2), m: number(2.0) },
        Shape::SuperGauss { a: number(1.5), w: number(0.3), p: number(4.0) },
        Shape::k_correlation([number(0.001), number(6.0), number(2.5)], number(0.55), number(0.49)),
    ];
    for (k, shape) in shapes.into_iter().enumerate() {
        let lobe = if k % 2 == 0 { Lobe::Transmission } else { Lobe::Reflection };
        for eta in [ior::<T>(), RelativeIor::new(T::ONE).ok()] {
            let made = eta.and_then(|eta| ShiftInvariant::new(shape, lobe, eta, None).ok());
            law(made, count / 8, &mut source, &mut d);
        }
    }
    d.finish()
}
