//! Laws from one precision to another.

use super::{Bsdf, Ggx, Normals, OpaqueGgx, Smooth};
use crate::direction::Direction;
use crate::math::{Fast, Real};
use crate::ndf::law::{Law, Profile};
use crate::ndf::normals::NormalDensity;
use crate::quantity::{Alpha, RelativeIor};

fn eta() -> RelativeIor<f64> {
    RelativeIor::new(1.49).unwrap()
}

fn law(profile: Profile, centre: f64) -> Law<f64> {
    Law::new(profile, 0.21, 2.3, centre).unwrap()
}

fn directions<T: Real>(k: u32) -> (Direction<T>, Direction<T>) {
    let x = f64::from(k);
    let turned = |w: Direction<f64>, down: bool| {
        let [x, y, z] = w.xyz().map(T::from_f64);
        Direction::from_unit(x, y, if down { -z } else { z })
    };
    let wi = Direction::from_angles(0.021 * x, 0.7 * x);
    let wo = Direction::from_angles((0.033 * x) % 1.4, 0.7 * x + 2.9);
    (turned(wi, k.is_multiple_of(2)), turned(wo, k.is_multiple_of(3)))
}

/// A law and what it is cast to agree but for the rounding of the narrower.
fn agree<T: Real, U: Real>(law: &impl Bsdf<T>, cast: &impl Bsdf<U>) {
    let mut lit = 0;
    for k in 0..60 {
        let ((i, o), (ci, co)) = (directions::<T>(k), directions::<U>(k));
        let (a, b) = (law.ars(i, o).to_f64(), cast.ars(ci, co).to_f64());
        assert!((a - b).abs() <= 3e-4 * a + 1e-9, "{k}: {a} {b}");
        lit += u32::from(a > 1e-6);
    }
    assert!(lit > 5);
}

#[test]
fn every_law_keeps_its_values_in_another_precision() {
    let alpha = Alpha::new(0.3).unwrap();
    let ggx = Ggx::new(alpha, eta());
    agree(&ggx, &ggx.cast::<f32>());
    agree(&ggx, &ggx.cast::<Fast<f32>>());
    agree(&ggx.cast::<f32>(), &ggx.cast::<f32>().cast::<f64>());
    let opaque = OpaqueGgx::new(alpha, 0.7, 0.05).unwrap();
    agree(&opaque, &opaque.cast::<f32>());
    agree(&opaque.cast::<f32>(), &opaque.cast::<f32>().cast::<f64>());
    for law in [law(Profile::Gauss, 0.0), law(Profile::Cauchy, 0.1)] {
        let normals: Normals<f64, 64> = Normals::new(NormalDensity::new(law), eta());
        agree(&normals, &normals.cast::<f32>());
        agree(&normals.cast::<f32>(), &normals.cast::<f32>().cast::<f64>());
    }
    let up = Direction::normal();
    let smooth = Smooth { eta: eta() };
    let (wide, narrow) = (smooth.fresnel(up), smooth.cast::<f32>().fresnel(Direction::normal()));
    assert!((wide.reflected - f64::from(narrow.reflected)).abs() < 1e-8);
}

#[test]
fn parameters_are_rounded_once_and_stay_in_their_domains() {
    assert_eq!(Alpha::new(0.3_f64).unwrap().cast::<f32>().get().to_bits(), 0.3_f32.to_bits());
    assert_eq!(
        Alpha::new(0.3_f32).unwrap().cast::<f64>().get().to_bits(),
        f64::from(0.3_f32).to_bits()
    );
    // the nearest single-precision number to an end may lie outside of the double-precision domain
    for end in [Alpha::<f64>::LEAST, Alpha::<f64>::MOST] {
        let narrow = Alpha::new(end).unwrap().cast::<f32>();
        assert!(Alpha::new(narrow.get()).is_ok() && Alpha::new(narrow.cast::<f64>().get()).is_ok());
    }
    for (delta, n, centre) in [(1e-6, 0.1, 0.0), (10.0, 100.0, core::f64::consts::FRAC_PI_2)] {
        let law = Law::new(Profile::Gauss, delta, n, centre).unwrap();
        let narrow = law.cast::<f32>();
        assert!(Law::new(Profile::Gauss, narrow.delta(), narrow.n(), narrow.centre()).is_ok());
        let wide = narrow.cast::<f64>();
        assert!(Law::new(Profile::Gauss, wide.delta(), wide.n(), wide.centre()).is_ok());
        assert_eq!(wide.profile(), Profile::Gauss);
    }
    let huge = OpaqueGgx::new(Alpha::new(0.3).unwrap(), 1e300, 0.0).unwrap();
    assert!(huge.cast::<f32>().gain.is_finite());
}
